//! Writing files whole or not at all.

use std::io::Cursor;
use std::path::Path;

use shadowgraph::engine::gpu::Pixels;

use super::{Failure, other};

/// Writes `bytes` beside `path` and renames them there, so that `path` is never half-written.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    let name =
        path.file_name().ok_or_else(|| Failure::Usage(format!("'{}' is no file name", path.display())))?;
    let mut beside = name.to_owned();
    beside.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(beside);
    let failed =
        |error: std::io::Error| Failure::Other(format!("cannot write '{}': {error}", path.display()));
    let written = std::fs::write(&temporary, bytes).and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|error| {
        // The temporary file may not even exist; the error to report is the first one.
        let _ = std::fs::remove_file(&temporary);
        failed(error)
    })
}

/// Makes a folder and those above it.
pub(crate) fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path)
        .map_err(|error| Failure::Other(format!("cannot make folder '{}': {error}", path.display())))
}

/// Writes an 8-bit RGBA picture as PNG.
pub(crate) fn write_png(path: &Path, pixels: &Pixels) -> Result<(), Failure> {
    let [width, height] = pixels.size_px;
    let mut png = Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut png,
        &pixels.bytes,
        width,
        height,
        image::ExtendedColorType::Rgba8,
        image::ImageFormat::Png,
    )
    .map_err(other)?;
    write_whole(path, png.get_ref())
}
