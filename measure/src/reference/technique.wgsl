// The traced factor of every pixel.

#import common/frame
#import common/fullscreen

@group(1) @binding(0) var<storage, read> factors: array<f32>;

@fragment
fn traced(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = u32(position.y) * u32(frame.size_px.x) + u32(position.x);
#if COLORED
    return vec4f(factors[pixel * 3u], factors[pixel * 3u + 1u], factors[pixel * 3u + 2u], 1.0);
#else
    return vec4f(factors[pixel]);
#endif
}
