//! Measurements as JSON, in the one shape that every command writes.

use serde_json::{Value, json};

use super::timing::Spread;
use crate::LightError;

/// A spread of times.
pub fn spread_json(times_ms: &Spread) -> Value {
    json!({
        "median_ms": times_ms.median,
        "lower_quartile_ms": times_ms.lower,
        "upper_quartile_ms": times_ms.upper,
        "min_ms": times_ms.min,
        "max_ms": times_ms.max,
    })
}

/// Everything that was measured of one light: what belongs to penumbrae and to colours where there are any.
pub fn error_json(error: &LightError) -> Value {
    let mut entry = json!({
        "compared": error.compared,
        "different_triangle": error.different_triangle,
        "boundary_pixels": error.boundary_pixels,
        "band_pixels": error.band_pixels,
        "wrong": error.wrong,
        "leak": error.leak,
        "false": error.false_shadow,
        "wrong_outside_band": error.wrong_outside_band,
        "leak_outside_band": error.leak_outside_band,
        "false_outside_band": error.false_outside_band,
        "rmse": error.rmse,
        "signed_mean": error.signed_mean,
        "p99": error.p99,
        "max": error.max,
        "outside_bounds": error.outside_bounds,
        "boundary_distance_mean_px": finite(error.boundary_distance_mean_px),
        "boundary_distance_max_px": finite(error.boundary_distance_max_px),
        "band_px": error.band_px,
        "band_limit_px": error.band_limit_px,
        "exact": error.passes(),
        "verdict": error.verdict().to_string(),
    });
    if error.penumbra_pixels > 0 {
        entry["penumbra_pixels"] = json!(error.penumbra_pixels);
        entry["penumbra_rmse"] = json!(error.penumbra_rmse);
        entry["max_outside_band"] = json!(error.max_outside_band);
        entry["leak_mean"] = json!(error.leak_mean);
        entry["false_mean"] = json!(error.false_mean);
    }
    if let Some(count) = error.same_samples {
        entry["same_samples"] = json!(count);
    }
    if let [red, green, blue] = &error.channels[..] {
        entry["channels"] =
            json!({ "red": error_json(red), "green": error_json(green), "blue": error_json(blue) });
    }
    entry
}

/// JSON has no infinity: `null`.
pub fn finite(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}
