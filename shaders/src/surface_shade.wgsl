// Forward shading of the visible surface: every light of the frame in one pass, each with its shadow factor.
// Flags leave out what a material does not have, and the loop for one light: software adapters run both sides of
// every branch, and loops with a mask.
// With SURFACE_FUNCTION a material's own text follows, which defines `reflected` and `outgoing`.

#import common/frame
#import common/lights
#import common/light_tiles
#import common/material
#import common/surface
#import common/tone

@group(2) @binding(2) var metallic_roughness_texture: texture_2d<f32>;
@group(2) @binding(3) var emissive_texture: texture_2d<f32>;
@group(2) @binding(4) var normal_texture: texture_2d<f32>;
@group(2) @binding(5) var occlusion_texture: texture_2d<f32>;
@group(2) @binding(6) var base_color_sampler: sampler;
@group(2) @binding(7) var metallic_roughness_sampler: sampler;
@group(2) @binding(8) var emissive_sampler: sampler;
@group(2) @binding(9) var normal_sampler: sampler;
@group(2) @binding(10) var occlusion_sampler: sampler;

#if MULTISAMPLED
#if COUNTS
@group(1) @binding(0) var counts: texture_multisampled_2d<u32>;
#endif
#if MASK
@group(1) @binding(1) var mask: texture_multisampled_2d<f32>;
#endif
// The visible depth of every sample.
@group(1) @binding(3) var depths: texture_depth_multisampled_2d;
#else
#if COUNTS
@group(1) @binding(0) var counts: texture_2d<u32>;
#endif
#if MASK
@group(1) @binding(1) var mask: texture_2d_array<f32>;
#endif
#endif
#if VISIBILITY
@group(1) @binding(2) var visibility: texture_2d_array<f32>;
#endif

#if FARTHER
// The nearest transparent surface at every pixel: only what is behind it is drawn.
@group(1) @binding(9) var nearest_depth: texture_depth_2d;
#endif

#if TINTED
// What the picture loses of a light where a factor is 0. Entry i is for light i; the next factor of the same light is
// entry `next`, with where it is, until `next` is 0.
struct TintedFactor {
    max_darkening: vec3f,
    next: u32,
    kind: u32,
    index: u32,
    pad_0: u32,
    pad_1: u32,
}
@group(1) @binding(7) var<storage, read> tints: array<TintedFactor>;
#endif

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) p_in_view: vec3f,
    @location(1) normal_in_view: vec3f,
    @location(2) @interpolate(flat, first) receives: u32,
    @location(3) uvs: Uvs,
#if VERTEX_COLOR
    @location(4) color: vec4f,
#endif
#if SMOOTH_TERMINATOR
    @location(5) @interpolate(flat, first) smooth_terminators: u32,
#endif
}

@vertex
fn vertex(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
#if SECOND_UV
    @location(4) second_uv: vec2f,
#endif
    @builtin(instance_index) instance: u32,
) -> Varyings {
    let i = instances[instance];
    let n = vec3f(dot(i.normal_x.xyz, normal), dot(i.normal_y.xyz, normal), dot(i.normal_z.xyz, normal));
    var out: Varyings;
    out.clip = clip_from_local(instance, position);
    out.p_in_view = view_from_local(instance, position);
    out.normal_in_view = n;
    out.receives = i.flags & 1u;
#if SECOND_UV
    out.uvs = vec4f(uv, second_uv);
#else
    out.uvs = uv;
#endif
#if VERTEX_COLOR
    out.color = color;
#endif
#if SMOOTH_TERMINATOR
    out.smooth_terminators = i.smooth_terminators;
#endif
    return out;
}

fn base_color(in: Varyings) -> vec4f {
    var color = material.base_color;
#if VERTEX_COLOR
    color *= in.color;
#endif
#if BASE_COLOR_TEXTURE
    color *= textureSample(base_color_texture, base_color_sampler, uv_of(0u, in.uvs));
#endif
    return color;
}

// How much of a surface is there where it is at all.
fn covered_share(alpha: f32) -> f32 {
    return select(1.0, saturate(alpha), material.blends == 1u);
}

fn is_hole(in: Varyings) -> bool {
#if VERTEX_COLOR
    return has_hole(in.uvs, in.color.a);
#else
    return has_hole(in.uvs, 1.0);
#endif
}

#if MULTISAMPLED
// For each of the pixel's samples, its share in this fragment's factor. Set by the entry point.
var<private> sample_shares: vec4f;

