//! What a report holds, as plain data: the pages are made from nothing else.

use std::collections::BTreeMap;

use shadowgraph_engine::scene::{CameraSnapshot, Params, Scene};

use super::totals::Totals;
use crate::LightError;
use crate::cases::sweeps::Swept;
use crate::compare::timing::{FrameTimes, Spread};

/// A scene to report on.
#[derive(Clone, Debug)]
pub struct ReportScene {
    /// A name no other scene of the report has; also part of file names.
    pub name: String,
    /// What it shows, in one line.
    pub shows: String,
    /// The scene. Its shadow nodes keep their scopes and get each technique in turn; without any, one over everything
    /// is added. Or why it could not be had.
    pub scene: Result<(Scene, CameraSnapshot), String>,
}

/// Everything that was measured.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// The adapter's name.
    pub adapter: String,
    /// How much was measured: `quick`, `default` or `full`.
    pub effort: &'static str,
    /// The size of the scenes' frames.
    pub size_px: [u32; 2],
    /// The processors that could be used.
    pub processors: usize,
    /// Every technique of the catalog: its type name, its short name and what it is.
    pub techniques: Vec<[&'static str; 3]>,
    /// The scenes, in the order they were given.
    pub scenes: Vec<SceneReport>,
    /// Cost against the size of things.
    pub axes: Vec<AxisReport>,
    /// Cost of motion.
    pub motions: Vec<MotionReport>,
    /// Error against parameters.
    pub sweeps: Vec<SweepReport>,
    /// How many times smaller, along each side, the sweeps' frames are than their cases say.
    pub sweep_shrink: u32,
    /// PNG files by their paths below the report's folder.
    pub pictures: BTreeMap<String, Vec<u8>>,
}

impl Report {
    /// What failed, one line each: refusals are answers and not among them.
    pub fn failures(&self) -> Vec<String> {
        let mut failures = Vec::new();
        for scene in &self.scenes {
            failures.extend(scene.failure.iter().map(|why| format!("scene '{}': {why}", scene.name)));
            let failed =
                scene.points.iter().filter_map(|point| Some((point.label(), point.outcome.failure()?)));
            failures.extend(failed.map(|(label, why)| format!("scene '{}', {label}: {why}", scene.name)));
        }
        for axis in &self.axes {
            for (technique, steps) in &axis.techniques {
                let failed = steps.iter().filter_map(|step| Some((step.value, step.outcome.failure()?)));
                failures.extend(
                    failed.map(|(value, why)| format!("{technique} at {value} {}: {why}", axis.parameter)),
                );
            }
        }
        for motion in &self.motions {
            let failed = motion.techniques.iter().filter_map(|(name, of)| Some((name, of.failure()?)));
            failures.extend(
                failed.map(|(name, why)| {
                    format!("{name} on '{}', moving {}: {why}", motion.scene, motion.moves)
                }),
            );
        }
        for sweep in &self.sweeps {
            for (technique, steps) in &sweep.techniques {
                let failed = steps.iter().filter_map(|step| Some((step.value, step.outcome.failure()?)));
                failures
                    .extend(failed.map(|(value, why)| format!("{technique} at {} {value}: {why}", sweep.id)));
            }
        }
        failures
    }
}

/// One scene's part.
#[derive(Clone, Debug, Default)]
pub struct SceneReport {
    /// Its name.
    pub name: String,
    /// What it shows.
    pub shows: String,
    /// Triangles of all meshes.
    pub triangles: usize,
    /// Lights.
    pub lights: usize,
    /// Rounds of frames that were timed.
    pub rounds: usize,
    /// Frames without shadows, on the wall clock.
    pub unshadowed_ms: Spread,
    /// How long the reference was traced on the CPU; 0 when none was needed.
    pub reference_ms: f64,
    /// What no shadows at all get wrong.
    pub none: Option<Totals>,
    /// Every technique and setting.
    pub points: Vec<Point>,
    /// Why nothing of it could be measured.
    pub failure: Option<String>,
}

/// One technique with one quality setting on one scene.
#[derive(Clone, Debug)]
pub struct Point {
    /// The technique's type name.
    pub technique: &'static str,
    /// Its short name.
    pub short_name: &'static str,
    /// The setting's name.
    pub setting: &'static str,
    /// What the setting is tried for.
    pub why: &'static str,
    /// The setting's options.
    pub params: Params,
    /// The error that the technique has by design.
    pub known_error: &'static str,
    /// What came of it.
    pub outcome: Outcome<Box<Measurement>>,
}

impl Point {
    /// `hard`, `hard z-fail`: the short name, and the setting unless it is the default.
    pub fn label(&self) -> String {
        label(self.short_name, self.setting)
    }

    /// What was measured, if it was.
    pub fn measurement(&self) -> Option<&Measurement> {
        self.outcome.measured().map(Box::as_ref)
    }
}

