//! Fig. 8 of paper 001: frames a second against the number of lights, with a straight line through them.

use shadowgraph_engine::render::Exposure;
use shadowgraph_measure::report::{Drawn, Entry, Figure, Line, Plotted, PlottedLine, PlottedPoint, line};
use shadowgraph_measure::timing::Spread;
use shadowgraph_nodes::ShadowVolumeHard;

use super::harness::{Bench, Made, PaperError, Rounds, shadowed};
use crate::demo;

const LIGHTS: [u32; 6] = [1, 2, 4, 8, 16, 32];
/// A line through two points would have no error.
const FEW_LIGHTS: [u32; 4] = [1, 2, 4, 8];

pub(super) fn fig_8(bench: &mut Bench<'_>) -> Made<Entry> {
    let counts: &[u32] = if bench.effort.ends_only { &FEW_LIGHTS } else { &LIGHTS };
    let knot = demo::speed().swap_remove(0).2.without_shadows();
    let lit: Vec<_> = counts.iter().map(|count| demo::under_lamps(&knot, *count)).collect();
    let dark: Vec<_> = lit.iter().map(|scene| shadowed(scene, ShadowVolumeHard::default())).collect();
    bench.tell("frames in turn");
    let rounds = bench.rounds(&[lit, dark.clone()].concat())?;
    let few = counts.len();
    let points = |first: usize, of: fn(f64) -> f64| -> Vec<PlottedPoint> {
        let point = |(row, count): (usize, &u32)| {
            let Spread { median, lower, upper, .. } = rounds.ms(first + row);
            let quartiles = Some([of(lower).min(of(upper)), of(upper).max(of(lower))]);
            PlottedPoint { at: [f64::from(*count), of(median)], quartiles }
        };
        counts.iter().enumerate().map(point).collect()
    };
    let [without_ms, with_ms] = [0, few].map(|first| points(first, |ms| ms));
    let [without_fps, with_fps] = [0, few].map(|first| points(first, |ms| 1e3 / ms));
    let of_ms = fitted(&with_ms)?;
    let of_fps = fitted(&with_fps)?;
    let picture = dark.last().ok_or(PaperError::Missing("a scene"))?;
    let caption = format!("the last of them: {} lamps", counts[few - 1]);
    Ok(Entry {
        sentence: "A straight line fits the time of a frame, to which every light adds about the same, and not the frames a \
                   second, through which they draw theirs; with one light the frame costs little more than without shadows."
            .into(),
        figures: figures(&of_ms, &of_fps, &rounds, few),
        plots: vec![
            plotted(
                ["001-fig8-ms", "Time of a frame against lights, with a straight line", "ms"],
                [without_ms, with_ms],
                &of_ms,
            ),
            plotted(
                ["001-fig8-fps", "Their axes: frames a second against lights, with theirs", "frames a second"],
                [without_fps, with_fps],
                &of_fps,
            ),
        ],
        pictures: vec![bench.picture(picture, Exposure::default(), ("001-fig8", caption))?],
        ..Entry::default()
    })
}

fn fitted(points: &[PlottedPoint]) -> Made<Line> {
    let points: Vec<(f64, f64)> = points.iter().map(|point| (point.at[0], point.at[1])).collect();
    line(&points).ok_or(PaperError::Missing("a second number of lights"))
}

fn figures(of_ms: &Line, of_fps: &Line, rounds: &Rounds, few: usize) -> Vec<Figure> {
    let error = of_ms
        .standard_error
        .map(|error| Figure::new("ms.slope-error", "its standard error", error).in_unit("ms"));
    let slope = Figure::new("ms.slope", "what each light adds to a frame, by the line", of_ms.slope);
    let least = Figure::new("ms.at-zero", "what the line says of a frame without lights", of_ms.at_zero);
    [slope.in_unit("ms")]
        .into_iter()
        .chain(error)
        .chain([
            least.in_unit("ms"),
            Figure::new("ms.residual", "how far frames are from the line, root mean square", of_ms.residual)
                .in_unit("ms"),
            Figure::new(
                "ms.r-squared",
                "share of the variance of times that a line explains",
                of_ms.r_squared,
            ),
            Figure::new("fps.r-squared", "the same of frames a second", of_fps.r_squared)
                .beside_words("a line is drawn"),
            Figure::spread(
                "one-light",
                "one light: frame with shadows, of that without",
                rounds.ratio(few, 0),
            )
            .beside_words("“not much different”"),
            Figure::spread(
                "most-lights",
                "most lights: frame with shadows, of that without",
                rounds.ratio(2 * few - 1, few - 1),
            ),
        ])
        .collect()
}

fn plotted(
    [name, title, unit]: [&'static str; 3],
    [without, with]: [Vec<PlottedPoint>; 2],
    fit: &Line,
) -> Plotted {
    let ends = [with.first(), with.last()].into_iter().flatten().map(|point| point.at[0]);
    let ends = ends.map(|x| PlottedPoint { at: [x, fit.at(x)], quartiles: None }).collect();
    let joined = |name: &str, points| PlottedLine { name: name.into(), drawn: Drawn::Joined, points };
    Plotted {
        name: name.into(),
        title: title.into(),
        axes: ["lights", unit],
        is_log: [false; 2],
        lines: vec![
            joined("with shadows", with),
            joined("without", without),
            PlottedLine { name: "line".into(), drawn: Drawn::Fit, points: ends },
        ],
    }
}
