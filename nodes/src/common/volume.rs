//! The shadow volume of one caster and one light: its indices, and the record its vertex shader reads.

use std::collections::{BTreeMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4};
use shadowgraph_engine::geometry::{Capped, Chain, Topology, restricted_signs};
use shadowgraph_engine::scene::Instance;

use super::beside_light::{CutVertex, Cutter, Side};
use super::extrusion::End;
use super::facing::CasterFacing;
use super::front_caps::FrontCaps;

/// `struct Volume` of the shadow volume shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct VolumeUniform {
    pub light_high: [f32; 4],
    pub light_low: [f32; 4],
    pub end_normal: [f32; 3],
    pub end_offset: f32,
    pub end_kind: u32,
    pub end_scale: f32,
    pub instance: u32,
    pub first_cut: u32,
}

impl VolumeUniform {
    /// The byte offset of every field, and the whole size: what the layout test compares.
    pub fn layout() -> (Vec<(&'static str, usize)>, usize) {
        use std::mem::offset_of;
        let fields = vec![
            ("light_high", offset_of!(Self, light_high)),
            ("light_low", offset_of!(Self, light_low)),
            ("end_normal", offset_of!(Self, end_normal)),
            ("end_offset", offset_of!(Self, end_offset)),
            ("end_kind", offset_of!(Self, end_kind)),
            ("end_scale", offset_of!(Self, end_scale)),
            ("instance", offset_of!(Self, instance)),
            ("first_cut", offset_of!(Self, first_cut)),
        ];
        (fields, size_of::<Self>())
    }

    /// The record of `instance` (number `index` of the frame) for the homogeneous world-space `light`; its cut vertices
    /// begin at `first_cut`. The instance's transform must not be singular.
    pub fn new(instance: &Instance, index: usize, light: DVec4, end: End, first_cut: u32) -> Self {
        let world_from_shader = instance.world_from_shader();
        let shader_from_world = world_from_shader.inverse();
        let light_in_shader = if light.w > 0.0 {
            shader_from_world.transform_point3(light.truncate())
        } else {
            shader_from_world.transform_vector3(light.truncate())
        };
        let high = light_in_shader.as_vec3();
        let low = (light_in_shader - high.as_dvec3()).as_vec3();
        let (end_kind, plane, end_scale) = match end {
            End::Infinite => (0, None, 0.0),
            End::Plane(plane) => (1, Some(plane), 0.0),
            End::Scaled(scale) => (2, None, scale as f32),
            End::Reach(reach_m) => (3, None, reach_m as f32),
        };
        // normal·(M p + t) = offset  ⇔  (Mᵀ normal)·p = offset − normal·t
        let normal = plane.map_or(DVec3::ZERO, |p| world_from_shader.matrix3.transpose() * p.normal);
        let offset = plane.map_or(0.0, |p| p.offset - p.normal.dot(world_from_shader.translation));
        Self {
            light_high: high.extend(light.w as f32).to_array(),
            light_low: low.extend(0.0).to_array(),
            end_normal: normal.as_vec3().to_array(),
            end_offset: offset as f32,
            end_kind,
            end_scale,
            instance: index as u32,
            first_cut,
        }
    }
}

/// The triangles of a caster: its mesh's own, and after them those that close it.
#[derive(Clone, Debug)]
pub enum CastShape<'a> {
    /// The mesh as it is.
    Own(&'a Topology),
    /// With caps over its open loops.
    Capped(Arc<Capped>),
    /// With the reverse of every triangle.
    Doubled(Arc<Topology>),
}

impl CastShape<'_> {
    /// Welded corners, edges and closedness of all its triangles.
    pub fn topology(&self) -> &Topology {
        match self {
            Self::Own(topology) => topology,
            Self::Capped(capped) => &capped.topology,
            Self::Doubled(doubled) => doubled,
        }
    }

    /// The signs without those of triangles that have holes or let light through.
    pub fn whole_only(&self, instance: &Instance, signs: Vec<i8>) -> Vec<i8> {
        self.of_parts(instance, signs, |part| instance.materials[part].casts_whole())
    }

    /// The signs without those of the parts (by their number) that are not to cast.
    pub(super) fn of_parts(
        &self,
        instance: &Instance,
        mut signs: Vec<i8>,
        casts: impl Fn(usize) -> bool,
    ) -> Vec<i8> {
        let own = instance.mesh.triangle_count();
        for (number, part) in instance.mesh.data().parts.iter().enumerate() {
            let (start, end) = (part.triangles.start as usize, part.triangles.end as usize);
            if !casts(number) {
                signs[start..end].fill(0);
                if matches!(self, Self::Doubled(_)) {
                    signs[own + start..own + end].fill(0);
                }
            }
        }
        signs
    }

