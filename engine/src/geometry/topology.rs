//! Welded vertices, edges with any number of triangles, and closedness.
//!
//! A shadow volume is built from sums over edges (see [`Chain`](super::Chain)), so all that is asked of an edge is
//! which triangles use it and in which direction. No manifold is assumed: an edge may have one use, or fifty.
//!
//! *Welding.* Materials and texture seams split vertices that are one point in space and would open a closed mesh.
//! Vertices weld when their positions are equal bit for bit (−0 equals 0), never by distance: two vertices that
//! differ at all are two points, and joining them would move geometry that the picture shows unmoved.
//!
//! *Collapsed triangles.* A triangle with two equal welded corners has no area, and its boundary is zero: the edge
//! between the equal corners is a point and the other two cancel. It is left out of the edge table and belongs to
//! no component, so that the poles of a sphere do not count as non-manifold.
//!
//! Everything is sorted, not hashed: the tables are the same on every machine and in every run.

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;
use rayon::prelude::*;

use super::components::{self, Component, Orientation};

/// An undirected edge between two welded vertices, `p < q`, named by a representative of each in the mesh's own
/// vertex numbering.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// The lower welded vertex (an index into the mesh's positions).
    pub p: u32,
    /// The higher welded vertex (an index into the mesh's positions).
    pub q: u32,
}

/// One triangle's use of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeUse {
    /// The triangle.
    pub triangle: u32,
    /// +1 if the triangle runs p→q, −1 if it runs q→p.
    pub sigma: i32,
}

/// How far a mesh is from bounding a solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Closedness {
    /// Edges with exactly one triangle.
    pub boundary_edges: usize,
    /// Edges with three or more triangles.
    pub non_manifold_edges: usize,
    /// Edges with exactly two triangles that run the same way.
    pub inconsistent_edges: usize,
    /// Edges whose signed uses do not sum to zero: the mesh is closed as a chain iff there is none.
    pub unbalanced_edges: usize,
    /// Triangles without area (exactly, in f64).
    pub degenerate_triangles: usize,
    /// Connected components, as [`Topology::components`] lists them.
    pub components: usize,
    /// The signed volume in local space, in cubic metres; positive when wound outwards. Only meaningful when closed.
    pub signed_volume: f64,
}

/// The connectivity of a mesh.
#[derive(Debug)]
pub struct Topology {
    tables: Arc<Tables>,
    components: Vec<Component>,
    closedness: Closedness,
}

/// What depends on which vertices are one point, and on nothing else: poses of a mesh share it.
#[derive(Debug)]
pub(super) struct Tables {
    /// For every vertex the lowest one at the same position.
    representative: Vec<u32>,
    pub(super) corners: Vec<[u32; 3]>,
    edges: Vec<Edge>,
    /// The uses of edge e are `uses[first_use[e]..first_use[e + 1]]`.
    first_use: Vec<u32>,
    uses: Vec<EdgeUse>,
    two_uses: Vec<TwoUses>,
    component_of: Vec<Option<u32>>,
}

impl Topology {
    /// Welds `positions` by exact equality (−0 equals 0) and builds the edge table.
    ///
    /// # Panics
    /// When an index is out of range; a validated [`Mesh`](super::Mesh) has none.
    pub fn new(positions: &[Vec3], indices: &[u32]) -> Self {
        Self::measured(Arc::new(Tables::new(weld(positions), indices)), positions)
    }

    /// The topology of the same triangles with vertices at `positions`: the tables are shared as long as exactly the
    /// same vertices weld. Seams part where their two sides move differently, and vertices may meet.
    ///
    /// # Panics
    /// As [`Topology::new`].
    #[must_use]
    pub fn posed(&self, positions: &[Vec3], indices: &[u32]) -> Self {
        let representative = weld(positions);
        if representative == self.tables.representative {
            return Self::measured(Arc::clone(&self.tables), positions);
        }
        Self::measured(Arc::new(Tables::new(representative, indices)), positions)
    }

    fn measured(tables: Arc<Tables>, positions: &[Vec3]) -> Self {
        let mut topology = Self { tables, components: Vec::new(), closedness: Closedness::default() };
        topology.components = components::describe(&topology, positions);
        topology.closedness = topology.measure(positions);
        topology
    }

    /// Every edge, sorted by (p, q).
    pub fn edges(&self) -> &[Edge] {
        &self.tables.edges
    }

