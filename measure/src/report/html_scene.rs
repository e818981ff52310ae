//! A scene's part of the page: its plane, its table, its pictures, the plan behind each point.

use super::csv::params_text;
use super::data::{Measurement, Outcome, Point, Report, SceneReport};
use super::html::{Cell, Page, mebibytes, percent};
use super::plots;
use super::scales::{count, number};
use super::svg::escaped;
use crate::compare::pictures::error_key;

pub(super) fn scene(page: &mut Page, report: &Report, scene: &SceneReport) {
    page.put(format_args!("<section><h3>{}</h3><p>{}.</p>", escaped(&scene.name), escaped(&scene.shows)));
    if let Some(failure) = &scene.failure {
        page.put(format_args!("<p class=\"bad\">Failed: {}</p></section>", escaped(failure)));
        return;
    }
    page.put(format_args!(
        "<p class=\"facts\">{} triangles, {} light{}. Without shadows {} ms ({}–{}), {} rounds. Reference: {} s on the \
         processor.</p>",
        count(scene.triangles),
        scene.lights,
        if scene.lights == 1 { "" } else { "s" },
        number(scene.unshadowed_ms.median),
        number(scene.unshadowed_ms.lower),
        number(scene.unshadowed_ms.upper),
        scene.rounds,
        number(scene.reference_ms / 1e3)
    ));
    if let Some(svg) = plots::scene_plane(report, scene) {
        page.plot(
            "large",
            &svg,
            &format!("Speed against error on {}", scene.name),
            "Medians with quartiles.",
        );
    }
    points_table(page, scene);
    pictures(page, scene);
    for point in &scene.points {
        if let Some(measurement) = point.measurement() {
            behind(page, point, measurement);
        }
    }
    page.put(format_args!("</section>"));
}

fn points_table(page: &mut Page, scene: &SceneReport) {
    let rows: Vec<Vec<Cell>> = scene
        .points
        .iter()
        .map(|point| match &point.outcome {
            Outcome::Measured(measurement) => measured_row(point, measurement),
            Outcome::Refused(_) => blank_row(point, "refused"),
            Outcome::Failed(_) => blank_row(point, "failed"),
        })
        .collect();
    let head = [
        "technique",
        "frame, ms",
        "quartiles",
        "ratio",
        "passes, ms",
        "MiB",
        "wrong",
        "wrong, %",
        "leak",
        "false",
        "out of band",
        "band",
        "RMSE",
        "mean",
        "P99",
        "max",
        "distance, px",
        "penumbra RMSE",
        "off its samples",
    ];
    page.table(
        "Pixels summed over lights; distance of wrong pixels from the nearest shadow boundary: mean, largest",
        &head,
        &rows,
    );
    for point in &scene.points {
        if let Outcome::Refused(why) | Outcome::Failed(why) = &point.outcome {
            let what = if matches!(point.outcome, Outcome::Refused(_)) { "refused" } else { "failed" };
            page.put(format_args!(
                "<p class=\"soft\"><strong>{}</strong> {what}: {}.</p>",
                escaped(&point.label()),
                escaped(why.trim_end_matches('.'))
            ));
        }
    }
}

fn measured_row(point: &Point, measurement: &Measurement) -> Vec<Cell> {
    let Measurement { shadowed_ms, ratio, totals, .. } = measurement;
    let passes_ms: Option<f64> = measurement.passes.iter().map(|p| p.gpu_ms.map(|ms| ms.median)).sum();
    let has_penumbra = totals.penumbra_pixels > 0;
    let distance = if totals.wrong == 0 {
        "–".into()
    } else {
        format!("{}, {}", length(totals.boundary_distance_mean_px), length(totals.boundary_distance_max_px))
    };
    vec![
        Cell::Text(point.label()),
        Cell::of(shadowed_ms.median),
        Cell::Number(format!("{}–{}", number(shadowed_ms.lower), number(shadowed_ms.upper))),
        Cell::Number(format!("{:.2}", ratio.median)),
        Cell::Number(passes_ms.map_or("–".into(), number)),
        Cell::Number(mebibytes(measurement.gpu_bytes)),
        Cell::count(totals.wrong),
        Cell::Number(percent(totals.wrong, totals.compared)),
        Cell::count(totals.leak),
        Cell::count(totals.false_shadow),
        Cell::ought_be_zero(totals.wrong_outside_band),
        Cell::count(totals.band_pixels),
        Cell::of(totals.rmse),
        Cell::of(totals.signed_mean),
        Cell::of(totals.p99),
        Cell::of(totals.max),
        Cell::Number(distance),
        Cell::Number(if has_penumbra { number(totals.penumbra_rmse) } else { "–".into() }),
        match measurement.same_samples {
            Some((_, outside)) => Cell::ought_be_zero(outside),
            None => Cell::Number("–".into()),
        },
    ]
}

/// Infinite where a light has wrong pixels and no boundary.
fn length(px: f64) -> String {
    if px.is_finite() { number(px) } else { "∞".into() }
}

fn blank_row(point: &Point, what: &str) -> Vec<Cell> {
    let mut row = vec![Cell::Text(point.label()), Cell::Number(what.into())];
    row.extend((0..17).map(|_| Cell::Number("–".into())));
    row
}

