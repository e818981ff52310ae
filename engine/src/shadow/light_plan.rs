//! What a technique gets to work with: one light, its casters, the view, and the plan in the making.

use std::sync::Arc;

use wgpu::TextureFormat;

use super::{Cache, Claim, Layer, ShadowError, culling};
use crate::math::{Aabb, ViewFrustum};
use crate::plan::{
    Access, BufferUsage, ColorTarget, DepthTarget, Load, Pass, PlanBuilder, SlotId, SlotKind, taken,
};
use crate::scene::{ImageKey, Instance, Posed, PosedCamera, PosedLight};

/// From where, and how large, the frame is seen.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera.
    pub camera: PosedCamera,
    /// Width and height of the picture, in pixels.
    pub size_px: [u32; 2],
    /// What the camera sees.
    pub frustum: ViewFrustum,
    /// The box around every surface that may receive a shadow in this view, in the world. Where it ends, volumes
    /// may end too.
    pub receiver_bounds: Aabb,
}

/// Channels of a visibility target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channels {
    /// One value for all colours.
    One,
    /// Red, green and blue apart.
    Rgb,
}

/// The format of [`LightPlan::receiver_planes`]: a horizon is decided by all digits that positions have.
const RECEIVER_PLANES: TextureFormat = TextureFormat::Rgba32Uint;

/// The lights that may have smooth terminators: a bit for each of them goes with every instance.
pub const MAX_SMOOTH_LIGHTS: usize = 32;

impl Channels {
    /// The format of visibility targets that hold these.
    pub fn format(self) -> TextureFormat {
        match self {
            Self::One => TextureFormat::R16Float,
            Self::Rgb => TextureFormat::Rgba16Float,
        }
    }
}

/// The frame plan as one technique sees it while it serves one light.
#[derive(Debug)]
pub struct LightPlan<'a> {
    /// The scene.
    pub posed: &'a Posed,
    /// The view.
    pub view: &'a View,
    /// What the adapter can do.
    pub features: wgpu::Features,
    /// The adapter's name, for errors.
    pub adapter: &'a str,
    /// Results that persist between frames.
    pub cache: &'a mut Cache,
    pub(crate) light_index: usize,
    pub(crate) claim: &'a Claim,
    pub(crate) builder: &'a mut PlanBuilder,
    pub(crate) depth: SlotId,
    pub(crate) visibility: SlotId,
    pub(crate) uses_counts: &'a mut bool,
    pub(crate) uses_visibility: &'a mut Option<Channels>,
    pub(crate) counts_bound: &'a mut u32,
    pub(crate) visibility_layer: u32,
    /// The one darkening of this frame, and whether this light's counts go into it.
    pub(crate) darkening: &'a mut Option<Darkening>,
    pub(crate) darkens: &'a mut bool,
    pub(crate) smooth_terminators: &'a mut Vec<u32>,
    pub(crate) visible_triangles: &'a mut Option<SlotId>,
    pub(crate) receiver_planes: &'a mut Option<SlotId>,
    pub(crate) own_shadow: &'a mut bool,
    pub(crate) has_size: bool,
    /// What the picture loses where this claim's factor is 0, and whether the finished picture does, not the light.
    pub(crate) taken: &'a mut [f32; 3],
    pub(crate) darkens_apart: &'a mut bool,
    pub(crate) layer: Option<Layer>,
}

/// The one darkening of a frame's finished picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Darkening {
    /// How much of the picture's light is taken away, from 0 to 1.
    pub(crate) weight: f64,
    /// The node that asked first.
    pub(crate) node: String,
    /// Its technique.
    pub(crate) technique: &'static str,
    /// A bound on the counts of all lights together.
    pub(crate) bound: u32,
}

