//! What a shadow technique is, how techniques are found by name, and how their nodes are regrouped by light.
//!
//! A technique is a type that implements [`ShadowTechnique`] and is registered in a [`Catalog`]. For each light it
//! serves it gets a [`LightContext`], adds passes to a [`PassList`] that leave the light's *factor* (1 lit, 0 dark) as
//! counts in the stencil or in the light's visibility, and returns a [`Contribution`] that says which. The engine shades;
//! techniques never do.

mod area_light;
mod cache;
mod catalog;
mod contribution;
mod culling;
mod error;
mod light_context;
mod light_samples;
mod options;
mod pass_list;
mod receivers;
mod registry;

pub use area_light::{LightDisc, LightSize, MAX_ANGLE_DEG, MAX_RADIUS_M, disc_samples};
pub use cache::{Cache, hash_of};
pub use catalog::{Catalog, Layer, Layers, Setting, ShadowTechnique, TechniqueEntry, Traits};
pub use contribution::{Apply, Channels, Contribution};
pub use error::ShadowError;
pub(crate) use light_context::CountsBefore;
pub use light_context::{LightContext, MAX_SMOOTH_LIGHTS, View};
pub use light_samples::{MAX_LIGHT_SAMPLES, light_samples};
pub use options::{Accepts, Clash, OptionError, OptionSpec, OptionTable, Options, Word, extension_schema};
pub use pass_list::{Binding, ColorTarget, DepthTarget, Draw, Geometry, Pass, PassList};
pub use receivers::receivers_for;
pub use registry::{Claim, Registry};
/// What an adapter can do beyond the basics.
pub use wgpu::Features;
