//! Measuring everything, one part after the other. What fails is written down, and the rest goes on.

use shadowgraph_engine::gpu::Gpu;
use shadowgraph_engine::render::{FrameError, FrameRequest, RenderError, Renderer};
use shadowgraph_engine::scene::Scene;
use shadowgraph_engine::shadow::{Catalog, Setting, ShadowError, TechniqueEntry};

use super::axes::{self, Axis, AxisScene};
use super::data::{AxisReport, AxisStep, Outcome, Report, ReportScene, SweepReport, SweepStep, label};
use super::effort::Effort;
use super::motion;
use super::references::References;
use super::scene::{self, with_technique};
use super::totals::Totals;
use crate::cases::sweeps::{self, Sweep};
use crate::cases::{Case, Cast};
use crate::compare::timing::{Runner, Spread, take_turns};
use crate::{EvaluateError, KnownReferences, evaluate_again, evaluate_converged};

/// Told how many steps are done, of how many, and what comes next.
pub type Watch<'a> = dyn Fn(usize, usize, &str) + 'a;

/// The steps of a run, told to whoever watches.
pub(super) struct Steps<'a> {
    done: usize,
    all: usize,
    watch: &'a Watch<'a>,
}

impl Steps<'_> {
    pub(super) fn next(&mut self, what: &str) {
        (self.watch)(self.done, self.all, what);
        self.done += 1;
    }

    /// Where `count` more steps end.
    pub(super) fn after(&self, count: usize) -> usize {
        self.done + count
    }

    /// Passes over steps that there turned out to be no need for.
    pub(super) fn skip_to(&mut self, end: usize) {
        self.done = end;
    }
}

/// What is measured with.
pub(super) struct Bench<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) catalog: &'a Catalog,
    pub(super) effort: &'a Effort,
}

impl Bench<'_> {
    pub(super) fn renderer(&self) -> Renderer {
        Renderer::new(self.gpu.clone(), self.catalog.clone())
    }

    /// The settings of all techniques: every one of those for which `every` says so, the default of the others.
    fn settings(&self, every: impl Fn(&TechniqueEntry) -> bool) -> Vec<(TechniqueEntry, Setting)> {
        let of = |entry: &TechniqueEntry| {
            let count = if every(entry) { usize::MAX } else { 1 };
            entry.all_settings().take(count).map(|setting| (*entry, setting)).collect::<Vec<_>>()
        };
        self.catalog.entries().iter().flat_map(of).collect()
    }

    /// Those that scenes try.
    pub(super) fn scene_settings(&self) -> Vec<(TechniqueEntry, Setting)> {
        self.settings(|_| self.effort.scene_settings)
    }

    /// Those that axes try.
    fn axis_settings(&self) -> Vec<(TechniqueEntry, Setting)> {
        self.settings(|_| self.effort.all_settings)
    }

    /// Those that `sweep` tries: every quality of a technique whose own option it sweeps.
    fn settings_for(&self, sweep: &Sweep) -> Vec<(TechniqueEntry, Setting)> {
        let of = |entry: &TechniqueEntry| {
            let tries_all = self.effort.all_settings || sweep.tries_all_of(entry);
            let settings = entry.all_settings().take(if tries_all { usize::MAX } else { 1 });
            sweep.told_apart(entry, settings).into_iter().map(|setting| (*entry, setting)).collect::<Vec<_>>()
        };
        self.catalog.entries().iter().flat_map(of).collect()
    }

    /// A runner for the scene without shadows and one for each setting that can be planned; and of every setting why it cannot.
    pub(super) fn runners(
        &self,
        scene: &Scene,
        request: &FrameRequest,
        settings: &[(TechniqueEntry, Setting)],
    ) -> (Vec<Runner>, Vec<Option<RenderError>>) {
        let runner = |scene| Runner { renderer: self.renderer(), scene, request: request.clone() };
        let mut runners = vec![runner(scene.without_shadows())];
        let errors = settings.iter().map(|(entry, setting)| {
            let mut runner = runner(with_technique(scene, entry, setting));
            let error = runner.renderer.plan(&runner.scene, request).err();
            runners.extend(error.is_none().then_some(runner));
            error
        });
        let errors = errors.collect();
        (runners, errors)
    }
}

