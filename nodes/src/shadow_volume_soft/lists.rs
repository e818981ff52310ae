//! Which edges and triangles can matter to which receivers: lists for the cells of a grid the light's centre looks through.
//!
//! A receiver's point p lies in one cell, seen from the centre, and in one *slice*: between two distances from it (for a
//! directional light, along its direction). The way from p to any sample of the light stays within t·R of the way to the
//! centre, t from 0 at p to 1 at the light. So an edge at distance z is touched from within the slice up to distance d only
//! through cells about R·(1 − z/d) around its image: it is listed in these, and in no slice that ends before z; and in no
//! cell from all of which it is no silhouette, see `sides`. Triangles between p and the centre are listed without that margin.
//!
//! *Nothing is lost.* All of it is f64 on the CPU, conservative, and enlarged by [`CELL_MARGIN`] of a cell and by what f32
//! loses when the shader finds p's cell and sees edges from p ([`Distances::lost`]): that grows with how far the eye is, and
//! p. It does not grow with the light's distance, since planes have their origin among the casters. Whatever is listed in
//! vain changes nothing.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use shadowgraph_engine::geometry::{LightGrid, LightPlane};
use shadowgraph_engine::math::Aabb;

use super::chain::{LightBall, SoftEdge};
use super::silhouette_culling::{EdgeSides, Piece};
use super::slices::Distances;

/// By how much of a cell footprints are enlarged on every side.
pub(super) const CELL_MARGIN: f64 = 0.01;
/// The most cells along a side, for edges and for triangles.
const FINEST: usize = 256;
const FINEST_OF_TRIANGLES: usize = 512;
/// The most words of lists, for edges and for triangles each: so many for each of them, but no fewer than the least and no more than
/// the most, which every adapter can bind.
pub(super) const LEAST_WORDS: usize = 1 << 21;
const WORDS_PER_PRIMITIVE: usize = 64;
pub(super) const MOST_WORDS: usize = 1 << 24;
/// How many edges, or triangles, are sampled to estimate the words that all of them take.
pub(super) const SOME: usize = 256;

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
    pub(super) distances: Distances,
}

/// An edge that may be a silhouette.
#[derive(Clone, Copy, Debug)]
pub(super) struct ListedEdge {
    /// Its ends in the world.
    pub ends: [DVec3; 2],
    /// What the shader reads of it, and the middle of its caster.
    pub record: SoftEdge,
    /// The middle of its caster.
    pub center: DVec3,
}

