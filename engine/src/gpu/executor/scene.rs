//! The frame that is being recorded: its plan, and where the plan's slots are on the device.

use super::GpuSlot;
use crate::plan::{FramePlan, SlotId, SlotKind, TextureFormat};
use crate::scene::SceneSnapshot;

/// What recording needs to know besides the executor's own stores.
pub(super) struct Scene<'a> {
    pub(super) plan: &'a FramePlan,
    pub(super) snapshot: &'a SceneSnapshot,
    pub(super) slots: &'a [GpuSlot],
    pub(super) frame_group: &'a wgpu::BindGroup,
}

impl Scene<'_> {
    pub(super) fn texture(&self, slot: SlotId) -> Option<&wgpu::Texture> {
        match &self.slots[slot.0] {
            GpuSlot::Texture(texture) => Some(texture),
            GpuSlot::Buffer(_) => None,
        }
    }

    pub(super) fn format(&self, slot: SlotId) -> TextureFormat {
        match self.plan.slot(slot).kind {
            SlotKind::Texture { format, .. } => format,
            SlotKind::Buffer { .. } | SlotKind::Image { .. } => TextureFormat::R8Unorm,
        }
    }

    pub(super) fn view(
        &self,
        slot: SlotId,
        descriptor: &wgpu::TextureViewDescriptor<'_>,
    ) -> Option<wgpu::TextureView> {
        Some(self.texture(slot)?.create_view(descriptor))
    }
}
