//! Which slots passes write, and taking out one that none names.

use super::{Access, Binding, FramePlan, Geometry, Pass, SlotId};

impl FramePlan {
    /// The slots that a pass writes: colour attachments, what they are resolved into, depth that is not read-only.
    pub fn written_by<'a>(&self, pass: &'a Pass) -> impl Iterator<Item = SlotId> + use<'a> {
        let depth = pass.depth.iter().filter(|depth| {
            depth.depth != Access::ReadOnly || depth.stencil.is_some_and(|s| s != Access::ReadOnly)
        });
        let colors = pass.colors.iter().flat_map(|color| [Some(color.slot), color.resolve]);
        colors.flatten().chain(depth.map(|depth| depth.slot))
    }

    /// Removes a slot that no pass names, renumbering those after it.
    pub(crate) fn remove_slot(&mut self, removed: SlotId) {
        self.slots.remove(removed.0);
        let shift = |slot: &mut SlotId| slot.0 -= usize::from(slot.0 > removed.0);
        for pass in &mut self.passes {
            pass.colors.iter_mut().for_each(|color| shift(&mut color.slot));
            pass.colors.iter_mut().filter_map(|color| color.resolve.as_mut()).for_each(shift);
            pass.depth.iter_mut().for_each(|depth| shift(&mut depth.slot));
            for draw in &mut pass.draws {
                if let Geometry::Indexed { indices, .. } = &mut draw.geometry {
                    shift(indices);
                }
                for (_, binding) in &mut draw.bindings {
                    match binding {
                        Binding::Storage(slot)
                        | Binding::Texture(slot)
                        | Binding::TextureArray(slot)
                        | Binding::TextureLayer(slot, _)
                        | Binding::StencilOf(slot) => shift(slot),
                    }
                }
            }
        }
        shift(&mut self.picture);
        self.visible_triangles.iter_mut().for_each(shift);
        self.lights.iter_mut().filter_map(|light| light.factor_image.as_mut()).for_each(shift);
        self.lights.iter_mut().flat_map(|light| &mut light.layer_factor_images).for_each(shift);
        self.layer_triangles.iter_mut().for_each(shift);
    }
}