    /// The uses of edge number `edge`, by ascending triangle.
    ///
    /// # Panics
    /// When there is no such edge.
    pub fn uses(&self, edge: usize) -> &[EdgeUse] {
        self.tables.uses(edge)
    }

    /// For every edge its uses, if it has two of them. Most have, and are found faster here.
    pub(super) fn two_uses(&self) -> &[TwoUses] {
        &self.tables.two_uses
    }

    /// The welded corners of every triangle, in the triangle's own order, as indices into the mesh's positions.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.tables.corners
    }

    /// The component of `triangle`; `None` for collapsed triangles.
    ///
    /// # Panics
    /// When there is no such triangle.
    pub fn component_of(&self, triangle: usize) -> Option<u32> {
        self.tables.component_of[triangle]
    }

    /// The connected components, by ascending first triangle.
    ///
    /// Triangles are connected over *edges*: two solids that touch in a vertex, or along an edge at which each is
    /// closed by itself, are two solids, and each can be turned outwards without the other.
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// How far the mesh is from bounding a solid.
    pub fn closedness(&self) -> &Closedness {
        &self.closedness
    }

    /// The signs that turn every component outwards in the world; `None` unless every component is a solid
    /// ([`Component::is_solid`]) and the transform keeps it one (its linear part is not singular).
    ///
    /// Without them the mesh must be treated as a soup, and so must a solid within which a light may stand: see
    /// [`Topology::may_enclose`].
    pub fn orientation(&self, world_from_local: &glam::DAffine3) -> Option<Orientation<'_>> {
        Orientation::new(self, world_from_local)
    }

    /// Whether `point`, in local space, may lie inside a component; false only when it lies outside all bounds.
    pub fn may_enclose(&self, point: glam::DVec3) -> bool {
        self.components.iter().any(|component| {
            let rounding = 1e-9 * (component.bounds.radius() + component.bounds.center().length());
            component.bounds.expanded(rounding).contains(point)
        })
    }

    fn measure(&self, positions: &[Vec3]) -> Closedness {
        let mut closedness = Closedness {
            components: self.components.len(),
            signed_volume: self.components.iter().map(|component| component.signed_volume).sum(),
            ..Closedness::default()
        };
        for edge in 0..self.edges().len() {
            let uses = self.uses(edge);
            let balance: i32 = uses.iter().map(|use_of| use_of.sigma).sum();
            closedness.boundary_edges += usize::from(uses.len() == 1);
            closedness.non_manifold_edges += usize::from(uses.len() > 2);
            closedness.inconsistent_edges += usize::from(uses.len() == 2 && balance != 0);
            closedness.unbalanced_edges += usize::from(balance != 0);
        }
        let has_no_area = |corners: &&[u32; 3]| {
            let [a, b, c] = corners.map(|corner| positions[corner as usize].as_dvec3());
            (b - a).cross(c - a) == glam::DVec3::ZERO
        };
        closedness.degenerate_triangles = self.triangles().iter().filter(has_no_area).count();
        closedness
    }
}

impl Tables {
    fn new(representative: Vec<u32>, indices: &[u32]) -> Self {
        let corners: Vec<[u32; 3]> = indices
            .chunks_exact(3)
            .map(|corners| std::array::from_fn(|i| representative[corners[i] as usize]))
            .collect();
        let mut tables = Self {
            representative,
            edges: Vec::new(),
            first_use: vec![0],
            uses: Vec::with_capacity(corners.len() * 3),
            two_uses: Vec::new(),
            component_of: Vec::new(),
            corners,
        };
        tables.build_edges();
        tables.component_of = components::connect(&tables);
        tables
    }

    pub(super) fn edges(&self) -> &[Edge] {
        &self.edges
    }

    pub(super) fn uses(&self, edge: usize) -> &[EdgeUse] {
        &self.uses[self.use_range(edge)]
    }

    fn use_range(&self, edge: usize) -> Range<usize> {
        self.first_use[edge] as usize..self.first_use[edge + 1] as usize
    }

