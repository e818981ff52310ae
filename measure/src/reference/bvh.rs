//! Finds the triangles near a ray; decides nothing.
//!
//! A tree of boxes over all triangles, built by `obvhs`, walked here in f32. Coordinates are moved and scaled so that
//! the scene fills the cube \[−1, 1\]³, rays are clipped to that cube in f64 before they are rounded, and every box is
//! enlarged by [`BOX_MARGIN`]. So a triangle that a ray touches in exact arithmetic is always among the candidates,
//! with plenty to spare; whether it is touched is the caller's question, answered in f64.
//!
//! The error behind the margin, in units of the cube: rounding the origin 2⁻²⁴, rounding the direction 2⁻²⁴ over a
//! length of at most 2√3, the reciprocal, the difference and the product three times 2⁻²⁴ over a distance of at most
//! 2 and a rounded box 2⁻²⁴: together below 1·10⁻⁶.

use std::ops::Range;
use std::time::Duration;

use glam::swizzles::Vec4Swizzles;
use glam::{DVec3, DVec4, Vec3A, Vec4};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use shadowgraph_engine::math::Aabb;

/// How far boxes reach beyond their triangles, as a share of half the scene's size; eight times the rounding error.
const BOX_MARGIN: f64 = 8e-6;

/// The largest thickness of a ray, as a share of half the scene's size; beyond it the bounds of the rounding error
/// do not hold, and the candidates would be too many anyway.
const MAX_THICKNESS: f64 = 0.01;

/// The tree. Triangles are renumbered so that each leaf is a run: see [`Bvh::new`].
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    root: Child,
    center: DVec3,
    /// Cube coordinates per metre.
    scale: f64,
}

/// A node with the boxes of both its children: along each axis the two lower bounds, then the two upper bounds.
#[derive(Clone, Copy)]
struct Node {
    slabs: [Vec4; 3],
    children: [Child; 2],
}

/// A node (`count` 0) or a run of triangles.
#[derive(Clone, Copy)]
struct Child {
    first: u32,
    count: u32,
}

/// A place still to visit, and where the ray enters it.
pub(crate) struct Open {
    child: Child,
    t: f32,
}

/// A ray in cube coordinates, clipped to the cube, as thick as asked.
pub(crate) struct BoxRay {
    /// Per axis: the origin less the thickness twice, then the origin plus it twice, swapped for falling rays.
    origin: [Vec4; 3],
    /// Per axis: the reciprocal direction twice, then negated twice.
    inverse: [Vec4; 3],
    falling: [bool; 3],
    t_max: f32,
    /// Cube length per unit of the caller's ray parameter, and where the cube was entered.
    cube_per_t: f64,
    entry: f64,
}

impl BoxRay {
    /// The caller's ray parameter `t` as a limit for the walk, rounded up.
    pub(crate) fn limit(&self, t: f64) -> f32 {
        ((t * self.cube_per_t - self.entry) * (1.0 + 1e-5) + 1e-5) as f32
    }
}

/// All ways from about a point to about a disc, in cube coordinates: for every t in \[0, 1\], or from 0 on, along each
/// axis whatever lies between `origin[0]` + t·`slope[0]` and `origin[1]` + t·`slope[1]`.
pub(crate) struct Cone {
    /// Per axis the lower bound's and the upper bound's start.
    origin: [[f64; 2]; 3],
    /// Per axis how fast they move, as reciprocals.
    inverse: [[f64; 2]; 3],
    t_max: f64,
}

impl Cone {
    /// Whether it meets the box between `low` and `high`.
    #[inline(always)]
    fn meets(&self, low: [f32; 3], high: [f32; 3]) -> bool {
        let (mut first, mut last) = (0.0_f64, self.t_max);
        for axis in 0..3 {
            // The lower bound has to be below the box's upper side, and the upper bound above its lower side.
            let below = (f64::from(high[axis]) - self.origin[axis][0]) * self.inverse[axis][0];
            let above = (f64::from(low[axis]) - self.origin[axis][1]) * self.inverse[axis][1];
            if self.inverse[axis][0] > 0.0 {
                last = last.min(below);
            } else {
                first = first.max(below);
            }
            if self.inverse[axis][1] > 0.0 { first = first.max(above) } else { last = last.min(above) }
        }
        first <= last
    }
}

