//! The measures: an exact reference for hard shadows and for lights with a size, and what a technique's picture is worth beside it.
//!
//! [`Reference`] shoots its own rays at the posed scene in f64 and says for every pixel which triangle is seen and
//! whether each light reaches it. [`compare`] puts a technique's factors beside it and counts what is wrong,
//! [`expect_shadow`] refuses a comparison in which there was nothing to get wrong, and [`pictures`] writes both down.
//! Nothing here shares a line with the techniques it judges, except the orientation signs of
//! [`shadowgraph_engine::math`].

mod answers;
mod area;
#[cfg(test)]
mod area_tests;
mod bvh;
mod cover;
mod coverage;
mod disc;
mod distance;
mod error_table;
mod evaluate;
mod forms;
mod glass;
mod holes;
pub mod json;
mod layers;
mod metrics;
mod moved;
pub mod pictures;
mod query;
mod reference;
mod render;
pub mod report;
mod samples;
mod surface;
mod technique;
mod ties;
pub mod timing;
mod verdict;
mod view;
mod way;

pub use area::{CONVERGED_SAMPLES, Samples, SizedCasters, SoftBounds};
pub use coverage::convex_visible_share;
pub use error_table::ErrorTable;
pub use evaluate::{
    Converged, EvaluateError, Evaluation, KnownReferences, converged_queries, evaluate, evaluate_again,
    evaluate_converged, layer_measured, mean_of_samples, measured, queries, queries_with,
};
pub use layers::{LayerEvaluation, evaluate_layers};
pub use metrics::{
    BAND_FLOOR_PIXELS, BAND_PIXELS_PER_BOUNDARY_PIXEL, CompareError, DIFFERENT_FLOOR_PIXELS, HALF_FLOAT_LOSS,
    LightError, MAX_DIFFERENT_SHARE, Measured, compare,
};
pub use reference::{CasterSet, Hit, Reference, Tracer};
pub use render::{
    CORNER_SNAP, DEPTH_ULPS, GRAZED, LightQuery, LightReference, PIXEL_MOVE, PixelReference, Progress,
    ReferenceImage, SupersampledImage,
};
pub use shadowgraph_engine::shadow::{LightSize, disc_samples, light_samples};
pub use technique::{OnTransparent, ReferenceShadow};
pub use verdict::{Verdict, expect_shadow};
