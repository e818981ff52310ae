//! Every technique × every case × every setting, each held to its row of the table.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use shadowgraph::cases::{Case, Expect};
use shadowgraph::engine::shadow::{Setting, ShadowError, TechniqueEntry};
use shadowgraph::measure::{
    ErrorTable, EvaluateError, Evaluation, KnownReferences, LightError, evaluate_again, pictures,
    queries_with,
};
use shadowgraph::prelude::*;

use super::tolerances::{COUNT_NOTHING, LARGE_CASES, ROWS, Row, THINNED, THINNED_TO_ONE_IN, Tolerance};

/// One technique and setting on one case.
pub(crate) struct Trial {
    pub(crate) technique: &'static str,
    pub(crate) setting: &'static str,
    pub(crate) case: String,
    /// Whether there is a picture, rather than an error.
    pub(crate) accepted: bool,
    /// What is wrong; `None` when everything is as it was declared.
    pub(crate) complaint: Option<String>,
    /// Whether what its setting owes on most cases would not do: what the table excepts this case for.
    pub(crate) needs_exception: bool,
    pub(crate) evaluation: Option<Evaluation>,
    /// How long it took, references that no earlier trial had asked for included.
    pub(crate) took: Duration,
}

impl Trial {
    /// What it is called in messages.
    pub(crate) fn name(&self) -> String {
        format!("{} ({}) on {}", self.technique, self.setting, self.case)
    }
}

/// What a technique says about a case before it is tried.
#[derive(Clone, Copy)]
struct Claims {
    /// It shades the receivers that it accepts, and there may be none.
    receivers_only: bool,
    /// What the case is about casts nothing through it.
    leaves_out: bool,
}

/// So many samples stand for a whole light here: an edge is then off by a share of 0.003 at most, which is well below any
/// bound of the table.
const WHOLE_LIGHT_SAMPLES: u32 = 1024;

/// Tries every technique that `renderer` knows, in every setting, on `case`.
pub(crate) fn try_all(renderer: &mut Renderer, case: &Case, rows: &[Row]) -> Vec<Trial> {
    let mut references = no_references();
    let entries: Vec<TechniqueEntry> = renderer.catalog().entries().to_vec();
    let settings = entries.iter().flat_map(|entry| entry.all_settings().map(move |setting| (entry, setting)));
    let mut trials = Vec::new();
    let turn: usize = case.name().bytes().map(usize::from).sum();
    for (place, (entry, setting)) in settings.enumerate() {
        let is_its_turn = (turn + place).is_multiple_of(THINNED_TO_ONE_IN) && !LARGE_CASES.contains(&case.id);
        if is_thinned(entry.type_name, setting.name) && !is_its_turn {
            continue;
        }
        if case.is_heavy && COUNT_NOTHING.contains(&entry.type_name) && !tries_everything() {
            continue;
        }
        let start = Instant::now();
        let trial = try_one(renderer, case, (entry, setting), rows, &mut references, &trials);
        trials.push(Trial { took: start.elapsed(), ..trial });
    }
    trials
}

/// One setting on `case`, judged as [`try_all`] judges it and whether or not it is its turn there. `references` are those of
/// this case.
pub(crate) fn try_setting(
    renderer: &mut Renderer,
    case: &Case,
    setting: (&TechniqueEntry, Setting),
    references: &mut KnownReferences,
) -> Trial {
    let start = Instant::now();
    let trial = try_one(renderer, case, setting, ROWS, references, &[]);
    Trial { took: start.elapsed(), ..trial }
}

/// No references yet, of as many samples as trials take.
pub(crate) fn no_references() -> KnownReferences {
    KnownReferences::with_samples(WHOLE_LIGHT_SAMPLES)
}

/// Whether `CASE=` or `EVERY_CASE=1` (`./x test --all`) asks for all of what is thinned otherwise.
pub(crate) fn tries_everything() -> bool {
    ["CASE", "EVERY_CASE"].iter().any(|name| std::env::var_os(name).is_some())
}

/// Whether a setting is tried on one case in [`THINNED_TO_ONE_IN`], each case with others of such settings: what is dear
/// beside its default, which is tried on all. `CASE=` and `EVERY_CASE=1` try everything.
pub(crate) fn is_thinned(technique: &str, setting: &str) -> bool {
    !tries_everything() && setting != "default" && THINNED.contains(&technique)
}

