//! Timing frames: warm-up, medians, spread; several scenes in turn, so that what slows the machine slows all alike.

use std::time::{Duration, Instant};

use shadowgraph_engine::gpu::Timing;
use shadowgraph_engine::render::{FrameRequest, RenderError, RenderOptions, Renderer};
use shadowgraph_engine::scene::Scene;

use super::motion::{Motion, Moving};

/// Median, quartiles, minimum and maximum of some values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Half of the values are not above it.
    pub median: f64,
    /// A quarter of the values are not above it.
    pub lower: f64,
    /// Three quarters of the values are not above it.
    pub upper: f64,
    /// The smallest.
    pub min: f64,
    /// The largest.
    pub max: f64,
}

impl Spread {
    /// Of any number of values; all zero of none.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let Some(last) = values.len().checked_sub(1) else { return Self::default() };
        // Between two values the quantile is interpolated.
        let at = |share: f64| {
            let place = share * last as f64;
            let below = place.floor() as usize;
            let above = (below + 1).min(last);
            values[below] + (values[above] - values[below]) * place.fract()
        };
        Self { median: at(0.5), lower: at(0.25), upper: at(0.75), min: values[0], max: values[last] }
    }
}

/// What timing a scene gave.
#[derive(Clone, Debug)]
pub struct Timed {
    /// Whole frames.
    pub frames: FrameTimes,
    /// What the passes took.
    pub passes: PassTimes,
}

/// Whole frames, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// On the wall clock: planning, encoding, executing, waiting.
    pub wall_ms: Spread,
    /// Of it on the CPU: posing, collecting, planning.
    pub plan_ms: Spread,
    /// And then until the GPU had all its commands.
    pub encode_ms: Spread,
}

/// Times on the GPU's clock, in milliseconds.
#[derive(Clone, Debug, Default)]
pub struct PassTimes {
    /// Whole frames, passes apart; `None` without timestamps.
    pub frame_ms: Option<Spread>,
    /// Every pass, in the plan's order; `None` without timestamps, 0 while what it draws is kept.
    pub pass_ms: Vec<Option<Spread>>,
}

/// Rounds that are counted even of what is slow.
const SLOW_ROUNDS: usize = 3;

/// Frames rendered before any is counted.
pub(crate) const WARM_UP_FRAMES: usize = 3;

/// Times `frames` frames, and then as many with every pass apart.
///
/// # Errors
/// As [`Renderer::render`].
pub fn time_frames(
    renderer: &mut Renderer,
    moving: &mut Moving,
    frames: usize,
) -> Result<Timed, RenderError> {
    let mut rounds = Rounds::default();
    for frame in 0..frames + WARM_UP_FRAMES {
        rounds.render(renderer, moving, frame, frame >= WARM_UP_FRAMES)?;
    }
    let passes = time_moving_passes(renderer, moving, frames, Duration::MAX)?;
    Ok(Timed { frames: rounds.times(), passes })
}

/// The times of frames so far.
#[derive(Clone, Debug, Default)]
pub struct Rounds {
    wall_ms: Vec<f64>,
    plan_ms: Vec<f64>,
    encode_ms: Vec<f64>,
}

impl Rounds {
    /// Renders frame `number` of what moves, and remembers its times if it `counts`. Moving it is not timed.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render(
        &mut self,
        renderer: &mut Renderer,
        moving: &mut Moving,
        number: usize,
        counts: bool,
    ) -> Result<(), RenderError> {
        moving.show(number)?;
        let start = Instant::now();
        let frame = renderer.render(&moving.scene, &moving.request, &RenderOptions::default())?;
        if counts {
            self.wall_ms.push(milliseconds(start.elapsed()));
            self.plan_ms.push(frame.plan_ms);
            self.encode_ms.push(frame.encode_ms);
        }
        Ok(())
    }

    /// Their medians and spreads.
    pub fn times(&self) -> FrameTimes {
        let [wall_ms, plan_ms, encode_ms] =
            [&self.wall_ms, &self.plan_ms, &self.encode_ms].map(|times_ms| Spread::of(times_ms.clone()));
        FrameTimes { wall_ms, plan_ms, encode_ms }
    }
}

/// Times `frames` frames of an unmoved scene with every pass apart, after one that is not counted; fewer when these take longer
/// than `budget`, but one.
///
/// # Errors
/// As [`Renderer::render`].
pub fn time_passes(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    frames: usize,
    budget: Duration,
) -> Result<PassTimes, RenderError> {
    let mut moving = Moving::new(scene.clone(), request.clone(), Motion::Still)?;
    time_moving_passes(renderer, &mut moving, frames, budget)
}

