//! Which edges and triangles can matter to which receivers: lists for the cells of a grid the light's centre looks through.
//!
//! A receiver's point p lies in one cell, seen from the centre, and in one *slice*: between two distances from it (for a
//! directional light, along its direction). The way from p to any sample of the light stays within t·R of the way to the
//! centre, t from 0 at p to 1 at the light. So an edge at distance z is touched from within the slice up to distance d only
//! through cells about R·(1 − z/d) around its image: it is listed in these, and in no slice that ends before z. Triangles
//! between p and the centre are listed without that margin.
//!
//! *Nothing is lost.* All of it is f64 on the CPU, conservative, and enlarged by [`CELL_MARGIN`] of a cell and by what f32
//! loses when the shader finds p's cell and sees edges from p ([`SoftGrid::lost`]): that grows with how far the eye is, and
//! p. It does not grow with the light's distance, since planes have their origin among the casters. Whatever is listed in
//! vain changes nothing.

use glam::{DVec2, DVec3};
use shadowgraph_engine::geometry::{LightGrid, LightPlane};
use shadowgraph_engine::math::Aabb;

use super::chain::LightBall;

/// By how much of a cell footprints are enlarged on every side.
const CELL_MARGIN: f64 = 0.01;
/// Half an ulp of 1 in f32: what one rounding loses at most.
const HALF_ULP: f64 = 1.0 / (1 << 24) as f64;
/// The eye's distance counts as the next power of this, so that lists are seldom made anew for it.
const EYE_STEP: f64 = 16.0;
/// Slices, at most: see `SoftHead` of soft_light.wgsl.
pub(super) const MAX_SLICES: usize = 8;
/// The most cells along a side, for edges and for triangles.
const FINEST: usize = 256;
const FINEST_OF_TRIANGLES: usize = 512;
/// Words of lists, of edges and of triangles: as many as these, or as many for each edge and triangle; below what every adapter can bind.
const LEAST_WORDS: usize = 1 << 20;
const WORDS_PER_PRIMITIVE: usize = 64;
const MOST_WORDS: usize = 1 << 24;

/// What the light's centre looks through, and how far.
#[derive(Clone, Debug)]
pub(super) struct SoftGrid {
    /// The light.
    pub light: LightBall,
    /// One plane, or six.
    pub planes: Vec<LightPlane>,
    /// Cells along a side of each, for edges.
    pub side: usize,
    /// Cells along a side of each, for triangles, which are not told apart by slices.
    pub triangle_side: usize,
    /// Where slices end: distances from the centre, or along the light's direction from the planes' origin; ascending.
    /// Receivers beyond the last are in the last.
    pub slice_ends: Vec<f64>,
    /// What goes into [`SoftGrid::lost`].
    distances: Distances,
}

/// How far things are from the planes' origin, in metres.
#[derive(Clone, Copy, Debug)]
struct Distances {
    /// The eye, at most.
    eye: f64,
    /// The light; 0 for a direction.
    light: f64,
    /// What casts, at most.
    casters: f64,
    /// What receives, at most.
    receivers: f64,
}

/// How far the eye may be from the middle of `casters`, in few steps.
pub(super) fn eye_distance(eye: DVec3, casters: &Aabb) -> f64 {
    let distance = casters.center().distance(eye).max(f64::MIN_POSITIVE);
    EYE_STEP.powf((distance.ln() / EYE_STEP.ln()).ceil())
}

/// The cells of one plane and slice that something may be touched through.
struct Footprint {
    from: DVec2,
    to: DVec2,
    /// In cells.
    reach: f64,
}

impl Distances {
    /// What f32 loses of a receiver's place that is no further than `receivers` from the origin: of the eye's place twice,
    /// and of differences, products and turns on the way, each a few roundings.
    fn lost(&self, receivers: f64) -> f64 {
        let receivers = receivers.min(self.receivers);
        HALF_ULP * (4.0 * self.eye + 32.0 * (receivers + self.casters))
    }
}

