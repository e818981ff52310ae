//! One scene: every technique and setting, its time beside the frame without shadows, its error, its pictures.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use shadowgraph_engine::gpu::Pixels;
use shadowgraph_engine::render::{Frame, FrameRequest, RenderError, RenderOptions};
use shadowgraph_engine::scene::{Scene, Scope, ShadowNode};
use shadowgraph_engine::shadow::{Setting, TechniqueEntry};

use shadowgraph_engine::shadow::receivers_for;

use super::data::{Measurement, Outcome, PassReport, Point, ReportScene, SceneReport};
use super::references::{References, Traced};
use super::run::{Bench, Steps, unmeasured};
use super::totals::Totals;
use crate::compare::evaluate::on_receivers;
use crate::compare::timing::{PassTimes, Runner, Spread, take_turns, time_passes};
use crate::{LightError, LightQuery, Measured, compare, converged_queries, measured, pictures, queries_with};

/// The scene with this technique and setting in its shadow nodes, whose scopes stay; without any, one over everything. A
/// technique that shades receivers only gets those it accepts where nodes name none.
pub(super) fn with_technique(scene: &Scene, entry: &TechniqueEntry, setting: &Setting) -> Scene {
    let mut scene = scene.clone();
    let params = (setting.params)();
    let made = (entry.from_params)(&params).ok().zip(scene.snapshot().ok());
    let receivers = made.map_or(Scope::All, |(made, snapshot)| receivers_for(&snapshot, made.as_ref()));
    let shadows: Vec<_> = scene.shadows().map(|(key, _)| key).collect();
    for key in &shadows {
        if let Some(node) = scene.shadow_mut(*key) {
            node.technique = entry.type_name.into();
            node.params = params.clone();
            if node.receivers == Scope::All {
                node.receivers = receivers.clone();
            }
        }
    }
    if shadows.is_empty() {
        let node =
            ShadowNode { technique: entry.type_name.into(), params, receivers, ..ShadowNode::default() };
        scene.add_shadow(entry.short_name, node);
    }
    scene
}

/// How many steps [`measure`] takes.
pub(super) fn steps(bench: &Bench<'_>) -> usize {
    1 + bench.scene_settings().len()
}

/// A setting that the techniques accept for the scene, in the making.
struct Accepted {
    /// Which of the scene's points it is.
    point: usize,
    shadowed_ms: Spread,
    ratio: Spread,
    rounds: usize,
    passes: PassTimes,
}

pub(super) fn measure(
    bench: &Bench<'_>,
    scene: &ReportScene,
    references: &mut References,
    steps: &mut Steps<'_>,
    pictures: &mut BTreeMap<String, Vec<u8>>,
) -> SceneReport {
    let mut report =
        SceneReport { name: scene.name.clone(), shows: scene.shows.clone(), ..SceneReport::default() };
    if let Err(why) = fill(bench, scene, references, steps, pictures, &mut report) {
        report.failure = Some(why);
        report.points.clear();
    }
    report
}

fn fill(
    bench: &Bench<'_>,
    scene: &ReportScene,
    references: &mut References,
    steps: &mut Steps<'_>,
    pictures: &mut BTreeMap<String, Vec<u8>>,
    report: &mut SceneReport,
) -> Result<(), String> {
    let end = steps.after(self::steps(bench));
    let (given, camera) = scene.scene.as_ref().map_err(Clone::clone).inspect_err(|_| steps.skip_to(end))?;
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let snapshot = given.snapshot().map_err(|error| said(&error)).inspect_err(|_| steps.skip_to(end))?;
    report.triangles = snapshot.instances.iter().map(|instance| instance.mesh.triangle_count()).sum();
    report.lights = snapshot.lights.len();
    let request = FrameRequest::new(camera.clone(), bench.effort.size_px);

    let settings = bench.scene_settings();
    let (mut runners, errors) = bench.runners(given, &request, &settings);
    let mut accepted_points = Vec::new();
    for ((entry, setting), error) in settings.iter().zip(&errors) {
        let outcome = match error {
            Some(error) => unmeasured(error),
            None => {
                accepted_points.push(report.points.len());
                Outcome::Failed("it was not measured".into())
            }
        };
        report.points.push(point(entry, setting, outcome)?);
    }
    steps.next(&format!("{}: time", scene.name));
    let accepted = time(bench, &mut runners, accepted_points, report)
        .map_err(|error| said(&error))
        .inspect_err(|_| steps.skip_to(end))?;
    let mut runners = runners.into_iter();
    drop(runners.next());
    let mut shelf = Shelf { scene: file_name(&scene.name), pictures };
    for (mut runner, accepted) in runners.zip(accepted) {
        let index = accepted.point;
        steps.next(&format!("{}: error of {}", scene.name, report.points[index].label()));
        let judged = judge(bench, &mut runner, references);
        report.points[index].outcome = match judged {
            Ok(judged) => {
                report.reference_ms = judged.traced.trace_ms;
                report.none.get_or_insert_with(|| no_shadows(&judged));
                match shelf.measurement(&judged, accepted, &report.points[index].label()) {
                    Ok(measurement) => Outcome::Measured(Box::new(measurement)),
                    Err(why) => Outcome::Failed(why),
                }
            }
            Err(outcome) => outcome,
        };
    }
    steps.skip_to(end);
    Ok(())
}

