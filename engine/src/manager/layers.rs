//! Transparent surfaces that shadows fall on, drawn layer by layer.
//!
//! At every pixel the transparent surfaces before the opaque one are ordered by depth, and where surfaces pass through
//! one another each pixel by itself. A *layer* is the n-th of them at every pixel, nearest first. The next layer is peeled
//! off (the nearest surface behind the last one), the lights' techniques plan for its depth as they did for the opaque
//! surfaces, and it is shaded. What the layers before it let pass is kept as a product of red, green and blue, so that
//! in the end light of layers + product · opaque picture is the finished one: nothing is blended in a wrong order.
//!
//! Where shadows fall on the nearest surface only, there is one layer: see [`super::nearest_layer`].
//!
//! Memory does not grow with the number of layers, passes do. There are as many layers as the view may need
//! ([`super::layer_count`]); none of this is in the plan if no technique asks for layers, or nothing transparent is in view.

use wgpu::TextureFormat;

use super::assembly::{Assembly, engine_shader};
use super::frame::{Planner, Receivers, Seen};
use super::layer_count::most_layers;
use super::request::{FrameError, FrameRequest};
use super::segments::{Part, Segment};
use super::surfaces::Surfaces;
use crate::plan::{
    Access, Antialias, Binding, BlendComponent, BlendFactor, BlendOperation, BlendState, ColorTarget,
    CompareFunction, DepthTarget, Draw, DrawState, FactorAt, Geometry, LightPlanned, Load, MULTIPLY, Pass,
    PlanBuilder, SlotId, SlotKind, SurfaceStyle,
};
use crate::shadow::{Layers, hash_of};

/// How far the numbers of a layer's factors lie behind those of an opaque surface's: see [`SurfaceStyle::Layer`].
const LAYER_COUNTS: u32 = 5;

/// The most layers a frame draws: each takes its passes, and so does each light on it.
const MAX_LAYERS: u32 = 1024;

/// The layers of a frame and what the lights' techniques planned for them.
#[derive(Default)]
pub(super) struct Layered {
    /// The depth of even and of odd layers.
    pub(super) depths: Vec<SlotId>,
    /// For each layer its instance and triangle at every pixel, where these are drawn.
    pub(super) triangles: Vec<Option<SlotId>>,
    /// Those that were asked for.
    pub(super) kept_triangles: Vec<SlotId>,
    /// The normals of the layer that is being drawn, when a technique asks for them.
    normals: Option<SlotId>,
    /// For each layer, for each light.
    pub(super) segments: Vec<Vec<Segment>>,
    /// Whether no light's shadows fall on any but the first.
    pub(super) nearest_only: bool,
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
        let looked_at = if request.factors { request.layer_factors.end } else { 0 };
        let nearest_only = claim.technique.receiver_layers() == Layers::First;
        let mut layers = self.layer_count(surfaces);
        if nearest_only {
            // Further ones are peeled off only to be looked at.
            layers = layers.min(looked_at.max(1));
        }
        if layers > MAX_LAYERS {
            return Err(FrameError::TooManyLayers { asked_by, layers, limit: MAX_LAYERS });
        }
        if layers == 0 {
            return Ok(None);
        }
        let mut layered = Layered { nearest_only, ..Layered::default() };
        for parity in ["even", "odd"].iter().take(layers as usize) {
            let reason = "where shadows fall on transparent surfaces, layer by layer";
            let name = format!("depth of {parity} layers");
            layered.depths.push(b.texture(&name, TextureFormat::Depth32Float, 1, reason));
        }
        let mut reused = [None; 2];
        for layer in 0..layers {
            let kept = request.factors && request.layer_factors.contains(&layer);
            // Where the nearest layer is all there is, its depth says which it is.
            let triangles =
                (!nearest_only || looked_at > 0).then(|| self.layer_triangles(b, layer, kept, &mut reused));
            layered.triangles.push(triangles);
            layered.kept_triangles.extend(triangles.filter(|_| kept));
            let depth = layered.depths[layer as usize % 2];
            // What was left out here was left out of the opaque surfaces' passes too.
            let notes = b.notes.len();
            let receivers = Receivers { depth, layer: Some(layer) };
            let mut seen = Seen { triangles, normals: layered.normals };
            layered.segments.push(self.lights(b, receivers, &mut seen)?);
            layered.normals = seen.normals;
            b.notes.truncate(notes);
        }
        if self.darkens.contains(&true) {
            b.note("lights that darken the finished picture leave transparent layers lit");
        }
        Ok(Some(layered))
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

