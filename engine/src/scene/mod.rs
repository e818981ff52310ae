//! The scene graph: plain data, no device.
//!
//! A [`Scene`] owns nodes, meshes, materials, images, lights, cameras and shadow nodes, each behind a key type of
//! its own. Nodes form a forest; each node has one [`Content`]. Shadow nodes are data too (a type name and
//! parameters): what they do is looked up in a technique catalog when a frame is planned.
//!
//! Animations, skins and morph targets are data as well. Showing an animation at a moment sets transforms and weights;
//! [`Scene::snapshot`] bends the meshes, so that all that comes after sees triangles at their places.

mod adding;
mod animation;
mod content;
mod deform;
mod graph;
mod material;
mod playback;
mod skin;
mod snapshot;
mod surface_function;
mod wgsl_names;

pub use animation::{Animation, Channel, Interpolation, Property, Track, TrackError, Transform};
pub use content::{
    Camera, Content, Light, LightKind, MeshNode, ParamValue, Params, Scope, ShadowFlags, ShadowNode, look_at,
    placed,
};
pub use graph::{
    AnimationKey, CameraKey, ImageKey, LightKey, MaterialKey, MeshKey, Node, NodeKey, Scene, SceneError,
    ShadowKey, SkinKey,
};
pub use material::{AlphaMode, Image, Material, TexCoord, TextureRef, UvTransform, Wrap};
pub use skin::Skin;
pub use snapshot::{CameraSnapshot, Instance, LightSnapshot, SceneSnapshot, ShadowNodeSnapshot};
pub use surface_function::{SurfaceFunction, SurfaceFunctionError};
