//! Counts of any size in eight bits.
//!
//! A stencil wraps at 256, and counts begin at [`STENCIL_AT_REST`], so what a count may become is bounded before anything is
//! counted. If all casters of a light together stay within that, they are counted at once. Otherwise they are counted in
//! groups of at most 95 layers, and between two groups a *fold* sets the sticky bit 7, which later counts (bits 0 to 6) leave
//! alone, wherever something casts, and sets bits 0 to 6 back to rest.

use std::sync::Arc;

use shadowgraph_engine::geometry::{CastTriangles, GroupMember, layer_groups, max_layers};
use shadowgraph_engine::plan::STENCIL_AT_REST;
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{Apply, LightContext, PassList, hash_of};

use super::facing::CasterFacing;
use super::volume::CastShape;

/// The largest count an 8-bit stencil holds above its rest.
pub const MAX_COUNT: u32 = 255 - STENCIL_AT_REST as u32;
/// The largest count beside the sticky bit.
pub const MAX_GROUP_COUNT: u32 = 127 - STENCIL_AT_REST as u32;

/// A caster of one light with the triangles that cast.
#[derive(Clone, Debug)]
pub struct Caster<'a> {
    /// Its number in the frame.
    pub index: usize,
    /// The mesh at its place.
    pub instance: &'a Instance,
    /// Its triangles.
    pub shape: CastShape<'a>,
    /// A hash of everything `facing` was computed from.
    pub key: u64,
    /// Its facing signs.
    pub facing: Arc<CasterFacing>,
}

impl Caster<'_> {
    /// The triangles that cast.
    pub fn triangles(&self) -> CastTriangles<'_> {
        CastTriangles {
            p_in_world: &self.facing.p_in_world,
            triangles: self.shape.topology().triangles(),
            cast: &self.facing.cast,
        }
    }
}

/// Groups of casters that are counted one after the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Groups {
    /// The groups, in the order of the scene and then of the file.
    pub groups: Vec<Vec<GroupMember>>,
    /// A bound on what all casters together count at any pixel.
    pub bound: u32,
    /// Whether counts must be folded between groups, and before the first if others have counted.
    pub folds: bool,
}

/// Splits `casters` into groups whose counts the stencil can hold on top of what others counted for the light before.
/// `apply` says which counts those are ([`LightContext::counts_before`]). Kept until a caster or the light moves.
pub fn group_by_layers(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    casters: &[Caster<'_>],
    apply: Apply,
) -> Arc<Groups> {
    let keys: Vec<u64> = casters.iter().map(|caster| caster.key).collect();
    let (position, before) = (light.light().position, light.counts_before(apply));
    let groups = light.cache.get_or_compute("layer groups", hash_of((&keys, before)), || {
        let triangles: Vec<CastTriangles<'_>> = casters.iter().map(Caster::triangles).collect();
        let everything: Vec<GroupMember> = (0..casters.len()).map(GroupMember::whole).collect();
        let bound = max_layers(position, &triangles, &everything, MAX_COUNT);
        if bound <= MAX_COUNT - before.min(MAX_COUNT) {
            return Groups { groups: vec![everything], bound, folds: false };
        }
        Groups { groups: layer_groups(position, &triangles, MAX_GROUP_COUNT), bound, folds: true }
    });
    if groups.folds {
        let (bound, count) = (groups.bound, groups.groups.len());
        out.note(format!(
            "a wider counter for '{}': up to {bound} layers are counted in {count} groups of at most {MAX_GROUP_COUNT}",
            light.light().name
        ));
    }
    groups
}
