//! What several techniques share: which casters matter, how volumes end, and their vertices.

pub mod culling;
pub mod extrusion;
pub mod volume;
