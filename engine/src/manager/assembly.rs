//! Putting a frame together from what each light's techniques planned.

use wgpu::TextureFormat;

use super::layers::Layered;
use super::request::{Adapter, FrameError, FrameRequest};
use super::segments::{Part, Segment};
use super::states::{ADD_CONSTANT, CLEAR_STENCIL, FREE_WHERE_COUNTED};
use super::surfaces::Surfaces;
use crate::plan::{
    ALL_TAKEN, Access, Antialias, Binding, BlendState, ColorTarget, CompareFunction, DepthTarget, Draw,
    DrawState, FactorAt, FactorPart, FramePlan, Geometry, LightPlanned, Load, Pass, PlanBuilder, Shader,
    SlotId, SlotKind, SurfaceStyle,
};
use crate::scene::Posed;
use crate::shadow::{Channels, View};

/// Everything that is known when the pieces of the frame are put together.
pub(super) struct Assembly<'a> {
    pub(super) posed: &'a Posed,
    pub(super) view: &'a View,
    pub(super) surfaces: Surfaces,
    pub(super) request: &'a FrameRequest,
    pub(super) adapter: &'a Adapter<'a>,
    pub(super) b: PlanBuilder,
    /// The finished picture.
    pub(super) picture: SlotId,
    /// What is drawn into: the picture itself, or what it is averaged from.
    pub(super) drawn: SlotId,
    pub(super) depth: SlotId,
    pub(super) visibility: SlotId,
    /// The visible triangle of every pixel, when a technique asks for it.
    pub(super) triangles: Option<SlotId>,
    /// The normal of the surface that every pixel shows, when a technique asks for it.
    pub(super) normals: Option<SlotId>,
}