// Only the samples that show this fragment's own surface have a share: those it covers, and whose depth is the one
// its plane has there; elsewhere something nearer is seen, with shadows of its own.
fn shares_of_samples(clip: vec4f, covered: u32) -> vec4f {
    // The standard places of four samples, from the pixel's middle.
    let x = vec4f(-0.125, 0.375, -0.375, 0.125);
    let y = vec4f(-0.375, -0.125, 0.125, 0.375);
    let slope = vec2f(dpdx(clip.z), dpdy(clip.z));
    let expected = clip.z + slope.x * x + slope.y * y;
    let pixel = vec2u(clip.xy);
    let visible = vec4f(
        textureLoad(depths, pixel, 0), textureLoad(depths, pixel, 1),
        textureLoad(depths, pixel, 2), textureLoad(depths, pixel, 3),
    );
    // Rounding of a depth and of its slopes: some hundred units in the last place. Two surfaces nearer to one another
    // than that touch, and share their shadow.
    let rounding = 1.5e-5 * clip.z + (abs(slope.x) + abs(slope.y)) / 64.0;
    let own = step(abs(visible - expected), vec4f(rounding));
    let inside = vec4f((vec4u(covered) >> vec4u(0u, 1u, 2u, 3u)) & vec4u(1u));
    var shares = own * inside;
    if dot(shares, vec4f(1.0)) == 0.0 {
        shares = select(vec4f(1.0), inside, covered != 0u);
    }
    return shares / dot(shares, vec4f(1.0));
}

// The mean factor of samples that are dark where `dark` is not 0.
fn mean_factor(dark: vec4u) -> vec3f {
    return vec3f(dot(sample_shares, select(vec4f(1.0), vec4f(0.0), dark != vec4u(0u))));
}
#endif

// The factor that is where `kind` and `index` say: see common/lights. Of a single one the flags say where it is.
fn factor_at(kind: u32, index: u32, pixel: vec2u) -> vec3f {
#if COUNTS
#if ONE_FACTOR
#else
    if kind == 1u
#endif
    {
#if MULTISAMPLED
        let counted = vec4u(
            textureLoad(counts, pixel, 0).x, textureLoad(counts, pixel, 1).x,
            textureLoad(counts, pixel, 2).x, textureLoad(counts, pixel, 3).x,
        );
        return mean_factor(vec4u(counted > vec4u(AT_REST)));
#else
        return select(vec3f(1.0), vec3f(0.0), textureLoad(counts, pixel, 0).x > AT_REST);
#endif
    }
#endif
#if MASK
#if ONE_FACTOR
#else
    if kind == 2u
#endif
    {
        let channel = (index / 8u) % 4u;
#if MULTISAMPLED
        let bytes = vec4u(vec4f(
            textureLoad(mask, pixel, 0)[channel], textureLoad(mask, pixel, 1)[channel],
            textureLoad(mask, pixel, 2)[channel], textureLoad(mask, pixel, 3)[channel],
        ) * 255.0 + 0.5);
        return mean_factor((bytes >> vec4u(index % 8u)) & vec4u(1u));
#else
        let byte = u32(textureLoad(mask, pixel, index / 32u, 0)[channel] * 255.0 + 0.5);
        return select(vec3f(1.0), vec3f(0.0), (byte >> (index % 8u) & 1u) != 0u);
#endif
    }
#endif
#if VISIBILITY
#if ONE_FACTOR
#else
    if kind == 3u
#endif
    {
        // Read within the bounds wherever the pixel is: what is not read need not be fetched, nor cleared.
        let bounds = frame.shadowed_px;
        let within = clamp(pixel, bounds.xy, bounds.zw - 1u);
#if MULTISAMPLED
        // A texel for every sample.
        let first = 2u * within;
        let known = sample_shares.x * textureLoad(visibility, first, index, 0)
            + sample_shares.y * textureLoad(visibility, first + vec2u(1u, 0u), index, 0)
            + sample_shares.z * textureLoad(visibility, first + vec2u(0u, 1u), index, 0)
            + sample_shares.w * textureLoad(visibility, first + vec2u(1u, 1u), index, 0);
#else
        let known = textureLoad(visibility, within, index, 0);
#endif
        let factor = select(vec4f(1.0), known, all(pixel == within));
#if ONE_CHANNEL
        return factor.rrr;
#else
        return factor.rgb;
#endif
    }
#endif
    return vec3f(1.0);
}

