// The alpha of a masked texture at a place: the one look-up that visible surfaces, their shading and their
// shadows share. Texels are read one by one and blended in f32, since samplers blend with weights
// of 8 bits and round as they like.

// `reading` in bits: 0 and 1 say what is beyond the edges in u, 2 and 3 in v (0 repeats, 1 repeats mirrored, 2 the
// edge goes on), 4 whether texels blend.

fn wrapped(index: i32, size: i32, mode: u32) -> i32 {
    let period = select(size, 2 * size, mode == 1u);
    let within = ((index % period) + period) % period;
    return select(min(within, 2 * size - 1 - within), clamp(index, 0, size - 1), mode == 2u);
}

// In 0 … 255, without the rounding of a quotient.
fn texel_alpha(image: texture_2d<f32>, texel: vec2i, size: vec2i, reading: u32) -> f32 {
    let place = vec2i(wrapped(texel.x, size.x, reading & 3u), wrapped(texel.y, size.y, (reading >> 2u) & 3u));
    return floor(textureLoad(image, place, 0).a * 255.0 + 0.5);
}

// Four texels and how they blend: `first`, and its neighbours to the right and below.
struct BlendedTexels {
    first: vec2i,
    // How much the right and the lower ones weigh; 0, 0 where the first has all the weight.
    weight: vec2f,
}

// The texels of an image of this size that are read at `uv`.
fn blended_texels(uv: vec2f, size: vec2i, reading: u32) -> BlendedTexels {
    let place = uv * vec2f(size);
    let blends = (reading & 16u) != 0u;
    let corner = floor(select(place, place - 0.5, blends));
    let weight = select(vec2f(0.0), place - 0.5 - corner, blends);
    return BlendedTexels(vec2i(corner), weight);
}

// The alpha, 0 to 1, of four texels in 0 … 255: the first, the right one, the lower one, and the one right below.
fn blended_alpha(texels: vec4f, weight: vec2f) -> f32 {
    let top = texels.x + (texels.y - texels.x) * weight.x;
    let bottom = texels.z + (texels.w - texels.z) * weight.x;
    return (top + (bottom - top) * weight.y) / 255.0;
}

// The alpha of `image` at `uv`, of its full size whatever the distance.
fn mask_alpha(image: texture_2d<f32>, uv: vec2f, reading: u32) -> f32 {
    let size = vec2i(textureDimensions(image));
    let at = blended_texels(uv, size, reading);
    let a = texel_alpha(image, at.first, size, reading);
    // All the weight is one texel's.
    if all(at.weight == vec2f(0.0)) {
        return a / 255.0;
    }
    let b = texel_alpha(image, at.first + vec2i(1, 0), size, reading);
    let c = texel_alpha(image, at.first + vec2i(0, 1), size, reading);
    let d = texel_alpha(image, at.first + vec2i(1, 1), size, reading);
    return blended_alpha(vec4f(a, b, c, d), at.weight);
}
