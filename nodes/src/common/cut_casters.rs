//! Casters with triangles larger than what a view shows of them, a floor under a lamp say: cut to the view in f64.
//!
//! A rasteriser cuts what reaches far beyond its target, in f32. Of the slivers that this leaves, depth and its slope are
//! off by many roundings, and a floor would shadow itself along them. And f32 loses of every position a share of the caster's size,
//! which may be all that a small thing on a large one throws. What is cut here has corners within the view, and each of
//! its triangles brings the plane that it lies in, by which depth is written.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec4};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{LightContext, hash_of};

use super::light_views::{Depth, LightView};
use super::ray_candidates::Layout;
use crate::layout;

/// `struct CutCorner` of shadow_map_casters.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct CutCorner {
    pub clip: [f32; 4],
    pub slope: [f32; 2],
    pub depth: f32,
    pub half_texels: f32,
}

/// The structure of shadow_map_casters.wgsl as it is here: what the layout test compares.
pub fn cut_layout() -> (&'static str, Layout) {
    ("CutCorner", layout!(CutCorner: clip, slope, depth, half_texels))
}

/// Triangles of this share of a view's window and more are cut; rasterisers leave alone what is within twice the window.
const LARGE: f64 = 0.4;
/// How many times as large something beside a perspective view's axis is seen.
const BESIDE_AXIS: f64 = 3.0;
/// Triangles are cut a little beyond the window.
const BEYOND: f64 = 1.01;

/// Whether a caster with an edge of this length within `bounds` has triangles so large in a view that they have to be cut.
pub fn is_large(longest_edge_m: f64, bounds: &Aabb, view: &LightView) -> bool {
    let [low, high] = view.window;
    let side = (high - low).min_element();
    match view.depth {
        Depth::Orthographic { .. } => longest_edge_m > LARGE * side,
        Depth::Perspective { .. } => {
            BESIDE_AXIS * longest_edge_m > LARGE * side * bounds.distance(view.origin)
        }
    }
}

/// How high an instance reaches within an orthographic view, along it: what its triangles do, where its box may be higher.
pub fn top_m(light: &LightContext<'_>, instance: &Instance, view: &LightView) -> Option<f64> {
    let Depth::Orthographic { end_m, range_m } = view.depth else { return None };
    let key = hash_of((instance.pose_key, view.bits()));
    Some(*light.cache.get_or_compute("top in a view", key, || {
        let clip_from_light = view.clip_from_light();
        let outlines = (0..instance.mesh.triangle_count()).flat_map(|triangle| {
            let corners = instance.world_triangle(triangle);
            outline_of(corners.map(|corner| clip_from_light * view.light_from(corner).extend(1.0)))
        });
        end_m + range_m * outlines.map(|corner| corner.z).fold(f64::NEG_INFINITY, f64::max)
    }))
}

/// The longest edge of all triangles.
pub fn longest_edge_m(instance: &Instance) -> f64 {
    let edges = (0..instance.mesh.triangle_count()).flat_map(|triangle| {
        let [a, b, c] = instance.world_triangle(triangle);
        [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)]
    });
    edges.fold(0.0, f64::max).sqrt()
}

/// What a view with so many texels shows of these triangles of a caster: three corners for each piece.
pub fn pieces_in(view: &LightView, texels: u32, instance: &Instance, triangles: &[u32]) -> Vec<CutCorner> {
    let clip_from_light = view.clip_from_light();
    let planes_from_light = clip_from_light.inverse().transpose();
    let mut pieces = Vec::new();
    for triangle in triangles {
        let corners = instance.world_triangle(*triangle as usize).map(|corner| view.light_from(corner));
        let outline = outline_of(corners.map(|corner| clip_from_light * corner.extend(1.0)));
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a);
        // a·x + b·y + c·depth + d = 0.
        let plane = planes_from_light * normal.extend(-normal.dot(a));
        if outline.len() < 3 || plane.z == 0.0 {
            continue;
        }
        let half_texels = 0.5 * f64::from(texels);
        let slope = DVec2::new(-plane.x, plane.y) / (plane.z * half_texels);
        let corner = |clip: DVec4| CutCorner {
            clip: clip.as_vec4().to_array(),
            slope: slope.as_vec2().to_array(),
            depth: (-plane.w / plane.z) as f32,
            half_texels: half_texels as f32,
        };
        for pair in outline[1..].windows(2) {
            pieces.extend([outline[0], pair[0], pair[1]].map(corner));
        }
    }
    pieces
}

/// What of a triangle in clip space is in the window and beyond the near plane: its corners in order.
fn outline_of(corners: [DVec4; 3]) -> Vec<DVec4> {
    let sides = [
        DVec4::new(1.0, 0.0, 0.0, BEYOND),
        DVec4::new(-1.0, 0.0, 0.0, BEYOND),
        DVec4::new(0.0, 1.0, 0.0, BEYOND),
        DVec4::new(0.0, -1.0, 0.0, BEYOND),
        DVec4::new(0.0, 0.0, -1.0, 1.0),
        DVec4::W,
    ];
    cut_outline(corners.to_vec(), &sides)
}

/// The corners, in order, of what of a polygon in clip space is on the positive side of all these planes.
pub fn cut_outline(mut outline: Vec<DVec4>, sides: &[DVec4]) -> Vec<DVec4> {
    for side in sides {
        let ends = outline.iter().zip(outline.iter().cycle().skip(1));
        let kept = ends.flat_map(|(a, b)| {
            let (at_a, at_b) = (side.dot(*a), side.dot(*b));
            let crossing = (at_a * at_b < 0.0).then(|| *a + (*b - *a) * (at_a / (at_a - at_b)));
            (at_a >= 0.0).then_some(*a).into_iter().chain(crossing)
        });
        outline = kept.collect();
    }
    outline
}