    /// The facing signs of the triangles in `half`, 0 for the others.
    pub(super) fn signs_of(&self, instance: &Instance, signs: Vec<i8>, half: Half) -> Vec<i8> {
        if half == Half::Both {
            return signs;
        }
        // Of a face and its reverse one faces the light; which of them is outside is not asked.
        if matches!(self, Self::Doubled(_)) {
            return signs.into_iter().map(|sign| sign.max(0)).collect();
        }
        let Some(orientation) = self.topology().orientation(&instance.world_from_local) else { return signs };
        let lit = orientation.lit_only(&signs);
        if half == Half::Lit {
            return lit;
        }
        signs.iter().zip(lit).map(|(sign, lit)| sign - lit).collect()
    }
}

/// Which triangles of a caster cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Half {
    /// All that are not edge-on.
    Both,
    /// Those that face the light outwards: for solids with the light outside.
    Lit,
    /// Those that face away from it: for solids with the light outside, whose own far side stays undecided (smooth
    /// terminators).
    Unlit,
}

/// How edges of more than unit weight are listed among the sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Weights {
    /// As often as they weigh: for counters that go by ones.
    Repeated,
    /// Once, in a run of their own for each weight: for counters that add any number.
    Apart,
}

/// Where the sides begin through which the view enters a volume, next to the caster by less than rounding can tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Begin {
    /// A little behind it, as those through which the view leaves.
    Behind,
    /// A little before it: what is seen of the caster may be turned away from the light and is not to be in the caster's own
    /// shadow, which the view enters through these sides and leaves through a cap that is moved ahead as well.
    Ahead,
    /// The same, but for edges of triangles that hold the light's centre in their plane: those sides lie in that plane, and so do
    /// surfaces which are neither before nor behind them.
    AheadOfSlanted,
}

/// The sides of one weight that begin alike.
#[derive(Clone, Debug, PartialEq)]
pub struct SideRun {
    /// What each of them counts.
    pub weight: u32,
    /// The triangle of every side that has its edge: (q, p, p∞), or (q, p, m∞) where it is cut; all there is of it when both
    /// ends meet at infinity.
    pub near: Range<u32>,
    /// The others: (q, p∞, q∞), or (p, p∞, m∞) and (q, m∞, q∞).
    pub far: Range<u32>,
    /// All triangles of every side once more, with q and p a little before the caster; empty unless they
    /// [begin](Begin) there.
    pub ahead: Range<u32>,
}

/// Indices of a volume, each 4·vertex + kind of corner (see common/volume.wgsl), in runs that are drawn as the view demands.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeIndices {
    /// All runs, one after the other.
    pub indices: Vec<u32>,
    /// The sides, by ascending weight.
    pub sides: Vec<SideRun>,
    /// Far caps.
    pub far_caps: Range<u32>,
    /// Front caps of triangles the light sees from the front, in the mesh's own order of corners.
    pub front_caps: Range<u32>,
    /// Front caps of triangles the light sees from behind, in the mesh's own order of corners: they count the other
    /// way round. (Turning the triangle instead could change its depth by a rounding, and caps must equal the
    /// visible surface bit by bit.)
    pub front_caps_turned: Range<u32>,
    /// Front caps of triangles that close the mesh and are not drawn.
    pub unseen_caps: Range<u32>,
    /// Those of them that count the other way round.
    pub unseen_caps_turned: Range<u32>,
    /// Different silhouette edges.
    pub silhouette_edges: usize,
    /// Vertices that are none of the mesh's: see [`super::beside_light`].
    pub cuts: Vec<CutVertex>,
}

impl VolumeIndices {
    /// Where the caps are among the indices: front caps and unseen ones, which come last.
    pub fn caps(&self) -> Range<usize> {
        self.front_caps.start as usize..self.indices.len()
    }

