//! `shadowgraph fuzz`: a random search for scenes that are drawn wrong.

use std::collections::HashMap;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use shadowgraph::search::{Failure, Family, Judge, Recipe, Tally, Verdict, recipe_of, shrink, write_failure};

use super::output::{note, out};
use super::render::open_with;
use super::{Failure as CommandFailure, files, other};

/// The arguments of `fuzz`.
#[derive(Debug, Args)]
pub(crate) struct FuzzArgs {
    /// How many scenes.
    scenes: u64,
    /// The first seed; a seed and its kind make the same scene everywhere.
    #[arg(long, value_name = "FIRST", default_value_t = 0)]
    seed: u64,
    /// Where failing scenes go, made as small as they fail.
    #[arg(short, long, value_name = "DIR", default_value = "out/fuzz")]
    output: PathBuf,
    /// Only these kinds of scene, in turn.
    #[arg(long, value_name = "KIND,..", value_delimiter = ',')]
    kinds: Vec<Family>,
    /// How many failures of each kind of scene are made small and written; the others are listed.
    #[arg(long, value_name = "N", default_value_t = 3)]
    keep: usize,
    /// How often a failing scene is tried smaller.
    #[arg(long, value_name = "N", default_value_t = 400)]
    trials: usize,
    /// The adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

pub(crate) fn run(args: &FuzzArgs) -> Result<(), CommandFailure> {
    let kinds = if args.kinds.is_empty() { Family::ALL } else { &args.kinds[..] };
    files::make_folder(&args.output)?;
    let mut judge = Judge::new(open_with(args.adapter.as_deref(), shadowgraph::nodes::catalog())?);
    let mut tally = Tally::default();
    let mut kept: HashMap<Family, usize> = HashMap::new();
    let bar = ProgressBar::new(args.scenes);
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {eta:>4} left  {msg}") {
        bar.set_style(style);
    }
    let started = Instant::now();
    for seed in args.seed..args.seed.saturating_add(args.scenes) {
        let family = Family::of_seed(seed, kinds);
        let recipe = recipe_of(seed, family, judge.catalog());
        let verdict = judge.judge(&recipe);
        tally.count(&recipe, &verdict);
        if let Verdict::Wrong(failure) = &verdict {
            let line = failure.lines.first().map_or("", |line| line.as_str());
            bar.suspend(|| out!("{family}-{seed}: {:?}: {line}", failure.kind));
            let kept = kept.entry(family).or_default();
            if *kept < args.keep {
                *kept += 1;
                keep(&mut judge, &recipe, failure, args)?;
            }
        }
        let (wrong, refused) = (tally.wrong().len(), tally.refused());
        bar.set_message(format!("{wrong} wrong, {refused} refused, now {family}"));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let seconds = started.elapsed().as_secs_f64();
    out!("{tally}{} scenes in {seconds:.0} s", tally.scenes());
    match tally.wrong().len() {
        0 => Ok(()),
        wrong => Err(other(format!("{wrong} of {} scenes are wrong", tally.scenes()))),
    }
}

/// Makes a failing scene small and writes it.
fn keep(
    judge: &mut Judge,
    recipe: &Recipe,
    failure: &Failure,
    args: &FuzzArgs,
) -> Result<(), CommandFailure> {
    // A region must not dwindle to a single pixel, nor a pixel grow to a region: those fail for other reasons.
    let least = failure.pixels.min((failure.pixels / 8).max(4));
    let most = failure.pixels.max(4).saturating_mul(6);
    let mut last = failure.clone();
    let small = shrink(recipe, args.trials, &mut |smaller| match judge.judge(smaller) {
        Verdict::Wrong(found) if found.is_like(failure) && (least..=most).contains(&found.pixels) => {
            last = found;
            true
        }
        _ => false,
    });
    let path = write_failure(&args.output, &small, &last, judge.catalog()).map_err(other)?;
    note!("{}: {} triangles of {}", path.display(), small.triangle_count(), recipe.triangle_count());
    Ok(())
}
