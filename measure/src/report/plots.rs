//! The plots of the report.

use super::data::{AxisReport, AxisStep, Report, SceneReport, SweepReport, SweepStep};
use super::fit::fit;
use super::pareto::front;
use super::plot::{AxisOf, Layout, Mark, Plot};
use super::scales::number;
use super::svg::Svg;
use super::tables::axis_points;
use super::totals::Totals;
use super::{style, tables};
use crate::cases::sweeps::ShowsIn;

/// The main plot's file.
pub(super) const MAIN: &str = "speed-error.svg";

/// Every plot as a file of its own: its name and its text.
pub(super) fn standalone(report: &Report) -> Vec<(String, String)> {
    let mut plots = Vec::new();
    let style = style::standalone();
    let mut put = |name: String, title: &str, svg: &Svg| plots.push((name, svg.standalone(title, &style)));
    if let Some(svg) = overview(report) {
        put(MAIN.into(), "Speed against error, all scenes", &svg);
    }
    for axis in &report.axes {
        put(format!("cost-{}.svg", axis.parameter), &format!("Cost against {}", axis.parameter), &cost(axis));
    }
    for sweep in &report.sweeps {
        put(format!("sweep-{}.svg", sweep.id), &format!("Error against {}", sweep.parameter), &error(sweep));
        if let Some(svg) = qualities(sweep) {
            put(format!("quality-{}.svg", sweep.id), &qualities_title(sweep), &svg);
        }
    }
    plots
}

const COST_TITLE: &str = "time of a frame, as a multiple of the frame without shadows";
/// What every scale of errors covers, so that plots look alike: from one pixel in a hundred million wrong to all.
const WHOLE_RANGE: [f64; 2] = [1e-4, 1.0];
const ERROR_TITLE: &str = "error outside the ambiguity band (RMSE)";

/// The number that a technique's colour and shape come from.
fn series(report: &Report, short_name: &str) -> Option<usize> {
    report.techniques.iter().position(|[_, name, _]| *name == short_name)
}

/// A point of a speed–error plane.
struct PlanePoint {
    series: Option<usize>,
    label: String,
    cost: f64,
    spread: Option<[f64; 2]>,
    error: f64,
    /// Whether it may be compared with the others: it was measured wherever they were.
    is_complete: bool,
    title: String,
}

/// All scenes in one plane.
pub(super) fn overview(report: &Report) -> Option<Svg> {
    let mut points: Vec<PlanePoint> = tables::overview(report)
        .into_iter()
        .map(|row| {
            let share = format!("{} of {} scenes", row.scenes, row.of);
            let label =
                if row.is_complete() { row.label.clone() } else { format!("{} ({share})", row.label) };
            PlanePoint {
                series: series(report, &row.short_name),
                title: format!(
                    "{}: {} times the frame without shadows, RMSE {} outside the band, {share}",
                    row.label,
                    number(row.ratio),
                    number(row.rmse_outside_band)
                ),
                label,
                cost: row.ratio,
                // Scenes differ far more than rounds do: their range stands in the table.
                spread: None,
                error: row.rmse_outside_band,
                is_complete: row.is_complete(),
            }
        })
        .collect();
    if points.is_empty() {
        return None;
    }
    points.extend(tables::pooled_none(report).map(none_point));
    let [width, height] = report.size_px;
    Some(plane(&points, &format!("{width}×{height}, {}", report.adapter)))
}

/// One scene in a plane.
pub(super) fn scene_plane(report: &Report, scene: &SceneReport) -> Option<Svg> {
    let mut points: Vec<PlanePoint> = scene
        .points
        .iter()
        .filter_map(|point| {
            let measurement = point.measurement()?;
            let (ratio, totals) = (measurement.ratio, &measurement.totals);
            Some(PlanePoint {
                series: series(report, point.short_name),
                label: point.label(),
                cost: ratio.median,
                spread: Some([ratio.lower, ratio.upper]),
                error: totals.rmse_outside_band,
                is_complete: true,
                title: format!(
                    "{}: {} ms, {} times the frame without shadows; RMSE {} outside the band, {} over all pixels",
                    point.label(),
                    number(measurement.shadowed_ms.median),
                    number(ratio.median),
                    number(totals.rmse_outside_band),
                    number(totals.rmse)
                ),
            })
        })
        .collect();
    if points.is_empty() {
        return None;
    }
    points.extend(scene.none.as_ref().map(|none| none_point(none.rmse_outside_band)));
    if scene.reference_ms > 0.0 && scene.unshadowed_ms.median > 0.0 {
        let cost = scene.reference_ms / scene.unshadowed_ms.median;
        points.push(PlanePoint {
            series: None,
            label: "reference".into(),
            cost,
            spread: None,
            error: 0.0,
            is_complete: true,
            title: format!("the reference: traced on the CPU in {} ms", number(scene.reference_ms)),
        });
    }
    Some(plane(&points, ""))
}

