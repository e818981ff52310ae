// The mean of four pixels of a picture drawn at twice the size, in linear light.

#import common/fullscreen

@group(1) @binding(0) var picture: texture_2d<f32>;

@fragment
fn average(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let first = vec2u(position.xy) * 2u;
    let top = textureLoad(picture, first, 0) + textureLoad(picture, first + vec2u(1u, 0u), 0);
    let bottom = textureLoad(picture, first + vec2u(0u, 1u), 0) + textureLoad(picture, first + vec2u(1u, 1u), 0);
    return (top + bottom) * 0.25;
}
