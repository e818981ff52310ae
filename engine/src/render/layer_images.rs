//! The factors of lights on layers of transparent surfaces as images, where they were asked for: for measuring.
//!
//! Pictures need their layers from behind, and it matters to none which triangle a pixel of a layer belongs to. Who
//! compares factors wants both: here a *layer* is the n-th surface from the eye at every pixel, nearest first, each the
//! nearest behind the last one, with its instance and triangle. Of two surfaces at one depth each is a layer.

use super::factor_images::format_of;
use super::factors::{Factors, Part};
use super::layered::{Layered, LookedAt};
use super::lights::ReceiverPasses;
use super::reach;
use super::request::FrameError;
use super::resolve::{self, fullscreen};
use super::schedule::{Group, Inputs, Needs, Schedule, Scope, Seen};
use super::seen::{self, no_triangle};
use crate::plan::{
    Access, BlendState, CompareFunction, DepthId, DrawState, FactorAt, LightPlanned, Load, PulledStyle,
    Resource, Shader, ShaderError, SlotId, TextureFormat,
};
use crate::shadow::{Binding, ColorTarget, DepthTarget, Draw, Layer, Pass};

/// Has all lights plan `on` those layers in view whose factors were asked for, and on those before them.
///
/// # Errors
/// What the techniques refuse.
pub(super) fn plan(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    in_view: u32,
    on: &mut dyn FnMut(&mut Needs, DepthId, Layer) -> Result<ReceiverPasses, FrameError>,
) -> Result<Vec<LookedAt>, FrameError> {
    let wanted = inputs.request.layer_factors.clone();
    let wanted = if inputs.request.factors { wanted } else { 0..0 };
    let reason = "factors on layers were asked for";
    let count = if wanted.is_empty() { 0 } else { wanted.end.min(in_view) };
    let mut looked_at: Vec<LookedAt> = Vec::new();
    for layer in 0..count {
        // Even and odd ones take turns, unless they are kept.
        let before = layer.checked_sub(2).map(|before| &looked_at[before as usize]);
        let depth = match before {
            Some(before) => before.receivers.depth,
            None => needs.depth(format!("depth looked at, layer {layer}"), 1, reason),
        };
        let kept = wanted.contains(&layer);
        let triangles = match before.filter(|before| !kept && !before.kept) {
            Some(before) => before.triangles,
            None => {
                let name = format!("triangles of layer {layer}");
                needs.texture(&name, TextureFormat::Rg32Uint, inputs.view.size_px, reason)
            }
        };
        let receivers = on(needs, depth, Layer::FromEye(layer))?;
        looked_at.push(LookedAt { receivers, triangles, kept });
    }
    Ok(looked_at)
}

/// Peels these layers off, one after the other, and draws the images of those that are kept.
///
/// # Errors
/// What is wrong with a shader.
pub(super) fn draw<'p>(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'p>,
    layers: &'p Layered,
    (factors, lights): (&Factors, &mut [LightPlanned]),
) -> Result<(), FrameError> {
    let receivers = layers.looked_at.iter().map(|layer| &layer.receivers);
    let planes = Seen::asked_by(inputs, needs, receivers).planes;
    let mut last = None;
    for (number, layer) in layers.looked_at.iter().enumerate() {
        let LookedAt { receivers, triangles, kept } = layer;
        let scope = Scope {
            depth: receivers.depth,
            seen: Seen { triangles: Some(*triangles), planes, depth: None },
            place: format!(" on layer {number}"),
            ..Scope::default()
        };
        schedule.push(&scope, peel(inputs, last, *triangles)?);
        if *kept {
            if receivers.are_shadowed() {
                let seen = Seen { triangles: None, planes, depth: None };
                seen::add_on_layer(inputs, schedule, &Scope { seen, ..scope.clone() })?;
            }
            images_of(inputs, needs, schedule, (number, receivers, &scope), (factors, lights))?;
        }
        last = Some((receivers.depth, *triangles));
    }
    Ok(())
}

