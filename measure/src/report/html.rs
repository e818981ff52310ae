//! `index.html`: one page that opens from disk.

use std::fmt::Write;

use super::data::{Outcome, Report};
use super::html_scene;
use super::scales::{count, number};
use super::svg::{Svg, escaped};
use super::{fit, plots, style, tables};

/// A page under construction.
pub(super) struct Page(String);

impl Page {
    /// Markup as it is.
    pub(super) fn put(&mut self, markup: std::fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.0, "{markup}");
    }

    /// A table in a box of its own that scrolls where the screen is narrow. Numbers stand to the right.
    pub(super) fn table(&mut self, caption: &str, head: &[&str], rows: &[Vec<Cell>]) {
        self.put(format_args!(
            "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{caption}\"><table><caption>{caption}</caption><thead><tr>",
            caption = escaped(caption)
        ));
        for (column, name) in head.iter().enumerate() {
            let class = match rows.first().and_then(|row| row.get(column)) {
                Some(Cell::Number(_)) => " class=\"n\"",
                _ => "",
            };
            self.put(format_args!("<th scope=\"col\"{class}>{}</th>", escaped(name)));
        }
        self.put(format_args!("</tr></thead><tbody>"));
        for row in rows {
            let cells: String = row.iter().map(Cell::markup).collect();
            self.put(format_args!("<tr>{cells}</tr>"));
        }
        self.put(format_args!("</tbody></table></div>"));
    }

    /// A plot with its caption; `size` is a class: `large`, `lines` or `small`.
    pub(super) fn plot(&mut self, size: &str, svg: &Svg, title: &str, caption: &str) {
        self.put(format_args!(
            "<figure><div class=\"scroll plot {size}\">{}</div><figcaption>{caption}</figcaption></figure>",
            svg.inline(title)
        ));
    }
}

/// A cell of a table.
pub(super) enum Cell {
    Text(String),
    Number(String),
    /// A longer text that may wrap.
    Why(String),
    /// A number that should not be there.
    Bad(String),
}

impl Cell {
    /// A number as readers like it.
    pub(super) fn of(value: f64) -> Self {
        Self::Number(number(value))
    }

    /// A whole number, every digit of it.
    pub(super) fn count(value: usize) -> Self {
        Self::Number(count(value))
    }

    /// A count that ought to be 0.
    pub(super) fn ought_be_zero(value: usize) -> Self {
        if value == 0 { Self::count(0) } else { Self::Bad(count(value)) }
    }

    fn markup(&self) -> String {
        match self {
            Self::Text(text) => format!("<td>{}</td>", escaped(text)),
            Self::Number(text) => format!("<td class=\"n\">{}</td>", escaped(text)),
            Self::Why(text) => format!("<td class=\"why\">{}</td>", escaped(text)),
            Self::Bad(text) => format!("<td class=\"n bad\"><strong>{}</strong></td>", escaped(text)),
        }
    }
}

pub(super) fn page(report: &Report) -> String {
    let mut page = Page(String::new());
    let style = style::variables() + &style::plot_rules() + style::PAGE_RULES;
    page.put(format_args!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width, initial-scale=1\">\n<title>Shadowgraph: speed against error</title>\n\
         <style>{style}</style>\n</head>\n<body>\n<header>\n<h1>Speed against error</h1>"
    ));
    let [width, height] = report.size_px;
    page.put(format_args!(
        "<p class=\"facts\">Adapter: <strong>{}</strong>. Scenes at {width}×{height} pixels, {} processors, effort \
         “{}”, Shadowgraph {}.</p>",
        escaped(&report.adapter),
        report.processors,
        report.effort,
        env!("CARGO_PKG_VERSION")
    ));
    page.put(format_args!(
        "<ul class=\"nav\"><li><a href=\"#how\">How to read it</a></li><li><a href=\"#all\">All scenes</a></li>\
         <li><a href=\"#scenes\">Scene by scene</a></li><li><a href=\"#cost\">Cost against size</a></li>\
         <li><a href=\"#sweeps\">Error against parameters</a></li><li><a href=\"#refused\">Refused and failed</a></li>\
         <li><a href=\"report.csv\">CSV</a></li><li><a href=\"report.json\">JSON</a></li></ul>\n</header>\n<main>"
    ));
    how_to_read(&mut page);
    all_scenes(&mut page, report);
    page.put(format_args!("<section id=\"scenes\"><h2>Scene by scene</h2>"));
    if report.scenes.is_empty() {
        page.put(format_args!("<p class=\"soft\">Not measured in this run.</p>"));
    }
    for scene in &report.scenes {
        html_scene::scene(&mut page, report, scene);
    }
    page.put(format_args!("</section>"));
    cost(&mut page, report);
    sweeps(&mut page, report);
    refused(&mut page, report);
    page.put(format_args!("</main>\n</body>\n</html>"));
    page.0
}

