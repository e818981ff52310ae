//! Turning counts in the stencil into something that stays, and setting them back for the next light.

use super::states::{ADD_CONSTANT, FREE_WHERE_COUNTED};
use crate::plan::{BlendState, CompareFunction, DrawState, Load, Shader, ShaderError, SlotId};
use crate::shadow::{ColorTarget, DepthTarget, Draw, Geometry, Pass};

/// A draw over all pixels by an entry point of resolve_mask, of the same name.
pub(super) fn draw(fragment: &'static str, state: DrawState) -> Result<Draw, ShaderError> {
    fullscreen(fragment, ("resolve_mask", &[], fragment), state)
}

/// A draw over all pixels by (module, flags, fragment entry point) of the engine's own shaders.
pub(super) fn fullscreen(
    name: &str,
    (module, flags, fragment): (&'static str, &[&str], &'static str),
    state: DrawState,
) -> Result<Draw, ShaderError> {
    let shader = Shader::composed(module, flags, "fullscreen_vertex", Some(fragment))?;
    Ok(Draw::new(name, Geometry::fullscreen(shader), state))
}

/// Marks a light's shadow in the mask and sets counts back for the next light.
pub(super) fn to_mask(light: &str, mask: SlotId, bit: u32) -> Result<Pass, ShaderError> {
    let mut state = DrawState::new(CompareFunction::Always, vec![Some(ADD_CONSTANT)]);
    state.blend_constant[(bit as usize / 8) % 4] = f64::from(1u32 << (bit % 8)) / 255.0;
    state.stencil = Some(FREE_WHERE_COUNTED);
    let load = if bit.is_multiple_of(32) { Load::Clear([0.0; 4]) } else { Load::Keep };
    Ok(Pass {
        name: format!("resolve {light}"),
        reason: format!("its counts become bit {bit} of the light mask, and the stencil is free again"),
        colors: vec![ColorTarget { layer: bit / 32, ..ColorTarget::new(mask, load) }],
        depth: Some(DepthTarget::COUNT),
        draws: vec![draw("mark", state)?],
    })
}

/// Writes darkness where a light that also has a visibility was counted as shadowed.
pub(super) fn to_visibility(light: &str) -> Result<Pass, ShaderError> {
    let mut state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
    state.stencil = Some(FREE_WHERE_COUNTED);
    Ok(Pass {
        name: format!("resolve {light}"),
        reason: "its counts darken its visibility, and the stencil is free again".into(),
        colors: vec![ColorTarget::VISIBILITY],
        depth: Some(DepthTarget::COUNT),
        draws: vec![draw("darken", state)?],
    })
}

/// Sets counts back after one light's factor was taken from them.
pub(super) fn to_nothing(light: &str) -> Result<Pass, ShaderError> {
    let mut state = DrawState::new(CompareFunction::Always, vec![]);
    state.stencil = Some(FREE_WHERE_COUNTED);
    Ok(Pass {
        name: format!("forget counts of {light}"),
        reason: "its factor is kept, and the stencil is free again".into(),
        colors: vec![],
        depth: Some(DepthTarget::COUNT),
        draws: vec![draw("mark", state)?],
    })
}
