// What passes one crossing of a transparent surface, and the colour of its texture there: the one look-up of shadows
// and of the layers they fall on. Texels are read one by one and blended in f32, as common/alpha_mask reads alpha.

#import common/alpha_mask

// Adapters decode sRGB with tables that may be off by more than a thousandth: the byte is recovered from their value, and
// decoded here.
fn decoded(linear: vec3f) -> vec3f {
    let encoded = select(1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055, 12.92 * linear, linear <= vec3f(0.0031308));
    let value = floor(encoded * 255.0 + 0.5) / 255.0;
    return select(pow((value + 0.055) / 1.055, vec3f(2.4)), value / 12.92, value <= vec3f(0.04045));
}

fn texel_color(image: texture_2d<f32>, texel: vec2i, size: vec2i, reading: u32) -> vec4f {
    let place = vec2i(wrapped(texel.x, size.x, reading & 3u), wrapped(texel.y, size.y, (reading >> 2u) & 3u));
    let color = textureLoad(image, place, 0);
    // Without the rounding of a quotient: alpha 0 is no surface.
    return vec4f(decoded(color.rgb), floor(color.a * 255.0 + 0.5) / 255.0);
}

// Linear colour and alpha of `image` at `uv`, of its full size whatever the distance; `reading` as in common/alpha_mask.
fn color_at(image: texture_2d<f32>, uv: vec2f, reading: u32) -> vec4f {
    let size = vec2i(textureDimensions(image));
    let at = blended_texels(uv, size, reading);
    let a = texel_color(image, at.first, size, reading);
    // All the weight is one texel's.
    if all(at.weight == vec2f(0.0)) {
        return a;
    }
    let b = texel_color(image, at.first + vec2i(1, 0), size, reading);
    let c = texel_color(image, at.first + vec2i(0, 1), size, reading);
    let d = texel_color(image, at.first + vec2i(1, 1), size, reading);
    return mix(mix(a, b, at.weight.x), mix(c, d, at.weight.x), at.weight.y);
}

// What passes a surface of linear colour `rgb` that covers this share (its alpha where it blends, else 1; 0 in a hole)
// and has this `KHR_materials_transmission`: as `Material::transmission_at` has it.
fn transmission_at(rgb: vec3f, coverage: f32, transmission: f32) -> vec3f {
    if coverage <= 0.0 {
        return vec3f(1.0);
    }
    return saturate(rgb * (1.0 - coverage * (1.0 - transmission)));
}

// The same of a surface of this colour and alpha; `alpha_mode` 0: alpha is ignored, 1: holes are where it is below the cutoff,
// 2: it is the share that is covered.
fn passing_surface(color: vec4f, alpha_mode: u32, cutoff: f32, transmission: f32) -> vec3f {
    var coverage = 1.0;
    if alpha_mode == 1u {
        coverage = select(0.0, 1.0, color.a >= cutoff);
    }
    if alpha_mode == 2u {
        coverage = saturate(color.a);
    }
    return transmission_at(color.rgb, coverage, transmission);
}
