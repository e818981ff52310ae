//! The one pass that shades what is seen, with the factors of all lights.

use std::sync::Arc;

use super::factors::Factors;
use super::light_tiles;
use super::request::FrameError;
use super::schedule::{Inputs, Needs, Schedule, Scope};
use super::sorted::Sorted;
use super::surface_functions;
use crate::gpu::TintUniform;
use crate::plan::{
    Access, BlendState, BufferDesc, BufferUsage, CompareFunction, DepthId, DrawState, FULL_DARKENING,
    FactorAt, LightPlanned, Load, Resource, SlotId, SurfaceStyle, Symbol,
};
use crate::shadow::{Binding, ColorTarget, DepthTarget, Draw, Pass, hash_of};

/// What is there when surfaces are shaded.
#[derive(Clone, Copy)]
pub(super) struct Before {
    /// Whether the depth of all opaque surfaces is drawn already.
    pub(super) prepass: bool,
    /// Whether transparent surfaces are drawn in layers.
    pub(super) layered: bool,
}

/// Shades what is opaque into `picture` by all lights at once; and what is transparent, unless that is drawn in layers.
pub(super) fn add(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'_>,
    (picture, before): (SlotId, Before),
    factors: &Factors,
    lights: &[LightPlanned],
) -> Result<(), FrameError> {
    let background = inputs.snapshot.background.as_dvec3();
    let mut bindings = factor_bindings(inputs, needs, factors, lights);
    if inputs.is_multisampled() && !bindings.is_empty() {
        // Which samples show the fragment that is shaded: their factors are averaged.
        bindings.push((3, Binding::Texture(DepthId::default().resource())));
    }
    bindings.extend(light_tiles::add(inputs, needs).map(|tiles| (10, Binding::Storage(tiles.into()))));
    let mut state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
    let mut depth = DepthTarget::TEST;
    if !before.prepass {
        state.depth_compare = CompareFunction::Greater;
        state.depth_write = true;
        depth.depth = Access::Clear(0.0);
    }
    let opaque = inputs.opaque(SurfaceStyle::Opaque);
    let mut draws = vec![Draw::new("opaque surfaces", opaque, state).reading(bindings)];
    if !before.layered && !inputs.surfaces.blended.is_empty() {
        draws.extend(Sorted::all().draws(inputs));
        needs.note("blended surfaces are lit without shadows: factors are those of the opaque surface");
    }
    needs.notes.extend(surface_functions::notes(inputs.snapshot, inputs.surfaces, lights));
    let reason = match lights.len() {
        0 => "ambient light only".to_owned(),
        1 => "the only light".into(),
        n => format!("all {n} lights at once"),
    };
    let load = Load::Clear([background.x, background.y, background.z, 1.0]);
    schedule.push(
        &Scope::default(),
        Pass {
            name: "shading".into(),
            reason: reason + &surface_functions::reason(inputs.snapshot, inputs.surfaces),
            colors: vec![ColorTarget::new(picture, load)],
            depth: Some(depth),
            draws,
        },
    );
    Ok(())
}

/// Where shading finds the factors of all lights on the receivers, and their weights.
pub(super) fn factor_bindings(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    factors: &Factors,
    lights: &[LightPlanned],
) -> Vec<(u32, Binding)> {
    let mut bindings = Vec::new();
    let any = |wanted: &dyn Fn(FactorAt) -> bool| {
        lights.iter().flat_map(LightPlanned::factors).any(|part| wanted(part.at))
    };
    if any(&|at| at == FactorAt::Counts) {
        bindings.push((0, Binding::StencilOf(Resource::RECEIVER_DEPTH)));
    }
    bindings.extend(factors.mask.map(|mask| match inputs.is_multisampled() {
        true => (1, Binding::Texture(mask.into())),
        false => (1, Binding::TextureArray(mask.into())),
    }));
    if any(&|at| matches!(at, FactorAt::Visibility(_))) {
        bindings.push((2, Binding::TextureArray(Resource(Symbol::AllVisibilities))));
    }
    bindings.extend(tints(needs, lights).map(|tints| (7, Binding::Storage(tints.into()))));
    bindings
}

/// What the picture loses where factors are 0, as `tints` of surface_shade: an entry for each light, and after them
/// one for each further factor. `None` when shadows take everything, each light's in one factor.
fn tints(needs: &mut Needs, lights: &[LightPlanned]) -> Option<SlotId> {
    if lights.iter().all(|light| light.max_darkening == FULL_DARKENING && light.more_factors.is_empty()) {
        return None;
    }
    let (mut tints, mut further) = (Vec::new(), Vec::new());
    for light in lights {
        let first = (lights.len() + further.len()) as u32;
        let count = light.more_factors.len() as u32;
        for (part, at) in light.factors().zip(0..) {
            let [kind, index] = part.at.kind_and_index();
            // Each names the next; the last one none.
            let next = if at < count { first + at } else { 0 };
            let tint =
                TintUniform { max_darkening: part.max_darkening, next, kind, index, pad_0: 0, pad_1: 0 };
            if at == 0 { tints.push(tint) } else { further.push(tint) }
        }
    }
    tints.extend(further);
    let bytes: Vec<u8> = bytemuck::cast_slice(&tints).to_vec();
    Some(needs.slots.buffer(BufferDesc {
        name: "tints",
        usage: BufferUsage::Storage,
        revision_key: hash_of(("tints", &bytes)),
        contents: Arc::new(bytes),
        reason: "weights and colours of shadows: what the picture loses where a factor is 0",
    }))
}
