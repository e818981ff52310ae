//! `shadowgraph render`: a picture, its shadows' factors, their error and the time it takes.

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use serde_json::{Map, Value, json};
use shadowgraph::engine::gpu::GpuError;
use shadowgraph::engine::render::Frame;
use shadowgraph::engine::shadow::Catalog;
use shadowgraph::measure::json::{error_json, spread_json};
use shadowgraph::measure::motion::{Motion, Moving};
use shadowgraph::measure::pictures::PictureError;
use shadowgraph::measure::timing::{Spread, Timed, time_frames};
use shadowgraph::measure::{
    CONVERGED_SAMPLES, Converged, ErrorTable, Evaluation, KnownReferences, LayerEvaluation, LightError,
    Progress, evaluate, evaluate_converged, evaluate_layers, layer_measured, mean_of_samples, measured,
    pictures,
};
use shadowgraph::prelude::*;

use super::files::Outputs;
use super::output::{note, out};
use super::scenes::{SceneArgs, catalog};
use super::{Failure, files, other};

/// The arguments of `render`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Where the picture goes, as PNG.
    #[arg(short, long, value_name = "OUT.png")]
    output: PathBuf,
    /// Writes each light's linear factor at the first hit to DIR/<light>.exr, NaN where nothing is hit; the mean of the
    /// samples that hit something where edges are smoothed. Where shadows fall on transparent surfaces, also to
    /// DIR/<light>.layerN.exr for the Nth of them, 0 the nearest.
    #[arg(long, value_name = "DIR")]
    visibility: Option<PathBuf>,
    /// Compares every shadowed light with the exact reference and prints the error, also on transparent surfaces that
    /// its shadows fall on; lights of a technique that takes samples of them with those samples first, then with the
    /// whole light.
    #[arg(long)]
    error: bool,
    /// Writes the picture beside the reference's factor and the error map of every shadowed light, as one PNG.
    #[arg(long, value_name = "FILE.png")]
    sheet: Option<PathBuf>,
    /// Times this many frames after a warm-up.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: Option<u32>,
    /// Turns the camera by one degree from one timed frame to the next, round the scene's middle.
    #[arg(long, requires = "frames")]
    orbit: bool,
    /// Plays the scene's animation in the timed frames, over and over, 60 of them a second: the first, or that of --animation, from
    /// --time on.
    #[arg(long, requires = "frames", conflicts_with = "orbit")]
    play: bool,
    /// Writes everything measured as JSON.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// How edges are smoothed: none, msaa4 (four samples a pixel) or ssaa4 (four pixels a pixel).
    #[arg(long, value_name = "HOW", default_value = "none")]
    antialias: Antialias,
    /// The most a frame may take on the GPU, in MiB [default: 4096].
    #[arg(long, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..=1 << 40))]
    gpu_budget: Option<u64>,
    /// The adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// Opens the adapter that was asked for, with every technique, and says which one it is.
pub(crate) fn open(adapter: Option<&str>) -> Result<Renderer, Failure> {
    open_with(adapter, catalog())
}

/// [`open`] with the techniques of `catalog`.
pub(crate) fn open_with(adapter: Option<&str>, catalog: Catalog) -> Result<Renderer, Failure> {
    Ok(Renderer::new(open_gpu(adapter)?, catalog))
}

/// The device of the adapter that was asked for; says which one it is.
fn open_gpu(adapter: Option<&str>) -> Result<Gpu, Failure> {
    let choice = adapter.map_or(AdapterChoice::Auto, |name| AdapterChoice::Named(name.into()));
    let gpu = Gpu::open(&choice).or_else(|error| match error {
        // Where there is none at all, the name is not what is wrong.
        GpuError::NoSuchAdapter { .. } if Gpu::list().is_empty() => Gpu::open(&AdapterChoice::Auto),
        error => Err(error),
    });
    let gpu = gpu.map_err(|error| match error {
        GpuError::NoSuchAdapter { .. } => Failure::Usage(error.to_string()),
        error => RenderError::from(error).into(),
    })?;
    note!("adapter: {}", gpu.name());
    Ok(gpu)
}

