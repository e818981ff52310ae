//! The part of a caster that lies above a plane.
//!
//! Triangles in the plane or under it cast nothing on it, and of those that cross it only the part above does; both are
//! decided in f64.

use std::collections::HashMap;

use glam::{DVec2, DVec3, DVec4};
use shadowgraph_engine::scene::Instance;

use super::receivers::Flat;
use crate::common::mask_vertices::MaskVertices;

/// A vertex, or a point on an edge where it was cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub(super) p_in_world: DVec3,
    pub(super) uv: DVec2,
    pub(super) color: DVec4,
}

/// One material's triangles of one caster, above a plane.
#[derive(Debug, Default)]
pub(super) struct AbovePlane {
    pub(super) vertices: Vec<Vertex>,
    /// Three for each triangle.
    pub(super) indices: Vec<u32>,
}

impl AbovePlane {
    /// The triangles of a part, cut where they cross the plane.
    pub(super) fn new(instance: &Instance, part: usize, flat: &Flat) -> Self {
        let mesh = instance.mesh.data();
        let worn = MaskVertices::new(instance, instance.materials[part].base_color_texture.as_ref());
        let vertex = |vertex: u32| Vertex {
            p_in_world: instance.world_position(vertex),
            uv: worn.uv(vertex),
            color: worn.color(vertex),
        };
        let mut above = Self::default();
        let mut known: HashMap<(u32, u32), u32> = HashMap::new();
        for triangle in mesh.parts[part].triangles.clone() {
            let corners = instance.mesh.triangle(triangle as usize);
            let heights = corners.map(|corner| flat.plane.height(instance.world_position(corner)));
            if heights.iter().all(|height| *height <= flat.tolerance_m) {
                continue;
            }
            let mut outline = Vec::with_capacity(4);
            for i in 0..3 {
                let (from, to) = (i, (i + 1) % 3);
                if heights[from] >= 0.0 {
                    let key = (corners[from], corners[from]);
                    outline.push(above.place(&mut known, key, || vertex(corners[from])));
                }
                if heights[from] * heights[to] < 0.0 {
                    // In one order for both triangles of an edge.
                    let (a, b) = if corners[from] < corners[to] { (from, to) } else { (to, from) };
                    let share = heights[a] / (heights[a] - heights[b]);
                    outline.push(above.place(&mut known, (corners[a], corners[b]), || {
                        let (a, b) = (vertex(corners[a]), vertex(corners[b]));
                        Vertex {
                            p_in_world: a.p_in_world.lerp(b.p_in_world, share),
                            uv: a.uv.lerp(b.uv, share),
                            color: a.color.lerp(b.color, share),
                        }
                    }));
                }
            }
            above.indices.extend((2..outline.len()).flat_map(|i| [outline[0], outline[i - 1], outline[i]]));
        }
        above
    }

    /// The number of a vertex, made if it is new.
    fn place(
        &mut self,
        known: &mut HashMap<(u32, u32), u32>,
        key: (u32, u32),
        vertex: impl FnOnce() -> Vertex,
    ) -> u32 {
        *known.entry(key).or_insert_with(|| {
            self.vertices.push(vertex());
            self.vertices.len() as u32 - 1
        })
    }
}