    /// Sorts all (p, q, triangle, direction) and cuts the result into edges.
    fn build_edges(&mut self) {
        let mut keys: Vec<u128> = Vec::with_capacity(self.corners.len() * 3);
        for (triangle, &[a, b, c]) in self.corners.iter().enumerate() {
            if a == b || b == c || c == a {
                continue;
            }
            keys.extend([(a, b), (b, c), (c, a)].map(|(from, to)| {
                let (p, q, backwards) = if from < to { (from, to, 0) } else { (to, from, 1) };
                u128::from(p) << 96 | u128::from(q) << 64 | (triangle as u128) << 1 | backwards
            }));
        }
        keys.par_sort_unstable();
        for key in keys {
            let edge = Edge { p: (key >> 96) as u32, q: (key >> 64) as u32 };
            if self.edges.last() != Some(&edge) {
                if !self.edges.is_empty() {
                    self.first_use.push(self.uses.len() as u32);
                }
                self.edges.push(edge);
            }
            let sigma = if key & 1 == 0 { 1 } else { -1 };
            self.uses.push(EdgeUse { triangle: (key as u64 >> 1) as u32, sigma });
        }
        if !self.edges.is_empty() {
            self.first_use.push(self.uses.len() as u32);
        }
        self.two_uses = (0..self.edges.len()).map(|edge| TwoUses::packed(self.uses(edge))).collect();
    }
}

/// The uses of an edge with two of them, each a word: the triangle, and in the lowest bit whether it runs against the edge. Of
/// other edges, all bits are set.
#[derive(Clone, Copy, Debug)]
pub(super) struct TwoUses([u32; 2]);

impl TwoUses {
    const NOT_TWO: u32 = u32::MAX;

    fn packed(uses: &[EdgeUse]) -> Self {
        let word = |use_of: &EdgeUse| use_of.triangle << 1 | u32::from(use_of.sigma < 0);
        match uses {
            [first, second] => Self([word(first), word(second)]),
            _ => Self([Self::NOT_TWO; 2]),
        }
    }

    /// `None` of an edge that has not two.
    #[inline]
    pub(super) fn unpacked(self) -> Option<[EdgeUse; 2]> {
        let use_of = |word: u32| EdgeUse { triangle: word >> 1, sigma: 1 - 2 * (word & 1) as i32 };
        let [first, second] = self.0;
        if first == Self::NOT_TWO { None } else { Some([use_of(first), use_of(second)]) }
    }
}

