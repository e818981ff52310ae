// Copies a buffer of words into a texture, four words to a texel, for look-ups at many places at every pixel: software adapters
// read texels for all pixels of a group together, but storage buffers word by word and pixel by pixel.

#import common/fullscreen

// Texels along a row: see common/packed.
const PACKED_WIDTH: u32 = 2048u;

@group(1) @binding(0) var<storage, read> words: array<u32>;

@fragment
fn pack(@builtin(position) position: vec4f) -> @location(0) vec4u {
    let first = 4u * (u32(position.y) * PACKED_WIDTH + u32(position.x));
    return vec4u(words[first], words[first + 1u], words[first + 2u], words[first + 3u]);
}
