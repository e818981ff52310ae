//! What a shadow technique is, how techniques are found by name, and how their nodes are regrouped by light.
//!
//! A technique is a type that implements [`ShadowTechnique`] and is registered in a [`Catalog`]. For each light it
//! serves it gets a [`LightPlan`] and adds passes that leave the light's *factor* (1 lit, 0 dark) either as counts
//! in the stencil or in a visibility target. The engine shades; techniques never do.

mod area_light;
mod cache;
mod catalog;
mod culling;
mod error;
mod light_plan;
mod light_samples;
mod options;
mod receivers;
mod registry;

pub use area_light::{LightDisc, LightSize, MAX_ANGLE_DEG, MAX_RADIUS_M, disc_samples};
pub use cache::{Cache, hash_of};
pub use catalog::{Catalog, Layer, Layers, Requirements, Setting, ShadowTechnique, TechniqueEntry};
pub use error::ShadowError;
pub(crate) use light_plan::Darkening;
pub use light_plan::{Channels, LightPlan, MAX_SMOOTH_LIGHTS, View};
pub use light_samples::{MAX_LIGHT_SAMPLES, light_samples};
pub use options::{Accepts, Clash, OptionError, OptionSpec, OptionTable, Options, Word, extension_schema};
pub use receivers::receivers_for;
pub use registry::{Claim, Registry};
/// What an adapter can do beyond the basics.
pub use wgpu::Features;
