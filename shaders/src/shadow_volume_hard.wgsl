// Hard shadow volumes, counted in the stencil or in a float target.

#import common/volume_faces
#import common/fullscreen

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
