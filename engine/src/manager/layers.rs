//! Transparent surfaces that shadows fall on, drawn in the order of every pixel.
//!
//! At every pixel the transparent surfaces before the opaque one are ordered by depth, and where surfaces pass through one
//! another each pixel by itself. The *nearest* of them is found first, as a depth of its own. Then the *farther* ones come
//! as layers, from behind: the farthest that is before the last layer and behind the nearest is found, as a depth; the
//! lights' techniques plan for it as they did for the opaque surfaces; it is shaded with their factors and blended over the
//! picture. The nearest comes last. So nothing is blended in a wrong order, and surfaces at one depth, which are in one
//! place and so in one shadow, are one layer, blended in the order of drawing.
//!
//! Where shadows fall on the nearest surface only (Kim, Kim & Turk, section 6), those behind it are blended without shadows,
//! far to near by their middles (see [`super::sorted`]): a depth, a count and a blend is all it adds.
//!
//! Memory does not grow with the number of layers, passes do. There are as many layers as the view may need
//! ([`super::layer_count`]); none of this is in the plan if no technique asks for layers, or nothing transparent is in
//! view. Factors on layers, numbered from the eye, are images on demand: see [`super::layer_images`].

use wgpu::TextureFormat;

use super::assembly::{Assembly, engine_shader};
use super::frame::{Planner, Receivers, Seen};
use super::layer_count::most_layers;
use super::layer_images::LookedAt;
use super::request::{FrameError, FrameRequest};
use super::segments::{Part, Segment};
use super::sorted::Sorted;
use super::states::CLEAR_STENCIL;
use super::surfaces::Surfaces;
use crate::plan::{
    Access, Antialias, Binding, BlendState, ColorTarget, CompareFunction, DepthTarget, Draw, DrawState,
    Geometry, LightPlanned, Load, Pass, PlanBuilder, SlotId, SlotKind, SurfaceStyle,
};
use crate::shadow::{Layer, Layers, hash_of};

/// The most layers a frame draws: each takes its passes, and so does each light on it.
const MAX_LAYERS: u32 = 1024;

/// Transparent surfaces, one at a pixel, and what the lights' techniques planned for them.
pub(super) struct Receiving {
    pub(super) depth: SlotId,
    /// For each light.
    pub(super) segments: Vec<Segment>,
}

/// The layers of a frame.
pub(super) struct Layered {
    nearest: Receiving,
    /// Those behind it, the farthest first; empty where no light's shadows fall on them.
    farther: Vec<Receiving>,
    /// Whether there may be any behind it.
    only_one: bool,
    /// What techniques ask to know about the layer that is being drawn.
    seen: Seen,
    /// Those whose factors were asked for as images, or that lie before such: the nearest first.
    pub(super) looked_at: Vec<LookedAt>,
}

impl Layered {
    /// How many layers are drawn with shadows.
    pub(super) fn count(&self) -> u32 {
        self.farther.len() as u32 + 1
    }

    /// What is planned for each of them, and for each that is looked at.
    pub(super) fn segments(&mut self) -> impl Iterator<Item = &mut Vec<Segment>> {
        let drawn = std::iter::once(&mut self.nearest).chain(&mut self.farther);
        drawn.chain(self.looked_at.iter_mut().map(|layer| &mut layer.receiving)).map(|r| &mut r.segments)
    }

    /// The widest visibility that any light leaves on any layer.
    pub(super) fn widest(&mut self) -> Option<crate::shadow::Channels> {
        self.segments().flatten().filter_map(|segment| segment.visibility).max()
    }
}