fn none_point(error: f64) -> PlanePoint {
    PlanePoint {
        series: None,
        label: "none".into(),
        cost: 1.0,
        spread: None,
        error,
        is_complete: true,
        title: format!("no shadows at all: RMSE {} outside the band", number(error)),
    }
}

fn plane(points: &[PlanePoint], remark: &str) -> Svg {
    let spreads = points.iter().filter_map(|p| p.spread).flatten();
    let x = AxisOf {
        title: COST_TITLE,
        values: points.iter().map(|p| p.cost).chain(spreads).collect(),
        is_log: true,
        least: 4.0,
    };
    let y = AxisOf {
        title: ERROR_TITLE,
        values: points.iter().map(|p| p.error).chain(WHOLE_RANGE).collect(),
        is_log: true,
        least: 1.0,
    };
    let mut plot = Plot::new(Layout::LARGE, &x, &y, Some("exact"));
    let complete: Vec<&PlanePoint> = points.iter().filter(|p| p.is_complete).collect();
    let costs: Vec<(f64, f64)> = complete.iter().map(|p| (p.cost, p.error)).collect();
    let front: Vec<[f64; 2]> =
        front(&costs).into_iter().map(|i| [complete[i].cost, complete[i].error]).collect();
    plot.stairs("front", &front);
    plot.remark(remark);
    for point in points {
        plot.mark(&Mark {
            at: [point.cost, point.error],
            x_spread: point.spread,
            y_spread: None,
            class: if point.is_complete { "" } else { "hollow" },
            shape: point.series.unwrap_or(6),
            series: point.series,
            title: point.title.clone(),
            label: point.label.clone(),
        });
    }
    plot.finish()
}

/// Cost against the size of one thing.
pub(super) fn cost(axis: &AxisReport) -> Svg {
    let medians = |steps: &[AxisStep]| axis_points(steps);
    let added = axis.techniques.iter().flat_map(|(_, steps)| steps);
    let added = added.filter_map(|step| step.outcome.measured());
    let spreads = axis.unshadowed_ms.iter().map(|(_, ms)| ms).chain(added);
    let x = AxisOf {
        title: axis.parameter,
        values: axis.unshadowed_ms.iter().map(|(value, _)| *value).collect(),
        is_log: true,
        least: 10.0,
    };
    let y = AxisOf {
        title: "ms",
        values: spreads.flat_map(|ms| [ms.lower, ms.median, ms.upper]).collect(),
        is_log: true,
        least: 10.0,
    };
    let mut plot = Plot::new(Layout::LINES, &x, &y, None);
    let plain: Vec<[f64; 2]> = axis.unshadowed_ms.iter().map(|(value, ms)| [*value, ms.median]).collect();
    plot.line("line end", &plain);
    for (value, ms) in &axis.unshadowed_ms {
        plot.mark(&Mark {
            at: [*value, ms.median],
            x_spread: None,
            y_spread: Some([ms.lower, ms.upper]),
            class: "",
            shape: 6,
            series: None,
            title: format!("frame without shadows: {} ms", number(ms.median)),
            label: String::new(),
        });
    }
    if let Some(last) = plain.last() {
        plot.label(*last, None, "without shadows");
    }
    for (index, (name, steps)) in axis.techniques.iter().enumerate() {
        let points = medians(steps);
        let line: Vec<[f64; 2]> = points.iter().map(|(x, y)| [*x, *y]).collect();
        let color = Mark::color(Some(index));
        plot.line(&format!("line {color}"), &line);
        for step in steps {
            let Some(ms) = step.outcome.measured() else { continue };
            plot.mark(&Mark {
                at: [step.value, ms.median],
                x_spread: None,
                y_spread: Some([ms.lower, ms.upper]),
                class: "",
                shape: index,
                series: Some(index),
                title: format!("{name} adds {} ms at {}", number(ms.median), number(step.value)),
                label: String::new(),
            });
        }
        if let Some(fit) = fit(&points) {
            plot.line(&format!("fit {color}"), &fit.range.map(|x| [x, fit.at(x)]));
        }
        if let Some(last) = line.last() {
            plot.label(*last, Some(index), &format!("{name} adds"));
        }
    }
    plot.finish()
}

/// What [`qualities`] plots.
pub(super) fn qualities_title(sweep: &SweepReport) -> String {
    let of = match sweep.option.map(|swept| swept.shows_in) {
        Some(ShowsIn::Penumbrae) => "Error in penumbrae",
        Some(ShowsIn::Edges) => "Distance of edges",
        None => "Error of each setting",
    };
    format!("{of} against {}", sweep.parameter)
}