/// What an earlier trial found by the very plan that `scene` has, asked the same questions: most settings change nothing on
/// most cases, and the same passes over the same scene give the same factors.
fn found_already(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    trials: &[Trial],
) -> Option<Evaluation> {
    let plan = renderer.plan(scene, &FrameRequest { factors: true, ..request.clone() }).ok()?;
    let (_, registry) = renderer.snapshot(scene).ok()?;
    let queries = queries_with(&registry, WHOLE_LIGHT_SAMPLES);
    let mut found = trials.iter().filter_map(|trial| trial.evaluation.as_ref());
    found.find(|earlier| earlier.queries == queries && earlier.frame.plan == plan).cloned()
}

fn try_one(
    renderer: &mut Renderer,
    case: &Case,
    (entry, setting): (&TechniqueEntry, Setting),
    rows: &[Row],
    references: &mut KnownReferences,
    trials: &[Trial],
) -> Trial {
    let mut trial = Trial {
        technique: entry.type_name,
        setting: setting.name,
        case: case.name(),
        accepted: false,
        complaint: None,
        needs_exception: false,
        evaluation: None,
        took: Duration::ZERO,
    };
    let Some(row) = rows.iter().find(|row| row.technique == entry.type_name && row.setting == setting.name)
    else {
        trial.complaint = Some("no row in the table of tolerances".into());
        return trial;
    };
    let scene = match case.scene_with(entry, &(setting.params)()) {
        Ok(scene) => scene,
        Err(error) => {
            trial.complaint = Some(format!("the setting is not accepted: {error}"));
            return trial;
        }
    };
    let made = (entry.from_params)(&(setting.params)()).ok();
    let claims = Claims {
        receivers_only: made.as_ref().is_some_and(|technique| technique.traits().shades_receivers_only),
        leaves_out: made.is_some_and(|technique| case.is_left_out_by(technique.as_ref())),
    };
    let request = case.request();
    let result = match found_already(renderer, &scene, &request, trials) {
        Some(evaluation) => Ok(evaluation),
        None => evaluate_again(renderer, &scene, &request, references, &|_, _| {}),
    };
    trial.accepted = result.is_ok();
    let owed = row.on(case.id, &case.name());
    trial.needs_exception = owed != row.owes && complaint(case, &result, row.owes, claims).is_some();
    trial.complaint = complaint(case, &result, owed, claims).map(|complaint| match setting.name {
        "default" => complaint,
        _ => format!("{complaint} [{}]", setting.why),
    });
    // Pictures of 4 096 pixels a side are not kept for every setting at once.
    let [width, height] = request.size_px;
    let is_large = u64::from(width) * u64::from(height) > 1 << 20;
    trial.evaluation = result.ok().filter(|_| !is_large || trial.complaint.is_some());
    trial
}

/// What is wrong with a result, in a few lines. What shades receivers only may find none that it accepts, and no shadow on
/// those it finds; that it finds enough is in its row, and for the techniques' own tests.
fn complaint(
    case: &Case,
    result: &Result<Evaluation, EvaluateError>,
    owed: Tolerance,
    claims: Claims,
) -> Option<String> {
    let owed = if matches!(case.expect, Expect::Refused { .. }) { Tolerance::Refused } else { owed };
    let evaluation = match (result, owed) {
        (Ok(_), Tolerance::Refused) => return Some("drew something, but should refuse".into()),
        (Ok(evaluation), _) => evaluation,
        (Err(error), Tolerance::Refused | Tolerance::ExactWhereAccepted) if is_refusal(error) => return None,
        (Err(EvaluateError::Render(RenderError::Shadow(ShadowError::ReceiverRefused { .. }))), _)
            if claims.receivers_only =>
        {
            return None;
        }
        (Err(error), _) => return Some(format!("failed: {error}")),
    };
    let wrong = evaluation.errors.iter().filter_map(|error| match claims.receivers_only {
        true if error.compared == 0 => None,
        _ => complaint_about(case, error, claims, owed),
    });
    let wrong: Vec<String> = wrong.collect();
    (!wrong.is_empty()).then(|| wrong.join("\n"))
}

/// Whether the technique, or the engine for it, said no: neither a lost device nor a picture that cannot be compared.
fn is_refusal(error: &EvaluateError) -> bool {
    matches!(error, EvaluateError::Render(RenderError::Shadow(_) | RenderError::Frame(_)))
}