/// The cells of one plane and slice that something may be touched through.
struct Footprint {
    from: DVec2,
    to: DVec2,
    /// In cells.
    reach: f64,
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
        let from_origin = if directional { -planes[0].away.dot(planes[0].origin) } else { 0.0 };
        let slice_ends = vec![farthest + from_origin];
        Self { light, planes, side: 1, triangle_side: 1, slice_ends, distances }
    }

    /// How many lists of edges there are.
    pub(super) fn edge_lists(&self) -> usize {
        self.planes.len() * self.slice_ends.len() * self.side * self.side
    }

    /// How many lists of triangles there are.
    fn triangle_lists(&self) -> usize {
        self.planes.len() * self.triangle_side * self.triangle_side
    }

    /// Calls `visit` with every list whose receivers may touch the edge on their way to the light, where it may be a silhouette.
    fn edge_cells(&self, edge: &ListedEdge, visit: &mut dyn FnMut(usize)) {
        let nearest = self.nearest(edge.ends);
        let half = (1.0 + 2.0 * CELL_MARGIN) / self.side as f64;
        for (number, plane) in self.planes.iter().enumerate() {
            let sides = EdgeSides::new(&edge.record, edge.center, plane);
            let lengths = [plane.x_axis.length(), plane.y_axis.length()];
            let across = DVec2::from(lengths).recip();
            let ends = edge.ends.map(|p| {
                let d = p - plane.origin;
                DVec3::new(d.dot(plane.x_axis), d.dot(plane.y_axis), d.dot(plane.z_axis) + plane.z_offset)
            });
            for slice in 0..self.slice_ends.len() {
                let Some(reach_m) = self.reach(nearest, slice) else { continue };
                let reach_m = reach_m + self.lost(nearest, slice);
                let Some(footprint) = self.footprint((plane, lengths), ends, reach_m) else { continue };
                let (range, unsure) = (self.range(nearest, slice), self.unsure(slice));
                self.cells_about(&footprint, |x, y| {
                    let middle = [x, y].map(|place| (2 * place + 1) as f64 / self.side as f64 - 1.0);
                    let depths = if self.light.position.w == 0.0 {
                        range
                    } else {
                        // How far it is to a depth of 1, across a cell.
                        let slope = DVec2::from(middle) * across;
                        let (length, spread) =
                            ((1.0 + slope.length_squared()).sqrt(), half * across.length());
                        [range[0].max(0.0) / (length + spread), range[1] / (length - spread).max(1.0)]
                    };
                    if sides.may_weigh(&Piece { middle, half, depths, unsure }) {
                        visit(self.cell(number, slice, x, y));
                    }
                });
            }
        }
    }

    fn cell(&self, plane: usize, slice: usize, x: usize, y: usize) -> usize {
        ((plane * self.slice_ends.len() + slice) * self.side + y) * self.side + x
    }

    /// The image of a segment on a plane, whose first two axes are so long, with `reach_m` around it; `None` when it is not in view. The
    /// segment's ends are along the plane's axes.
    fn footprint(
        &self,
        (plane, [x_length, y_length]): (&LightPlane, [f64; 2]),
        [mut from, mut to]: [DVec3; 2],
        reach_m: f64,
    ) -> Option<Footprint> {
        let everything = Footprint { from: DVec2::ZERO, to: DVec2::ZERO, reach: f64::INFINITY };
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
        edges: &[ListedEdge],
        triangles: &[(u32, [DVec3; 3])],
    ) -> (Self, Vec<u32>, [usize; 2]) {
        let budget = |primitives: usize| (primitives * WORDS_PER_PRIMITIVE).clamp(LEAST_WORDS, MOST_WORDS);
        // How many words finer cells would take is estimated from some of the edges and triangles.
        let some = edges.iter().step_by(edges.len().div_ceil(SOME).max(1));
        let stands_for = edges.len() as f64 / some.len().max(1) as f64;
        while self.side < FINEST {
            let finer = Self { side: self.side * 2, ..self.clone() };
            let mut words = 0;
            some.clone().for_each(|edge| finer.edge_cells(edge, &mut |_| words += 1));
            if finer.edge_lists() + (f64::from(words) * stands_for) as usize > budget(edges.len()) {
                break;
            }
            self = finer;
        }
        let some = triangles.iter().step_by(triangles.len().div_ceil(SOME).max(1));
        let stands_for = triangles.len() as f64 / some.len().max(1) as f64;
        while self.triangle_side < FINEST_OF_TRIANGLES {
            let finer = Self { triangle_side: self.triangle_side * 2, ..self.clone() };
            let mut words = 0;
            some.clone().for_each(|(_, corners)| finer.triangle_cells(corners, &mut |_| words += 1));
            if finer.triangle_lists() + (f64::from(words) * stands_for) as usize > budget(triangles.len()) {
                break;
            }
            self = finer;
        }
        let edge_entries = loop {
            let entries = entries_of(edges, |index, edge, add| {
                self.edge_cells(edge, &mut |list| add(list, index as u32));
            });
            // Those that were asked may have been the small ones.
            if length(&entries) <= MOST_WORDS || self.side == 1 {
                break entries;
            }
            self.side /= 2;
        };
        let triangle_entries = loop {
            let entries = entries_of(triangles, |_, (number, corners), add| {
                self.triangle_cells(corners, &mut |list| add(list, *number));
            });
            if length(&entries) <= MOST_WORDS || self.triangle_side == 1 {
                break entries;
            }
            self.triangle_side /= 2;
        };
        let edge_counts = counts(&edge_entries, self.edge_lists());
        let triangle_counts = counts(&triangle_entries, self.triangle_lists());
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
        edge_entries.iter().flatten().for_each(|(list, number)| put(*list as usize, *number));
        let first = edge_counts.len() + 1;
        triangle_entries.iter().flatten().for_each(|(list, number)| put(first + *list as usize, *number));
        let longest = [&edge_counts, &triangle_counts]
            .map(|counts| counts.iter().max().copied().unwrap_or_default() as usize);
        (self, words, longest)
    }

    /// Calls `visit` with every list whose receivers may have the triangle before the light's centre.
    fn triangle_cells(&self, corners: &[DVec3; 3], visit: &mut dyn FnMut(usize)) {
        let corners = *corners;
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

/// What is worth handing to another thread.
const CHUNK: usize = 256;

/// What goes into lists, chunk after chunk of the things that are listed: (list, number). `list` is asked of every thing, with its
/// place, and calls what it is given with each.
fn entries_of<T: Sync>(
    things: &[T],
    list: impl Fn(usize, &T, &mut dyn FnMut(usize, u32)) + Sync,
) -> Vec<Vec<(u32, u32)>> {
    let of_chunk = |(chunk, things): (usize, &[T])| {
        let mut entries = Vec::new();
        for (index, thing) in (chunk * CHUNK..).zip(things) {
            list(index, thing, &mut |list, number| entries.push((list as u32, number)));
        }
        entries
    };
    things.par_chunks(CHUNK).enumerate().map(of_chunk).collect()
}

fn length(entries: &[Vec<(u32, u32)>]) -> usize {
    entries.iter().map(Vec::len).sum()
}

/// How many entries each of so many lists has.
fn counts(entries: &[Vec<(u32, u32)>], lists: usize) -> Vec<u32> {
    let mut counts = vec![0; lists];
    for (list, _) in entries.iter().flatten() {
        counts[*list as usize] += 1;
    }
    counts
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
