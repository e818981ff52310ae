//! Transparent surfaces that shadows fall on, drawn in the order of every pixel.
//!
//! At every pixel the transparent surfaces before the opaque one are ordered by depth, and where surfaces pass through one
//! another each pixel by itself. The *nearest* of them is found first, as a depth of its own. Then the *farther* ones come
//! as layers, from behind: the farthest that is before the last layer and behind the nearest is found, as a depth; the
//! lights' techniques plan for it as they did for the opaque surfaces; it is shaded with their factors and blended over the
//! picture. The nearest comes last. So nothing is blended in a wrong order, and surfaces at one depth, which are in one
//! place and so in one shadow, are one layer, blended in the order of drawing.
//!
//! Where shadows fall on the nearest surface only (Kim, Kim & Turk, section 6), those behind it are blended without shadows,
//! far to near by their middles (see [`super::sorted`]): a depth, a count and a blend is all it adds.
//!
//! Memory does not grow with the number of layers, passes do. There are as many layers as the view may need
//! ([`super::layer_count`]); none of this is in the plan if no technique asks for layers, or nothing transparent is in
//! view. Factors on layers, numbered from the eye, are images on demand: see [`super::layer_images`].

use super::factors::Factors;
use super::layer_count::most_layers;
use super::layer_images;
use super::layered::Layered;
use super::lights::{self, ReceiverPasses};
use super::request::FrameError;
use super::schedule::{Inputs, Needs, Schedule, Scope, Seen};
use super::seen;
use super::shading::factor_bindings;
use super::sorted::Sorted;
use super::{reach, resolve};
use crate::plan::{
    Access, Antialias, CompareFunction, DepthId, DrawState, LightPlanned, Resource, SlotId, SurfaceStyle,
};
use crate::shadow::{Apply, Binding, DepthTarget, Draw, Layer, Layers, Pass, hash_of};

/// The most layers a frame draws: each takes its passes, and so does each light on it.
const MAX_LAYERS: u32 = 1024;

/// Plans all lights for every layer of transparent surfaces; `None` where no technique asks for layers or there is none.
///
/// # Errors
/// What the techniques refuse; several samples a pixel; more layers than a frame may have.
pub(super) fn plan(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    opaque: &ReceiverPasses,
) -> Result<Option<Layered>, FrameError> {
    let lights = inputs.registry.lights.iter().zip(&inputs.snapshot.lights);
    let reaching = lights.filter(|(_, light)| light.may_reach(&inputs.view.receiver_bounds));
    let claims = reaching.flat_map(|(claims, _)| claims);
    let asks = claims.max_by_key(|claim| claim.technique.traits().receiver_layers);
    let asks = asks.filter(|claim| claim.technique.traits().receiver_layers != Layers::OpaqueOnly);
    let (Some(claim), false) = (asks, inputs.surfaces.transparent.is_empty()) else { return Ok(None) };
    let asked_by = format!("'{}' ({})", claim.node, claim.label);
    if inputs.request.antialias == Antialias::Multisample4 {
        return Err(FrameError::MultisampledLayers { asked_by });
    }
    let in_view = layers_in_view(inputs);
    let layers = match claim.technique.traits().receiver_layers {
        Layers::All => in_view,
        Layers::First | Layers::OpaqueOnly => in_view.min(1),
    };
    if layers > MAX_LAYERS {
        return Err(FrameError::TooManyLayers { asked_by, layers, limit: MAX_LAYERS });
    }
    if layers == 0 {
        return Ok(None);
    }
    let darkens = darkening(opaque);
    let mut on =
        |needs: &mut Needs, depth: DepthId, layer: Layer| plan_on(inputs, needs, (depth, layer), &darkens);
    let reason = "where shadows fall on transparent surfaces";
    let nearest = needs.depth("depth of the nearest layer", 1, reason);
    let nearest = on(needs, nearest, Layer::FromEye(0))?;
    let names = ["depth of even layers", "depth of odd layers"];
    let names = names.iter().take(layers as usize - 1);
    let depths: Vec<DepthId> = names.map(|name| needs.depth(*name, 1, reason)).collect();
    let farther = (0..layers - 1).zip(depths.iter().cycle());
    let farther = farther.map(|(layer, depth)| on(needs, *depth, Layer::FromBehind(layer)));
    let farther = farther.collect::<Result<_, _>>()?;
    let looked_at = layer_images::plan(inputs, needs, in_view, &mut on)?;
    if darkens.contains(&true) {
        needs.note("lights that darken the finished picture leave transparent layers lit");
    }
    Ok(Some(Layered { nearest, farther, only_one: in_view == 1, looked_at }))
}

/// The lights whose shadows darken the finished picture, which is that of the opaque surfaces.
fn darkening(opaque: &ReceiverPasses) -> Vec<bool> {
    let darkens = |apply: &Apply| !matches!(apply, Apply::Light { .. });
    let nodes = opaque.lights.iter();
    nodes
        .map(|nodes| {
            let mut left = nodes.iter().map(|node| &node.contribution).filter(|left| left.is_some());
            left.any(|left| darkens(&left.apply))
        })
        .collect()
}

