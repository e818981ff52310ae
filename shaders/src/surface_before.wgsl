// The depth of transparent surfaces before another depth; with FARTHER of those only that are behind the nearest.

#import common/frame
#import common/material

@group(1) @binding(0) var behind_depth: texture_depth_2d;
#if FARTHER
@group(1) @binding(9) var nearest_depth: texture_depth_2d;
#endif

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) uvs: Uvs,
    @location(1) alpha: f32,
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
    var out: Varyings;
    out.clip = clip_from_local(instance, position);
#if SECOND_UV
    out.uvs = vec4f(uv, second_uv);
#else
    out.uvs = uv;
#endif
    out.alpha = color.a;
    return out;
}

@fragment
fn before(in: Varyings) {
    let pixel = vec2u(in.clip.xy);
    var is_seen = in.clip.z > textureLoad(behind_depth, pixel, 0);
#if FARTHER
    is_seen = is_seen && in.clip.z < textureLoad(nearest_depth, pixel, 0);
#endif
    if !is_seen || !is_there(in.uvs, in.alpha) {
        discard;
    }
}
