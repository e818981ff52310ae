//! A picture in one call, for programs that want nothing else of a frame.

use std::path::Path;

use image::{ImageError, RgbaImage};
use shadowgraph_engine::gpu::{AdapterChoice, Gpu, GpuError};
use shadowgraph_engine::render::{FrameRequest, RenderError, RenderOptions, Renderer};
use shadowgraph_engine::scene::{CameraSnapshot, Scene};
use thiserror::Error;

/// The short way to a picture; [`Renderer::new`] and [`Renderer::render`] are the long one, with plans, factors and times.
pub trait Pictures: Sized {
    /// A renderer with all built-in techniques, on the adapter that the environment variable `SHADOWGRAPH_ADAPTER` names, or
    /// else on the fastest.
    ///
    /// # Errors
    /// [`GpuError`] when there is no such adapter, or it gives no device.
    fn open() -> Result<Self, GpuError>;

    /// The scene as `camera` sees it, `size_px` wide and high, in sRGB, with an exposure that suits its lights.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    fn picture(
        &mut self,
        scene: &Scene,
        camera: &CameraSnapshot,
        size_px: [u32; 2],
    ) -> Result<Picture, RenderError>;
}

impl Pictures for Renderer {
    fn open() -> Result<Self, GpuError> {
        let choice = std::env::var("SHADOWGRAPH_ADAPTER").map_or(AdapterChoice::Auto, AdapterChoice::Named);
        Ok(Self::new(Gpu::open(&choice)?, shadowgraph_nodes::catalog()))
    }

    fn picture(
        &mut self,
        scene: &Scene,
        camera: &CameraSnapshot,
        size_px: [u32; 2],
    ) -> Result<Picture, RenderError> {
        let request = FrameRequest::new(camera.clone(), size_px);
        let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
        let frame = self.render(scene, &request, &options)?;
        let rgba = frame.picture.map(|pixels| pixels.bytes).unwrap_or_default();
        Ok(Picture { size_px, rgba })
    }
}

/// A finished picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// Width and height.
    pub size_px: [u32; 2],
    /// Red, green, blue and alpha of every pixel in sRGB, a byte each; top row first.
    pub rgba: Vec<u8>,
}

/// Why a picture was not written.
#[derive(Debug, Error)]
#[error("'{path}' cannot be written: {source}")]
pub struct SaveError {
    /// The file.
    pub path: String,
    /// What was in the way.
    #[source]
    pub source: ImageError,
}

impl Picture {
    /// Writes the picture as a file of the kind that its name ends with: `.png`, `.jpg` or `.webp`. Folders that are missing
    /// are made.
    ///
    /// # Errors
    /// [`SaveError`] names the file and what was in the way.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), SaveError> {
        let path = path.as_ref();
        let made = path.parent().map_or(Ok(()), std::fs::create_dir_all).map_err(ImageError::IoError);
        let [width, height] = self.size_px;
        let written = made.and_then(|()| match RgbaImage::from_raw(width, height, self.rgba.clone()) {
            // JPEG has no alpha, which is 1 everywhere.
            Some(pixels) if path.extension().is_some_and(|ending| ending == "jpg" || ending == "jpeg") => {
                image::DynamicImage::ImageRgba8(pixels).to_rgb8().save(path)
            }
            Some(pixels) => pixels.save(path),
            None => Err(ImageError::Parameter(image::error::ParameterError::from_kind(
                image::error::ParameterErrorKind::DimensionMismatch,
            ))),
        });
        written.map_err(|source| SaveError { path: path.display().to_string(), source })
    }
}