/// The error of every quality setting against an option of theirs, where that shows, or of one technique's settings that
/// a sweep compares, outside the band; `None` where a sweep does neither, or it shows nowhere.
pub(super) fn qualities(sweep: &SweepReport) -> Option<Svg> {
    let shows_in = sweep.option.map(|swept| swept.shows_in);
    if shows_in.is_none() && sweep.compares.is_none() {
        return None;
    }
    let is_compared = |name: &str| {
        let of = |short: &str| {
            name.strip_prefix(short).is_some_and(|rest| rest.is_empty() || rest.starts_with(' '))
        };
        shows_in.is_some() || sweep.compares.is_some_and(of)
    };
    let error = |totals: &Totals| match shows_in {
        Some(ShowsIn::Penumbrae) => (totals.penumbra_pixels > 0).then_some(totals.penumbra_rmse),
        Some(ShowsIn::Edges) => (totals.penumbra_pixels == 0).then(|| totals.edge_distance_px()),
        None => Some(totals.rmse_outside_band),
    };
    let (title, unit, place) = match shows_in {
        Some(ShowsIn::Penumbrae) => ("penumbra RMSE", "RMSE", "in the penumbra"),
        Some(ShowsIn::Edges) => ("edges off, px", "px", "from the edge on average"),
        None => (ERROR_TITLE, "RMSE", "outside the band"),
    };
    let judged = |(index, (name, steps)): (usize, &(String, Vec<SweepStep>))| {
        let points: Vec<[f64; 2]> =
            steps.iter().filter_map(|step| Some([step.value, error(step.outcome.measured()?)?])).collect();
        (!points.is_empty() && is_compared(name)).then(|| (index, name.clone(), points))
    };
    let lines: Vec<_> = sweep.techniques.iter().enumerate().filter_map(judged).collect();
    if lines.is_empty() {
        return None;
    }
    let all = || lines.iter().flat_map(|(_, _, points)| points);
    let x = AxisOf {
        title: if sweep.unit.is_empty() { sweep.parameter } else { sweep.unit },
        values: all().map(|[value, _]| *value).collect(),
        is_log: sweep.is_log,
        least: 10.0,
    };
    let y = AxisOf {
        title,
        values: all().map(|[_, error]| *error).chain([1e-3, 1.0]).collect(),
        is_log: true,
        least: 1.0,
    };
    let mut plot = Plot::new(Layout::LINES, &x, &y, Some("0"));
    for (index, name, points) in &lines {
        plot.line(&format!("line {}", Mark::color(Some(*index))), points);
        for [value, error] in points {
            plot.mark(&Mark {
                at: [*value, *error],
                x_spread: None,
                y_spread: None,
                class: "",
                shape: *index,
                series: Some(*index),
                title: format!("{name} at {}: {} {unit} {place}", number(*value), number(*error)),
                label: String::new(),
            });
        }
        if let Some(last) = points.last() {
            plot.label(*last, Some(*index), name);
        }
    }
    Some(plot.finish())
}

/// Error against one parameter: filled outside the band, hollow over all pixels.
pub(super) fn error(sweep: &SweepReport) -> Svg {
    let measured = || sweep.techniques.iter().flat_map(|(_, steps)| steps);
    let totals = || measured().filter_map(|step| step.outcome.measured());
    // What is swept stands in the caption.
    let title = if sweep.unit.is_empty() { "factor" } else { sweep.unit };
    let x = AxisOf {
        title,
        values: measured().map(|step| step.value).collect(),
        is_log: sweep.is_log,
        least: 10.0,
    };
    let errors = totals().flat_map(|totals| [totals.rmse, totals.rmse_outside_band]);
    let y = AxisOf { title: "RMSE", values: errors.chain(WHOLE_RANGE).collect(), is_log: true, least: 1.0 };
    let mut plot = Plot::new(Layout::SMALL, &x, &y, Some("0"));
    for (index, (name, steps)) in sweep.techniques.iter().enumerate() {
        for (class, value) in
            [("hollow", (|t| t.rmse) as fn(&Totals) -> f64), ("", |t: &Totals| t.rmse_outside_band)]
        {
            for step in steps {
                let Some(totals) = step.outcome.measured() else { continue };
                plot.mark(&Mark {
                    at: [step.value, value(totals)],
                    x_spread: None,
                    y_spread: None,
                    class,
                    shape: index,
                    series: Some(index),
                    title: format!(
                        "{name} at {}: RMSE {} over all pixels, {} outside the band",
                        number(step.value),
                        number(totals.rmse),
                        number(totals.rmse_outside_band)
                    ),
                    label: String::new(),
                });
            }
        }
    }
    let refused = measured().filter(|step| step.outcome.measured().is_none()).count();
    if refused > 0 {
        plot.remark(&format!("{refused} not measured"));
    }
    plot.finish()
}