impl Planner<'_> {
    /// Plans all lights for every layer of transparent surfaces; `None` where no technique asks for layers or there
    /// is none.
    ///
    /// # Errors
    /// What the techniques refuse; several samples a pixel; more layers than a frame may have.
    pub(super) fn layers(
        &mut self,
        b: &mut PlanBuilder,
        request: &FrameRequest,
        surfaces: &Surfaces,
    ) -> Result<Option<Layered>, FrameError> {
        let lights = self.registry.lights.iter().zip(&self.posed.lights);
        let reaching = lights.filter(|(_, light)| light.may_reach(&self.view.receiver_bounds));
        let claims = reaching.flat_map(|(claims, _)| claims);
        let asks = claims.max_by_key(|claim| claim.technique.receiver_layers());
        let asks = asks.filter(|claim| claim.technique.receiver_layers() != Layers::OpaqueOnly);
        let (Some(claim), false) = (asks, surfaces.transparent.is_empty()) else { return Ok(None) };
        let asked_by = format!("'{}' ({})", claim.node, claim.label);
        if request.antialias == Antialias::Multisample4 {
            return Err(FrameError::MultisampledLayers { asked_by });
        }
        let in_view = self.layer_count(surfaces);
        let layers = match claim.technique.receiver_layers() {
            Layers::All => in_view,
            Layers::First | Layers::OpaqueOnly => in_view.min(1),
        };
        if layers > MAX_LAYERS {
            return Err(FrameError::TooManyLayers { asked_by, layers, limit: MAX_LAYERS });
        }
        if layers == 0 {
            return Ok(None);
        }
        let mut seen = Seen::default();
        let depth = |b: &mut PlanBuilder, name: &str| {
            b.texture(name, TextureFormat::Depth32Float, 1, "where shadows fall on transparent surfaces")
        };
        let nearest = depth(b, "depth of the nearest layer");
        let nearest = self.receiving(b, nearest, Layer::FromEye(0), &mut seen)?;
        let mut farther = Vec::new();
        let names = ["depth of even layers", "depth of odd layers"];
        let depths: Vec<SlotId> = names.iter().take(layers as usize - 1).map(|name| depth(b, name)).collect();
        for (layer, depth) in (1..layers).zip(depths.iter().cycle()) {
            farther.push(self.receiving(b, *depth, Layer::FromBehind(layer - 1), &mut seen)?);
        }
        let looked_at = if request.factors { request.layer_factors.clone() } else { 0..0 };
        let looked_at = self.looked_at(b, looked_at, in_view)?;
        if self.darkens.contains(&true) {
            b.note("lights that darken the finished picture leave transparent layers lit");
        }
        Ok(Some(Layered { nearest, farther, only_one: in_view == 1, seen, looked_at }))
    }

    /// What all lights' techniques plan for one layer.
    pub(super) fn receiving(
        &mut self,
        b: &mut PlanBuilder,
        depth: SlotId,
        layer: Layer,
        seen: &mut Seen,
    ) -> Result<Receiving, FrameError> {
        // What was left out here was left out of the opaque surfaces' passes too.
        let notes = b.notes.len();
        let segments = self.lights(b, Receivers { depth, layer: Some(layer) }, seen)?;
        b.notes.truncate(notes);
        Ok(Receiving { depth, segments })
    }

    /// The most layers at any pixel of this view.
    fn layer_count(&mut self, surfaces: &Surfaces) -> u32 {
        let worn = |(instance, part): &(u32, u32)| {
            let instance = &self.posed.instances[*instance as usize];
            (instance.pose_key, *part, instance.materials[*part as usize].double_sided)
        };
        let worn: Vec<_> = surfaces.transparent.iter().map(worn).collect();
        let key = hash_of(("layers", worn, format!("{:?}", self.view.camera), self.view.size_px));
        let (posed, view) = (self.posed, self.view);
        *self.cache.get_or_compute("layers in view", key, || most_layers(posed, view, &surfaces.transparent))
    }
}

