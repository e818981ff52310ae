//! What the tables and plots of all scenes together are made from.

use super::data::{AxisStep, Measurement, Report};

/// One technique and setting over all scenes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct OverviewRow {
    pub(super) short_name: String,
    pub(super) label: String,
    pub(super) why: &'static str,
    /// The scenes it was measured on.
    pub(super) scenes: usize,
    /// The scenes on which anything was.
    pub(super) of: usize,
    /// The geometric mean of the scenes' median ratios, and the smallest and largest of them.
    pub(super) ratio: f64,
    pub(super) ratio_range: [f64; 2],
    pub(super) compared: usize,
    pub(super) wrong: usize,
    pub(super) wrong_outside_band: usize,
    /// Over the pixels of all scenes.
    pub(super) rmse: f64,
    pub(super) rmse_outside_band: f64,
    pub(super) gpu_bytes: u64,
}

impl OverviewRow {
    /// Whether it was measured wherever anything was: only then its means can be compared with others.
    pub(super) fn is_complete(&self) -> bool {
        self.scenes == self.of
    }
}

/// Every technique and setting that was measured anywhere.
pub(super) fn overview(report: &Report) -> Vec<OverviewRow> {
    let measured_any = |s: &&super::SceneReport| s.points.iter().any(|p| p.measurement().is_some());
    let scenes: Vec<_> = report.scenes.iter().filter(measured_any).collect();
    let mut names: Vec<(&str, &str)> = Vec::new();
    for point in scenes.iter().flat_map(|scene| &scene.points) {
        if !names.contains(&(point.short_name, point.setting)) {
            names.push((point.short_name, point.setting));
        }
    }
    let row = |(short_name, setting): (&str, &str)| {
        let points = scenes.iter().flat_map(|scene| &scene.points);
        let points: Vec<_> = points.filter(|p| (p.short_name, p.setting) == (short_name, setting)).collect();
        let found: Vec<&Measurement> = points.iter().filter_map(|p| p.measurement()).collect();
        let ratios: Vec<f64> = found.iter().map(|m| m.ratio.median.max(1e-6)).collect();
        let sum = |value: fn(&Measurement) -> usize| found.iter().map(|m| value(m)).sum::<usize>();
        let compared = sum(|m| m.totals.compared);
        let band = |m: &Measurement| m.totals.compared.saturating_sub(m.totals.band_pixels);
        let outside = found.iter().map(|m| band(m)).sum::<usize>();
        let pooled = |value: fn(&Measurement) -> f64, weight: &dyn Fn(&Measurement) -> usize, all: usize| {
            let squares = found.iter().map(|m| value(m).powi(2) * weight(m) as f64);
            (squares.sum::<f64>() / all.max(1) as f64).sqrt()
        };
        Some(OverviewRow {
            short_name: short_name.into(),
            label: points.first()?.label(),
            why: points.first()?.why,
            scenes: found.len(),
            of: scenes.len(),
            ratio: geometric_mean(&ratios)?,
            ratio_range: [
                ratios.iter().copied().fold(f64::INFINITY, f64::min),
                ratios.iter().copied().fold(0.0, f64::max),
            ],
            compared,
            wrong: sum(|m| m.totals.wrong),
            wrong_outside_band: sum(|m| m.totals.wrong_outside_band),
            rmse: pooled(|m| m.totals.rmse, &|m| m.totals.compared, compared),
            rmse_outside_band: pooled(|m| m.totals.rmse_outside_band, &band, outside),
            gpu_bytes: found.iter().map(|m| m.gpu_bytes).sum(),
        })
    };
    names.into_iter().filter_map(row).collect()
}

/// The error of no shadows at all, over the pixels of all scenes.
pub(super) fn pooled_none(report: &Report) -> Option<f64> {
    let none: Vec<_> = report.scenes.iter().filter_map(|scene| scene.none.as_ref()).collect();
    let weight = |t: &super::Totals| t.compared.saturating_sub(t.band_pixels) as f64;
    let all: f64 = none.iter().map(|t| weight(t)).sum();
    let squares: f64 = none.iter().map(|t| t.rmse_outside_band.powi(2) * weight(t)).sum();
    (all > 0.0).then(|| (squares / all).sqrt())
}

fn geometric_mean(values: &[f64]) -> Option<f64> {
    let logs = values.iter().map(|value| value.ln()).sum::<f64>();
    (!values.is_empty()).then(|| (logs / values.len() as f64).exp())
}

/// What was measured on an axis: the size and the median of what was added, in milliseconds.
pub(super) fn axis_points(steps: &[AxisStep]) -> Vec<(f64, f64)> {
    steps.iter().filter_map(|step| Some((step.value, step.outcome.measured()?.median))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_ratios_is_geometric() {
        assert!((geometric_mean(&[0.5, 2.0]).expect("there are two") - 1.0).abs() < 1e-12);
        assert_eq!(geometric_mean(&[]), None);
    }
}