/// What all lights' techniques plan for one layer.
fn plan_on(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    (depth, layer): (DepthId, Layer),
    darkens: &[bool],
) -> Result<ReceiverPasses, FrameError> {
    // What is left out here was left out of the opaque surfaces' passes too.
    let notes = needs.notes.len();
    let planned = lights::plan(inputs, needs, (depth, Some(layer)), &|light| darkens[light])?;
    needs.notes.truncate(notes);
    Ok(planned)
}

/// The most layers at any pixel of this view.
fn layers_in_view(inputs: &Inputs<'_>) -> u32 {
    let Inputs { snapshot, view, surfaces, cache, .. } = *inputs;
    let worn = |(instance, part): &(u32, u32)| {
        let instance = &snapshot.instances[*instance as usize];
        (instance.pose_key, *part, instance.materials[*part as usize].double_sided)
    };
    let worn: Vec<_> = surfaces.transparent.iter().map(worn).collect();
    let key = hash_of(("layers", worn, format!("{:?}", view.camera), view.size_px));
    *cache.get_or_compute("layers in view", key, || most_layers(snapshot, view, &surfaces.transparent))
}

/// Blends all layers over `picture`, from behind.
///
/// # Errors
/// What is wrong with a shader.
pub(super) fn draw<'p>(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'p>,
    (layers, picture): (&'p Layered, SlotId),
    (factors, lights): (&Factors, &[LightPlanned]),
) -> Result<(), FrameError> {
    let opaque = DepthId::default();
    let seen = Seen::asked_by(inputs, needs, layers.drawn());
    let nearest = layers.nearest.depth;
    let scope = |receivers: &ReceiverPasses, place: String| Scope {
        depth: receivers.depth,
        seen,
        place,
        ..Scope::default()
    };
    let on_nearest = scope(&layers.nearest, " on the nearest layer".into());
    let reason = "where the nearest transparent surface is";
    schedule.push(&on_nearest, depth_before(inputs, opaque, None, reason));
    if layers.farther.is_empty() && !layers.only_one {
        let reason = "all transparent surfaces but the nearest, lit without shadows, far to near";
        let sorted = Sorted { behind: Some(nearest), ..Sorted::all() };
        schedule.push(&Scope::default(), sorted.pass(inputs, picture, ("farther surfaces", reason)));
    }
    let mut behind = opaque;
    for (layer, receivers) in layers.farther.iter().enumerate() {
        let scope = scope(receivers, format!(" on layer {layer} from behind"));
        let reason = "the farthest transparent surface before the last layer";
        schedule.push(&scope, depth_before(inputs, behind, Some(nearest), reason));
        shade(inputs, needs, schedule, (receivers, scope, picture), (factors, lights))?;
        behind = receivers.depth;
    }
    shade(inputs, needs, schedule, (&layers.nearest, on_nearest, picture), (factors, lights))
}

/// Draws into the receivers' depth: of all transparent surfaces before `behind` the nearest, or else the farthest of those
/// that are behind the `nearest`.
fn depth_before(inputs: &Inputs<'_>, behind: DepthId, nearest: Option<DepthId>, reason: &str) -> Pass {
    let mut bindings = vec![(0, Binding::Texture(behind.resource()))];
    bindings.extend(nearest.map(|nearest| (9, Binding::Texture(nearest.resource()))));
    let (compare, nothing) = match nearest {
        None => (CompareFunction::Greater, 0.0),
        Some(_) => (CompareFunction::Less, 1.0),
    };
    let mut state = DrawState::new(compare, vec![]);
    state.depth_write = true;
    let geometry = inputs.transparent(SurfaceStyle::Before);
    Pass {
        name: "depth".into(),
        reason: reason.into(),
        colors: vec![],
        depth: Some(DepthTarget::new(Resource::RECEIVER_DEPTH, Access::Clear(nothing))),
        draws: vec![Draw::new("transparent surfaces", geometry, state).reading(bindings)],
    }
}

/// Adds the lights' passes for one layer, and blends it over the picture.
fn shade<'p>(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'p>,
    (receivers, scope, picture): (&'p ReceiverPasses, Scope, SlotId),
    (factors, lights): (&Factors, &[LightPlanned]),
) -> Result<(), FrameError> {
    let shadowed = receivers.are_shadowed();
    if shadowed {
        seen::add_on_layer(inputs, schedule, &scope)?;
        let in_scene = factors.lights.iter().zip(&receivers.lights).zip(&inputs.snapshot.lights);
        for (((light, nodes), snapshot), planned) in in_scene.zip(lights) {
            for part in &light.shaded {
                let mut group = part.group(&scope, nodes, &planned.name)?;
                if let (Some(mask), Some(bit)) = (factors.mask, part.bit) {
                    group.push(resolve::to_mask(&planned.name, mask, bit)?);
                }
                reach::confine(&mut group, inputs.view, snapshot);
                schedule.push_group(group);
            }
        }
    }
    let bindings = if shadowed { factor_bindings(inputs, needs, factors, lights) } else { vec![] };
    let sorted = Sorted { compare: CompareFunction::Equal, behind: None, factors: bindings };
    let what = ("shading", "blended over what is behind it, with the shadows on it");
    schedule.push(&scope, sorted.pass(inputs, picture, what));
    Ok(())
}