pub(crate) fn run(args: &RenderArgs) -> Result<(), Failure> {
    let (scene, camera, read) = args.scene.prepare()?;
    super::view::note_empty(&scene, &camera, args.scene.size.0)?;
    // Where the results go is checked before any time is spent on them.
    let mut outputs = Outputs::beside(&read);
    outputs.reserve(&args.output)?;
    args.json.iter().chain(&args.sheet).try_for_each(|path| outputs.reserve(path))?;
    args.visibility.iter().try_for_each(|folder| outputs.make_folder(folder))?;

    let mut gpu = open_gpu(args.adapter.as_deref())?;
    if let Some(mib) = args.gpu_budget {
        gpu = gpu.with_budget(mib << 20);
    }
    let mut renderer = Renderer::new(gpu, catalog());
    let request = FrameRequest { antialias: args.antialias, ..FrameRequest::new(camera, args.scene.size.0) };
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    let frame = renderer.render(&scene, &request, &options)?;
    let timed = match args.frames {
        Some(frames) => {
            let motion = args.motion(&scene)?;
            let moving = Moving::new(scene.clone(), request.clone(), motion).map_err(RenderError::from)?;
            Some(time_frames(&mut renderer, &mut { moving }, frames as usize)?)
        }
        None => None,
    };
    let judged = args.error || args.sheet.is_some();
    let evaluation = if judged { Some(with_progress(&mut renderer, &scene, &request)?) } else { None };
    let converged = match &evaluation {
        Some(evaluation) => with_progress_converged(&mut renderer, &scene, &request, evaluation)?,
        None => None,
    };

    if let Some(folder) = &args.visibility {
        // Factors take passes of their own, which are no part of what was timed.
        let request = FrameRequest { factors: true, ..request.clone() };
        let frame = renderer.render(&scene, &request, &RenderOptions::default())?;
        stage_factors(&mut outputs, folder, &frame, &request)?;
        stage_layers(&mut outputs, folder, &mut renderer, (&scene, &request), frame.plan.layers)?;
    }
    if let Some(path) = &args.json {
        let errors = [
            evaluation.as_ref().map_or(&[][..], |evaluation| &evaluation.errors),
            converged.as_ref().map_or(&[][..], |converged| &converged.errors),
        ];
        let report = report(renderer.gpu(), &frame, timed.as_ref(), errors, args.frames);
        let text = serde_json::to_string_pretty(&report).map_err(other)?;
        outputs.stage_bytes(path, format!("{text}\n").as_bytes())?;
    }
    if let Some(picture) = &frame.picture {
        let png = files::png(picture)?;
        if let (Some(path), Some(Evaluation { measured, reference, .. })) = (&args.sheet, &evaluation) {
            let reference = converged.as_ref().map_or(reference, |converged| &converged.reference);
            let sheet = pictures::sheet_png(path, &png, measured, reference).map_err(other)?;
            outputs.stage_bytes(path, &sheet)?;
        }
        outputs.stage_bytes(&args.output, &png)?;
    }
    outputs.commit()?;
    if let Some(timed) = &timed {
        print_times(&frame, timed);
    }
    if let Some(evaluation) = &evaluation {
        out!("{}", ErrorTable(&evaluation.errors));
        print_layers(&mut renderer, (&scene, &request), frame.plan.layers)?;
    }
    if let Some(converged) = &converged {
        out!("against the whole light ({CONVERGED_SAMPLES} samples):\n{}", ErrorTable(&converged.errors));
    }
    Ok(())
}

impl RenderArgs {
    /// What moves while frames are timed.
    fn motion(&self, scene: &Scene) -> Result<Motion, Failure> {
        Ok(match (self.orbit, self.play) {
            (true, _) => Motion::Eye,
            (_, true) => Motion::Clip(self.scene.clip(scene, "--play")?, self.scene.time.unwrap_or(0.0)),
            _ => Motion::Still,
        })
    }
}