    /// Where instance and triangle of a layer are drawn: what even and what odd layers share, unless they are kept.
    fn layer_triangles(
        &self,
        b: &mut PlanBuilder,
        layer: u32,
        kept: bool,
        reused: &mut [Option<SlotId>; 2],
    ) -> SlotId {
        let format = TextureFormat::Rg32Uint;
        if kept {
            return b.texture(&format!("triangles of layer {layer}"), format, 1, "asked for");
        }
        let (parity, name) = match layer % 2 {
            0 => (0, "triangles of even layers"),
            _ => (1, "triangles of odd layers"),
        };
        let reason = "of two surfaces at one depth each is a layer";
        *reused[parity].get_or_insert_with(|| b.texture(name, format, 1, reason))
    }
}

impl Assembly<'_> {
    /// What the opaque picture is drawn into before layers are put over it.
    pub(super) fn picture_behind_layers(&mut self) -> SlotId {
        let format = match self.b.slots[self.drawn.0].kind {
            SlotKind::Texture { format, .. } => format,
            SlotKind::Buffer { .. } | SlotKind::Image { .. } => TextureFormat::Rgba8UnormSrgb,
        };
        self.b.texture("picture behind layers", format, 1, "what is opaque, seen through the layers")
    }

    /// Draws all layers, nearest first, and puts them over what was drawn, into `finished`.
    pub(super) fn draw_layers(
        &mut self,
        mut layers: Layered,
        mask: Option<SlotId>,
        finished: SlotId,
        lights: &mut [LightPlanned],
    ) {
        self.count_on(&layers);
        let half = TextureFormat::Rgba16Float;
        let passed = self.b.texture("passed by layers", half, 1, "what all layers so far let pass");
        let light = self.b.texture("light of layers", half, 1, "what they add themselves");
        let clear =
            |slot, value: f64| ColorTarget { slot, layer: 0, load: Load::Clear([value; 4]), resolve: None };
        self.b.passes.push(Pass {
            name: "no layer yet".into(),
            reason: "everything passes, nothing is added".into(),
            colors: vec![clear(passed, 1.0), clear(light, 0.0)],
            depth: None,
            draws: vec![],
        });
        let opaque_depth = self.depth;
        let mut last = None;
        for layer in 0..layers.segments.len() {
            let first_pass = self.b.passes.len();
            let shadowed = self.layer(&mut layers, layer, (opaque_depth, last), mask, lights);
            let Some(triangles) = layers.triangles[layer] else { continue };
            // At the numbers that layers' draws have for them.
            let factors = if shadowed { self.factor_bindings(mask, lights) } else { vec![] };
            let factors =
                factors.into_iter().map(|(number, binding)| (number + LAYER_COUNTS, binding)).collect();
            self.shade_layer(triangles, (passed, light), factors);
            for pass in &mut self.b.passes[first_pass..] {
                pass.name += &format!(" on layer {layer}");
            }
            last = Some((self.depth, triangles));
        }
        self.depth = opaque_depth;
        let mut draw = self
            .resolve_draw("over", DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]));
        draw.shader = Some(engine_shader("layer_images", &[], "fullscreen_vertex", Some("over")));
        draw.bindings =
            [(2, self.drawn), (3, passed), (4, light)].map(|(n, slot)| (n, Binding::Texture(slot))).into();
        self.b.passes.push(Pass {
            name: "layers over the picture".into(),
            reason: "what passes all layers, and their own light".into(),
            colors: vec![clear(finished, 0.0)],
            depth: None,
            draws: vec![draw],
        });
        self.drawn = finished;
    }

    /// Gives the depths of layers a stencil where something counts in it.
    pub(super) fn count_on(&mut self, layers: &Layered) {
        let mut parts =
            layers.segments.iter().flatten().flat_map(|segment| segment.shaded.iter().chain(&segment.alone));
        if parts.any(|part| part.counts) {
            for depth in &layers.depths {
                if let SlotKind::Texture { format, .. } = &mut self.b.slots[depth.0].kind {
                    *format = TextureFormat::Depth32FloatStencil8;
                }
            }
        }
    }

    /// Finds layer number `layer` behind the `last` one and plans all lights for it; says whether any shadow falls on it.
    /// `self.depth` is its depth then.
    pub(super) fn layer(
        &mut self,
        layers: &mut Layered,
        layer: usize,
        (opaque_depth, last): (SlotId, Option<(SlotId, SlotId)>),
        mask: Option<SlotId>,
        lights: &mut [LightPlanned],
    ) -> bool {
        let (triangles, segments) = (layers.triangles[layer], std::mem::take(&mut layers.segments[layer]));
        self.depth = layers.depths[layer % 2];
        match triangles {
            Some(triangles) => self.peel(opaque_depth, last, triangles),
            None => self.nearest_depth(opaque_depth),
        }
        let draws = |part: &Part| part.passes.iter().any(|pass| !pass.draws.is_empty());
        let shadowed = segments.iter().any(|segment| segment.shaded.iter().any(draws));
        if let (Some(normals), true) = (layers.normals, shadowed) {
            self.layer_normals(normals);
        }
        self.shadows_on_layer((layer as u32, triangles), (segments, shadowed), mask, lights);
        shadowed
    }

    /// Finds the next layer: its depth into `self.depth`, instance and triangle into `triangles`.
    fn peel(&mut self, opaque_depth: SlotId, last: Option<(SlotId, SlotId)>, triangles: SlotId) {
        let mut flags = vec!["BASE_COLOR_TEXTURE", "SECOND_UV"];
        let mut bindings = vec![(3, Binding::Texture(opaque_depth))];
        if let Some((last_depth, last_triangles)) = last {
            flags.push("BEHIND");
            bindings.extend([(4, Binding::Texture(last_depth)), (5, Binding::Texture(last_triangles))]);
        }
        let mut state = DrawState::new(CompareFunction::Greater, vec![Some(BlendState::REPLACE)]);
        state.depth_write = true;
        let shader = engine_shader("surface_peel", &flags, "vertex", Some("peel"));
        let stencil = self.depth_read().stencil.map(|_| Access::Clear(0.0));
        let nothing = f64::from(u32::MAX);
        self.b.passes.push(Pass {
            name: "peel".into(),
            reason: "the nearest transparent surface behind the last layer".into(),
            colors: vec![ColorTarget {
                slot: triangles,
                layer: 0,
                load: Load::Clear([nothing, nothing, 0.0, 0.0]),
                resolve: None,
            }],
            depth: Some(DepthTarget { slot: self.depth, depth: Access::Clear(0.0), stencil }),
            draws: vec![Draw {
                shader: Some(shader),
                ..self.transparent_draw("transparent surfaces", SurfaceStyle::PulledMasked, state, bindings)
            }],
        });
    }

    /// The normals of the layer whose depth is `self.depth`.
    fn layer_normals(&mut self, normals: SlotId) {
        let state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
        let shader = engine_shader("surface_measure", &["NORMALS"], "vertex", Some("receiver_normal"));
        let load = Load::Clear([0.0; 4]);
        self.b.passes.push(Pass {
            name: "receiver normals".into(),
            reason: "a technique asks which way each pixel's surface faces".into(),
            colors: vec![ColorTarget { slot: normals, layer: 0, load, resolve: None }],
            depth: Some(self.depth_read()),
            draws: vec![Draw {
                shader: Some(shader),
                ..self.transparent_draw("transparent surfaces", SurfaceStyle::Pulled, state, vec![])
            }],
        });
    }

    /// The passes of every light for one layer; factor images where they were asked for.
    fn shadows_on_layer(
        &mut self,
        (layer, triangles): (u32, Option<SlotId>),
        (segments, shadowed): (Vec<Segment>, bool),
        mask: Option<SlotId>,
        lights: &mut [LightPlanned],
    ) {
        let kept = self.request.factors && self.request.layer_factors.contains(&layer);
        let triangles = triangles.filter(|_| kept);
        let mut bits = 0;
        for (segment, light) in segments.into_iter().zip(lights) {
            let name = &light.name;
            let wanted = triangles.filter(|_| segment.claimed);
            let mut image = None;
            if let (Some(part), Some(triangles), true) = (segment.alone, wanted, shadowed) {
                self.passes_of(&part, name);
                image = Some(self.layer_factor_image((layer, triangles), name, part.place()));
                if part.is_counted() {
                    self.b.passes.push(self.forget_counts(name));
                }
            }
            for part in segment.shaded.iter().filter(|_| shadowed) {
                self.passes_of(part, name);
                if let (Some(triangles), None) = (wanted, image) {
                    image = Some(self.layer_factor_image((layer, triangles), name, part.place()));
                }
                if let (Some(mask), true) = (mask, part.is_counted()) {
                    self.b.passes.push(self.resolve_to_mask(name, mask, bits));
                    bits += 1;
                }
            }
            if let (Some(triangles), None) = (wanted, image) {
                image = Some(self.layer_factor_image((layer, triangles), name, FactorAt::Lit));
            }
            light.layer_factor_images.extend(image);
        }
    }

    /// The factor of one light on a layer as a linear image.
    fn layer_factor_image(
        &mut self,
        (layer, triangles): (u32, SlotId),
        light: &str,
        factor: FactorAt,
    ) -> SlotId {
        let mut bindings = vec![(0, Binding::Texture(triangles))];
        let (mut flags, mut format): (&[&str], _) = (&[], TextureFormat::R32Float);
        match factor {
            FactorAt::Counts | FactorAt::MaskBit(_) => {
                bindings.push((1, Binding::StencilOf(self.depth)));
                flags = &["COUNTS"];
            }
            FactorAt::Visibility(layer) => {
                bindings.push((1, Binding::TextureLayer(self.visibility, layer)));
                flags = &["VISIBILITY"];
                if matches!(
                    self.b.slots[self.visibility.0].kind,
                    SlotKind::Texture { format: TextureFormat::Rgba16Float, .. }
                ) {
                    format = TextureFormat::Rgba32Float;
                }
            }
            FactorAt::Lit | FactorAt::Darkening => {}
        }
        let name = format!("factor of {light}");
        let slot = self.b.texture(&format!("{name} on layer {layer}"), format, 1, "asked for");
        let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
        let mut draw = self.resolve_draw("factor", state);
        draw.shader = Some(engine_shader("layer_images", flags, "fullscreen_vertex", Some("factor")));
        draw.bindings = bindings;
        self.b.passes.push(Pass {
            name,
            reason: "the factor on this layer was asked for as an image".into(),
            colors: vec![ColorTarget { slot, layer: 0, load: Load::Clear([1.0; 4]), resolve: None }],
            depth: None,
            draws: vec![draw],
        });
        slot
    }

    /// Adds one layer's own light to that of the layers before it, and takes from what passes what it does not let pass.
    fn shade_layer(
        &mut self,
        triangles: SlotId,
        (passed, light): (SlotId, SlotId),
        factors: Vec<(u32, Binding)>,
    ) {
        let own = (3, Binding::Texture(triangles));
        let mut bindings = vec![own, (4, Binding::Texture(passed))];
        bindings.extend(factors);
        let pass = |name: &str, reason: &str, slot, draw, depth| Pass {
            name: name.into(),
            reason: reason.into(),
            colors: vec![ColorTarget { slot, layer: 0, load: Load::Keep, resolve: None }],
            depth: Some(depth),
            draws: vec![draw],
        };
        let equal = |blend| DrawState::new(CompareFunction::Equal, vec![Some(blend)]);
        let draw = self.transparent_draw("layer", SurfaceStyle::Layer, equal(ADD), bindings);
        let reason = "the layer's own light, as far as it passes the layers before it";
        let shading = pass("shading", reason, light, draw, self.depth_read());
        let draw = self.transparent_draw("layer", SurfaceStyle::LayerTint, equal(MULTIPLY), vec![own]);
        let reason = "how much is seen through the layer";
        let tint = pass("passing", reason, passed, draw, self.depth_read());
        self.b.passes.extend([shading, tint]);
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

/// dst + src.
const ADD: BlendState = {
    let add = BlendComponent {
        src_factor: BlendFactor::One,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    BlendState { color: add, alpha: add }
};
