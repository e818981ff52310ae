// A buffer of words as a texture, four words to a texel: what is looked up at many places at every pixel. Software adapters
// read a texel for all pixels of a group together, and a storage buffer word by word and pixel by pixel.

#import common/fullscreen

// Texels along a row: see common/packed.
const PACKED_WIDTH: u32 = 2048u;

@group(1) @binding(0) var<storage, read> words: array<u32>;

@fragment
fn pack(@builtin(position) position: vec4f) -> @location(0) vec4u {
    let first = 4u * (u32(position.y) * PACKED_WIDTH + u32(position.x));
    return vec4u(words[first], words[first + 1u], words[first + 2u], words[first + 3u]);
}
