// The material of a surface, and where it has holes.

#import common/alpha_mask

struct Material {
    base_color: vec4f,
    emissive: vec3f,
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    // Holes are where alpha is below; negative when there are none.
    alpha_cutoff: f32,
    // How the alpha of the base colour is read where it is a mask: see common/alpha_mask.
    mask_reading: u32,
    // One bit for each texture: whether it lies on the second texture coordinates.
    uv_sets: u32,
    // `KHR_materials_transmission`: the fraction of light that passes.
    transmission: f32,
    // 1 where alpha blends over what is behind.
    blends: u32,
    // Two rows for each texture: uv' = (dot(row0, (u, v, 1)), dot(row1, (u, v, 1))).
    uv_rows: array<vec4f, 10>,
}

@group(2) @binding(0) var<uniform> material: Material;
@group(2) @binding(1) var base_color_texture: texture_2d<f32>;

// Both texture coordinates of a vertex, where a material uses the second.
#if SECOND_UV
alias Uvs = vec4f;
#else
alias Uvs = vec2f;
#endif

// The texture coordinates of texture number `texture`, in the order of the bindings.
fn uv_of(texture: u32, uvs: Uvs) -> vec2f {
#if SECOND_UV
    let uv1 = vec3f(select(uvs.xy, uvs.zw, ((material.uv_sets >> texture) & 1u) == 1u), 1.0);
#else
    let uv1 = vec3f(uvs, 1.0);
#endif
    return vec2f(dot(material.uv_rows[texture * 2u].xyz, uv1), dot(material.uv_rows[texture * 2u + 1u].xyz, uv1));
}

// The alpha of the base colour where the vertex colour has this alpha, of its texture's full size.
fn full_alpha(uvs: Uvs, vertex_alpha: f32) -> f32 {
    var alpha = material.base_color.a * vertex_alpha;
#if BASE_COLOR_TEXTURE
    alpha *= mask_alpha(base_color_texture, uv_of(0u, uvs), material.mask_reading);
#endif
    return alpha;
}

// Whether a transparent surface is there: alpha 0 is none where alpha blends, and a mask has holes below its cutoff.
fn is_there(uvs: Uvs, vertex_alpha: f32) -> bool {
    let alpha = full_alpha(uvs, vertex_alpha);
    return select(alpha >= material.alpha_cutoff, alpha > 0.0, material.blends == 1u);
}

// Whether the surface is not there, where the vertex colour has this alpha.
fn has_hole(uvs: Uvs, vertex_alpha: f32) -> bool {
    return full_alpha(uvs, vertex_alpha) < material.alpha_cutoff;
}
