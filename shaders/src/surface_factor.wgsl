// The linear factor of one light at the visible surface: 1 lit, 0 dark, red green and blue apart.

#import common/frame
#import common/positions
#if MASKED
#import common/attributes
#endif

@group(1) @binding(1) var<storage, read> indices: array<u32>;
// With OWN_SHADOW the factor says by itself what the surface is turned away from.
#if OWN_SHADOW
#else
// A bit for each triangle of the frame: the eye sees the side turned away from the light.
@group(1) @binding(3) var<storage, read> turned_away: array<u32>;
#endif
#if COUNTS
@group(1) @binding(4) var counts: texture_2d<u32>;
#endif
#if VISIBILITY
@group(1) @binding(4) var visibility: texture_2d_array<f32>;
#endif

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) p_in_view: vec3f,
#if OWN_SHADOW
#else
    @location(1) @interpolate(flat, first) dark_side: u32,
#endif
    @location(2) @interpolate(flat, first) receives: u32,
#if MASKED
    @location(3) uvs: Uvs,
    @location(4) alpha: f32,
#endif
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let vertex = indices[corner];
    let p = local_position(vertex);
    var out: Varyings;
    out.clip = clip_from_local(instance, p);
    out.p_in_view = view_from_local(instance, p);
#if OWN_SHADOW
#else
    let triangle = instances[instance].first_triangle + corner / 3u;
    out.dark_side = (turned_away[triangle / 32u] >> (triangle % 32u)) & 1u;
#endif
    out.receives = instances[instance].flags & 1u;
#if MASKED
    out.uvs = vertex_uvs(vertex);
    out.alpha = vertex_alpha(vertex);
#endif
    return out;
}

@fragment
fn factor(in: Varyings) -> @location(0) vec4f {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    if in.receives == 0u {
        return vec4f(1.0);
    }
#if OWN_SHADOW
#else
    if in.dark_side == 1u {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
#endif
    let pixel = vec2u(in.clip.xy);
    var result = vec3f(1.0);
#if COUNTS
    if textureLoad(counts, pixel, 0).x > AT_REST {
        result = vec3f(0.0);
    }
#endif
#if VISIBILITY
    result = textureLoad(visibility, pixel, 0, 0).rgb;
#endif
    return vec4f(result, 1.0);
}
