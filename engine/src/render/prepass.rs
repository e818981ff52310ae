//! The visible surface, before anything is shaded.

use super::schedule::{Inputs, Schedule, Scope};
use crate::plan::{Access, CompareFunction, DrawState, Resource, SurfaceStyle};
use crate::shadow::{DepthTarget, Draw, Geometry, Pass};

/// Draws the depth of all opaque surfaces, where something needs it before shading; says whether it does.
pub(super) fn add(inputs: &Inputs<'_>, schedule: &mut Schedule<'_>, shadowed: bool) -> bool {
    // Holes are cut before anything is shaded: what shades a pixel's samples at once cannot tell them apart.
    let holes = inputs.is_multisampled() && inputs.surfaces.have_holes(inputs.snapshot);
    if !(shadowed || inputs.request.factors || holes) {
        return false;
    }
    let mut state = DrawState::new(CompareFunction::Greater, vec![]);
    state.depth_write = true;
    let geometry: Geometry = inputs.opaque(SurfaceStyle::Depth);
    schedule.push(
        &Scope::default(),
        Pass {
            name: "depth prepass".into(),
            reason: "shadows need the visible surface before it is shaded".into(),
            colors: vec![],
            depth: Some(DepthTarget::new(Resource::RECEIVER_DEPTH, Access::Clear(0.0))),
            draws: vec![Draw::new("opaque surfaces", geometry, state)],
        },
    );
    true
}
