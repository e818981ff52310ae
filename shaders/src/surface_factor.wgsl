// The linear factor of one light at the visible surface: 1 lit, 0 dark, red green and blue apart.

#import common/frame
#import common/positions

@group(1) @binding(1) var<storage, read> indices: array<u32>;
// Two bits for each triangle of the frame: bit 0, the eye sees the side turned away from the light.
@group(1) @binding(2) var<storage, read> turned_away: array<u32>;
#if COUNTS
@group(1) @binding(3) var counts: texture_2d<u32>;
#endif
#if VISIBILITY
@group(1) @binding(3) var visibility: texture_2d_array<f32>;
#endif

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) p_in_view: vec3f,
    @location(1) @interpolate(flat, first) dark_side: u32,
    @location(2) @interpolate(flat, first) receives: u32,
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let p = local_position(indices[corner]);
    let triangle = instances[instance].first_triangle + corner / 3u;
    let dark_side = (turned_away[triangle / 32u] >> (triangle % 32u)) & 1u;
    return Varyings(clip_from_local(instance, p), view_from_local(instance, p), dark_side, instances[instance].flags & 1u);
}

@fragment
fn factor(in: Varyings) -> @location(0) vec4f {
    if in.receives == 0u {
        return vec4f(1.0);
    }
    if in.dark_side == 1u {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
    let pixel = vec2u(in.clip.xy);
    var result = vec3f(1.0);
#if COUNTS
    if textureLoad(counts, pixel, 0).x != 0u {
        result = vec3f(0.0);
    }
#endif
#if VISIBILITY
    result = textureLoad(visibility, pixel, 0, 0).rgb;
#endif
    return vec4f(result, 1.0);
}
