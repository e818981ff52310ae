//! What the chapter's parts share: pictures, errors, and rounds in which every row draws one frame.

use std::time::Duration;

use glam::DVec3;
use image::codecs::png::PngEncoder;
use image::{ImageEncoder, ImageError, RgbaImage, imageops};
use shadowgraph_engine::gpu::Gpu;
use shadowgraph_engine::render::{Exposure, Frame, FrameRequest, RenderError, RenderOptions, Renderer};
use shadowgraph_engine::scene::{CameraSnapshot, Scene, SceneError, ShadowNode};
use shadowgraph_measure::pictures::PictureError;
use shadowgraph_measure::report::Picture;
use shadowgraph_measure::timing::{Pace, Runner, Spread, take_turns};
use shadowgraph_measure::{
    CompareError, EvaluateError, Evaluation, KnownReferences, LightError, evaluate_again, evaluate_converged,
};
use thiserror::Error;

use super::models::ModelError;

/// Why an entry could not be made.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "each is explained where it is defined")]
pub enum PaperError {
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Model(#[from] ModelError),
    #[error(transparent)]
    Map(#[from] PictureError),
    #[error("a picture cannot be encoded: {0}")]
    Encode(#[from] ImageError),
    #[error("{0} is missing")]
    Missing(&'static str),
}

pub(super) type Made<T> = Result<T, PaperError>;

/// How much is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Its name.
    pub name: &'static str,
    /// The size of frames that are timed.
    pub size_px: [u32; 2],
    /// The size of pictures, and of frames that are judged.
    pub picture_px: [u32; 2],
    /// How many pixels each way are averaged into one of a picture.
    pub oversampling: u32,
    /// The size of frames that are judged beside whole lights with a size.
    pub soft_px: [u32; 2],
    /// The samples that stand for such a light.
    pub light_samples: u32,
    /// How long a table's rows are timed in turn.
    pub pace: Pace,
    /// Whether only the first and the last of every list of sizes and models are tried.
    pub ends_only: bool,
}

impl Effort {
    /// About ten minutes on two cores with the software driver.
    pub const DEFAULT: Self = Self {
        name: "default",
        size_px: [1280, 720],
        picture_px: [640, 360],
        oversampling: 2,
        soft_px: [192, 108],
        light_samples: 1024,
        pace: Pace { min_rounds: 5, max_rounds: 41, budget: Duration::from_secs(10) },
        ends_only: false,
    };
    /// Under a minute.
    pub const QUICK: Self = Self {
        name: "quick",
        size_px: [192, 108],
        picture_px: [192, 108],
        oversampling: 1,
        soft_px: [64, 36],
        light_samples: 256,
        pace: Pace { min_rounds: 3, max_rounds: 5, budget: Duration::from_millis(300) },
        ends_only: true,
    };

    /// The same with timed frames of another size. Pictures have its shape, and at most as many pixels as they had.
    #[must_use]
    pub fn sized(self, size_px: [u32; 2]) -> Self {
        let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
        let at_most = |own_px: [u32; 2]| {
            let scale = (pixels(own_px) / pixels(size_px)).sqrt().min(1.0);
            size_px.map(|side| ((f64::from(side) * scale).round() as u32).max(1))
        };
        Self { size_px, picture_px: at_most(self.picture_px), soft_px: at_most(self.soft_px), ..self }
    }

    /// The elements of `all` that this effort tries.
    pub(super) fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        match all {
            [first, .., last] if self.ends_only => vec![first.clone(), last.clone()],
            _ => all.to_vec(),
        }
    }
}

/// What everything is measured with.
pub(super) struct Bench<'a> {
    pub(super) effort: &'a Effort,
    /// For pictures and errors; whatever is timed has a renderer of its own.
    pub(super) renderer: Renderer,
    gpu: &'a Gpu,
    tell: &'a dyn Fn(&str),
}

impl<'a> Bench<'a> {
    pub(super) fn new(gpu: &'a Gpu, effort: &'a Effort, tell: &'a dyn Fn(&str)) -> Self {
        Self { effort, renderer: Renderer::new(gpu.clone(), super::catalog()), gpu, tell }
    }

    /// Says what comes next.
    pub(super) fn tell(&self, what: &str) {
        (self.tell)(what);
    }