// What fraction of `light`, number `number`, this pixel's surface is shown in: what passes all casters, and what
// shadows of less than full weight leave.
fn shadow_factor(light: Light, number: u32, pixel: vec2u) -> vec3f {
#if TINTED
    var tint = tints[number];
    var shown = 1.0 - tint.max_darkening * (1.0 - factor_at(tint.kind, tint.index, pixel));
    while tint.next != 0u {
        tint = tints[tint.next];
        shown *= 1.0 - tint.max_darkening * (1.0 - factor_at(tint.kind, tint.index, pixel));
    }
    return shown;
#else
    return factor_at(light.factor_kind, light.factor_index, pixel);
#endif
}

#if NORMAL_TEXTURE
// The normal of the tangent-space map in a frame made from screen-space derivatives of position and uv.
fn mapped_normal(n: vec3f, p: vec3f, uvs: Uvs) -> vec3f {
    let dp_dx = dpdx(p);
    let dp_dy = dpdy(p);
    let uv = uv_of(3u, uvs);
    let duv_dx = dpdx(uv);
    let duv_dy = dpdy(uv);
    let px = cross(dp_dy, n);
    let py = cross(n, dp_dx);
    let tangent = px * duv_dx.x + py * duv_dy.x;
    let bitangent = px * duv_dx.y + py * duv_dy.y;
    // Pixels run downwards, and a surface may be seen mirrored: the frame turns with them.
    let turn = sign(dot(dp_dx, px));
    let size = turn * inverseSqrt(max(max(dot(tangent, tangent), dot(bitangent, bitangent)), 1e-30));
    let texel = textureSample(normal_texture, normal_sampler, uv).xyz * 2.0 - 1.0;
    let scaled = vec3f(texel.xy * material.normal_scale, texel.z);
    return normalize(tangent * size * scaled.x - bitangent * size * scaled.y + n * scaled.z);
}
#endif

// Whether the terminator of light number `light` follows the shading normals on this instance.
fn ends_smooth(in: Varyings, light: u32) -> bool {
#if SMOOTH_TERMINATOR
    return light < 32u && (in.smooth_terminators >> (light & 31u) & 1u) == 1u;
#else
    return false;
#endif
}

// What `light`, number `number`, adds to the outgoing radiance.
fn lit_by(light: Light, number: u32, s: Surface, pixel: vec2u, receives: u32, smooth_end: bool) -> vec3f {
    let incoming = illumination(light, s.p_in_view);
    // The terminator is geometric, whatever the shading normal says, unless a smooth one is asked for.
    var behind = !smooth_end && dot(s.geometric_in_view, incoming.towards) <= 0.0;
#if OWN_SHADOW
    behind = behind & (light.own_shadow == 0u);
#endif
#if SURFACE_FUNCTION
    // Asked for every light, whatever arrives: its derivatives need all pixels of a quad.
    let past_casters = select(vec3f(1.0), shadow_factor(light, number, pixel), receives == 1u);
    let factor = select(past_casters, vec3f(0.0), behind);
    return reflected(s, LightArriving(incoming.towards, incoming.irradiance, factor));
#else
    if behind || all(incoming.irradiance == vec3f(0.0)) {
        return vec3f(0.0);
    }
    let factor = select(vec3f(1.0), shadow_factor(light, number, pixel), receives == 1u);
    return factor * incoming.irradiance * reflect_light(s, incoming.towards);
#endif
}

