// Darkens the finished picture by one shadow's visibility: the black rectangle of paper 002, section 6.4.

#import common/fullscreen

// What is lost where nothing is visible, for red, green and blue.
@group(1) @binding(0) var<storage, read> max_darkening: vec4f;
@group(1) @binding(1) var visibility: texture_2d_array<f32>;

@fragment
fn darken_by(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = textureLoad(visibility, vec2u(position.xy), 0, 0);
#if ONE_CHANNEL
    let factor = texel.rrr;
#else
    let factor = texel.rgb;
#endif
    return vec4f(1.0 - max_darkening.xyz * (1.0 - factor), 1.0);
}
