//! `report.csv`: one row for each scene, technique and setting. A value that was not measured is empty.

use shadowgraph_engine::scene::{ParamValue, Params};

use super::data::{Measurement, Outcome, Point, Report, SceneReport};

/// The columns, in order. Units are in their names; error columns are those of all lights together.
pub(super) const COLUMNS: [&str; 51] = [
    "scene",
    "technique",
    "setting",
    "params",
    "status",
    "reason",
    "width_px",
    "height_px",
    "triangles",
    "lights",
    "rounds",
    "unshadowed_median_ms",
    "unshadowed_lower_quartile_ms",
    "unshadowed_upper_quartile_ms",
    "shadowed_median_ms",
    "shadowed_lower_quartile_ms",
    "shadowed_upper_quartile_ms",
    "ratio_median",
    "ratio_lower_quartile",
    "ratio_upper_quartile",
    "gpu_median_ms",
    "gpu_bytes",
    "plan_bytes",
    "compared_px",
    "different_triangle_px",
    "boundary_px",
    "band_px",
    "wrong_px",
    "leak_px",
    "false_px",
    "wrong_outside_band_px",
    "leak_outside_band_px",
    "false_outside_band_px",
    "rmse",
    "rmse_outside_band",
    "penumbra_px",
    "penumbra_rmse",
    "signed_mean",
    "p99",
    "max",
    "max_outside_band",
    "boundary_distance_mean_px",
    "boundary_distance_max_px",
    "exact",
    "judged_width_px",
    "judged_height_px",
    "leak_mean",
    "false_mean",
    "outside_bounds_px",
    "same_samples",
    "outside_samples_px",
];

pub(super) fn table(report: &Report) -> String {
    let mut rows = vec![COLUMNS.map(String::from).to_vec()];
    for scene in &report.scenes {
        if let Some(failure) = &scene.failure {
            let mut row = vec![String::new(); COLUMNS.len()];
            row[0] = scene.name.clone();
            row[4] = "failed".into();
            row[5] = failure.clone();
            rows.push(row);
        }
        rows.extend(scene.points.iter().map(|point| row(report, scene, point)));
    }
    let line = |row: &Vec<String>| row.iter().map(|cell| quoted(cell)).collect::<Vec<_>>().join(",");
    rows.iter().map(|row| line(row) + "\n").collect()
}

fn row(report: &Report, scene: &SceneReport, point: &Point) -> Vec<String> {
    let (status, reason) = match &point.outcome {
        Outcome::Measured(_) => ("measured", ""),
        Outcome::Refused(reason) => ("refused", reason.as_str()),
        Outcome::Failed(reason) => ("failed", reason.as_str()),
    };
    let mut row: Vec<String> = vec![
        scene.name.clone(),
        point.technique.into(),
        point.setting.into(),
        params_text(&point.params),
        status.into(),
        reason.into(),
        report.size_px[0].to_string(),
        report.size_px[1].to_string(),
        scene.triangles.to_string(),
        scene.lights.to_string(),
        match &point.outcome {
            Outcome::Measured(measurement) => measurement.rounds.to_string(),
            _ => scene.rounds.to_string(),
        },
    ];
    let plain = &scene.unshadowed_ms;
    row.extend([plain.median, plain.lower, plain.upper].map(number));
    if let Outcome::Measured(measurement) = &point.outcome {
        row.extend(measured_cells(measurement));
    }
    row.resize(COLUMNS.len(), String::new());
    row
}

fn measured_cells(measurement: &Measurement) -> Vec<String> {
    let Measurement { shadowed_ms, ratio, totals, .. } = measurement;
    let mut cells: Vec<String> =
        [shadowed_ms.median, shadowed_ms.lower, shadowed_ms.upper, ratio.median, ratio.lower, ratio.upper]
            .map(number)
            .to_vec();
    cells.push(measurement.gpu_ms.map_or(String::new(), |ms| number(ms.median)));
    cells.extend([measurement.gpu_bytes, measurement.plan_bytes].map(|bytes| bytes.to_string()));
    let counts = [
        totals.compared,
        totals.different_triangle,
        totals.boundary_pixels,
        totals.band_pixels,
        totals.wrong,
        totals.leak,
        totals.false_shadow,
        totals.wrong_outside_band,
        totals.leak_outside_band,
        totals.false_outside_band,
    ];
    cells.extend(counts.map(|count| count.to_string()));
    cells.extend([totals.rmse, totals.rmse_outside_band].map(number));
    cells.push(totals.penumbra_pixels.to_string());
    let values = [
        totals.penumbra_rmse,
        totals.signed_mean,
        totals.p99,
        totals.max,
        totals.max_outside_band,
        totals.boundary_distance_mean_px,
        totals.boundary_distance_max_px,
    ];
    cells.extend(values.map(number));
    cells.push(totals.is_exact.to_string());
    cells.extend(measurement.judged_size_px.map(|side| side.to_string()));
    cells.extend([totals.leak_mean, totals.false_mean].map(number));
    cells.push(totals.outside_bounds.to_string());
    if let Some((count, outside)) = measurement.same_samples {
        cells.extend([count.to_string(), outside.to_string()]);
    }
    cells
}

/// As it was measured; what is infinite is empty.
fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
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

/// Quoted as RFC 4180 has it, where a cell needs it.
fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_need_it_are_quoted() {
        assert_eq!(quoted("plain"), "plain");
        assert_eq!(quoted("a \"b\", c"), "\"a \"\"b\"\", c\"");
    }

    #[test]
    fn params_are_written_as_the_command_line_takes_them() {
        let params = Params::from([
            ("color".into(), ParamValue::Numbers(vec![1.0, 0.5, 0.0])),
            ("samples".into(), ParamValue::Number(16.0)),
        ]);
        assert_eq!(params_text(&params), "color=1/0.5/0,samples=16");
    }
}
