//! Factors and error maps as files. A file appears whole or not at all.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageBuffer, ImageFormat, Rgb, RgbImage, imageops};
use thiserror::Error;

use super::metrics::{Measured, sees_same};
use crate::reference::channels::{HALF_FLOAT_LOSS, at};
use crate::reference::render::ReferenceImage;

/// Why a picture was not written.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum PictureError {
    #[error("'{path}': {count} pixels are not a picture of {size_px:?}")]
    Size { path: PathBuf, count: usize, size_px: [u32; 2] },
    #[error("'{path}': light '{light}' is not in the {picture}")]
    MissingLight { path: PathBuf, light: String, picture: &'static str },
    #[error("'{path}' cannot be encoded: {source}")]
    Encode { path: PathBuf, source: image::ImageError },
    #[error("'{path}' cannot be written: {source}")]
    Write { path: PathBuf, source: std::io::Error },
}

/// Writes a `factor` picture, one value for each pixel or red, green and blue, as OpenEXR, linear RGB in f32; NaN stays
/// NaN.
///
/// # Errors
/// [`PictureError`] names the path.
pub fn write_factor(path: &Path, size_px: [u32; 2], factor: &[f32]) -> Result<(), PictureError> {
    let (texels, rest) = factor.as_chunks::<3>();
    if rest.is_empty() && holds(size_px, texels.len()) {
        return write_rgb(path, size_px, texels);
    }
    let rgb: Vec<[f32; 3]> = factor.iter().map(|f| [*f; 3]).collect();
    write_rgb(path, size_px, &rgb)
}

/// Writes a coloured factor picture as OpenEXR, linear RGB in f32; NaN stays NaN.
///
/// # Errors
/// [`PictureError`] names the path.
pub fn write_rgb(path: &Path, size_px: [u32; 2], rgb: &[[f32; 3]]) -> Result<(), PictureError> {
    let [width, height] = size_px;
    let image = ImageBuffer::<Rgb<f32>, _>::from_raw(width, height, rgb.as_flattened().to_vec())
        .filter(|_| holds(size_px, rgb.len()))
        .ok_or_else(|| PictureError::Size { path: path.into(), count: rgb.len(), size_px })?;
    write(path, &DynamicImage::ImageRgb32F(image), ImageFormat::OpenExr)
}

const LEAK: [u8; 3] = [230, 40, 30];
const FALSE_SHADOW: [u8; 3] = [40, 90, 240];
const BAND: [u8; 3] = [225, 195, 50];
const DIFFERENT: [u8; 3] = [128, 128, 128];

/// How much of its colour an error gets: all for 1, half for an eighth, a quarter for 1/64.
fn strength(difference: f32) -> f32 {
    difference.abs().min(1.0).cbrt()
}

/// `from` with so much of `to` in it.
fn mixed(from: [u8; 3], to: [u8; 3], share: f32) -> [u8; 3] {
    std::array::from_fn(|i| {
        (f32::from(from[i]) + (f32::from(to[i]) - f32::from(from[i])) * share).round() as u8
    })
}

/// The key to the shades of an error map: differences and their colours over middle grey, from the darkest false shadow to
/// the brightest leak.
pub fn error_key() -> Vec<(f32, [u8; 3])> {
    let grey = [70; 3];
    let step = |index: i16| {
        let difference = f32::from(index) / 8.0;
        (difference, mixed(grey, if index < 0 { FALSE_SHADOW } else { LEAK }, strength(difference)))
    };
    (-8..=8).map(step).collect()
}

/// Writes where `light` is wrong, as PNG: leaks red, false shadows blue, pixels that show different triangles grey, over
/// the dimmed reference. For a light without size wrong pixels have full colour, what else is in the ambiguity band is yellow,
/// and smaller differences are shades; for a light with a size all differences are shades, as strong as the cube root of what
/// they exceed the bounds by.
///
/// # Errors
/// [`PictureError`] names the path.
pub fn write_error_map(
    path: &Path,
    measured: &Measured,
    reference: &ReferenceImage,
    light: &str,
) -> Result<(), PictureError> {
    write_bytes(path, &error_map_png(path, measured, reference, light)?)
}

/// What [`write_error_map`] writes; `path` says in errors what the picture is for.
///
/// # Errors
/// [`PictureError`] names the path.
pub fn error_map_png(
    path: &Path,
    measured: &Measured,
    reference: &ReferenceImage,
    light: &str,
) -> Result<Vec<u8>, PictureError> {
    let missing = |picture| PictureError::MissingLight { path: path.into(), light: light.into(), picture };
    let (_, factor) =
        measured.lights.iter().find(|(name, _)| name == light).ok_or_else(|| missing("measured picture"))?;
    let exact = reference.lights.iter().find(|l| l.name == light).ok_or_else(|| missing("reference"))?;
    let size_px = reference.size_px;
    let one_each = |count: usize| holds(size_px, count);
    let one_or_rgb = |count: usize| one_each(count) || (count.is_multiple_of(3) && one_each(count / 3));
    for (count, fits) in [
        (factor.len(), one_or_rgb(factor.len())),
        (exact.factor.len(), one_or_rgb(exact.factor.len())),
        (measured.ids.len(), one_each(measured.ids.len())),
        (reference.hits.len(), one_each(reference.hits.len())),
    ] {
        if !fits {
            return Err(PictureError::Size { path: path.into(), count, size_px });
        }
    }
    let pixels = reference.hits.len();
    let color = |pixel: usize| {
        // Of a coloured factor the channel that differs most.
        let channels = at(factor, pixels, pixel).zip(at(&exact.factor, pixels, pixel)).enumerate();
        let differences = channels.map(|(channel, (value, factor))| {
            let [least, largest] = exact.bounds(pixel, channel, factor);
            let outside = if value > largest { value - largest } else { (value - least).min(0.0) };
            (value - factor, outside, factor)
        });
        let (difference, outside, factor) =
            differences.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).unwrap_or_default();
        // NaN, where nothing is, becomes black.
        let dimmed = [(factor * 70.0 + 20.0).max(0.0) as u8; 3];
        let is_hard = exact.soft.is_none();
        match (exact.compared[pixel], difference) {
            _ if !sees_same(measured.ids[pixel], reference.hits[pixel]) => DIFFERENT,
            (false, _) => dimmed,
            (true, d) if is_hard && d > 0.5 => LEAK,
            (true, d) if is_hard && d < -0.5 => FALSE_SHADOW,
            (true, _) if is_hard && exact.ambiguous[pixel] => BAND,
            _ if outside.abs() > HALF_FLOAT_LOSS as f32 => {
                mixed(dimmed, if outside > 0.0 { LEAK } else { FALSE_SHADOW }, strength(outside))
            }
            _ => dimmed,
        }
    };
    rgb_png(path, size_px, (0..pixels).flat_map(color).collect())
}