impl<'a> LightPlan<'a> {
    /// The light.
    pub fn light(&self) -> &'a PosedLight {
        &self.posed.lights[self.light_index]
    }

    /// The light's number: its place in [`Posed::lights`] and in the `lights` of `common/lights`.
    pub fn light_index(&self) -> usize {
        self.light_index
    }

    /// The shadow node's name.
    pub fn node(&self) -> &'a str {
        &self.claim.node
    }

    /// The casters: (index into [`Posed::instances`], instance).
    pub fn casters(&self) -> impl Iterator<Item = (usize, &'a Instance)> + use<'a> {
        let posed = self.posed;
        self.claim.casters.iter().map(move |index| (*index, &posed.instances[*index]))
    }

    /// The receivers the node names: (index into [`Posed::instances`], instance).
    pub fn receivers(&self) -> impl Iterator<Item = (usize, &'a Instance)> + use<'a> {
        let posed = self.posed;
        self.claim.receivers.iter().map(move |index| (*index, &posed.instances[*index]))
    }

    /// Whether a caster within `bounds` may shadow something in view; the reason when it certainly does not.
    ///
    /// # Errors
    /// The reason why it cannot matter, for a note.
    pub fn may_shadow(&self, bounds: &Aabb) -> Result<(), &'static str> {
        culling::may_shadow(self.view, self.light(), bounds)
    }

    /// Which of the transparent surfaces at each pixel the receivers are; `None` for the opaque surfaces. Techniques
    /// that ask for layers ([`ShadowTechnique::receiver_layers`](super::ShadowTechnique)) are called for the opaque
    /// surfaces first. Where a pixel has no such surface, depth is 0 for [`Layer::FromEye`], 1 for
    /// [`Layer::FromBehind`].
    ///
    /// Layers hide nothing: of a layer's pixel, opaque casters nearer to the eye than the layer are not in view, and
    /// transparent ones may be.
    pub fn layer(&self) -> Option<Layer> {
        self.layer
    }

    /// The depth of the receivers, for sampling in a pass that does not attach it.
    pub fn receiver_depth(&self) -> SlotId {
        self.depth
    }

    /// The visible triangle of every pixel, as `texture_2d<u32>`: the index of its instance and its own number in that
    /// instance's mesh; `0xffffffff` where nothing is seen. In the plan only when some technique calls this, or
    /// somebody measures.
    pub fn visible_triangles(&mut self) -> SlotId {
        let builder = &mut *self.builder;
        *self.visible_triangles.get_or_insert_with(|| {
            let reason = "a technique asks which triangle each pixel shows";
            builder.texture("visible triangles", TextureFormat::Rg32Uint, 1, reason)
        })
    }

    /// The plane of the triangle that every pixel shows, as `texture_2d<u32>`: what `unpacked_plane` of
    /// `common/receiver_depth` reads. There are its unit normal in view space on the eye's side (the triangle's own, not one
    /// blended between vertices), how high it is over the eye, and how far the triangle's nearest and farthest corners are, in
    /// metres; these are 0 where the surface does not receive shadows or nothing is seen. `on_plane` there says where the visible
    /// point is by plane and depth together: depth alone is badly known on triangles thinner than a pixel. In the plan only when
    /// some technique calls this.
    pub fn receiver_planes(&mut self) -> SlotId {
        let builder = &mut *self.builder;
        *self.receiver_planes.get_or_insert_with(|| {
            let reason = "a technique asks in which plane each pixel's surface lies";
            builder.texture("receiver planes", RECEIVER_PLANES, 1, reason)
        })
    }

    /// Says that what this technique leaves in the light's visibility holds the receiver's own shadow too: what part of
    /// the light lies beyond the horizon of the surface. Nothing else darkens surfaces then for being turned away from
    /// the light's centre, neither in pictures, beyond the cosine of their normals, nor in factors, whatever other
    /// techniques serve the light: a light's factor is the product of what they leave, and the horizon is in one of
    /// them. Without effect when the technique adds no pass that writes the light's visibility.
    pub fn decides_own_shadow(&mut self) {
        *self.own_shadow = true;
    }

    /// Whether some technique that serves this light takes it to have a size. Then a surface that is turned away from the
    /// light's centre may still see a part of it: what other techniques leave there counts, and the surface's own plane is
    /// to darken nothing.
    pub fn has_size(&self) -> bool {
        self.has_size
    }

    /// The attachment for a pass that tests against the receivers' depth and leaves depth and stencil alone.
    pub fn test_depth(&self) -> DepthTarget {
        // Whether there is a stencil is known when all lights are planned; the frame is put together with it.
        DepthTarget { slot: self.depth, depth: Access::ReadOnly, stencil: None }
    }

    /// The attachment for a pass that counts in the stencil: receivers' depth read-only, the stencil written. The
    /// stencil holds [`STENCIL_AT_REST`](crate::plan::STENCIL_AT_REST) where nothing has counted for this light yet; more than that
    /// is dark.
    ///
    /// `bound` is an upper bound on what this technique adds to any pixel's final count. Returned with the
    /// attachment is the bound on what was there before: a technique whose sum would exceed 223 folds first.
    pub fn count_in_stencil(&mut self, bound: u32) -> (DepthTarget, u32) {
        if let SlotKind::Texture { format, .. } = &mut self.builder.slots[self.depth.0].kind {
            *format = TextureFormat::Depth32FloatStencil8;
        }
        let before = self.counts_before();
        let sum = before.saturating_add(bound);
        match self.darkening {
            Some(darkening) if *self.darkens => darkening.bound = sum,
            _ => {
                *self.uses_counts = true;
                *self.counts_bound = sum;
            }
        }
        (DepthTarget { slot: self.depth, depth: Access::ReadOnly, stencil: Some(Access::Keep) }, before)
    }

    /// The bound on what others have counted in the stencil for this light so far; after
    /// [`LightPlan::darken_once`], for all lights that it was called for.
    pub fn counts_before(&self) -> u32 {
        match &*self.darkening {
            Some(darkening) if *self.darkens => darkening.bound,
            _ => *self.counts_bound,
        }
    }

    /// Has this light's counts put together with those of all other lights for which this is called: the light is
    /// shaded as if nothing shadowed it, and where the sum of all counts is not zero, the finished picture is
    /// darkened, once, by `weight`. (No count is negative, so they do not cancel.) Called before anything is counted.
    /// A factor that is asked for is still the light's own.
    ///
    /// # Errors
    /// [`ShadowError::WeightsDiffer`] when another node of the frame asked for another weight.
    pub fn darken_once(&mut self, weight: f64) -> Result<(), ShadowError> {
        let technique = self.claim.technique.type_name();
        let own = Darkening { weight, node: self.claim.node.clone(), technique, bound: 0 };
        let darkening = self.darkening.get_or_insert(own);
        if darkening.weight != weight {
            return Err(ShadowError::WeightsDiffer {
                first: darkening.node.clone(),
                first_weight: darkening.weight,
                second: self.claim.node.clone(),
                second_weight: weight,
            });
        }
        *self.darkens = true;
        Ok(())
    }

    /// Weights and colours this node's shadow in the picture, channel by channel: the light is multiplied by
    /// 1 − weight · (1 − factor) · (1 − colour), for each node that serves it. `color` is linear red, green and blue;
    /// both are confined to 0 … 1. The factor that is asked for is never weighted. (With four samples a pixel, where
    /// shadow edges of two nodes of different weights cross within a pixel, it gets the product of their means.)
    pub fn tint(&mut self, weight: f64, color: [f64; 3]) {
        *self.taken = taken(weight, color);
    }

    /// Has the light shaded as if nothing shadowed it, and the finished picture multiplied by
    /// 1 − weight · (1 − factor) · (1 − colour), with this node's factor, be it counted or in the visibility; for one
    /// node and light after the other (the black rectangle over the screen of the second method of paper 002 §6.4). Highlights of
    /// lights that are blocked stay, darkened. The factor that is asked for is not changed. Weight and colour as for
    /// [`LightPlan::tint`], which has no effect then. A light whose shadows darken the picture for one node does so for
    /// all of its nodes, or the frame is refused.
    pub fn darken_picture(&mut self, weight: f64, color: [f64; 3]) {
        *self.taken = taken(weight, color);
        *self.darkens_apart = true;
    }

    /// Has instance number `instance` shaded by its normals alone where it turns away from this light: the technique
    /// leaves what is there undecided. For pictures; in factors, what is turned away stays dark. False, and nothing is
    /// changed, beyond the first [`MAX_SMOOTH_LIGHTS`] lights of a scene.
    #[must_use]
    pub fn smooth_terminator(&mut self, instance: usize) -> bool {
        let possible = self.light_index < MAX_SMOOTH_LIGHTS;
        self.smooth_terminators.extend(possible.then_some(instance as u32));
        possible
    }

    /// The target for a pass that multiplies visibility: 1 where nothing has darkened it yet.
    pub fn multiply_visibility(&mut self, channels: Channels) -> ColorTarget {
        let load = if self.uses_visibility.is_none() { Load::Clear([1.0; 4]) } else { Load::Keep };
        *self.uses_visibility = (*self.uses_visibility).max(Some(channels));
        ColorTarget { slot: self.visibility, layer: self.visibility_layer, load, resolve: None }
    }

    /// Adds a buffer; see [`PlanBuilder::buffer`].
    pub fn buffer(
        &mut self,
        name: &str,
        usage: BufferUsage,
        revision_key: u64,
        contents: Arc<Vec<u8>>,
        reason: &str,
    ) -> SlotId {
        self.builder.buffer(name, usage, revision_key, contents, reason)
    }

    /// Adds a texture of its own size; see [`PlanBuilder::texture_sized`].
    pub fn texture(
        &mut self,
        name: &str,
        format: TextureFormat,
        size_px: [u32; 2],
        layers: u32,
        reason: &str,
    ) -> SlotId {
        self.builder.texture_sized(name, format, size_px, layers, reason)
    }

    /// Adds a texture for passes that follow each other, or takes the one that others of this name, format, size and
    /// layers are done with; see [`PlanBuilder::scratch_texture`]. Its first pass clears it.
    pub fn scratch_texture(
        &mut self,
        name: &str,
        format: TextureFormat,
        size_px: [u32; 2],
        layers: u32,
        reason: &str,
    ) -> SlotId {
        self.builder.scratch_texture(name, format, size_px, layers, reason)
    }

    /// Adds a texture whose contents outlive the frame: once drawn for `revision_key`, a hash of everything that its
    /// contents depend on, the passes that write it run again only when another key is asked for, or the device was
    /// lost, a frame failed or the budget was short. A texture that no frame names for a while is dropped. Names need not
    /// differ between lights or nodes.
    ///
    /// A pass that writes it may write other kept textures, but nothing else; what such passes hand on to one another
    /// (a mask that is blurred, say) is therefore kept too, under a key of its own. They may read anything; only the
    /// key says when what they read has changed.
    pub fn kept_texture(
        &mut self,
        name: &str,
        format: TextureFormat,
        size_px: [u32; 2],
        layers: u32,
        revision_key: u64,
        reason: &str,
    ) -> SlotId {
        self.builder.kept_texture(name, format, size_px, layers, revision_key, reason)
    }

    /// A texture as large as what is drawn that this technique clears and is done with in its own passes: lights and
    /// layers share it; see [`PlanBuilder::scratch`].
    pub fn scratch(&mut self, name: &str, format: TextureFormat, reason: &str) -> SlotId {
        self.builder.scratch(name, format, reason)
    }

    /// Adds an image of the scene for [`crate::plan::Binding::Texture`]; see [`PlanBuilder::image`].
    pub fn image(&mut self, image: ImageKey, reason: &str) -> SlotId {
        let name = self.posed.images.get(&image).map_or("image", |image| &image.name);
        self.builder.image(name, image, reason)
    }

    /// Adds a pass.
    pub fn pass(&mut self, pass: Pass) {
        self.builder.passes.push(pass);
    }

    /// The passes that techniques have added for this light so far, in order: what a technique that wraps another may
    /// still change.
    pub fn passes_mut(&mut self) -> &mut [Pass] {
        &mut self.builder.passes
    }

    /// Notes something that was left out.
    pub fn note(&mut self, note: impl Into<String>) {
        self.builder.note(note);
    }

    /// Checks that the adapter has `needed`.
    ///
    /// # Errors
    /// [`ShadowError::MissingFeature`] with `purpose` in its text.
    pub fn require(&self, needed: wgpu::Features, purpose: &str) -> Result<(), ShadowError> {
        if self.features.contains(needed) {
            return Ok(());
        }
        Err(ShadowError::MissingFeature {
            node: self.claim.node.clone(),
            technique: self.claim.technique.type_name(),
            needed: format!("{needed:?} ({purpose})"),
            adapter: self.adapter.into(),
        })
    }

    /// A refusal of this node for `reason`.
    pub fn unsupported(&self, reason: impl Into<String>) -> ShadowError {
        ShadowError::Unsupported {
            node: self.claim.node.clone(),
            technique: self.claim.technique.type_name(),
            reason: reason.into(),
        }
    }
}
