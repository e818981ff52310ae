//! Darkening the finished picture instead of taking each light's own light away: once for all counts (Lindrud & Löfgren
//! 2004 §5.3, single pass), or by each factor (paper 002 §6.4, second method).

use std::sync::Arc;

use super::factors::{Factors, Part};
use super::lights::ReceiverPasses;
use super::request::FrameError;
use super::resolve::{draw, fullscreen};
use super::schedule::{Group, Inputs, Needs, Schedule, Scope};
use super::states::{FREE_WHERE_COUNTED, TIMES_ONE_MINUS_CONSTANT, WHERE_COUNTED};
use crate::plan::{
    BlendState, BufferDesc, BufferUsage, CompareFunction, DrawState, Load, MULTIPLY, Resource, ShaderError,
    SlotId, SurfaceStyle,
};
use crate::shadow::{Binding, Channels, ColorTarget, DepthTarget, Draw, Pass, hash_of};

/// Darkens the finished `picture`: by each factor that asks for it, then once by all counts that are put together.
pub(super) fn add<'p>(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'p>,
    (picture, scope): (SlotId, &Scope),
    factors: &Factors,
    opaque: &'p ReceiverPasses,
) -> Result<(), FrameError> {
    let lights = || factors.lights.iter().zip(&opaque.lights).zip(&inputs.snapshot.lights);
    for ((light, nodes), snapshot) in lights() {
        for part in &light.after {
            let mut group = part.group(scope, nodes, &snapshot.name)?;
            by_factor(inputs, needs, &mut group, (picture, part), (factors, &snapshot.name))?;
            schedule.push_group(group);
        }
    }
    let Some(weight) = factors.once_weight else { return Ok(()) };
    let mut group = Group::new(scope);
    for ((light, nodes), snapshot) in lights() {
        if let Some(part) = &light.once {
            group.passes.extend(part.group(scope, nodes, &snapshot.name)?.passes);
        }
    }
    once(inputs, &mut group, picture, weight)?;
    schedule.push_group(group);
    Ok(())
}

/// Darkens what is in the shadow of any light that was counted.
fn once(inputs: &Inputs<'_>, group: &mut Group<'_>, picture: SlotId, weight: f64) -> Result<(), ShaderError> {
    forget_where_nothing_is_received(inputs, group);
    let mut state = DrawState::new(CompareFunction::Less, vec![Some(TIMES_ONE_MINUS_CONSTANT)]);
    state.blend_constant = [weight, weight, weight, 0.0];
    state.stencil = Some(WHERE_COUNTED);
    group.push(Pass {
        name: "darkening".into(),
        reason: format!("the finished picture loses {weight} of its light, once, where any light is blocked"),
        colors: vec![ColorTarget::new(picture, Load::Keep)],
        depth: Some(DepthTarget::TEST),
        // The draw lies at depth 0, infinitely far: whatever is nearer is a surface, and the sky stays as it is.
        draws: vec![draw("darken", state)?],
    });
    Ok(())
}

/// Darkens the finished picture by the factor that the passes of `part` leave for `light`.
fn by_factor(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    group: &mut Group<'_>,
    (picture, part): (SlotId, &Part),
    (factors, light): (&Factors, &str),
) -> Result<(), ShaderError> {
    let (draw, depth) = if part.layer.is_some() {
        light_where_nothing_is_received(inputs, group)?;
        (by_visibility(needs, part.max_darkening, factors.channels)?, DepthTarget::TEST)
    } else {
        forget_where_nothing_is_received(inputs, group);
        let mut state = DrawState::new(CompareFunction::Less, vec![Some(TIMES_ONE_MINUS_CONSTANT)]);
        let [r, g, b] = part.max_darkening.map(f64::from);
        state.blend_constant = [r, g, b, 0.0];
        // Counts in front of the sky stay; nothing is ever shadowed there.
        state.stencil = Some(FREE_WHERE_COUNTED);
        (draw("darken", state)?, DepthTarget::COUNT)
    };
    group.push(Pass {
        name: format!("darkening by {light}"),
        reason: format!("the finished picture is darkened where {light} is blocked"),
        colors: vec![ColorTarget::new(picture, Load::Keep)],
        depth: Some(depth),
        draws: vec![draw],
    });
    Ok(())
}

fn by_visibility(
    needs: &mut Needs,
    max_darkening: [f32; 3],
    channels: Channels,
) -> Result<Draw, ShaderError> {
    let [r, g, b] = max_darkening;
    let max_darkening = needs.slots.buffer(BufferDesc {
        name: "darkening",
        usage: BufferUsage::Storage,
        revision_key: hash_of(("darkening", max_darkening.map(f32::to_bits))),
        contents: Arc::new(bytemuck::cast_slice(&[r, g, b, 0.0]).to_vec()),
        reason: "what the picture loses where nothing of the light is visible",
    });
    let flags: &[&str] = if channels == Channels::One { &["ONE_CHANNEL"] } else { &[] };
    // At depth 0, as above.
    let state = DrawState::new(CompareFunction::Less, vec![Some(MULTIPLY)]);
    let draw = fullscreen("darken_by", ("darken_picture", flags, "darken_by"), state)?;
    let visibility = Binding::Texture(Resource::VISIBILITY);
    Ok(draw.reading(vec![(0, Binding::Storage(max_darkening.into())), (1, visibility)]))
}

/// The opaque parts in view that receive no shadows.
fn receiving_nothing(inputs: &Inputs<'_>) -> Vec<(u32, u32)> {
    let receives_nothing = |&&(instance, part): &&(u32, u32)| {
        let instance = &inputs.snapshot.instances[instance as usize];
        !instance.shadow.receives || instance.materials[part as usize].unlit
    };
    inputs.surfaces.opaque.iter().filter(receives_nothing).copied().collect()
}

const NOT_DARKENED: &str = "surfaces that receive no shadows are not darkened";

/// Sets the visibility to 1 where surfaces are seen that receive no shadows.
fn light_where_nothing_is_received(inputs: &Inputs<'_>, group: &mut Group<'_>) -> Result<(), ShaderError> {
    let parts = receiving_nothing(inputs);
    if parts.is_empty() {
        return Ok(());
    }
    let state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
    // Of a factor that is in no place and holds its own shadows nothing is left but 1.
    let draws = inputs.pulled_runs(&parts, ("surface_factor", &["OWN_SHADOW"], "factor"), &state, &[])?;
    group.push(Pass {
        name: "unmark".into(),
        reason: NOT_DARKENED.into(),
        colors: vec![ColorTarget::VISIBILITY],
        depth: Some(DepthTarget::TEST),
        draws,
    });
    Ok(())
}

/// Sets counts back where surfaces are seen that receive no shadows.
fn forget_where_nothing_is_received(inputs: &Inputs<'_>, group: &mut Group<'_>) {
    let parts = receiving_nothing(inputs);
    if parts.is_empty() {
        return;
    }
    let mut state = DrawState::new(CompareFunction::Equal, vec![]);
    state.stencil = Some(FREE_WHERE_COUNTED);
    let draw = Draw::new("surfaces that receive nothing", inputs.shown(SurfaceStyle::Depth, &parts), state);
    group.push(Pass {
        name: "unmark".into(),
        reason: NOT_DARKENED.into(),
        colors: vec![],
        depth: Some(DepthTarget::COUNT),
        draws: vec![draw],
    });
}