/// The errors on every layer of transparent surfaces that shadows fall on, nearest first.
fn print_layers(
    renderer: &mut Renderer,
    (scene, request): (&Scene, &FrameRequest),
    layers: u32,
) -> Result<(), Failure> {
    for first in (0..layers).step_by(LAYERS_AT_A_TIME as usize) {
        let range = first..layers.min(first + LAYERS_AT_A_TIME);
        for LayerEvaluation { layer, errors, .. } in
            evaluate_layers(renderer, scene, request, range, &|_, _| {})?
        {
            // There may be fewer layers than were counted.
            if errors.iter().any(|error| error.hit_pixels > 0) {
                out!("layer {layer}\n{}", ErrorTable(&errors));
            }
        }
    }
    Ok(())
}

/// Evaluates behind a progress bar.
pub(crate) fn with_progress(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
) -> Result<Evaluation, Failure> {
    Ok(behind_bar(request, &mut |progress| evaluate(renderer, scene, request, progress))?)
}

/// Compares with whole lights, behind a progress bar, what was compared with a technique's own samples.
fn with_progress_converged(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    evaluation: &Evaluation,
) -> Result<Option<Converged>, Failure> {
    let mut references = KnownReferences::default();
    Ok(behind_bar(request, &mut |progress| {
        evaluate_converged(renderer, scene, request, evaluation, &mut references, progress)
    })?)
}