impl Assembly<'_> {
    /// What is blended into while layers are drawn: more digits than a picture of eight bits has, which every layer would
    /// round. The picture itself where it has them, or there are no layers but one.
    pub(super) fn draw_in_layers(&mut self, layers: &Layered) {
        let eight_bits = match self.b.slots[self.drawn.0].kind {
            SlotKind::Texture { format, .. } => format != TextureFormat::Rgba32Float,
            SlotKind::Buffer { .. } | SlotKind::Image { .. } => false,
        };
        if eight_bits && !layers.farther.is_empty() {
            let reason = "blended into layer by layer, in more digits than pictures have";
            self.drawn = self.b.texture("picture in layers", TextureFormat::Rgba16Float, 1, reason);
        }
    }

    /// Blends all layers over what was drawn, from behind, and sees to it that they are in `finished`.
    pub(super) fn draw_layers(
        &mut self,
        mut layers: Layered,
        mask: Option<SlotId>,
        finished: SlotId,
        lights: &mut [LightPlanned],
    ) {
        self.count_on(&mut layers);
        let opaque_depth = self.depth;
        let Layered { nearest, farther, only_one, seen, looked_at } = layers;
        let nearest_depth = nearest.depth;
        self.on_layer("on the nearest layer", |assembly| {
            let reason = "where the nearest transparent surface is";
            assembly.depth_before(nearest_depth, opaque_depth, None, reason);
        });
        if farther.is_empty() && !only_one {
            self.depth = opaque_depth;
            let reason = "all transparent surfaces but the nearest, lit without shadows, far to near";
            let sorted = Sorted { behind: Some(nearest_depth), ..Sorted::all() };
            self.blend("farther surfaces", reason, &sorted);
        }
        let mut behind = opaque_depth;
        for (layer, receiving) in farther.into_iter().enumerate() {
            let depth = receiving.depth;
            self.on_layer(&format!("on layer {layer} from behind"), |assembly| {
                let reason = "the farthest transparent surface before the last layer";
                assembly.depth_before(depth, behind, Some(nearest_depth), reason);
                assembly.shade(receiving, &seen, mask, lights);
            });
            behind = depth;
        }
        self.on_layer("on the nearest layer", |assembly| assembly.shade(nearest, &seen, mask, lights));
        self.depth = opaque_depth;
        self.look_at(looked_at, lights);
        if self.drawn != finished {
            self.round_to(finished);
        }
    }

    /// Adds passes, and says of each what it is on.
    fn on_layer(&mut self, place: &str, add: impl FnOnce(&mut Self)) {
        let first = self.b.passes.len();
        add(self);
        for pass in &mut self.b.passes[first..] {
            pass.name = format!("{} {place}", pass.name);
        }
    }

    /// Gives the depths of layers a stencil where something counts in it.
    fn count_on(&mut self, layers: &mut Layered) {
        let counts = |part: &Part| part.counts;
        let mut segments = layers.segments().flatten();
        if !segments.any(|segment| segment.shaded.iter().chain(&segment.alone).any(counts)) {
            return;
        }
        drop(segments);
        let drawn = std::iter::once(&layers.nearest).chain(&layers.farther);
        for receiving in drawn.chain(layers.looked_at.iter().map(|layer| &layer.receiving)) {
            if let SlotKind::Texture { format, .. } = &mut self.b.slots[receiving.depth.0].kind {
                *format = TextureFormat::Depth32FloatStencil8;
            }
        }
    }

    /// Draws into `depth`, which becomes `self.depth`: of all transparent surfaces before `behind` the nearest, or else the
    /// farthest of those that are behind the `nearest`.
    fn depth_before(&mut self, depth: SlotId, behind: SlotId, nearest: Option<SlotId>, reason: &str) {
        self.depth = depth;
        let mut bindings = vec![(0, Binding::Texture(behind))];
        bindings.extend(nearest.map(|nearest| (9, Binding::Texture(nearest))));
        let (compare, nothing) = match nearest {
            None => (CompareFunction::Greater, 0.0),
            Some(_) => (CompareFunction::Less, 1.0),
        };
        let mut state = DrawState::new(compare, vec![]);
        state.depth_write = true;
        let stencil = self.depth_read().stencil.map(|_| CLEAR_STENCIL);
        self.b.passes.push(Pass {
            name: "depth".into(),
            reason: reason.into(),
            colors: vec![],
            depth: Some(DepthTarget { slot: depth, depth: Access::Clear(nothing), stencil }),
            draws: vec![self.transparent_draw("transparent surfaces", SurfaceStyle::Before, state, bindings)],
        });
    }

    /// Adds the lights' passes for the layer whose depth is `self.depth`, and blends it over the picture.
    fn shade(
        &mut self,
        receiving: Receiving,
        seen: &Seen,
        mask: Option<SlotId>,
        lights: &mut [LightPlanned],
    ) {
        self.depth = receiving.depth;
        let shadowed = receiving.segments.iter().any(Segment::draws);
        if shadowed {
            self.seen_on_layer(seen);
            let mut bits = 0;
            for (segment, light) in receiving.segments.into_iter().zip(&*lights) {
                for part in &segment.shaded {
                    self.passes_of(part, &light.name);
                    if let (Some(mask), true) = (mask, part.is_counted()) {
                        self.b.passes.push(self.resolve_to_mask(&light.name, mask, bits));
                        bits += 1;
                    }
                }
            }
        }
        let factors = if shadowed { self.factor_bindings(mask, lights) } else { vec![] };
        let sorted = Sorted { compare: CompareFunction::Equal, behind: None, factors };
        self.blend("shading", "blended over what is behind it, with the shadows on it", &sorted);
    }

    /// What techniques ask to know about the layer whose depth is `self.depth`.
    pub(super) fn seen_on_layer(&mut self, seen: &Seen) {
        let (name, fragment, flags): (_, _, &[&str]) = match (seen.triangles, seen.normals) {
            (None, None) => return,
            (Some(_), None) => ("visible triangles", "visible_triangle", &[]),
            (None, Some(_)) => ("receiver planes", "receiver_plane", &["PLANES"]),
            (Some(_), Some(_)) => {
                ("visible triangles and receiver planes", "triangle_and_plane", &["PLANES"])
            }
        };
        let nothing = f64::from(u32::MAX);
        let color = |slot, clear| ColorTarget { slot, layer: 0, load: Load::Clear(clear), resolve: None };
        let triangles = seen.triangles.map(|slot| color(slot, [nothing, nothing, 0.0, 0.0]));
        let colors: Vec<_> =
            triangles.into_iter().chain(seen.normals.map(|slot| color(slot, [0.0; 4]))).collect();
        let targets = vec![Some(BlendState::REPLACE); colors.len()];
        let state = DrawState::new(CompareFunction::Equal, targets);
        let mut draw = self.transparent_draw("transparent surfaces", SurfaceStyle::Pulled, state, vec![]);
        draw.shader = Some(engine_shader("surface_measure", flags, "vertex", Some(fragment)));
        self.b.passes.push(Pass {
            name: name.into(),
            reason: "a technique asks what it is that each pixel shows".into(),
            colors,
            depth: Some(self.depth_read()),
            draws: vec![draw],
        });
    }

    /// The finished picture, in the digits it has.
    fn round_to(&mut self, finished: SlotId) {
        let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
        let mut draw = self.resolve_draw("rounded", state);
        draw.shader = Some(engine_shader("layer_images", &[], "fullscreen_vertex", Some("rounded")));
        draw.bindings = vec![(2, Binding::Texture(self.drawn))];
        self.b.passes.push(Pass {
            name: "picture of all layers".into(),
            reason: "in the digits that it was asked for".into(),
            colors: vec![ColorTarget {
                slot: finished,
                layer: 0,
                load: Load::Clear([0.0; 4]),
                resolve: None,
            }],
            depth: None,
            draws: vec![draw],
        });
        self.drawn = finished;
    }

    pub(super) fn transparent_draw(
        &self,
        name: &str,
        style: SurfaceStyle,
        state: DrawState,
        bindings: Vec<(u32, Binding)>,
    ) -> Draw {
        let geometry: Geometry = Surfaces::geometry(self.posed, style, &self.surfaces.transparent);
        Draw { name: name.into(), shader: None, state, geometry, bindings, scissor_px: None }
    }
}