impl Bvh {
    /// All ways from within `near_m` of `from`, along each axis, to within `far_m[axis]` of `from` + `way`; on and on in
    /// the same directions where they do not `end` there.
    pub(crate) fn cone(&self, from: DVec3, near_m: f64, way: DVec3, far_m: DVec3, end: bool) -> Cone {
        let from = (from - self.center) * self.scale;
        let (near, way, far) = (near_m * self.scale, way * self.scale, far_m * self.scale);
        // Endless ways fan out from where they start; those with an end go straight from one spread to the other.
        let fan = if end { far - near } else { far };
        // A finite stand-in for the reciprocal of zero keeps 0·∞ out.
        let inverse = |slope: f64| if slope.abs() < 1e-280 { 1e280 } else { slope.recip() };
        Cone {
            origin: std::array::from_fn(|axis| [from[axis] - near, from[axis] + near]),
            inverse: std::array::from_fn(|axis| {
                [inverse(way[axis] - fan[axis]), inverse(way[axis] + fan[axis])]
            }),
            t_max: if end { 1.0 } else { f64::INFINITY },
        }
    }

    /// Calls `leaf` with every run of triangles whose box `cone` meets, until it returns `false`.
    pub(crate) fn walk_cone(
        &self,
        cone: &Cone,
        stack: &mut Vec<Open>,
        mut leaf: impl FnMut(Range<usize>) -> bool,
    ) {
        stack.clear();
        stack.push(Open { child: self.root, t: 0.0 });
        while let Some(Open { child, .. }) = stack.pop() {
            if child.count > 0 {
                let first = child.first as usize;
                if !leaf(first..first + child.count as usize) {
                    return;
                }
                continue;
            }
            let Some(node) = self.nodes.get(child.first as usize) else { return };
            for (side, child) in node.children.into_iter().enumerate() {
                let low = node.slabs.map(|slab| slab[side]);
                let high = node.slabs.map(|slab| slab[side + 2]);
                if cone.meets(low, high) {
                    stack.push(Open { child, t: 0.0 });
                }
            }
        }
    }

    /// Builds the tree over triangles with these `boxes` within `bounds`, and says in which order it wants them.
    pub(crate) fn new(boxes: &[Aabb], bounds: &Aabb) -> (Self, Vec<u32>) {
        let center = bounds.center();
        let half_size = if bounds.is_empty() { 0.0 } else { (bounds.max - bounds.min).max_element() * 0.5 };
        let scale = if half_size > 0.0 { half_size.recip() } else { 1.0 };
        // Far from the origin, positions in f64 are themselves coarser than the scene is small.
        let margin = BOX_MARGIN + 8.0 * f64::EPSILON * center.abs().max_element() * scale;
        let boxes: Vec<_> = boxes
            .iter()
            .map(|b| {
                let low = (b.min - center) * scale - margin;
                let high = (b.max - center) * scale + margin;
                obvhs::aabb::Aabb::new(Vec3A::from(low.as_vec3()), Vec3A::from(high.as_vec3()))
            })
            .collect();
        let empty = Self { nodes: Vec::new(), root: Child { first: 0, count: 0 }, center, scale };
        if boxes.is_empty() {
            return (empty, Vec::new());
        }
        let params = BvhBuildParams { max_prims_per_leaf: 4, ..BvhBuildParams::medium_build() };
        let tree = build_bvh2(&boxes, params, &mut Duration::default());
        (Self { nodes: pair_up(&tree), root: child_of(&tree, 0), ..empty }, tree.primitive_indices)
    }

    /// Whether a ray may be `thickness_m` thick.
    pub(crate) fn takes_thickness(&self, thickness_m: f64) -> bool {
        thickness_m * self.scale <= MAX_THICKNESS
    }

    /// The way from `point` to `light`, (position, 1) or (direction towards it, 0), as [`Bvh::ray`] has it.
    pub(crate) fn way_to_light(&self, point: DVec3, light: DVec4, thickness_m: f64) -> Option<BoxRay> {
        let t_max = if light.w == 0.0 { f64::INFINITY } else { 1.0 };
        self.ray(point, light.truncate() - point * light.w, 0.0..t_max, thickness_m)
    }

