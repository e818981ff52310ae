//! The exact reference: an f64 tracer that says for every pixel which triangle is seen and how much of each light arrives.
//!
//! It shares no line with the techniques it judges, which this crate cannot even name; only the orientation signs of
//! [`shadowgraph_engine::math`] are the engine's.

pub(crate) mod answers;
pub(crate) mod area;
#[cfg(test)]
mod area_tests;
mod bvh;
pub(crate) mod channels;
mod cover;
mod coverage;
mod disc;
mod disc_panes;
mod far_casters;
mod forms;
mod glass;
mod holes;
pub(crate) mod moved;
pub(crate) mod query;
pub(crate) mod render;
mod samples;
pub(crate) mod surface;
mod technique;
mod ties;
pub(crate) mod tracer;
pub(crate) mod view;
mod way;

pub use area::{CONVERGED_SAMPLES, Samples, SizedCasters, SoftBounds};
pub use channels::HALF_FLOAT_LOSS;
pub use coverage::convex_visible_share;
pub use render::{
    CORNER_SNAP, DEPTH_ULPS, GRAZED, LightQuery, LightReference, PIXEL_MOVE, PixelReference, Progress,
    ReferenceImage, SupersampledImage,
};
pub use technique::{OnTransparent, ReferenceShadow};
pub use tracer::{CasterSet, Hit, Reference, Tracer};
