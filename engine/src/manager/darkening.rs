//! One darkening of the finished picture, instead of taking each light's own light away (Lindrud & Löfgren 2004 §5.3,
//! single pass).

use super::assembly::Assembly;
use super::states::{TIMES_ONE_MINUS_CONSTANT, WHERE_COUNTED, ZERO_WHERE_COUNTED};
use super::surfaces::Surfaces;
use crate::plan::{
    Access, ColorTarget, CompareFunction, DepthTarget, Draw, DrawState, Load, Pass, SurfaceStyle,
};

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

    /// Sets the stencil to zero where surfaces are seen that receive no shadows.
    fn forget_where_nothing_is_received(&mut self) {
        let receives_nothing = |&&(instance, part): &&(u32, u32)| {
            let instance = &self.posed.instances[instance as usize];
            !instance.shadow.receives || instance.materials[part as usize].unlit
        };
        let parts: Vec<(u32, u32)> = self.surfaces.opaque.iter().filter(receives_nothing).copied().collect();
        if parts.is_empty() {
            return;
        }
        let mut state = DrawState::new(CompareFunction::Equal, vec![]);
        state.stencil = Some(ZERO_WHERE_COUNTED);
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

    /// Sets the stencil back to zero after one light's factor was taken from it.
    pub(super) fn forget_counts(&self, light: &str) -> Pass {
        let draw = self.resolve_draw(
            "mark",
            DrawState {
                stencil: Some(ZERO_WHERE_COUNTED),
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
