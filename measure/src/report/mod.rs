//! The report: every technique of a catalog with every quality setting on a list of scenes, its time beside its error.
//!
//! [`run`] measures, [`files`] makes the pages. A [`Chapter`] is a page beside the report, which
//! holds figures up beside published ones. Nothing here knows a technique: what is measured is what the catalog
//! holds and what each entry's `settings` name, so a technique from outside appears by being registered.
//!
//! *Time.* All settings of a scene are rendered in turn with the same frame without shadows, round after round, each by
//! a renderer of its own. A setting's ratio is the median of its rounds' ratios: what slows the machine slows both.
//!
//! *Error.* On linear factors against the exact reference, all lights of a scene taken together; each light's own
//! measures are kept beside it. The plots show the error outside the ambiguity band, where exact techniques have none;
//! the tables show the error of all pixels as well.

mod axes;
mod chapter;
mod chapter_page;
mod chapter_plot;
mod csv;
mod data;
mod effort;
mod fit;
mod html;
mod html_motion;
mod html_scene;
mod json;
mod labels;
mod motion;
mod pareto;
mod plot;
mod plots;
mod references;
mod run;
mod scales;
mod scene;
mod style;
mod svg;
mod tables;
mod totals;

use std::path::PathBuf;

pub use chapter::{
    Chapter, Drawn, Entry, Figure, Picture, Plotted, PlottedLine, PlottedPoint, Table, TableCell, Theirs,
    chapter_files,
};
pub use data::{
    AxisReport, AxisStep, Measurement, MotionReport, Outcome, PassReport, Point, Report, ReportScene,
    SceneReport, SweepReport, SweepStep,
};
pub use effort::{Effort, Parts, Steps};
pub use fit::{Fit, Line, fit, line};
pub use pareto::front;
pub use references::References;
pub use run::{Watch, run};
pub use totals::Totals;

/// A file of the report: its path below the report's folder, and its contents.
pub type ReportFile = (PathBuf, Vec<u8>);

/// Every file of the report: `index.html`, `report.csv`, `report.json`, `plots/` and `pictures/`.
pub fn files(report: &Report) -> Vec<ReportFile> {
    let mut files = vec![
        (PathBuf::from("index.html"), html::page(report).into_bytes()),
        (PathBuf::from("report.csv"), csv::table(report)),
        (PathBuf::from("report.json"), format!("{:#}\n", json::report_json(report)).into_bytes()),
    ];
    for (name, plot) in plots::standalone(report) {
        files.push((PathBuf::from("plots").join(name), plot.into_bytes()));
    }
    files.extend(report.pictures.iter().map(|(name, png)| (PathBuf::from(name), png.clone())));
    files
}

/// The report's main plot, as `plots/speed-error.svg` holds it; `None` when nothing was measured.
pub fn main_plot(report: &Report) -> Option<String> {
    plots::standalone(report).into_iter().find(|(name, _)| name == plots::MAIN).map(|(_, plot)| plot)
}
