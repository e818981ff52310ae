//! `shadowgraph report --papers`: the tables and figures of the papers made again, as a page, as JSON and as a short table.

use std::time::Instant;

use shadowgraph::measure::report::{Chapter, Theirs, chapter_files};
use shadowgraph::papers::{self, Effort};

use super::Failure;
use super::files::Outputs;
use super::output::{note, out};
use super::render::open_with;
use super::report::{ReportArgs, failed, progress_bar, stage};

pub(super) fn run(args: &ReportArgs) -> Result<(), Failure> {
    let effort = if args.quick { Effort::QUICK } else { Effort::DEFAULT };
    let effort = args.size.map_or(effort, |size| effort.sized(size.0));
    // Where the results go is checked before any time is spent on them.
    let page = args.output.join("papers.html");
    let mut outputs = Outputs::default();
    outputs.make_folder(&args.output)?;
    outputs.reserve(&page)?;

    let renderer = open_with(args.adapter.as_deref(), shadowgraph::nodes::catalog())?;
    let start = Instant::now();
    // Entries differ too much for a guess at what is left.
    let bar = progress_bar("{bar:30} {pos}/{len} {elapsed:>4}: {wide_msg}");
    let chapter = papers::run(renderer.gpu(), &effort, &|done, all, what| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
        bar.set_message(what.to_owned());
    });
    bar.finish_and_clear();
    for file in chapter_files(&chapter) {
        stage(&mut outputs, &args.output, &page, file)?;
    }
    outputs.commit()?;
    note!("measured in {:.0} s", start.elapsed().as_secs_f64());
    out!("{}", table(&chapter));
    out!("{}", page.display());
    failed(&chapter.failures())
}

/// What is said of theirs, with ours before it.
fn table(chapter: &Chapter) -> String {
    let figures = chapter.entries.iter().flat_map(|entry| {
        let published = entry.figures.iter().filter(|figure| figure.theirs != Theirs::Nothing);
        published
            .map(|figure| [entry.id.into(), figure.key.clone(), figure.ours_text(), figure.theirs_text()])
    });
    let heads = ["entry", "figure", "ours", "theirs"].map(String::from);
    let rows: Vec<[String; 4]> = std::iter::once(heads).chain(figures).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths = [0, 1, 2].map(width);
    let line = |[entry, figure, ours, theirs]: &[String; 4]| {
        let [first, second, third] = widths;
        format!("{entry:<first$}  {figure:<second$}  {ours:>third$}  {theirs}")
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}
