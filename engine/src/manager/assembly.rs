//! Putting a frame together from what each light's techniques planned.

use wgpu::TextureFormat;

use super::request::{Adapter, FrameError, FrameRequest};
use super::states::{ADD_CONSTANT, ZERO_WHERE_COUNTED};
use super::surface_functions;
use super::surfaces::Surfaces;
use crate::plan::{
    Access, Antialias, Binding, BlendState, ColorTarget, CompareFunction, DepthTarget, Draw, DrawState,
    FactorAt, FramePlan, Geometry, LightPlanned, Load, Pass, PlanBuilder, Shader, SlotId, SlotKind,
    SurfaceStyle,
};
use crate::scene::Posed;
use crate::shadow::{Channels, View};

/// One light's part of the plan, before it is known how factors are stored.
pub(super) struct Segment {
    pub(super) passes: Vec<Pass>,
    pub(super) counts: bool,
    pub(super) visibility: Option<Channels>,
    pub(super) techniques: Vec<String>,
    pub(super) claimed: bool,
    /// Whether the light is shaded as if unshadowed and its counts go into the one darkening.
    pub(super) darkens: bool,
    pub(super) smooth_terminators: Vec<u32>,
    pub(super) own_shadow: bool,
}

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
    /// Puts prepass, segments, resolves and shading together, and the one darkening of `weight` after them.
    ///
    /// # Errors
    /// What the adapter cannot do with four samples a pixel.
    pub(super) fn assemble(
        mut self,
        segments: Vec<Segment>,
        weight: Option<f64>,
    ) -> Result<FramePlan, FrameError> {
        let counted = segments.iter().filter(|s| s.counts && s.visibility.is_none()).count() as u32;
        let any_counts = segments.iter().any(|s| s.counts || s.darkens);
        let shadowed = segments.iter().any(|s| !s.passes.is_empty());
        let layers = segments.iter().filter(|s| s.visibility.is_some()).count() as u32;
        self.size_visibility(layers, segments.iter().filter_map(|s| s.visibility).max());
        if any_counts {
            self.b.slots[self.depth.0].reason = "hidden surfaces, and the counts of shadow volumes".into();
        }
        // One light with counts is shaded straight from the stencil, if no other light counts in it.
        let others_count = segments.iter().any(|s| (s.counts && s.visibility.is_some()) || s.darkens);
        let mask = if counted > 1 || (counted == 1 && others_count) {
            Some(self.light_mask(counted)?)
        } else {
            None
        };
        if self.multisampled() {
            self.adapter.check_multisampled("depth", self.depth_format())?;
        }

        // Holes are cut before anything is shaded: what shades a pixel's samples at once cannot tell them apart.
        let prepass = shadowed || self.request.factors || (self.multisampled() && self.has_holes());
        if prepass {
            let pass = self.prepass(any_counts);
            self.b.passes.push(pass);
        }
        let visible_triangles = self.what_is_seen()?;
        let (mut bit, mut layer) = (0, 0);
        let mut lights = Vec::new();
        let mut darkening = Vec::new();
        for (index, mut segment) in segments.into_iter().enumerate() {
            let name = self.posed.lights[index].name.clone();
            let passes =
                std::mem::take(&mut segment.passes).into_iter().map(|pass| self.with_stencil_as_it_is(pass));
            let passes: Vec<Pass> = passes.collect();
            let factor = match (segment.counts, segment.visibility) {
                _ if segment.darkens => FactorAt::Darkening,
                (_, Some(_)) => FactorAt::Visibility(layer),
                (true, None) if mask.is_some() => FactorAt::MaskBit(bit),
                (true, None) => FactorAt::Counts,
                (false, None) => FactorAt::Lit,
            };
            // What darkens the finished picture is counted when it is finished; for a factor by itself, and before.
            let factor_alone = factor == FactorAt::Darkening && self.request.factors;
            if factor == FactorAt::Darkening {
                darkening.extend(passes.iter().cloned());
            }
            if factor != FactorAt::Darkening || factor_alone {
                self.b.passes.extend(passes);
            }
            if segment.counts && segment.visibility.is_some() {
                self.b.passes.push(self.resolve_to_visibility(&name, layer));
            }
            let wanted = self.request.factors && segment.claimed;
            let factor_image =
                wanted.then(|| self.factor_image(index, (factor, segment.own_shadow), visible_triangles));
            if factor_alone {
                self.b.passes.push(self.forget_counts(&name));
            }
            if let (FactorAt::MaskBit(bit), Some(mask)) = (factor, mask) {
                self.b.passes.push(self.resolve_to_mask(&name, mask, bit));
            }
            bit += u32::from(matches!(factor, FactorAt::MaskBit(_)));
            layer += u32::from(segment.visibility.is_some());
            let Segment { techniques, smooth_terminators, own_shadow, .. } = segment;
            lights.push(LightPlanned {
                name,
                factor,
                techniques,
                smooth_terminators,
                own_shadow,
                factor_image,
            });
        }
        self.shading(prepass, any_counts, mask, layers > 0, &lights);
        if let Some(weight) = weight.filter(|_| !darkening.is_empty()) {
            self.darken(darkening, weight);
        }
        self.finish_picture();
        let Self { b, picture, request, .. } = self;
        let mut plan = FramePlan {
            size_px: b.size_px,
            antialias: request.antialias,
            slots: b.slots,
            passes: b.passes,
            lights,
            picture,
            visible_triangles: visible_triangles.filter(|_| request.factors),
            notes: b.notes,
        };
        if layers == 0 {
            plan.remove_slot(self.visibility);
        }
        Ok(plan)
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
    fn with_stencil_as_it_is(&self, mut pass: Pass) -> Pass {
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
                stencil: stencil.then_some(Access::Clear(0.0)),
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
        let parts =
            if style == SurfaceStyle::Blended { &self.surfaces.blended } else { &self.surfaces.opaque };
        Draw {
            name: name.into(),
            shader,
            state,
            geometry: Surfaces::geometry(self.posed, style, parts),
            bindings: vec![],
            scissor_px: None,
        }
    }

    /// The opaque surfaces by a shader that pulls them: runs with and without holes, in the order of drawing.
    pub(super) fn pulled_draws(
        &self,
        shader: &'static str,
        flags: &[&str],
        fragment: &'static str,
        state: &DrawState,
        bindings: &[(u32, Binding)],
    ) -> Vec<Draw> {
        let is_masked = |&(instance, part): &(u32, u32)| {
            self.posed.instances[instance as usize].materials[part as usize].cutoff().is_some()
        };
        let runs = self.surfaces.opaque.chunk_by(|a, b| is_masked(a) == is_masked(b));
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

    /// Marks a light's shadow in the mask and sets the stencil back to zero for the next light.
    fn resolve_to_mask(&self, light: &str, mask: SlotId, bit: u32) -> Pass {
        let layer = bit / 32;
        let first = bit.is_multiple_of(32);
        let mut state = DrawState::new(CompareFunction::Always, vec![Some(ADD_CONSTANT)]);
        state.blend_constant[(bit as usize / 8) % 4] = f64::from(1u32 << (bit % 8)) / 255.0;
        state.stencil = Some(ZERO_WHERE_COUNTED);
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
        state.stencil = Some(ZERO_WHERE_COUNTED);
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

    fn shading(
        &mut self,
        after_prepass: bool,
        counts: bool,
        mask: Option<SlotId>,
        visibility: bool,
        lights: &[LightPlanned],
    ) {
        let background = self.posed.background.as_dvec3();
        let mut bindings = Vec::new();
        if lights.iter().any(|light| light.factor == FactorAt::Counts) {
            bindings.push((0, Binding::StencilOf(self.depth)));
        }
        if self.multisampled() {
            bindings.extend(mask.map(|mask| (1, Binding::Texture(mask))));
        } else {
            bindings.extend(mask.map(|mask| (1, Binding::TextureArray(mask))));
        }
        if visibility {
            bindings.push((2, Binding::TextureArray(self.visibility)));
        }
        if self.multisampled() && !bindings.is_empty() {
            // Which samples show the fragment that is shaded: their factors are averaged.
            bindings.push((3, Binding::Texture(self.depth)));
        }
        let mut state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
        let mut depth = self.depth_read();
        if !after_prepass {
            state.depth_compare = CompareFunction::Greater;
            state.depth_write = true;
            depth.depth = Access::Clear(0.0);
            depth.stencil = counts.then_some(Access::Clear(0.0));
        }
        let mut draws = vec![self.surfaces_draw("opaque surfaces", SurfaceStyle::Opaque, None, state)];
        draws[0].bindings = bindings;
        if !self.surfaces.blended.is_empty() {
            let state = DrawState::new(
                CompareFunction::Greater,
                vec![Some(BlendState::PREMULTIPLIED_ALPHA_BLENDING)],
            );
            draws.push(self.surfaces_draw("blended surfaces", SurfaceStyle::Blended, None, state));
            self.b.note("blended surfaces are lit without shadows: factors are those of the opaque surface");
        }
        self.b.notes.extend(surface_functions::notes(self.posed, &self.surfaces, lights));
        let by_functions = surface_functions::reason(self.posed, &self.surfaces);
        self.b.passes.push(Pass {
            name: "shading".into(),
            reason: match lights.len() {
                0 => "ambient light only".to_owned(),
                1 => "the only light".into(),
                n => format!("all {n} lights at once"),
            } + &by_functions,
            colors: vec![ColorTarget {
                slot: self.drawn,
                layer: 0,
                load: Load::Clear([background.x, background.y, background.z, 1.0]),
                resolve: None,
            }],
            depth: Some(depth),
            draws,
        });
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