fn how_to_read(page: &mut Page) {
    page.put(format_args!(
        "<section id=\"how\"><h2>How to read it</h2>\
<p>Every point is one technique with one quality setting. <strong>Further left is faster, further down is more \
right.</strong> The dotted stairs are the Pareto front: what stands on them is beaten by nothing in both at once.</p>\
<dl><dt>Time</dt><dd>A whole frame on the wall clock, divided by the same frame without shadows. All settings of a scene \
and the frame without shadows are rendered in turn, so that both see the same machine. Marks are medians; bars reach from \
the lower to the upper quartile. Times of passes are the adapter’s \
own clock, measured with every pass apart.</dd>\
<dt>Error</dt><dd>Each light’s factor (1 lit, 0 dark), before shading, minus that of an exact ray tracer in f64, as a root \
mean square: for hard shadows 0.01 means one pixel in ten thousand. The plots take the pixels outside the <em>ambiguity \
band</em>: those whose exact factor stays when the pixel’s centre moves by 1/256 pixel or the surface by 64 roundings of its \
depth, where rasterisation is no excuse. “Exact” is zero there, not a small number. The tables give the error over all \
pixels too.</dd>\
<dt>Leak, false</dt><dd>Lit where it should be dark; dark where it should be lit. In error maps leaks are red, false shadows \
blue, the band yellow.</dd>\
<dt>Lights with a size</dt><dd>Each technique is compared with the light that it takes to be there: a point, or a disc of \
its own radius. The factor is then the visible share of the disc, and the exact one that of thousands of samples, at a smaller \
frame size, which is said where it is. The plots take what is beyond the factors that a pixel’s ambiguous samples allow. \
<em>Penumbra RMSE</em> is over the pixels where the share is neither 0 nor 1; in error maps shades go with the cube root of the error. A technique that takes \
so many samples of the light is also compared with exactly these: <em>off its samples</em> counts the pixels that are not what they give, \
and ought to be 0.</dd>\
<dt>None, reference</dt><dd>The ends of the axis: no shadows at all, and the ray tracer itself on the processor.</dd></dl>\
<p class=\"soft\">Times of a software adapter say nothing about graphics cards; the ratios say more, but not all.</p></section>"
    ));
}

