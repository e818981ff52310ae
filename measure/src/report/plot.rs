//! A plot: a frame with two scales, a grid, series of points with their spread, and labels beside them.

use super::labels::{Box2, Label, place, width_px};
use super::scales::Scale;
use super::svg::{Anchor, Svg};

/// How large a plot is and what its edges are kept for, in the units of its view box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) width: f64,
    pub(super) height: f64,
    /// Free space to the right, for labels of lines.
    pub(super) right: f64,
}

impl Layout {
    pub(super) const LARGE: Self = Self { width: 760.0, height: 500.0, right: 24.0 };
    pub(super) const LINES: Self = Self { width: 440.0, height: 300.0, right: 118.0 };
    pub(super) const SMALL: Self = Self { width: 300.0, height: 200.0, right: 14.0 };
}

const LEFT: f64 = 58.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 46.0;
/// The height of the strip for exact zero.
const ZERO_STRIP: f64 = 30.0;

/// What an axis shows.
#[derive(Clone, Debug)]
pub(super) struct AxisOf<'a> {
    pub(super) title: &'a str,
    pub(super) values: Vec<f64>,
    pub(super) is_log: bool,
    /// A logarithmic scale covers at least this factor.
    pub(super) least: f64,
}

/// A point of a series.
#[derive(Clone, Debug)]
pub(super) struct Mark {
    pub(super) at: [f64; 2],
    /// Its quartiles along x, or along y.
    pub(super) x_spread: Option<[f64; 2]>,
    pub(super) y_spread: Option<[f64; 2]>,
    /// Class beside those of its series: `hollow`, say.
    pub(super) class: &'static str,
    pub(super) shape: usize,
    /// The series' number, which its colour comes from; `None` for what is no technique.
    pub(super) series: Option<usize>,
    /// What it says when pointed at.
    pub(super) title: String,
    /// What stands beside it; empty for nothing.
    pub(super) label: String,
}

impl Mark {
    /// The classes of something in the colour of a series.
    pub(super) fn color(series: Option<usize>) -> String {
        series.map_or("end".into(), |series| format!("s{}", series % super::style::COLORS.len()))
    }
}

/// A plot under construction.
pub(super) struct Plot {
    svg: Svg,
    layout: Layout,
    x: Scale,
    y: Scale,
    obstacles: Vec<Box2>,
    labels: Vec<(Label, String)>,
}

