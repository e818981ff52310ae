//! Getting textures back to the CPU.

use thiserror::Error;
use wgpu::TextureFormat;

use super::{Gpu, GpuError};

/// Why pixels could not be had.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum PixelsError {
    #[error("pixels of format {format:?} cannot be read back")]
    Format { format: TextureFormat },
    #[error("pixels are {format:?}, not {wanted}")]
    WrongType { format: TextureFormat, wanted: &'static str },
    #[error("reading pixels back failed: {0}")]
    Map(String),
}

/// The texels of a texture, tightly packed, top row first.
#[derive(Clone, Debug, PartialEq)]
pub struct Pixels {
    /// Their format.
    pub format: TextureFormat,
    /// Width and height.
    pub size_px: [u32; 2],
    /// The bytes.
    pub bytes: Vec<u8>,
}

impl Pixels {
    /// The texels as f32 values, all channels in a row.
    ///
    /// # Errors
    /// [`PixelsError::WrongType`] when the format is no 32-bit float.
    pub fn floats(&self) -> Result<Vec<f32>, PixelsError> {
        match self.format {
            TextureFormat::R32Float | TextureFormat::Rg32Float | TextureFormat::Rgba32Float => {
                Ok(bytemuck::pod_collect_to_vec(&self.bytes))
            }
            format => Err(PixelsError::WrongType { format, wanted: "32-bit floats" }),
        }
    }

    /// The texels as pairs of u32.
    ///
    /// # Errors
    /// [`PixelsError::WrongType`] when the format is not `Rg32Uint`.
    pub fn pairs(&self) -> Result<Vec<[u32; 2]>, PixelsError> {
        match self.format {
            TextureFormat::Rg32Uint => Ok(bytemuck::pod_collect_to_vec(&self.bytes)),
            format => Err(PixelsError::WrongType { format, wanted: "pairs of u32" }),
        }
    }
}

/// A copy under way.
pub(crate) struct Pending {
    buffer: wgpu::Buffer,
    format: TextureFormat,
    size_px: [u32; 2],
    row_bytes: u32,
    padded_row_bytes: u32,
}

impl Pending {
    /// Records the copy of layer 0 of `texture`.
    pub(crate) fn record(
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        texture: &wgpu::Texture,
    ) -> Result<Self, PixelsError> {
        let format = texture.format();
        let size_px = [texture.width(), texture.height()];
        let (row_bytes, padded_row_bytes) =
            row_bytes(format, size_px[0]).ok_or(PixelsError::Format { format })?;
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("read back"),
            size: u64::from(padded_row_bytes) * u64::from(size_px[1]),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(padded_row_bytes),
            rows_per_image: Some(size_px[1]),
        };
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
            wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
        );
        Ok(Self { buffer, format, size_px, row_bytes, padded_row_bytes })
    }

    /// Waits for the copy and unpads its rows.
    pub(crate) fn finish(self, gpu: &Gpu) -> Result<Pixels, GpuError> {
        let padded = read_buffer(gpu, &self.buffer)?;
        let rows = padded.chunks_exact(self.padded_row_bytes as usize);
        let bytes = rows.flat_map(|row| &row[..self.row_bytes as usize]).copied().collect();
        Ok(Pixels { format: self.format, size_px: self.size_px, bytes })
    }
}

/// The bytes of a row, and those it takes in a copy.
fn row_bytes(format: TextureFormat, width_px: u32) -> Option<(u32, u32)> {
    let bytes = width_px.checked_mul(format.block_copy_size(None)?)?;
    Some((bytes, bytes.checked_next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)?))
}

/// The bytes of the buffer a texture is copied to.
pub(crate) fn padded_bytes(format: TextureFormat, size_px: [u32; 2]) -> Option<u64> {
    Some(u64::from(row_bytes(format, size_px[0])?.1) * u64::from(size_px[1]))
}

/// The contents of a mappable buffer whose copy has been submitted.
pub(crate) fn read_buffer(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, GpuError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver is gone only when the frame was given up.
        let _ = sender.send(result);
    });
    gpu.wait()?;
    let failed = |message: String| GpuError::from(PixelsError::Map(message));
    match receiver.try_recv() {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(failed(error.to_string())),
        Err(error) => return Err(failed(error.to_string())),
    }
    let range = buffer.get_mapped_range(..).map_err(|error| failed(error.to_string()))?;
    Ok(range.to_vec())
}
