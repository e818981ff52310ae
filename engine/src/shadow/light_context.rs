//! What a technique gets to know: one light, its casters, the receivers and the view.

use glam::DVec4;

use super::{Apply, Cache, Claim, Layer, ShadowError, culling};
use crate::math::{Aabb, ViewFrustum};
use crate::scene::{CameraSnapshot, Instance, LightSnapshot, SceneSnapshot};

/// The camera of a frame, the frame's size, and what the camera sees.
#[derive(Clone, Debug)]
pub struct View {
    /// The camera.
    pub camera: CameraSnapshot,
    /// Width and height of the picture, in pixels.
    pub size_px: [u32; 2],
    /// Samples of a pixel. With more than one, the light's visibility and the images of what is seen have a texel for every
    /// sample, twice as many as pixels along each side; scissors stay in pixels.
    pub samples: u32,
    /// The camera's frustum.
    pub frustum: ViewFrustum,
    /// The box around every surface that may receive a shadow in this view, in the world. Volumes need not reach
    /// beyond it.
    pub receiver_bounds: Aabb,
}

impl View {
    /// x, y, width and height of the pixels around the images of everything between these points, which are homogeneous in the world;
    /// `None` where that is none. A pixel is added on every side.
    ///
    /// Where some points are behind the near plane, what counts is where the lines between them and the others cross it.
    pub fn pixels_around(&self, points: &[DVec4]) -> Option<[u32; 4]> {
        let [width, height] = self.size_px.map(f64::from);
        let clip_from_world = self.camera.clip_from_world(self.size_px);
        let points: Vec<DVec4> = points.iter().map(|p| clip_from_world * *p).collect();
        // In front of the eye: w > 0 for a perspective camera, and everywhere for an orthographic one. What is nearer than the
        // near plane is not drawn, so a little of it may be left out.
        let least_w = if self.frustum.eye.w > 0.0 { 0.5 * self.camera.projection.near_m() } else { 0.5 };
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let mut add = |p: DVec4| {
            for axis in 0..2 {
                low[axis] = low[axis].min(p[axis] / p.w);
                high[axis] = high[axis].max(p[axis] / p.w);
            }
        };
        for (number, p) in points.iter().enumerate() {
            if p.w >= least_w {
                add(*p);
            }
            for q in &points[..number] {
                if (p.w < least_w) != (q.w < least_w) {
                    let share = (least_w - p.w) / (q.w - p.w);
                    let crossing = *p + (*q - *p) * share;
                    add(crossing.truncate().extend(least_w));
                }
            }
        }
        let pixel = |ndc: f64, size: f64, more: f64| ((ndc * 0.5 + 0.5) * size + more).clamp(0.0, size);
        let (left, right) = (pixel(low[0], width, -1.0).floor(), pixel(high[0], width, 1.0).ceil());
        let (top, bottom) = (pixel(-high[1], height, -1.0).floor(), pixel(-low[1], height, 1.0).ceil());
        let is_something = right > left && bottom > top;
        is_something.then(|| [left, top, right - left, bottom - top].map(|px| px as u32))
    }

    /// The flags under which `place_px` of `common/frame` says where a texel of these images lies.
    pub fn sample_flags(&self) -> &'static [&'static str] {
        if self.samples > 1 { &["EACH_SAMPLE"] } else { &[] }
    }
}

/// The most lights that can have smooth terminators: every instance has a bit for each of them.
pub const MAX_SMOOTH_LIGHTS: usize = 32;

/// One light, as the technique of one node sees it while it plans.
#[derive(Clone, Copy, Debug)]
pub struct LightContext<'a> {
    /// The scene.
    pub snapshot: &'a SceneSnapshot,
    /// The view.
    pub view: &'a View,
    /// The adapter's features.
    pub features: wgpu::Features,
    /// The adapter's name, for errors.
    pub adapter: &'a str,
    /// Results that persist between frames.
    pub cache: &'a Cache,
    pub(crate) light_index: usize,
    pub(crate) claim: &'a Claim,
    pub(crate) layer: Option<Layer>,
    pub(crate) is_beside_size: bool,
    pub(crate) counts_before: CountsBefore,
}