    /// The ray `from + t·direction`, t in `range`, with everything within `thickness_m` of it along each axis; `None`
    /// when it misses the scene.
    pub(crate) fn ray(
        &self,
        from: DVec3,
        direction: DVec3,
        range: Range<f64>,
        thickness_m: f64,
    ) -> Option<BoxRay> {
        let from = (from - self.center) * self.scale;
        let thickness = thickness_m * self.scale;
        let length = direction.length();
        let direction = direction / length;
        if !(length > 0.0 && from.is_finite() && direction.is_finite()) {
            return None;
        }
        let cube_per_t = length * self.scale;
        let (mut entry, mut exit) = (range.start * cube_per_t, range.end * cube_per_t);
        let reach = 1.0 + 1e-4 + thickness;
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if from[axis].abs() > reach {
                    return None;
                }
                continue;
            }
            let (t0, t1) = ((-reach - from[axis]) / direction[axis], (reach - from[axis]) / direction[axis]);
            entry = entry.max(t0.min(t1));
            exit = exit.min(t0.max(t1));
        }
        if entry > exit {
            return None;
        }
        let origin = (from + direction * entry).as_vec3();
        let (direction, thickness) = (direction.as_vec3(), thickness as f32);
        let falling = direction.to_array().map(|d| d < 0.0);
        Some(BoxRay {
            origin: std::array::from_fn(|axis| {
                let (low, high) = (origin[axis] + thickness, origin[axis] - thickness);
                let origin = Vec4::new(low, low, high, high);
                if falling[axis] { origin.zwxy() } else { origin }
            }),
            inverse: std::array::from_fn(|axis| {
                // A finite stand-in for the reciprocal of zero keeps 0·∞ out of the slab test.
                let inverse = 1.0 / direction[axis].abs().max(1e-30);
                let inverse = if falling[axis] { -inverse } else { inverse };
                Vec4::new(inverse, inverse, -inverse, -inverse)
            }),
            falling,
            t_max: ((exit - entry) * (1.0 + 1e-5) + 1e-5) as f32,
            cube_per_t,
            entry,
        })
    }

    /// Calls `leaf` with every run of triangles whose box the ray touches, near ones first. `leaf` returns how far the
    /// ray still needs to be followed (see [`BoxRay::limit`]), or `None` to leave that as it is; a negative limit ends
    /// the walk.
    pub(crate) fn walk(
        &self,
        ray: &BoxRay,
        stack: &mut Vec<Open>,
        mut leaf: impl FnMut(Range<usize>) -> Option<f32>,
    ) {
        stack.clear();
        stack.push(Open { child: self.root, t: 0.0 });
        let mut t_max = ray.t_max;
        while let Some(Open { mut child, t }) = stack.pop() {
            if t > t_max {
                continue;
            }
            while child.count == 0 {
                let Some(node) = self.nodes.get(child.first as usize) else { return };
                let [left, right] = node.enter(ray, t_max);
                let (near, far) = if left <= right { (0, 1) } else { (1, 0) };
                let (t_near, t_far) = (left.min(right), left.max(right));
                if t_far < f32::INFINITY {
                    stack.push(Open { child: node.children[far], t: t_far });
                }
                if t_near == f32::INFINITY {
                    break;
                }
                child = node.children[near];
            }
            if child.count > 0 {
                let first = child.first as usize;
                if let Some(limit) = leaf(first..first + child.count as usize) {
                    t_max = t_max.min(limit);
                }
            }
        }
    }
}

impl Node {
    /// Where the ray enters each child's box; infinite where it misses it.
    #[inline(always)]
    fn enter(&self, ray: &BoxRay, t_max: f32) -> [f32; 2] {
        // Lanes 0 and 1 hold where the ray enters a slab, lanes 2 and 3 where it leaves it, negated: one maximum
        // over the three axes then serves both.
        let mut latest = Vec4::new(0.0, 0.0, -t_max, -t_max);
        for axis in 0..3 {
            let slab = if ray.falling[axis] { self.slabs[axis].zwxy() } else { self.slabs[axis] };
            latest = latest.max((slab - ray.origin[axis]) * ray.inverse[axis]);
        }
        let hit = |enter: f32, minus_leave: f32| {
            if enter + minus_leave <= 0.0 { enter } else { f32::INFINITY }
        };
        [hit(latest.x, latest.z), hit(latest.y, latest.w)]
    }
}

fn child_of(tree: &Bvh2, index: usize) -> Child {
    let node = &tree.nodes[index];
    if node.is_leaf() {
        Child { first: node.first_index, count: node.prim_count }
    } else {
        // Siblings stand side by side from index 1 on, so every pair has a number of its own.
        Child { first: node.first_index.saturating_sub(1) / 2, count: 0 }
    }
}

/// The tree's nodes with each pair of siblings drawn together into one.
fn pair_up(tree: &Bvh2) -> Vec<Node> {
    tree.nodes
        .get(1..)
        .unwrap_or_default()
        .chunks_exact(2)
        .enumerate()
        .map(|(pair, siblings)| {
            let [left, right] = [siblings[0].aabb(), siblings[1].aabb()];
            Node {
                slabs: std::array::from_fn(|axis| {
                    Vec4::new(left.min[axis], right.min[axis], left.max[axis], right.max[axis])
                }),
                children: [child_of(tree, 2 * pair + 1), child_of(tree, 2 * pair + 2)],
            }
        })
        .collect()
}
