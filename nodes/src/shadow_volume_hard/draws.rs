//! From volumes to draws: the buffers of one light, which runs of indices a view demands, and how they count.

use std::sync::Arc;

use shadowgraph_engine::geometry::GroupMember;
use shadowgraph_engine::plan::{
    Binding, BlendComponent, BlendFactor, BlendOperation, BlendState, BufferUsage, CompareFunction,
    DepthTarget, Draw, DrawState, Geometry, Pass, Shader, SlotId, Stencil, StencilFaceState,
    StencilOperation,
};
use shadowgraph_engine::shadow::{LightPlan, hash_of};

use super::Volume;
use crate::common::extrusion::End;
use crate::common::layer_groups::Caster;
use crate::common::volume::{Half, VolumeIndices, VolumeUniform, Weights};

/// The buffers of one light's volumes.
pub(super) struct Buffers {
    index_slot: SlotId,
    records: SlotId,
    /// For each record: where its indices begin, and their runs.
    indices: Vec<(u32, Arc<VolumeIndices>)>,
}

pub(super) fn upload(
    light: &mut LightPlan<'_>,
    volumes: &[Volume<'_>],
    groups: &[Vec<GroupMember>],
    weights: Weights,
) -> Buffers {
    let mut keys = Vec::new();
    let mut indices = Vec::new();
    let mut records: Vec<VolumeUniform> = Vec::new();
    let mut first = 0;
    for member in groups.iter().flatten() {
        let Volume { caster: Caster { index, instance, shape, key, facing }, end, .. } =
            &volumes[member.caster];
        let key = hash_of((key, &member.triangles, weights));
        let runs = light.cache.get_or_compute("volume indices", key, || {
            let triangles = member.triangles.as_ref().unwrap_or(&facing.cast);
            VolumeIndices::new(instance, shape, facing, triangles, weights)
        });
        records.push(VolumeUniform::new(instance, *index, light.light().position, *end));
        keys.push(key);
        let count = runs.indices.len() as u32;
        indices.push((first, runs));
        first += count;
    }
    let name = light.light().name.clone();
    let key = hash_of(("volume indices", &keys));
    let bytes = light.cache.get_or_compute("volume index bytes", key, || {
        indices
            .iter()
            .flat_map(|(_, runs)| bytemuck::cast_slice::<u32, u8>(&runs.indices))
            .copied()
            .collect::<Vec<u8>>()
    });
    let edges: usize = indices.iter().map(|(_, runs)| runs.silhouette_edges).sum();
    let reason = format!("{edges} silhouette edges, and the caps for views that need them");
    let index_slot =
        light.buffer(&format!("volume indices of {name}"), BufferUsage::Index, key, bytes, &reason);
    let bytes: &[u8] = bytemuck::cast_slice(&records);
    let key = hash_of(("volumes", bytes));
    let records = light.buffer(
        &format!("volumes of {name}"),
        BufferUsage::Storage,
        key,
        Arc::new(bytes.to_vec()),
        "where the light is, as each caster sees it, and where its volume ends",
    );
    Buffers { index_slot, records, indices }
}

/// A shader of this technique's own; its text is checked by a test, so composing it cannot fail.
pub(super) fn volume_shader(vertex: &'static str, fragment: Option<&'static str>) -> Shader {
    let source = shadowgraph_shaders::compose_named("shadow_volume_hard", &[]).unwrap_or_default();
    Shader {
        name: "shadow_volume_hard".into(),
        source: source.into(),
        vertex: vertex.into(),
        fragment: fragment.map(Into::into),
    }
}

/// What counts.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Counter {
    /// All bits of the stencil.
    AllBits,
    /// Bits 0 to 6 of the stencil.
    BesideStickyBit,
    /// A float target.
    Float,
}

/// Neighbouring indices that count alike.
#[derive(Clone, PartialEq)]
struct Run {
    start: u32,
    end: u32,
    how: How,
}

/// How the faces of a run count.
#[derive(Clone, Copy, PartialEq)]
struct How {
    /// What a face counts that enters a volume; negative when the triangles are wound against the chain.
    weight: i32,
    /// Which of them count.
    faces: Faces,
    /// Whether a face at the very depth of the visible surface counts as before it.
    equal_is_before: bool,
}

impl How {
    fn both(weight: i32) -> Self {
        Self { weight, faces: Faces::Both, equal_is_before: false }
    }
}

/// The faces of a volume that a draw counts, by what the view does there.
#[derive(Clone, Copy, PartialEq)]
enum Faces {
    Both,
    Entering,
    Leaving,
}

