//! The connected components of a mesh, and which of them bound a solid.
//!
//! A closed caster may cast with only its light-facing half, but only if "light-facing" is meant outwards: an
//! inside-out solid would cast with its far half and leave its own back lit. So orientation is *measured*, by the
//! signed volume of each component, and turned where it is negative; winding is never trusted.

use glam::{DAffine3, Vec3};

use super::topology::Tables;
use super::{EdgeUse, Topology};
use crate::math::{Aabb, orient_sign};

/// One connected component of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// The number of its triangles, collapsed ones left out.
    pub triangles: usize,
    /// Edges at which its signed uses do not sum to zero.
    pub unbalanced_edges: usize,
    /// The signed volume in local space, in cubic metres, positive when wound outwards; taken about the centre of
    /// `bounds`, so that it is precise far from the origin, and only meaningful without unbalanced edges.
    pub signed_volume: f64,
    /// An upper bound on the rounding error of `signed_volume`, in cubic metres.
    pub volume_rounding: f64,
    /// The box around it in local space.
    pub bounds: Aabb,
}

impl Component {
    /// Whether it is closed and has a volume beyond rounding: then it has an outside.
    pub fn is_solid(&self) -> bool {
        self.unbalanced_edges == 0 && self.signed_volume.abs() > self.volume_rounding
    }
}

/// For every component of a mesh of solids the sign that turns it outwards in the world.
///
/// With it a technique may cast only triangles whose facing sign times [`Orientation::sign`] is positive
/// ([`Orientation::lit_only`]): half the count. It is exact for points outside the solids *if the light is outside
/// them too*. Between two outside points a segment enters each solid as often as it leaves it, and towards the light
/// it leaves through triangles that face the light; so it crosses one of those iff it crosses any. A light inside
/// sees the walls from their backs, and they would not cast at all: where [`Topology::may_enclose`] says so, cast all
/// triangles instead.
#[derive(Clone, Debug)]
pub struct Orientation<'a> {
    topology: &'a Topology,
    component_signs: Vec<i8>,
}

impl<'a> Orientation<'a> {
    pub(super) fn new(topology: &'a Topology, world_from_local: &DAffine3) -> Option<Self> {
        let linear = world_from_local.matrix3;
        let handedness = orient_sign(linear.x_axis, linear.y_axis, linear.z_axis);
        let components = topology.components();
        if handedness == 0 || !components.iter().all(Component::is_solid) {
            return None;
        }
        let sign_of = |component: &Component| {
            if (component.signed_volume > 0.0) == (handedness > 0) { 1 } else { -1 }
        };
        Some(Self { topology, component_signs: components.iter().map(sign_of).collect() })
    }

    /// The sign of every component: +1 wound outwards in the world, −1 inwards.
    pub fn component_signs(&self) -> &[i8] {
        &self.component_signs
    }

    /// The sign of `triangle`'s component; 0 for a collapsed triangle, or when there is no such triangle.
    pub fn sign(&self, triangle: usize) -> i8 {
        let in_range = triangle < self.topology.triangles().len();
        let component = in_range.then(|| self.topology.component_of(triangle)).flatten();
        component.map_or(0, |component| self.component_signs[component as usize])
    }

    /// Of the facing signs of all triangles those that face the light outwards, unchanged; 0 for the others.
    #[must_use]
    pub fn lit_only(&self, signs: &[i8]) -> Vec<i8> {
        let keep = |(triangle, &sign): (usize, &i8)| {
            if i32::from(sign) * i32::from(self.sign(triangle)) > 0 { sign } else { 0 }
        };
        signs.iter().enumerate().map(keep).collect()
    }
}

