//! Meshes and what the shadow techniques need to know of them: welded vertices, edges, closedness, the chain
//! that bounds a shadow volume, and how many layers of it one light ray can meet.

mod chain;
mod closure;
mod components;
mod deformable;
mod facing;
mod layer_groups;
mod layers;
mod light_grid;
mod mesh;
pub mod shapes;
mod topology;

pub use chain::{Chain, facing_signs, restricted_signs};
pub use closure::{Capped, LoopTooLong, MAX_CAPPED_EDGES, capped, doubled, open_loops};
pub use components::{Component, Orientation};
pub use deformable::{Influences, MorphTarget};
pub use facing::FacingPlanes;
pub use layer_groups::{CastTriangles, GroupMember, layer_groups, max_layers};
pub use layers::LayerGrid;
pub use light_grid::{CellRange, LightGrid, LightPlane};
pub use mesh::{MAX_MESH_ELEMENTS, Mesh, MeshData, MeshError, Part};
pub use topology::{Closedness, Edge, EdgeUse, Topology};
