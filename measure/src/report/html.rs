//! `index.html`: one page that opens from disk.

use maud::{DOCTYPE, Markup, PreEscaped, Render, html};

use super::data::{AxisReport, Report, SweepReport};
use super::scales::{count, number};
use super::svg::Svg;
use super::tables::OverviewRow;
use super::{Fit, Totals, fit, plots, style, tables};
use super::{html_motion, html_scene};
use crate::cases::sweeps::ShowsIn;

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
    pub(super) fn text(text: &str) -> Self {
        Self::Text(text.into())
    }

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

    /// A number that there may be none of.
    pub(super) fn maybe(text: Option<String>) -> Self {
        Self::Number(text.unwrap_or_else(|| "–".into()))
    }
}

impl Render for Cell {
    fn render(&self) -> Markup {
        html! {
            @match self {
                Self::Text(text) => { td { (text) } }
                Self::Number(text) => { td.n { (text) } }
                Self::Why(text) => { td.why { (text) } }
                Self::Bad(text) => { td.n.bad { strong { (text) } } }
            }
        }
    }
}

/// A column of a table: its name, and its cell of a row.
pub(super) type Column<T> = (&'static str, fn(&T) -> Cell);

/// A table in a box of its own that scrolls where the screen is narrow. Numbers stand to the right.
pub(super) fn table<T>(caption: &str, rows: &[T], columns: &[Column<T>]) -> Markup {
    let is_number =
        |cell: fn(&T) -> Cell| rows.first().is_some_and(|row| matches!(cell(row), Cell::Number(_)));
    html! {
        div.scroll tabindex="0" role="region" aria-label=(caption) {
            table {
                caption { (caption) }
                thead { tr {
                    @for (name, cell) in columns { th.n[is_number(*cell)] scope="col" { (name) } }
                } }
                tbody {
                    @for row in rows { tr { @for (_, cell) in columns { (cell(row)) } } }
                }
            }
        }
    }
}

/// A plot with its caption; `size` is a class: `large`, `lines` or `small`.
pub(super) fn plot(size: &str, svg: &Svg, title: &str, caption: &Markup) -> Markup {
    html! {
        figure {
            div.scroll.plot.(size) { (PreEscaped(svg.inline(title))) }
            figcaption { (caption) }
        }
    }
}

/// The parts of the page, by their place in it.
const NAVIGATION: [(&str, &str); 9] = [
    ("#how", "How to read it"),
    ("#all", "All scenes"),
    ("#scenes", "Scene by scene"),
    ("#cost", "Cost against size"),
    ("#motion", "Cost of motion"),
    ("#sweeps", "Error against parameters"),
    ("#refused", "Refused and failed"),
    ("report.csv", "CSV"),
    ("report.json", "JSON"),
];

pub(super) fn page(report: &Report) -> String {
    let [width, height] = report.size_px;
    document(
        "Shadowgraph: speed against error",
        &html! {
            header {
                h1 { "Speed against error" }
                p.facts {
                    "Adapter: " strong { (report.adapter) } ". Scenes at " (width) "×" (height) " pixels, "
                    (report.processors) " processors, effort “" (report.effort) "”, Shadowgraph "
                    (env!("CARGO_PKG_VERSION")) "."
                }
                ul.nav { @for (place, name) in NAVIGATION { li { a href=(place) { (name) } } } }
            }
            main {
                (how_to_read())
                (all_scenes(report))
                section #scenes {
                    h2 { "Scene by scene" }
                    @if report.scenes.is_empty() { (not_measured()) }
                    @for scene in &report.scenes { (html_scene::scene(report, scene)) }
                }
                (cost(report))
                (html_motion::motion(report))
                (sweeps(report))
                (refused(report))
            }
        },
    )
}

/// A page with the report's looks.
pub(super) fn document(title: &str, body: &Markup) -> String {
    let style = style::variables() + &style::plot_rules() + style::PAGE_RULES;
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(style)) }
            }
            body { (body) }
        }
    };
    // Neither HTML nor the reader has a use for other control characters.
    let is_odd = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    page.into_string().replace(is_odd, "\u{fffd}")
}

