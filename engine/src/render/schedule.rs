//! The passes of a frame in order, while it is not known yet what all of them together need.

use std::borrow::Cow;

use super::request::{Adapter, FrameRequest};
use super::surfaces::Surfaces;
use crate::plan::{Antialias, DepthId, SlotId, Slots, TextureDesc, TextureFormat};
use crate::scene::SceneSnapshot;
use crate::shadow::{Cache, Pass, Registry, View};

/// What every stage of a frame looks at, and none changes.
#[derive(Clone, Copy)]
pub(super) struct Inputs<'a> {
    pub(super) snapshot: &'a SceneSnapshot,
    pub(super) registry: &'a Registry,
    pub(super) request: &'a FrameRequest,
    pub(super) adapter: &'a Adapter<'a>,
    pub(super) cache: &'a Cache,
    pub(super) view: &'a View,
    pub(super) surfaces: &'a Surfaces,
}

impl Inputs<'_> {
    pub(super) fn is_multisampled(&self) -> bool {
        self.request.antialias == Antialias::Multisample4
    }
}

/// What stages and techniques ask for: textures, buffers, depths, notes.
#[derive(Debug, Default)]
pub(super) struct Needs {
    pub(super) slots: Slots,
    pub(super) depths: Vec<DepthDesc>,
    pub(super) notes: Vec<String>,
}

/// The depth of one set of receivers, which has a stencil where something counts.
#[derive(Clone, Debug)]
pub(super) struct DepthDesc {
    pub(super) name: String,
    pub(super) samples: u32,
    pub(super) reason: &'static str,
}

impl Needs {
    /// The depth of one more set of receivers.
    pub(super) fn depth(&mut self, name: impl Into<String>, samples: u32, reason: &'static str) -> DepthId {
        self.depths.push(DepthDesc { name: name.into(), samples, reason });
        DepthId(self.depths.len() - 1)
    }

    /// A texture of one layer for this frame.
    pub(super) fn texture(
        &mut self,
        name: &str,
        format: TextureFormat,
        size_px: [u32; 2],
        reason: &str,
    ) -> SlotId {
        self.slots.texture(TextureDesc::new(name, format, size_px, reason))
    }

    pub(super) fn note(&mut self, note: impl Into<String>) {
        self.notes.push(note.into());
    }
}

/// What the symbols of a group of passes stand for, and what is said of all its passes.
#[derive(Clone, Debug, Default)]
pub(super) struct Scope {
    /// The receivers' depth.
    pub(super) depth: DepthId,
    /// What the receivers' pixels show.
    pub(super) seen: Seen,
    /// Whether the visibility has a texel for every sample of a pixel.
    pub(super) each_sample: bool,
    /// The layer of the visibility array that the light's factor is in. The first pass that draws into it makes it 1.
    pub(super) visibility: Option<u32>,
    /// Where the passes are, after their names.
    pub(super) place: String,
    /// What they are for, after their reasons.
    pub(super) purpose: &'static str,
}

/// The format of receivers' planes: a horizon is decided by all digits that positions have.
pub(super) const RECEIVER_PLANES: TextureFormat = TextureFormat::Rgba32Uint;

/// What techniques may ask to know about the surface that each pixel shows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seen {
    /// Its instance and triangle.
    pub(super) triangles: Option<SlotId>,
    /// The plane that it lies in.
    pub(super) planes: Option<SlotId>,
    /// Its depth, where that is not the receivers' own: one texel for every sample.
    pub(super) depth: Option<SlotId>,
}

/// Passes that follow one another and name the same things.
#[derive(Debug)]
pub(super) struct Group<'p> {
    pub(super) scope: Scope,
    pub(super) passes: Vec<Cow<'p, Pass>>,
}

impl<'p> Group<'p> {
    pub(super) fn new(scope: &Scope) -> Self {
        Self { scope: scope.clone(), passes: vec![] }
    }

    pub(super) fn push(&mut self, pass: Pass) {
        self.passes.push(Cow::Owned(pass));
    }
}

/// The passes of a frame, in order.
#[derive(Debug, Default)]
pub(super) struct Schedule<'p> {
    pub(super) groups: Vec<Group<'p>>,
}

impl<'p> Schedule<'p> {
    /// Adds one pass.
    pub(super) fn push(&mut self, scope: &Scope, pass: Pass) {
        self.groups.push(Group { scope: scope.clone(), passes: vec![Cow::Owned(pass)] });
    }

    pub(super) fn push_group(&mut self, group: Group<'p>) {
        self.groups.push(group);
    }
}
