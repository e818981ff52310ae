//! The silhouettes of casters as a view of the light has them: edges in texels, cut at the view's borders.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::{DAffine3, DVec2, DVec3, DVec4};
use shadowgraph_engine::geometry::Chain;
use shadowgraph_engine::plan::{BufferDesc, Resource};
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{LightContext, PassList, hash_of};

use crate::common::facing::CasterFacing;
use crate::common::light_views::LightView;
use crate::common::map_casters::MapCaster;
use crate::common::ray_candidates::Layout;
use crate::common::volume::{CastShape, Half};
use crate::layout;

/// `struct Edge` of silhouette_points.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct SilhouetteEdge {
    pub a: [f32; 2],
    pub b: [f32; 2],
    pub depth_a: f32,
    pub depth_b: f32,
    pub pad_0: u32,
    pub pad_1: u32,
}

/// The structure of silhouette_points.wgsl as it is here: what the layout test compares.
pub fn layout() -> (&'static str, Layout) {
    ("Edge", layout!(SilhouetteEdge: a, b, depth_a, depth_b, pad_0, pad_1))
}

/// Texels beyond the map in which an edge may still touch something.
const BEYOND: f64 = 3.0;

/// The edges of all `casters` in one view, and how many there are; `key` says what the view and its casters are.
pub(super) fn edges_in(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    casters: &[MapCaster<'_>],
    (view, texels): (&LightView, u32),
    key: u64,
) -> Option<(Resource, u32)> {
    let bytes = light.cache.get_or_compute("silhouettes in a view", key, || {
        let mut edges: Vec<SilhouetteEdge> = Vec::new();
        for caster in casters.iter().filter(|caster| view.may_show(&caster.instance.world_bounds)) {
            let silhouettes = silhouettes_of(light, caster.instance);
            edges.extend(silhouettes.iter().filter_map(|edge| in_texels(view, texels, *edge)));
        }
        cast_slice(&edges).to_vec()
    });
    let count = (bytes.len() / size_of::<SilhouetteEdge>()) as u32;
    let reason = format!("{count} edges at which what the light sees of a caster ends");
    let label = format!("silhouettes of {}", light.light().name);
    let desc = BufferDesc::storage(&label, hash_of(("silhouettes", key)), Arc::clone(&bytes), &reason);
    (count > 0).then(|| (out.buffer(desc), count))
}

/// The edges of a caster between what faces the light and what does not, and those that end it, in the world.
fn silhouettes_of(light: &LightContext<'_>, instance: &Instance) -> Arc<Vec<[DVec3; 2]>> {
    let position = light.light().position;
    let whole: Vec<bool> = instance.materials.iter().map(|material| material.casts_whole()).collect();
    let key = hash_of((instance.pose_key, position.to_array().map(f64::to_bits), whole));
    light.cache.get_or_compute("silhouettes", key, || {
        let topology = instance.mesh.topology();
        let facing = CasterFacing::new(light, instance, &CastShape::Own(topology), Half::Both);
        let mut sides = Chain::extract(topology, &facing.signs).sides;
        // Edges of more weight are listed as often in a row.
        sides.dedup();
        sides.into_iter().map(|side| side.map(|vertex| facing.p_in_world[vertex as usize])).collect()
    })
}

/// An edge in the texels of silhouettes, whose corners are the middles of those of depth; cut at the near plane and a little
/// beyond the map. `None` where nothing is left.
fn in_texels(view: &LightView, texels: u32, edge: [DVec3; 2]) -> Option<SilhouetteEdge> {
    let map_from_world = view.map_from_local(&DAffine3::IDENTITY, texels);
    let [a, b] = edge.map(|p| map_from_world * p.extend(1.0));
    // Before the near plane depth would be more than 1.
    let height = |p: DVec4| p.w - p.z;
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let cut = |at_a: f64, at_b: f64, from: &mut f64, to: &mut f64| {
        if at_a < 0.0 && at_b < 0.0 {
            return false;
        }
        let crossing = at_a / (at_a - at_b);
        if at_a < 0.0 {
            *from = from.max(crossing);
        } else if at_b < 0.0 {
            *to = to.min(crossing);
        }
        *from <= *to
    };
    if !cut(height(a), height(b), &mut from, &mut to) || a.w.max(b.w) <= 0.0 {
        return None;
    }
    let end = f64::from(texels) + BEYOND;
    for (at_a, at_b) in [
        (a.x + BEYOND * a.w, b.x + BEYOND * b.w),
        (end * a.w - a.x, end * b.w - b.x),
        (a.y + BEYOND * a.w, b.y + BEYOND * b.w),
        (end * a.w - a.y, end * b.w - b.y),
    ] {
        if !cut(at_a, at_b, &mut from, &mut to) {
            return None;
        }
    }
    let place = |t: f64| {
        let p = a + (b - a) * t;
        ((p.truncate() / p.w).truncate() - DVec2::splat(0.5), p.z / p.w)
    };
    let ((a, depth_a), (b, depth_b)) = (place(from), place(to));
    let short = |p: DVec2| p.as_vec2().to_array();
    let edge = SilhouetteEdge { a: short(a), b: short(b), ..SilhouetteEdge::default() };
    Some(SilhouetteEdge { depth_a: depth_a as f32, depth_b: depth_b as f32, ..edge })
}
