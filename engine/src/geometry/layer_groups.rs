//! Splitting what casts for one light into groups that a small counter can hold.
//!
//! Any set of triangles casts a closed chain, so casters can be counted one after the other, and even one mesh can be
//! split. Each group must be counted and resolved by itself, and the shadows then united: counts of two groups in one
//! counter could wrap together.

use glam::{DVec3, DVec4};

use super::LayerGrid;
use crate::math::Aabb;

/// What one caster casts with.
#[derive(Clone, Copy, Debug)]
pub struct CastTriangles<'a> {
    /// Vertices in the world.
    pub p_in_world: &'a [DVec3],
    /// The corners of every triangle.
    pub triangles: &'a [[u32; 3]],
    /// The triangles that cast.
    pub cast: &'a [u32],
}

impl CastTriangles<'_> {
    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|corner| self.p_in_world[corner as usize])
    }
}

/// One caster, or some of its triangles, in a group of certified size.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupMember {
    /// The caster's place in the list that was split.
    pub caster: usize,
    /// The triangles; `None` for all that cast.
    pub triangles: Option<Vec<u32>>,
}

impl GroupMember {
    /// All of one caster.
    pub fn whole(caster: usize) -> Self {
        Self { caster, triangles: None }
    }

    fn cast<'a>(&'a self, casters: &[CastTriangles<'a>]) -> &'a [u32] {
        self.triangles.as_deref().unwrap_or(casters[self.caster].cast)
    }
}

/// Splits `casters` into groups that no ray from `light` crosses more than `limit` times (at least 1). One group is
/// the common case; groups keep the order of casters and triangles, and those without triangles are left out.
///
/// # Panics
/// When a triangle or corner is out of range.
pub fn layer_groups(light: DVec4, casters: &[CastTriangles<'_>], limit: u32) -> Vec<Vec<GroupMember>> {
    let limit = limit.max(1);
    let mut groups = Vec::new();
    let mut open: Vec<Vec<GroupMember>> = vec![(0..casters.len()).map(GroupMember::whole).collect()];
    // Halves of the order in the file: neighbours stay together, and the second half waits.
    while let Some(mut group) = open.pop() {
        if max_layers(light, casters, &group, limit) <= limit {
            group.retain(|member| !member.cast(casters).is_empty());
            groups.extend((!group.is_empty()).then_some(group));
        } else if group.len() > 1 {
            let second_half = group.split_off(group.len() / 2);
            open.extend([second_half, group]);
        } else if let Some(member) = group.pop() {
            let caster = member.caster;
            let mut triangles = member.cast(casters).to_vec();
            let second_half = triangles.split_off(triangles.len() / 2);
            open.extend(
                [second_half, triangles].map(|half| vec![GroupMember { caster, triangles: Some(half) }]),
            );
        }
    }
    groups
}

/// A bound on the triangles of `members` that one ray from `light` crosses. A first bound above `enough` is tried
/// again with a finer grid.
///
/// # Panics
/// When a caster, triangle or corner is out of range.
pub fn max_layers(light: DVec4, casters: &[CastTriangles<'_>], members: &[GroupMember], enough: u32) -> u32 {
    let count: usize = members.iter().map(|member| member.cast(casters).len()).sum();
    // No ray crosses more triangles than there are.
    if count <= enough as usize {
        return count as u32;
    }
    let mut bounds = Aabb::EMPTY;
    for member in members {
        for triangle in member.cast(casters) {
            for corner in casters[member.caster].corners(*triangle) {
                bounds = bounds.union(&Aabb { min: corner, max: corner });
            }
        }
    }
    let bound_with = |detail: usize| {
        let mut grid = LayerGrid::with_detail(light, &bounds, count, detail);
        for member in members {
            let CastTriangles { p_in_world, triangles, .. } = casters[member.caster];
            grid.add_mesh(p_in_world, triangles, member.cast(casters));
        }
        grid.max_layers()
    };
    let bound = bound_with(1);
    if bound > enough { bound.min(bound_with(4)) } else { bound }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_certified_and_complete() {
        // 300 unit triangles one above the other, of which one does not cast.
        let stack: Vec<DVec3> = (0..300)
            .flat_map(|i| [DVec3::ZERO, DVec3::X, DVec3::Z].map(|p| p + DVec3::Y * f64::from(i)))
            .collect();
        let triangles: Vec<[u32; 3]> = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let cast: Vec<u32> = (0..300).filter(|triangle| *triangle != 7).collect();
        let caster = CastTriangles { p_in_world: &stack, triangles: &triangles, cast: &cast };
        let light = DVec4::new(0.0, 1.0, 0.0, 0.0);
        let listed = |groups: &[Vec<GroupMember>], casters: &[CastTriangles<'_>]| -> Vec<Vec<(usize, u32)>> {
            let all = |member: &GroupMember| {
                let triangles = member.triangles.clone().unwrap_or(casters[member.caster].cast.to_vec());
                triangles.into_iter().map(|t| (member.caster, t)).collect::<Vec<_>>()
            };
            groups.iter().map(|group| group.iter().flat_map(all).collect()).collect()
        };
        let groups = listed(&layer_groups(light, &[caster], 255), &[caster]);
        assert_eq!(groups.iter().map(Vec::len).collect::<Vec<_>>(), [149, 150]);
        assert!(groups.concat().into_iter().eq(cast.iter().map(|t| (0, *t))));
        assert_eq!(layer_groups(light, &[caster], 299), [[GroupMember::whole(0)]]);
        assert_eq!(layer_groups(light, &[caster], 0).len(), 299);
        // Casters are kept together while they fit, and split only when one alone does not.
        let casters = [caster; 3];
        let groups = listed(&layer_groups(light, &casters, 400), &casters);
        assert_eq!(groups.iter().map(Vec::len).collect::<Vec<_>>(), [299, 299, 299]);
        assert_eq!(layer_groups(light, &casters, 600).len(), 2);
        // Nothing is no group.
        let nothing = CastTriangles { cast: &[], ..caster };
        assert!(layer_groups(light, &[nothing], 255).is_empty() && layer_groups(light, &[], 1).is_empty());
    }
}
