// Turns counts into a bit of the light mask: drawn where the stencil is not zero, added by a blend constant that
// carries the bit.

#import common/fullscreen

@fragment
fn mark() -> @location(0) vec4f {
    return vec4f(1.0);
}

// Turns counts into darkness in a visibility target.
@fragment
fn darken() -> @location(0) vec4f {
    return vec4f(0.0);
}
