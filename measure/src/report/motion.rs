//! What it costs that something moves: the frame, and how long the CPU plans it and hands it over.

use std::time::Instant;

use shadowgraph_engine::render::{FrameRequest, RenderError, Renderer};
use shadowgraph_engine::scene::{CameraSnapshot, Scene};
use shadowgraph_engine::shadow::{Setting, TechniqueEntry};

use super::axes;
use super::data::{MotionReport, Outcome, label};
use super::run::{Bench, Steps, unmeasured};
use super::scene::with_technique;
use crate::compare::motion::{Motion, Moving};
use crate::compare::timing::{FrameTimes, Rounds, WARM_UP_FRAMES};

/// A scene that is seen in every motion.
struct MotionScene {
    name: &'static str,
    shows: &'static str,
    build: fn() -> (Scene, CameraSnapshot),
}

const SCENES: [MotionScene; 2] = [
    MotionScene {
        name: "knot",
        shows: "one closed knot of 13 000 triangles over a floor, one lamp",
        build: || axes::seen(axes::triangles(13_000)),
    },
    MotionScene {
        name: "boxes",
        shows: "256 instances of one small box over a floor, one lamp",
        build: || axes::seen(axes::casters(256)),
    },
];

/// How many steps [`measure`] takes.
pub(super) const STEPS: usize = SCENES.len() * Motion::OF_ANY_SCENE.len();

/// A scene with one setting, in motion.
struct Runner {
    renderer: Renderer,
    moving: Moving,
    rounds: Rounds,
}

pub(super) fn measure(
    bench: &Bench<'_>,
    settings: &[(TechniqueEntry, Setting)],
    steps: &mut Steps<'_>,
) -> Vec<MotionReport> {
    let mut reports = Vec::new();
    for scene in &SCENES {
        for motion in Motion::OF_ANY_SCENE {
            steps.next(&format!("cost of motion: {}, moving {}", scene.name, motion.name()));
            reports.push(measure_one(bench, scene, motion, settings));
        }
    }
    reports
}

fn measure_one(
    bench: &Bench<'_>,
    scene: &MotionScene,
    motion: Motion,
    settings: &[(TechniqueEntry, Setting)],
) -> MotionReport {
    let (given, camera) = (scene.build)();
    let request = FrameRequest::new(camera, bench.effort.axis_size_px);
    let runner = |scene: Scene| -> Result<Runner, RenderError> {
        let mut renderer = bench.renderer();
        renderer.plan(&scene, &request)?;
        let moving = Moving::new(scene, request.clone(), motion)?;
        Ok(Runner { renderer, moving, rounds: Rounds::default() })
    };
    let scenes = settings.iter().map(|(entry, setting)| with_technique(&given, entry, setting));
    let runners = std::iter::once(given.without_shadows()).chain(scenes).map(runner);
    let (mut accepted, mut outcomes) = (Vec::new(), Vec::new());
    for runner in runners {
        outcomes.push(match runner {
            Ok(runner) => {
                accepted.push(runner);
                None
            }
            Err(error) => Some(unmeasured(&error)),
        });
    }
    let failure = take_turns(bench, &mut accepted).err().map(|error| error.to_string());
    let mut times = accepted.iter().map(|runner| runner.rounds.times());
    let mut outcomes = outcomes.into_iter().map(|refused| match (&failure, refused) {
        (_, Some(refused)) => refused,
        (Some(why), None) => Outcome::Failed(why.clone()),
        (None, None) => Outcome::Measured(times.next().unwrap_or_default()),
    });
    let unshadowed: Option<Outcome<FrameTimes>> = outcomes.next();
    let labels = settings.iter().map(|(entry, setting)| label(entry.short_name, setting.name));
    MotionReport {
        scene: scene.name,
        shows: scene.shows,
        moves: motion.name(),
        unshadowed: unshadowed.and_then(|outcome| outcome.measured().copied()),
        techniques: labels.zip(outcomes).collect(),
    }
}

/// Renders frame after frame of all runners in turn, each as far along its way as the others.
fn take_turns(bench: &Bench<'_>, runners: &mut [Runner]) -> Result<(), RenderError> {
    let pace = &bench.effort.axis_pace;
    let start = Instant::now();
    for number in 0..pace.max_rounds + WARM_UP_FRAMES {
        let counted = number.saturating_sub(WARM_UP_FRAMES);
        if counted >= pace.min_rounds && start.elapsed() >= pace.budget {
            break;
        }
        for Runner { renderer, moving, rounds } in runners.iter_mut() {
            rounds.render(renderer, moving, number, number >= WARM_UP_FRAMES)?;
        }
    }
    Ok(())
}
