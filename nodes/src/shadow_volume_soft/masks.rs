//! Parts with holes: triangles that are asked one by one, sample by sample, with their masks.
//!
//! *The idea.* A silhouette knows triangles, not texels, so triangles with holes are in no chain. Each receiver asks those that some
//! way from it to the disc may meet, which are listed by cell and slice as edges are (`lists`); of the samples behind one the
//! mask is looked up where the way crosses it. A sample that several hide, or a mask and an edge, is dark once.
//!
//! *In every quality.* Areas know no holes. Beside `perReceiver` and `wedge` a pass of samples asks the masks alone, and
//! multiplies what these leave of the light: too light or too dark where both hide parts of the disc, as areas are among themselves.
//!
//! *Limits.* The alphas of all images that a light's masks wear are in one texture of 256 MiB at most.

use std::collections::BTreeMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::DVec3;
use shadowgraph_engine::geometry::LightGrid;
use shadowgraph_engine::plan::BufferDesc;
use shadowgraph_engine::scene::{Image, ImageKey, Instance};
use shadowgraph_engine::shadow::{Binding, LightContext, PassList, ShadowError, hash_of, light_samples};

use super::chain::{ChainTriangle, LightBall, chain_triangle};
use super::lists::{CELL_MARGIN, LEAST_WORDS, MOST_WORDS, SOME, SoftGrid};
use super::packed::packed;
use crate::common::mask_vertices::MaskVertices;

/// The mask of a triangle in four texels: see soft_masks.wgsl. Corners are in the order of the triangle's record.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub(super) struct SoftMask {
    pub uvs: [[f32; 2]; 3],
    pub alphas: [f32; 3],
    pub cutoff: f32,
    pub reading: u32,
    pub first: u32,
    pub size: [u32; 2],
    pub pad_0: [u32; 2],
}

/// A triangle with holes.
#[derive(Clone, Debug)]
pub(super) struct MaskedTriangle {
    pub triangle: ChainTriangle,
    /// Where its image's alphas begin, and the image's size, are not yet set.
    pub mask: SoftMask,
    pub image: Option<ImageKey>,
}

/// A hash of what [`masked_triangles`] reads of an instance beside its shape.
pub(super) fn masks_key(instance: &Instance) -> u64 {
    let worn = instance.materials.iter().filter(|material| material.casts_by_texel()).map(|material| {
        let texture = format!("{:?}", material.base_color_texture);
        (texture, material.base_color.w.to_bits(), material.cutoff().map(f32::to_bits))
    });
    hash_of(worn.collect::<Vec<_>>())
}

/// The triangles with holes of an instance, relative to `center`.
pub(super) fn masked_triangles(instance: &Instance, light: &LightBall, center: DVec3) -> Vec<MaskedTriangle> {
    let mut masked = Vec::new();
    for (part, material) in instance.materials.iter().enumerate() {
        let Some(cutoff) = material.cutoff().filter(|_| material.casts_by_texel()) else { continue };
        let texture = material.base_color_texture;
        let worn = MaskVertices::new(instance, texture.as_ref());
        for number in instance.mesh.data().parts[part].triangles.clone() {
            let vertices = instance.mesh.triangle(number as usize);
            let corners = vertices.map(|vertex| instance.world_position(vertex));
            let Some((triangle, order)) = chain_triangle(corners, center, light) else { continue };
            let sorted = order.map(|corner| vertices[corner]);
            let mask = SoftMask {
                uvs: sorted.map(|vertex| worn.uv(vertex).as_vec2().to_array()),
                alphas: sorted.map(|vertex| (f64::from(material.base_color.w) * worn.alpha(vertex)) as f32),
                cutoff,
                reading: texture.map_or(0, |texture| texture.reading_bits()),
                ..SoftMask::default()
            };
            masked.push(MaskedTriangle { triangle, mask, image: texture.map(|texture| texture.image) });
        }
    }
    masked
}

/// What the shader reads of all masks of a light.
#[derive(Debug)]
pub(super) struct Masks {
    /// A [`SoftMask`] for each triangle.
    pub masks: Arc<Vec<u8>>,
    pub alphas: Arc<Vec<u8>>,
    /// The images, which are known by where they are: as long as this is kept, no other can be there.
    _images: Vec<Arc<Image>>,
    /// The number of the first triangle.
    pub first: usize,
    /// How many there are.
    pub count: usize,
    /// Cells along a side of a plane.
    pub side: usize,
    /// Where their lists begin.
    pub lists: usize,
}

