//! Images: found, decoded within limits, each once.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;

use gltf::json;
use image::{ImageFormat, ImageReader, Limits};

use super::GltfError;
use super::buffers::Buffers;
use super::limits::{Budget, Warnings};
use super::uri;
use crate::scene::{Image, ImageKey, Scene};

/// The most texels an image may have along a side: what GPUs take.
const MAX_SIDE: u32 = 16384;

/// Loads images into a scene as materials ask for them.
pub(super) struct Images<'a> {
    pub(super) root: &'a json::Root,
    pub(super) buffers: &'a Buffers<'a>,
    pub(super) base_dir: Option<&'a Path>,
    pub(super) scene: &'a mut Scene,
    pub(super) budget: &'a mut Budget,
    pub(super) warnings: &'a mut Warnings,
    pub(super) loaded: HashMap<usize, ImageKey>,
}

impl Images<'_> {
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
        let name = match self.root.images.get(index).and_then(|image| image.name.as_ref()) {
            Some(name) => name.clone(),
            None => format!("image{index}"),
        };
        let label = format!("image {index} '{name}'");
        let wrong = |problem: String| GltfError::Image { image: label.clone(), problem };
        let declaration = self.root.images.get(index).ok_or_else(|| wrong("it does not exist".into()))?;
        let file;
        let bytes: &[u8] = match (declaration.buffer_view, &declaration.uri) {
            (Some(view), _) => self.buffers.view(self.root, view)?,
            (None, Some(text)) => {
                file = uri::read(&label, text, self.base_dir, self.budget)?;
                &file
            }
            (None, None) => return Err(wrong("it has neither bufferView nor uri".into())),
        };
        // The content decides the format: declared MIME types and file endings are often wrong.
        let format = image::guess_format(bytes).ok();
        let Some(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = format else {
            return Err(wrong("its format is not supported".into()));
        };
        let failed = |error: image::ImageError| wrong(error.to_string());
        let size = ImageReader::with_format(Cursor::new(bytes), format).into_dimensions();
        let (width, height) = size.map_err(failed)?;
        if width == 0 || height == 0 || width.max(height) > MAX_SIDE {
            return Err(wrong(format!("{width}x{height} texels; 1 to {MAX_SIDE} a side are accepted")));
        }
        let texels = u64::from(width) * u64::from(height);
        self.budget.charge_texels(texels)?;
        let mut limits = Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        // Up to four 16-bit channels, and as much again for the decoder itself.
        limits.max_alloc = Some(texels * 16 + (1 << 20));
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        reader.limits(limits);
        let rgba8 = reader.decode().map_err(failed)?.into_rgba8().into_raw();
        Ok(Image { name, width, height, rgba8 })
    }
}