pub(super) fn not_measured() -> Markup {
    html! { p.soft { "Not measured in this run." } }
}

fn how_to_read() -> Markup {
    html! {
        section #how {
            h2 { "How to read it" }
            p { "Every point is one technique with one quality setting. "
                strong { "Further left is faster, further down is more right." }
                " The dotted stairs are the Pareto front: what stands on them is beaten by nothing in both at once." }
            dl {
                dt { "Time" }
                dd { "A whole frame on the wall clock, divided by the same frame without shadows. All settings of a scene and \
                      the frame without shadows are rendered in turn, so that both see the same machine. Marks are medians; \
                      bars reach from the lower to the upper quartile. Times of passes are the adapter’s own clock, measured \
                      with every pass apart." }
                dt { "Error" }
                dd { "Each light’s factor (1 lit, 0 dark), before shading, minus that of an exact ray tracer in f64, as a root \
                      mean square: for hard shadows 0.01 means one pixel in ten thousand. The plots take the pixels outside the "
                     em { "ambiguity band" }
                     ": those whose exact factor stays when the pixel’s centre moves by 1/256 pixel or the surface by 64 \
                      roundings of its depth, where rasterisation is no excuse. “Exact” is zero there, not a small number. \
                      The tables give the error over all pixels too." }
                dt { "Leak, false" }
                dd { "Lit where it should be dark; dark where it should be lit. In error maps leaks are red, false shadows \
                      blue, the band yellow." }
                dt { "Lights with a size" }
                dd { "Each technique is compared with the light that it takes to be there: a point, or a disc of its own \
                      radius. The factor is then the visible share of the disc, and the exact one that of thousands of \
                      samples, at a smaller frame size, which is said where it is. The plots take what is beyond the factors \
                      that a pixel’s ambiguous samples allow. " em { "Penumbra RMSE" } " is over the pixels where the share \
                      is neither 0 nor 1; in error maps shades go with the cube root of the error. A technique that takes so \
                      many samples of the light is also compared with exactly these: " em { "off its samples" } " counts the \
                      pixels that are not what they give, and ought to be 0." }
                dt { "None, reference" }
                dd { "The ends of the axis: no shadows at all, and the ray tracer itself on the processor." }
            }
            p.soft { "Times of a software adapter say nothing about graphics cards; the ratios say more, but not all." }
        }
    }
}

const OVERVIEW: &[Column<OverviewRow>] = &[
    ("technique", |row| Cell::text(&row.label)),
    ("scenes", |row| Cell::Number(format!("{} of {}", row.scenes, row.of))),
    ("time ratio", |row| Cell::Number(format!("{:.2}", row.ratio))),
    ("range", |row| Cell::Number(format!("{:.2}–{:.2}", row.ratio_range[0], row.ratio_range[1]))),
    ("pixels judged", |row| Cell::count(row.compared)),
    ("wrong", |row| Cell::count(row.wrong)),
    ("wrong, %", |row| Cell::Number(percent(row.wrong, row.compared))),
    ("wrong out of band", |row| Cell::ought_be_zero(row.wrong_outside_band)),
    ("RMSE", |row| Cell::of(row.rmse)),
    ("RMSE out of band", |row| Cell::of(row.rmse_outside_band)),
    ("MiB, mean", |row| Cell::Number(mebibytes(row.gpu_bytes / row.scenes.max(1) as u64))),
];

