//! `report.csv`: one row for each scene, technique and setting. A value that was not measured is empty.

use serde::Serialize;
use shadowgraph_engine::scene::{ParamValue, Params};

use super::data::{Measurement, Outcome, Point, Report, SceneReport};

/// A row; its fields are the columns, in order. Units are in their names; errors are those of all lights together.
#[derive(Default, Serialize)]
struct Row<'a> {
    scene: &'a str,
    technique: &'a str,
    setting: &'a str,
    params: String,
    status: &'a str,
    reason: &'a str,
    width_px: Option<u32>,
    height_px: Option<u32>,
    triangles: Option<usize>,
    lights: Option<usize>,
    rounds: Option<usize>,
    unshadowed_median_ms: Option<f64>,
    unshadowed_lower_quartile_ms: Option<f64>,
    unshadowed_upper_quartile_ms: Option<f64>,
    shadowed_median_ms: Option<f64>,
    shadowed_lower_quartile_ms: Option<f64>,
    shadowed_upper_quartile_ms: Option<f64>,
    ratio_median: Option<f64>,
    ratio_lower_quartile: Option<f64>,
    ratio_upper_quartile: Option<f64>,
    gpu_median_ms: Option<f64>,
    gpu_bytes: Option<u64>,
    plan_bytes: Option<u64>,
    compared_px: Option<usize>,
    different_triangle_px: Option<usize>,
    boundary_px: Option<usize>,
    band_px: Option<usize>,
    wrong_px: Option<usize>,
    leak_px: Option<usize>,
    false_px: Option<usize>,
    wrong_outside_band_px: Option<usize>,
    leak_outside_band_px: Option<usize>,
    false_outside_band_px: Option<usize>,
    rmse: Option<f64>,
    rmse_outside_band: Option<f64>,
    penumbra_px: Option<usize>,
    penumbra_rmse: Option<f64>,
    signed_mean: Option<f64>,
    p99: Option<f64>,
    max: Option<f64>,
    max_outside_band: Option<f64>,
    boundary_distance_mean_px: Option<f64>,
    boundary_distance_max_px: Option<f64>,
    exact: Option<bool>,
    judged_width_px: Option<u32>,
    judged_height_px: Option<u32>,
    leak_mean: Option<f64>,
    false_mean: Option<f64>,
    outside_bounds_px: Option<usize>,
    same_samples: Option<u32>,
    outside_samples_px: Option<usize>,
}

/// The table with its header.
pub(super) fn table(report: &Report) -> Vec<u8> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let rows = report.scenes.iter().flat_map(|scene| {
        let failed = scene.failure.as_deref().map(|reason| Row {
            scene: &scene.name,
            status: "failed",
            reason,
            ..Row::default()
        });
        failed.into_iter().chain(scene.points.iter().map(|point| Row::new(report, scene, point)))
    });
    let mut is_empty = true;
    for row in rows {
        is_empty = false;
        // Rows of one struct are of one length, and memory takes what is written.
        let _ = table.serialize(row);
    }
    let bytes = table.into_inner().unwrap_or_default();
    if is_empty { header() } else { bytes }
}

/// The header alone, for a report without scenes.
fn header() -> Vec<u8> {
    let mut table = csv::Writer::from_writer(Vec::new());
    let _ = table.serialize(Row::default());
    let bytes = table.into_inner().unwrap_or_default();
    let end = bytes.iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |place| place + 1);
    bytes[..end].to_vec()
}