fn point(
    entry: &TechniqueEntry,
    setting: &Setting,
    outcome: Outcome<Box<Measurement>>,
) -> Result<Point, String> {
    let params = (setting.params)();
    // A setting that its own technique does not accept is a mistake of the technique's.
    let technique = (entry.from_params)(&params)
        .map_err(|error| format!("setting '{}' of {}: {error}", setting.name, entry.type_name))?;
    Ok(Point {
        technique: entry.type_name,
        short_name: entry.short_name,
        setting: setting.name,
        why: setting.why,
        params,
        known_error: technique.traits().known_error,
        outcome,
    })
}

/// Times all runners in turn, and then each one's passes; the first runner has no shadows.
fn time(
    bench: &Bench<'_>,
    runners: &mut [Runner],
    points: Vec<usize>,
    report: &mut SceneReport,
) -> Result<Vec<Accepted>, RenderError> {
    let times_ms = take_turns(runners, &bench.effort.scene_pace)?;
    report.rounds = times_ms[0].len();
    report.unshadowed_ms = Spread::of(times_ms[0].clone());
    let mut accepted = Vec::new();
    for ((point, runner), with_ms) in points.into_iter().zip(&mut runners[1..]).zip(&times_ms[1..]) {
        let ratios = with_ms.iter().zip(&times_ms[0]).map(|(with, without)| with / without.max(1e-6));
        let Runner { renderer, scene, request } = runner;
        accepted.push(Accepted {
            point,
            shadowed_ms: Spread::of(with_ms.clone()),
            ratio: Spread::of(ratios.collect()),
            rounds: with_ms.len(),
            passes: time_passes(
                renderer,
                scene,
                request,
                bench.effort.pass_frames,
                bench.effort.scene_pace.budget_of_one(),
            )?,
        });
    }
    Ok(accepted)
}

/// A setting's frame beside the reference.
struct Judged {
    /// A frame as it was timed, for its plan and its bytes: reading factors takes passes of its own.
    frame: Frame,
    same_samples: Option<(u32, usize)>,
    measured: Measured,
    traced: Arc<Traced>,
    errors: Vec<LightError>,
}

fn judge(
    bench: &Bench<'_>,
    runner: &mut Runner,
    references: &mut References,
) -> Result<Judged, Outcome<Box<Measurement>>> {
    let Runner { renderer, scene, request } = runner;
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    let frame = renderer.render(scene, request, &options).map_err(|error| unmeasured(&error))?;
    let (snapshot, registry) = renderer.snapshot(scene).map_err(|error| unmeasured(&error))?;
    let [whole_light, _] = bench.effort.whole_light_samples;
    let own_queries = queries_with(&registry, whole_light);
    if own_queries.is_empty() {
        return Err(Outcome::Failed("no shadow node serves any light: there is nothing to compare".into()));
    }
    // A light with a size is asked thousands of times at every pixel: fewer of them will do.
    let is_sized = own_queries.iter().any(|query| !query.sized.is_empty());
    let area = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
    let soft_size_px = bench.effort.soft_size_px;
    let is_smaller = is_sized && area(soft_size_px) < area(request.size_px);
    let size_px = if is_smaller { soft_size_px } else { request.size_px };
    let request = FrameRequest { factors: true, size_px, ..request.clone() };
    let judged = renderer.render(scene, &request, &RenderOptions::default());
    let judged = judged.map_err(|error| unmeasured(&error))?;
    let failed = |error: &dyn std::fmt::Display| Outcome::Failed(error.to_string());
    let measured = measured(&judged, size_px).map_err(|error| failed(&error))?;
    let mut beside = |queries: &[LightQuery]| {
        let mut traced = references.get(&snapshot, &request, queries, &|_, _| {});
        if let Cow::Owned(image) = traced.image.as_seen(&measured.ids) {
            traced = Arc::new(Traced { image, trace_ms: traced.trace_ms });
        }
        if let Some(image) = on_receivers(&registry, &traced.image) {
            traced = Arc::new(Traced { image, trace_ms: traced.trace_ms });
        }
        let errors = compare(&measured, &traced.image).map_err(|error| failed(&error))?;
        Ok((traced, errors))
    };
    let (mut traced, mut errors) = beside(&own_queries)?;
    let mut same_samples = None;
    if let Some(queries) = converged_queries(&own_queries, whole_light) {
        let count = errors.iter().filter_map(|error| error.same_samples).max();
        let outside = errors.iter().map(|error| error.outside_bounds).sum();
        same_samples = count.map(|count| (count, outside));
        (traced, errors) = beside(&queries)?;
    }
    Ok(Judged { frame, same_samples, measured, traced, errors })
}

