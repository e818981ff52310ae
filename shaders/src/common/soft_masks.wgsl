// Where triangles with holes have them, as ways from a receiver to samples of the light cross them. The alphas of all images
// are in one texture, so that one shader asks all casters.

#import common/soft_seen
#import common/alpha_mask

#if CASTERS
#if MASKS
// Four texels for each triangle with holes, from the first of them: see SoftMask of masks.rs of ShadowVolumeSoft.
@group(1) @binding(9) var soft_masks: texture_2d<u32>;
// Alphas of images, row by row, a byte each: sixteen in a texel.
@group(1) @binding(10) var soft_alphas: texture_2d<u32>;
// Samples of the unit disc, two in a texel.
@group(1) @binding(11) var soft_samples: texture_2d<u32>;

fn sample_place(sample: u32) -> vec2f {
    let two = bitcast<vec4f>(packed(soft_samples, sample >> 1u));
    return select(two.xy, two.zw, (sample & 1u) != 0u);
}

// A triangle's mask; a, b and c are the corners of its record.
struct Mask {
    // Texture coordinates, transformed.
    uv_a: vec2f,
    uv_b: vec2f,
    uv_c: vec2f,
    // What the texture's alpha is multiplied by.
    alpha: vec3f,
    // Holes are where alpha is below.
    cutoff: f32,
    // How alpha is read: see common/alpha_mask.
    reading: u32,
    // Where the image's alphas begin, and its size; 0 without an image.
    first: u32,
    size: vec2u,
}

fn mask_of(number: u32) -> Mask {
    let place = (number - soft.first_masked) * 4u;
    let one = bitcast<vec4f>(packed(soft_masks, place));
    let two = bitcast<vec4f>(packed(soft_masks, place + 1u));
    let three = packed(soft_masks, place + 2u);
    let four = packed(soft_masks, place + 3u);
    let rest = bitcast<vec2f>(three.xy);
    return Mask(one.xy, one.zw, two.xy, vec3f(two.zw, rest.x), rest.y, three.z, three.w, four.xy);
}

// In 0 … 255.
fn packed_alpha(mask: Mask, texel: vec2i) -> f32 {
    let size = vec2i(mask.size);
    let x = wrapped(texel.x, size.x, mask.reading & 3u);
    let y = wrapped(texel.y, size.y, (mask.reading >> 2u) & 3u);
    let byte = mask.first + u32(y) * mask.size.x + u32(x);
    let four = packed(soft_alphas, byte >> 4u);
    let word = four[(byte >> 2u) & 3u];
    return f32((word >> ((byte & 3u) * 8u)) & 0xffu);
}

// Whether there is a hole where the way towards (x, y, 1) in the receiver's frame crosses the triangle.
fn has_hole_towards(mask: Mask, t: SeenTriangle, direction: vec2f) -> bool {
    // Over the planes through the receiver and the edges, a point of the triangle is as high as the corner opposite weighs.
    let d = vec3f(1.0, direction);
    let weights = vec3f(dot(t.bc, d), -dot(t.ac, d), dot(t.ab, d));
    let share = weights.yz / (weights.x + weights.y + weights.z);
    // From the first corner, so that what is alike at all three is no other between them.
    var alpha = mask.alpha.x + (mask.alpha.y - mask.alpha.x) * share.x + (mask.alpha.z - mask.alpha.x) * share.y;
    if mask.size.x > 0u {
        let uv = mask.uv_a + (mask.uv_b - mask.uv_a) * share.x + (mask.uv_c - mask.uv_a) * share.y;
        let at = blended_texels(uv, vec2i(mask.size), mask.reading);
        var texels = vec4f(packed_alpha(mask, at.first));
        if any(at.weight != vec2f(0.0)) {
            texels.y = packed_alpha(mask, at.first + vec2i(1, 0));
            texels.z = packed_alpha(mask, at.first + vec2i(0, 1));
            texels.w = packed_alpha(mask, at.first + vec2i(1, 1));
        }
        alpha *= blended_alpha(texels, at.weight);
    }
    return alpha < mask.cutoff;
}
#endif
#endif
