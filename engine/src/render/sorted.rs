//! Transparent surfaces blended far to near by the middles of what they belong to. Surfaces of one object, or that pass
//! through one another, may blend in a wrong order so, unless the draws are of one layer: see [`super::layers`].

use super::schedule::Inputs;
use crate::plan::{BlendState, CompareFunction, DepthId, DrawState, Load, MULTIPLY, SlotId, SurfaceStyle};
use crate::shadow::{Binding, ColorTarget, DepthTarget, Draw, Pass};

/// Which of the transparent surfaces are blended, and with what.
pub(super) struct Sorted {
    /// How they lie to the depth that is attached.
    pub(super) compare: CompareFunction,
    /// Only those behind this depth.
    pub(super) behind: Option<DepthId>,
    /// Where the factors of lights on them are; none where they are lit without shadows.
    pub(super) factors: Vec<(u32, Binding)>,
}

impl Sorted {
    /// All of them before the opaque surfaces, lit without shadows.
    pub(super) fn all() -> Self {
        Self { compare: CompareFunction::Greater, behind: None, factors: vec![] }
    }

    /// A pass of its own that blends them over `picture`.
    pub(super) fn pass(&self, inputs: &Inputs<'_>, picture: SlotId, (name, reason): (&str, &str)) -> Pass {
        Pass {
            name: name.into(),
            reason: reason.into(),
            colors: vec![ColorTarget::new(picture, Load::Keep)],
            depth: Some(DepthTarget::TEST),
            draws: self.draws(inputs),
        }
    }

    /// Transparent surfaces far to near by their middles.
    pub(super) fn draws(&self, inputs: &Inputs<'_>) -> Vec<Draw> {
        let transmits = |&(instance, part): &(u32, u32)| {
            inputs.snapshot.instances[instance as usize].materials[part as usize].transmission > 0.0
        };
        let behind = self.behind.map(|depth| (9, Binding::Texture(depth.resource())));
        let draw = |name: &str, style, parts: &[(u32, u32)], blend| {
            let state = DrawState::new(self.compare, vec![Some(blend)]);
            Draw::new(name, inputs.shown(style, parts), state).reading(behind.into_iter().collect())
        };
        let mut draws = Vec::new();
        for run in inputs.surfaces.blended.chunk_by(|a, b| !transmits(a) && !transmits(b)) {
            // What shines through in colour takes that colour on first.
            if run.iter().any(transmits) {
                draws.push(draw("tint", SurfaceStyle::Tint, run, MULTIPLY));
            }
            let blend = BlendState::PREMULTIPLIED_ALPHA_BLENDING;
            let mut blended = draw("blended surfaces", SurfaceStyle::Blended, run, blend);
            blended.bindings.extend(&self.factors);
            draws.push(blended);
        }
        draws
    }
}