/// For every vertex the lowest vertex at the same position.
fn weld(positions: &[Vec3]) -> Vec<u32> {
    let mut keys: Vec<u128> = positions
        .iter()
        .enumerate()
        .map(|(vertex, position)| {
            // Adding 0 turns −0 into 0 and changes nothing else.
            let [x, y, z] = (*position + 0.0).to_array().map(|value| u128::from(value.to_bits()));
            x << 96 | y << 64 | z << 32 | vertex as u128
        })
        .collect();
    keys.par_sort_unstable();
    let mut representative = vec![0; positions.len()];
    for class in keys.chunk_by(|a, b| a >> 32 == b >> 32) {
        for key in class {
            representative[*key as u32 as usize] = class[0] as u32;
        }
    }
    representative
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DAffine3, DVec3};

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    fn unit_tetrahedron() -> Vec<Vec3> {
        vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z]
    }

    #[test]
    fn empty_and_collapsed_meshes_are_closed_and_nothing() {
        for (positions, indices) in
            [(vec![], vec![]), (unit_tetrahedron(), vec![]), (unit_tetrahedron(), vec![0, 0, 1, 2, 2, 2])]
        {
            let topology = Topology::new(&positions, &indices);
            assert!(topology.edges().is_empty() && topology.components().is_empty());
            assert_eq!(topology.tables.first_use, [0]);
            assert_eq!(topology.closedness().degenerate_triangles, indices.len() / 3);
            assert!(topology.orientation(&DAffine3::IDENTITY).is_some());
        }
    }

    #[test]
    fn a_tetrahedron_without_shared_vertices_welds_to_a_solid() {
        // Each triangle brings its own vertices, the origin once as −0.
        let mut positions: Vec<Vec3> =
            TETRAHEDRON.iter().flatten().map(|&vertex| unit_tetrahedron()[vertex as usize]).collect();
        positions[3] = Vec3::new(-0.0, 0.0, -0.0);
        let topology = Topology::new(&positions, &(0..12).collect::<Vec<_>>());
        assert_eq!(topology.triangles(), [[0, 1, 2], [0, 2, 5], [2, 1, 5], [1, 0, 5]]);
        assert_eq!(topology.edges().len(), 6);
        let closedness = topology.closedness();
        assert_eq!((closedness.unbalanced_edges, closedness.components), (0, 1));
        assert!((closedness.signed_volume - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn nearly_equal_vertices_do_not_weld() {
        let nudged = Vec3::new(f32::from_bits(1), 0.0, 0.0);
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, nudged, Vec3::X, Vec3::NEG_Y];
        let topology = Topology::new(&positions, &[0, 1, 2, 3, 5, 4]);
        assert_eq!(topology.closedness().boundary_edges, 6);
        assert_eq!(topology.closedness().components, 2);
    }

    #[test]
    fn fins_duplicates_and_moebius_strips_are_named() {
        let positions = unit_tetrahedron();
        // Three leaves of a book at edge (0, 1).
        let fin = Topology::new(&[positions.clone(), vec![Vec3::ONE]].concat(), &[0, 1, 2, 0, 1, 3, 1, 0, 4]);
        assert_eq!(fin.closedness().non_manifold_edges, 1);
        assert_eq!(fin.closedness().boundary_edges, 6);
        assert_eq!(fin.uses(0).iter().map(|u| u.sigma).collect::<Vec<_>>(), [1, 1, -1]);
        assert_eq!(fin.components().iter().map(|c| c.unbalanced_edges).sum::<usize>(), 7);
        assert_eq!(fin.closedness().components, 1);
        // A solid twice in the same place: four uses at every edge, and twice the volume.
        let twice = Topology::new(&positions, &[TETRAHEDRON.concat(), TETRAHEDRON.concat()].concat());
        assert_eq!((twice.closedness().components, twice.closedness().non_manifold_edges), (1, 6));
        assert!((twice.closedness().signed_volume - 1.0 / 3.0).abs() < 1e-15);
        assert!(twice.components()[0].is_solid());
        // The same face twice, and a face with its opposite: closed, but without volume.
        assert_eq!(Topology::new(&positions, &[0, 1, 2, 0, 1, 2]).closedness().inconsistent_edges, 3);
        let sheet = Topology::new(&positions, &[0, 1, 2, 0, 2, 1]);
        assert_eq!(sheet.closedness().unbalanced_edges, 0);
        assert!(sheet.orientation(&DAffine3::IDENTITY).is_none());
        // Five triangles in a ring with one half twist: vertices 0..5, triangle i = (i, i+1, i+2).
        let ring: Vec<Vec3> = (0..5).map(|i| Vec3::new(i as f32, (i * i) as f32, (i % 2) as f32)).collect();
        let indices: Vec<u32> = (0..5).flat_map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
        let moebius = Topology::new(&ring, &indices);
        assert_eq!(moebius.closedness().boundary_edges, 5);
        assert_eq!(moebius.closedness().inconsistent_edges, 5);
        assert_eq!(moebius.closedness().components, 1);
    }

    #[test]
    fn solids_that_touch_in_a_vertex_or_an_edge_are_turned_apart() {
        let mut positions = unit_tetrahedron();
        positions.extend([Vec3::NEG_X, Vec3::NEG_Y]);
        let outwards: Vec<u32> = TETRAHEDRON.concat();
        // Sharing only the edge (0, 3), and wound inwards: (0, 4, 5, 3) is the first solid turned half about z.
        let touching: Vec<u32> =
            TETRAHEDRON.iter().flat_map(|&[a, b, c]| [a, c, b]).map(|v| [0, 4, 5, 3][v as usize]).collect();
        let topology = Topology::new(&positions, &[outwards.clone(), touching].concat());
        assert_eq!(topology.closedness().non_manifold_edges, 1);
        let orientation = topology.orientation(&DAffine3::IDENTITY).unwrap();
        assert_eq!(orientation.component_signs(), [1, -1]);
        assert_eq!((orientation.sign(0), orientation.sign(7)), (1, -1));
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 3.0, 1e-6));
        assert_eq!(topology.orientation(&mirror).unwrap().component_signs(), [-1, 1]);
        assert!(topology.orientation(&DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
        assert!(topology.may_enclose(DVec3::splat(0.2)) && !topology.may_enclose(DVec3::splat(1.2)));
        // One triangle missing: no orientation.
        assert!(Topology::new(&positions, &outwards[3..]).orientation(&DAffine3::IDENTITY).is_none());
    }

    #[test]
    fn volume_is_measured_about_the_component_itself() {
        // A millimetre-sized solid a kilometre away: about the origin its volume would drown in rounding.
        let far: Vec<Vec3> =
            unit_tetrahedron().iter().map(|p| *p / 1024.0 + Vec3::new(1000.0, -2000.0, 500.0)).collect();
        let topology = Topology::new(&far, &TETRAHEDRON.concat());
        let exact = 1.0 / 6.0 / 1024.0_f64.powi(3);
        assert!((topology.closedness().signed_volume / exact - 1.0).abs() < 1e-12);
        assert!(topology.components()[0].is_solid());
    }
}
