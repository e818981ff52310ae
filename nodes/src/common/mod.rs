//! What several techniques share: which casters matter, how volumes end, their vertices, and how many layers they count.

pub mod culling;
pub mod extrusion;
pub mod layer_groups;
pub mod light_lists;
pub mod masked;
pub mod volume;