fn all_scenes(report: &Report) -> Markup {
    let rows = tables::overview(report);
    let known_error = |type_name: &str| {
        let mut points = report.scenes.iter().flat_map(|scene| &scene.points);
        points.find(|point| point.technique == type_name).map(|point| point.known_error)
    };
    html! {
        section #all {
            h2 { "All scenes" }
            @match plots::overview(report) {
                Some(svg) => (plot("large", &svg, "Speed against error over all scenes", &html! {
                    "Geometric mean of the scenes’ time ratios; error over the pixels of all scenes. Hollow: refused on some \
                     scenes, so not to be compared."
                })),
                None => p.soft { "Nothing was measured on scenes in this run." }
            }
            @if !rows.is_empty() {
                (table("Every technique and setting, pixels summed over lights and scenes", &rows, OVERVIEW))
            }
            h3 { "The techniques" }
            dl {
                @for [type_name, short_name, summary] in &report.techniques {
                    dt { (short_name) " (" code { (type_name) } ")" }
                    dd {
                        (summary) "."
                        @if let Some(known) = known_error(type_name) {
                            " Known error: " (known.trim_end_matches('.')) "."
                        }
                        @for row in rows.iter().filter(|row| row.short_name == *short_name) {
                            br; strong { (row.label) } ": " (row.why) "."
                        }
                    }
                }
            }
        }
    }
}

/// A share as percent, to two digits of its own.
pub(super) fn percent(part: usize, of: usize) -> String {
    if part == 0 { "0".into() } else { number(100.0 * part as f64 / of.max(1) as f64) }
}

/// From one number to another.
pub(super) fn range(from: f64, to: f64) -> String {
    format!("{}–{}", number(from), number(to))
}

pub(super) fn mebibytes(bytes: u64) -> String {
    format!("{:.1}", bytes as f64 / f64::from(1 << 20))
}

/// A line of a cost plot with its fit.
struct CostRow {
    axis: &'static str,
    name: String,
    fit: Option<Fit>,
    last: Option<(f64, f64)>,
}

const COST: &[Column<CostRow>] = &[
    ("size", |row| Cell::text(row.axis)),
    ("what", |row| Cell::text(&row.name)),
    ("exponent", |row| Cell::maybe(row.fit.map(|fit| format!("{:.2}", fit.exponent)))),
    ("standard error", |row| {
        Cell::maybe(row.fit.and_then(|fit| Some(format!("±{:.2}", fit.standard_error?))))
    }),
    ("fitted over", |row| Cell::maybe(row.fit.map(|fit| range(fit.range[0], fit.range[1])))),
    ("largest", |row| Cell::maybe(row.last.map(|(x, _)| number(x)))),
    ("ms there", |row| Cell::maybe(row.last.map(|(_, ms)| number(ms)))),
];

/// The frame without shadows, and what every setting adds to it.
fn cost_rows(axis: &AxisReport) -> Vec<CostRow> {
    let plain: Vec<(f64, f64)> = axis.unshadowed_ms.iter().map(|(x, ms)| (*x, ms.median)).collect();
    let added =
        axis.techniques.iter().map(|(name, steps)| (format!("{name} adds"), tables::axis_points(steps)));
    let lines = std::iter::once(("frame without shadows".to_owned(), plain)).chain(added);
    let row = |(name, points): (String, Vec<(f64, f64)>)| CostRow {
        axis: axis.parameter,
        name,
        fit: fit(&points),
        last: points.last().copied(),
    };
    lines.map(row).collect()
}

fn cost(report: &Report) -> Markup {
    let rows: Vec<CostRow> = report.axes.iter().flat_map(cost_rows).collect();
    html! {
        section #cost {
            h2 { "Cost against size" }
            @if report.axes.is_empty() {
                (not_measured())
            } @else {
                p {
                    "What shadows " em { "add" } " to a frame, beside the frame without them. A cost that grows as a power of \
                     the size is a straight line; the dashed line is the fit over the upper decade, its slope the exponent."
                }
                div.grid2 {
                    @for axis in &report.axes {
                        (plot("lines", &plots::cost(axis), &format!("Cost against {}", axis.parameter), &html! {
                            strong { (axis.parameter) } ": " (axis.shows) "."
                        }))
                    }
                }
                (table("Exponents over the upper decade, by least squares on logarithms", &rows, COST))
            }
        }
    }
}

/// A sweep of one technique and setting.
struct SweepRow {
    sweep: &'static str,
    name: String,
    measured: Vec<Totals>,
    steps: usize,
}

fn sweep_rows(sweep: &SweepReport) -> impl Iterator<Item = SweepRow> {
    sweep.techniques.iter().map(|(name, steps)| SweepRow {
        sweep: sweep.id,
        name: name.clone(),
        measured: steps.iter().filter_map(|step| step.outcome.measured().cloned()).collect(),
        steps: steps.len(),
    })
}