impl Assembly<'_> {
    /// Puts prepass, segments, resolves and shading together, and what darkens the finished picture after them: each
    /// by itself, then the one darkening of `weight`. The visibility has `visibilities` layers; `layers` are those of
    /// transparent surfaces, which come last.
    ///
    /// # Errors
    /// What the adapter cannot do with four samples a pixel.
    pub(super) fn assemble(
        mut self,
        segments: Vec<Segment>,
        visibilities: u32,
        weight: Option<f64>,
        mut layers: Option<Layered>,
    ) -> Result<FramePlan, FrameError> {
        let parts = |s: &Segment| [&s.shaded[..], &s.after[..], s.alone.as_slice()].concat();
        let all: Vec<Part> = segments.iter().flat_map(parts).collect();
        let counted = segments.iter().flat_map(|s| &s.shaded).filter(|part| part.is_counted()).count() as u32;
        let counting = all.iter().filter(|part| part.counts).count() as u32;
        let shadowed = all.iter().any(|part| !part.passes.is_empty());
        let on_layers = layers.as_mut().and_then(Layered::widest);
        let widest = segments.iter().filter_map(|s| s.visibility).max().max(on_layers);
        self.size_visibility(visibilities, widest);
        if counting > 0 {
            let slot = &mut self.b.slots[self.depth.0];
            slot.reason = "hidden surfaces, and the counts of shadow volumes".into();
            if let SlotKind::Texture { format, .. } = &mut slot.kind {
                *format = TextureFormat::Depth32FloatStencil8;
            }
        }
        // One light with counts is shaded straight from the stencil, if nothing else counts in it.
        let mask = if counted > 0 && counting > 1 { Some(self.light_mask(counted)?) } else { None };
        if self.multisampled() {
            self.adapter.check_multisampled("depth", self.depth_format())?;
        }

        // Holes are cut before anything is shaded: what shades a pixel's samples at once cannot tell them apart.
        let prepass = shadowed || self.request.factors || (self.multisampled() && self.has_holes());
        if prepass {
            let pass = self.prepass(counting > 0);
            self.b.passes.push(pass);
        }
        let visible_triangles = self.what_is_seen()?;
        let mut bits = 0;
        let mut lights = Vec::new();
        let (mut apart, mut once) = (Vec::new(), Vec::new());
        for (index, segment) in segments.into_iter().enumerate() {
            let name = self.posed.lights[index].name.clone();
            let Segment { techniques, smooth_terminators, own_shadow, .. } = segment;
            let wanted = self.request.factors && segment.claimed;
            let mut factor_image = None;
            if let Some(part) = segment.alone.filter(|_| wanted) {
                self.passes_of(&part, &name);
                let image = self.factor_image(index, (part.place(), own_shadow), visible_triangles);
                factor_image = Some(image);
                if part.is_counted() {
                    self.b.passes.push(self.forget_counts(&name));
                }
            }
            let mut factors = Vec::new();
            for part in segment.shaded {
                self.passes_of(&part, &name);
                let at = match mask {
                    Some(_) if part.is_counted() => FactorAt::MaskBit(bits),
                    _ => part.place(),
                };
                if wanted && factor_image.is_none() {
                    factor_image = Some(self.factor_image(index, (at, own_shadow), visible_triangles));
                }
                if let (FactorAt::MaskBit(bit), Some(mask)) = (at, mask) {
                    self.b.passes.push(self.resolve_to_mask(&name, mask, bit));
                    bits += 1;
                }
                factors.extend((at != FactorAt::Lit).then_some(FactorPart { at, taken: part.taken }));
            }
            if wanted && factor_image.is_none() {
                factor_image = Some(self.factor_image(index, (FactorAt::Lit, false), visible_triangles));
            }
            let lit = if segment.after.is_empty() { FactorAt::Lit } else { FactorAt::Darkening };
            if segment.once {
                once.extend(segment.after.into_iter().flat_map(|part| part.passes));
            } else {
                apart.extend(segment.after.into_iter().map(|part| (name.clone(), part)));
            }
            let mut factors = factors.into_iter();
            let first = factors.next().unwrap_or(FactorPart { at: lit, taken: ALL_TAKEN });
            lights.push(LightPlanned {
                name,
                factor: first.at,
                taken: first.taken,
                more_factors: factors.collect(),
                techniques,
                smooth_terminators,
                own_shadow,
                factor_image,
                layer_factor_images: vec![],
            });
        }
        let finished = self.drawn;
        if let Some(layers) = &layers {
            self.draw_in_layers(layers);
        }
        self.shading(prepass, counting > 0, mask, &lights, layers.is_some());
        for (light, part) in apart {
            self.darken_by(&light, part);
        }
        if let Some(weight) = weight.filter(|_| !once.is_empty()) {
            let once = once.into_iter().map(|pass| self.with_stencil_as_it_is(pass)).collect();
            self.darken(once, weight);
        }
        let (mut layer_count, mut layer_triangles) = (0, vec![]);
        if let Some(layers) = layers {
            layer_count = layers.count();
            layer_triangles =
                layers.looked_at.iter().filter(|layer| layer.kept).map(|layer| layer.triangles).collect();
            self.draw_layers(layers, mask, finished, &mut lights);
        }
        self.finish_picture();
        let shadowed_px = self.confine_visibility();
        let Self { b, picture, request, .. } = self;
        let mut plan = FramePlan {
            size_px: b.size_px,
            antialias: request.antialias,
            slots: b.slots,
            passes: b.passes,
            lights,
            picture,
            visible_triangles: visible_triangles.filter(|_| request.factors),
            layers: layer_count,
            layer_triangles,
            shadowed_px,
            notes: b.notes,
        };
        if visibilities == 0 {
            plan.remove_slot(self.visibility);
        }
        Ok(plan)
    }

    /// Adds the passes of one part. Counts beside a visibility go into it.
    pub(super) fn passes_of(&mut self, part: &Part, light: &str) {
        let passes = part.passes.iter().cloned().map(|pass| self.with_stencil_as_it_is(pass));
        let passes: Vec<Pass> = passes.collect();
        self.b.passes.extend(passes);
        if let (true, Some(layer)) = (part.counts, part.layer) {
            self.b.passes.push(self.resolve_to_visibility(light, layer));
        }
    }

    pub(super) fn multisampled(&self) -> bool {
        self.request.antialias == Antialias::Multisample4
    }

    fn has_holes(&self) -> bool {
        let instances = &self.surfaces.opaque_instances;
        instances.iter().any(|instance| self.posed.instances[*instance as usize].is_masked())
    }

    fn depth_format(&self) -> TextureFormat {
        match self.b.slots[self.depth.0].kind {
            SlotKind::Texture { format, .. } => format,
            SlotKind::Buffer { .. } | SlotKind::Image { .. } => TextureFormat::Depth32Float,
        }
    }

    /// One bit for each of `counted` lights, in the narrowest format that holds them.
    fn light_mask(&mut self, counted: u32) -> Result<SlotId, FrameError> {
        let format = match counted {
            0..=8 => TextureFormat::R8Unorm,
            9..=16 => TextureFormat::Rg8Unorm,
            _ => TextureFormat::Rgba8Unorm,
        };
        let reason = format!("one bit for each of {counted} lights with counts");
        if !self.multisampled() {
            return Ok(self.b.texture("light mask", format, counted.div_ceil(32), &reason));
        }
        // Multisampled textures have one layer.
        if counted > 32 {
            return Err(FrameError::MultisampledLights { lights: counted, limit: 32 });
        }
        self.adapter.check_multisampled("the light mask", format)?;
        Ok(self.b.samples("light mask", format, self.request.antialias.samples(), &reason))
    }

    fn size_visibility(&mut self, light_layers: u32, widest: Option<Channels>) {
        if let SlotKind::Texture { format, layers, .. } = &mut self.b.slots[self.visibility.0].kind {
            *layers = light_layers.max(1);
            *format = widest.unwrap_or(Channels::One).format();
        }
    }

    /// The depth attachment of passes that only test against the prepass.
    pub(super) fn depth_read(&self) -> DepthTarget {
        let stencil = match self.b.slots[self.depth.0].kind {
            SlotKind::Texture { format, .. } if format.has_stencil_aspect() => Some(Access::ReadOnly),
            _ => None,
        };
        DepthTarget { slot: self.depth, depth: Access::ReadOnly, stencil }
    }

    /// Techniques that only test depth do not know whether others count in the stencil beside it.
    pub(super) fn with_stencil_as_it_is(&self, mut pass: Pass) -> Pass {
        if let Some(depth) = &mut pass.depth
            && depth.slot == self.depth
            && depth.stencil.is_none()
        {
            depth.stencil = self.depth_read().stencil;
        }
        pass
    }

    fn prepass(&self, stencil: bool) -> Pass {
        let mut state = DrawState::new(CompareFunction::Greater, vec![]);
        state.depth_write = true;
        Pass {
            name: "depth prepass".into(),
            reason: "shadows need the visible surface before it is shaded".into(),
            colors: vec![],
            depth: Some(DepthTarget {
                slot: self.depth,
                depth: Access::Clear(0.0),
                stencil: stencil.then_some(CLEAR_STENCIL),
            }),
            draws: vec![self.surfaces_draw("opaque surfaces", SurfaceStyle::Depth, None, state)],
        }
    }

    pub(super) fn surfaces_draw(
        &self,
        name: &str,
        style: SurfaceStyle,
        shader: Option<Shader>,
        state: DrawState,
    ) -> Draw {
        Draw {
            name: name.into(),
            shader,
            state,
            geometry: Surfaces::geometry(self.posed, style, &self.surfaces.opaque),
            bindings: vec![],
            scissor_px: None,
        }
    }

    /// The opaque surfaces `pulled` by a shader, with its flags and fragment entry point: runs with and without holes,
    /// in the order of drawing.
    pub(super) fn pulled_draws(
        &self,
        pulled: &[(u32, u32)],
        (shader, flags, fragment): (&'static str, &[&str], &'static str),
        state: &DrawState,
        bindings: &[(u32, Binding)],
    ) -> Vec<Draw> {
        let is_masked = |&(instance, part): &(u32, u32)| {
            self.posed.instances[instance as usize].materials[part as usize].cutoff().is_some()
        };
        let runs = pulled.chunk_by(|a, b| is_masked(a) == is_masked(b));
        let draw = |parts: &[(u32, u32)]| {
            // A mask without a texture reads a white one: no variant of its own.
            let masked: &[&str] = &["MASKED", "BASE_COLOR_TEXTURE", "SECOND_UV"];
            let (name, style, more) = if parts.first().is_some_and(is_masked) {
                ("masked surfaces", SurfaceStyle::PulledMasked, masked)
            } else {
                ("opaque surfaces", SurfaceStyle::Pulled, &[] as &[&str])
            };
            Draw {
                name: name.into(),
                shader: Some(engine_shader(shader, &[flags, more].concat(), "vertex", Some(fragment))),
                state: state.clone(),
                geometry: Surfaces::geometry(self.posed, style, parts),
                bindings: bindings.to_vec(),
                scissor_px: None,
            }
        };
        runs.map(draw).collect()
    }

    /// Marks a light's shadow in the mask and sets counts back for the next light.
    pub(super) fn resolve_to_mask(&self, light: &str, mask: SlotId, bit: u32) -> Pass {
        let layer = bit / 32;
        let first = bit.is_multiple_of(32);
        let mut state = DrawState::new(CompareFunction::Always, vec![Some(ADD_CONSTANT)]);
        state.blend_constant[(bit as usize / 8) % 4] = f64::from(1u32 << (bit % 8)) / 255.0;
        state.stencil = Some(FREE_WHERE_COUNTED);
        Pass {
            name: format!("resolve {light}"),
            reason: format!("its counts become bit {bit} of the light mask, and the stencil is free again"),
            colors: vec![ColorTarget {
                slot: mask,
                layer,
                load: if first { Load::Clear([0.0; 4]) } else { Load::Keep },
                resolve: None,
            }],
            depth: Some(DepthTarget {
                slot: self.depth,
                depth: Access::ReadOnly,
                stencil: Some(Access::Keep),
            }),
            draws: vec![self.resolve_draw("mark", state)],
        }
    }

    /// Writes darkness where a light that also has a visibility target was counted as shadowed.
    fn resolve_to_visibility(&self, light: &str, layer: u32) -> Pass {
        let mut state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
        state.stencil = Some(FREE_WHERE_COUNTED);
        Pass {
            name: format!("resolve {light}"),
            reason: "its counts darken its visibility, and the stencil is free again".into(),
            colors: vec![ColorTarget { slot: self.visibility, layer, load: Load::Keep, resolve: None }],
            depth: Some(DepthTarget {
                slot: self.depth,
                depth: Access::ReadOnly,
                stencil: Some(Access::Keep),
            }),
            draws: vec![self.resolve_draw("darken", state)],
        }
    }

    pub(super) fn resolve_draw(&self, fragment: &'static str, state: DrawState) -> Draw {
        Draw {
            name: fragment.into(),
            shader: Some(engine_shader("resolve_mask", &[], "fullscreen_vertex", Some(fragment))),
            state,
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings: vec![],
            scissor_px: None,
        }
    }
}

/// A shader of the engine's own; its text is checked by a test, so composing it cannot fail.
pub(super) fn engine_shader(
    name: &'static str,
    flags: &[&str],
    vertex: &'static str,
    fragment: Option<&'static str>,
) -> Shader {
    let source = shadowgraph_shaders::compose_named(name, flags).unwrap_or_default();
    let name = if flags.is_empty() { name.into() } else { format!("{name} {}", flags.join(" ")) };
    Shader {
        name: name.into(),
        source: source.into(),
        vertex: vertex.into(),
        fragment: fragment.map(Into::into),
    }
}
