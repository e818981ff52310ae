//! Where each light's factors are once its passes have run: in the stencil, as a bit of the light mask, in a layer of the
//! visibility array.
//!
//! Nodes that neither weigh nor colour their shadow share one factor of their light; each of the others has a *part* of its
//! own. A part is in the same place on all receivers, so that shading needs only one place for it.

use std::borrow::Cow;

use super::layered::Layered;
use super::lights::{NodePasses, ReceiverPasses};
use super::request::FrameError;
use super::schedule::{Group, Inputs, Needs, Scope};
use super::{resolve, samples};
use crate::plan::{FULL_DARKENING, FactorAt, Resource, ShaderError, SlotId, TextureDesc, TextureFormat};
use crate::shadow::{Apply, Channels, ColorTarget, Pass, ShadowError};

/// One factor of a light: counts in a stencil at rest, a layer of the visibility, or both.
#[derive(Clone, Debug, Default)]
pub(super) struct Part {
    /// The light's claims that leave it.
    claims: Vec<usize>,
    pub(super) counts: bool,
    /// Its layer of the visibility array.
    pub(super) layer: Option<u32>,
    /// Its bit of the light mask.
    pub(super) bit: Option<u32>,
    /// What the picture loses where the factor is 0.
    pub(super) max_darkening: [f32; 3],
    /// What its passes are for beside shading.
    purpose: &'static str,
}

/// The factors of one light.
#[derive(Clone, Debug, Default)]
pub(super) struct LightFactors {
    /// What the light is shaded with, multiplied; none where it is lit everywhere.
    pub(super) shaded: Vec<Part>,
    /// The light's factor by itself, where an image of it was asked for and `shaded` is not it.
    pub(super) alone: Option<Part>,
    /// What darkens the finished picture instead, one after the other.
    pub(super) after: Vec<Part>,
    /// What darkens the finished picture together with other lights.
    pub(super) once: Option<Part>,
}

/// Where the factors of all lights are.
#[derive(Debug)]
pub(super) struct Factors {
    pub(super) lights: Vec<LightFactors>,
    /// Layers of the visibility array.
    pub(super) visibilities: u32,
    /// Channels of each.
    pub(super) channels: Channels,
    /// The bits of lights with counts.
    pub(super) mask: Option<SlotId>,
    /// The weight of the one darkening.
    pub(super) once_weight: Option<f64>,
}

impl Part {
    /// Where the factor is while it is the last that was left.
    pub(super) fn place(&self) -> FactorAt {
        match (self.counts, self.layer) {
            (_, Some(layer)) => FactorAt::Visibility(layer),
            (true, None) => FactorAt::Counts,
            (false, None) => FactorAt::Lit,
        }
    }

    /// Where shading finds it.
    pub(super) fn shaded_from(&self) -> FactorAt {
        self.bit.map_or(self.place(), FactorAt::MaskBit)
    }

    /// Whether its counts stay counts.
    pub(super) fn is_counted(&self) -> bool {
        self.place() == FactorAt::Counts
    }

    /// The passes that leave it on receivers of this `scope`, of what the light's `nodes` planned for them.
    ///
    /// # Errors
    /// What is wrong with a shader.
    pub(super) fn group<'p>(
        &self,
        scope: &Scope,
        nodes: &'p [NodePasses],
        light: &str,
    ) -> Result<Group<'p>, ShaderError> {
        let scope = Scope { visibility: self.layer, purpose: self.purpose, ..scope.clone() };
        let passes = self.claims.iter().filter_map(|claim| nodes.get(*claim)).flat_map(|node| &node.passes);
        let each_sample = scope.each_sample;
        let mut group = Group { scope, passes: passes.map(Cow::Borrowed).collect() };
        if self.layer.is_some() && !group.passes.iter().any(|pass| pass.draws_into(Resource::VISIBILITY)) {
            group.passes.insert(0, Cow::Owned(lit_visibility()));
        }
        if self.counts && self.layer.is_some() {
            if each_sample {
                group.push(samples::to_visibility(light)?);
                group.push(resolve::to_nothing(light)?);
            } else {
                group.push(resolve::to_visibility(light)?);
            }
        }
        Ok(group)
    }
}