impl<'a> Row<'a> {
    fn new(report: &Report, scene: &'a SceneReport, point: &'a Point) -> Self {
        let (status, reason) = match &point.outcome {
            Outcome::Measured(_) => ("measured", ""),
            Outcome::Refused(reason) => ("refused", reason.as_str()),
            Outcome::Failed(reason) => ("failed", reason.as_str()),
        };
        let plain = &scene.unshadowed_ms;
        let row = Self {
            scene: &scene.name,
            technique: point.technique,
            setting: point.setting,
            params: params_text(&point.params),
            status,
            reason,
            width_px: Some(report.size_px[0]),
            height_px: Some(report.size_px[1]),
            triangles: Some(scene.triangles),
            lights: Some(scene.lights),
            rounds: Some(scene.rounds),
            unshadowed_median_ms: number(plain.median),
            unshadowed_lower_quartile_ms: number(plain.lower),
            unshadowed_upper_quartile_ms: number(plain.upper),
            ..Self::default()
        };
        match &point.outcome {
            Outcome::Measured(measurement) => row.measured(measurement),
            Outcome::Refused(_) | Outcome::Failed(_) => row,
        }
    }

    /// The row with what was measured.
    fn measured(self, measurement: &Measurement) -> Self {
        let Measurement { shadowed_ms, ratio, totals, .. } = measurement;
        Self {
            rounds: Some(measurement.rounds),
            shadowed_median_ms: number(shadowed_ms.median),
            shadowed_lower_quartile_ms: number(shadowed_ms.lower),
            shadowed_upper_quartile_ms: number(shadowed_ms.upper),
            ratio_median: number(ratio.median),
            ratio_lower_quartile: number(ratio.lower),
            ratio_upper_quartile: number(ratio.upper),
            gpu_median_ms: measurement.gpu_ms.as_ref().and_then(|ms| number(ms.median)),
            gpu_bytes: Some(measurement.gpu_bytes),
            plan_bytes: Some(measurement.plan_bytes),
            compared_px: Some(totals.compared),
            different_triangle_px: Some(totals.different_triangle),
            boundary_px: Some(totals.boundary_pixels),
            band_px: Some(totals.band_pixels),
            wrong_px: Some(totals.wrong),
            leak_px: Some(totals.leak),
            false_px: Some(totals.false_shadow),
            wrong_outside_band_px: Some(totals.wrong_outside_band),
            leak_outside_band_px: Some(totals.leak_outside_band),
            false_outside_band_px: Some(totals.false_outside_band),
            rmse: number(totals.rmse),
            rmse_outside_band: number(totals.rmse_outside_band),
            penumbra_px: Some(totals.penumbra_pixels),
            penumbra_rmse: number(totals.penumbra_rmse),
            signed_mean: number(totals.signed_mean),
            p99: number(totals.p99),
            max: number(totals.max),
            max_outside_band: number(totals.max_outside_band),
            boundary_distance_mean_px: number(totals.boundary_distance_mean_px),
            boundary_distance_max_px: number(totals.boundary_distance_max_px),
            exact: Some(totals.is_exact),
            judged_width_px: Some(measurement.judged_size_px[0]),
            judged_height_px: Some(measurement.judged_size_px[1]),
            leak_mean: number(totals.leak_mean),
            false_mean: number(totals.false_mean),
            outside_bounds_px: Some(totals.outside_bounds),
            same_samples: measurement.same_samples.map(|(count, _)| count),
            outside_samples_px: measurement.same_samples.map(|(_, outside)| outside),
            ..self
        }
    }
}

/// As it was measured; what is infinite is empty.
fn number(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

/// `key=value` pairs as the command line takes them.
pub(super) fn params_text(params: &Params) -> String {
    let value = |value: &ParamValue| match value {
        ParamValue::Text(text) => text.clone(),
        ParamValue::Number(number) => number.to_string(),
        ParamValue::Flag(flag) => flag.to_string(),
        ParamValue::Numbers(numbers) => numbers.iter().map(f64::to_string).collect::<Vec<_>>().join("/"),
    };
    params.iter().map(|(name, v)| format!("{name}={}", value(v))).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn params_are_written_as_the_command_line_takes_them() {
        let params = Params::from([
            ("color".into(), ParamValue::Numbers(vec![1.0, 0.5, 0.0])),
            ("samples".into(), ParamValue::Number(16.0)),
        ]);
        assert_eq!(params_text(&params), "color=1/0.5/0,samples=16");
    }
}
