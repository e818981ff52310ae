//! Shadowgraph: a small scene-graph engine in which every shadow is a node you plug in, and every node tells you how
//! fast and how wrong it is.
//!
//! This crate is the facade: the engine, the techniques, and what measures them. See [`prelude`] for the names a
//! program needs.
//!
//! ```no_run
//! use shadowgraph::prelude::*;
//!
//! fn main() -> Result<(), Box<dyn std::error::Error>> {
//!     let mut scene = Scene::new();
//!     let floor = Mesh::new(shapes::plane(Vec2::splat(20.0)))?;
//!     let body = Mesh::new(shapes::cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)))?;
//!     scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
//!     scene.add_mesh(body, Material::default(), DAffine3::from_translation(DVec3::Y));
//!     scene.add_lamp(Light::point("lamp", 40.0), DVec3::new(2.0, 5.0, 1.0));
//!     scene.add_shadow("shadows", ShadowVolumeHard::default());
//!
//!     let camera = Camera::perspective("eye", 0.8);
//!     let camera = CameraSnapshot::looking(camera, DVec3::new(4.0, 3.0, 5.0), DVec3::ZERO);
//!     let picture = Renderer::open()?.picture(&scene, &camera, [640, 480])?;
//!     picture.save("out/first_picture.png")?;
//!     Ok(())
//! }
//! ```

pub mod demo;
pub mod papers;
mod picture;
pub mod search;

pub use shadowgraph_engine as engine;
pub use shadowgraph_measure as measure;
pub use shadowgraph_measure::cases;
pub use shadowgraph_nodes as nodes;
pub use shadowgraph_shaders as shaders;

/// The techniques that have a part in the hard cases' scenes.
pub const CAST: cases::Cast = cases::Cast {
    tried: nodes::ShadowVolumeHard::ENTRY.type_name,
    sized: nodes::ShadowVolumeSoft::ENTRY.type_name,
};

pub use picture::{Picture, Pictures, SaveError};

/// What most programs need.
pub mod prelude {
    pub use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec3};
    pub use shadowgraph_engine::geometry::{Influences, Mesh, MeshData, MorphTarget, shapes};
    pub use shadowgraph_engine::gpu::{AdapterChoice, Gpu, Timing};
    pub use shadowgraph_engine::plan::Antialias;
    pub use shadowgraph_engine::render::{
        Exposure, FrameRequest, PictureFormat, RenderError, RenderOptions, Renderer,
    };
    pub use shadowgraph_engine::scene::{
        Animation, Camera, CameraSnapshot, Channel, Content, Interpolation, Light, Material, MeshNode,
        Property, Scene, Scope, ShadowNode, Skin, SurfaceFunction, Track, Transform,
    };
    pub use shadowgraph_nodes::{
        self, Accumulate, Apply, Closure, CounterKind, DepthTest, Extrusion, Faces, GeometryMode, Passes,
        PlanarMode, PointFormat, Quality, SelfShadow, ShadowMap, ShadowVolumeHard, ShadowVolumeSoft,
        SilhouetteMap, SoftShadow, Terminator, TransparentShadow,
    };

    pub use crate::{Picture, Pictures};
}

/// What a technique of one's own is written with; see "Writing a technique" in ARCHITECTURE.md. Its options derive serde's
/// `Serialize` and `Deserialize` and schemars' `JsonSchema`.
pub mod technique {
    pub use shadowgraph_engine::plan::{
        BufferDesc, CompareFunction, DrawState, MULTIPLY, Shader, TextureDesc,
    };
    pub use shadowgraph_engine::scene::{Instance, Params};
    pub use shadowgraph_engine::shadow::{
        Apply, Binding, Channels, ColorTarget, Contribution, DepthTarget, Draw, Features, Geometry,
        LightContext, Options, Pass, PassList, Setting, ShadowError, ShadowTechnique, TechniqueEntry, Traits,
        hash_of,
    };
}
