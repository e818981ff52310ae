//! The README's list of what is known to be wrong is the tests' own lists; and every entry of these is wrong.
//!
//! `WRITE_DOCS=1` writes it anew; the test fails all the same that once.

use std::fmt::Write;

use crate::known::{
    COMPARED_ONE_CASE_IN, KNOWN, KNOWN_ON_CASES, KNOWN_SEEDS, Known, OUTSIDE_ONE_CASE_IN, SWEPT_ONE_STEP_IN,
    TOLERATED,
};
use crate::search::{FIXED_SEEDS, MENDED_OF_KIND, MENDED_SEEDS};
use crate::slips::cases_named;
use crate::tolerances::{COUNT_NOTHING, LARGE_CASES, ROWS, SOFT, THINNED, THINNED_TO_ONE_IN, Tolerance};
use crate::trials::{no_references, try_setting};
use shadowgraph::cases::sweeps;
use shadowgraph_testing::docs::{holds, text, with_block};

/// Names as code, one after the other.
fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// What is wrong although it should not be.
fn wrong() -> String {
    let mut text = String::new();
    for Known { technique, settings, cases, why } in KNOWN.iter().chain(KNOWN_ON_CASES) {
        let (settings, cases) = (settings.join(", "), listed(cases.iter().copied()));
        writeln!(text, "- `{technique}` ({settings}) on {cases}: {why}.").unwrap();
    }
    for (seed, why) in KNOWN_SEEDS {
        writeln!(text, "- Random scene {seed}: {why}.").unwrap();
    }
    for tolerated in TOLERATED {
        let (case, pixels, why) = (tolerated.case, tolerated.pixels, tolerated.why);
        writeln!(text, "- `{SOFT}` with large lights on `{case}`, up to {pixels} pixels: {why}.").unwrap();
    }
    text
}

/// Where a setting that owes exactness elsewhere owes a bound.
fn bounded() -> String {
    let mut text = String::new();
    let is_exact = |owed: Tolerance| matches!(owed, Tolerance::Exact | Tolerance::ExactWhereAccepted);
    for row in ROWS.iter().filter(|row| is_exact(row.owes)) {
        let (mut why, mut of) = ("", "");
        let mut bounds = Vec::new();
        for (case, owed) in row.exceptions() {
            if let Tolerance::Within(bound) = owed {
                why = bound.why;
                // Where factors are 0 or 1, their share says it all.
                let share = bound.false_share.max(bound.leak_share);
                let is_share = bound.rmse == 1.0;
                of = if is_share { "as a share of the pixels" } else { "as a root mean square" };
                bounds.push(format!("`{case}` {}", if is_share { share } else { bound.rmse }));
            }
        }
        if !bounds.is_empty() {
            let (technique, setting) = (row.technique, row.setting);
            writeln!(text, "- `{technique}` ({setting}): {why}; {of}, {}.", bounds.join(", ")).unwrap();
        }
    }
    text
}

/// What is tried less than fully.
fn thinned() -> String {
    format!(
        "- Settings other than the default of {}: on one case in {THINNED_TO_ONE_IN}, and on none of {}.\n\
         - Ways to one picture, and large lights: on one case in {COMPARED_ONE_CASE_IN}.\n\
         - Sweeps: at one step in {SWEPT_ONE_STEP_IN}, and at the last; {} on no heavy step of {}.\n\
         - The technique from outside the library: on one case in {OUTSIDE_ONE_CASE_IN}.\n",
        listed(THINNED.iter().copied()),
        listed(LARGE_CASES.iter().copied()),
        listed(COUNT_NOTHING.iter().copied()),
        listed(sweeps::all().iter().filter(|sweep| sweep.heavy_from.is_finite()).map(|sweep| sweep.id)),
    )
}

#[test]
fn the_readme_lists_what_is_known_to_be_wrong() {
    let block = format!(
        "Wrong, though they should not be:\n\n{}\nOn single cases a bound in place of exactness, the most that passes:\n\n{}\n\
         Tried less than fully; `./x test --all` tries all but the last:\n\n{}",
        wrong(),
        bounded(),
        thinned()
    );
    holds("README.md", &with_block(text("README.md"), "known to be wrong", &block));
}

/// Conformance tries what is thinned on some cases only: here all that is listed is tried.
#[test]
fn what_is_known_on_cases_is_wrong() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut right = Vec::new();
    for known in KNOWN_ON_CASES {
        let entries = renderer.catalog().entries().to_vec();
        let entry = entries.iter().find(|entry| entry.type_name == known.technique).unwrap();
        for case in known.cases.iter().flat_map(|name| cases_named(name)) {
            let mut references = no_references();
            for setting in entry.all_settings().filter(|setting| known.settings.contains(&setting.name)) {
                let trial = try_setting(&mut renderer, &case, (entry, setting), &mut references);
                println!("{:>5.1} s  {}", trial.took.as_secs_f64(), trial.name());
                if trial.complaint.is_none() {
                    right.push(trial.name());
                }
            }
        }
    }
    assert!(right.is_empty(), "right now: strike it out of what is known:\n{}", right.join("\n"));
}

/// A seed that is never judged would stay on the list for good.
#[test]
fn every_known_seed_is_tried_and_the_readme_says_how_many_are_wrong() {
    for (seed, _) in KNOWN_SEEDS {
        assert!(FIXED_SEEDS.contains(seed) || MENDED_SEEDS.contains(seed), "nobody tries {seed}");
    }
    let tried = FIXED_SEEDS.count() + MENDED_SEEDS.len() + MENDED_OF_KIND.len();
    let said = format!("**{}** of {tried} random scenes", KNOWN_SEEDS.len());
    assert!(text("README.md").contains(&said), "the README does not say '{said}'");
}
