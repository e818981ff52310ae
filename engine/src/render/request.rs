//! What is wanted of a frame, of which adapter, and why it may be refused.

use std::ops::Range;

use thiserror::Error;
use wgpu::TextureFormat;

use crate::plan::{Antialias, MULTISAMPLED_EVERYWHERE, ShaderError};
use crate::scene::{CameraSnapshot, SurfaceFunctionError};
use crate::shadow::ShadowError;

/// Why a frame could not be planned.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum FrameError {
    #[error("a picture of {width}x{height} was asked for; width and height must be from 1 to {limit}")]
    Size { width: u32, height: u32, limit: u32 },
    #[error(
        "a picture of {width}x{height} with antialias {antialias} needs targets of {needed_width}x{needed_height}; they must not exceed {limit}"
    )]
    AntialiasedSize {
        antialias: Antialias,
        width: u32,
        height: u32,
        needed_width: u32,
        needed_height: u32,
        limit: u32,
    },
    #[error(
        "antialias msaa4 needs {what} as {format:?} with 4 samples, which adapter '{adapter}' does not have (accepted for it: {accepted})"
    )]
    Multisample { what: String, format: TextureFormat, adapter: String, accepted: &'static str },
    #[error(
        "antialias msaa4 keeps the counts of up to {limit} lights apart in its light mask, the scene has {lights} (accepted for it: none, ssaa4)"
    )]
    MultisampledLights { lights: u32, limit: u32 },
    #[error(
        "{asked_by} wants shadows on transparent surfaces, which antialias msaa4 does not draw apart (accepted for it: none, ssaa4)"
    )]
    MultisampledLayers { asked_by: String },
    #[error(
        "{asked_by} wants shadows on transparent surfaces, of which up to {layers} lie one behind the other in this view; the limit is {limit}"
    )]
    TooManyLayers { asked_by: String, layers: u32, limit: u32 },
    #[error(
        "camera '{name}' is not valid: it needs 0 < near < far, and a field of view between 0 and pi or a positive height, all finite"
    )]
    Camera { name: String },
    #[error("material '{material}': {source}")]
    SurfaceFunction { material: String, source: SurfaceFunctionError },
    #[error(
        "material '{material}' is unlit, so its surface function '{function}' has no light to reflect; it may have one of the two"
    )]
    UnlitFunction { material: String, function: String },
    #[error(transparent)]
    Shader(#[from] ShaderError),
    #[error(transparent)]
    Shadow(#[from] ShadowError),
}

/// The format of the finished picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureFormat {
    /// Tone-mapped, 8 bits, sRGB.
    #[default]
    Srgb8,
    /// Linear radiance times exposure in f32, not tone-mapped.
    LinearF32,
}

/// What is wanted of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRequest {
    /// The camera.
    pub camera: CameraSnapshot,
    /// Width and height, in pixels.
    pub size_px: [u32; 2],
    /// The picture's format.
    pub picture: PictureFormat,
    /// How edges are smoothed.
    pub antialias: Antialias,
    /// Whether each shadowed light's factor is kept as an image, with the visible triangle of every pixel, or of every
    /// sample when edges are smoothed.
    pub factors: bool,
    /// The layers of transparent surfaces, 0 the nearest, whose factors are kept too, with the visible triangle of
    /// every pixel of the layer: factors of the lights whose techniques ask for layers. Every layer takes images of
    /// its own.
    pub layer_factors: Range<u32>,
}

impl FrameRequest {
    /// An sRGB picture of this size from `camera`, without antialiasing.
    pub fn new(camera: CameraSnapshot, size_px: [u32; 2]) -> Self {
        Self {
            camera,
            size_px,
            picture: PictureFormat::Srgb8,
            antialias: Antialias::None,
            factors: false,
            layer_factors: 0..0,
        }
    }
}

/// What the adapter offers a plan.
#[derive(Clone, Debug)]
pub struct Adapter<'a> {
    /// The adapter's name, for errors.
    pub name: &'a str,
    /// Its features.
    pub features: wgpu::Features,
    /// Its largest texture side, in pixels.
    pub max_size_px: u32,
    /// The formats in which it has targets of four samples.
    pub multisampled: &'a [TextureFormat],
}

/// Checks that the adapter has targets as large as antialiasing asks for.
pub(super) fn check_size(
    request: &FrameRequest,
    adapter: &Adapter<'_>,
    [needed_width, needed_height]: [u32; 2],
) -> Result<(), FrameError> {
    let (antialias, [width, height], limit) = (request.antialias, request.size_px, adapter.max_size_px);
    if needed_width <= limit && needed_height <= limit {
        return Ok(());
    }
    Err(FrameError::AntialiasedSize { antialias, width, height, needed_width, needed_height, limit })
}

impl Adapter<'_> {
    /// Checks that there are targets of four samples in `format`, needed as `what`.
    pub(super) fn check_multisampled(&self, what: &str, format: TextureFormat) -> Result<(), FrameError> {
        if self.multisampled.contains(&format) {
            return Ok(());
        }
        let accepted = if format == TextureFormat::Rgba32Float {
            "none, ssaa4, or an 8-bit picture"
        } else {
            "none, ssaa4"
        };
        let (what, adapter) = (what.into(), self.name.into());
        Err(FrameError::Multisample { what, format, adapter, accepted })
    }
}

impl Adapter<'static> {
    /// An imagined adapter with every feature a plan may ask for: for planning without a device.
    pub fn imagined() -> Self {
        Self {
            name: "no adapter",
            features: wgpu::Features::all(),
            max_size_px: 16384,
            multisampled: MULTISAMPLED_EVERYWHERE,
        }
    }
}