fn complaint_about(case: &Case, error: &LightError, claims: Claims, owed: Tolerance) -> Option<String> {
    let name = &error.name;
    // Where nothing is visible there is nothing to compare, and only then.
    if case.expect == Expect::NoShadow && error.hit_pixels == 0 {
        return None;
    }
    let passes = match owed {
        Tolerance::Within(bound) => {
            let share = |pixels: usize| pixels as f64 / error.compared as f64;
            error.compared > 0
                && share(error.leak_outside_band) <= bound.leak_share
                && share(error.false_outside_band) <= bound.false_share
                && error.rmse <= bound.rmse
                && error.penumbra_rmse <= bound.penumbra_rmse
                && error.max <= bound.max
        }
        _ => error.passes(),
    };
    if !passes {
        let (leaks, dark) = (error.leak_outside_band, error.false_outside_band);
        let table = ErrorTable(std::slice::from_ref(error)).to_string();
        return Some(format!("{name}: {leaks} leaks and {dark} false shadows outside the band\n{table}"));
    }
    if claims.leaves_out || claims.receivers_only {
        return None;
    }
    // What a case expects is said of points: a light with a size has its penumbra, and may see what its centre does not.
    if error.same_samples.is_some() || error.penumbra_pixels > 0 {
        return None;
    }
    let lit = error.shadow_pixels < error.compared;
    match case.expect {
        Expect::Shadow if error.shadow_pixels == 0 || !lit => Some(format!("{name}: no shadow to get wrong")),
        Expect::Shadow if error.measured_shadow_pixels == 0 => {
            Some(format!("{name}: no shadow where one is expected"))
        }
        Expect::NoShadow if error.measured_shadow_pixels > 0 && !matches!(owed, Tolerance::Within(_)) => {
            Some(format!("{name}: a shadow where none is expected"))
        }
        _ => None,
    }
}

/// Writes the error maps of a trial into the folder `DUMP`, where it is set, for looking at.
#[allow(clippy::unwrap_used, reason = "a test fails by panicking")]
pub(crate) fn dump(trial: &Trial) {
    let (Some(evaluation), Some(folder)) = (&trial.evaluation, std::env::var_os("DUMP")) else { return };
    let folder = std::path::Path::new(&folder);
    std::fs::create_dir_all(folder).unwrap();
    for (light, _) in &evaluation.measured.lights {
        let name = format!("{}-{}-{}-{light}.png", trial.case, trial.technique, trial.setting);
        let path = folder.join(name.replace('/', "_"));
        pictures::write_error_map(&path, &evaluation.measured, &evaluation.reference, light).unwrap();
    }
}

/// Where the time of many trials went: by technique and setting, and by case, the longest first.
pub(crate) fn print_times<'a>(
    times: impl Iterator<Item = &'a (&'static str, &'static str, String, Duration)>,
) {
    let mut by_setting = BTreeMap::<String, (usize, Duration)>::new();
    let mut by_case = BTreeMap::<String, (usize, Duration)>::new();
    for (technique, setting, case, took) in times {
        let id = case.split('/').next().unwrap_or(case);
        for (sums, name) in
            [(&mut by_setting, format!("{technique} ({setting})")), (&mut by_case, id.to_owned())]
        {
            let (count, sum) = sums.entry(name).or_default();
            *count += 1;
            *sum += *took;
        }
    }
    for sums in [by_setting, by_case] {
        let mut sums: Vec<_> = sums.into_iter().collect();
        sums.sort_by_key(|(_, (_, took))| std::cmp::Reverse(*took));
        for (name, (count, took)) in sums.iter().take(25) {
            println!("{:>8.1} s  {count:>5} trials  {name}", took.as_secs_f64());
        }
    }
}

/// How many renderers work at once: one more than the two cores that the whole suite is measured on.
const AT_ONCE: usize = 3;

/// Asks `judge` about every item, several at a time, each with a renderer of its own: the answers in the order of the items.
/// Drawing and judging take turns, and a thread that waits for the driver leaves its core to others: so there are more
/// renderers than cores. `None` where there is no adapter.
pub(crate) fn with_several_renderers<T: Sync, R: Send>(
    renderer: impl Fn() -> Option<Renderer>,
    items: &[T],
    judge: impl Fn(&mut Renderer, &T) -> R + Sync,
) -> Option<Vec<R>> {
    let renderers: Vec<Renderer> = (0..AT_ONCE).map(|_| renderer()).collect::<Option<_>>()?;
    let next = AtomicUsize::new(0);
    let answers = Mutex::new(Vec::with_capacity(items.len()));
    std::thread::scope(|scope| {
        for mut renderer in renderers {
            let (next, answers, judge) = (&next, &answers, &judge);
            scope.spawn(move || {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else { break };
                    let answer = judge(&mut renderer, item);
                    answers.lock().unwrap_or_else(PoisonError::into_inner).push((index, answer));
                }
            });
        }
    });
    let mut answers = answers.into_inner().unwrap_or_else(PoisonError::into_inner);
    answers.sort_by_key(|(index, _)| *index);
    Some(answers.into_iter().map(|(_, answer)| answer).collect())
}
