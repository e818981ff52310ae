// The nearest of all transparent surfaces before the opaque one: its depth.

#import common/frame
#import common/material

// Of the opaque surface at every pixel.
@group(1) @binding(0) var opaque_depth: texture_depth_2d;

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
fn nearest(in: Varyings) {
    if in.clip.z <= textureLoad(opaque_depth, vec2u(in.clip.xy), 0) || !is_there(in.uvs, in.alpha) {
        discard;
    }
}