impl Plot {
    /// The frame, with a strip for exact zeros of y where `zero` says what to call it.
    pub(super) fn new(layout: Layout, x: &AxisOf<'_>, y: &AxisOf<'_>, zero: Option<&str>) -> Self {
        let (right, bottom) = (layout.width - layout.right, layout.height - BOTTOM);
        let floor = if zero.is_some() { bottom - ZERO_STRIP } else { bottom };
        let zero_px = zero.map(|_| bottom - ZERO_STRIP * 0.5);
        let scale = |axis: &AxisOf<'_>, px: [f64; 2], zero_px: Option<f64>| {
            if axis.is_log {
                Scale::log(&axis.values, axis.least, px, zero_px)
            } else {
                Scale::linear(&axis.values, px)
            }
        };
        let mut plot = Self {
            svg: Svg::new(layout.width, layout.height),
            layout,
            x: scale(x, [LEFT, right], None),
            y: scale(y, [floor, TOP], zero_px),
            obstacles: Vec::new(),
            labels: Vec::new(),
        };
        plot.grid([right, floor, bottom]);
        if let (Some(zero), Some(zero_px)) = (zero, zero_px) {
            plot.svg.rect("zero", [LEFT, floor], [right - LEFT, ZERO_STRIP]);
            plot.svg.text("tick", [LEFT - 6.0, zero_px + 4.0], Anchor::End, zero);
        }
        plot.svg.text("name", [(LEFT + right) * 0.5, layout.height - 8.0], Anchor::Middle, x.title);
        plot.svg.text_up("name", [13.0, (TOP + bottom) * 0.5], y.title);
        plot
    }

    fn grid(&mut self, [right, floor, bottom]: [f64; 3]) {
        // Labels that would touch their neighbour are left out.
        let mut free_from = 0.0;
        for tick in self.x.ticks() {
            let class = if tick.label.is_empty() { "grid minor" } else { "grid" };
            self.svg.line(class, [tick.px, TOP], [tick.px, bottom]);
            let half = width_px(&tick.label) * 0.5;
            if !tick.label.is_empty() && tick.px - half >= free_from {
                self.svg.text("tick", [tick.px, bottom + 16.0], Anchor::Middle, &tick.label);
                free_from = tick.px + half + 6.0;
            }
        }
        let mut free_to = f64::INFINITY;
        for tick in self.y.ticks() {
            let class = if tick.label.is_empty() { "grid minor" } else { "grid" };
            self.svg.line(class, [LEFT, tick.px], [right, tick.px]);
            if !tick.label.is_empty() && tick.px + 6.0 <= free_to && tick.px <= floor {
                self.svg.text("tick", [LEFT - 6.0, tick.px + 4.0], Anchor::End, &tick.label);
                free_to = tick.px - 7.0;
            }
        }
        self.svg.line("axis", [LEFT, bottom], [right, bottom]);
        self.svg.line("axis", [LEFT, TOP], [LEFT, bottom]);
    }

    /// The place of a point, if both scales have one.
    pub(super) fn place(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        Some([self.x.px(x)?, self.y.px(y)?])
    }

    /// A line through points; those without a place are passed over.
    pub(super) fn line(&mut self, class: &str, points: &[[f64; 2]]) {
        let places: Vec<[f64; 2]> = points.iter().filter_map(|point| self.place(*point)).collect();
        if places.len() > 1 {
            self.svg.path(class, &places);
        }
    }

    /// The stairs along a front: right to the next cost, down to its error.
    pub(super) fn stairs(&mut self, class: &str, points: &[[f64; 2]]) {
        let places: Vec<[f64; 2]> = points.iter().filter_map(|point| self.place(*point)).collect();
        let mut path: Vec<[f64; 2]> = Vec::new();
        for place in places {
            path.extend(path.last().map(|last| [place[0], last[1]]));
            path.push(place);
        }
        if path.len() > 1 {
            self.svg.path(class, &path);
        }
        self.obstacles.extend(path.windows(2).map(|ends| Box2::line(ends[0], ends[1])));
    }

    /// A point with its spread; its label is placed when the plot is done.
    pub(super) fn mark(&mut self, mark: &Mark) {
        let Some(at) = self.place(mark.at) else { return };
        let color = Mark::color(mark.series);
        for end in [0, 1] {
            let x = mark.x_spread.and_then(|spread| self.x.px(spread[end]));
            let y = mark.y_spread.and_then(|spread| self.y.px(spread[end]));
            if x.is_some() || y.is_some() {
                let to = [x.unwrap_or(at[0]), y.unwrap_or(at[1])];
                self.svg.line(&format!("spread {color}"), at, to);
                self.obstacles.push(Box2::line(at, to));
            }
        }
        self.svg.mark(&format!("mark {color} {}", mark.class), mark.shape, at, &mark.title);
        self.obstacles.push(Box2::mark(at));
        if !mark.label.is_empty() {
            self.labels.push((Label { at, text: mark.label.clone() }, color));
        }
    }

    /// A label at a point that has no mark of its own.
    pub(super) fn label(&mut self, at: [f64; 2], series: Option<usize>, text: &str) {
        if let Some(at) = self.place(at) {
            self.labels.push((Label { at, text: text.into() }, Mark::color(series)));
        }
    }

    /// A remark in the upper right corner of the frame.
    pub(super) fn remark(&mut self, text: &str) {
        let at = [self.layout.width - self.layout.right - 4.0, TOP + 12.0];
        self.svg.text("remark", at, Anchor::End, text);
        self.obstacles.push(Box2::line([at[0] - width_px(text) * 0.9, at[1] - 8.0], at));
    }

    /// The picture, labels placed.
    pub(super) fn finish(mut self) -> Svg {
        let bounds = [[LEFT + 2.0, TOP - 8.0], [self.layout.width - 2.0, self.layout.height - BOTTOM - 2.0]];
        let labels: Vec<Label> = self.labels.iter().map(|(label, _)| label.clone()).collect();
        for ((label, color), placed) in self.labels.iter().zip(place(&labels, &self.obstacles, bounds)) {
            let Some(placed) = placed else { continue };
            if let Some(end) = placed.leader {
                self.svg.line("leader", label.at, end);
            }
            self.svg.text(&format!("label {color}"), placed.at, Anchor::Start, &label.text);
        }
        self.svg
    }
}
