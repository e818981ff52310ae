//! Where a technique writes its passes, and asks for the textures and buffers they need.

use crate::plan::{self, BufferDesc, Resource, Slots, Symbol, TextureDesc};
use crate::scene::{ImageKey, SceneSnapshot};

/// A pass while the frame is planned.
pub type Pass = plan::Pass<Resource>;
/// A draw while the frame is planned.
pub type Draw = plan::Draw<Resource>;
/// What a draw draws, while the frame is planned.
pub type Geometry = plan::Geometry<Resource>;
/// What a shader reads, while the frame is planned.
pub type Binding = plan::Binding<Resource>;
/// A colour attachment while the frame is planned.
pub type ColorTarget = plan::ColorTarget<Resource>;
/// A depth attachment while the frame is planned.
pub type DepthTarget = plan::DepthTarget<Resource>;

impl Pass {
    /// Whether it uses the stencil beside the receivers' depth.
    pub(crate) fn counts(&self) -> bool {
        self.depth.is_some_and(|depth| depth.slot == Resource::RECEIVER_DEPTH && depth.stencil.is_some())
    }
}

/// Collects the passes of one node for one light and one set of receivers, and hands out their textures and buffers.
#[derive(Debug)]
pub struct PassList<'a> {
    pub(crate) snapshot: &'a SceneSnapshot,
    pub(crate) slots: &'a mut Slots,
    pub(crate) notes: &'a mut Vec<String>,
    pub(crate) passes: Vec<Pass>,
    /// Whether passes of earlier nodes multiply the light's visibility.
    pub(crate) visibility_is_touched: bool,
}

impl PassList<'_> {
    /// Adds a pass.
    pub fn pass(&mut self, pass: Pass) {
        self.passes.push(pass);
    }

    /// A texture for the passes of this node.
    pub fn texture(&mut self, desc: TextureDesc<'_>) -> Resource {
        self.slots.texture(desc).into()
    }

    /// A buffer for the passes of this node.
    pub fn buffer(&mut self, desc: BufferDesc<'_>) -> Resource {
        self.slots.buffer(desc).into()
    }

    /// An image of the scene, for [`Binding::Texture`].
    pub fn image(&mut self, image: ImageKey, reason: &str) -> Resource {
        let name = self.snapshot.images.get(&image).map_or("image", |image| &image.name);
        self.slots.image(name, image, reason).into()
    }

    /// Notes something that was left out.
    pub fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }

    /// The depth of the receivers, to be sampled in a pass that does not attach it.
    pub fn receiver_depth(&self) -> Resource {
        Resource(Symbol::ReceiverDepth)
    }

    /// The visible triangle of every pixel, as `texture_2d<u32>`: the index of its instance and its own number in that
    /// instance's mesh; `0xffffffff` where nothing is seen. In the plan only when some pass reads it, or somebody measures.
    pub fn visible_triangles(&self) -> Resource {
        Resource(Symbol::VisibleTriangles)
    }

    /// The plane of the triangle that every pixel shows, as `texture_2d<u32>` for `unpacked_plane` of
    /// `common/receiver_depth`: its unit normal in view space on the eye's side (the triangle's own, not
    /// interpolated), its height over the eye, and the distances of the triangle's nearest and farthest corners, in
    /// metres. All are 0 where nothing is seen or the surface receives no shadows. `on_plane` there finds the visible
    /// point from plane and depth, since depth alone is inaccurate on triangles thinner than a pixel. In the plan
    /// only when some pass reads it.
    pub fn receiver_planes(&self) -> Resource {
        Resource(Symbol::ReceiverPlanes)
    }

    /// Whether an earlier pass multiplies the light's visibility; until one does it is 1 and need not be read.
    pub fn visibility_is_touched(&self) -> bool {
        self.visibility_is_touched || self.passes.iter().any(|pass| pass.draws_into(Resource::VISIBILITY))
    }

    /// Takes out the passes so far, in order, for a technique that wraps another and changes its passes.
    pub fn take_passes(&mut self) -> Vec<Pass> {
        std::mem::take(&mut self.passes)
    }
}
