// The depth prepass: what is visible, and how far away.

#import common/frame

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
}

@vertex
fn vertex(@location(0) position: vec3f, @builtin(instance_index) instance: u32) -> Varyings {
    return Varyings(clip_from_local(instance, position));
}
