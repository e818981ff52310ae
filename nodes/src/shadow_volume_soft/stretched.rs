//! Casters that reach much further than what the eye has before it: roads, cables, rows of a terrain.
//!
//! Records are relative to the middle of their caster, in f32. Over a road of 50 km that leaves millimetres, and planes, whose
//! normals are rounded too, are off by as much a long way from their offset. Such casters have their records relative to a
//! place near the eye instead ([`Stretched::center`]), in steps, so that they are seldom made anew; and their long edges are cut
//! about that place, at distances that grow fourfold: what passes near the eye then ends near it, and keeps its digits.
//!
//! *Why cutting is exact.* Parts of an edge have the edge's triangles; parts of a triangle have its plane, so the edges between
//! them weigh nothing. Cuts are points in f64, the same for all triangles of an edge.

use glam::DVec3;
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{LightContext, hash_of};

/// Casters within so many near distances of the eye keep enough digits as they are.
const FAR_REACHING: f64 = 1280.0;
/// Only casters with edges as long as this share of their radius are stretched; terrains of many small cells are not.
const LONG_EDGE: f64 = 0.125;
/// Steps of the records' centre, in shares of the caster's radius.
const STEP: f64 = 1.0 / 256.0;
/// The distances of cuts grow by this.
const GROWTH: f64 = 4.0;

/// About which place a stretched caster is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretched {
    /// What records are relative to, in the world.
    pub center: DVec3,
    /// The distance of the first cut from there, in metres.
    first_cut_m: f64,
}

impl Stretched {
    /// `None` for casters whose middle will do.
    pub(super) fn of(light: &LightContext<'_>, instance: &Instance) -> Option<Self> {
        let camera = &light.view.camera;
        let (bounds, eye) = (instance.world_bounds, camera.world_from_view.translation);
        let radius_m = bounds.radius();
        // Orthographic depths are coarser than all that.
        if light.view.frustum.eye.w == 0.0 || radius_m < FAR_REACHING * camera.projection.near_m() {
            return None;
        }
        let key = hash_of(("longest edge", instance.pose_key));
        let longest_m = *light.cache.get_or_compute("longest edge", key, || longest_edge(instance));
        (longest_m > LONG_EDGE * radius_m).then(|| Self::about(&bounds, eye))
    }

    /// About the place within `bounds` that is next to `eye`, but for steps.
    fn about(bounds: &Aabb, eye: DVec3) -> Self {
        let step_m = bounds.radius() * STEP;
        let nearest = eye.clamp(bounds.min, bounds.max);
        Self { center: (nearest / step_m).round() * step_m, first_cut_m: step_m }
    }

    /// The points between `p` and `q` at which their edge is cut, from `p` to `q`.
    pub(super) fn cuts(&self, p: DVec3, q: DVec3) -> Vec<DVec3> {
        let along = q - p;
        let length_m = along.length();
        if length_m <= self.first_cut_m {
            return vec![];
        }
        let foot_m = (self.center - p).dot(along) / length_m;
        let beside_m = (p + along * (foot_m / length_m)).distance(self.center);
        let mut places = Vec::new();
        let mut reach_m = self.first_cut_m.max(beside_m);
        while reach_m < foot_m.abs() + length_m {
            places.extend([foot_m - reach_m, foot_m + reach_m]);
            reach_m *= GROWTH;
        }
        places.retain(|place| (1e-6 * length_m..(1.0 - 1e-6) * length_m).contains(place));
        places.sort_by(f64::total_cmp);
        places.into_iter().map(|place| p + along * (place / length_m)).collect()
    }

    /// The corners of a triangle's outline with its cuts. `vertices` are the corners' numbers, by which all triangles of an
    /// edge cut it the same way.
    fn outline(&self, corners: [DVec3; 3], vertices: [u32; 3]) -> Vec<DVec3> {
        let mut outline = Vec::new();
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            outline.push(corners[i]);
            if vertices[i] < vertices[j] {
                outline.extend(self.cuts(corners[i], corners[j]));
            } else {
                outline.extend(self.cuts(corners[j], corners[i]).into_iter().rev());
            }
        }
        outline
    }

    /// The triangles that a triangle is cut into: a fan. Those without an area fill the places where edges would gape.
    pub(super) fn parts(&self, corners: [DVec3; 3], vertices: [u32; 3]) -> Vec<[DVec3; 3]> {
        let outline = self.outline(corners, vertices);
        outline[1..].windows(2).map(|pair| [outline[0], pair[0], pair[1]]).collect()
    }
}

fn longest_edge(instance: &Instance) -> f64 {
    let lengths = (0..instance.mesh.triangle_count()).map(|triangle| {
        let [a, b, c] = instance.world_triangle(triangle);
        a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a))
    });
    lengths.fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_road_is_cut_about_the_eye_and_no_part_is_lost() {
        let bounds = Aabb { min: DVec3::new(-2e4, 0.0, -1.0), max: DVec3::new(3e4, 0.3, 1.0) };
        let road = Stretched::about(&bounds, DVec3::new(700.0, 2.0, 5.0));
        assert!(road.center.distance(DVec3::new(700.0, 0.3, 1.0)) < 200.0, "{}", road.center);
        let [a, b, c] = [bounds.min, bounds.max, DVec3::new(-2e4, 0.3, 1.0)];
        let cuts = road.cuts(a, b);
        assert!((6..40).contains(&cuts.len()), "{}", cuts.len());
        let along: Vec<f64> = cuts.iter().map(|p| (*p - a).dot(b - a)).collect();
        assert!(along.is_sorted() && cuts.iter().all(|p| (*p - a).cross(b - a).length() < 1e-3));
        // The same cuts whichever way a triangle runs along the edge.
        let parts = road.parts([a, b, c], [0, 1, 2]);
        let turned = road.parts([b, a, c], [1, 0, 2]);
        let area =
            |parts: &[[DVec3; 3]]| -> DVec3 { parts.iter().map(|[a, b, c]| (b - a).cross(c - a)).sum() };
        let whole = (b - a).cross(c - a);
        assert!((area(&parts) - whole).length() < 1e-9 * whole.length());
        assert!((area(&turned) + whole).length() < 1e-9 * whole.length());
        assert!(
            parts.iter().flatten().all(|p| [a, b, c].contains(p) || turned.iter().flatten().any(|q| q == p))
        );
        assert!(road.cuts(road.center, road.center + DVec3::X).is_empty(), "short edges stay");
    }
}
