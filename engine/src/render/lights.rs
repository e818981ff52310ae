//! What the nodes of each light plan for one set of receivers.

use super::reach;
use super::request::FrameError;
use super::schedule::{Inputs, Needs};
use crate::plan::{DepthId, Resource, SlotKind, Symbol, TextureFormat};
use crate::shadow::{
    Apply, Claim, Contribution, CountsBefore, Layer, Layers, LightContext, Pass, PassList, ShadowError,
};

/// Passes of one node for one light.
#[derive(Debug, Default)]
pub(super) struct NodePasses {
    pub(super) passes: Vec<Pass>,
    pub(super) contribution: Contribution,
}

/// What all lights' nodes plan for one set of receivers.
#[derive(Debug)]
pub(super) struct ReceiverPasses {
    /// The receivers' depth.
    pub(super) depth: DepthId,
    /// For each light an entry for each of its claims; none where the light has no passes.
    pub(super) lights: Vec<Vec<NodePasses>>,
}

impl ReceiverPasses {
    /// Whether anything is drawn that may darken the receivers.
    pub(super) fn are_shadowed(&self) -> bool {
        self.passes().any(|pass| !pass.draws.is_empty())
    }

    /// Whether a pass reads what `symbol` stands for.
    pub(super) fn ask(&self, symbol: Symbol) -> bool {
        self.passes().any(|pass| pass.reads(Resource(symbol)))
    }

    fn passes(&self) -> impl Iterator<Item = &Pass> {
        self.lights.iter().flatten().flat_map(|node| &node.passes)
    }
}

/// Has every node that serves a light plan for the receivers whose depth this is: a `layer` of transparent surfaces, or the
/// opaque ones. Lights that are `left_out` plan nothing.
///
/// # Errors
/// What the techniques refuse; two ways of darkening that do not go together.
pub(super) fn plan(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    (depth, layer): (DepthId, Option<Layer>),
    left_out: &dyn Fn(usize) -> bool,
) -> Result<ReceiverPasses, FrameError> {
    let mut lights = Vec::new();
    let mut once: Option<Once> = None;
    for (index, claims) in inputs.registry.lights.iter().enumerate() {
        let light = &inputs.snapshot.lights[index];
        let falls = match layer {
            None => true,
            Some(Layer::FromEye(0)) => inputs.registry.receiver_layers(index) >= Layers::First,
            Some(_) => inputs.registry.receiver_layers(index) == Layers::All,
        };
        let mut nodes = Vec::new();
        if claims.is_empty() {
            needs.note(format!("light '{}' has no shadow node: no passes", light.name));
        } else if !light.may_reach(&inputs.view.receiver_bounds)
            || reach::pixels(inputs.view, light).is_none()
        {
            needs.note(format!("light '{}' reaches nothing in view: no passes", light.name));
        } else if falls && !left_out(index) {
            nodes = plan_light(inputs, needs, (index, layer), &mut once)?;
        }
        lights.push(nodes);
    }
    Ok(ReceiverPasses { depth, lights })
}

/// The one darkening of a frame's finished picture, as the first node asked for it.
struct Once {
    weight: f64,
    node: String,
    /// A bound on the counts of all lights together.
    bound: u32,
}

fn plan_light(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    (index, layer): (usize, Option<Layer>),
    once: &mut Option<Once>,
) -> Result<Vec<NodePasses>, FrameError> {
    let (light, claims) = (&inputs.snapshot.lights[index], &inputs.registry.lights[index]);
    let is_wide = |claim: &Claim| claim.light_size().is_wide(light.position);
    let wide = claims.iter().filter(|claim| is_wide(claim)).count();
    let mut nodes: Vec<NodePasses> = Vec::new();
    let mut counts_bound: u32 = 0;
    for claim in claims {
        // Of a light with a size, part may be beyond a receiver's horizon, whether or not anything casts.
        if claim.casters.is_empty() && !is_wide(claim) {
            needs.note(format!("'{}' has no casters for light '{}': no passes", claim.node, light.name));
            nodes.push(NodePasses::default());
            continue;
        }
        let darkening = once.as_ref().map_or(0, |once| once.bound);
        let context = LightContext {
            snapshot: inputs.snapshot,
            view: inputs.view,
            features: inputs.adapter.features,
            adapter: inputs.adapter.name,
            cache: inputs.cache,
            light_index: index,
            claim,
            layer,
            is_beside_size: wide > usize::from(is_wide(claim)),
            counts_before: CountsBefore { light: counts_bound, darkening },
        };
        let visibility_is_touched = nodes.iter().any(|node| node.contribution.visibility.is_some());
        let mut out = PassList {
            snapshot: inputs.snapshot,
            slots: &mut needs.slots,
            notes: &mut needs.notes,
            passes: vec![],
            visibility_is_touched,
        };
        let contribution = claim.technique.plan(&context, &mut out)?;
        let passes = out.passes;
        needs.slots.free_scratch();
        check_written(&context, &passes, &contribution)?;
        match (contribution.apply, contribution.counts_bound) {
            (Apply::DarkenOnce { weight }, Some(bound)) => put_together(once, claim, weight, bound)?,
            (_, bound) => counts_bound = counts_bound.saturating_add(bound.unwrap_or(0)),
        }
        nodes.push(NodePasses { passes, contribution });
        check_one_way(&light.name, claims, &nodes)?;
        if inputs.is_multisampled() {
            check_per_sample(needs, claim, nodes.last())?;
        }
    }
    Ok(nodes)
}

