//! Counts of any size in eight bits.
//!
//! A stencil wraps at 256, so what a count may become is bounded before anything is counted. If all casters of a
//! light together stay within the stencil, they are counted at once. Otherwise they are counted in groups of at most
//! 127 layers, and between two groups a *fold* turns every count that is not zero into the sticky bit 7, which later
//! counts (bits 0 to 6) leave alone. Any set of triangles casts a closed chain, so even one mesh can be split.

use std::sync::Arc;

use glam::DVec4;
use shadowgraph_engine::geometry::{LayerGrid, Topology};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{LightPlan, hash_of};

use super::volume::CasterFacing;

/// The largest count an 8-bit stencil holds.
pub const MAX_COUNT: u32 = 255;
/// The largest count beside the sticky bit.
pub const MAX_GROUP_COUNT: u32 = 127;

/// A caster of one light with the triangles that cast.
#[derive(Clone, Debug)]
pub struct Caster<'a> {
    /// Its number in the frame.
    pub index: usize,
    /// The mesh at its place.
    pub instance: &'a Instance,
    /// A hash of everything `facing` was computed from.
    pub key: u64,
    /// Its facing signs.
    pub facing: Arc<CasterFacing>,
}

impl<'a> Caster<'a> {
    fn topology(&self) -> &'a Topology {
        self.instance.mesh.topology()
    }
}

/// One caster, or some of its triangles, in a group of certified size.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// The caster's place in the list that was split.
    pub caster: usize,
    /// The triangles; `None` for all that are cast.
    pub triangles: Option<Vec<u32>>,
}

/// Groups of casters that are counted one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Groups {
    /// The groups, in the order of the scene and then of the file.
    pub groups: Vec<Vec<Member>>,
    /// A bound on what all casters together count at any pixel.
    pub bound: u32,
    /// Whether counts must be folded between groups, and before the first if others have counted.
    pub folds: bool,
}

/// Splits `casters` into groups whose counts the stencil can hold, beside what others counted for the light before.
/// Kept until a caster or the light moves.
pub fn group_by_layers(light: &mut LightPlan<'_>, casters: &[Caster<'_>]) -> Arc<Groups> {
    let keys: Vec<u64> = casters.iter().map(|caster| caster.key).collect();
    let (position, before) = (light.light().position, light.counts_before());
    let groups = light.cache.get_or_compute("layer groups", hash_of((&keys, before)), || {
        let bound = layers(position, casters, &everything(casters), MAX_COUNT);
        if bound <= MAX_COUNT - before.min(MAX_COUNT) {
            return Groups { groups: vec![everything(casters)], bound, folds: false };
        }
        Groups { groups: split(position, casters), bound, folds: true }
    });
    if groups.folds {
        let (bound, count) = (groups.bound, groups.groups.len());
        light.note(format!(
            "a wider counter for '{}': up to {bound} layers are counted in {count} groups of at most {MAX_GROUP_COUNT}",
            light.light().name
        ));
    }
    groups
}

fn everything(casters: &[Caster<'_>]) -> Vec<Member> {
    (0..casters.len()).map(|caster| Member { caster, triangles: None }).collect()
}

/// Halves until each is small enough.
fn split(light: DVec4, casters: &[Caster<'_>]) -> Vec<Vec<Member>> {
    let mut groups = Vec::new();
    let mut open = vec![everything(casters)];
    while let Some(mut group) = open.pop() {
        if layers(light, casters, &group, MAX_GROUP_COUNT) <= MAX_GROUP_COUNT {
            groups.push(group);
        } else if group.len() > 1 {
            let second_half = group.split_off(group.len() / 2);
            open.extend([second_half, group]);
        } else if let Some(Member { caster, triangles }) = group.pop() {
            let mut triangles = triangles.unwrap_or_else(|| casters[caster].facing.cast.clone());
            let second_half = triangles.split_off(triangles.len() / 2);
            open.extend([second_half, triangles].map(|half| vec![Member { caster, triangles: Some(half) }]));
        }
    }
    groups
}

/// A bound on the cast triangles of `members` that one light ray crosses. A first bound above `enough` is tried again
/// with a finer grid.
fn layers(light: DVec4, casters: &[Caster<'_>], members: &[Member], enough: u32) -> u32 {
    let cast = |member: &Member| {
        let all = casters[member.caster].facing.cast.len();
        member.triangles.as_ref().map_or(all, Vec::len)
    };
    let count: usize = members.iter().map(cast).sum();
    // No ray crosses more triangles than there are.
    if count <= enough as usize {
        return count as u32;
    }
    let bounds = members.iter().fold(Aabb::EMPTY, |bounds, member| {
        let caster = &casters[member.caster];
        bounds.union(&caster.facing.bounds(caster.topology()))
    });
    let bound_with = |detail: usize| {
        let mut grid = LayerGrid::with_detail(light, &bounds, count, detail);
        for member in members {
            let (facing, topology) = (&casters[member.caster].facing, casters[member.caster].topology());
            let triangles = member.triangles.as_ref().unwrap_or(&facing.cast);
            triangles.iter().for_each(|triangle| grid.add_triangle(facing.corners(topology, *triangle)));
        }
        grid.max_layers()
    };
    let bound = bound_with(1);
    if bound > enough { bound.min(bound_with(4)) } else { bound }
}
