//! What passes name while a frame is planned, before it is known what all of them together need.

use super::{
    Access, Binding, BufferUsage, ColorTarget, Contents, DepthTarget, Draw, Geometry, Load, Pass, Slot,
    SlotId, SlotKind,
};
use crate::scene::ImageKey;
use std::sync::Arc;
use wgpu::TextureFormat;

/// A texture or buffer as passes name it while the frame is planned: one that was asked for, or a *symbol* like the
/// receivers' depth. Which texture a symbol stands for depends on the passes that name it (whose receivers, which
/// light's factor), and its format on what all passes of the frame do with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Resource(pub(crate) Symbol);

/// What a [`Resource`] stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Symbol {
    /// A slot that [`Slots`] handed out.
    Slot(SlotId),
    /// The depth of the receivers, with the light's counts in the stencil beside it where something counts.
    ReceiverDepth,
    /// The triangle that every pixel of the receivers shows.
    VisibleTriangles,
    /// The plane of that triangle.
    ReceiverPlanes,
    /// The layer of the visibility array that holds the light's factor.
    Visibility,
    /// All layers of that array.
    AllVisibilities,
    /// The depth of certain receivers.
    DepthOf(DepthId),
}

/// The depth of one set of receivers, by its place among those of the frame; 0 is that of the opaque surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct DepthId(pub(crate) usize);

impl From<SlotId> for Resource {
    fn from(slot: SlotId) -> Self {
        Self(Symbol::Slot(slot))
    }
}

impl DepthId {
    pub(crate) fn resource(self) -> Resource {
        Resource(Symbol::DepthOf(self))
    }
}

impl Resource {
    pub(crate) const RECEIVER_DEPTH: Self = Self(Symbol::ReceiverDepth);
    pub(crate) const VISIBILITY: Self = Self(Symbol::Visibility);
}

impl ColorTarget<Resource> {
    /// The light's visibility, to be multiplied: 1 where nothing has darkened it yet.
    pub const VISIBILITY: Self =
        Self { slot: Resource::VISIBILITY, layer: 0, load: Load::Keep, resolve: None };

    /// Layer 0 of a texture.
    pub fn new(slot: impl Into<Resource>, load: Load) -> Self {
        Self { slot: slot.into(), layer: 0, load, resolve: None }
    }
}

impl DepthTarget<Resource> {
    /// The receivers' depth, to test against: nothing is written. What counts in the stencil beside it stays.
    pub const TEST: Self =
        Self { slot: Resource::RECEIVER_DEPTH, layer: 0, depth: Access::ReadOnly, stencil: None };
    /// The receivers' depth, to test against, and the stencil beside it, to count in: there is
    /// [`STENCIL_AT_REST`](super::STENCIL_AT_REST) where nothing has counted for this light yet, and more is dark.
    pub const COUNT: Self = Self { stencil: Some(Access::Keep), ..Self::TEST };

    /// A texture of depth alone.
    pub fn new(slot: impl Into<Resource>, depth: Access) -> Self {
        Self { slot: slot.into(), layer: 0, depth, stencil: None }
    }
}

/// How long a texture's contents are needed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Lifetime {
    /// Until the frame is done.
    #[default]
    Frame,
    /// Until the passes are done that are planned together with it: the next planner may get the same texture.
    Scratch,
    /// Beyond the frame, under a hash of everything that the contents depend on. The passes that write the texture
    /// run again only for another key, or after a lost device, a failed frame or a short budget. A texture that no
    /// frame names for a while is dropped. Textures of equal name, shape and key are one texture, whoever asks for
    /// them.
    ///
    /// A pass that writes it may write other kept textures, but nothing else. So what such passes hand on to one
    /// another (a mask that is blurred, say) must be kept too, under a key of its own. They may read anything; only
    /// the key tells when they must run again.
    Kept(u64),
}

/// A request for a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureDesc<'a> {
    /// What it is called in the plan's text and in captures: a label, no identity.
    pub name: &'a str,
    /// Texel format.
    pub format: TextureFormat,
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// Array layers.
    pub layers: u32,
    /// Samples of a pixel.
    pub samples: u32,
    /// How long it is needed.
    pub lifetime: Lifetime,
    /// Why the frame needs it.
    pub reason: &'a str,
}

impl<'a> TextureDesc<'a> {
    /// A texture of one layer and one sample for this frame.
    pub fn new(name: &'a str, format: TextureFormat, size_px: [u32; 2], reason: &'a str) -> Self {
        Self { name, format, size_px, layers: 1, samples: 1, lifetime: Lifetime::Frame, reason }
    }
}

/// A request for a buffer.
#[derive(Clone, Debug, PartialEq)]
pub struct BufferDesc<'a> {
    /// What it is called in the plan's text and in captures: a label, no identity.
    pub name: &'a str,
    /// What it is for.
    pub usage: BufferUsage,
    /// A hash of what the contents were computed from; see [`SlotKind::Buffer`].
    pub revision_key: u64,
    /// The contents.
    pub contents: Arc<Vec<u8>>,
    /// Why the frame needs it.
    pub reason: &'a str,
}

impl<'a> BufferDesc<'a> {
    /// A buffer that shaders read.
    pub fn storage(name: &'a str, revision_key: u64, contents: Arc<Vec<u8>>, reason: &'a str) -> Self {
        Self { name, usage: BufferUsage::Storage, revision_key, contents, reason }
    }