/// Checks that passes write what is said of them, and nothing else.
fn check_written(
    light: &LightContext<'_>,
    passes: &[Pass],
    contribution: &Contribution,
) -> Result<(), ShadowError> {
    if contribution.counts_bound.is_none() && passes.iter().any(Pass::counts) {
        return Err(light.unsupported("a pass counts in the stencil, and no bound is stated"));
    }
    let darkens = |pass: &Pass| pass.draws_into(Resource::VISIBILITY);
    if contribution.visibility.is_none() && passes.iter().any(darkens) {
        return Err(light.unsupported("a pass draws into the light's visibility, and no channels are stated"));
    }
    if let (Apply::DarkenOnce { .. }, Some(_)) = (contribution.apply, contribution.visibility) {
        return Err(light.unsupported(
            "what darkens the finished picture once is counted, and this multiplies the light's visibility",
        ));
    }
    Ok(())
}

/// Adds what one light's node counts to the one darkening of the frame.
fn put_together(once: &mut Option<Once>, claim: &Claim, weight: f64, bound: u32) -> Result<(), ShadowError> {
    let once = once.get_or_insert_with(|| Once { weight, node: claim.node.clone(), bound: 0 });
    if once.weight != weight {
        return Err(ShadowError::WeightsDiffer {
            first: once.node.clone(),
            first_weight: once.weight,
            second: claim.node.clone(),
            second_weight: weight,
        });
    }
    once.bound = once.bound.saturating_add(bound);
    Ok(())
}

/// Refuses a light whose shadows darken the picture in two ways: it would be darkened twice.
fn check_one_way(light: &str, claims: &[Claim], nodes: &[NodePasses]) -> Result<(), ShadowError> {
    let find = |wanted: &dyn Fn(Apply) -> bool| {
        let mut nodes = claims.iter().zip(nodes);
        let node = nodes.find(|(_, n)| n.contribution.is_some() && wanted(n.contribution.apply));
        node.map(|(claim, _)| claim.node.clone())
    };
    let once = find(&|apply| matches!(apply, Apply::DarkenOnce { .. }));
    let apart = find(&|apply| matches!(apply, Apply::DarkenPicture { .. }));
    let light = light.to_owned();
    if let (Some(once), Some(apart)) = (&once, &apart) {
        let (once, apart) = (once.clone(), apart.clone());
        return Err(ShadowError::DarkeningsDiffer { light, once, apart });
    }
    match (once.or(apart), find(&|apply| matches!(apply, Apply::Light { .. }))) {
        (Some(darkening), Some(other)) => Err(ShadowError::DarkenedTwice { light, darkening, other }),
        _ => Ok(()),
    }
}

/// Counts are kept for every sample by the stencil itself, and a technique that asks each sample has a texel for each. Any other
/// visibility is written once for each fragment: its samples would all hold the factor of one point, and edges would be as
/// wrong as without antialiasing. So would the images of what each pixel shows, and a counter of its own beside the
/// receivers' depth. A finished picture is darkened once for each fragment.
fn check_per_sample(needs: &Needs, claim: &Claim, node: Option<&NodePasses>) -> Result<(), ShadowError> {
    let Some(NodePasses { passes, contribution }) = node else { return Ok(()) };
    let beside_depth = |pass: &&Pass| pass.depth.is_some_and(|depth| depth.slot == Resource::RECEIVER_DEPTH);
    let counter = passes.iter().filter(beside_depth).flat_map(|pass| &pass.colors).find_map(|color| {
        match color.slot.0 {
            Symbol::Slot(slot) => match needs.slots.get(slot).kind {
                SlotKind::Texture { format, samples: 1, .. } => Some(format),
                _ => None,
            },
            _ => None,
        }
    });
    let shades = matches!(contribution.apply, Apply::Light { .. });
    let by_itself = |pass: &Pass| pass.depth.is_none() || !pass.draws_into(Resource::VISIBILITY);
    let asks_each = claim.technique.traits().asks_each_sample && shades && passes.iter().all(by_itself);
    let asks = |symbol| passes.iter().any(|pass| pass.reads(Resource(symbol)));
    let image = if asks(Symbol::VisibleTriangles) {
        Some(TextureFormat::Rg32Uint)
    } else {
        asks(Symbol::ReceiverPlanes).then_some(super::schedule::RECEIVER_PLANES)
    };
    let visibility = contribution.visibility.map(crate::shadow::Channels::format);
    match counter.or(visibility.or(image).filter(|_| !asks_each)) {
        None => Ok(()),
        Some(format) => {
            let (node, technique) = (claim.node.clone(), claim.type_name);
            Err(ShadowError::NotPerSample { node, technique, format })
        }
    }
}
