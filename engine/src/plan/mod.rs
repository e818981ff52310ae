//! The frame plan: a frame as plain data.
//!
//! A [`FramePlan`] lists slots (textures and buffers), then passes in the order in which they run, each with its
//! attachments, its draws and the reason it is there. It holds no closures and needs no device: it can be compared,
//! printed, validated and tested as text. The executor in [`crate::gpu`] does what it says and nothing else.

mod antialias;
mod draw;
mod lights;
mod pass;
mod resource;
mod slot;
mod text;
mod validate;

pub use antialias::{Antialias, MULTISAMPLED_EVERYWHERE, STANDARD_SAMPLES_PX, UnknownAntialias};
pub use draw::{
    ADD, Binding, Draw, DrawState, Geometry, MULTIPLY, PulledStyle, STENCIL_AT_REST, Shader, ShaderError,
    Stencil, SurfaceStyle,
};
pub use lights::{FULL_DARKENING, FactorAt, FactorPart, LightPlanned, max_darkening};
pub use pass::{Access, ColorTarget, DepthTarget, Load, Pass};
pub use resource::{BufferDesc, Lifetime, Resource, Slots, TextureDesc};
pub(crate) use resource::{DepthId, Symbol};
pub use slot::{BufferUsage, Contents, Slot, SlotId, SlotKind};
pub use validate::PlanError;
/// Plain enumerations of the graphics API that plans are written in.
pub use wgpu::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, ColorWrites, CompareFunction, StencilFaceState,
    StencilOperation, TextureFormat,
};

/// A frame as plain data.
#[derive(Clone, Debug, PartialEq)]
pub struct FramePlan {
    /// Width and height of what is drawn into, in pixels; the picture has half of each with
    /// [`Antialias::Supersample4`].
    pub size_px: [u32; 2],
    /// How edges are smoothed.
    pub antialias: Antialias,
    /// Textures and buffers.
    pub slots: Vec<Slot>,
    /// Passes, in order.
    pub passes: Vec<Pass>,
    /// One entry for each light of the scene's snapshot.
    pub lights: Vec<LightPlanned>,
    /// The slot with the finished picture.
    pub picture: SlotId,
    /// The array with the factors of lights that are not hard, where there are any.
    pub visibility: Option<SlotId>,
    /// The bits of lights with counts, where several count.
    pub light_mask: Option<SlotId>,
    /// The slot with (instance, triangle) of every pixel, when asked for.
    pub visible_triangles: Option<SlotId>,
    /// How many layers of transparent surfaces are drawn one by one, nearest first, because shadows fall on them: an
    /// upper bound over all pixels.
    pub layers: u32,
    /// The slots with (instance, triangle) of the layers whose factors were asked for: nearest first.
    pub layer_triangles: Vec<SlotId>,
    /// A rectangle of pixels (first x and y, then x and y after the last); outside of it every visibility counts as
    /// 1, whatever the texture holds.
    pub shadowed_px: [u32; 4],
    /// What was left out, and why.
    pub notes: Vec<String>,
}

impl FramePlan {
    /// The slot behind `id`.
    pub fn slot(&self, id: SlotId) -> &Slot {
        &self.slots[id.0]
    }

    /// Width and height of the picture, in pixels.
    pub fn picture_size_px(&self) -> [u32; 2] {
        match self.slot(self.picture).kind {
            SlotKind::Texture { size_px, .. } => size_px,
            SlotKind::Buffer { .. } | SlotKind::Image { .. } => self.size_px,
        }
    }

    /// The bytes of all slots.
    pub fn bytes(&self) -> u64 {
        self.slots.iter().map(Slot::bytes).sum()
    }

    /// The slots that a pass writes: colour attachments, what they are resolved into, depth that is not read-only.
    pub fn written_by<'a>(&self, pass: &'a Pass) -> impl Iterator<Item = SlotId> + use<'a> {
        let depth = pass.depth.iter().filter(|depth| {
            depth.depth != Access::ReadOnly || depth.stencil.is_some_and(|s| s != Access::ReadOnly)
        });
        let colors = pass.colors.iter().flat_map(|color| [Some(color.slot), color.resolve]);
        colors.flatten().chain(depth.map(|depth| depth.slot))
    }

    /// The passes whose name begins with `prefix`.
    pub fn passes_named<'a>(&'a self, prefix: &'a str) -> impl Iterator<Item = &'a Pass> {
        self.passes.iter().filter(move |pass| pass.name.starts_with(prefix))
    }
}