impl SoftGrid {
    /// A grid for casters within `casters` and receivers within `receivers`, and an eye no further than `eye_m` from the
    /// middle of the casters.
    pub(super) fn new(light: LightBall, casters: &Aabb, receivers: &Aabb, eye_m: f64) -> Self {
        let directional = light.position.w == 0.0;
        let towards = light.position.truncate();
        let along = |bounds: &Aabb| {
            let extent = (bounds.max - bounds.min).dot(towards.abs()) * 0.5;
            let middle = -towards.dot(bounds.center());
            (middle - extent, middle + extent)
        };
        let (nearest, farthest, reach) = if directional {
            let (nearest, farthest) = (along(casters).0, along(receivers).1.max(along(casters).1));
            (nearest, farthest, (farthest - nearest) * light.radius)
        } else {
            let far = |bounds: &Aabb| {
                bounds.corners().map(|corner| corner.distance(towards)).into_iter().fold(0.0, f64::max)
            };
            (casters.distance(towards), far(receivers).max(far(casters)), light.radius)
        };
        let from_middle = |bounds: &Aabb| {
            let middle = casters.center();
            bounds.corners().map(|corner| corner.distance(middle)).into_iter().fold(0.0, f64::max)
        };
        let mut distances = Distances {
            eye: eye_m,
            light: if directional { 0.0 } else { towards.distance(casters.center()) },
            casters: casters.radius(),
            receivers: if receivers.is_empty() { 0.0 } else { from_middle(receivers) },
        };
        let margin = reach * (1.0 + 1e-6) + distances.lost(f64::INFINITY);
        let mut planes = LightGrid::new(light.position, &casters.expanded(margin)).planes().to_vec();
        match planes.as_mut_slice() {
            // From a far light's place f32 would not tell casters apart: their middle is on the plane's axis too.
            [plane] if !directional => {
                plane.z_offset = (casters.center() - plane.origin).dot(plane.z_axis);
                plane.origin = casters.center();
            }
            [_] => {}
            // All of it from the light, which stands among the casters.
            _ => {
                distances.eye += distances.light;
                distances.receivers += distances.light;
                distances.casters += distances.light;
            }
        }
        let farthest = farthest + 1e-6 * (farthest.abs() + nearest.abs());
        let slice_ends = if directional {
            let from_origin = -planes[0].away.dot(planes[0].origin);
            let place = |i: usize| nearest + (farthest - nearest) * (i + 1) as f64 / MAX_SLICES as f64;
            (0..MAX_SLICES).map(|i| place(i) + from_origin).collect()
        } else {
            // Evenly in 1/distance, as penumbrae grow.
            let (near, far) = (
                1.0 / nearest.max(farthest * 1e-2).max(f64::MIN_POSITIVE),
                1.0 / farthest.max(f64::MIN_POSITIVE),
            );
            let place = |i: usize| 1.0 / (near + (far - near) * (i + 1) as f64 / MAX_SLICES as f64);
            (0..MAX_SLICES).map(place).collect()
        };
        Self { light, planes, side: 1, triangle_side: 1, slice_ends, distances }
    }

