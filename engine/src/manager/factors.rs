//! What tests and reports compare: the visible triangle of every pixel and each light's factor as an image; or of
//! every sample, where edges are smoothed by several samples a pixel.

use std::sync::Arc;

use wgpu::TextureFormat;

use super::assembly::{Assembly, engine_shader};
use super::request::FrameError;
use crate::math::facing_sign;
use crate::plan::{
    Access, Binding, BlendState, BufferUsage, ColorTarget, CompareFunction, DepthTarget, Draw, DrawState,
    FactorAt, Geometry, Load, Pass, SlotId, SlotKind,
};
use crate::shadow::hash_of;

/// Where nothing is seen.
const NO_NORMAL: Load = Load::Clear([0.0; 4]);

impl Assembly<'_> {
    /// (instance, triangle) of every pixel and the normal there, as far as they are wanted, with a depth test of its
    /// own so that of two coincident surfaces the first drawn wins, as in the prepass.
    pub(super) fn what_is_seen(&mut self) -> Result<Option<SlotId>, FrameError> {
        let wanted = self.request.factors || self.triangles.is_some();
        match (wanted, self.normals) {
            (false, None) => Ok(None),
            (false, Some(normals)) => {
                let color = ColorTarget { slot: normals, layer: 0, load: NO_NORMAL, resolve: None };
                let reason = "a technique asks which way each pixel's surface faces";
                self.seen_pass("receiver planes", reason, ("receiver_plane", &["PLANES"]), vec![color]);
                Ok(None)
            }
            (true, normals) => Ok(Some(self.visible_triangles(normals)?)),
        }
    }

    /// A pass over what is seen, one pixel or sample one triangle.
    fn seen_pass(
        &mut self,
        name: &str,
        reason: &str,
        (fragment, flags): (&'static str, &[&str]),
        colors: Vec<ColorTarget>,
    ) {
        let samples = colors.first().map_or(1, |color| self.b.slots[color.slot.0].samples());
        let format = TextureFormat::Depth32Float;
        let depth = self.b.samples("depth of visible triangles", format, samples, reason);
        let targets = vec![Some(BlendState::REPLACE); colors.len()];
        let mut state = DrawState::new(CompareFunction::Greater, targets);
        state.depth_write = true;
        let draws =
            self.pulled_draws(&self.surfaces.opaque, ("surface_measure", flags, fragment), &state, &[]);
        self.b.passes.push(Pass {
            name: name.into(),
            reason: reason.into(),
            colors,
            depth: Some(DepthTarget { slot: depth, depth: Access::Clear(0.0), stencil: None }),
            draws,
        });
    }

    fn visible_triangles(&mut self, normals: Option<SlotId>) -> Result<SlotId, FrameError> {
        let reason = if self.request.factors {
            "measuring compares where reference and GPU see the same triangle"
        } else {
            "a technique asks which triangle each pixel shows"
        };
        let samples = self.request.antialias.samples();
        let slot = if self.multisampled() {
            // No format of 64 bits and two channels has samples; one of four channels does.
            let format = TextureFormat::Rgba16Uint;
            self.adapter.check_multisampled("visible triangles", format)?;
            self.b.samples("visible triangles in samples", format, samples, reason)
        } else if let Some(asked_for) = self.triangles {
            asked_for
        } else {
            self.b.texture("visible triangles", TextureFormat::Rg32Uint, 1, reason)
        };
        // Every bit set, and triangle 0 where there are bits for it.
        let [nothing, triangle] = if self.multisampled() { [65535.0; 2] } else { [f64::from(u32::MAX), 0.0] };
        let load = Load::Clear([nothing, nothing, triangle, triangle]);
        let mut colors = vec![ColorTarget { slot, layer: 0, load, resolve: None }];
        colors.extend(normals.map(|slot| ColorTarget { slot, layer: 0, load: NO_NORMAL, resolve: None }));
        let (name, shader): (_, (&str, &[&str])) = match normals {
            // What each pixel faces is refused with several samples.
            _ if self.multisampled() => ("visible triangles", ("visible_triangle", &["HALVES"])),
            None => ("visible triangles", ("visible_triangle", &[])),
            Some(_) => ("visible triangles and receiver planes", ("triangle_and_plane", &["PLANES"])),
        };
        self.seen_pass(name, reason, shader, colors);
        Ok(if self.multisampled() { self.triangles_of_samples(slot) } else { slot })
    }

    /// The visible triangle of every sample, a texel each.
    fn triangles_of_samples(&mut self, in_samples: SlotId) -> SlotId {
        let size_px = self.request.antialias.factor_size_px(self.request.size_px);
        let reason = "a texel for every sample";
        let slot = self.b.texture_sized("visible triangles", TextureFormat::Rg32Uint, size_px, 1, reason);
        let bindings = vec![(0, Binding::Texture(in_samples))];
        self.sample_pass("visible triangles", slot, ("triangle", &[]), bindings);
        slot
    }

    /// A pass that writes a texel for every sample.
    fn sample_pass(
        &mut self,
        name: &str,
        slot: SlotId,
        (fragment, flags): (&'static str, &[&str]),
        bindings: Vec<(u32, Binding)>,
    ) {
        let draw = Draw {
            name: "samples".into(),
            shader: Some(engine_shader("sample_images", flags, "fullscreen_vertex", Some(fragment))),
            state: DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]),
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings,
            scissor_px: None,
        };
        self.b.passes.push(Pass {
            name: format!("{name} of samples"),
            reason: "the factor of every sample was asked for".into(),
            colors: vec![ColorTarget { slot, layer: 0, load: Load::Clear([0.0; 4]), resolve: None }],
            depth: None,
            draws: vec![draw],
        });
    }

    /// The factor of one light as a linear image.
    pub(super) fn factor_image(
        &mut self,
        light: usize,
        (factor, own_shadow): (FactorAt, bool),
        triangles: Option<SlotId>,
    ) -> SlotId {
        let name = &self.posed.lights[light].name;
        let color = matches!(
            self.b.slots[self.visibility.0].kind,
            SlotKind::Texture { format: TextureFormat::Rgba16Float, .. }
        );
        let color = color && matches!(factor, FactorAt::Visibility(_));
        let format = if color { TextureFormat::Rgba32Float } else { TextureFormat::R32Float };
        let name = format!("factor of {name}");
        let size_px = self.request.antialias.factor_size_px(self.request.size_px);
        let slot = self.b.texture_sized(&name, format, size_px, 1, "asked for");
        let turned_away = (!own_shadow).then(|| self.turned_away(light));
        let mut bindings: Vec<_> = turned_away.map(|slot| (3, Binding::Storage(slot))).into_iter().collect();
        let flags: &[&str] = match factor {
            FactorAt::Counts | FactorAt::MaskBit(_) | FactorAt::Darkening => {
                bindings.push((4, Binding::StencilOf(self.depth)));
                &["COUNTS"]
            }
            FactorAt::Visibility(layer) => {
                bindings.push((4, Binding::TextureLayer(self.visibility, layer)));
                if own_shadow { &["VISIBILITY", "OWN_SHADOW"] } else { &["VISIBILITY"] }
            }
            FactorAt::Lit => &[],
        };
        if let (true, Some(triangles)) = (self.multisampled(), triangles) {
            bindings.push((1, Binding::Texture(triangles)));
            self.sample_pass(&name, slot, ("factor", flags), bindings);
            return slot;
        }
        let state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
        let draws =
            self.pulled_draws(&self.surfaces.opaque, ("surface_factor", flags, "factor"), &state, &bindings);
        let pass = Pass {
            name,
            reason: "the factor was asked for as an image".into(),
            colors: vec![ColorTarget { slot, layer: 0, load: Load::Clear([1.0; 4]), resolve: None }],
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
}
