// The samples of a light's unit disc as code, since looking up a thousand of them at every pixel would be slow. This text
// has four samples; techniques replace it by one with those that they take, 32 samples to a word.

const SAMPLE_COUNT: u32 = 4u;
// Samples are taken 64 at a time.
const ROUNDS: u32 = 1u;

// A bit for each sample of the round.
fn samples_of(round: u32) -> vec2u {
    return vec2u(0xfu, 0u);
}

// Those samples (x, y) for which heights.x + heights.y·x + heights.z·y is not negative.
fn samples_not_below(heights: vec3f, round: u32) -> vec2u {
    var low = 0u;
    low = (low >> 1u) | (~bitcast<u32>(fma(0.5, heights.y, fma(0.5, heights.z, heights.x))) & 0x80000000u);
    low = (low >> 1u) | (~bitcast<u32>(fma(-0.5, heights.y, fma(0.5, heights.z, heights.x))) & 0x80000000u);
    low = (low >> 1u) | (~bitcast<u32>(fma(-0.5, heights.y, fma(-0.5, heights.z, heights.x))) & 0x80000000u);
    low = (low >> 1u) | (~bitcast<u32>(fma(0.5, heights.y, fma(-0.5, heights.z, heights.x))) & 0x80000000u);
    return vec2u(low >> 28u, 0u);
}

// Those samples s whose way from the centre crosses the edge from a to b on a line of these heights: s is on the other
// side of the line than the centre, and between a and b as seen from the centre. `flip` is 0 when the centre is on the left,
// else all ones.
fn samples_crossed(heights: vec3f, a: vec2f, b: vec2f, flip: u32, round: u32) -> vec2u {
    var low = 0u;
    low = (low >> 1u) | sample_crossed(vec2f(0.5, 0.5), heights, a, b, flip);
    low = (low >> 1u) | sample_crossed(vec2f(-0.5, 0.5), heights, a, b, flip);
    low = (low >> 1u) | sample_crossed(vec2f(-0.5, -0.5), heights, a, b, flip);
    low = (low >> 1u) | sample_crossed(vec2f(0.5, -0.5), heights, a, b, flip);
    return vec2u(low >> 28u, 0u);
}

fn sample_crossed(sample: vec2f, heights: vec3f, a: vec2f, b: vec2f, flip: u32) -> u32 {
    let line = bitcast<u32>(fma(sample.x, heights.y, fma(sample.y, heights.z, heights.x))) ^ flip;
    let at_a = bitcast<u32>(fma(sample.x, a.y, -(sample.y * a.x))) ^ flip;
    let at_b = bitcast<u32>(fma(sample.x, b.y, -(sample.y * b.x))) ^ flip;
    return line & at_a & ~at_b & 0x80000000u;
}
