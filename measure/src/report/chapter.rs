//! A chapter: figures that were measured, held up beside those that somebody published. What they are of is said by whoever
//! fills it in; this makes the page and the file for programs of it.

use std::path::PathBuf;

use serde_json::{Value, json};

use super::scales::number;
use super::{ReportFile, chapter_page, chapter_plot};
use crate::compare::json::finite;
use crate::compare::timing::Spread;

/// A page of entries.
#[derive(Clone, Debug, Default)]
pub struct Chapter {
    /// The stem of its page's and its JSON's name.
    pub stem: &'static str,
    /// Its title.
    pub title: &'static str,
    /// What it is, in a paragraph.
    pub lead: &'static str,
    /// The adapter that everything was measured on.
    pub adapter: String,
    /// The machine's processors.
    pub processors: usize,
    /// The effort's name.
    pub effort: &'static str,
    /// The size of timed frames.
    pub size_px: [u32; 2],
    /// Its entries.
    pub entries: Vec<Entry>,
}

impl Chapter {
    /// What failed, each with its entry.
    pub fn failures(&self) -> Vec<String> {
        let failed = |entry: &Entry| Some(format!("{}: {}", entry.id, entry.failure.as_ref()?));
        self.entries.iter().filter_map(failed).collect()
    }
}

/// One published table or figure, made again.
#[derive(Clone, Debug, Default)]
pub struct Entry {
    /// A short name for programs and links: letters, digits and hyphens.
    pub id: &'static str,
    /// What it was published in.
    pub source: &'static str,
    /// What it is.
    pub title: &'static str,
    /// What is found, in a plain sentence.
    pub sentence: String,
    /// What was measured beside what was published.
    pub figures: Vec<Figure>,
    /// Everything else that was measured.
    pub tables: Vec<Table>,
    /// Plots of it.
    pub plots: Vec<Plotted>,
    /// Pictures of it.
    pub pictures: Vec<Picture>,
    /// Why it could not be made.
    pub failure: Option<String>,
}

/// What a publication says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Theirs {
    /// Nothing.
    #[default]
    Nothing,
    /// A number.
    Number(f64),
    /// Words.
    Words(&'static str),
}

/// A measured number beside a published one.
#[derive(Clone, Debug, Default)]
pub struct Figure {
    /// Its name within its entry, for programs.
    pub key: String,
    /// What it is.
    pub what: String,
    /// Its unit; empty for a ratio or a count.
    pub unit: &'static str,
    /// What was measured: of times the median.
    pub ours: f64,
    /// Quartiles of what was measured.
    pub quartiles: Option<[f64; 2]>,
    /// What was published.
    pub theirs: Theirs,
}

impl Figure {
    /// A ratio or a count.
    pub fn new(key: impl Into<String>, what: impl Into<String>, ours: f64) -> Self {
        Self { key: key.into(), what: what.into(), ours, ..Self::default() }
    }

    /// A median with its quartiles.
    pub fn spread(key: impl Into<String>, what: impl Into<String>, ours: Spread) -> Self {
        let Spread { median, lower, upper, .. } = ours;
        Self { quartiles: Some([lower, upper]), ..Self::new(key, what, median) }
    }

    /// The same in `unit`.
    #[must_use]
    pub fn in_unit(self, unit: &'static str) -> Self {
        Self { unit, ..self }
    }

    /// The same beside a published number.
    #[must_use]
    pub fn beside(self, theirs: f64) -> Self {
        Self { theirs: Theirs::Number(theirs), ..self }
    }

    /// The same beside published words.
    #[must_use]
    pub fn beside_words(self, theirs: &'static str) -> Self {
        Self { theirs: Theirs::Words(theirs), ..self }
    }

    /// Our number for a reader, with its unit.
    pub fn ours_text(&self) -> String {
        with_unit(&number(self.ours), self.unit)
    }

    /// Their number or words for a reader.
    pub fn theirs_text(&self) -> String {
        match self.theirs {
            Theirs::Nothing => "–".into(),
            Theirs::Number(value) => with_unit(&number(value), self.unit),
            Theirs::Words(words) => words.into(),
        }
    }
}

fn with_unit(number: &str, unit: &str) -> String {
    if unit.is_empty() { number.into() } else { format!("{number} {unit}") }
}

/// A cell of a [`Table`].
#[derive(Clone, Debug, PartialEq)]
pub enum TableCell {
    /// Words.
    Text(String),
    /// A number.
    Number(f64),
    /// Nothing was measured or published.
    Nothing,
}

impl From<&str> for TableCell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for TableCell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for TableCell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl From<Option<f64>> for TableCell {
    fn from(number: Option<f64>) -> Self {
        number.map_or(Self::Nothing, Self::Number)
    }
}

/// Rows of what was measured.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// What it holds.
    pub caption: String,
    /// The name of every column.
    pub columns: Vec<&'static str>,
    /// A cell for each column.
    pub rows: Vec<Vec<TableCell>>,
}

