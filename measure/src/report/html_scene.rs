//! A scene's part of the page: its plane, its table, its pictures, the plan behind each point.

use maud::{Markup, html};

use super::csv::params_text;
use super::data::{Measurement, Outcome, PassReport, Point, Report, SceneReport};
use super::html::{Cell, Column, mebibytes, percent, plot, range, table};
use super::scales::{count, number};
use super::{Totals, plots};
use crate::LightError;
use crate::compare::pictures::error_key;
use crate::compare::timing::Spread;

pub(super) fn scene(report: &Report, scene: &SceneReport) -> Markup {
    let Spread { median, lower, upper, .. } = scene.unshadowed_ms;
    html! {
        section {
            h3 { (scene.name) }
            p { (scene.shows) "." }
            @if let Some(failure) = &scene.failure {
                p.bad { "Failed: " (failure) }
            } @else {
                p.facts {
                    (count(scene.triangles)) " triangles, " (scene.lights) " light" @if scene.lights != 1 { "s" }
                    ". Without shadows " (number(median)) " ms (" (range(lower, upper)) "), "
                    (scene.rounds) " rounds. Reference: " (number(scene.reference_ms / 1e3)) " s on the processor."
                }
                @if let Some(svg) = plots::scene_plane(report, scene) {
                    (plot("large", &svg, &format!("Speed against error on {}", scene.name), &html! {
                        "Medians with quartiles."
                    }))
                }
                (points(scene))
                (pictures(scene))
                @for point in &scene.points {
                    @if let Some(measurement) = point.measurement() { (behind(point, measurement)) }
                }
            }
        }
    }
}

/// A cell of what was measured; a dash where nothing was.
fn at(point: &Point, cell: fn(&Measurement) -> Cell) -> Cell {
    point.measurement().map_or_else(|| Cell::maybe(None), cell)
}

const POINTS: &[Column<Point>] = &[
    ("technique", |point| Cell::Text(point.label())),
    ("frame, ms", |point| match &point.outcome {
        Outcome::Measured(m) => Cell::of(m.shadowed_ms.median),
        Outcome::Refused(_) => Cell::Number("refused".into()),
        Outcome::Failed(_) => Cell::Number("failed".into()),
    }),
    ("quartiles", |p| at(p, |m| Cell::Number(range(m.shadowed_ms.lower, m.shadowed_ms.upper)))),
    ("ratio", |p| at(p, |m| Cell::Number(format!("{:.2}", m.ratio.median)))),
    ("passes, ms", |p| at(p, |m| Cell::maybe(passes_ms(m).map(number)))),
    ("MiB", |p| at(p, |m| Cell::Number(mebibytes(m.gpu_bytes)))),
    ("wrong", |p| at(p, |m| Cell::count(m.totals.wrong))),
    ("wrong, %", |p| at(p, |m| Cell::Number(percent(m.totals.wrong, m.totals.compared)))),
    ("leak", |p| at(p, |m| Cell::count(m.totals.leak))),
    ("false", |p| at(p, |m| Cell::count(m.totals.false_shadow))),
    ("out of band", |p| at(p, |m| Cell::ought_be_zero(m.totals.wrong_outside_band))),
    ("band", |p| at(p, |m| Cell::count(m.totals.band_pixels))),
    ("RMSE", |p| at(p, |m| Cell::of(m.totals.rmse))),
    ("mean", |p| at(p, |m| Cell::of(m.totals.signed_mean))),
    ("P99", |p| at(p, |m| Cell::of(m.totals.p99))),
    ("max", |p| at(p, |m| Cell::of(m.totals.max))),
    ("distance, px", |p| at(p, |m| Cell::maybe((m.totals.wrong > 0).then(|| distance(&m.totals))))),
    ("penumbra RMSE", |p| at(p, |m| Cell::maybe(penumbra_rmse(&m.totals)))),
    ("off its samples", |p| {
        at(p, |m| m.same_samples.map_or_else(|| Cell::maybe(None), |(_, off)| Cell::ought_be_zero(off)))
    }),
];

fn passes_ms(measurement: &Measurement) -> Option<f64> {
    measurement.passes.iter().map(|pass| pass.gpu_ms.as_ref().map(|ms| ms.median)).sum()
}

/// Infinite where a light has wrong pixels and no boundary.
fn distance(totals: &Totals) -> String {
    let length = |px: f64| if px.is_finite() { number(px) } else { "∞".into() };
    format!("{}, {}", length(totals.boundary_distance_mean_px), length(totals.boundary_distance_max_px))
}

fn penumbra_rmse(totals: &Totals) -> Option<String> {
    (totals.penumbra_pixels > 0).then(|| number(totals.penumbra_rmse))
}

fn points(scene: &SceneReport) -> Markup {
    let caption =
        "Pixels summed over lights; distance of wrong pixels from the nearest shadow boundary: mean, largest";
    let told = |point: &Point, what: &str, why: &str| {
        html! { p.soft { strong { (point.label()) } " " (what) ": " (why.trim_end_matches('.')) "." } }
    };
    html! {
        (table(caption, &scene.points, POINTS))
        @for point in &scene.points {
            @match &point.outcome {
                Outcome::Refused(why) => (told(point, "refused", why)),
                Outcome::Failed(why) => (told(point, "failed", why)),
                Outcome::Measured(_) => {}
            }
        }
    }
}

