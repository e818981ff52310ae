//! Transparent surfaces blended far to near by the middles of what they belong to. Surfaces of one object, or that pass
//! through one another, may blend in a wrong order so, unless the draws are of one layer: see [`super::layers`].

use super::assembly::Assembly;
use super::surfaces::Surfaces;
use crate::plan::{
    Binding, BlendState, ColorTarget, CompareFunction, Draw, DrawState, Load, MULTIPLY, Pass, SlotId,
    SurfaceStyle,
};

/// Which of the transparent surfaces are blended, and with what.
pub(super) struct Sorted {
    /// How they lie to the depth that is attached.
    pub(super) compare: CompareFunction,
    /// Only those behind this depth.
    pub(super) behind: Option<SlotId>,
    /// Where the factors of lights on them are; none where they are lit without shadows.
    pub(super) factors: Vec<(u32, Binding)>,
}

impl Sorted {
    /// All of them before the opaque surfaces, lit without shadows.
    pub(super) fn all() -> Self {
        Self { compare: CompareFunction::Greater, behind: None, factors: vec![] }
    }
}

impl Assembly<'_> {
    /// Blends them over the picture, in a pass of its own.
    pub(super) fn blend(&mut self, name: &str, reason: &str, sorted: &Sorted) {
        let target = ColorTarget { slot: self.drawn, layer: 0, load: Load::Keep, resolve: None };
        self.b.passes.push(Pass {
            name: name.into(),
            reason: reason.into(),
            colors: vec![target],
            depth: Some(self.depth_read()),
            draws: self.sorted_draws(sorted),
        });
    }

    /// Transparent surfaces far to near by their middles.
    pub(super) fn sorted_draws(&self, sorted: &Sorted) -> Vec<Draw> {
        let transmits = |&(instance, part): &(u32, u32)| {
            self.posed.instances[instance as usize].materials[part as usize].transmission > 0.0
        };
        let draw = |name: &str, style, parts: &[(u32, u32)], blend| Draw {
            name: name.into(),
            shader: None,
            state: DrawState::new(sorted.compare, vec![Some(blend)]),
            geometry: Surfaces::geometry(self.posed, style, parts),
            bindings: sorted.behind.map(|depth| (9, Binding::Texture(depth))).into_iter().collect(),
            scissor_px: None,
        };
        let mut draws = Vec::new();
        for run in self.surfaces.blended.chunk_by(|a, b| !transmits(a) && !transmits(b)) {
            // What shines through in colour takes that colour on first.
            if run.iter().any(transmits) {
                draws.push(draw("tint", SurfaceStyle::Tint, run, MULTIPLY));
            }
            let blend = BlendState::PREMULTIPLIED_ALPHA_BLENDING;
            let mut blended = draw("blended surfaces", SurfaceStyle::Blended, run, blend);
            blended.bindings.extend(&sorted.factors);
            draws.push(blended);
        }
        draws
    }
}
