//! What a technique's picture is worth: its factors beside the reference's, and its times.

mod distance;
mod error_table;
pub(crate) mod evaluate;
pub mod json;
mod layers;
pub(crate) mod metrics;
pub mod motion;
pub mod pictures;
pub mod timing;
mod verdict;

pub use error_table::ErrorTable;
pub use evaluate::{
    Converged, EvaluateError, Evaluation, KnownReferences, converged_queries, evaluate, evaluate_again,
    evaluate_converged, layer_measured, mean_of_samples, measured, queries, queries_with,
};
pub use layers::{LayerEvaluation, evaluate_layers};
pub use metrics::{
    BAND_FLOOR_PIXELS, BAND_PIXELS_PER_BOUNDARY_PIXEL, CompareError, DIFFERENT_FLOOR_PIXELS, LightError,
    MAX_DIFFERENT_SHARE, Measured, compare,
};
pub use verdict::{Verdict, expect_shadow};
