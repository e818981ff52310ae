//! Slices of receivers by their distance from the light, and how near the way to the light's centre something matters to
//! those of a slice.

use glam::DVec3;
use shadowgraph_engine::math::Aabb;

use super::lists::{ListedEdge, SoftGrid};
use super::masks::MaskedTriangle;

/// Half an ulp of 1 in f32: what one rounding loses at most.
const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;
/// The eye's distance counts as the next power of this, so that lists are seldom made anew for it.
const EYE_STEP: f64 = 16.0;
/// Slices, at most: see `SoftHead` of soft_light.wgsl.
pub(super) const MAX_SLICES: usize = 8;

/// How far things are from the planes' origin, in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Distances {
    /// The eye, at most.
    pub(super) eye: f64,
    /// The light; 0 for a direction.
    pub(super) light: f64,
    /// What casts, at most.
    pub(super) casters: f64,
    /// What receives, at most.
    pub(super) receivers: f64,
}

/// How far the eye may be from the middle of `casters`, `least_m` at least, in few steps.
pub(super) fn eye_distance(eye: DVec3, casters: &Aabb, least_m: f64) -> f64 {
    let distance = casters.center().distance(eye).max(least_m).max(f64::MIN_POSITIVE);
    EYE_STEP.powf((distance.ln() / EYE_STEP.ln()).ceil())
}

/// A disc is at most this much larger than the light's radius for receivers no nearer than two radii: 2/√3. Nearer
/// receivers ask all triangles.
pub(super) const LARGEST_DISC: f64 = 1.154_700_538_379_252;

/// The radius of the disc that a sphere of `radius` is seen as from `distance` and beyond, but for receivers nearer than two radii.
fn disc_radius(radius: f64, distance: f64) -> f64 {
    let distance = distance.max(2.0 * radius);
    let tangent = distance * distance - radius * radius;
    if tangent > 0.0 { radius * distance / tangent.sqrt() * (1.0 + 1e-6) } else { radius * LARGEST_DISC }
}

impl Distances {
    /// What f32 loses of a receiver's place that is no further than `receivers` from the origin: of the eye's place twice,
    /// and of differences, products and turns on the way, each a few roundings.
    pub(super) fn lost(&self, receivers: f64) -> f64 {
        let receivers = receivers.min(self.receivers);
        HALF_ULP * (4.0 * self.eye + 32.0 * (receivers + self.casters))
    }
}

impl SoftGrid {
    /// Places the ends of slices: the last is where it is.
    pub(super) fn place_slices(&mut self, edges: &[ListedEdge], masked: &[MaskedTriangle]) {
        let Some(farthest) = self.slice_ends.last().copied() else { return };
        // What few edges are nearer than most is not worth slices.
        let of_edges = edges.iter().map(|edge| self.nearest(edge.ends));
        let of_masked = masked.iter().map(|masked| self.nearest_of_triangle(masked.triangle.corners));
        let mut nearest: Vec<f64> = of_edges.chain(of_masked).collect();
        let few = nearest.len() / 32;
        if nearest.is_empty() {
            return;
        }
        let nearest = *nearest.select_nth_unstable_by(few, f64::total_cmp).1;
        let place = |i: usize| (i + 1) as f64 / MAX_SLICES as f64;
        self.slice_ends = if self.light.position.w == 0.0 {
            (0..MAX_SLICES).map(|i| nearest + (farthest - nearest) * place(i)).collect()
        } else {
            // Evenly in 1/distance, as penumbrae grow.
            let nearest = nearest.max(farthest * 1e-2).max(f64::MIN_POSITIVE);
            let (near, far) = (nearest.recip(), farthest.max(f64::MIN_POSITIVE).recip());
            (0..MAX_SLICES).map(|i| (near + (far - near) * place(i)).recip()).collect()
        };
    }

    /// By how much of metres f32 may move something that is `nearest` to the light, as receivers in `slice` see it.
    pub(super) fn lost(&self, nearest: f64, slice: usize) -> f64 {
        let reach = if self.light.position.w == 0.0 {
            // What lies over the casters: at most so far aside, and so far along.
            let along =
                self.slice_ends.get(slice + 1).map_or(f64::INFINITY, |_| self.slice_ends[slice].abs());
            2.0 * self.distances.casters + along
        } else {
            // A receiver beyond is seen smaller, by as much as it is further away.
            1.5 * nearest + self.distances.light
        };
        self.distances.lost(reach)
    }

    /// How far from the way to the centre something may lie, which is at least `nearest` from it (along the planes'
    /// direction, for a directional light), to be met on the way of a receiver in `slice` to a sample; `None` when it
    /// lies beyond the slice.
    pub(super) fn reach(&self, nearest: f64, slice: usize) -> Option<f64> {
        let [from, end] = self.range(nearest, slice);
        let radius = self.light.radius;
        if self.light.position.w == 0.0 {
            let way = end - nearest;
            return (way >= 0.0).then_some(way * radius);
        }
        // From the slice's beginning the disc is largest. A share t from p to the sample, the way is t·radius aside and
        // (1 − t)·d along.
        let radius = disc_radius(radius / LARGEST_DISC, from);
        let along = (nearest * nearest - radius * radius).max(0.0).sqrt();
        (along <= end).then_some(radius * (1.0 - along / end))
    }

    /// How near and how far a receiver in `slice` may be that something `nearest` to the light matters to, in the terms of
    /// slices: never nearer than that.
    pub(super) fn range(&self, nearest: f64, slice: usize) -> [f64; 2] {
        let lost = self.distances.lost(f64::INFINITY);
        let moved = |end: f64, sign: f64| end * (1.0 + sign * 1e-6 * end.signum()) + sign * lost;
        let from = if slice == 0 { nearest } else { moved(self.slice_ends[slice - 1], -1.0).max(nearest) };
        [from - lost, moved(self.slice_ends[slice], 1.0)]
    }

    /// At which height over a plane the shader may not know the side that a receiver in `slice` is on: of its depth 48 ulps
    /// are left open, of positions 6e-7 of their distances, and as much again is for f32 to compute that.
    pub(super) fn unsure(&self, slice: usize) -> f64 {
        let Distances { eye, light, casters, receivers } = self.distances;
        let beyond =
            self.slice_ends[slice].abs() + if self.light.position.w == 0.0 { 2.0 * casters } else { light };
        let receivers = if slice + 1 == self.slice_ends.len() { receivers } else { receivers.min(beyond) };
        5.8e-6 * (eye + receivers)
            + 1.2e-6 * (2.0 * eye + receivers + casters)
            + self.distances.lost(receivers)
    }

    /// How near a segment comes to the light, in the terms of slices.
    pub(super) fn nearest(&self, [a, b]: [DVec3; 2]) -> f64 {
        if self.light.position.w == 0.0 {
            let plane = &self.planes[0];
            return (a - plane.origin).dot(plane.away).min((b - plane.origin).dot(plane.away));
        }
        self.light.distance_to_segment(a, b)
    }

    /// The same of a triangle.
    pub(super) fn nearest_of_triangle(&self, corners: [DVec3; 3]) -> f64 {
        let [a, b, c] = corners;
        if self.light.position.w == 0.0 {
            return self.nearest([a, b]).min(self.nearest([b, c]));
        }
        self.light.distance_to_triangle(corners)
    }

    /// How far a triangle may be from a light at most where it is nearest: as far as its nearest corner.
    pub(super) fn nearest_of(&self, corners: [DVec3; 3]) -> f64 {
        let light = self.light.position.truncate();
        corners.iter().map(|corner| corner.distance(light)).fold(f64::INFINITY, f64::min)
    }
}
