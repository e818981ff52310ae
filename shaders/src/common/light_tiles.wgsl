// Which lights may reach something in the part of the picture that a pixel lies in.

#if LIGHT_TILES
// How many tiles a row has, and words a tile; then tile by tile, row by row, a bit for each light.
@group(1) @binding(10) var<storage, read> light_tiles: array<u32>;

// A tile has 1 << this many pixels along a side.
const LIGHT_TILE_SHIFT: u32 = 5u;

fn light_words() -> u32 {
    return light_tiles[1];
}

// Those of lights 32·word to 32·word + 31 that may reach the tile of `pixel`, a bit each.
fn lights_reaching(pixel: vec2u, word: u32) -> u32 {
    let tile = pixel >> vec2u(LIGHT_TILE_SHIFT);
    return light_tiles[2u + (tile.y * light_tiles[0] + tile.x) * light_words() + word];
}
#endif
