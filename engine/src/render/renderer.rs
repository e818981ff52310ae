//! One object that renders scenes: poses, collects, plans and executes, and keeps what does not change.

use std::sync::Arc;
use std::time::Instant;

use thiserror::Error;

use super::Exposure;
use super::planner::Planner;
use super::request::{Adapter, FrameError, FrameRequest, PictureFormat};
use crate::gpu::{Executed, Executor, FrameInputs, Gpu, GpuError, PassTime, Pixels, PixelsError, Timing};
use crate::plan::{FramePlan, SlotId};
use crate::scene::{Scene, SceneError, SceneSnapshot};
use crate::shadow::{Catalog, Registry, ShadowError};

/// Why a frame was not rendered. Nothing is drawn in its place.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "each is explained where it is defined")]
pub enum RenderError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Frame(#[from] FrameError),
    #[error(transparent)]
    Shadow(#[from] ShadowError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error(transparent)]
    Pixels(#[from] PixelsError),
}

/// What is wanted of rendering beside the frame itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderOptions {
    /// How radiance becomes brightness.
    pub exposure: Exposure,
    /// What is timed.
    pub timing: Timing,
    /// Whether the picture is copied to the CPU.
    pub read_picture: bool,
}

/// The factor of one light as a linear image.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorImage {
    /// The light's name.
    pub light: String,
    /// The factor of every pixel, 1 lit and 0 dark, as 32-bit floats: one, or red, green and blue with a fourth that
    /// is unused.
    pub pixels: Pixels,
}

/// The factors on one layer of transparent surfaces, as asked for by [`FrameRequest::layer_factors`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameLayer {
    /// (instance, triangle) of every pixel; `u32::MAX` where there is no such layer.
    pub triangles: Vec<[u32; 2]>,
    /// The factor of every light that a shadow node serves, 1 where the layer receives none.
    pub factors: Vec<FactorImage>,
}

/// A rendered frame.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The plan that was executed.
    pub plan: Arc<FramePlan>,
    /// The picture, if it was read.
    pub picture: Option<Pixels>,
    /// (instance, triangle) of every pixel, if factors were asked for; `u32::MAX` where nothing is.
    pub visible_triangles: Option<Vec<[u32; 2]>>,
    /// The factor of every light that a shadow node serves, if asked for.
    pub factors: Vec<FactorImage>,
    /// The layers of [`FrameRequest::layer_factors`] that the scene has, nearest first.
    pub layers: Vec<FrameLayer>,
    /// The names of the passes that did not run, since what they draw was kept from an earlier frame.
    pub kept: Vec<String>,
    /// GPU times of passes.
    pub times: Vec<PassTime>,
    /// GPU time of the whole frame, in milliseconds.
    pub gpu_ms: Option<f64>,
    /// CPU time of posing, collecting and planning, in milliseconds.
    pub plan_ms: f64,
    /// CPU time from the plan until the GPU had all its commands, in milliseconds.
    pub encode_ms: f64,
    /// Bytes on the GPU: the plan's slots, meshes and textures.
    pub gpu_bytes: u64,
}

/// Renders scenes on one device with one catalog of techniques.
#[derive(Debug)]
pub struct Renderer {
    executor: Executor,
    planner: Planner,
    recoveries: u64,
}

/// Devices that may be lost while one frame is rendered before it is given up.
const RECOVERIES_A_FRAME: u32 = 3;

impl Renderer {
    /// A renderer on `gpu` that knows the techniques of `catalog`.
    pub fn new(gpu: Gpu, catalog: Catalog) -> Self {
        Self { executor: Executor::new(gpu), planner: Planner::new(catalog), recoveries: 0 }
    }

    /// The device it runs on.
    pub fn gpu(&self) -> &Gpu {
        self.executor.gpu()
    }

    /// The techniques it knows.
    pub fn catalog(&self) -> &Catalog {
        self.planner.catalog()
    }

    /// How many cached results were computed and how many buffers uploaded since the renderer was made. Neither
    /// number grows in a frame in which nothing moved.
    pub fn work_done(&self) -> (u64, u64) {
        (self.planner.computed(), self.executor.uploads())
    }

    /// The scene flattened, and its shadow nodes by light; kept until the scene changes.
    ///
    /// # Errors
    /// What is wrong with the scene or its shadow nodes.
    pub fn snapshot(&mut self, scene: &Scene) -> Result<(Arc<SceneSnapshot>, Arc<Registry>), RenderError> {
        self.planner.snapshot(scene)
    }