/// Bounds on what others have counted in the stencil so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct CountsBefore {
    /// For this light.
    pub(crate) light: u32,
    /// For all lights that darken the finished picture once.
    pub(crate) darkening: u32,
}

impl<'a> LightContext<'a> {
    /// The light.
    pub fn light(&self) -> &'a LightSnapshot {
        &self.snapshot.lights[self.light_index]
    }

    /// The light's number: its place in [`SceneSnapshot::lights`] and in the `lights` of `common/lights`.
    pub fn light_index(&self) -> usize {
        self.light_index
    }

    /// The shadow node's name.
    pub fn node(&self) -> &'a str {
        &self.claim.node
    }

    /// The casters: (index into [`SceneSnapshot::instances`], instance).
    pub fn casters(&self) -> impl Iterator<Item = (usize, &'a Instance)> + use<'a> {
        let snapshot = self.snapshot;
        self.claim.casters.iter().map(move |index| (*index, &snapshot.instances[*index]))
    }

    /// The receivers the node names: (index into [`SceneSnapshot::instances`], instance).
    pub fn receivers(&self) -> impl Iterator<Item = (usize, &'a Instance)> + use<'a> {
        let snapshot = self.snapshot;
        self.claim.receivers.iter().map(move |index| (*index, &snapshot.instances[*index]))
    }

    /// Whether a caster within `bounds` may shadow something in view.
    ///
    /// # Errors
    /// The reason, for a note, where it certainly cannot.
    pub fn may_shadow(&self, bounds: &Aabb) -> Result<(), &'static str> {
        culling::may_shadow(self.view, self.light(), bounds)
    }

    /// Which of the transparent surfaces at each pixel the receivers are; `None` for the opaque surfaces. Techniques
    /// that ask for layers ([`Traits::receiver_layers`](super::Traits)) are called for the opaque
    /// surfaces first. Where a pixel has no such surface, depth is 0 for [`Layer::FromEye`], 1 for
    /// [`Layer::FromBehind`].
    ///
    /// Layers hide nothing: of a layer's pixel, opaque casters nearer to the eye than the layer are not in view, and
    /// transparent ones may be.
    pub fn layer(&self) -> Option<Layer> {
        self.layer
    }

    /// Whether some technique that serves this light gives it a size. A surface that is turned away from the light's
    /// centre may then still see a part of it: what other techniques leave there counts, and a surface must not be
    /// darkened by what lies in its own plane.
    pub fn has_size(&self) -> bool {
        self.is_beside_size || self.claim.light_size().is_wide(self.light().position)
    }

    /// Whether another node that serves this light gives it a size. That node then has the horizon in its factor
    /// ([`Contribution::own_shadow`](super::Contribution::own_shadow)), and the engine darkens no surface for being turned away:
    /// a technique for lights with a size must darken those that see nothing of its own disc.
    pub fn is_beside_size(&self) -> bool {
        self.is_beside_size
    }

    /// An upper bound on what other nodes have counted in the stencil so far: for this light, or, where `apply` is
    /// [`Apply::DarkenOnce`](super::Apply::DarkenOnce), for all lights that darken the picture once. A technique must
    /// fold first if the sum of this and its own bound exceeds 223.
    pub fn counts_before(&self, apply: Apply) -> u32 {
        match apply {
            Apply::DarkenOnce { .. } => self.counts_before.darkening,
            Apply::Light { .. } | Apply::DarkenPicture { .. } => self.counts_before.light,
        }
    }

    /// Whether this is one of the lights that can have smooth terminators: the first [`MAX_SMOOTH_LIGHTS`] of the scene.
    pub fn can_smooth_terminators(&self) -> bool {
        self.light_index < MAX_SMOOTH_LIGHTS
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
            technique: self.claim.type_name,
            needed: format!("{needed:?} ({purpose})"),
            adapter: self.adapter.into(),
        })
    }

    /// The error by which a technique refuses this node for `reason`.
    pub fn unsupported(&self, reason: impl Into<String>) -> ShadowError {
        ShadowError::Unsupported {
            node: self.claim.node.clone(),
            technique: self.claim.type_name,
            reason: reason.into(),
        }
    }
}