/// Each picture once, with everything that looks exactly like it.
fn pictures(scene: &SceneReport) -> Markup {
    let mut shown: Vec<(&Measurement, Vec<String>)> = Vec::new();
    for point in &scene.points {
        let Some(measurement) = point.measurement() else { continue };
        let same = |m: &Measurement| m.picture == measurement.picture && m.worst == measurement.worst;
        match shown.iter_mut().find(|(known, _)| same(known)) {
            Some((_, labels)) => labels.push(point.label()),
            None => shown.push((measurement, vec![point.label()])),
        }
    }
    let shown = shown.into_iter().map(|(measurement, labels)| (measurement, labels.join(", ")));
    html! {
        @for (measurement, labels) in shown {
            div.pictures {
                (picture(&measurement.picture, &format!("{labels}: picture"), &html! { (labels) }))
                @if let Some([light, map, reference]) = &measurement.worst {
                    (picture(map, &format!("{labels}: errors for light {light}"), &html! {
                        "where it is wrong, light " em { (light) } ": leak red, false blue, " (map_key(measurement))
                    }))
                    (picture(reference, &format!("reference factor of light {light}"), &html! {
                        "the reference’s factor of " em { (light) } ": lit white, dark black"
                    }))
                }
            }
        }
    }
}

/// What an error map shows beside leaks and false shadows: the band, or shades with their key.
fn map_key(measurement: &Measurement) -> Markup {
    if !measurement.lights.iter().any(|(_, error)| error.is_converged) {
        return html! { "band yellow" };
    }
    let stops: Vec<String> =
        error_key().iter().map(|(_, [red, green, blue])| format!("rgb({red},{green},{blue})")).collect();
    let [width, height] = measurement.judged_size_px;
    let gradient = format!(
        "display:inline-block;width:8em;height:0.8em;background:linear-gradient(to right,{})",
        stops.join(",")
    );
    html! {
        "the more the stronger: "
        span style="white-space:nowrap" { "−1 " span style=(gradient) {} " +1" }
        "; judged at " (width) "×" (height) " pixels"
    }
}

fn picture(path: &str, alt: &str, caption: &Markup) -> Markup {
    html! {
        figure {
            a href=(path) { img src=(path) alt=(alt) loading="lazy"; }
            figcaption { (caption) }
        }
    }
}

const LIGHTS: &[Column<(String, LightError)>] = &[
    ("light", |(_, error)| Cell::text(&error.name)),
    ("technique", |(technique, _)| Cell::text(technique)),
    ("judged", |(_, error)| Cell::count(error.compared)),
    ("other triangle", |(_, error)| Cell::count(error.different_triangle)),
    ("wrong", |(_, error)| Cell::count(error.wrong)),
    ("leak", |(_, error)| Cell::count(error.leak)),
    ("false", |(_, error)| Cell::count(error.false_shadow)),
    ("out of band", |(_, error)| Cell::ought_be_zero(error.wrong_outside_band)),
    ("band", |(_, error)| Cell::count(error.band_pixels)),
    ("boundary", |(_, error)| Cell::count(error.boundary_pixels)),
    ("RMSE", |(_, error)| Cell::of(error.rmse)),
    ("mean", |(_, error)| Cell::of(error.signed_mean)),
    ("P99", |(_, error)| Cell::of(error.p99)),
    ("max", |(_, error)| Cell::of(error.max)),
];

/// A pass's time; a dash without timestamps.
fn time(pass: &PassReport, pick: fn(&Spread) -> f64) -> Cell {
    Cell::maybe(pass.gpu_ms.as_ref().map(|ms| number(pick(ms))))
}

const PASSES: &[Column<PassReport>] = &[
    ("pass", |pass| Cell::text(&pass.name)),
    ("ms", |pass| time(pass, |ms| ms.median)),
    ("lower quartile", |pass| time(pass, |ms| ms.lower)),
    ("upper quartile", |pass| time(pass, |ms| ms.upper)),
    ("draws", |pass| Cell::count(pass.draws)),
    ("vertices", |pass| Cell::count(pass.vertices as usize)),
    ("why it is there", |pass| Cell::Why(pass.reason.clone())),
];

/// What is behind a point: its options, lights, passes and plan.
fn behind(point: &Point, measurement: &Measurement) -> Markup {
    let params = params_text(&point.params);
    let options = if params.is_empty() { "defaults" } else { &params };
    // A coloured factor as a whole, then its channels.
    let lights = measurement.lights.iter().flat_map(|(technique, error)| {
        std::iter::once(error).chain(&error.channels).map(|error| (technique.clone(), error.clone()))
    });
    let lights: Vec<(String, LightError)> = lights.collect();
    html! {
        details {
            summary { "Behind " (point.label()) }
            p {
                (point.technique) ": " (point.why) ". Options: " code { (options) } ". "
                (mebibytes(measurement.gpu_bytes)) " MiB on the GPU, " (mebibytes(measurement.plan_bytes))
                " MiB of them the plan’s own."
            }
            (table("Each light, in pixels", &lights, LIGHTS))
            (table("Passes, on the adapter’s clock", &measurement.passes, PASSES))
            pre tabindex="0" { (measurement.plan) }
        }
    }
}