    /// Plans a frame without executing it.
    ///
    /// # Errors
    /// As [`Renderer::render`], but for the device's own.
    pub fn plan(&mut self, scene: &Scene, request: &FrameRequest) -> Result<Arc<FramePlan>, RenderError> {
        let gpu = self.executor.gpu();
        let name = gpu.name();
        let adapter = Adapter {
            name: &name,
            features: gpu.features,
            max_size_px: gpu.limits.max_texture_dimension_2d,
            multisampled: &gpu.multisampled,
        };
        self.planner.plan(scene, request, &adapter)
    }

    /// Renders one frame and waits for it. A device that is lost, now or since the last frame, is replaced by another,
    /// and everything on it made again.
    ///
    /// # Errors
    /// What is wrong with the scene, its shadow nodes, the request, or the device; [`GpuError::Lost`] when devices are
    /// lost one after the other, or none can be opened.
    pub fn render(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        options: &RenderOptions,
    ) -> Result<Frame, RenderError> {
        let mut tries_left = RECOVERIES_A_FRAME;
        loop {
            match self.render_once(scene, request, options) {
                Err(RenderError::Gpu(GpuError::Lost { .. })) if tries_left > 0 => {
                    tries_left -= 1;
                    self.executor = Executor::new(self.executor.gpu().reopened()?);
                    self.recoveries += 1;
                }
                result => return result,
            }
        }
    }

    /// How many lost devices were replaced since the renderer was made.
    pub fn recoveries(&self) -> u64 {
        self.recoveries
    }

    fn render_once(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        options: &RenderOptions,
    ) -> Result<Frame, RenderError> {
        let start = Instant::now();
        let plan = self.plan(scene, request)?;
        let plan_ms = start.elapsed().as_secs_f64() * 1e3;
        let (snapshot, _) = self.snapshot(scene)?;
        let wanted = wanted_slots(&plan, options.read_picture);
        let read_back: Vec<SlotId> = wanted.iter().map(|(slot, _)| *slot).collect();
        let inputs = FrameInputs {
            snapshot: &snapshot,
            camera: &request.camera.fitted_to(&snapshot.world_bounds),
            exposure: options.exposure.factor(&snapshot),
            tone_map: request.picture == PictureFormat::Srgb8,
            timing: options.timing,
            read_back: &read_back,
        };
        let executed = self.executor.execute(&plan, &inputs)?;
        Ok(frame_of((plan, plan_ms), wanted, executed)?)
    }
}

/// What a slot that is read back is for.
#[derive(Clone, Debug)]
enum Purpose {
    Picture,
    VisibleTriangles,
    Factor(String),
    LayerTriangles(usize),
    LayerFactor(usize, String),
}

fn wanted_slots(plan: &FramePlan, read_picture: bool) -> Vec<(SlotId, Purpose)> {
    let mut wanted = Vec::new();
    wanted.extend(read_picture.then_some((plan.picture, Purpose::Picture)));
    wanted.extend(plan.visible_triangles.map(|slot| (slot, Purpose::VisibleTriangles)));
    for light in &plan.lights {
        wanted.extend(light.factor_image.map(|slot| (slot, Purpose::Factor(light.name.clone()))));
        let layers = light.layer_factor_images.iter().enumerate();
        wanted.extend(layers.map(|(layer, slot)| (*slot, Purpose::LayerFactor(layer, light.name.clone()))));
    }
    let layers = plan.layer_triangles.iter().enumerate();
    wanted.extend(layers.map(|(layer, slot)| (*slot, Purpose::LayerTriangles(layer))));
    wanted
}

fn frame_of(
    (plan, plan_ms): (Arc<FramePlan>, f64),
    wanted: Vec<(SlotId, Purpose)>,
    executed: Executed,
) -> Result<Frame, PixelsError> {
    let Executed { pixels, kept, times, gpu_ms, encode_ms, gpu_bytes } = executed;
    let mut frame = Frame {
        layers: vec![FrameLayer::default(); plan.layer_triangles.len()],
        plan,
        picture: None,
        visible_triangles: None,
        factors: vec![],
        kept,
        times,
        gpu_ms,
        plan_ms,
        encode_ms,
        gpu_bytes,
    };
    for ((_, purpose), pixels) in wanted.into_iter().zip(pixels) {
        match purpose {
            Purpose::Picture => frame.picture = Some(pixels),
            Purpose::VisibleTriangles => frame.visible_triangles = Some(pixels.pairs()?),
            Purpose::Factor(light) => frame.factors.push(FactorImage { light, pixels }),
            Purpose::LayerTriangles(layer) => frame.layers[layer].triangles = pixels.pairs()?,
            Purpose::LayerFactor(layer, light) => {
                frame.layers[layer].factors.push(FactorImage { light, pixels });
            }
        }
    }
    Ok(frame)
}
