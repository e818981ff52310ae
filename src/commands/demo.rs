//! `shadowgraph demo`: the demo scenes as pictures, with a table of speed and error.

use std::path::PathBuf;

use clap::Args;
use shadowgraph::demo;
use shadowgraph::measure::motion::{Motion, Moving};
use shadowgraph::measure::timing::time_frames;
use shadowgraph::measure::{LightError, Measured, ReferenceImage, pictures};
use shadowgraph::prelude::*;

use super::args::Size;
use super::output::{note, out};
use super::render::{open, with_progress};
use super::{Failure, files, other};

/// The arguments of `demo`.
#[derive(Debug, Args)]
pub(crate) struct DemoArgs {
    /// Where the pictures go.
    #[arg(short, long, value_name = "DIR", default_value = "out/demo")]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, default_value = "1280x720", value_name = "WxH")]
    size: Size,
    /// Frames timed for each scene.
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
    /// How edges of the pictures are smoothed: none, msaa4 or ssaa4; what is timed and judged is not.
    #[arg(long, value_name = "HOW", default_value = "ssaa4")]
    antialias: Antialias,
    /// The adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

/// A line of the first table, and lines of the second.
struct Rows {
    scene: String,
    lights: Vec<String>,
}

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let mut renderer = open(args.adapter.as_deref())?;
    files::make_folder(&args.output)?;
    let mut rows = Vec::new();
    for (name, shows, scene) in demo::all().into_iter().chain(demo::mixed()) {
        note!("{name}: {shows}");
        rows.push(show(&mut renderer, args, name, &scene)?);
    }
    let [width, height] = args.size.0;
    out!("");
    out!("{}, {width}x{height}, median of {} frames on the wall clock", renderer.gpu().name(), args.frames);
    out!(
        "{:<11} {:>6} {:>12} {:>12} {:>14} {:>8} {:>12} {:>12}",
        "scene",
        "lights",
        "unshadowed",
        "shadowed",
        "pixels judged",
        "wrong",
        "wrong %",
        "out of band"
    );
    out!("{:<11} {:>6} {:>12} {:>12}", "", "", "ms", "ms");
    rows.iter().for_each(|row| out!("{}", row.scene));
    out!("");
    out!(
        "Light by light. RMSE is over all pixels that are judged; the band is what a pixel's own rounding excuses."
    );
    out!("{:<11} {:<14} {:>8} {:>12} {:>9}  shadows by", "scene", "light", "wrong", "out of band", "RMSE");
    rows.iter().flat_map(|row| &row.lights).for_each(|row| out!("{row}"));
    Ok(())
}

/// Times and judges one scene, and writes its picture and the error map of its worst light.
fn show(renderer: &mut Renderer, args: &DemoArgs, name: &str, scene: &Scene) -> Result<Rows, Failure> {
    let camera = scene.snapshot().map_err(RenderError::from)?.cameras.into_iter().next();
    let camera = camera.ok_or_else(|| Failure::Other(format!("demo scene '{name}' has no camera")))?;
    let request = FrameRequest::new(camera, args.size.0);

    let mut unshadowed = scene.clone();
    let shadows: Vec<_> = scene.nodes().filter(|(_, n)| matches!(n.content, Content::Shadow(_))).collect();
    for (key, _) in &shadows {
        unshadowed.remove(*key).map_err(RenderError::from)?;
    }
    let mut time = |scene: &Scene| {
        let mut still = Moving::new(scene.clone(), request.clone(), Motion::Still)?;
        time_frames(renderer, &mut still, args.frames as usize)
    };
    let [plain, timed] = [time(&unshadowed)?, time(scene)?];
    let evaluation = with_progress(renderer, scene, &request)?;

    let path = args.output.join(format!("{name}.png"));
    let smooth = FrameRequest { antialias: args.antialias, ..request };
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    if let Some(picture) = renderer.render(scene, &smooth, &options)?.picture {
        files::write_png(&path, &picture)?;
    }
    let worst = evaluation.errors.iter().max_by_key(|error| error.wrong);
    if let Some(worst) = worst {
        let map = args.output.join(format!("{name}-error-{}.png", worst.name));
        write_map(&map, &evaluation.measured, &evaluation.reference, &worst.name)?;
    }
    out!("{}", path.display());
    let sum = |value: fn(&LightError) -> usize| evaluation.errors.iter().map(value).sum::<usize>();
    let (compared, wrong) = (sum(|e| e.compared), sum(|e| e.wrong));
    let scene_row = format!(
        "{name:<11} {:>6} {:>12.2} {:>12.2} {:>14} {:>8} {:>12.5} {:>12}",
        evaluation.errors.len(),
        plain.frames.wall_ms.median,
        timed.frames.wall_ms.median,
        compared,
        wrong,
        100.0 * wrong as f64 / compared.max(1) as f64,
        sum(|e| e.wrong_outside_band),
    );
    let light_row = |error: &LightError| {
        let planned = evaluation.frame.plan.lights.iter().find(|light| light.name == error.name);
        format!(
            "{name:<11} {:<14} {:>8} {:>12} {:>9.5}  {}",
            error.name,
            error.wrong,
            error.wrong_outside_band,
            error.rmse,
            planned.map(|light| light.techniques.join(" + ")).unwrap_or_default(),
        )
    };
    Ok(Rows { scene: scene_row, lights: evaluation.errors.iter().map(light_row).collect() })
}

fn write_map(
    path: &std::path::Path,
    measured: &Measured,
    reference: &ReferenceImage,
    light: &str,
) -> Result<(), Failure> {
    pictures::write_error_map(path, measured, reference, light).map_err(other)
}
