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
use crate::common::volume::{VolumeIndices, VolumeUniform};

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
) -> Buffers {
    let mut keys = Vec::new();
    let mut indices = Vec::new();
    let mut records: Vec<VolumeUniform> = Vec::new();
    let mut first = 0;
    for member in groups.iter().flatten() {
        let Volume { caster: Caster { index, instance, key, facing }, end, .. } = &volumes[member.caster];
        let key = hash_of((key, &member.triangles));
        let runs = light.cache.get_or_compute("volume indices", key, || {
            VolumeIndices::new(instance, facing, member.triangles.as_ref().unwrap_or(&facing.cast))
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

/// Which bits of the stencil count.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Counter {
    AllBits,
    BesideStickyBit,
}

/// The draws of one volume: the runs its depth test and end demand, neighbours joined.
pub(super) fn volume_draws(
    volume: &Volume<'_>,
    record: u32,
    buffers: &Buffers,
    counter: Counter,
) -> Vec<Draw> {
    let (first, runs) = &buffers.indices[record as usize];
    let meets_at_infinity = volume.directional && volume.end == End::Infinite;
    let mut wanted = vec![(&runs.sides_near, false)];
    if !meets_at_infinity {
        wanted.push((&runs.sides_far, false));
    }
    if volume.z_fail {
        if !meets_at_infinity {
            wanted.push((&runs.far_caps, false));
        }
        wanted.push((&runs.front_caps, false));
        wanted.push((&runs.front_caps_turned, true));
    }
    let mut joined: Vec<(u32, u32, bool)> = Vec::new();
    for (run, turned) in wanted {
        match joined.last_mut() {
            Some((_, end, last_turned)) if *end == run.start && *last_turned == turned => *end = run.end,
            _ => joined.push((run.start, run.end, turned)),
        }
    }
    joined.retain(|(start, end, _)| start < end);
    joined
        .into_iter()
        .map(|(start, end, turned)| {
            let mut state = DrawState::new(CompareFunction::Greater, vec![]);
            state.depth_clamp = volume.clamp_depth;
            state.stencil = Some(count(volume.z_fail, turned, counter));
            Draw {
                name: volume.name(),
                shader: Some(buffers.shader.clone()),
                state,
                geometry: Geometry::Indexed {
                    instance: volume.caster.index as u32,
                    indices: buffers.index_slot,
                    first: first + start,
                    count: end - start,
                    record,
                },
                bindings: vec![(1, Binding::Storage(buffers.records))],
                scissor_px: None,
            }
        })
        .collect()
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