/// Leaves a light's visibility at 1 where its techniques leave it alone and on other surfaces do not.
fn lit_visibility() -> Pass {
    Pass {
        name: "clear visibility".into(),
        reason: "nothing shadows it here, but on other surfaces".into(),
        colors: vec![ColorTarget::VISIBILITY],
        depth: None,
        draws: vec![],
    }
}

impl LightFactors {
    /// The light's factor as an image shows it; on transparent layers, where nothing darkens a finished picture.
    pub(super) fn on_layers(&self) -> Option<&Part> {
        let shades = self.after.is_empty() && self.once.is_none();
        self.alone.as_ref().or(self.shaded.first()).filter(|_| shades)
    }

    fn parts(&self) -> impl Iterator<Item = &Part> {
        self.alone.iter().chain(&self.shaded).chain(&self.after).chain(&self.once)
    }
}

impl Factors {
    /// Divides what the nodes left into parts, and gives each its place.
    ///
    /// # Errors
    /// [`ShadowError::LayersDiffer`] for a light that is weighted otherwise on some layer; more counted lights than a light
    /// mask of several samples holds.
    pub(super) fn place(
        inputs: &Inputs<'_>,
        needs: &mut Needs,
        opaque: &ReceiverPasses,
        layers: Option<&Layered>,
    ) -> Result<Self, FrameError> {
        let mut places = Places::default();
        let (mut lights, mut channels, mut once_weight) = (Vec::new(), None, None);
        for (index, nodes) in opaque.lights.iter().enumerate() {
            let on_layers = layers.into_iter().flat_map(Layered::receivers).map(|on| &on.lights[index][..]);
            let name = &inputs.snapshot.lights[index].name;
            let left = joined(name, nodes, on_layers)?;
            channels = channels.max(left.iter().filter_map(|left| left.visibility).max());
            let once = left.iter().find_map(|left| match left.apply {
                Apply::DarkenOnce { weight } => Some(weight),
                _ => None,
            });
            once_weight = once_weight.or(once);
            lights.push(divide(&left, &mut places, inputs.request.factors));
        }
        let parts = || lights.iter().flat_map(LightFactors::parts);
        let counting = parts().filter(|part| part.counts).count();
        let counted = lights.iter().flat_map(|light| &light.shaded).filter(|part| part.is_counted()).count();
        // One light with counts is shaded straight from the stencil, if nothing else counts in it.
        let mut mask = None;
        if counted > 0 && counting > 1 {
            mask = Some(light_mask(inputs, needs, counted as u32)?);
            let shaded = lights.iter_mut().flat_map(|light| &mut light.shaded);
            let bits = shaded.filter(|part| part.is_counted()).zip(0..);
            bits.for_each(|(part, bit)| part.bit = Some(bit));
        }
        let (visibilities, channels) = (places.visibilities, channels.unwrap_or(Channels::One));
        Ok(Self { lights, visibilities, channels, mask, once_weight })
    }

    /// Whether passes over the opaque surfaces leave any of them.
    pub(super) fn are_left_by_passes(&self, opaque: &ReceiverPasses) -> bool {
        let lights = self.lights.iter().zip(&opaque.lights);
        let mut parts = lights.flat_map(|(light, nodes)| light.parts().map(move |part| (part, nodes)));
        let has_passes = |claim: &usize, nodes: &[NodePasses]| {
            nodes.get(*claim).is_some_and(|node| !node.passes.is_empty())
        };
        parts.any(|(part, nodes)| {
            part.layer.is_some() || part.claims.iter().any(|claim| has_passes(claim, nodes))
        })
    }
}

/// What a node leaves of a light, whatever receives.
#[derive(Clone, Copy, Debug)]
struct Left {
    claim: usize,
    counts: bool,
    visibility: Option<Channels>,
    apply: Apply,
}