/// What a frame whose every factor is 1 gets wrong: the other end of the axis.
fn no_shadows(judged: &Judged) -> Totals {
    let mut measured = judged.measured.clone();
    for (_, factor) in &mut measured.lights {
        factor.fill(1.0);
    }
    let errors = compare(&measured, &judged.traced.image).unwrap_or_default();
    Totals::of(&errors, &measured, &judged.traced.image)
}

/// Where a scene's pictures go. Equal pictures are kept once.
struct Shelf<'a> {
    scene: String,
    pictures: &'a mut BTreeMap<String, Vec<u8>>,
}

impl Shelf<'_> {
    fn put(&mut self, name: &str, png: Vec<u8>) -> String {
        let prefix = format!("pictures/{}-", self.scene);
        if let Some((known, _)) =
            self.pictures.iter().find(|(path, kept)| path.starts_with(&prefix) && **kept == png)
        {
            return known.clone();
        }
        let path = format!("{prefix}{}.png", file_name(name));
        self.pictures.insert(path.clone(), png);
        path
    }

    fn measurement(
        &mut self,
        judged: &Judged,
        accepted: Accepted,
        label: &str,
    ) -> Result<Measurement, String> {
        let Judged { frame, same_samples, measured, traced, errors } = judged;
        let image = &traced.image;
        let said = |error: &dyn std::fmt::Display| error.to_string();
        let picture = match &frame.picture {
            Some(picture) => self.put(label, png(picture)?),
            None => return Err("the frame has no picture".into()),
        };
        let worst = errors.iter().max_by(|a, b| {
            let badness = |e: &LightError| (e.wrong_outside_band, e.wrong);
            badness(a).cmp(&badness(b)).then(a.rmse.total_cmp(&b.rmse))
        });
        let worst = match worst {
            Some(worst) => {
                let map = pictures::error_map_png(Path::new("error map"), measured, image, &worst.name);
                let map = self.put(&format!("{label}-error-{}", worst.name), map.map_err(|e| said(&e))?);
                let exact = pictures::factor_png(Path::new("reference"), image, &worst.name);
                let exact =
                    self.put(&format!("{label}-reference-{}", worst.name), exact.map_err(|e| said(&e))?);
                Some([worst.name.clone(), map, exact])
            }
            None => None,
        };
        let lights = errors.iter().map(|error| {
            let planned = frame.plan.lights.iter().find(|light| light.name == error.name);
            (planned.map_or(String::new(), |light| light.techniques.join(" + ")), error.clone())
        });
        Ok(Measurement {
            shadowed_ms: accepted.shadowed_ms,
            ratio: accepted.ratio,
            rounds: accepted.rounds,
            gpu_ms: accepted.passes.frame_ms,
            passes: passes(frame, &accepted.passes),
            gpu_bytes: frame.gpu_bytes,
            plan_bytes: frame.plan.bytes(),
            judged_size_px: measured.size_px,
            totals: Totals::of(errors, measured, image),
            same_samples: *same_samples,
            lights: lights.collect(),
            plan: frame.plan.to_string(),
            picture,
            worst,
        })
    }
}

fn passes(frame: &Frame, times: &PassTimes) -> Vec<PassReport> {
    let pass = |(index, pass): (usize, &shadowgraph_engine::plan::Pass)| PassReport {
        name: pass.name.clone(),
        reason: pass.reason.clone(),
        draws: pass.draws.len(),
        vertices: pass.draws.iter().map(|draw| draw.vertices()).sum(),
        gpu_ms: times.pass_ms.get(index).copied().flatten(),
    };
    frame.plan.passes.iter().enumerate().map(pass).collect()
}

/// A picture of 8-bit RGBA as PNG.
fn png(pixels: &Pixels) -> Result<Vec<u8>, String> {
    let [width, height] = pixels.size_px;
    let mut png = std::io::Cursor::new(Vec::new());
    let kind = image::ExtendedColorType::Rgba8;
    image::write_buffer_with_format(&mut png, &pixels.bytes, width, height, kind, image::ImageFormat::Png)
        .map_err(|error| error.to_string())?;
    Ok(png.into_inner())
}

/// A name as part of a file's name, on any system.
fn file_name(name: &str) -> String {
    let kept = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' };
    name.chars().map(kept).take(80).collect()
}
