// The traced factor of every pixel.

#import common/frame
#import common/fullscreen

@group(1) @binding(0) var<storage, read> factors: array<f32>;

@fragment
fn traced(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let factor = factors[u32(position.y) * u32(frame.size_px.x) + u32(position.x)];
    // NaN where nothing is hit compares false.
    return vec4f(select(0.0, 1.0, !(factor < 0.5)));
}