impl Masks {
    /// Of triangles that are numbered from `first`. Their lists are over `grid`, and are returned.
    pub(super) fn new(
        grid: &SoftGrid,
        triangles: &[MaskedTriangle],
        first: usize,
        images: &dyn Fn(ImageKey) -> Option<Arc<Image>>,
    ) -> (Self, Vec<Vec<u32>>) {
        let (mut alphas, mut places, mut kept) = (Vec::new(), BTreeMap::new(), Vec::new());
        let masks: Vec<SoftMask> = triangles
            .iter()
            .map(|triangle| {
                let place = triangle.image.and_then(|key| {
                    *places.entry(key).or_insert_with(|| {
                        let image = images(key)?;
                        let first = alphas.len() as u32;
                        alphas.extend(image.rgba8.chunks_exact(4).map(|texel| texel[3]));
                        let size = [image.width, image.height];
                        kept.push(image);
                        Some((first, size))
                    })
                });
                place.map_or(triangle.mask, |(first, size)| SoftMask { first, size, ..triangle.mask })
            })
            .collect();
        // The shader reads four words at once.
        alphas.resize(alphas.len().next_multiple_of(16).max(16), 0);
        let (side, lists) = lists(grid, first, triangles);
        let masks = Self {
            masks: Arc::new(cast_slice(&masks).to_vec()),
            alphas: Arc::new(alphas),
            _images: kept,
            first,
            count: triangles.len(),
            side,
            lists: 0,
        };
        (masks, lists)
    }

    /// Adds what the shader reads to the plan: masks, alphas, and the places of so many samples.
    pub(super) fn bind(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        key: u64,
        samples: u32,
    ) -> Result<Vec<(u32, Binding)>, ShadowError> {
        let name = &light.light().name;
        let places: Vec<[f32; 2]> =
            light_samples(samples).iter().map(|place| place.as_vec2().to_array()).collect();
        let places = Arc::new(cast_slice(&places).to_vec());
        let [masks, alphas] = ["soft masks", "soft alphas"].map(|what| (what, hash_of((what, key))));
        let samples = ("soft samples", hash_of(("soft samples", samples)));
        let mut bindings = Vec::new();
        for (binding, (what, key), bytes, reason) in [
            (9, masks, &self.masks, "where triangles have holes"),
            (10, alphas, &self.alphas, "looked up where light would pass them"),
            (11, samples, &places, "towards which they are asked"),
        ] {
            let name = format!("{what} of {name}");
            let slot = out.buffer(BufferDesc::storage(&name, key, Arc::clone(bytes), reason));
            let words = packed(light, out, &name, (slot, bytes.len()), Some(key))?;
            bindings.push((binding, Binding::Texture(words)));
        }
        Ok(bindings)
    }
}

/// How many cells a side of a plane has, and for each plane, slice and cell the numbers of the triangles that ways to the disc may
/// meet from there: as many cells as memory allows.
fn lists(grid: &SoftGrid, first: usize, triangles: &[MaskedTriangle]) -> (usize, Vec<Vec<u32>>) {
    let corners: Vec<[DVec3; 3]> = triangles.iter().map(|masked| masked.triangle.corners).collect();
    let some = || corners.iter().step_by(corners.len().div_ceil(SOME).max(1));
    let stands_for = corners.len() as f64 / some().len().max(1) as f64;
    let lists = |side: usize| grid.planes.len() * grid.slice_ends.len() * side * side;
    let words = |side: usize| {
        let mut words = 0_usize;
        some().for_each(|corners| masked_cells(grid, side, *corners, &mut |_| words += 1));
        lists(side) + (words as f64 * stands_for) as usize
    };
    let mut side = 1;
    while side < FINEST && words(side * 2) <= LEAST_WORDS {
        side *= 2;
    }
    loop {
        let mut listed = vec![Vec::new(); lists(side)];
        let mut words = lists(side);
        for (number, corners) in (first as u32..).zip(&corners) {
            masked_cells(grid, side, *corners, &mut |list| {
                listed[list].push(number);
                words += 1;
            });
        }
        if words <= MOST_WORDS || side == 1 {
            return (side, listed);
        }
        side /= 2;
    }
}

/// The most cells along a side.
const FINEST: usize = 64;

/// Calls `visit` with every list whose receivers may meet the triangle on their way to the light.
fn masked_cells(grid: &SoftGrid, side: usize, corners: [DVec3; 3], visit: &mut dyn FnMut(usize)) {
    let cells = LightGrid::from_planes(&grid.planes, side);
    let nearest = grid.nearest_of_triangle(corners);
    for slice in 0..grid.slice_ends.len() {
        let Some(reach_m) = grid.reach(nearest, slice) else { continue };
        let reach_m = reach_m + grid.lost(nearest, slice);
        for plane in 0..grid.planes.len() {
            cells.for_each_cell_within(plane, corners, CELL_MARGIN, reach_m, |[x, y]| {
                visit(((plane * grid.slice_ends.len() + slice) * side + y) * side + x);
            });
        }
    }
}
