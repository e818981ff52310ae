//! Timing frames: warm-up, medians, spread.

use std::time::Instant;

use shadowgraph::prelude::*;

use super::Failure;

/// Median, minimum and maximum of some times, in milliseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spread {
    pub(crate) median_ms: f64,
    pub(crate) min_ms: f64,
    pub(crate) max_ms: f64,
}

impl Spread {
    /// Of any number of times; all zero of none.
    pub(crate) fn of(mut times_ms: Vec<f64>) -> Self {
        times_ms.sort_by(f64::total_cmp);
        let at = |index: usize| times_ms.get(index).copied().unwrap_or_default();
        let count = times_ms.len();
        let median_ms = if count % 2 == 1 {
            at(count / 2)
        } else {
            (at((count / 2).wrapping_sub(1)) + at(count / 2)) / 2.0
        };
        Self { median_ms, min_ms: at(0), max_ms: at(count.wrapping_sub(1)) }
    }
}

/// What timing a scene gave.
#[derive(Clone, Debug)]
pub(crate) struct Timed {
    /// Whole frames on the wall clock: planning, encoding, executing, waiting.
    pub(crate) wall: Spread,
    /// Whole frames on the GPU's clock, passes apart; `None` without timestamps.
    pub(crate) gpu: Option<Spread>,
    /// The median GPU time of every pass, in the plan's order; `None` without timestamps.
    pub(crate) pass_ms: Vec<Option<f64>>,
}

/// Frames rendered before any is counted.
const WARM_UP_FRAMES: usize = 3;

/// Times `frames` frames of an unmoved scene, and then as many with every pass apart.
pub(crate) fn time_frames(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    frames: usize,
) -> Result<Timed, Failure> {
    let mut options = RenderOptions::default();
    let mut wall_ms = Vec::with_capacity(frames);
    for frame in 0..frames + WARM_UP_FRAMES {
        let start = Instant::now();
        renderer.render(scene, request, &options)?;
        if frame >= WARM_UP_FRAMES {
            wall_ms.push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    options.timing = Timing::Passes;
    let (mut gpu_ms, mut pass_ms): (Vec<f64>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
    let mut passes = 0;
    for frame in 0..frames + 1 {
        let rendered = renderer.render(scene, request, &options)?;
        passes = rendered.plan.passes.len();
        if frame > 0 {
            gpu_ms.extend(rendered.gpu_ms);
            pass_ms.resize(rendered.times.len(), Vec::new());
            rendered.times.iter().zip(&mut pass_ms).for_each(|(time, all)| all.push(time.gpu_ms));
        }
    }
    let gpu = (!gpu_ms.is_empty()).then(|| Spread::of(gpu_ms));
    let mut pass_ms: Vec<_> = pass_ms.into_iter().map(|times| Some(Spread::of(times).median_ms)).collect();
    pass_ms.resize(passes, None);
    Ok(Timed { wall: Spread::of(wall_ms), gpu, pass_ms })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_even_and_no_times() {
        assert_eq!(Spread::of(vec![3.0, 1.0, 2.0]), Spread { median_ms: 2.0, min_ms: 1.0, max_ms: 3.0 });
        assert_eq!(Spread::of(vec![4.0, 1.0]).median_ms, 2.5);
        assert_eq!(Spread::of(vec![]), Spread::default());
    }
}
