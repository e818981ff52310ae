//! `shadowgraph demo`: the demo scenes as pictures, with a table of speed and error.

use std::path::PathBuf;

use clap::Args;
use shadowgraph::demo;
use shadowgraph::measure::timing::time_frames;
use shadowgraph::measure::{Measured, ReferenceImage, pictures};
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
    /// The adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    adapter: Option<String>,
}

pub(crate) fn run(args: &DemoArgs) -> Result<(), Failure> {
    let mut renderer = open(args.adapter.as_deref())?;
    files::make_folder(&args.output)?;
    let mut rows = Vec::new();
    for (name, shows, scene) in demo::all() {
        note!("{name}: {shows}");
        let camera = scene.snapshot().map_err(RenderError::from)?.cameras.into_iter().next();
        let camera = camera.ok_or_else(|| Failure::Other(format!("demo scene '{name}' has no camera")))?;
        let request = FrameRequest::new(camera, args.size.0);

        let mut unshadowed = scene.clone();
        let shadows: Vec<_> =
            scene.nodes().filter(|(_, n)| matches!(n.content, Content::Shadow(_))).collect();
        for (key, _) in &shadows {
            unshadowed.remove(*key).map_err(RenderError::from)?;
        }
        let plain = time_frames(&mut renderer, &unshadowed, &request, args.frames as usize)?;
        let timed = time_frames(&mut renderer, &scene, &request, args.frames as usize)?;
        let evaluation = with_progress(&mut renderer, &scene, &request)?;

        let path = args.output.join(format!("{name}.png"));
        if let Some(picture) = &evaluation.frame.picture {
            files::write_png(&path, picture)?;
        }
        let worst = evaluation.errors.iter().max_by_key(|error| error.wrong);
        if let Some(worst) = worst {
            let map = args.output.join(format!("{name}-error-{}.png", worst.name));
            write_map(&map, &evaluation.measured, &evaluation.reference, &worst.name)?;
        }
        let sum = |value: fn(&shadowgraph::measure::LightError) -> usize| {
            evaluation.errors.iter().map(value).sum::<usize>()
        };
        let (compared, wrong) = (sum(|e| e.compared), sum(|e| e.wrong));
        rows.push(format!(
            "{name:<10} {:>6} {:>12.2} {:>12.2} {:>14} {:>8} {:>12.5} {:>12}",
            evaluation.errors.len(),
            plain.wall_ms.median,
            timed.wall_ms.median,
            compared,
            wrong,
            100.0 * wrong as f64 / compared.max(1) as f64,
            sum(|e| e.wrong_outside_band),
        ));
        out!("{}", path.display());
    }
    let [width, height] = args.size.0;
    out!("");
    out!("{}, {width}x{height}, median of {} frames on the wall clock", renderer.gpu().name(), args.frames);
    out!(
        "{:<10} {:>6} {:>12} {:>12} {:>14} {:>8} {:>12} {:>12}",
        "scene",
        "lights",
        "unshadowed",
        "shadowed",
        "pixels judged",
        "wrong",
        "wrong %",
        "out of band"
    );
    out!("{:<10} {:>6} {:>12} {:>12}", "", "", "ms", "ms");
    rows.iter().for_each(|row| out!("{row}"));
    Ok(())
}

fn write_map(
    path: &std::path::Path,
    measured: &Measured,
    reference: &ReferenceImage,
    light: &str,
) -> Result<(), Failure> {
    pictures::write_error_map(path, measured, reference, light).map_err(other)
}