const SWEEPS: &[Column<SweepRow>] = &[
    ("sweep", |row| Cell::text(row.sweep)),
    ("technique", |row| Cell::text(&row.name)),
    ("steps measured", |row| Cell::Number(format!("{} of {}", row.measured.len(), row.steps))),
    ("wrong", |row| Cell::count(row.measured.iter().map(|t| t.wrong).sum())),
    ("wrong out of band", |row| Cell::ought_be_zero(row.measured.iter().map(|t| t.wrong_outside_band).sum())),
    ("largest RMSE out of band", |row| {
        Cell::of(row.measured.iter().map(|t| t.rmse_outside_band).fold(0.0, f64::max))
    }),
];

fn sweeps(report: &Report) -> Markup {
    let rows: Vec<SweepRow> = report.sweeps.iter().flat_map(sweep_rows).collect();
    html! {
        section #sweeps {
            h2 { "Error against parameters" }
            @if report.sweeps.is_empty() {
                (not_measured())
            } @else {
                p {
                    "One thing of a scene goes from harmless to extreme. Filled marks: error outside the band; hollow marks: \
                     over all pixels. The strip at the foot is exact zero."
                    @if report.sweep_shrink > 1 {
                        " Frames are " (report.sweep_shrink) " times smaller along each side than in longer reports, and heavy steps are left out."
                    }
                }
                div.grid3 { @for sweep in &report.sweeps { (sweep_plot(sweep)) } }
                @for sweep in &report.sweeps {
                    @if let Some(svg) = plots::qualities(sweep) {
                        (plot("lines", &svg, &plots::qualities_title(sweep), &html! {
                            strong { (sweep.id) } ": "
                            @match sweep.option.map(|swept| swept.shows_in) {
                                Some(ShowsIn::Penumbrae) => {
                                    "every quality’s error beside the whole light, over the penumbra’s pixels."
                                }
                                Some(ShowsIn::Edges) => {
                                    "how far the edges of hard shadows are off on average: wrong pixels over the pixels of the true edge."
                                }
                                None => "every setting’s error outside the ambiguity band, one beside the other.",
                            }
                        }))
                    }
                }
                (table("Pixels summed over the steps", &rows, SWEEPS))
            }
        }
    }
}

fn sweep_plot(sweep: &SweepReport) -> Markup {
    plot(
        "small",
        &plots::error(sweep),
        &format!("Error against {}", sweep.parameter),
        &html! {
            strong { (sweep.id) } ": " (sweep.parameter) ". What breaks elsewhere: " (sweep.what_breaks) "."
            @if !sweep.f32_loses.is_empty() {
                " " span.soft { "Where f32 must lose: " (sweep.f32_loses) "." }
            }
        },
    )
}

const REFUSALS: &[Column<[String; 3]>] = &[
    ("scene", |[scene, _, _]| Cell::text(scene)),
    ("technique", |[_, technique, _]| Cell::text(technique)),
    ("reason", |[_, _, why]| Cell::Why(why.clone())),
];

fn refused(report: &Report) -> Markup {
    let points = report.scenes.iter().flat_map(|scene| scene.points.iter().map(move |point| (scene, point)));
    let refusals = points.filter_map(|(scene, point)| {
        Some([scene.name.clone(), point.label(), point.outcome.refusal()?.to_owned()])
    });
    let refusals: Vec<[String; 3]> = refusals.collect();
    let failures = report.failures();
    html! {
        section #refused {
            h2 { "Refused and failed" }
            @if refusals.is_empty() {
                p { "No technique refused a scene." }
            } @else {
                p { "A refusal is an answer: a typed error in place of a wrong picture." }
                (table("Refusals", &refusals, REFUSALS))
            }
            @if failures.is_empty() {
                p { "Nothing failed." }
            } @else {
                p.bad { (failures.len()) " failed:" }
                ul { @for failure in &failures { li { (failure) } } }
            }
        }
    }
}
