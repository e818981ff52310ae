//! From volumes to draws: the buffers of one light, which runs of indices a view demands, and how they count.

use std::sync::Arc;

use shadowgraph_engine::geometry::GroupMember;
use shadowgraph_engine::plan::{
    Binding, BufferUsage, CompareFunction, DepthTarget, Draw, DrawState, Geometry, Pass, Shader, SlotId,
    Stencil, StencilFaceState, StencilOperation,
};
use shadowgraph_engine::shadow::{LightPlan, hash_of};

use super::Volume;
use crate::common::extrusion::End;
use crate::common::layer_groups::Caster;
use crate::common::volume::{VolumeIndices, VolumeUniform, Weights};

/// The buffers of one light's volumes.
pub(super) struct Buffers {
    index_slot: SlotId,
    records: SlotId,
    /// For each record: where its indices begin, and their runs.
    indices: Vec<(u32, Arc<VolumeIndices>)>,
    shader: Shader,
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
    Buffers { index_slot, records, indices, shader: volume_shader("vertex") }
}

fn volume_shader(vertex: &'static str) -> Shader {
    let source = shadowgraph_shaders::compose_named("shadow_volume_hard", &[]).unwrap_or_default();
    Shader { name: "shadow_volume_hard".into(), source: source.into(), vertex: vertex.into(), fragment: None }
}

/// What counts.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Counter {
    /// All bits of the stencil.
    AllBits,
    /// Bits 0 to 6 of the stencil.
    BesideStickyBit,
}

/// Neighbouring indices that count alike.
#[derive(Clone, PartialEq)]
struct Run {
    start: u32,
    end: u32,
    /// What a face counts that enters a volume; negative when the triangles are wound against the chain.
    weight: i32,
}

/// The runs of a volume that its depth test and end demand, neighbours joined.
fn runs(volume: &Volume<'_>, indices: &VolumeIndices) -> Vec<Run> {
    let meets_at_infinity = volume.directional && volume.end == End::Infinite;
    let mut wanted = Vec::new();
    for side in &indices.sides {
        wanted.push((&side.near, side.weight as i32));
        if !meets_at_infinity {
            wanted.push((&side.far, side.weight as i32));
        }
    }
    if volume.z_fail && !meets_at_infinity {
        wanted.push((&indices.far_caps, 1));
    }
    if volume.z_fail || volume.hidden_caps_count {
        wanted.push((&indices.front_caps, 1));
        wanted.push((&indices.front_caps_turned, -1));
    }
    wanted.push((&indices.unseen_caps, 1));
    wanted.push((&indices.unseen_caps_turned, -1));
    let mut joined: Vec<Run> = Vec::new();
    for (range, weight) in wanted {
        match joined.last_mut() {
            Some(last) if last.end == range.start && last.weight == weight => last.end = range.end,
            _ => joined.push(Run { start: range.start, end: range.end, weight }),
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
        let mut state = DrawState::new(CompareFunction::Greater, vec![]);
        state.depth_clamp = volume.clamp_depth;
        state.stencil = Some(count(volume.z_fail, run.weight < 0, counter));
        Draw {
            name: volume.name(),
            shader: Some(buffers.shader.clone()),
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
/// the surface: a back face still to be left, +1; a front face still to be entered, −1. `turned` triangles are wound
/// against the chain.
fn count(z_fail: bool, turned: bool, counter: Counter) -> Stencil {
    use StencilOperation::{DecrementWrap, IncrementWrap, Keep};
    let (front, back) =
        if z_fail == turned { (IncrementWrap, DecrementWrap) } else { (DecrementWrap, IncrementWrap) };
    let face = |op| StencilFaceState {
        compare: CompareFunction::Always,
        fail_op: Keep,
        depth_fail_op: if z_fail { op } else { Keep },
        pass_op: if z_fail { Keep } else { op },
    };
    let write_mask = if counter == Counter::AllBits { 0xff } else { 0x7f };
    Stencil { front: face(front), back: face(back), read_mask: 0xff, write_mask, reference: 0 }
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
            shader: Some(volume_shader("fullscreen_vertex")),
            state,
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings: vec![],
            scissor_px: None,
        }],
    }
}
