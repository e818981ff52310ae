//! The small mathematics everything else stands on: bounds, orientation signs, planes and projections.
//!
//! World space is right-handed with y up. Scene transforms are f64; only what reaches the GPU is rounded to
//! f32, and that rounding happens in camera-relative or mesh-relative coordinates.

mod bounds;
mod orient;
mod plane;
mod projection;

pub use bounds::Aabb;
pub use orient::{ORIENT_EPSILON, POSITION_EPSILON, facing_sign, orient_sign};
pub use plane::Plane;
pub use projection::{Projection, ViewFrustum};