fn all_scenes(page: &mut Page, report: &Report) {
    page.put(format_args!("<section id=\"all\"><h2>All scenes</h2>"));
    match plots::overview(report) {
        Some(svg) => page.plot(
            "large",
            &svg,
            "Speed against error over all scenes",
            "Geometric mean of the scenes’ time ratios; error over the pixels of all scenes. Hollow: refused on some \
             scenes, so not to be compared.",
        ),
        None => page.put(format_args!("<p class=\"soft\">Nothing was measured on scenes in this run.</p>")),
    }
    let rows = tables::overview(report);
    let cells: Vec<Vec<Cell>> = rows
        .iter()
        .map(|row| {
            vec![
                Cell::Text(row.label.clone()),
                Cell::Number(format!("{} of {}", row.scenes, row.of)),
                Cell::Number(format!("{:.2}", row.ratio)),
                Cell::Number(format!("{:.2}–{:.2}", row.ratio_range[0], row.ratio_range[1])),
                Cell::count(row.compared),
                Cell::count(row.wrong),
                Cell::Number(percent(row.wrong, row.compared)),
                Cell::ought_be_zero(row.wrong_outside_band),
                Cell::of(row.rmse),
                Cell::of(row.rmse_outside_band),
                Cell::Number(mebibytes(row.gpu_bytes / row.scenes.max(1) as u64)),
            ]
        })
        .collect();
    let head = [
        "technique",
        "scenes",
        "time ratio",
        "range",
        "pixels judged",
        "wrong",
        "wrong, %",
        "wrong out of band",
        "RMSE",
        "RMSE out of band",
        "MiB, mean",
    ];
    if !rows.is_empty() {
        page.table("Every technique and setting, pixels summed over lights and scenes", &head, &cells);
    }
    page.put(format_args!("<h3>The techniques</h3><dl>"));
    for [type_name, short_name, summary] in &report.techniques {
        let points = report.scenes.iter().flat_map(|scene| &scene.points);
        let known = points.filter(|p| p.technique == *type_name).map(|p| p.known_error).next();
        let known = known.map_or(String::new(), |known| {
            format!(" Known error: {}.", escaped(known.trim_end_matches('.')))
        });
        page.put(format_args!(
            "<dt>{} (<code>{}</code>)</dt><dd>{}.{known}",
            escaped(short_name),
            escaped(type_name),
            escaped(summary)
        ));
        for row in rows.iter().filter(|row| row.short_name == *short_name) {
            page.put(format_args!("<br><strong>{}</strong>: {}.", escaped(&row.label), escaped(row.why)));
        }
        page.put(format_args!("</dd>"));
    }
    page.put(format_args!("</dl></section>"));
}

/// A share as percent, to two digits of its own.
pub(super) fn percent(part: usize, of: usize) -> String {
    if part == 0 { "0".into() } else { number(100.0 * part as f64 / of.max(1) as f64) }
}

pub(super) fn mebibytes(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / f64::from(1 << 20))
}

fn cost(page: &mut Page, report: &Report) {
    page.put(format_args!("<section id=\"cost\"><h2>Cost against size</h2>"));
    if report.axes.is_empty() {
        page.put(format_args!("<p class=\"soft\">Not measured in this run.</p></section>"));
        return;
    }
    page.put(format_args!(
        "<p>What shadows <em>add</em> to a frame, beside the frame without them. A cost that grows as a power of the size \
         is a straight line; the dashed line is the fit over the upper decade, its slope the exponent.</p><div class=\"grid2\">"
    ));
    for axis in &report.axes {
        page.plot(
            "lines",
            &plots::cost(axis),
            &format!("Cost against {}", axis.parameter),
            &format!("<strong>{}</strong>: {}.", escaped(axis.parameter), escaped(axis.shows)),
        );
    }
    page.put(format_args!("</div>"));
    let mut rows = Vec::new();
    for axis in &report.axes {
        let plain: Vec<(f64, f64)> = axis.unshadowed_ms.iter().map(|(x, ms)| (*x, ms.median)).collect();
        let added =
            axis.techniques.iter().map(|(name, steps)| (format!("{name} adds"), tables::axis_points(steps)));
        let lines = std::iter::once(("frame without shadows".to_owned(), plain)).chain(added);
        for (name, points) in lines {
            let last = points.last().copied();
            let fitted = fit(&points);
            let error = fitted.and_then(|fit| fit.standard_error);
            rows.push(vec![
                Cell::Text(axis.parameter.into()),
                Cell::Text(name),
                Cell::Number(fitted.map_or("–".into(), |fit| format!("{:.2}", fit.exponent))),
                Cell::Number(error.map_or("–".into(), |error| format!("±{error:.2}"))),
                Cell::Number(fitted.map_or("–".into(), |fit| {
                    format!("{}–{}", number(fit.range[0]), number(fit.range[1]))
                })),
                Cell::Number(last.map_or("–".into(), |(x, _)| number(x))),
                Cell::Number(last.map_or("–".into(), |(_, ms)| number(ms))),
            ]);
        }
    }
    let head = ["size", "what", "exponent", "standard error", "fitted over", "largest", "ms there"];
    page.table("Exponents over the upper decade, by least squares on logarithms", &head, &rows);
    page.put(format_args!("</section>"));
}

