//! The part of the page about motion.

use maud::{Markup, html};

use super::data::{MotionReport, Outcome, Report};
use super::html::{Cell, Column, not_measured, table};
use super::scales::number;
use crate::compare::timing::FrameTimes;

/// A technique and setting before one scene, with its frames in each motion.
struct MotionRow {
    name: String,
    /// In the order of [`Motion::OF_ANY_SCENE`](crate::motion::Motion::OF_ANY_SCENE).
    times: Vec<Option<FrameTimes>>,
}

impl MotionRow {
    /// The frame, and of it what the CPU took, in milliseconds.
    fn cell(&self, motion: usize) -> Cell {
        let text = |times: &FrameTimes| {
            let cpu_ms = times.plan_ms.median + times.encode_ms.median;
            format!("{} ({})", number(times.wall_ms.median), number(cpu_ms))
        };
        Cell::maybe(self.times.get(motion).and_then(|times| times.as_ref().map(text)))
    }
}

const COLUMNS: &[Column<MotionRow>] = &[
    ("", |row| Cell::text(&row.name)),
    ("nothing moves", |row| row.cell(0)),
    ("the eye", |row| row.cell(1)),
    ("the lights", |row| row.cell(2)),
    ("a caster", |row| row.cell(3)),
];

/// The rows of one scene's motions.
fn rows(motions: &[MotionReport]) -> Vec<MotionRow> {
    let plain = MotionRow {
        name: "no shadows".into(),
        times: motions.iter().map(|motion| motion.unshadowed).collect(),
    };
    let names = motions.first().map_or(&[][..], |motion| &motion.techniques[..]);
    let of = |(index, (name, _)): (usize, &(String, Outcome<FrameTimes>))| MotionRow {
        name: name.clone(),
        times: motions.iter().map(|motion| motion.techniques[index].1.measured().copied()).collect(),
    };
    std::iter::once(plain).chain(names.iter().enumerate().map(of)).collect()
}

pub(super) fn motion(report: &Report) -> Markup {
    html! {
        section #motion {
            h2 { "Cost of motion" }
            @if report.motions.is_empty() {
                (not_measured())
            } @else {
                p {
                    "Whole frames in milliseconds, and in brackets what of it the CPU takes: planning, and handing the commands over. From \
                     frame to frame something turns by one degree: the eye or the lights round the scene, or its largest caster on the spot."
                }
                @for scene in report.motions.chunk_by(|a, b| a.scene == b.scene) {
                    (table(scene[0].shows, &rows(scene), COLUMNS))
                }
            }
        }
    }
}
