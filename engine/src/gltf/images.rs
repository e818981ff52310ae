//! Images: found, decoded within limits, each once.

use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

use image::{ImageDecoder, ImageFormat, ImageReader, Limits};
use serde_json::Value;

use super::GltfError;
use super::buffers::Buffers;
use super::document::{Document, Section};
use super::limits::{Budget, Warnings};
use super::names::shown;
use super::uri::{self, Files};
use crate::scene::{Image, ImageKey, Scene};

/// The most texels an image may have along a side: what GPUs take.
const MAX_SIDE: u32 = 16384;

/// What a decoder may take to read a header.
const HEADER_BYTES: u64 = 1 << 20;

/// Loads images into a scene as materials ask for them.
pub(super) struct Images<'i, 'a> {
    pub(super) document: &'i Document,
    pub(super) buffers: &'i Buffers<'a>,
    pub(super) files: &'i Files,
    pub(super) scene: &'i mut Scene,
    pub(super) budget: &'i mut Budget,
    pub(super) warnings: &'i mut Warnings,
    pub(super) loaded: HashMap<usize, ImageKey>,
}

impl Images<'_, '_> {
    /// The key of image `index`, decoded on first use.
    pub(super) fn key(&mut self, index: usize) -> Result<ImageKey, GltfError> {
        if let Some(key) = self.loaded.get(&index) {
            return Ok(*key);
        }
        let image = self.decode(index)?;
        let key = self.scene.add_image(Arc::new(image));
        self.loaded.insert(index, key);
        Ok(key)
    }

    fn decode(&mut self, index: usize) -> Result<Image, GltfError> {
        let declaration = self.document.used(Section::Images, index)?;
        let text = |field: &str| declaration.get(field).and_then(Value::as_str);
        let name = text("name").map_or_else(|| format!("image{index}"), str::to_owned);
        let label = format!("image {index} '{}'", shown(&name));
        let wrong = |problem: String| GltfError::Image { image: label.clone(), problem };
        let file;
        let view = declaration.get("bufferView").and_then(Value::as_u64);
        let bytes: &[u8] = match (view, text("uri")) {
            (Some(view), _) => self.buffers.view(view as usize, self.budget)?,
            (None, Some(text)) => {
                file = uri::read(&label, text, self.files, self.budget)?;
                &file
            }
            (None, None) => return Err(wrong("it has neither bufferView nor uri".into())),
        };
        // The content decides the format: declared MIME types and file endings are often wrong.
        let format = image::guess_format(bytes).ok();
        let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP)) = format else {
            return Err(wrong("its format is not supported".into()));
        };
        let declared = text("mimeType").filter(|declared| *declared != format.to_mime_type());
        if let Some(declared) = declared {
            let found = format.to_mime_type();
            self.warnings
                .add(format!("{label}: it is {found}, though its mimeType says {}", shown(declared)));
        }
        let failed = |error: image::ImageError| wrong(error.to_string());
        // The header says what it will take, before any of it is taken.
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        limits.max_alloc = Some(bytes.len() as u64 + HEADER_BYTES);
        reader.limits(limits.clone());
        let decoder = reader.into_decoder().map_err(failed)?;
        let (width, height) = decoder.dimensions();
        if width == 0 || height == 0 || width.max(height) > MAX_SIDE {
            return Err(wrong(format!("{width}x{height} texels; 1 to {MAX_SIDE} a side are accepted")));
        }
        let (kept, decoded) = (u64::from(width) * u64::from(height) * 4, decoder.total_bytes());
        self.budget.charge_image(&label, kept, decoded)?;
        drop(decoder);
        // As much again for the decoder itself.
        limits.max_alloc = Some(2 * decoded + HEADER_BYTES);
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        reader.limits(limits);
        let rgba8 = reader.decode().map_err(failed)?.into_rgba8().into_raw();
        Ok(Image { name, width, height, rgba8 })
    }
}