    /// By how much of metres f32 may move something that is `nearest` to the light, as receivers in `slice` see it.
    fn lost(&self, nearest: f64, slice: usize) -> f64 {
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

    /// How many lists of edges there are.
    pub(super) fn edge_lists(&self) -> usize {
        self.planes.len() * self.slice_ends.len() * self.side * self.side
    }

    /// How many lists of triangles there are.
    fn triangle_lists(&self) -> usize {
        self.planes.len() * self.triangle_side * self.triangle_side
    }

    /// How far from the way to the centre something may lie, which is at least `nearest` from it (along the planes'
    /// direction, for a directional light), to be met on the way of a receiver in `slice` to a sample; `None` when it
    /// lies beyond the slice.
    fn reach(&self, nearest: f64, slice: usize) -> Option<f64> {
        let end = self.slice_ends[slice];
        let end = end * (1.0 + 1e-6 * end.signum()) + self.distances.lost(f64::INFINITY);
        let radius = self.light.radius;
        if self.light.position.w == 0.0 {
            let way = end - nearest;
            return (way >= 0.0).then_some(way * radius);
        }
        let whole = end.hypot(radius);
        let rest = (nearest - radius).max(0.0);
        (rest <= whole).then_some(radius * (1.0 - rest / whole))
    }

    /// How near a segment comes to the light, in the terms of slices.
    fn nearest(&self, [a, b]: [DVec3; 2]) -> f64 {
        if self.light.position.w == 0.0 {
            let plane = &self.planes[0];
            return (a - plane.origin).dot(plane.away).min((b - plane.origin).dot(plane.away));
        }
        self.light.distance_to_segment(a, b)
    }

    /// How far a triangle may be from a light at most where it is nearest: as far as its nearest corner.
    fn nearest_of(&self, corners: [DVec3; 3]) -> f64 {
        let light = self.light.position.truncate();
        corners.iter().map(|corner| corner.distance(light)).fold(f64::INFINITY, f64::min)
    }

    /// Calls `visit` with plane, slice, column and row of every cell that a receiver may touch the edge through.
    fn edge_cells(&self, ends: [DVec3; 2], visit: &mut impl FnMut(usize)) {
        let nearest = self.nearest(ends);
        for slice in 0..self.slice_ends.len() {
            let Some(reach_m) = self.reach(nearest, slice) else { continue };
            let reach_m = reach_m + self.lost(nearest, slice);
            for (number, plane) in self.planes.iter().enumerate() {
                let Some(footprint) = self.footprint(plane, ends, reach_m) else { continue };
                self.cells_about(&footprint, |x, y| visit(self.cell(number, slice, x, y)));
            }
        }
    }

    fn cell(&self, plane: usize, slice: usize, x: usize, y: usize) -> usize {
        ((plane * self.slice_ends.len() + slice) * self.side + y) * self.side + x
    }

    /// The image of a segment on a plane with `reach_m` around it; `None` when it is not in view.
    fn footprint(&self, plane: &LightPlane, ends: [DVec3; 2], reach_m: f64) -> Option<Footprint> {
        let everything = Footprint { from: DVec2::ZERO, to: DVec2::ZERO, reach: f64::INFINITY };
        let seen = |p: DVec3| {
            let d = p - plane.origin;
            DVec3::new(d.dot(plane.x_axis), d.dot(plane.y_axis), d.dot(plane.z_axis) + plane.z_offset)
        };
        let [mut from, mut to] = ends.map(seen);
        if plane.one_of_six {
            // What is beyond one side of the pyramid |x|, |y| ≤ z by more than the reach.
            let beyond =
                reach_m * std::f64::consts::SQRT_2 * (1.0 + 1e-6) + 1e-9 * (from.length() + to.length());
            for outside in [
                DVec3::new(1.0, 0.0, -1.0),
                DVec3::new(-1.0, 0.0, -1.0),
                DVec3::new(0.0, 1.0, -1.0),
                DVec3::new(0.0, -1.0, -1.0),
            ] {
                (from, to) = clipped(from, to, outside, beyond)?;
            }
        }
        let (x_length, y_length) = (plane.x_axis.length(), plane.y_axis.length());
        let reach_z = reach_m * plane.z_axis.length();
        let depth = from.z.min(to.z) - reach_z;
        if depth <= 1e-3 * (from.z.max(to.z) + reach_z) {
            return Some(everything);
        }
        let widest = |across: f64, length: f64| (across + length * reach_m) / depth;
        let x_widest = widest(from.x.abs().max(to.x.abs()), x_length) * plane.z_axis.length();
        let y_widest = widest(from.y.abs().max(to.y.abs()), y_length) * plane.z_axis.length();
        let reach = reach_m * x_length.hypot(x_widest).max(y_length.hypot(y_widest)) / depth;
        let in_cells = |h: DVec3| (h.truncate() / h.z * 0.5 + 0.5) * self.side as f64;
        Some(Footprint {
            from: in_cells(from),
            to: in_cells(to),
            reach: reach * 0.5 * self.side as f64 + CELL_MARGIN,
        })
    }

    /// Calls `visit` with column and row of the cells within reach of the footprint.
    fn cells_about(&self, footprint: &Footprint, mut visit: impl FnMut(usize, usize)) {
        let Footprint { from, to, reach } = *footprint;
        let last = self.side as f64 - 1.0;
        if !(reach.is_finite() && from.is_finite() && to.is_finite()) {
            (0..self.side * self.side).for_each(|i| visit(i % self.side, i / self.side));
            return;
        }
        let low = (from.min(to) - reach).floor().clamp(DVec2::ZERO, DVec2::splat(last));
        let high = (from.max(to) + reach).floor();
        if high.x < 0.0 || high.y < 0.0 || (from.min(to) - reach).max_element() > last + 1.0 {
            return;
        }
        let high = high.clamp(DVec2::ZERO, DVec2::splat(last));
        let along = to - from;
        let length_squared = along.length_squared();
        // A cell's corner is this far from its middle.
        let within = reach + std::f64::consts::FRAC_1_SQRT_2;
        for y in low.y as usize..=high.y as usize {
            for x in low.x as usize..=high.x as usize {
                let to_middle = DVec2::new(x as f64 + 0.5, y as f64 + 0.5) - from;
                let t = if length_squared > 0.0 {
                    (to_middle.dot(along) / length_squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                if (to_middle - along * t).length_squared() <= within * within {
                    visit(x, y);
                }
            }
        }
    }

    /// The grid with the smallest cells that the memory for lists allows, and the lists over it: for each list of
    /// edges where it begins, and where the last one ends; the same for triangles; then the lists of numbers:
    /// edges in their order, triangles by those given. At last how many edges, and how many triangles, the longest list has.
    pub(super) fn lists(
        mut self,
        edges: &[[DVec3; 2]],
        triangles: &[(u32, [DVec3; 3])],
    ) -> (Self, Vec<u32>, [usize; 2]) {
        let budget = |primitives: usize| (primitives * WORDS_PER_PRIMITIVE).clamp(LEAST_WORDS, MOST_WORDS);
        let mut edge_counts = self.edge_counts(edges);
        while self.side < FINEST {
            let finer = Self { side: self.side * 2, ..self.clone() };
            if finer.edge_lists() > budget(edges.len()) {
                break;
            }
            let counts = finer.edge_counts(edges);
            if sum(&counts) + counts.len() > budget(edges.len()) {
                break;
            }
            (self, edge_counts) = (finer, counts);
        }
        let mut triangle_counts = self.triangle_counts(triangles);
        while self.triangle_side < FINEST_OF_TRIANGLES {
            let finer = Self { triangle_side: self.triangle_side * 2, ..self.clone() };
            if finer.triangle_lists() > budget(triangles.len()) {
                break;
            }
            let counts = finer.triangle_counts(triangles);
            if sum(&counts) + counts.len() > budget(triangles.len()) {
                break;
            }
            (self, triangle_counts) = (finer, counts);
        }
        let mut words = Vec::new();
        let mut place = (edge_counts.len() + triangle_counts.len() + 2) as u32;
        for counts in [&edge_counts, &triangle_counts] {
            for count in counts {
                words.push(place);
                place += count;
            }
            words.push(place);
        }
        let mut next = words.clone();
        words.resize(place as usize, 0);
        let mut put = |list: usize, number: u32| {
            words[next[list] as usize] = number;
            next[list] += 1;
        };
        for (number, ends) in (0..).zip(edges) {
            self.edge_cells(*ends, &mut |cell| put(cell, number));
        }
        for (number, corners) in triangles {
            self.triangle_cells(*corners, &mut |cell| put(edge_counts.len() + 1 + cell, *number));
        }
        let longest = [&edge_counts, &triangle_counts]
            .map(|counts| counts.iter().max().copied().unwrap_or_default() as usize);
        (self, words, longest)
    }

    fn edge_counts(&self, edges: &[[DVec3; 2]]) -> Vec<u32> {
        let mut counts = vec![0_u32; self.edge_lists()];
        edges.iter().for_each(|ends| self.edge_cells(*ends, &mut |cell| counts[cell] += 1));
        counts
    }

    fn triangle_counts(&self, triangles: &[(u32, [DVec3; 3])]) -> Vec<u32> {
        let mut counts = vec![0_u32; self.triangle_lists()];
        triangles
            .iter()
            .for_each(|(_, corners)| self.triangle_cells(*corners, &mut |cell| counts[cell] += 1));
        counts
    }

    /// Calls `visit` with every list whose receivers may have the triangle before the light's centre.
    fn triangle_cells(&self, corners: [DVec3; 3], visit: &mut impl FnMut(usize)) {
        let side = self.triangle_side;
        let grid = LightGrid::from_planes(&self.planes, side);
        // The last slice holds those that lose most.
        let lost = self.lost(self.nearest_of(corners), self.slice_ends.len() - 1);
        for number in 0..self.planes.len() {
            grid.for_each_cell_within(number, corners, CELL_MARGIN, lost, |[x, y]| {
                visit((number * side + y) * side + x);
            });
        }
    }
}

fn sum(counts: &[u32]) -> usize {
    counts.iter().map(|count| *count as usize).sum()
}

/// The part of a segment where outside·h ≤ `beyond`; `None` when there is none.
fn clipped(from: DVec3, to: DVec3, outside: DVec3, beyond: f64) -> Option<(DVec3, DVec3)> {
    let (at_from, at_to) = (outside.dot(from) - beyond, outside.dot(to) - beyond);
    match (at_from > 0.0, at_to > 0.0) {
        (true, true) => None,
        (false, false) => Some((from, to)),
        (true, false) => Some((from.lerp(to, at_from / (at_from - at_to)), to)),
        (false, true) => Some((from, from.lerp(to, at_from / (at_from - at_to)))),
    }
}
