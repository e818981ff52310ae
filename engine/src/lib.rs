//! The engine of Shadowgraph: scene graph, shadow registry, frame plan, GPU execution and glTF.
//!
//! The engine knows no shadow technique by name. A technique is a type that implements the trait of
//! [`shadow`] and is registered in a catalog; scenes name it in their shadow nodes.

pub mod geometry;
pub mod gltf;
pub mod gpu;
pub mod math;
pub mod plan;
#[cfg(test)]
mod random;
pub mod render;
pub mod scene;
pub mod shadow;
