//! `shadowgraph report`: speed against error of every technique, as pages, plots and tables.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use shadowgraph::demo;
use shadowgraph::measure::report::{self, Effort, Parts, References, ReportFile, ReportScene};
use shadowgraph::prelude::*;

use super::Failure;
use super::args::Size;
use super::files::Outputs;
use super::output::{note, out};
use super::render::open_with;
use super::scenes::{SceneArgs, TrustArgs};

/// The arguments of `report`.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Scenes to report on (.gltf or .glb) [default: the project's demo and speed scenes].
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Where the report goes: index.html, report.csv, report.json, plots/ and pictures/.
    #[arg(short, long, value_name = "DIR")]
    pub(super) output: PathBuf,
    /// Makes the tables and figures of the implemented papers again instead: papers.html, papers.json, plots/ and pictures/; about ten
    /// minutes on two cores with the software driver, with --quick under one.
    #[arg(long, conflicts_with_all = ["scenes", "full", "parts", "plot", "references", "outside_files", "memory"])]
    papers: bool,
    /// Smaller frames, fewer sizes, and on the own scenes defaults only: under two minutes on two cores with the software driver.
    #[arg(long, conflicts_with = "full")]
    pub(super) quick: bool,
    /// Every setting everywhere, 4K and the largest sizes.
    #[arg(long)]
    full: bool,
    /// The size of the scenes' frames instead of that of the effort.
    #[arg(long, value_name = "WxH")]
    pub(super) size: Option<Size>,
    /// What is measured: scenes, scaling, motion, sweeps; several joined by commas.
    #[arg(long, value_name = "PARTS", value_delimiter = ',', default_value = "scenes,scaling,motion,sweeps")]
    parts: Vec<Part>,
    /// Writes the main plot to this file as well.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Keeps traced references in this folder for the next run.
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
    /// The adapter whose name contains this.
    #[arg(long, value_name = "NAME")]
    pub(super) adapter: Option<String>,
    #[command(flatten)]
    trust: TrustArgs,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    Scenes,
    Scaling,
    Motion,
    Sweeps,
}

impl ReportArgs {
    fn effort(&self) -> Effort {
        let effort = match (self.quick, self.full) {
            (true, _) => Effort::QUICK,
            (_, true) => Effort::FULL,
            _ => Effort::DEFAULT,
        };
        let has = |part| self.parts.contains(&part);
        let parts = Parts {
            scenes: has(Part::Scenes),
            scaling: has(Part::Scaling),
            motion: has(Part::Motion),
            sweeps: has(Part::Sweeps),
        };
        // Ten scenes with every setting would not be quick.
        let scene_settings = !(self.quick && self.scenes.is_empty());
        let size_px = self.size.map_or(effort.size_px, |size| size.0);
        Effort { parts, size_px, scene_settings, ..effort }
    }

    /// The scenes, and every file that was read for them.
    fn scenes(&self) -> (Vec<ReportScene>, Vec<PathBuf>) {
        if self.scenes.is_empty() {
            let own = demo::all().into_iter().chain(demo::speed());
            return (
                own.map(|(name, shows, scene)| of_the_project(name, shows, scene)).collect(),
                Vec::new(),
            );
        }
        let mut scenes: Vec<ReportScene> = Vec::new();
        let mut read = self.scenes.clone();
        for path in &self.scenes {
            let stem = path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            let taken = |name: &str| scenes.iter().any(|scene| scene.name == name);
            let name = (1..)
                .map(|count| if count == 1 { stem.clone() } else { format!("{stem}-{count}") })
                .find(|name| !taken(name))
                .unwrap_or(stem.clone());
            scenes.push(from_file(name, path, self.trust, &mut read));
        }
        (scenes, read)
    }
}

fn of_the_project(name: &str, shows: &str, scene: Scene) -> ReportScene {
    let camera = scene.snapshot().map_err(|error| error.to_string()).and_then(|snapshot| {
        snapshot.cameras.into_iter().next().ok_or_else(|| "it has no camera".to_owned())
    });
    ReportScene { name: name.into(), shows: shows.into(), scene: camera.map(|camera| (scene, camera)) }
}

/// A scene as `render` would show it. One that cannot be loaded is part of the report, with the reason.
fn from_file(name: String, path: &Path, trust: TrustArgs, read: &mut Vec<PathBuf>) -> ReportScene {
    let args = SceneArgs::plain(path.into(), trust);
    let scene = args.prepare().map_err(|failure| failure.to_string());
    let scene = scene.map(|(scene, camera, files)| {
        read.extend(files);
        (scene, camera)
    });
    ReportScene { name, shows: path.display().to_string(), scene }
}

pub(crate) fn run(args: &ReportArgs) -> Result<(), Failure> {
    if args.papers {
        return super::papers::run(args);
    }
    let effort = args.effort();
    let (scenes, read) = args.scenes();
    // Where the results go is checked before any time is spent on them.
    let index = args.output.join("index.html");
    let mut outputs = Outputs::beside(&read);
    outputs.make_folder(&args.output)?;
    outputs.reserve(&index)?;
    args.plot.iter().try_for_each(|plot| outputs.reserve(plot))?;

    // The reference is the other end of the axis, not one of the techniques.
    let renderer = open_with(args.adapter.as_deref(), shadowgraph::nodes::catalog())?;
    let mut references = args.references.as_deref().map_or_else(References::in_memory, References::in_folder);
    let start = Instant::now();
    let bar = progress_bar("{bar:30} {pos}/{len} {elapsed:>4}, about {eta} left: {wide_msg}");
    let report = report::run(
        renderer.gpu(),
        renderer.catalog(),
        &scenes,
        &effort,
        &mut references,
        &|done, all, what| {
            bar.set_length(all as u64);
            bar.set_position(done as u64);
            bar.set_message(what.to_owned());
        },
    );
    bar.finish_and_clear();
    references.warning().iter().for_each(|warning| note!("warning: {warning}"));

    for (path, bytes) in report::files(&report) {
        stage(&mut outputs, &args.output, &index, (path, bytes))?;
    }
    if let Some(path) = &args.plot {
        let plot = report::main_plot(&report)
            .ok_or_else(|| Failure::Other(format!("nothing was measured to plot in '{}'", path.display())))?;
        outputs.stage_bytes(path, plot.as_bytes())?;
    }
    outputs.commit()?;
    note!("measured in {:.0} s", start.elapsed().as_secs_f64());
    out!("{}", index.display());
    failed(&report.failures())
}

/// A file of the report, with the folder it lies in.
pub(super) fn stage(
    outputs: &mut Outputs,
    folder: &Path,
    index: &Path,
    (path, bytes): ReportFile,
) -> Result<(), Failure> {
    let path = folder.join(path);
    if path != index {
        path.parent().map_or(Ok(()), |folder| outputs.make_folder(folder))?;
        outputs.reserve(&path)?;
    }
    outputs.stage_bytes(&path, &bytes)
}

/// On stderr, and only where somebody looks.
pub(super) fn progress_bar(template: &str) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar.enable_steady_tick(std::time::Duration::from_millis(500));
    bar
}

/// The report is complete whatever failed; the exit code says that something did.
pub(super) fn failed(failures: &[String]) -> Result<(), Failure> {
    match failures {
        [] => Ok(()),
        [only] => Err(Failure::Other(format!("the report is written, but {only}"))),
        [first, rest @ ..] => Err(Failure::Other(format!(
            "the report is written, but {} things failed: {first}; and {} more, listed at its end",
            failures.len(),
            rest.len()
        ))),
    }
}