fn sweeps(page: &mut Page, report: &Report) {
    page.put(format_args!("<section id=\"sweeps\"><h2>Error against parameters</h2>"));
    if report.sweeps.is_empty() {
        page.put(format_args!("<p class=\"soft\">Not measured in this run.</p></section>"));
        return;
    }
    page.put(format_args!(
        "<p>One thing of a scene goes from harmless to extreme. Filled marks: error outside the band; hollow marks: over \
         all pixels. The strip at the foot is exact zero.</p><div class=\"grid3\">"
    ));
    for sweep in &report.sweeps {
        let loses = if sweep.f32_loses.is_empty() {
            String::new()
        } else {
            format!(" <span class=\"soft\">Where f32 must lose: {}.</span>", escaped(sweep.f32_loses))
        };
        page.plot(
            "small",
            &plots::error(sweep),
            &format!("Error against {}", sweep.parameter),
            &format!(
                "<strong>{}</strong>: {}. What breaks elsewhere: {}.{loses}",
                escaped(sweep.id),
                escaped(sweep.parameter),
                escaped(sweep.what_breaks)
            ),
        );
    }
    page.put(format_args!("</div>"));
    for sweep in &report.sweeps {
        if let Some(svg) = plots::qualities(sweep) {
            let what = if sweep.option.is_some() {
                "every quality’s error beside the whole light, over the penumbra’s pixels"
            } else {
                "every setting’s error outside the ambiguity band, one beside the other"
            };
            page.plot(
                "lines",
                &svg,
                &plots::qualities_title(sweep),
                &format!("<strong>{}</strong>: {what}.", escaped(sweep.id)),
            );
        }
    }
    let mut rows = Vec::new();
    for sweep in &report.sweeps {
        for (name, steps) in &sweep.techniques {
            let measured: Vec<_> =
                steps.iter().filter_map(|s| Some((s.value, s.outcome.measured()?))).collect();
            let wrong = measured.iter().map(|(_, totals)| totals.wrong).sum::<usize>();
            let outside = measured.iter().map(|(_, totals)| totals.wrong_outside_band).sum::<usize>();
            let worst = measured.iter().map(|(_, totals)| totals.rmse_outside_band).fold(0.0, f64::max);
            rows.push(vec![
                Cell::Text(sweep.id.into()),
                Cell::Text(name.clone()),
                Cell::Number(format!("{} of {}", measured.len(), steps.len())),
                Cell::count(wrong),
                Cell::ought_be_zero(outside),
                Cell::of(worst),
            ]);
        }
    }
    let head =
        ["sweep", "technique", "steps measured", "wrong", "wrong out of band", "largest RMSE out of band"];
    page.table("Pixels summed over the steps", &head, &rows);
    page.put(format_args!("</section>"));
}

fn refused(page: &mut Page, report: &Report) {
    page.put(format_args!("<section id=\"refused\"><h2>Refused and failed</h2>"));
    let mut rows = Vec::new();
    for scene in &report.scenes {
        for point in &scene.points {
            if let Outcome::Refused(why) = &point.outcome {
                rows.push(vec![
                    Cell::Text(scene.name.clone()),
                    Cell::Text(point.label()),
                    Cell::Why(why.clone()),
                ]);
            }
        }
    }
    if rows.is_empty() {
        page.put(format_args!("<p>No technique refused a scene.</p>"));
    } else {
        page.put(format_args!("<p>A refusal is an answer: a typed error in place of a wrong picture.</p>"));
        page.table("Refusals", &["scene", "technique", "reason"], &rows);
    }
    let failures = report.failures();
    if failures.is_empty() {
        page.put(format_args!("<p>Nothing failed.</p>"));
    } else {
        page.put(format_args!("<p class=\"bad\">{} failed:</p><ul>", failures.len()));
        for failure in failures {
            page.put(format_args!("<li>{}</li>", escaped(&failure)));
        }
        page.put(format_args!("</ul>"));
    }
    page.put(format_args!("</section>"));
}