/// The runs of a volume that its depth test and end demand, neighbours joined.
fn runs(volume: &Volume<'_>, indices: &VolumeIndices) -> Vec<Run> {
    let meets_at_infinity = volume.directional && volume.end == End::Infinite;
    let mut wanted = Vec::new();
    for side in &indices.sides {
        let how = How::both(side.weight as i32);
        // What is seen of a far side lies right behind the sides through which the view enters: they begin before it. (A
        // side taken to be before what it touches only adds to a count there: it cannot cancel another's, and a move of
        // the receiver by the ambiguity band's ulps would put it in the volume.)
        let unlit = volume.half == Half::Unlit;
        let how = if unlit { How { faces: Faces::Leaving, ..how } } else { how };
        wanted.push((&side.near, how));
        if !meets_at_infinity {
            wanted.push((&side.far, how));
        }
        if unlit {
            wanted.push((&side.ahead, How { faces: Faces::Entering, ..how }));
        }
    }
    if volume.z_fail && !meets_at_infinity {
        wanted.push((&indices.far_caps, How::both(1)));
    }
    let front_caps = [(&indices.front_caps, How::both(1)), (&indices.front_caps_turned, How::both(-1))];
    if volume.half == Half::Unlit {
        // The far side of the caster itself is not to be in its shadow: there the view leaves the volume at the very
        // depth of what it sees. Where it enters through a cap, nobody sees the cap, and depth is as it always is.
        let leaving = |how| How { faces: Faces::Leaving, equal_is_before: true, ..how };
        wanted.extend(front_caps.map(|(run, how)| (run, leaving(how))));
        if volume.z_fail {
            wanted.extend(front_caps.map(|(run, how)| (run, How { faces: Faces::Entering, ..how })));
        }
    } else if volume.z_fail || volume.hidden_caps_count {
        wanted.extend(front_caps);
    }
    wanted.push((&indices.unseen_caps, How::both(1)));
    wanted.push((&indices.unseen_caps_turned, How::both(-1)));
    let mut joined: Vec<Run> = Vec::new();
    for (range, how) in wanted {
        match joined.last_mut() {
            Some(last) if last.end == range.start && last.how == how => last.end = range.end,
            _ => joined.push(Run { start: range.start, end: range.end, how }),
        }
    }
    joined.retain(|run| run.start < run.end);
    joined
}

/// The draws of one volume.
pub(super) fn volume_draws(
    volume: &Volume<'_>,
    record: u32,
    buffers: &Buffers,
    counter: Counter,
) -> Vec<Draw> {
    let (first, indices) = &buffers.indices[record as usize];
    let draw = |run: Run| {
        let mut state = match counter {
            Counter::AllBits => stencil_state(volume.z_fail, run.how, 0xff),
            Counter::BesideStickyBit => stencil_state(volume.z_fail, run.how, 0x7f),
            Counter::Float => float_state(volume.z_fail, run.how),
        };
        state.depth_clamp = volume.clamp_depth;
        Draw {
            name: volume.name(),
            shader: Some(volume_shader(
                "vertex",
                (counter == Counter::Float).then_some(match (run.how.faces, run.how.weight < 0) {
                    (Faces::Both, _) => "count",
                    (Faces::Entering, false) | (Faces::Leaving, true) => "count_front",
                    (Faces::Entering, true) | (Faces::Leaving, false) => "count_back",
                }),
            )),
            state,
            geometry: Geometry::Indexed {
                instance: volume.caster.index as u32,
                indices: buffers.index_slot,
                first: first + run.start,
                count: run.end - run.start,
                record,
            },
            bindings: vec![(1, Binding::Storage(buffers.records))],
            scissor_px: None,
        }
    };
    runs(volume, indices).into_iter().map(draw).collect()
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
    let compare = if how.equal_is_before { CompareFunction::GreaterEqual } else { CompareFunction::Greater };
    let mut state = DrawState::new(compare, vec![]);
    state.stencil =
        Some(Stencil { front: face(front), back: face(back), read_mask: 0xff, write_mask, reference: 0 });
    state
}

/// As [`stencil_state`], in numbers: the shader says +1 for a front face and −1 for a back face, the blend constant how
/// much it weighs.
fn float_state(z_fail: bool, how: How) -> DrawState {
    let add = BlendComponent {
        src_factor: BlendFactor::Constant,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    let compare = match (z_fail, how.equal_is_before) {
        (false, false) => CompareFunction::Greater,
        (false, true) => CompareFunction::GreaterEqual,
        (true, false) => CompareFunction::LessEqual,
        (true, true) => CompareFunction::Less,
    };
    let mut state = DrawState::new(compare, vec![Some(BlendState { color: add, alpha: add })]);
    state.blend_constant = [f64::from(if z_fail { -how.weight } else { how.weight }); 4];
    state
}

/// Wherever bits 0 to 6 are not all zero: bit 7 alone.
pub(super) fn fold_pass(light: &LightPlan<'_>, depth: &DepthTarget) -> Pass {
    let face = StencilFaceState {
        compare: CompareFunction::NotEqual,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op: StencilOperation::Replace,
    };
    let mut state = DrawState::new(CompareFunction::Always, vec![]);
    state.stencil =
        Some(Stencil { front: face, back: face, read_mask: 0x7f, write_mask: 0xff, reference: 0x80 });
    Pass {
        name: format!("fold counts of {}", light.light().name),
        reason:
            "more layers than the stencil can count at once: dark stays dark while the counter starts again"
                .into(),
        colors: vec![],
        depth: Some(depth.clone()),
        draws: vec![Draw {
            name: "fold".into(),
            shader: Some(volume_shader("fullscreen_vertex", None)),
            state,
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings: vec![],
            scissor_px: None,
        }],
    }
}
