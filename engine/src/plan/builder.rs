//! Building a plan: slots, passes and notes as they are found to be needed.

use std::sync::Arc;

use wgpu::TextureFormat;

use super::{BufferUsage, Contents, Pass, Slot, SlotId, SlotKind};
use crate::scene::ImageKey;

/// A plan in the making.
#[derive(Clone, Debug)]
pub struct PlanBuilder {
    /// Width and height of what is drawn into, in pixels.
    pub size_px: [u32; 2],
    /// Textures and buffers so far.
    pub slots: Vec<Slot>,
    /// Passes so far, in order.
    pub passes: Vec<Pass>,
    /// What was left out, and why.
    pub notes: Vec<String>,
}

impl PlanBuilder {
    /// An empty plan that draws into targets of this size.
    pub fn new(size_px: [u32; 2]) -> Self {
        Self { size_px, slots: Vec::new(), passes: Vec::new(), notes: Vec::new() }
    }

    /// Adds a texture as large as what is drawn.
    pub fn texture(&mut self, name: &str, format: TextureFormat, layers: u32, reason: &str) -> SlotId {
        self.texture_sized(name, format, self.size_px, layers, reason)
    }

    /// Adds a texture as large as what is drawn, of several samples a pixel.
    pub fn samples(&mut self, name: &str, format: TextureFormat, samples: u32, reason: &str) -> SlotId {
        let size_px = self.size_px;
        self.slot(name, SlotKind::Texture { format, size_px, layers: 1, samples }, reason)
    }

    /// Adds a texture of any size.
    pub fn texture_sized(
        &mut self,
        name: &str,
        format: TextureFormat,
        size_px: [u32; 2],
        layers: u32,
        reason: &str,
    ) -> SlotId {
        self.slot(name, SlotKind::Texture { format, size_px, layers, samples: 1 }, reason)
    }

    /// Adds a texture whose contents nobody needs after the passes that are added next: several that want one of this
    /// name, format and size share it, in turns.
    pub fn scratch_texture(
        &mut self,
        name: &str,
        format: TextureFormat,
        size_px: [u32; 2],
        layers: u32,
        reason: &str,
    ) -> SlotId {
        let kind = SlotKind::Texture { format, size_px, layers, samples: 1 };
        let same = |slot: &Slot| slot.kept.is_none() && slot.name == name && slot.kind == kind;
        match self.slots.iter().position(same) {
            Some(index) => SlotId(index),
            None => self.slot(name, kind, reason),
        }
    }

    /// Adds a texture whose contents outlive the frame, under `revision_key`; see
    /// [`LightPlan::kept_texture`](crate::shadow::LightPlan::kept_texture). Equal in name, format, size and key, it is
    /// added once.
    pub fn kept_texture(
        &mut self,
        name: &str,
        format: TextureFormat,
        size_px: [u32; 2],
        layers: u32,
        revision_key: u64,
        reason: &str,
    ) -> SlotId {
        let kind = SlotKind::Texture { format, size_px, layers, samples: 1 };
        let same = |slot: &Slot| slot.kept == Some(revision_key) && slot.name == name && slot.kind == kind;
        if let Some(index) = self.slots.iter().position(same) {
            return SlotId(index);
        }
        let slot = self.slot(name, kind, reason);
        self.slots[slot.0].kept = Some(revision_key);
        slot
    }

    /// A texture as large as what is drawn whose contents are done with when the passes that asked for it are: one for
    /// all that ask by this name for this format.
    pub fn scratch(&mut self, name: &str, format: TextureFormat, reason: &str) -> SlotId {
        let wanted = format;
        let same = |slot: &Slot| {
            slot.name == name && matches!(slot.kind, SlotKind::Texture { format, .. } if format == wanted)
        };
        match self.slots.iter().position(same) {
            Some(index) => SlotId(index),
            None => self.texture(name, format, 1, reason),
        }
    }

    /// Adds a buffer with contents whose origin hashes to `revision_key`. A buffer with the same key and use is
    /// added once.
    pub fn buffer(
        &mut self,
        name: &str,
        usage: BufferUsage,
        revision_key: u64,
        contents: Arc<Vec<u8>>,
        reason: &str,
    ) -> SlotId {
        let same = |slot: &Slot| matches!(slot.kind, SlotKind::Buffer { usage: u, revision_key: key, .. } if u == usage && key == revision_key);
        if let Some(index) = self.slots.iter().position(same) {
            return SlotId(index);
        }
        self.slot(name, SlotKind::Buffer { usage, revision_key, contents: Contents(contents) }, reason)
    }

    /// Adds an image of the scene; once, however often it is asked for.
    pub fn image(&mut self, name: &str, image: ImageKey, reason: &str) -> SlotId {
        let kind = SlotKind::Image { image };
        match self.slots.iter().position(|slot| slot.kind == kind) {
            Some(index) => SlotId(index),
            None => self.slot(name, kind, reason),
        }
    }

    fn slot(&mut self, name: &str, kind: SlotKind, reason: &str) -> SlotId {
        self.slots.push(Slot { name: name.into(), kind, reason: reason.into(), kept: None });
        SlotId(self.slots.len() - 1)
    }

    /// Notes something that was left out.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }
}
