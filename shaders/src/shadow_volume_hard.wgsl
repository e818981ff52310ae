// Hard shadow volumes, counted in the stencil or in a float target.

#import common/volume
#if CAPS
#import common/volume_caps
#endif
#import common/fullscreen

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
#if CAPS
    @location(1) @interpolate(flat, first) normal_offset: vec4f,
    @location(2) @interpolate(flat, first) far_m: f32,
#endif
}

#if CAPS
@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) volume: u32) -> Varyings {
    let cap = cap_plane(corner, volume);
    return Varyings(volume_clip(cap_corners[corner], volume), cap.normal_offset, cap.far_m);
}
#else
@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) volume: u32) -> Varyings {
    return Varyings(volume_clip(index, volume));
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

#if CAPS
// In the stencil a cap's fragment says only where it is.
@fragment
fn place(in: Varyings) -> @builtin(frag_depth) f32 {
    return cap_depth(in.clip, CapPlane(in.normal_offset, in.far_m));
}
#endif

// What a face counts in a float target: +1 where the view enters a volume, −1 where it leaves it. How much it weighs,
// the blend constant says.
@fragment
fn count(in: Varyings, @builtin(front_facing) entering: bool) -> Counted {
    return counted(in, vec4f(select(-1.0, 1.0, entering)));
}

// The same of front faces only.
@fragment
fn count_front(in: Varyings, @builtin(front_facing) entering: bool) -> Counted {
    return counted(in, vec4f(select(0.0, 1.0, entering)));
}

// The same of back faces only.
@fragment
fn count_back(in: Varyings, @builtin(front_facing) entering: bool) -> Counted {
    return counted(in, vec4f(select(-1.0, 0.0, entering)));
}

@group(1) @binding(2) var counts: texture_2d<f32>;

// Darkness wherever more volumes were entered than left.
@fragment
fn darken_counted(@builtin(position) position: vec4f) -> @location(0) vec4f {
    if textureLoad(counts, vec2u(position.xy), 0).x <= 0.0 {
        discard;
    }
    return vec4f(0.0);
}