/// Each picture once, with everything that looks exactly like it.
fn pictures(page: &mut Page, scene: &SceneReport) {
    let mut shown: Vec<(&Measurement, Vec<String>)> = Vec::new();
    for point in &scene.points {
        let Some(measurement) = point.measurement() else { continue };
        let same = |m: &Measurement| m.picture == measurement.picture && m.worst == measurement.worst;
        match shown.iter_mut().find(|(known, _)| same(known)) {
            Some((_, labels)) => labels.push(point.label()),
            None => shown.push((measurement, vec![point.label()])),
        }
    }
    for (measurement, labels) in shown {
        let labels = escaped(&labels.join(", "));
        page.put(format_args!("<div class=\"pictures\">"));
        picture(page, &measurement.picture, &format!("{labels}: picture"), &labels);
        if let Some([light, map, reference]) = &measurement.worst {
            let light = escaped(light);
            picture(
                page,
                map,
                &format!("{labels}: errors for light {light}"),
                &format!(
                    "where it is wrong, light <em>{light}</em>: leak red, false blue, {}",
                    map_key(measurement)
                ),
            );
            picture(
                page,
                reference,
                &format!("reference factor of light {light}"),
                &format!("the reference’s factor of <em>{light}</em>: lit white, dark black"),
            );
        }
        page.put(format_args!("</div>"));
    }
}

/// What an error map shows beside leaks and false shadows: the band, or shades with their key.
fn map_key(measurement: &Measurement) -> String {
    if !measurement.lights.iter().any(|(_, error)| error.is_converged) {
        return "band yellow".into();
    }
    let stops: Vec<String> =
        error_key().iter().map(|(_, [red, green, blue])| format!("rgb({red},{green},{blue})")).collect();
    let [width, height] = measurement.judged_size_px;
    format!(
        "the more the stronger: <span style=\"white-space:nowrap\">−1 <span style=\"display:inline-block;width:8em;height:0.8em;\
         background:linear-gradient(to right,{})\"></span> +1</span>; judged at {width}×{height} pixels",
        stops.join(",")
    )
}

fn picture(page: &mut Page, path: &str, alt: &str, caption: &str) {
    page.put(format_args!(
        "<figure><a href=\"{path}\"><img src=\"{path}\" alt=\"{alt}\" loading=\"lazy\"></a><figcaption>{caption}</figcaption></figure>",
        path = escaped(path)
    ));
}

/// What is behind a point: its options, lights, passes and plan.
fn behind(page: &mut Page, point: &Point, measurement: &Measurement) {
    page.put(format_args!("<details><summary>Behind {}</summary>", escaped(&point.label())));
    let params = params_text(&point.params);
    let options = if params.is_empty() { "defaults".into() } else { params };
    page.put(format_args!(
        "<p>{}: {}. Options: <code>{}</code>. {} MiB on the GPU, {} MiB of them the plan’s own.</p>",
        escaped(point.technique),
        escaped(point.why),
        escaped(&options),
        mebibytes(measurement.gpu_bytes),
        mebibytes(measurement.plan_bytes)
    ));
    let lights: Vec<Vec<Cell>> = measurement
        .lights
        .iter()
        // A coloured factor as a whole, then its channels.
        .flat_map(|(technique, error)| {
            std::iter::once(error).chain(&error.channels).map(move |error| (technique, error))
        })
        .map(|(technique, error)| {
            vec![
                Cell::Text(error.name.clone()),
                Cell::Text(technique.clone()),
                Cell::count(error.compared),
                Cell::count(error.different_triangle),
                Cell::count(error.wrong),
                Cell::count(error.leak),
                Cell::count(error.false_shadow),
                Cell::ought_be_zero(error.wrong_outside_band),
                Cell::count(error.band_pixels),
                Cell::count(error.boundary_pixels),
                Cell::of(error.rmse),
                Cell::of(error.signed_mean),
                Cell::of(error.p99),
                Cell::of(error.max),
            ]
        })
        .collect();
    let head = [
        "light",
        "technique",
        "judged",
        "other triangle",
        "wrong",
        "leak",
        "false",
        "out of band",
        "band",
        "boundary",
        "RMSE",
        "mean",
        "P99",
        "max",
    ];
    page.table("Each light, in pixels", &head, &lights);
    let passes: Vec<Vec<Cell>> = measurement
        .passes
        .iter()
        .map(|pass| {
            let time = |pick: fn(&crate::compare::timing::Spread) -> f64| {
                Cell::Number(pass.gpu_ms.as_ref().map_or("–".into(), |ms| number(pick(ms))))
            };
            vec![
                Cell::Text(pass.name.clone()),
                time(|ms| ms.median),
                time(|ms| ms.lower),
                time(|ms| ms.upper),
                Cell::count(pass.draws),
                Cell::count(pass.vertices as usize),
                Cell::Why(pass.reason.clone()),
            ]
        })
        .collect();
    let head = ["pass", "ms", "lower quartile", "upper quartile", "draws", "vertices", "why it is there"];
    page.table("Passes, on the adapter’s clock", &head, &passes);
    page.put(format_args!("<pre tabindex=\"0\">{}</pre></details>", escaped(&measurement.plan)));
}