/// Measures `scenes`, and what else `effort` asks for, with every technique of `catalog`.
pub fn run(
    gpu: &Gpu,
    catalog: &Catalog,
    scenes: &[ReportScene],
    effort: &Effort,
    references: &mut References,
    watch: &Watch<'_>,
) -> Report {
    let bench = Bench { gpu, catalog, effort };
    let axes = if effort.parts.scaling { axes::all(effort) } else { vec![] };
    let sweeps = if effort.parts.sweeps { sweeps::all() } else { vec![] };
    let scenes = if effort.parts.scenes { scenes } else { &[] };
    let motions = if effort.parts.motion { motion::STEPS } else { 0 };
    let all = scenes.len() * scene::steps(&bench)
        + motions
        + axes.iter().map(|axis| axis.steps.len()).sum::<usize>()
        + sweeps.iter().map(|sweep| bench.settings_for(sweep).len()).sum::<usize>();
    let mut steps = Steps { done: 0, all, watch };
    let mut report = Report {
        adapter: gpu.name(),
        effort: effort.name,
        size_px: effort.size_px,
        sweep_shrink: effort.sweep_shrink,
        processors: std::thread::available_parallelism().map_or(1, usize::from),
        techniques: catalog.entries().iter().map(|e| [e.type_name, e.short_name, e.summary]).collect(),
        ..Report::default()
    };
    for scene in scenes {
        let measured = scene::measure(&bench, scene, references, &mut steps, &mut report.pictures);
        report.scenes.push(measured);
        references.forget();
    }
    report.axes = axes.iter().map(|axis| measure_axis(&bench, axis, &mut steps)).collect();
    if effort.parts.motion {
        report.motions = motion::measure(&bench, &bench.axis_settings(), &mut steps);
    }
    // Nothing is timed there: one renderer, which compiles every shader once.
    let mut renderer = bench.renderer();
    report.sweeps =
        sweeps.iter().map(|sweep| measure_sweep(&bench, &mut renderer, sweep, &mut steps)).collect();
    report
}

/// What an error is: a technique's refusal, which is an answer, or a failure.
pub(super) fn unmeasured<T>(error: &RenderError) -> Outcome<T> {
    match error {
        RenderError::Shadow(shadow) | RenderError::Frame(FrameError::Shadow(shadow))
            if matches!(
                shadow,
                ShadowError::CasterRefused { .. }
                    | ShadowError::MissingFeature { .. }
                    | ShadowError::Unsupported { .. }
            ) =>
        {
            Outcome::Refused(error.to_string())
        }
        _ => Outcome::Failed(error.to_string()),
    }
}

fn measure_axis(bench: &Bench<'_>, axis: &Axis, steps: &mut Steps<'_>) -> AxisReport {
    let settings = bench.axis_settings();
    let labels = settings.iter().map(|(entry, setting)| label(entry.short_name, setting.name));
    let mut report = AxisReport {
        parameter: axis.parameter,
        shows: axis.shows,
        unshadowed_ms: Vec::new(),
        techniques: labels.map(|label| (label, Vec::new())).collect(),
    };
    for step in &axis.steps {
        steps.next(&format!("cost against {}: {}", axis.parameter, step.value));
        let (unshadowed_ms, outcomes) = measure_size(bench, step, &settings);
        report.unshadowed_ms.extend(unshadowed_ms.map(|spread| (step.value, spread)));
        for ((_, steps), outcome) in report.techniques.iter_mut().zip(outcomes) {
            steps.push(AxisStep { value: step.value, outcome });
        }
    }
    report
}

