//! Slots: the textures and buffers of a plan.

use std::sync::Arc;

use wgpu::TextureFormat;

use crate::scene::ImageKey;

/// A slot of the plan, by its place in [`FramePlan::slots`](super::FramePlan::slots).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SlotId(pub usize);

/// A texture or a buffer that passes write and read.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// What it is called in the plan's text and in captures.
    pub name: String,
    /// What it is.
    pub kind: SlotKind,
    /// Why the frame needs it.
    pub reason: String,
    /// For a texture whose contents outlive the frame: a hash of all they depend on. The passes that write it run only
    /// when it does not hold the contents of this key yet.
    pub kept: Option<u64>,
}

/// What a slot is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum SlotKind {
    /// A texture the frame draws into; its contents do not outlive the frame, unless [`Slot::kept`] says so.
    Texture {
        /// Texel format.
        format: TextureFormat,
        /// Width and height in pixels.
        size_px: [u32; 2],
        /// Array layers.
        layers: u32,
        /// Samples of a pixel: 1, or those of [`Antialias::Multisample4`](super::Antialias::Multisample4).
        samples: u32,
    },
    /// A buffer whose contents were computed while planning.
    Buffer {
        /// What it is for.
        usage: BufferUsage,
        /// A hash of what the contents were computed from. Buffers with equal keys have equal contents, so that a
        /// buffer already on the GPU is neither computed nor uploaded again.
        revision_key: u64,
        /// The contents.
        contents: Contents,
    },
    /// An image of the scene, as materials wear it: base colours in sRGB, alpha as it is.
    Image {
        /// Which.
        image: ImageKey,
    },
}

/// What a buffer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BufferUsage {
    /// Read by shaders as `var<storage, read>`.
    Storage,
    /// 32-bit indices.
    Index,
}

/// The bytes of a buffer slot, shared between frames.
#[derive(Clone, PartialEq)]
pub struct Contents(pub Arc<Vec<u8>>);

impl std::fmt::Debug for Contents {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} B", self.0.len())
    }
}

impl Slot {
    /// The bytes the slot takes on the GPU.
    pub fn bytes(&self) -> u64 {
        match &self.kind {
            SlotKind::Texture { format, size_px, layers, samples } => {
                let texel =
                    format.block_copy_size(None).map_or_else(|| depth_texel_bytes(*format), u64::from);
                let texels = u64::from(size_px[0]) * u64::from(size_px[1]) * u64::from(*layers);
                texels * u64::from(*samples) * texel
            }
            SlotKind::Buffer { contents, .. } => contents.0.len() as u64,
            // Images are there for the surfaces that wear them, and counted with these.
            SlotKind::Image { .. } => 0,
        }
    }

    /// Samples of a pixel; 1 for buffers.
    pub fn samples(&self) -> u32 {
        if let SlotKind::Texture { samples, .. } = self.kind { samples } else { 1 }
    }
}

/// Depth formats have no copy size over both aspects; these are what implementations allocate.
fn depth_texel_bytes(format: TextureFormat) -> u64 {
    if format == TextureFormat::Depth32FloatStencil8 { 5 } else { 4 }
}