    /// A renderer for what is timed.
    pub(super) fn another_renderer(&self) -> Renderer {
        Renderer::new(self.gpu.clone(), super::catalog())
    }

    /// Times one frame of every scene in turn, round after round, at the timed size.
    pub(super) fn rounds(&self, scenes: &[Scene]) -> Made<Rounds> {
        self.rounds_at(scenes, self.effort.size_px)
    }

    /// The same at another size.
    pub(super) fn rounds_at(&self, scenes: &[Scene], size_px: [u32; 2]) -> Made<Rounds> {
        let mut runners = Vec::new();
        for scene in scenes {
            let request = FrameRequest::new(camera(scene)?, size_px);
            runners.push(Runner { renderer: self.another_renderer(), scene: scene.clone(), request });
        }
        Ok(Rounds { times_ms: take_turns(&mut runners, &self.effort.pace)? })
    }

    /// Renders the scene at the judged size and compares its factors; the request is the scene's first camera's.
    pub(super) fn judge(&mut self, scene: &Scene, references: &mut KnownReferences) -> Made<Evaluation> {
        let request = FrameRequest::new(camera(scene)?, self.effort.picture_px);
        Ok(evaluate_again(&mut self.renderer, scene, &request, references, &|_, _| {})?)
    }

    /// As [`Bench::judge`], beside the whole of lights with a size, all lights together.
    pub(super) fn judge_soft(&mut self, scene: &Scene, references: &mut KnownReferences) -> Made<Soft> {
        let request = FrameRequest::new(camera(scene)?, self.effort.soft_px);
        let renderer = &mut self.renderer;
        let evaluation = evaluate_again(renderer, scene, &request, references, &|_, _| {})?;
        let off_its_samples = evaluation.errors.iter().filter(|error| error.same_samples.is_some());
        let off_its_samples = off_its_samples.map(|error| error.outside_bounds).sum();
        let whole = evaluate_converged(renderer, scene, &request, &evaluation, references, &|_, _| {})?;
        let errors: &[LightError] = whole.as_ref().map_or(&evaluation.errors, |whole| &whole.errors);
        let (mut squares, mut penumbra_px) = (0.0, 0);
        for error in errors {
            squares += error.penumbra_rmse.powi(2) * error.penumbra_pixels as f64;
            penumbra_px += error.penumbra_pixels;
        }
        let penumbra_rmse = (squares / penumbra_px.max(1) as f64).sqrt();
        Ok(Soft { penumbra_rmse, penumbra_px, off_its_samples })
    }

    /// A frame from the scene's first camera at the judged size, with an exposure of 1 and whatever `ask` asks for.
    pub(super) fn frame(&mut self, scene: &Scene, ask: impl FnOnce(&mut FrameRequest)) -> Made<Frame> {
        self.drawn(scene, self.effort.picture_px, Exposure::Fixed(1.0), ask)
    }

    fn drawn(
        &mut self,
        scene: &Scene,
        size_px: [u32; 2],
        exposure: Exposure,
        ask: impl FnOnce(&mut FrameRequest),
    ) -> Made<Frame> {
        let mut request = FrameRequest::new(camera(scene)?, size_px);
        ask(&mut request);
        let options = RenderOptions { exposure, read_picture: true, ..RenderOptions::default() };
        Ok(self.renderer.render(scene, &request, &options)?)
    }

    /// The scene from its first camera, averaged from more pixels where the effort says so.
    pub(super) fn picture(
        &mut self,
        scene: &Scene,
        exposure: Exposure,
        named: (&str, impl Into<String>),
    ) -> Made<Picture> {
        self.averaged(scene, exposure, named, self.effort.oversampling)
    }

    /// The same from as many pixels as it has.
    pub(super) fn plain_picture(
        &mut self,
        scene: &Scene,
        exposure: Exposure,
        named: (&str, impl Into<String>),
    ) -> Made<Picture> {
        self.averaged(scene, exposure, named, 1)
    }

