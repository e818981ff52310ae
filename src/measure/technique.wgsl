// The traced factor of every pixel.

#import common/frame
#import common/fullscreen

@group(1) @binding(0) var<storage, read> factors: array<f32>;

@fragment
fn traced(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let factor = factors[u32(position.y) * u32(frame.size_px.x) + u32(position.x)];
    // Nothing is hit where it is not a number; one that is lies between 0 and 1.
    return vec4f(select(1.0, factor, factor >= 0.0 && factor <= 1.0));
}