/// For every triangle its component, numbered by ascending first triangle.
///
/// Edges with two uses connect. At an edge with more, several sheets meet, and only those connect that are not
/// balanced there by themselves: two boxes with a common edge stay two, three leaves of a book are one.
pub(super) fn connect(tables: &Tables) -> Vec<Option<u32>> {
    let triangle_count = tables.corners.len();
    let mut sheets = DisjointSets::new(triangle_count);
    for edge in 0..tables.edges().len() {
        if let [a, b] = tables.uses(edge) {
            sheets.join(a.triangle, b.triangle);
        }
    }
    let sheet_of: Vec<u32> = (0..triangle_count as u32).map(|triangle| sheets.root(triangle)).collect();
    for edge in (0..tables.edges().len()).filter(|edge| tables.uses(*edge).len() > 2) {
        let open = unbalanced(tables.uses(edge), |triangle| Some(sheet_of[triangle as usize]));
        for pair in open.windows(2) {
            sheets.join(pair[0], pair[1]);
        }
    }
    // Number the sets in the order of their first triangles.
    let mut number_of_root = vec![None; triangle_count];
    let mut next = 0;
    let number = |(triangle, &[a, b, c]): (usize, &[u32; 3])| {
        if a == b || b == c || c == a {
            return None;
        }
        let slot = &mut number_of_root[sheets.root(triangle as u32) as usize];
        if slot.is_none() {
            *slot = Some(next);
            next += 1;
        }
        *slot
    };
    tables.corners.iter().enumerate().map(number).collect()
}

/// Measures every component.
pub(super) fn describe(topology: &Topology, positions: &[Vec3]) -> Vec<Component> {
    let empty = Component {
        triangles: 0,
        unbalanced_edges: 0,
        signed_volume: 0.0,
        volume_rounding: 0.0,
        bounds: Aabb::EMPTY,
    };
    let in_components = || {
        let triangles = topology.triangles().iter().enumerate();
        triangles.filter_map(|(triangle, corners)| {
            let component = topology.component_of(triangle)? as usize;
            Some((component, corners.map(|corner| positions[corner as usize].as_dvec3())))
        })
    };
    let mut components = Vec::new();
    for (component, corners) in in_components() {
        // Components are numbered by first triangle, so a new one is always the next.
        if component == components.len() {
            components.push(empty.clone());
        }
        let report: &mut Component = &mut components[component];
        report.triangles += 1;
        report.bounds = report.bounds.union(&Aabb::from_points(corners));
    }
    for (component, [a, b, c]) in in_components() {
        let report = &mut components[component];
        let (to_a, ab, ac) = (a - report.bounds.center(), b - a, c - a);
        report.signed_volume += to_a.dot(ab.cross(ac)) / 6.0;
        report.volume_rounding += to_a.length() * ab.length() * ac.length() / 6.0;
    }
    for report in &mut components {
        // A sum of n terms, each a product of three differences, errs by less than (n + 16)·2⁻⁵³ of their sizes.
        report.volume_rounding *= (report.triangles as f64 + 16.0) * f64::EPSILON;
    }
    for edge in 0..topology.edges().len() {
        let uses = topology.uses(edge);
        // The common case first: two uses that cancel.
        if uses.len() == 2 && uses[0].sigma + uses[1].sigma == 0 {
            continue;
        }
        for component in unbalanced(uses, |triangle| topology.component_of(triangle as usize)) {
            components[component as usize].unbalanced_edges += 1;
        }
    }
    components
}

/// The groups of triangles, by ascending number, whose uses do not cancel.
fn unbalanced(uses: &[EdgeUse], group_of: impl Fn(u32) -> Option<u32>) -> Vec<u32> {
    let mut grouped: Vec<(u32, i32)> =
        uses.iter().filter_map(|use_of| Some((group_of(use_of.triangle)?, use_of.sigma))).collect();
    grouped.sort_unstable();
    grouped
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|group| group.iter().map(|(_, sigma)| sigma).sum::<i32>() != 0)
        .map(|group| group[0].0)
        .collect()
}

/// Union-find with path halving; the lower number becomes the root, which keeps the result independent of order.
struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    fn root(&mut self, mut element: u32) -> u32 {
        while self.parent[element as usize] != element {
            let grandparent = self.parent[self.parent[element as usize] as usize];
            self.parent[element as usize] = grandparent;
            element = grandparent;
        }
        element
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