/// The reference's factor of `light` as PNG, white where it is lit and coloured where it is; `path` says in errors what the picture is for.
///
/// # Errors
/// [`PictureError`] names the path.
pub fn factor_png(path: &Path, reference: &ReferenceImage, light: &str) -> Result<Vec<u8>, PictureError> {
    let missing =
        || PictureError::MissingLight { path: path.into(), light: light.into(), picture: "reference" };
    let exact = reference.lights.iter().find(|l| l.name == light).ok_or_else(missing)?;
    // NaN, where nothing is, becomes black.
    let level = |factor: f32| (factor * 255.0).round() as u8;
    let pixels = reference.hits.len();
    let shades = (0..pixels).flat_map(|pixel| {
        let mut channels = at(&exact.factor, pixels, pixel).map(level);
        let red = channels.next().unwrap_or_default();
        [red, channels.next().unwrap_or(red), channels.next().unwrap_or(red)]
    });
    rgb_png(path, reference.size_px, shades.collect())
}

/// A contact sheet as PNG: `picture_png` at the left, beside it for each light the reference's factor and the error map, one
/// light below the other; `path` says in errors what the sheet is for.
///
/// # Errors
/// [`PictureError`] names the path.
pub fn sheet_png(
    path: &Path,
    picture_png: &[u8],
    measured: &Measured,
    reference: &ReferenceImage,
) -> Result<Vec<u8>, PictureError> {
    let decode = |png: &[u8]| {
        let decoded = image::load_from_memory_with_format(png, ImageFormat::Png);
        decoded
            .map(|image| image.into_rgb8())
            .map_err(|source| PictureError::Encode { path: path.into(), source })
    };
    let picture = decode(picture_png)?;
    let (width, height) = picture.dimensions();
    let rows = measured.lights.len().max(1) as u32;
    let mut sheet = RgbImage::from_pixel(
        width * 3 + SHEET_GAP_PX * 2,
        height * rows + SHEET_GAP_PX * (rows - 1),
        Rgb([255; 3]),
    );
    let mut place = |image: &RgbImage, column: u32, row: u32| {
        let step = |size: u32, number: u32| i64::from((size + SHEET_GAP_PX) * number);
        imageops::replace(&mut sheet, image, step(width, column), step(height, row));
    };
    place(&picture, 0, 0);
    for (row, (light, _)) in measured.lights.iter().enumerate() {
        let maps = [factor_png(path, reference, light)?, error_map_png(path, measured, reference, light)?];
        for (column, png) in maps.iter().enumerate() {
            // Factors of several samples a pixel have a texel for each.
            let map = imageops::resize(&decode(png)?, width, height, imageops::FilterType::Triangle);
            place(&map, column as u32 + 1, row as u32);
        }
    }
    encode(path, &DynamicImage::ImageRgb8(sheet), ImageFormat::Png)
}

/// White between the pictures of a sheet, in pixels.
const SHEET_GAP_PX: u32 = 6;

fn rgb_png(path: &Path, size_px: [u32; 2], pixels: Vec<u8>) -> Result<Vec<u8>, PictureError> {
    let count = pixels.len() / 3;
    let image = ImageBuffer::<Rgb<u8>, _>::from_raw(size_px[0], size_px[1], pixels)
        .ok_or_else(|| PictureError::Size { path: path.into(), count, size_px })?;
    encode(path, &DynamicImage::ImageRgb8(image), ImageFormat::Png)
}

fn holds([width, height]: [u32; 2], count: usize) -> bool {
    width as usize * height as usize == count
}

/// Encodes in memory.
fn encode(path: &Path, image: &DynamicImage, format: ImageFormat) -> Result<Vec<u8>, PictureError> {
    let mut bytes = Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, format)
        .map_err(|source| PictureError::Encode { path: path.into(), source })?;
    Ok(bytes.into_inner())
}

fn write(path: &Path, image: &DynamicImage, format: ImageFormat) -> Result<(), PictureError> {
    write_bytes(path, &encode(path, image, format)?)
}

/// Writes beside the target, then moves into place.
fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), PictureError> {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    let part = path.with_file_name(name);
    let written = fs::write(&part, bytes).and_then(|()| fs::rename(&part, path));
    written.map_err(|source| {
        // Nothing to be done about a remainder that cannot be removed either; the first error is the one to tell.
        let _ = fs::remove_file(&part);
        PictureError::Write { path: path.into(), source }
    })
}
