//! Darkening the finished picture instead of taking each light's own light away: once for all counts (Lindrud & Löfgren
//! 2004 §5.3, single pass), or by each factor (paper 002 §6.4, second method).

use std::sync::Arc;

use wgpu::TextureFormat;

use super::assembly::{Assembly, engine_shader};
use super::segments::Part;
use super::states::{FREE_WHERE_COUNTED, TIMES_ONE_MINUS_CONSTANT, WHERE_COUNTED};
use super::surfaces::Surfaces;
use crate::plan::{
    Access, Binding, BlendState, BufferUsage, ColorTarget, CompareFunction, DepthTarget, Draw, DrawState,
    Load, MULTIPLY, Pass, SlotKind, SurfaceStyle,
};
use crate::shadow::hash_of;

impl Assembly<'_> {
    /// Counts all lights of `counting` at once and darkens what is in any of their shadows.
    pub(super) fn darken(&mut self, counting: Vec<Pass>, weight: f64) {
        self.b.passes.extend(counting);
        self.forget_where_nothing_is_received();
        let mut state = DrawState::new(CompareFunction::Less, vec![Some(TIMES_ONE_MINUS_CONSTANT)]);
        state.blend_constant = [weight, weight, weight, 0.0];
        state.stencil = Some(WHERE_COUNTED);
        // The draw lies at depth 0, infinitely far: whatever is nearer is a surface, and the sky stays as it is.
        let draw = self.resolve_draw("darken", state);
        self.b.passes.push(Pass {
            name: "darkening".into(),
            reason: format!(
                "the finished picture loses {weight} of its light, once, where any light is blocked"
            ),
            colors: vec![ColorTarget { slot: self.drawn, layer: 0, load: Load::Keep, resolve: None }],
            depth: Some(self.depth_read()),
            draws: vec![draw],
        });
    }

    /// Darkens the finished picture by the factor that the passes of `part` leave for `light`.
    pub(super) fn darken_by(&mut self, light: &str, part: Part) {
        // Nothing that could cast was in view.
        if part.layer.is_none() && !part.is_counted() {
            return;
        }
        self.passes_of(&part, light);
        let reason = format!("the finished picture is darkened where {light} is blocked");
        let draw = match part.layer {
            Some(layer) => {
                self.light_where_nothing_is_received(layer);
                self.darken_by_visibility(layer, part.taken)
            }
            None => {
                self.forget_where_nothing_is_received();
                let mut state = DrawState::new(CompareFunction::Less, vec![Some(TIMES_ONE_MINUS_CONSTANT)]);
                let [r, g, b] = part.taken.map(f64::from);
                state.blend_constant = [r, g, b, 0.0];
                // Counts in front of the sky stay; nothing is ever shadowed there.
                state.stencil = Some(FREE_WHERE_COUNTED);
                self.resolve_draw("darken", state)
            }
        };
        let counted = part.is_counted().then_some(Access::Keep);
        let mut depth = self.depth_read();
        depth.stencil = depth.stencil.map(|read| counted.unwrap_or(read));
        self.b.passes.push(Pass {
            name: format!("darkening by {light}"),
            reason,
            colors: vec![ColorTarget { slot: self.drawn, layer: 0, load: Load::Keep, resolve: None }],
            depth: Some(depth),
            draws: vec![draw],
        });
    }

    fn darken_by_visibility(&mut self, layer: u32, taken: [f32; 3]) -> Draw {
        let [r, g, b] = taken;
        let contents = Arc::new(bytemuck::cast_slice(&[r, g, b, 0.0]).to_vec());
        let key = hash_of(("darkening", taken.map(f32::to_bits)));
        let reason = "what the picture loses where nothing of the light is visible";
        let taken = self.b.buffer("darkening", BufferUsage::Storage, key, contents, reason);
        let one_channel = matches!(
            self.b.slots[self.visibility.0].kind,
            SlotKind::Texture { format: TextureFormat::R16Float, .. }
        );
        let flags: &[&str] = if one_channel { &["ONE_CHANNEL"] } else { &[] };
        // At depth 0, as above.
        let mut draw =
            self.resolve_draw("darken_by", DrawState::new(CompareFunction::Less, vec![Some(MULTIPLY)]));
        draw.shader = Some(engine_shader("darken_picture", flags, "fullscreen_vertex", Some("darken_by")));
        draw.bindings =
            vec![(0, Binding::Storage(taken)), (1, Binding::TextureLayer(self.visibility, layer))];
        draw
    }

    /// Sets the visibility to 1 where surfaces are seen that receive no shadows.
    fn light_where_nothing_is_received(&mut self, layer: u32) {
        let parts = self.receive_nothing();
        if parts.is_empty() {
            return;
        }
        let state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
        // Of a factor that is in no place and holds its own shadows nothing is left but 1.
        let shader: (_, &[&str], _) = ("surface_factor", &["OWN_SHADOW"], "factor");
        let draws = self.pulled_draws(&parts, shader, &state, &[]);
        self.b.passes.push(Pass {
            name: "unmark".into(),
            reason: "surfaces that receive no shadows are not darkened".into(),
            colors: vec![ColorTarget { slot: self.visibility, layer, load: Load::Keep, resolve: None }],
            depth: Some(self.depth_read()),
            draws,
        });
    }

    /// The opaque parts in view that receive no shadows.
    fn receive_nothing(&self) -> Vec<(u32, u32)> {
        let receives_nothing = |&&(instance, part): &&(u32, u32)| {
            let instance = &self.posed.instances[instance as usize];
            !instance.shadow.receives || instance.materials[part as usize].unlit
        };
        self.surfaces.opaque.iter().filter(receives_nothing).copied().collect()
    }

    /// Sets counts back where surfaces are seen that receive no shadows.
    fn forget_where_nothing_is_received(&mut self) {
        let parts = self.receive_nothing();
        if parts.is_empty() {
            return;
        }
        let mut state = DrawState::new(CompareFunction::Equal, vec![]);
        state.stencil = Some(FREE_WHERE_COUNTED);
        let draw = Draw {
            name: "surfaces that receive nothing".into(),
            shader: None,
            state,
            geometry: Surfaces::geometry(self.posed, SurfaceStyle::Depth, &parts),
            bindings: vec![],
            scissor_px: None,
        };
        let reason = "surfaces that receive no shadows are not darkened";
        self.b.passes.push(self.stencil_pass("unmark".into(), reason, draw));
    }

    /// Sets counts back after one light's factor was taken from them.
    pub(super) fn forget_counts(&self, light: &str) -> Pass {
        let draw = self.resolve_draw(
            "mark",
            DrawState {
                stencil: Some(FREE_WHERE_COUNTED),
                ..DrawState::new(CompareFunction::Always, vec![])
            },
        );
        let reason = "its factor is kept, and the stencil is free again";
        self.stencil_pass(format!("forget counts of {light}"), reason, draw)
    }

    fn stencil_pass(&self, name: String, reason: &str, draw: Draw) -> Pass {
        Pass {
            name,
            reason: reason.into(),
            colors: vec![],
            depth: Some(DepthTarget {
                slot: self.depth,
                depth: Access::ReadOnly,
                stencil: Some(Access::Keep),
            }),
            draws: vec![draw],
        }
    }
}
