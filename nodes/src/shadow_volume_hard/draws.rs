//! How volumes are counted in the stencil.

use shadowgraph_engine::plan::{
    CompareFunction, DrawState, STENCIL_AT_REST, Shader, ShaderError, Stencil, StencilFaceState,
    StencilOperation,
};
use shadowgraph_engine::shadow::{DepthTarget, Draw, Geometry, LightContext, Pass};

use crate::common::volume_draws::{Buffers, CAPS, Faces, How, Volume, float_state, volume_draws};

/// A shader of this technique's own.
pub(super) fn volume_shader(
    vertex: &'static str,
    fragment: Option<&'static str>,
    flags: &[&str],
) -> Result<Shader, ShaderError> {
    Shader::composed("shadow_volume_hard", flags, vertex, fragment)
}

/// What counts.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Counter {
    /// All bits of the stencil.
    AllBits,
    /// Bits 0 to 6 of the stencil.
    InGroups,
    /// A float target.
    Float,
}

/// The draws of one volume.
pub(super) fn counting_draws(
    volume: &Volume<'_>,
    record: u32,
    buffers: &Buffers,
    counter: Counter,
) -> Result<Vec<Draw>, ShaderError> {
    volume_draws(volume, record, buffers, |how, flags| {
        let state = match counter {
            Counter::AllBits => stencil_state(volume.z_fail, how, 0xff),
            Counter::InGroups => stencil_state(volume.z_fail, how, COUNT_BITS),
            Counter::Float => float_state(volume.z_fail, how),
        };
        let fragment = match (counter, how.front_faces()) {
            (Counter::Float, None) => Some("count"),
            (Counter::Float, Some(true)) => Some("count_front"),
            (Counter::Float, Some(false)) => Some("count_back"),
            _ => flags.contains(&CAPS).then_some("place"),
        };
        Ok((volume_shader("vertex", fragment, flags)?, state))
    })
}

/// z-pass: a front face before the surface enters a volume, +1; a back face leaves it, −1. z-fail, counting behind
/// the surface: a back face still to be left, +1; a front face still to be entered, −1. Triangles of negative weight
/// are wound against the chain.
fn stencil_state(z_fail: bool, how: How, write_mask: u8) -> DrawState {
    use StencilOperation::{DecrementWrap, IncrementWrap, Keep};
    let (entering, leaving) =
        if z_fail { (DecrementWrap, IncrementWrap) } else { (IncrementWrap, DecrementWrap) };
    let entering = if how.faces == Faces::Leaving { Keep } else { entering };
    let leaving = if how.faces == Faces::Entering { Keep } else { leaving };
    let (front, back) = if how.weight < 0 { (leaving, entering) } else { (entering, leaving) };
    let face = |op| StencilFaceState {
        compare: CompareFunction::Always,
        fail_op: Keep,
        depth_fail_op: if z_fail { op } else { Keep },
        pass_op: if z_fail { Keep } else { op },
    };
    let mut state = DrawState::new(CompareFunction::Greater, vec![]);
    state.stencil =
        Some(Stencil { front: face(front), back: face(back), read_mask: 0xff, write_mask, reference: 0 });
    state
}

/// What groups count in.
const COUNT_BITS: u8 = 0x7f;
/// Where earlier groups are dark, with the counter at rest.
const FOLDED: u8 = !COUNT_BITS | STENCIL_AT_REST;

/// What a fold does to counts, in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Fold {
    /// What others counted at once and is so large that it reaches the sticky bit: dark.
    Large,
    /// What is below rest is lit: the next group starts at rest.
    Lit,
    /// What is above is dark.
    Dark,
}

/// A draw over the whole target that does one fold.
fn fold_draw(fold: Fold) -> Result<Draw, ShaderError> {
    // A comparison has the reference on its left, as much of it as is read.
    let (compare, read_mask, write_mask, reference) = match fold {
        Fold::Large => (CompareFunction::Equal, !COUNT_BITS, 0xff, FOLDED),
        Fold::Lit => (CompareFunction::Greater, COUNT_BITS, COUNT_BITS, STENCIL_AT_REST),
        Fold::Dark => (CompareFunction::Less, COUNT_BITS, 0xff, FOLDED),
    };
    let face = StencilFaceState {
        compare,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op: StencilOperation::Replace,
    };
    let mut state = DrawState::new(CompareFunction::Always, vec![]);
    state.stencil = Some(Stencil { front: face, back: face, read_mask, write_mask, reference });
    let shader = volume_shader("fullscreen_vertex", None, &[])?;
    Ok(Draw::new("fold", Geometry::fullscreen(shader), state))
}

/// The pass between two groups, or before the first.
pub(super) fn fold_pass(light: &LightContext<'_>, folds: &[Fold]) -> Result<Pass, ShaderError> {
    Ok(Pass {
        name: format!("fold counts of {}", light.light().name),
        reason:
            "more layers than the stencil can count at once: dark stays dark while the counter starts again"
                .into(),
        colors: vec![],
        depth: Some(DepthTarget::COUNT),
        draws: folds.iter().copied().map(fold_draw).collect::<Result<_, _>>()?,
    })
}