    /// A buffer of 32-bit indices.
    pub fn index(name: &'a str, revision_key: u64, contents: Arc<Vec<u8>>, reason: &'a str) -> Self {
        Self { name, usage: BufferUsage::Index, revision_key, contents, reason }
    }
}

/// Hands out the textures and buffers of a plan. Each gets its id once.
#[derive(Clone, Debug, Default)]
pub struct Slots {
    slots: Vec<Slot>,
    /// Scratch textures, and whether the current planner has them.
    scratch: Vec<(SlotId, bool)>,
}

impl Slots {
    /// All of them, each at the place of its id.
    pub(crate) fn into_slots(self) -> Vec<Slot> {
        self.slots
    }

    /// The slot behind `id`.
    pub fn get(&self, id: SlotId) -> &Slot {
        &self.slots[id.0]
    }

    /// A new texture; for [`Lifetime::Scratch`] perhaps one that an earlier planner is done with, for
    /// [`Lifetime::Kept`] the one of the same name, shape and key.
    pub fn texture(&mut self, desc: TextureDesc<'_>) -> SlotId {
        let TextureDesc { name, format, size_px, layers, samples, lifetime, reason } = desc;
        let kind = SlotKind::Texture { format, size_px, layers, samples };
        let kept = if let Lifetime::Kept(key) = lifetime { Some(key) } else { None };
        match lifetime {
            Lifetime::Frame => {}
            Lifetime::Scratch => {
                let slots = &self.slots;
                let fits = |(id, taken): &&mut (SlotId, bool)| !*taken && slots[id.0].kind == kind;
                if let Some((id, taken)) = self.scratch.iter_mut().find(fits) {
                    *taken = true;
                    return *id;
                }
            }
            Lifetime::Kept(_) => {
                let same = |slot: &Slot| slot.kept == kept && slot.name == name && slot.kind == kind;
                if let Some(index) = self.slots.iter().position(same) {
                    return SlotId(index);
                }
            }
        }
        let id = self.add(Slot { name: name.into(), kind, reason: reason.into(), kept });
        if lifetime == Lifetime::Scratch {
            self.scratch.push((id, true));
        }
        id
    }

    /// A buffer; one of equal key and usage is added once.
    pub fn buffer(&mut self, desc: BufferDesc<'_>) -> SlotId {
        let BufferDesc { name, usage, revision_key, contents, reason } = desc;
        let same = |slot: &Slot| matches!(slot.kind, SlotKind::Buffer { usage: u, revision_key: key, .. } if u == usage && key == revision_key);
        if let Some(index) = self.slots.iter().position(same) {
            return SlotId(index);
        }
        let kind = SlotKind::Buffer { usage, revision_key, contents: Contents(contents) };
        self.add(Slot { name: name.into(), kind, reason: reason.into(), kept: None })
    }

    /// An image of the scene; added once, however often it is asked for.
    pub fn image(&mut self, name: &str, image: ImageKey, reason: &str) -> SlotId {
        let kind = SlotKind::Image { image };
        match self.slots.iter().position(|slot| slot.kind == kind) {
            Some(index) => SlotId(index),
            None => self.add(Slot { name: name.into(), kind, reason: reason.into(), kept: None }),
        }
    }

    /// What was planned up to now is done with its scratch textures.
    pub(crate) fn free_scratch(&mut self) {
        self.scratch.iter_mut().for_each(|(_, taken)| *taken = false);
    }

    fn add(&mut self, slot: Slot) -> SlotId {
        self.slots.push(slot);
        SlotId(self.slots.len() - 1)
    }
}

impl<R: Copy> Draw<R> {
    /// The same draw of what `place` says each resource is.
    pub(crate) fn lowered<S>(
        &self,
        place: impl Fn(Binding<R>) -> Binding<S>,
        slot: impl Fn(R) -> S,
    ) -> Draw<S> {
        Draw {
            name: self.name.clone(),
            geometry: self.geometry.lowered(slot),
            state: self.state.clone(),
            bindings: self.bindings.iter().map(|(number, binding)| (*number, place(*binding))).collect(),
            scissor_px: self.scissor_px,
        }
    }
}

impl<R: Copy> Geometry<R> {
    fn lowered<S>(&self, slot: impl Fn(R) -> S) -> Geometry<S> {
        match self.clone() {
            Self::Surfaces { style, parts, vertices } => Geometry::Surfaces { style, parts, vertices },
            Self::PulledSurfaces { shader, style, parts, vertices } => {
                Geometry::PulledSurfaces { shader, style, parts, vertices }
            }
            Self::Indexed { shader, instance, indices, first, count, record } => {
                Geometry::Indexed { shader, instance, indices: slot(indices), first, count, record }
            }
            Self::Numbered { shader, instance, first, count, record } => {
                Geometry::Numbered { shader, instance, first, count, record }
            }
            Self::IndexedProcedural { shader, indices, first, count, record } => {
                Geometry::IndexedProcedural { shader, indices: slot(indices), first, count, record }
            }
            Self::Procedural { shader, vertices, instances } => {
                Geometry::Procedural { shader, vertices, instances }
            }
        }
    }
}

impl<R: Copy + PartialEq> Pass<R> {
    /// Whether it draws into `target`.
    pub(crate) fn draws_into(&self, target: R) -> bool {
        self.colors.iter().any(|color| color.slot == target)
    }

    /// Whether a draw reads `resource`.
    pub(crate) fn reads(&self, resource: R) -> bool {
        let mut bindings = self.draws.iter().flat_map(|draw| &draw.bindings);
        bindings.any(|(_, binding)| binding.resource() == Some(resource))
    }
}
