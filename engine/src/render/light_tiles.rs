//! Which lights reach which parts of the picture, so that pixels are shaded by those alone.

use std::sync::Arc;

use super::reach;
use super::schedule::{Inputs, Needs};
use crate::plan::{BufferDesc, BufferUsage, SlotId};
use crate::shadow::hash_of;

/// Pixels along a side of a tile: 1 << `LIGHT_TILE_SHIFT` of common/light_tiles.
const TILE_PX: u32 = 1 << 5;
/// Tiles are worth it where a pixel has this many times fewer lights in its tile than there are: a light that is looked up by the
/// pixel costs more than one that all pixels take in turn.
const FEWER: usize = 3;

/// `light_tiles` of common/light_tiles: how many tiles a row has, and words a tile; then tile by tile a bit for each light that may reach
/// something there. `None` where most lights reach most of the picture.
pub(super) fn add(inputs: &Inputs<'_>, needs: &mut Needs) -> Option<SlotId> {
    let lights = &inputs.snapshot.lights;
    let [columns, rows] = inputs.view.size_px.map(|px| px.div_ceil(TILE_PX));
    // Of each light the tiles from its first to before its last, along and down.
    let reached_tiles = lights.iter().map(|light| {
        let [left, top, width, height] = reach::lit_pixels(inputs.view, light).unwrap_or_default();
        let tiles = |from: u32, count: u32| from / TILE_PX..(from + count).div_ceil(TILE_PX);
        (tiles(left, width), tiles(top, height))
    });
    let reached_tiles: Vec<_> = reached_tiles.collect();
    let reached: usize = reached_tiles.iter().map(|(along, down)| along.len() * down.len()).sum();
    if lights.len() < FEWER || reached * FEWER > lights.len() * (columns * rows) as usize {
        return None;
    }
    let words = lights.len().div_ceil(32);
    let mut tiles = vec![0_u32; (columns * rows) as usize * words];
    for (index, (along, down)) in reached_tiles.into_iter().enumerate() {
        for row in down {
            for column in along.clone() {
                tiles[(row * columns + column) as usize * words + index / 32] |= 1 << (index % 32);
            }
        }
    }
    let head = [columns, words as u32];
    let bytes = bytemuck::cast_slice(&[&head[..], &tiles].concat()).to_vec();
    Some(needs.slots.buffer(BufferDesc {
        name: "light tiles",
        usage: BufferUsage::Storage,
        revision_key: hash_of(("light tiles", &bytes)),
        contents: Arc::new(bytes),
        reason: "most lights reach a small part of the picture: which of them each tile of it is shaded by",
    }))
}