/// The factor of every light that has one on layer number `layer`.
fn images_of<'p>(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'p>,
    (layer, receivers, scope): (usize, &'p ReceiverPasses, &Scope),
    (factors, lights): (&Factors, &mut [LightPlanned]),
) -> Result<(), FrameError> {
    let shadowed = receivers.are_shadowed();
    let claimed = |light: usize| !inputs.registry.lights[light].is_empty();
    // A later light may count as well, whatever else it has.
    let mut counting = factors.lights.iter().enumerate().rev();
    let last = counting.find(|(light, f)| claimed(*light) && f.on_layers().is_some_and(|part| part.counts));
    let last = last.map(|(light, _)| light);
    for (index, light) in lights.iter_mut().enumerate().filter(|(index, _)| claimed(*index)) {
        let part = factors.lights[index].on_layers().filter(|_| shadowed);
        let mut group = match part {
            Some(part) => part.group(scope, &receivers.lights[index], &light.name)?,
            None => Group::new(scope),
        };
        let at = part.map_or(FactorAt::Lit, Part::place);
        let image = layer_factor_image(inputs, needs, &mut group, (layer, &light.name), (factors, at))?;
        light.layer_factor_images.push(image);
        if last.is_some_and(|last| last > index) && part.is_some_and(Part::is_counted) {
            group.push(resolve::to_nothing(&light.name)?);
        }
        reach::confine(&mut group, inputs.view, &inputs.snapshot.lights[index]);
        schedule.push_group(group);
    }
    Ok(())
}

/// Finds the next layer: its depth into the receivers' depth, instance and triangle into `triangles`.
fn peel(
    inputs: &Inputs<'_>,
    last: Option<(DepthId, SlotId)>,
    triangles: SlotId,
) -> Result<Pass, ShaderError> {
    let mut flags = vec!["BASE_COLOR_TEXTURE", "SECOND_UV"];
    let mut bindings = vec![(3, Binding::Texture(DepthId::default().resource()))];
    if let Some((last_depth, last_triangles)) = last {
        flags.push("BEHIND");
        bindings.push((4, Binding::Texture(last_depth.resource())));
        bindings.push((5, Binding::Texture(last_triangles.into())));
    }
    let mut state = DrawState::new(CompareFunction::Greater, vec![Some(BlendState::REPLACE)]);
    state.depth_write = true;
    let shader = Shader::composed("surface_peel", &flags, "vertex", Some("peel"))?;
    let geometry = inputs.pulled(shader, PulledStyle::PulledMasked, &inputs.surfaces.transparent);
    Ok(Pass {
        name: "peel".into(),
        reason: "the nearest transparent surface behind the last layer".into(),
        colors: vec![ColorTarget::new(triangles, no_triangle())],
        depth: Some(DepthTarget::new(Resource::RECEIVER_DEPTH, Access::Clear(0.0))),
        draws: vec![Draw::new("transparent surfaces", geometry, state).reading(bindings)],
    })
}

/// The factor of one light on a layer as a linear image.
fn layer_factor_image(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    group: &mut Group<'_>,
    (layer, light): (usize, &str),
    (factors, at): (&Factors, FactorAt),
) -> Result<SlotId, ShaderError> {
    let mut bindings: Vec<_> =
        group.scope.seen.triangles.map(|slot| (0, Binding::Texture(slot.into()))).into_iter().collect();
    let flags: &[&str] = match at {
        FactorAt::Counts | FactorAt::MaskBit(_) => {
            bindings.push((1, Binding::StencilOf(Resource::RECEIVER_DEPTH)));
            &["COUNTS"]
        }
        FactorAt::Visibility(_) => {
            bindings.push((1, Binding::Texture(Resource::VISIBILITY)));
            &["VISIBILITY"]
        }
        FactorAt::Lit | FactorAt::Darkening => &[],
    };
    let name = format!("factor of {light}");
    let size_px = inputs.view.size_px;
    let slot =
        needs.texture(&format!("{name} on layer {layer}"), format_of(factors, at), size_px, "asked for");
    let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
    let draw = fullscreen("factor", ("layer_images", flags, "factor"), state)?;
    group.push(Pass {
        name,
        reason: "the factor on this layer was asked for as an image".into(),
        colors: vec![ColorTarget::new(slot, Load::Clear([1.0; 4]))],
        depth: None,
        draws: vec![draw.reading(bindings)],
    });
    Ok(slot)
}
