//! Meshes and what the shadow techniques need to know of them: welded vertices, edges, closedness.

mod mesh;
pub mod shapes;
mod topology;

pub use mesh::{MAX_MESH_ELEMENTS, Mesh, MeshData, MeshError, Part};
pub use topology::{Closedness, Edge, EdgeUse, Topology};