fn shade(in: Varyings) -> vec4f {
    let base = base_color(in);
#if MASKED
    if is_hole(in) {
        discard;
    }
#endif
#if UNLIT
    // Unlit colours are what they are: exposure and tone mapping leave them alone.
    return base;
#else
    var emitted = material.emissive;
#if EMISSIVE_TEXTURE
    emitted *= textureSample(emissive_texture, emissive_sampler, uv_of(2u, in.uvs)).rgb;
#endif
    var s: Surface;
    s.p_in_view = in.p_in_view;
    s.towards_eye_in_view = select(vec3f(0.0, 0.0, 1.0), normalize(-in.p_in_view), frame.eye_w > 0.0);
    let geometric = normalize(cross(dpdx(in.p_in_view), -dpdy(in.p_in_view)));
    s.geometric_in_view = select(geometric, -geometric, dot(geometric, s.towards_eye_in_view) < 0.0);
    let normal = normalize(in.normal_in_view);
    s.normal_in_view = select(-normal, normal, dot(normal, s.geometric_in_view) >= 0.0);
#if NORMAL_TEXTURE
    s.normal_in_view = mapped_normal(s.normal_in_view, in.p_in_view, in.uvs);
#endif
    var metallic = material.metallic;
    var roughness = material.roughness;
#if METALLIC_ROUGHNESS_TEXTURE
    let metallic_roughness =
        textureSample(metallic_roughness_texture, metallic_roughness_sampler, uv_of(1u, in.uvs));
    metallic *= metallic_roughness.b;
    roughness *= metallic_roughness.g;
#endif
    s.ggx_alpha = max(roughness * roughness, 0.002);
    // What passes the surface is not scattered by it.
    s.diffuse = base.rgb * ((1.0 - metallic) * (1.0 - material.transmission));
    s.f0 = mix(vec3f(0.04), base.rgb, metallic);

    var occlusion = 1.0;
#if OCCLUSION_TEXTURE
    let openness = textureSample(occlusion_texture, occlusion_sampler, uv_of(4u, in.uvs)).r;
    occlusion = 1.0 + material.occlusion_strength * (openness - 1.0);
#endif
    // Ambient: full from above, half from below; metals show it as a mirror of the same sky.
    let sky = 0.75 + 0.25 * dot(s.normal_in_view, frame.up_in_view);
    let ambient = frame.ambient * sky * occlusion * (s.diffuse + s.f0 * 0.7);
#if SURFACE_FUNCTION
    s.world_from_view = transpose(mat3x3f(
        frame.view_from_world[0].xyz, frame.view_from_world[1].xyz, frame.view_from_world[2].xyz,
    ));
    s.p_in_world = s.world_from_view * (s.p_in_view - frame.view_from_world[3].xyz);
    s.uv = in.uvs.xy;
    s.base_color = base;
    s.metallic = metallic;
    s.roughness = roughness;
    s.pixel = in.clip.xy;
    var lit = vec3f(0.0);
#else
    var lit = ambient;
#endif

    let pixel = vec2u(in.clip.xy);
#if ONE_LIGHT
    lit += lit_by(lights[0], 0u, s, pixel, in.receives, ends_smooth(in, 0u));
#else
#if LIGHT_TILES
    for (var word = 0u; word < light_words(); word++) {
        var reaching = lights_reaching(pixel, word);
        while reaching != 0u {
            let i = word * 32u + firstTrailingBit(reaching);
            reaching &= reaching - 1u;
            lit += lit_by(lights[i], i, s, pixel, in.receives, ends_smooth(in, i));
        }
    }
#else
    for (var i = 0u; i < frame.light_count; i++) {
        lit += lit_by(lights[i], i, s, pixel, in.receives, ends_smooth(in, i));
    }
#endif
#endif
#if SURFACE_FUNCTION
    let color = outgoing(s, lit, ambient, emitted * frame.exposure);
#else
    let color = lit + emitted * frame.exposure;
#endif
    return vec4f(select(color, tone_mapped(color), frame.tone_map == 1u), base.a);
#endif
}

@fragment
fn opaque(
    in: Varyings,
#if MULTISAMPLED
    @builtin(sample_mask) covered: u32,
#endif
) -> @location(0) vec4f {
#if MULTISAMPLED
    sample_shares = shares_of_samples(in.clip, covered);
#endif
    return vec4f(shade(in).rgb, 1.0);
}

// Premultiplied, for blending over what is behind, or for adding to it where light passes in the surface's colour.
@fragment
fn blended(in: Varyings) -> @location(0) vec4f {
    let color = shade(in);
#if FARTHER
    if in.clip.z >= textureLoad(nearest_depth, vec2u(in.clip.xy), 0) {
        discard;
    }
#endif
    let covered = covered_share(color.a);
    return vec4f(color.rgb * covered, select(covered, 0.0, material.transmission > 0.0));
}


// How much of the picture behind is seen through a surface of this base colour.
fn seen_through(base: vec4f) -> vec3f {
    let covered = covered_share(base.a);
    return mix(vec3f(1.0), base.rgb * material.transmission, covered);
}

// What `blended` is added to is first multiplied by this.
@fragment
fn shine_through(in: Varyings) -> @location(0) vec4f {
    let base = base_color(in);
#if MASKED
    if is_hole(in) {
        discard;
    }
#endif
#if FARTHER
    if in.clip.z >= textureLoad(nearest_depth, vec2u(in.clip.xy), 0) {
        discard;
    }
#endif
    return vec4f(seen_through(base), 1.0);
}

// Depth only, with the holes of an alpha mask.
@fragment
fn masked_depth(in: Varyings) {
    if is_hole(in) {
        discard;
    }
}
