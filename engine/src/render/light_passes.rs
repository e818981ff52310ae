//! The passes of each light over the opaque surfaces, and what they leave behind for shading and for measures.

use super::factor_images;
use super::factors::{Factors, LightFactors, Part};
use super::lights::{NodePasses, ReceiverPasses};
use super::request::FrameError;
use super::schedule::{Group, Inputs, Needs, Schedule, Scope};
use super::{reach, resolve};
use crate::plan::{FULL_DARKENING, FactorAt, FactorPart, LightPlanned, Resource, SlotId};

/// Adds the passes of all lights: what leaves each factor, an image of it where one was asked for, and what makes room for
/// the next light. Says of every light where shading finds it.
///
/// # Errors
/// What is wrong with a shader.
pub(super) fn add<'p>(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'p>,
    scope: &Scope,
    factors: &Factors,
    opaque: &'p ReceiverPasses,
) -> Result<Vec<LightPlanned>, FrameError> {
    let mut lights = Vec::new();
    for (index, (light, nodes)) in factors.lights.iter().zip(&opaque.lights).enumerate() {
        let own_shadow = nodes.iter().any(decides_own_shadow);
        let mut images = Images { inputs, factors, light: index, own_shadow, image: None };
        let name = &inputs.snapshot.lights[index].name;
        let snapshot = &inputs.snapshot.lights[index];
        if let Some(part) = &light.alone {
            let mut group = part.group(scope, nodes, name)?;
            reach::confine(&mut group, inputs.view, snapshot);
            schedule.push_group(group);
            let mut group = Group::new(&Scope { visibility: part.layer, ..scope.clone() });
            images.add(needs, &mut group, part.place())?;
            if part.is_counted() {
                group.push(resolve::to_nothing(name)?);
            }
            reach::confine(&mut group, inputs.view, snapshot);
            schedule.push_group(group);
        }
        for part in &light.shaded {
            let mut group = part.group(scope, nodes, name)?;
            images.add(needs, &mut group, part.shaded_from())?;
            if let (Some(mask), Some(bit)) = (factors.mask, part.bit) {
                group.push(resolve::to_mask(name, mask, bit)?);
            }
            reach::confine(&mut group, inputs.view, snapshot);
            schedule.push_group(group);
        }
        if images.image.is_none() {
            images.own_shadow = false;
            let mut group = Group::new(scope);
            images.add(needs, &mut group, FactorAt::Lit)?;
            schedule.push_group(group);
        }
        lights.push(planned(inputs, index, light, nodes, (own_shadow, images.image)));
    }
    Ok(lights)
}

/// Whether what a node leaves in the visibility holds the receivers' own shadows.
fn decides_own_shadow(node: &NodePasses) -> bool {
    node.contribution.own_shadow && node.passes.iter().any(|pass| pass.draws_into(Resource::VISIBILITY))
}

/// The image of one light's factor: of the first that is left.
struct Images<'a> {
    inputs: &'a Inputs<'a>,
    factors: &'a Factors,
    light: usize,
    own_shadow: bool,
    image: Option<SlotId>,
}

impl Images<'_> {
    fn add(&mut self, needs: &mut Needs, group: &mut Group<'_>, at: FactorAt) -> Result<(), FrameError> {
        let is_served = !self.inputs.registry.lights[self.light].is_empty();
        if self.image.is_none() && self.inputs.request.factors && is_served {
            let what = (at, self.own_shadow);
            self.image = Some(factor_images::add(self.inputs, needs, group, self.factors, self.light, what)?);
        }
        Ok(())
    }
}

fn planned(
    inputs: &Inputs<'_>,
    index: usize,
    light: &LightFactors,
    nodes: &[NodePasses],
    (own_shadow, factor_image): (bool, Option<SlotId>),
) -> LightPlanned {
    let part = |part: &Part| FactorPart { at: part.shaded_from(), max_darkening: part.max_darkening };
    let mut shaded = light.shaded.iter().map(part).filter(|part| part.at != FactorAt::Lit);
    let darkens = light.once.is_some() || !light.after.is_empty();
    let lit = if darkens { FactorAt::Darkening } else { FactorAt::Lit };
    let first = shaded.next().unwrap_or(FactorPart { at: lit, max_darkening: FULL_DARKENING });
    let smooth = nodes.iter().flat_map(|node| &node.contribution.smooth_terminators);
    // A light that reaches nothing in view has no passes, of no technique.
    let claims = inputs.registry.lights[index].iter().filter(|_| !nodes.is_empty());
    LightPlanned {
        name: inputs.snapshot.lights[index].name.clone(),
        factor: first.at,
        max_darkening: first.max_darkening,
        more_factors: shaded.collect(),
        techniques: claims.map(|claim| claim.label.clone()).collect(),
        smooth_terminators: smooth.map(|instance| *instance as u32).collect(),
        own_shadow,
        factor_image,
        layer_factor_images: vec![],
    }
}