/// What the nodes of `light` leave on the opaque surfaces and on all layers; without those that leave nothing.
fn joined<'a>(
    light: &str,
    opaque: &[NodePasses],
    layers: impl Iterator<Item = &'a [NodePasses]>,
) -> Result<Vec<Left>, ShadowError> {
    let mut left: Vec<Left> = Vec::new();
    let numbered =
        |nodes: &'a [NodePasses]| nodes.iter().enumerate().map(|(claim, node)| (claim, node, true));
    let opaque = opaque.iter().enumerate().map(|(claim, node)| (claim, node, false));
    for (claim, node, on_layer) in opaque.chain(layers.flat_map(numbered)) {
        let here = &node.contribution;
        if !here.is_some() {
            continue;
        }
        let darkens = !matches!(here.apply, Apply::Light { .. });
        match left.iter_mut().find(|left| left.claim == claim) {
            Some(known) if known.apply == here.apply && !(on_layer && darkens) => {
                known.counts |= here.counts_bound.is_some();
                known.visibility = known.visibility.max(here.visibility);
            }
            None if !(on_layer && darkens) => {
                let (counts, visibility) = (here.counts_bound.is_some(), here.visibility);
                left.push(Left { claim, counts, visibility, apply: here.apply });
            }
            _ => return Err(ShadowError::LayersDiffer { light: light.into() }),
        }
    }
    left.sort_by_key(|left| left.claim);
    Ok(left)
}

/// Hands out layers of the visibility array.
#[derive(Debug, Default)]
struct Places {
    visibilities: u32,
    /// The one layer of everything that darkens the finished picture, one after the other.
    after: Option<u32>,
}

impl Places {
    fn next(&mut self) -> u32 {
        self.visibilities += 1;
        self.visibilities - 1
    }
}

/// The parts of one light.
fn divide(left: &[Left], places: &mut Places, factors: bool) -> LightFactors {
    let mut light = LightFactors::default();
    if left.is_empty() {
        return light;
    }
    if left.iter().any(|left| matches!(left.apply, Apply::DarkenOnce { .. })) {
        let whole = part(left.iter(), FULL_DARKENING, || 0);
        light.alone = factors.then(|| whole.clone());
        light.once = Some(whole);
        return light;
    }
    let apart = left.iter().any(|left| matches!(left.apply, Apply::DarkenPicture { .. }));
    let is_plain = |left: &&Left| left.apply.max_darkening() == FULL_DARKENING && !apart;
    let weighted = left.iter().filter(|left| !is_plain(left));
    let plain = left.iter().filter(is_plain);
    let count = weighted.clone().count() + usize::from(plain.clone().next().is_some());
    if factors && (count > 1 || apart) {
        let purpose = "; here for the factor by itself, which no weight changes";
        light.alone = Some(Part { purpose, ..part(left.iter(), FULL_DARKENING, || places.next()) });
    }
    if apart {
        light.after = weighted
            .map(|left| {
                let after = places.after;
                let part = part([left].into_iter(), left.apply.max_darkening(), || {
                    after.unwrap_or_else(|| places.next())
                });
                places.after = part.layer.or(places.after);
                part
            })
            .collect();
        return light;
    }
    if plain.clone().next().is_some() {
        light.shaded.push(part(plain, FULL_DARKENING, || places.next()));
    }
    for left in weighted {
        light.shaded.push(part([left].into_iter(), left.apply.max_darkening(), || places.next()));
    }
    light
}

/// The part of these claims, in this layer where they multiply a visibility.
fn part<'a>(
    left: impl Iterator<Item = &'a Left>,
    max_darkening: [f32; 3],
    layer: impl FnOnce() -> u32,
) -> Part {
    let mut part = Part { max_darkening, ..Part::default() };
    let mut visible = false;
    for left in left {
        part.claims.push(left.claim);
        part.counts |= left.counts;
        visible |= left.visibility.is_some();
    }
    part.layer = visible.then(layer);
    part
}

/// One bit for each of `counted` lights, in the narrowest format that holds them.
fn light_mask(inputs: &Inputs<'_>, needs: &mut Needs, counted: u32) -> Result<SlotId, FrameError> {
    let format = match counted {
        0..=8 => TextureFormat::R8Unorm,
        9..=16 => TextureFormat::Rg8Unorm,
        _ => TextureFormat::Rgba8Unorm,
    };
    if inputs.is_multisampled() {
        // Multisampled textures have one layer.
        if counted > 32 {
            return Err(FrameError::MultisampledLights { lights: counted, limit: 32 });
        }
        inputs.adapter.check_multisampled("the light mask", format)?;
    }
    let reason = format!("one bit for each of {counted} lights with counts");
    Ok(needs.slots.texture(TextureDesc {
        layers: counted.div_ceil(32),
        samples: inputs.request.antialias.samples(),
        ..TextureDesc::new("light mask", format, inputs.view.size_px, &reason)
    }))
}
