//! The shadow techniques of Shadowgraph, one file each.
//!
//! Every technique plugs in through `shadowgraph_engine::shadow`, as one written outside this crate does.

pub mod common;
mod shadow_map;
mod shadow_volume_hard;
mod shadow_volume_soft;
mod soft_shadow;
mod transparent_shadow;

use shadowgraph_engine::shadow::Catalog;

pub use shadow_map::{Faces, MAX_BIAS, MAX_MAP_RESOLUTION, MIN_MAP_RESOLUTION, ShadowMap};
pub use shadow_volume_hard::{
    Closure, CounterKind, DepthTest, Extrusion, GeometryMode, Passes, ShadowVolumeHard, Terminator,
};
pub use shadow_volume_soft::{Apply, Quality, ShadowVolumeSoft, layouts as soft_layouts, wedge_layouts};

pub use soft_shadow::{
    Flat, MAX_RESOLUTION, MAX_SAMPLES, MaskedCorner, NotPlanar, PlanarLight, PlanarMode, PlanarTexture,
    SoftShadow, planar_layouts,
};
pub use transparent_shadow::{Accumulate, SelfShadow, TransparentShadow, layouts as transparent_layouts};

/// A catalog with every technique of this crate.
pub fn catalog() -> Catalog {
    let mut catalog = Catalog::new();
    catalog.register(ShadowVolumeHard::ENTRY);
    catalog.register(ShadowVolumeSoft::ENTRY);
    catalog.register(SoftShadow::ENTRY);
    catalog.register(TransparentShadow::ENTRY);
    catalog.register(ShadowMap::ENTRY);
    catalog
}