fn time_moving_passes(
    renderer: &mut Renderer,
    moving: &mut Moving,
    frames: usize,
    budget: Duration,
) -> Result<PassTimes, RenderError> {
    let start = Instant::now();
    let options = RenderOptions { timing: Timing::Passes, ..RenderOptions::default() };
    let (mut gpu_ms, mut pass_ms): (Vec<f64>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    for frame in 0..frames + 1 {
        if frame > 1 && start.elapsed() >= budget {
            break;
        }
        moving.show(frame)?;
        let rendered = renderer.render(&moving.scene, &moving.request, &options)?;
        let passes = rendered.plan.passes.len();
        if frame == 0 {
            pass_ms.resize(passes, Vec::new());
        } else if rendered.gpu_ms.is_some() {
            gpu_ms.extend(rendered.gpu_ms);
            // Of something that moves, another frame may have other passes: they are not those of the first.
            if passes != pass_ms.len() {
                continue;
            }
            // What did not run, since what it draws was kept, took no time.
            for (index, all) in pass_ms.iter_mut().enumerate() {
                let time = rendered.times.iter().find(|time| time.passes.contains(&index));
                all.push(time.map_or(0.0, |time| time.gpu_ms));
            }
        }
    }
    let frame_ms = (!gpu_ms.is_empty()).then(|| Spread::of(gpu_ms));
    let spread = |times: Vec<f64>| (!times.is_empty()).then(|| Spread::of(times));
    let pass_ms = pass_ms.into_iter().map(spread).collect();
    Ok(PassTimes { frame_ms, pass_ms })
}

/// How long scenes are timed in turn: until both the rounds and the time are enough, or the rounds are more than that. What
/// has taken a quarter of the time by itself, and three rounds, is counted no more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    /// Rounds that are counted at least.
    pub min_rounds: usize,
    /// Rounds that are counted at most.
    pub max_rounds: usize,
    /// No round begins after this once there are enough.
    pub budget: Duration,
}

impl Pace {
    /// As long as one scene of several is timed, once it has been timed often enough.
    pub fn budget_of_one(&self) -> Duration {
        self.budget / 4
    }
}

/// One of several scenes that are timed in turn. Each has a renderer of its own, so that nothing kept for one is
/// dropped for another.
#[derive(Debug)]
pub struct Runner {
    /// What renders it.
    pub renderer: Renderer,
    /// What is rendered.
    pub scene: Scene,
    /// From where, and how large.
    pub request: FrameRequest,
}

impl Runner {
    fn frame_ms(&mut self) -> Result<f64, RenderError> {
        let start = Instant::now();
        self.renderer.render(&self.scene, &self.request, &RenderOptions::default())?;
        Ok(milliseconds(start.elapsed()))
    }
}

/// Renders one frame of every runner, round after round, and returns each runner's times in milliseconds: element `i`
/// of each belongs to the same round; slow ones have fewer. Every second round goes backwards, so that none always follows the same other.
///
/// # Errors
/// As [`Renderer::render`].
pub fn take_turns(runners: &mut [Runner], pace: &Pace) -> Result<Vec<Vec<f64>>, RenderError> {
    let mut times_ms = vec![Vec::new(); runners.len()];
    for runner in runners.iter_mut() {
        let start = Instant::now();
        for frame in 0..WARM_UP_FRAMES {
            if frame == 0 || start.elapsed() < pace.budget / 8 {
                runner.frame_ms()?;
            }
        }
    }
    let budget_of_one_ms = milliseconds(pace.budget_of_one());
    let start = Instant::now();
    for round in 0..pace.max_rounds {
        if round >= pace.min_rounds && start.elapsed() >= pace.budget {
            break;
        }
        let mut order: Vec<usize> = (0..runners.len()).collect();
        if round % 2 == 1 {
            order.reverse();
        }
        for index in order {
            let is_slow = times_ms[index].iter().sum::<f64>() >= budget_of_one_ms;
            if is_slow && times_ms[index].len() >= SLOW_ROUNDS {
                continue;
            }
            times_ms[index].push(runners[index].frame_ms()?);
        }
    }
    Ok(times_ms)
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_quartiles_of_odd_even_and_no_values() {
        let five = Spread::of(vec![5.0, 1.0, 3.0, 2.0, 4.0]);
        assert_eq!((five.min, five.lower, five.median, five.upper, five.max), (1.0, 2.0, 3.0, 4.0, 5.0));
        let two = Spread::of(vec![4.0, 1.0]);
        assert_eq!((two.lower, two.median, two.upper), (1.75, 2.5, 3.25));
        assert_eq!(Spread::of(vec![7.0]).upper, 7.0);
        assert_eq!(Spread::of(vec![]), Spread::default());
    }
}
