//! Putting a frame together from what each light's techniques planned.

use std::sync::Arc;

use wgpu::TextureFormat;

use super::request::FrameRequest;
use super::surfaces::Surfaces;
use crate::math::facing_sign;
use crate::plan::{
    Access, Binding, BlendComponent, BlendFactor, BlendOperation, BlendState, BufferUsage, ColorTarget,
    CompareFunction, DepthTarget, Draw, DrawState, FactorAt, FramePlan, Geometry, LightPlanned, Load, Pass,
    PlanBuilder, Shader, SlotId, SlotKind, Stencil, StencilFaceState, StencilOperation, SurfaceStyle,
};
use crate::scene::Posed;
use crate::shadow::{Channels, View, hash_of};

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
}

/// Everything that is known when the pieces of the frame are put together.
pub(super) struct Assembly<'a> {
    pub(super) posed: &'a Posed,
    pub(super) view: &'a View,
    pub(super) surfaces: Surfaces,
    pub(super) request: &'a FrameRequest,
    pub(super) b: PlanBuilder,
    pub(super) picture: SlotId,
    pub(super) depth: SlotId,
    pub(super) visibility: SlotId,
}

impl Assembly<'_> {
    /// Puts prepass, segments, resolves and shading together, and the one darkening of `weight` after them.
    pub(super) fn assemble(mut self, segments: Vec<Segment>, weight: Option<f64>) -> FramePlan {
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
        let mask = (counted > 1 || (counted == 1 && others_count)).then(|| {
            let format = match counted {
                0..=8 => TextureFormat::R8Unorm,
                9..=16 => TextureFormat::Rg8Unorm,
                _ => TextureFormat::Rgba8Unorm,
            };
            let reason = format!("one bit for each of {counted} lights with counts");
            self.b.texture("light mask", format, counted.div_ceil(32), &reason)
        });

        let prepass = shadowed || self.request.factors;
        if prepass {
            let pass = self.prepass(any_counts);
            self.b.passes.push(pass);
        }
        let visible_triangles = self.request.factors.then(|| self.visible_triangles());
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
            let factor_image = wanted.then(|| self.factor_image(index, factor));
            if factor_alone {
                self.b.passes.push(self.forget_counts(&name));
            }
            if let (FactorAt::MaskBit(bit), Some(mask)) = (factor, mask) {
                self.b.passes.push(self.resolve_to_mask(&name, mask, bit));
            }
            bit += u32::from(matches!(factor, FactorAt::MaskBit(_)));
            layer += u32::from(segment.visibility.is_some());
            let Segment { techniques, smooth_terminators, .. } = segment;
            lights.push(LightPlanned { name, factor, techniques, smooth_terminators, factor_image });
        }
        self.shading(prepass, any_counts, mask, layers > 0, &lights);
        if let Some(weight) = weight.filter(|_| !darkening.is_empty()) {
            self.darken(darkening, weight);
        }
        let Self { b, picture, .. } = self;
        let mut plan = FramePlan {
            size_px: b.size_px,
            slots: b.slots,
            passes: b.passes,
            lights,
            picture,
            visible_triangles,
            notes: b.notes,
        };
        if layers == 0 {
            plan.remove_slot(self.visibility);
        }
        plan
    }

    fn size_visibility(&mut self, light_layers: u32, widest: Option<Channels>) {
        if let SlotKind::Texture { format, layers, .. } = &mut self.b.slots[self.visibility.0].kind {
            *layers = light_layers.max(1);
            *format = if widest == Some(Channels::Rgb) {
                TextureFormat::Rgba16Float
            } else {
                TextureFormat::R16Float
            };
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

    fn surfaces_draw(
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
    fn pulled_draws(
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

    /// (instance, triangle) of every pixel, with a depth test of its own so that of two coincident surfaces the
    /// first drawn wins, as in the prepass.
    fn visible_triangles(&mut self) -> SlotId {
        let reason = "measuring compares where reference and GPU see the same triangle";
        let slot = self.b.texture("visible triangles", TextureFormat::Rg32Uint, 1, reason);
        let depth = self.b.texture("depth of visible triangles", TextureFormat::Depth32Float, 1, reason);
        let mut state = DrawState::new(CompareFunction::Greater, vec![Some(BlendState::REPLACE)]);
        state.depth_write = true;
        let draws = self.pulled_draws("surface_measure", &[], "visible_triangle", &state, &[]);
        let nothing = f64::from(u32::MAX);
        self.b.passes.push(Pass {
            name: "visible triangles".into(),
            reason: reason.into(),
            colors: vec![ColorTarget { slot, layer: 0, load: Load::Clear([nothing, nothing, 0.0, 0.0]) }],
            depth: Some(DepthTarget { slot: depth, depth: Access::Clear(0.0), stencil: None }),
            draws,
        });
        slot
    }

    /// The factor of one light as a linear image.
    fn factor_image(&mut self, light: usize, factor: FactorAt) -> SlotId {
        let name = &self.posed.lights[light].name;
        let color = matches!(
            self.b.slots[self.visibility.0].kind,
            SlotKind::Texture { format: TextureFormat::Rgba16Float, .. }
        );
        let color = color && matches!(factor, FactorAt::Visibility(_));
        let format = if color { TextureFormat::Rgba32Float } else { TextureFormat::R32Float };
        let slot = self.b.texture(&format!("factor of {name}"), format, 1, "asked for");
        let turned_away = self.turned_away(light);
        let mut bindings = vec![(3, Binding::Storage(turned_away))];
        let flags: &[&str] = match factor {
            FactorAt::Counts | FactorAt::MaskBit(_) | FactorAt::Darkening => {
                bindings.push((4, Binding::StencilOf(self.depth)));
                &["COUNTS"]
            }
            FactorAt::Visibility(layer) => {
                bindings.push((4, Binding::TextureLayer(self.visibility, layer)));
                &["VISIBILITY"]
            }
            FactorAt::Lit => &[],
        };
        let state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
        let draws = self.pulled_draws("surface_factor", flags, "factor", &state, &bindings);
        let pass = Pass {
            name: format!("factor of {name}"),
            reason: "the factor was asked for as an image".into(),
            colors: vec![ColorTarget { slot, layer: 0, load: Load::Clear([1.0; 4]) }],
            depth: Some(self.depth_read()),
            draws,
        };
        self.b.passes.push(pass);
        slot
    }

    /// One bit for each triangle of the frame: the eye sees the side turned away from the light. Decided in f64.
    fn turned_away(&mut self, light: usize) -> SlotId {
        let light = &self.posed.lights[light];
        let mut bits: Vec<u32> = Vec::new();
        let mut first = 0;
        for instance in &self.posed.instances {
            let count = instance.mesh.triangle_count();
            bits.resize((first + count).div_ceil(32).max(1), 0);
            let world: Vec<_> =
                (0..instance.mesh.positions().len() as u32).map(|v| instance.world_position(v)).collect();
            for triangle in 0..count {
                let [a, b, c] = instance.mesh.triangle(triangle).map(|v| world[v as usize]);
                let eye_side = facing_sign(a, b, c, self.view.frustum.eye);
                if eye_side * facing_sign(a, b, c, light.position) < 0 {
                    bits[(first + triangle) / 32] |= 1 << ((first + triangle) % 32);
                }
            }
            first += count;
        }
        if bits.is_empty() {
            bits.push(0);
        }
        let key = hash_of(("turned away", &bits));
        let contents = Arc::new(bytemuck::cast_slice(&bits).to_vec());
        let name = format!("turned away from {}", light.name);
        self.b.buffer(
            &name,
            BufferUsage::Storage,
            key,
            contents,
            "surfaces turned away from a light are dark",
        )
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
            colors: vec![ColorTarget { slot: self.visibility, layer, load: Load::Keep }],
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
        bindings.extend(mask.map(|mask| (1, Binding::TextureArray(mask))));
        if visibility {
            bindings.push((2, Binding::TextureArray(self.visibility)));
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
        self.b.passes.push(Pass {
            name: "shading".into(),
            reason: match lights.len() {
                0 => "ambient light only".into(),
                1 => "the only light".into(),
                n => format!("all {n} lights at once"),
            },
            colors: vec![ColorTarget {
                slot: self.picture,
                layer: 0,
                load: Load::Clear([background.x, background.y, background.z, 1.0]),
            }],
            depth: Some(depth),
            draws,
        });
    }
}

/// dst + constant.
const ADD_CONSTANT: BlendState = {
    let add = BlendComponent {
        src_factor: BlendFactor::Constant,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    BlendState { color: add, alpha: add }
};

/// Draws where the stencil is not zero, and leaves zero there.
pub(super) const ZERO_WHERE_COUNTED: Stencil = {
    let face = StencilFaceState {
        compare: CompareFunction::NotEqual,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op: StencilOperation::Zero,
    };
    Stencil { front: face, back: face, read_mask: 0xff, write_mask: 0xff, reference: 0 }
};

/// A shader of the engine's own; its text is checked by a test, so composing it cannot fail.
fn engine_shader(
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

impl FramePlan {
    /// Removes a slot that no pass names, renumbering those after it.
    fn remove_slot(&mut self, removed: SlotId) {
        self.slots.remove(removed.0);
        let shift = |slot: &mut SlotId| slot.0 -= usize::from(slot.0 > removed.0);
        for pass in &mut self.passes {
            pass.colors.iter_mut().for_each(|color| shift(&mut color.slot));
            pass.depth.iter_mut().for_each(|depth| shift(&mut depth.slot));
            for draw in &mut pass.draws {
                if let Geometry::Indexed { indices, .. } = &mut draw.geometry {
                    shift(indices);
                }
                for (_, binding) in &mut draw.bindings {
                    match binding {
                        Binding::Storage(slot)
                        | Binding::Texture(slot)
                        | Binding::TextureArray(slot)
                        | Binding::TextureLayer(slot, _)
                        | Binding::StencilOf(slot) => shift(slot),
                    }
                }
            }
        }
        shift(&mut self.picture);
        self.visible_triangles.iter_mut().for_each(shift);
        self.lights.iter_mut().filter_map(|light| light.factor_image.as_mut()).for_each(shift);
    }
}
