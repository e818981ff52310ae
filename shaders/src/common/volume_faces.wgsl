// The faces of shadow volumes as they are drawn and counted.

#import common/volume
#if CAPS
#import common/volume_caps
#endif

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) @interpolate(flat, first) volume: u32,
#if CAPS
    @location(1) @interpolate(flat, first) normal_offset: vec4f,
    @location(2) @interpolate(flat, first) far_m: f32,
#endif
}

#if CAPS
@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) volume: u32) -> Varyings {
    let cap = cap_plane(corner, volume);
    return Varyings(volume_clip(cap_corners[corner], volume), volume, cap.normal_offset, cap.far_m);
}
#else
@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) volume: u32) -> Varyings {
    return Varyings(volume_clip(index, volume), volume);
}
#endif

// What a fragment of a face counts, and of a cap the depth at which it does.
struct Counted {
    @location(0) count: vec4f,
#if CAPS
    @builtin(frag_depth) depth: f32,
#endif
}

fn counted(in: Varyings, count: vec4f) -> Counted {
#if CAPS
    return Counted(count, cap_depth(in.clip, CapPlane(in.normal_offset, in.far_m)));
#else
    return Counted(count);
#endif
}