    /// The volume of the given triangles of a caster, for the homogeneous world-space `light`, that is to end at `end`.
    pub fn new(
        instance: &Instance,
        shape: &CastShape<'_>,
        facing: &CasterFacing,
        triangles: &[u32],
        (weights, begin): (Weights, Begin),
        (light, end): (DVec4, End),
    ) -> Self {
        let topology = shape.topology();
        let all = triangles.len() == facing.cast.len();
        let restricted;
        let signs = if all {
            &facing.signs
        } else {
            restricted = restricted_signs(&facing.signs, triangles.iter().copied());
            &restricted
        };
        let chain = Chain::extract(topology, signs);
        let mut cutter = Cutter::new(instance, &facing.p_in_world, light, end);
        let mut indices = Vec::with_capacity(chain.sides.len() * 6 + triangles.len() * 6);
        let mut run = |add: &mut dyn FnMut(&mut Vec<u32>)| {
            let start = indices.len() as u32;
            add(&mut indices);
            start..indices.len() as u32
        };
        let mut sides = Vec::new();
        for (weight, begin, of_weight) in sides_apart(&chain, weights, begin, (topology, facing)) {
            let of_weight = cut_sides(&mut cutter, of_weight);
            let near_run = run(&mut |i| of_weight.iter().for_each(|side| i.extend(side.at_edge(near))));
            let far_run = run(&mut |i| of_weight.iter().for_each(|side| i.extend(side.beyond(near))));
            let ahead_run = run(&mut |i| {
                let of_weight = if begin == Begin::Ahead { &of_weight[..] } else { &[] };
                of_weight.iter().for_each(|side| i.extend(side.at_edge(ahead)));
                of_weight.iter().for_each(|side| i.extend(side.beyond(ahead)));
            });
            sides.push(SideRun { weight, near: near_run, far: far_run, ahead: ahead_run });
        }
        let far_caps = run(&mut |i| {
            let caps = [(&chain.caps_front, true), (&chain.caps_back, false)];
            for (triangles, turned) in caps {
                let mut add = |[a, b, c]: [u32; 3]| {
                    let [b, c] = if turned { [c, b] } else { [b, c] };
                    i.extend_from_slice(&[far(a), far(b), far(c)]);
                };
                for triangle in triangles {
                    let corners = topology.triangles()[*triangle as usize];
                    match &mut cutter {
                        None => add(corners),
                        Some(cutter) => cutter.triangle(corners).into_iter().for_each(&mut add),
                    }
                }
            }
        });
        let FrontCaps { own, unseen } = FrontCaps::new(instance, shape, &chain);
        let [front_caps, front_caps_turned] = own.map(|caps| run(&mut |i| i.extend_from_slice(&caps)));
        let [unseen_caps, unseen_caps_turned] = unseen.map(|caps| run(&mut |i| i.extend_from_slice(&caps)));
        Self {
            silhouette_edges: chain.silhouette_edges,
            indices,
            sides,
            far_caps,
            front_caps,
            front_caps_turned,
            unseen_caps,
            unseen_caps_turned,
            cuts: cutter.map_or_else(Vec::new, |cutter| cutter.cuts),
        }
    }
}

/// The sides in lists of one weight that begin alike.
fn sides_apart(
    chain: &Chain,
    weights: Weights,
    begin: Begin,
    (topology, facing): (&Topology, &CasterFacing),
) -> impl Iterator<Item = (u32, Begin, Vec<[u32; 2]>)> {
    let level = match begin {
        Begin::AheadOfSlanted => edges_of(topology, &facing.edge_on),
        Begin::Behind | Begin::Ahead => HashSet::new(),
    };
    let begins_behind =
        move |[p, q]: &[u32; 2]| begin == Begin::Behind || level.contains(&[*p.min(q), *p.max(q)]);
    let apart = by_weight(&chain.sides, weights).into_iter().flat_map(move |(weight, of_weight)| {
        let (behind, ahead): (Vec<_>, Vec<_>) = of_weight.into_iter().partition(&begins_behind);
        [(weight, Begin::Behind, behind), (weight, Begin::Ahead, ahead)]
    });
    apart.filter(|(_, _, sides)| !sides.is_empty())
}

/// The edges of these triangles, their ends in ascending order.
fn edges_of(topology: &Topology, triangles: &[u32]) -> HashSet<[u32; 2]> {
    let corners = triangles.iter().map(|triangle| topology.triangles()[*triangle as usize]);
    let edges = corners.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    edges.map(|[p, q]| [p.min(q), p.max(q)]).collect()
}

/// The sides, with the places where the light passes their edges.
fn cut_sides(cutter: &mut Option<Cutter<'_>>, sides: Vec<[u32; 2]>) -> Vec<Side> {
    let side = |[p, q]: [u32; 2]| match cutter {
        Some(cutter) => cutter.side(p, q),
        None => Side::whole([p, q]),
    };
    sides.into_iter().map(side).collect()
}

/// A corner of a side where the caster is, a little before it.
fn ahead(vertex: u32) -> u32 {
    vertex << 2 | 1
}

/// A corner of a side where the caster is, as far behind it as sides are.
fn near(vertex: u32) -> u32 {
    vertex << 2 | 2
}

/// A corner at the volume's far end.
pub(super) fn far(vertex: u32) -> u32 {
    vertex << 2 | 3
}

/// The sides in lists of one weight, ascending. [`Chain`] lists a side of weight k k times in a row.
fn by_weight(sides: &[[u32; 2]], weights: Weights) -> Vec<(u32, Vec<[u32; 2]>)> {
    if weights == Weights::Repeated {
        return vec![(1, sides.to_vec())];
    }
    let mut lists: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for equal in sides.chunk_by(|a, b| a == b) {
        lists.entry(equal.len() as u32).or_default().push(equal[0]);
    }
    lists.into_iter().collect()
}
