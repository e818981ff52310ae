//! What the examples share: opening the adapter, rendering a scene, and putting a picture into `out/`.
#![allow(
    dead_code,
    clippy::print_stdout,
    reason = "each example uses its part, and tells where its picture is"
)]

use std::error::Error;
use std::path::{Path, PathBuf};

use image::{RgbaImage, imageops};
use shadowgraph::engine::shadow::Catalog;
use shadowgraph::prelude::*;

/// The size of the pictures, in pixels.
pub(crate) const SIZE_PX: [u32; 2] = [1280, 720];

/// A renderer with the techniques of `catalog`, on the fastest adapter or on the one that `SHADOWGRAPH_ADAPTER` names.
pub(crate) fn renderer(catalog: Catalog) -> Result<Renderer, Box<dyn Error>> {
    let choice = std::env::var("SHADOWGRAPH_ADAPTER").map_or(AdapterChoice::Auto, AdapterChoice::Named);
    Ok(Renderer::new(Gpu::open(&choice)?, catalog))
}

/// `out/`, made if it is not there.
pub(crate) fn out_dir() -> Result<PathBuf, Box<dyn Error>> {
    let path = PathBuf::from("out");
    std::fs::create_dir_all(&path)
        .map_err(|error| format!("'{}' cannot be made: {error}", path.display()))?;
    Ok(path)
}

/// Renders `scene` twice as wide and high as [`SIZE_PX`], averages (the renderer draws one sample a pixel), and writes
/// `out/<name>.png`.
pub(crate) fn picture(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &CameraSnapshot,
    exposure: Exposure,
    name: &str,
) -> Result<(), Box<dyn Error>> {
    let size_px = SIZE_PX.map(|side| side * 2);
    let request = FrameRequest::new(camera.clone(), size_px);
    let options = RenderOptions { exposure, read_picture: true, ..RenderOptions::default() };
    let frame = renderer.render(scene, &request, &options)?;
    let pixels = frame.picture.ok_or("the frame has no picture")?;
    let large =
        RgbaImage::from_raw(size_px[0], size_px[1], pixels.bytes).ok_or("the picture is cut short")?;
    let small = imageops::resize(&large, SIZE_PX[0], SIZE_PX[1], imageops::FilterType::Triangle);
    let path = out_dir()?.join(name).with_extension("png");
    small.save(&path).map_err(|error| format!("'{}' cannot be written: {error}", path.display()))?;
    told(renderer, &path);
    Ok(())
}

/// Says where a file is and which adapter made it.
pub(crate) fn told(renderer: &Renderer, path: &Path) {
    println!("{} drawn by {}", path.display(), renderer.gpu().name());
}