/// A technique's name with a setting's, unless that is the default.
pub(super) fn label(short_name: &str, setting: &str) -> String {
    if setting == "default" { short_name.into() } else { format!("{short_name} {setting}") }
}

/// What came of a technique on a scene, or at one step.
#[derive(Clone, Debug)]
pub enum Outcome<T> {
    /// It was measured.
    Measured(T),
    /// The technique refused it: a typed error, told as it was.
    Refused(String),
    /// Something went wrong.
    Failed(String),
}

impl<T> Outcome<T> {
    /// What was measured, if it was.
    pub fn measured(&self) -> Option<&T> {
        match self {
            Self::Measured(measured) => Some(measured),
            _ => None,
        }
    }

    /// Why the technique refused, if it did.
    pub fn refusal(&self) -> Option<&str> {
        match self {
            Self::Refused(why) => Some(why),
            _ => None,
        }
    }

    /// Why it failed, if it did; a refusal is an answer and no failure.
    pub fn failure(&self) -> Option<&str> {
        match self {
            Self::Failed(why) => Some(why),
            _ => None,
        }
    }
}

/// What was measured.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Frames on the wall clock.
    pub shadowed_ms: Spread,
    /// Each round's frame divided by that without shadows.
    pub ratio: Spread,
    /// How many rounds were counted: fewer where it is slow.
    pub rounds: usize,
    /// Frames on the GPU's clock, passes apart.
    pub gpu_ms: Option<Spread>,
    /// The plan's passes.
    pub passes: Vec<PassReport>,
    /// Bytes on the GPU.
    pub gpu_bytes: u64,
    /// Bytes of the plan's own slots.
    pub plan_bytes: u64,
    /// The size of the frame that was judged: smaller than that which was timed where lights have a size.
    pub judged_size_px: [u32; 2],
    /// All lights together, beside the whole light where it has a size.
    pub totals: Totals,
    /// Where a technique takes samples of a light: how many, and the pixels whose factor is not what exactly these samples give.
    pub same_samples: Option<(u32, usize)>,
    /// Each light's techniques and errors.
    pub lights: Vec<(String, LightError)>,
    /// The plan as text.
    pub plan: String,
    /// The picture's path.
    pub picture: String,
    /// The light with most errors, and the paths of its error map and of the reference's factor.
    pub worst: Option<[String; 3]>,
}

/// One pass of a plan.
#[derive(Clone, Debug)]
pub struct PassReport {
    /// Its name.
    pub name: String,
    /// Why it is there.
    pub reason: String,
    /// Its draws.
    pub draws: usize,
    /// Their vertices.
    pub vertices: u64,
    /// Its time; `None` without timestamps.
    pub gpu_ms: Option<Spread>,
}

/// Cost against the size of one thing.
#[derive(Clone, Debug)]
pub struct AxisReport {
    /// What grows: `triangles`, say.
    pub parameter: &'static str,
    /// What the scenes show.
    pub shows: &'static str,
    /// Frames without shadows, on the wall clock, at each step.
    pub unshadowed_ms: Vec<(f64, Spread)>,
    /// For each technique and setting its steps.
    pub techniques: Vec<(String, Vec<AxisStep>)>,
}

/// One size.
#[derive(Clone, Debug)]
pub struct AxisStep {
    /// How much of it there is.
    pub value: f64,
    /// Each round's frame minus that without shadows, in milliseconds.
    pub outcome: Outcome<Spread>,
}

/// Frames of one scene in one motion.
#[derive(Clone, Debug)]
pub struct MotionReport {
    /// The scene's name.
    pub scene: &'static str,
    /// What it shows.
    pub shows: &'static str,
    /// What moves from frame to frame.
    pub moves: &'static str,
    /// Frames without shadows; `None` where they could not be rendered.
    pub unshadowed: Option<FrameTimes>,
    /// For each technique and setting its frames.
    pub techniques: Vec<(String, Outcome<FrameTimes>)>,
}

/// Error against a parameter.
#[derive(Clone, Debug)]
pub struct SweepReport {
    /// The sweep's name.
    pub id: &'static str,
    /// What is swept.
    pub parameter: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Whether its values are plotted by their logarithm.
    pub is_log: bool,
    /// What breaks.
    pub what_breaks: &'static str,
    /// Where f32 must lose, and why.
    pub f32_loses: &'static str,
    /// The option of techniques that is swept, where it is one.
    pub option: Option<Swept>,
    /// The short name of the technique whose settings are compared, where one is.
    pub compares: Option<&'static str>,
    /// For each technique and setting its steps.
    pub techniques: Vec<(String, Vec<SweepStep>)>,
}

/// One value of a sweep's parameter.
#[derive(Clone, Debug)]
pub struct SweepStep {
    /// The value.
    pub value: f64,
    /// The error of all lights together.
    pub outcome: Outcome<Totals>,
}
