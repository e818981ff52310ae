//! The scene graph: plain data, no device.
//!
//! A [`Scene`] owns nodes, meshes, materials, images, lights, cameras and shadow nodes, each behind a key type of
//! its own. Nodes form a forest; each node has one [`Content`]. Shadow nodes are data too (a type name and
//! parameters): what they do is looked up in a technique catalog when a frame is planned.

mod content;
mod graph;
mod material;
mod posed;

pub use content::{
    Camera, Content, Light, LightKind, MeshNode, ParamValue, Params, Scope, ShadowFlags, ShadowNode, look_at,
    placed,
};
pub use graph::{
    CameraKey, ImageKey, LightKey, MaterialKey, MeshKey, Node, NodeKey, Scene, SceneError, ShadowKey,
};
pub use material::{AlphaMode, Image, Material, TextureRef, UvTransform, Wrap};
pub use posed::{Instance, Posed, PosedCamera, PosedLight, PosedShadowNode};