/// What `work` returns, with a bar that shows its progress.
fn behind_bar<T>(request: &FrameRequest, work: &mut dyn FnMut(&Progress<'_>) -> T) -> T {
    let bar = ProgressBar::new(u64::from(request.size_px[1]));
    if let Ok(style) = ProgressStyle::with_template("reference {bar:40} {percent:>3} % {eta:>4} left") {
        bar.set_style(style);
    }
    let result = work(&|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    result
}

/// Every light's factor, to go to its file in `folder`.
fn stage_factors(
    outputs: &mut Outputs,
    folder: &Path,
    frame: &Frame,
    request: &FrameRequest,
) -> Result<(), Failure> {
    let FrameRequest { size_px, antialias, .. } = *request;
    let measured = measured(frame, antialias.factor_size_px(size_px))?;
    for light in &frame.plan.lights {
        let image = measured.lights.iter().find(|(name, _)| *name == light.name);
        // A light without shadow node shines everywhere.
        let lit = || measured.ids.iter().map(|id| if id[0] == u32::MAX { f32::NAN } else { 1.0 }).collect();
        let mut factor = image.map_or_else(lit, |(_, factor)| factor.clone());
        if antialias != Antialias::None {
            factor = mean_of_samples(measured.size_px, &factor);
        }
        stage_factor(outputs, &folder.join(format!("{}.exr", light.name)), size_px, &factor)?;
    }
    Ok(())
}

fn stage_factor(
    outputs: &mut Outputs,
    path: &Path,
    size_px: [u32; 2],
    factor: &[f32],
) -> Result<(), Failure> {
    outputs.reserve(path)?;
    outputs.stage(path, |temporary| {
        pictures::write_factor(temporary, size_px, factor).map_err(|error| match error {
            // The caller names the place it is for.
            PictureError::Write { source, .. } => source,
            error => std::io::Error::other(error.to_string()),
        })
    })
}

/// So many layers are rendered at a time: their images are on the GPU together.
const LAYERS_AT_A_TIME: u32 = 4;

/// The factor of every light with shadow nodes on every layer of transparent surfaces, nearest first.
fn stage_layers(
    outputs: &mut Outputs,
    folder: &Path,
    renderer: &mut Renderer,
    (scene, request): (&Scene, &FrameRequest),
    layers: u32,
) -> Result<(), Failure> {
    for first in (0..layers).step_by(LAYERS_AT_A_TIME as usize) {
        let layer_factors = first..layers.min(first + LAYERS_AT_A_TIME);
        let request = FrameRequest { layer_factors, ..request.clone() };
        let frame = renderer.render(scene, &request, &RenderOptions::default())?;
        for (number, layer) in (first..).zip(&frame.layers) {
            let size_px = request.antialias.factor_size_px(request.size_px);
            for (light, factor) in layer_measured(layer, size_px)?.lights {
                let factor = match request.antialias {
                    Antialias::None => factor,
                    _ => mean_of_samples(size_px, &factor),
                };
                let path = folder.join(format!("{light}.layer{number}.exr"));
                stage_factor(outputs, &path, request.size_px, &factor)?;
            }
        }
    }
    Ok(())
}

fn print_times(frame: &Frame, timed: &Timed) {
    let spread = |s: &Spread| format!("median {:.3} ms, min {:.3}, max {:.3}", s.median, s.min, s.max);
    out!("frame, wall clock: {}", spread(&timed.frames.wall_ms));
    out!("  on the CPU, planning: {}", spread(&timed.frames.plan_ms));
    out!("  on the CPU, encoding: {}", spread(&timed.frames.encode_ms));
    if let Some(gpu) = &timed.passes.frame_ms {
        out!("frame, GPU clock: {}", spread(gpu));
    }
    for (pass, ms) in frame.plan.passes.iter().zip(&timed.passes.pass_ms) {
        let is_kept = frame.plan.written_by(pass).any(|slot| frame.plan.slot(slot).kept.is_some());
        let kept = if is_kept && ms.is_some_and(|ms| ms.median == 0.0) { " (kept: drawn once)" } else { "" };
        let ms = ms.map_or("-".into(), |ms| format!("{:.3}", ms.median));
        out!("  {ms:>9} ms  {}{kept}", pass.name);
    }
}

fn report(
    gpu: &Gpu,
    frame: &Frame,
    timed: Option<&Timed>,
    [errors, converged]: [&[LightError]; 2],
    frames: Option<u32>,
) -> Value {
    let passes: Vec<Value> = frame
        .plan
        .passes
        .iter()
        .enumerate()
        .map(|(index, pass)| {
            let vertices: u64 = pass.draws.iter().map(|draw| draw.vertices()).sum();
            json!({
                "name": pass.name,
                "reason": pass.reason,
                "draws": pass.draws.len(),
                "vertices": vertices,
                "gpu_ms": timed.and_then(|timed| timed.passes.pass_ms.get(index).copied().flatten()).map(|ms| ms.median),
            })
        })
        .collect();
    let lights: Vec<Value> = frame
        .plan
        .lights
        .iter()
        .map(|light| {
            let mut entry = Map::new();
            entry.insert("name".into(), json!(light.name));
            let names: Vec<&str> = light.techniques.iter().filter_map(|t| t.split(' ').next()).collect();
            let technique = if names.is_empty() { "none".into() } else { names.join(" + ") };
            entry.insert("technique".into(), json!(technique));
            // With the options that are not at their default.
            entry.insert("techniques".into(), json!(light.techniques));
            if let Some(error) = errors.iter().find(|error| error.name == light.name) {
                entry.insert("error".into(), error_json(error));
            }
            // Where the technique takes samples: beside the whole light.
            if let Some(error) = converged.iter().find(|error| error.name == light.name) {
                entry.insert("error_whole_light".into(), error_json(error));
            }
            Value::Object(entry)
        })
        .collect();
    let mut report = json!({
        "adapter": gpu.name(),
        "size_px": frame.plan.picture_size_px(),
        "antialias": frame.plan.antialias.to_string(),
        "passes": passes,
        "gpu_bytes": frame.gpu_bytes,
        "plan_bytes": frame.plan.bytes(),
        "lights": lights,
    });
    if let Some(timed) = timed {
        let mut times = spread_json(&timed.frames.wall_ms);
        times["count"] = json!(frames);
        times["wall"] = spread_json(&timed.frames.wall_ms);
        times["plan"] = spread_json(&timed.frames.plan_ms);
        times["encode"] = spread_json(&timed.frames.encode_ms);
        times["gpu"] = timed.passes.frame_ms.as_ref().map_or(Value::Null, spread_json);
        report["frames"] = times;
    }
    report
}