/// A plot of lines.
#[derive(Clone, Debug, Default)]
pub struct Plotted {
    /// The name of its file, without its ending: letters, digits and hyphens.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// What its axes are of.
    pub axes: [&'static str; 2],
    /// Which of them go by powers of ten.
    pub is_log: [bool; 2],
    /// Its lines.
    pub lines: Vec<PlottedLine>,
}

/// How the points of a line are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drawn {
    /// Marks with lines between them.
    #[default]
    Joined,
    /// A dashed line without marks: a fit.
    Fit,
}

/// A line of a plot.
#[derive(Clone, Debug, Default)]
pub struct PlottedLine {
    /// What stands beside it.
    pub name: String,
    /// How it is drawn.
    pub drawn: Drawn,
    /// Its points, by x.
    pub points: Vec<PlottedPoint>,
}

/// A point of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlottedPoint {
    /// Where it is.
    pub at: [f64; 2],
    /// The quartiles of its y.
    pub quartiles: Option<[f64; 2]>,
}

/// A picture.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// The name of its file, without its ending: letters, digits and hyphens.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The picture as PNG.
    pub png: Vec<u8>,
}

/// Every file of the chapter: its page, its JSON, `plots/` and `pictures/`.
pub fn chapter_files(chapter: &Chapter) -> Vec<ReportFile> {
    let stem = chapter.stem;
    let mut files = vec![
        (PathBuf::from(format!("{stem}.html")), chapter_page::page(chapter).into_bytes()),
        (PathBuf::from(format!("{stem}.json")), format!("{:#}\n", chapter_json(chapter)).into_bytes()),
    ];
    for entry in &chapter.entries {
        let plots = entry.plots.iter();
        files.extend(plots.map(|plot| (plot_path(plot).into(), chapter_plot::standalone(plot).into_bytes())));
        let pictures = entry.pictures.iter();
        files.extend(pictures.map(|picture| (picture_path(picture).into(), picture.png.clone())));
    }
    files
}

pub(super) fn plot_path(plot: &Plotted) -> String {
    format!("plots/{}.svg", plot.name)
}

pub(super) fn picture_path(picture: &Picture) -> String {
    format!("pictures/{}.png", picture.name)
}

fn chapter_json(chapter: &Chapter) -> Value {
    json!({
        "shadowgraph": env!("CARGO_PKG_VERSION"),
        "adapter": chapter.adapter,
        "processors": chapter.processors,
        "effort": chapter.effort,
        "size_px": chapter.size_px,
        "entries": chapter.entries.iter().map(entry_json).collect::<Vec<_>>(),
        "failures": chapter.failures(),
    })
}

fn entry_json(entry: &Entry) -> Value {
    let picture =
        |picture: &Picture| json!({ "file": picture_path(picture), "caption": picture.caption.clone() });
    json!({
        "id": entry.id,
        "source": entry.source,
        "title": entry.title,
        "sentence": entry.sentence,
        "failure": entry.failure,
        "figures": entry.figures.iter().map(figure_json).collect::<Vec<_>>(),
        "tables": entry.tables.iter().map(table_json).collect::<Vec<_>>(),
        "plots": entry.plots.iter().map(plot_json).collect::<Vec<_>>(),
        "pictures": entry.pictures.iter().map(picture).collect::<Vec<_>>(),
    })
}

fn figure_json(figure: &Figure) -> Value {
    let theirs = match figure.theirs {
        Theirs::Nothing => Value::Null,
        Theirs::Number(number) => json!(number),
        Theirs::Words(words) => json!(words),
    };
    json!({
        "key": figure.key,
        "what": figure.what,
        "unit": figure.unit,
        "ours": finite(figure.ours),
        "quartiles": figure.quartiles,
        "theirs": theirs,
    })
}

fn table_json(table: &Table) -> Value {
    let cell = |cell: &TableCell| match cell {
        TableCell::Text(text) => json!(text),
        TableCell::Number(number) => finite(*number),
        TableCell::Nothing => Value::Null,
    };
    let rows: Vec<Vec<Value>> = table.rows.iter().map(|row| row.iter().map(cell).collect()).collect();
    json!({ "caption": table.caption, "columns": table.columns, "rows": rows })
}

fn plot_json(plot: &Plotted) -> Value {
    let point = |point: &PlottedPoint| json!({ "at": point.at, "quartiles": point.quartiles });
    let line = |line: &PlottedLine| {
        let points: Vec<Value> = line.points.iter().map(point).collect();
        json!({ "name": line.name, "is_fit": line.drawn == Drawn::Fit, "points": points })
    };
    let lines: Vec<Value> = plot.lines.iter().map(line).collect();
    json!({ "file": plot_path(plot), "title": plot.title, "axes": plot.axes, "lines": lines })
}
