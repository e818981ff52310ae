//! The page of a chapter.

use maud::{Markup, html};

use super::chapter::{Chapter, Entry, Figure, Table, TableCell, picture_path};
use super::chapter_plot;
use super::html::{Cell, Column, document, plot, range, table};

const FIGURES: &[Column<Figure>] = &[
    ("what", |figure| Cell::Why(figure.what.clone())),
    ("ours", |figure| Cell::Number(figure.ours_text())),
    ("quartiles", |figure| Cell::maybe(figure.quartiles.map(|[lower, upper]| range(lower, upper)))),
    ("theirs", |figure| Cell::Number(figure.theirs_text())),
];

pub(super) fn page(chapter: &Chapter) -> String {
    let [width, height] = chapter.size_px;
    let data = format!("{}.json", chapter.stem);
    document(
        &format!("Shadowgraph: {}", chapter.title),
        &html! {
            header {
                h1 { (chapter.title) }
                p { (chapter.lead) }
                p.facts {
                    "Adapter: " strong { (chapter.adapter) } ". Timed frames of " (width) "×" (height) " pixels, "
                    (chapter.processors) " processors, effort “" (chapter.effort) "”, Shadowgraph "
                    (env!("CARGO_PKG_VERSION")) "."
                }
                ul.nav {
                    @for entry in &chapter.entries { li { a href=(format!("#{}", entry.id)) { (entry.title) } } }
                    li { a href=(data) { "JSON" } }
                }
            }
            main { @for entry in &chapter.entries { (section(entry)) } }
        },
    )
}

fn section(entry: &Entry) -> Markup {
    html! {
        section id=(entry.id) {
            h2 { (entry.title) }
            p.facts { (entry.source) }
            @if let Some(failure) = &entry.failure { p.bad { "Failed: " (failure) } }
            p { (entry.sentence) }
            @if !entry.pictures.is_empty() {
                div.pictures {
                    @for picture in &entry.pictures {
                        figure {
                            img src=(picture_path(picture)) alt=(picture.caption) loading="lazy";
                            figcaption { (picture.caption) }
                        }
                    }
                }
            }
            @if !entry.plots.is_empty() {
                div.grid2 {
                    @for plotted in &entry.plots {
                        (plot("lines", &chapter_plot::svg(plotted), &plotted.title, &html! { (plotted.title) }))
                    }
                }
            }
            @if !entry.figures.is_empty() { (table("Ours beside theirs", &entry.figures, FIGURES)) }
            @for rows in &entry.tables { (rows_of(rows)) }
        }
    }
}

/// A table whose columns are known only as it is made.
fn rows_of(rows: &Table) -> Markup {
    let is_number =
        |column: usize| rows.rows.iter().any(|row| matches!(row.get(column), Some(TableCell::Number(_))));
    let cell = |cell: &TableCell| match cell {
        TableCell::Text(text) => Cell::text(text),
        TableCell::Number(number) => Cell::of(*number),
        TableCell::Nothing => Cell::maybe(None),
    };
    html! {
        div.scroll tabindex="0" role="region" aria-label=(rows.caption) {
            table {
                caption { (rows.caption) }
                thead { tr {
                    @for (column, name) in rows.columns.iter().enumerate() {
                        th.n[is_number(column)] scope="col" { (name) }
                    }
                } }
                tbody { @for row in &rows.rows { tr { @for value in row { (cell(value)) } } } }
            }
        }
    }
}