/// One size: frames without shadows, and what every setting adds to them.
fn measure_size(
    bench: &Bench<'_>,
    step: &AxisScene,
    settings: &[(TechniqueEntry, Setting)],
) -> (Option<Spread>, Vec<Outcome<Spread>>) {
    let (scene, camera) = step.build();
    let request = FrameRequest::new(camera, step.size_px);
    let (mut runners, errors) = bench.runners(&scene, &request, settings);
    let failed = |why: String| errors.iter().map(|_| Outcome::Failed(why.clone())).collect();
    let times_ms = match take_turns(&mut runners, &bench.effort.axis_pace) {
        Ok(times_ms) => times_ms,
        Err(error) => return (None, failed(error.to_string())),
    };
    let mut shadowed = times_ms[1..].iter();
    let outcomes = errors.iter().map(|error| match error {
        Some(error) => unmeasured(error),
        None => {
            let with_ms = shadowed.next().map_or(&[][..], |times| times);
            let added = with_ms.iter().zip(&times_ms[0]).map(|(with, without)| with - without);
            Outcome::Measured(Spread::of(added.collect()))
        }
    });
    (Some(Spread::of(times_ms[0].clone())), outcomes.collect())
}

fn measure_sweep(
    bench: &Bench<'_>,
    renderer: &mut Renderer,
    sweep: &Sweep,
    steps: &mut Steps<'_>,
) -> SweepReport {
    let mut all = sweep.steps(&Cast::NOBODY);
    all.retain(|(value, _)| bench.effort.sweep_shrink == 1 || *value < sweep.slow_from);
    let last = all.len().saturating_sub(1);
    let stride = bench.effort.sweep_stride.max(1);
    let taken: Vec<&(f64, Case)> =
        all.iter().enumerate().filter(|(i, _)| i % stride == 0 || *i == last).map(|(_, step)| step).collect();
    // Traced once for all techniques and settings.
    let [_, whole_light] = bench.effort.whole_light_samples;
    let mut known = vec![KnownReferences::with_samples(whole_light); taken.len()];
    let request = |case: &Case| {
        let request = case.request();
        FrameRequest {
            size_px: request.size_px.map(|side| side.div_ceil(bench.effort.sweep_shrink)),
            ..request
        }
    };
    let mut techniques = Vec::new();
    for (entry, setting) in bench.settings_for(sweep) {
        let label = label(entry.short_name, setting.name);
        steps.next(&format!("sweep {}: {label}", sweep.id));
        let measure = |((value, case), known): (&&(f64, Case), &mut KnownReferences)| {
            let outcome = match case.scene_with(&entry, &(setting.params)()) {
                Ok(scene) => measure_case(renderer, &scene, &request(case), known),
                Err(error) => Outcome::Failed(error.to_string()),
            };
            SweepStep { value: *value, outcome }
        };
        techniques.push((label, taken.iter().zip(&mut known).map(measure).collect()));
    }
    let compared = bench.catalog.entries().iter().find(|entry| sweep.compares(entry));
    SweepReport {
        id: sweep.id,
        parameter: sweep.parameter,
        unit: sweep.unit,
        is_log: sweep.axis == sweeps::Axis::Log,
        what_breaks: sweep.what_breaks,
        f32_loses: sweep.f32_loses,
        option: sweep.option,
        compares: compared.map(|entry| entry.short_name),
        techniques,
    }
}

fn measure_case(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    known: &mut KnownReferences,
) -> Outcome<Totals> {
    match evaluate_again(renderer, scene, request, known, &|_, _| {}) {
        // Beside the whole light, whatever samples a technique takes.
        Ok(found) => match evaluate_converged(renderer, scene, request, &found, known, &|_, _| {}) {
            Ok(Some(whole)) => {
                Outcome::Measured(Totals::of(&whole.errors, &found.measured, &whole.reference))
            }
            Ok(None) => Outcome::Measured(Totals::of(&found.errors, &found.measured, &found.reference)),
            Err(error) => Outcome::Failed(error.to_string()),
        },
        Err(EvaluateError::Render(error)) => unmeasured(&error),
        Err(error) => Outcome::Failed(error.to_string()),
    }
}
