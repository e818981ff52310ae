//! The plots of a chapter.

use super::chapter::{Drawn, Plotted};
use super::plot::{AxisOf, Layout, Mark, Plot};
use super::scales::number;
use super::style;
use super::svg::Svg;

/// The plot for a page that has the styles.
pub(super) fn svg(plotted: &Plotted) -> Svg {
    let points = || plotted.lines.iter().flat_map(|line| &line.points);
    let axis = |index: usize, values: Vec<f64>| AxisOf {
        title: plotted.axes[index],
        values,
        is_log: plotted.is_log[index],
        least: 4.0,
    };
    let x = axis(0, points().map(|point| point.at[0]).collect());
    let spreads = points().filter_map(|point| point.quartiles).flatten();
    let y = axis(1, points().map(|point| point.at[1]).chain(spreads).collect());
    // What is exactly 0 has no place among powers of ten.
    let has_zero = plotted.is_log[1] && points().any(|point| point.at[1] == 0.0);
    let mut plot = Plot::new(Layout::LINES, &x, &y, has_zero.then_some("0"));
    for (index, line) in plotted.lines.iter().enumerate() {
        let color = Mark::color(Some(index));
        let path: Vec<[f64; 2]> = line.points.iter().map(|point| point.at).collect();
        let class = if line.drawn == Drawn::Fit { "fit" } else { "line" };
        plot.line(&format!("{class} {color}"), &path);
        if line.drawn == Drawn::Joined {
            for point in &line.points {
                let [x, y] = point.at;
                plot.mark(&Mark {
                    at: point.at,
                    x_spread: None,
                    y_spread: point.quartiles,
                    class: "",
                    shape: index,
                    series: Some(index),
                    title: format!("{}: {} at {}", line.name, number(y), number(x)),
                    label: String::new(),
                });
            }
        }
        if let Some(last) = path.last() {
            plot.label(*last, Some(index), &line.name);
        }
    }
    plot.finish()
}

/// The plot as a file of its own.
pub(super) fn standalone(plotted: &Plotted) -> String {
    svg(plotted).standalone(&plotted.title, &style::standalone())
}