    fn averaged(
        &mut self,
        scene: &Scene,
        exposure: Exposure,
        (name, caption): (&str, impl Into<String>),
        oversampling: u32,
    ) -> Made<Picture> {
        let size_px = self.effort.picture_px.map(|side| side * oversampling);
        let frame = self.drawn(scene, size_px, exposure, |_| {})?;
        let pixels = frame.picture.ok_or(PaperError::Missing("a frame's picture"))?;
        let large = RgbaImage::from_raw(size_px[0], size_px[1], pixels.bytes)
            .ok_or(PaperError::Missing("a part of a frame's picture"))?;
        let [width, height] = self.effort.picture_px;
        let image = imageops::resize(&large, width, height, imageops::FilterType::Triangle);
        picture(name, caption, &image)
    }
}

/// What came of a comparison with the whole of lights with a size.
#[derive(Clone, Copy, Debug)]
pub(super) struct Soft {
    /// Root of the mean squared difference where the light is seen in part.
    pub(super) penumbra_rmse: f64,
    pub(super) penumbra_px: usize,
    /// Pixels that are not what the samples that the technique takes give.
    pub(super) off_its_samples: usize,
}

/// An image as a picture of the chapter.
pub(super) fn picture(name: &str, caption: impl Into<String>, image: &RgbaImage) -> Made<Picture> {
    let mut png = Vec::new();
    let (width, height) = image.dimensions();
    PngEncoder::new(&mut png).write_image(image.as_raw(), width, height, image::ExtendedColorType::Rgba8)?;
    Ok(Picture { name: name.into(), caption: caption.into(), png })
}

/// The scene's first camera.
pub(super) fn camera(scene: &Scene) -> Made<CameraSnapshot> {
    scene.snapshot()?.cameras.into_iter().next().ok_or(PaperError::Missing("a camera"))
}

/// The scene with a shadow node over everything.
pub(super) fn shadowed(scene: &Scene, node: impl Into<ShadowNode>) -> Scene {
    let mut scene = scene.clone();
    scene.add_shadow("shadows", node);
    scene
}

/// The pixel that shows the point, by its number; `None` outside the picture.
pub(super) fn pixel_of(camera: &CameraSnapshot, size_px: [u32; 2], p_in_world: DVec3) -> Option<usize> {
    let [width, height] = size_px.map(f64::from);
    let clip = camera.clip_from_world(size_px) * p_in_world.extend(1.0);
    let [x, y] = [(clip.x / clip.w + 1.0) * 0.5 * width, (1.0 - clip.y / clip.w) * 0.5 * height];
    let inside = clip.w > 0.0 && (0.0..width).contains(&x) && (0.0..height).contains(&y);
    inside.then_some(y as usize * size_px[0] as usize + x as usize)
}

/// Times of several rows; the elements of one number are of one round.
pub(super) struct Rounds {
    times_ms: Vec<Vec<f64>>,
}

impl Rounds {
    /// A row's frames, in milliseconds.
    pub(super) fn ms(&self, row: usize) -> Spread {
        Spread::of(self.times_ms[row].clone())
    }

    /// A row's frame as a multiple of another's in the same round.
    pub(super) fn ratio(&self, row: usize, to: usize) -> Spread {
        self.pairs(row, to, |own, other| own / other)
    }

    /// What a row's frame takes more than another's in the same round, in milliseconds.
    pub(super) fn adds(&self, row: usize, to: usize) -> Spread {
        self.pairs(row, to, |own, other| own - other)
    }

    fn pairs(&self, row: usize, to: usize, of: fn(f64, f64) -> f64) -> Spread {
        Spread::of(self.times_ms[row].iter().zip(&self.times_ms[to]).map(|(a, b)| of(*a, *b)).collect())
    }

    /// How many rounds there were.
    pub(super) fn count(&self) -> usize {
        self.times_ms.first().map_or(0, Vec::len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_have_the_shape_of_frames_and_no_more_pixels_than_they_had() {
        let small = Effort::QUICK.sized([96, 54]);
        assert_eq!((small.size_px, small.picture_px, small.soft_px), ([96, 54], [96, 54], [64, 36]));
        let square = Effort::DEFAULT.sized([400, 400]);
        assert_eq!((square.picture_px, square.soft_px), ([400, 400], [144, 144]));
    }

    #[test]
    fn rounds_are_compared_within_themselves() {
        let rounds = Rounds { times_ms: vec![vec![1.0, 2.0, 10.0], vec![2.0, 4.0, 20.0]] };
        assert_eq!((rounds.ratio(1, 0).median, rounds.ratio(1, 0).max, rounds.count()), (2.0, 2.0, 3));
        assert_eq!(rounds.adds(1, 0).max, 10.0);
    }
}
