//! Casters whose corners are so far from the eye that f32 loses more of them than the snap moves: see [`super::moved`].
//!
//! Their shadows' edges are off by what their corners are, times how much farther from the light the receiver is. Where such a
//! caster stands in the light's way from some places that near the receiver's point and not from others, what is drawn may be either.

use glam::{DVec3, DVec4};

use super::moved::{Moved, POSITION_LOSS, counts, lost_m};
use super::surface::Triangle;
use super::tracer::{CasterSet, Tracer};

/// How much farther than its caster a receiver may be from a lamp for the way between to count in full.
const FARTHEST: f64 = 1e3;

impl Tracer<'_> {
    /// Whether what positions lose of a caster's corners decides if it stands between a point and `light`.
    pub(crate) fn may_miss(&mut self, moved: &Moved<'_>, light: DVec4, casters: &CasterSet) -> bool {
        let Self { reference, stack, .. } = self;
        let bounds = &reference.world_bounds;
        let farthest_m =
            (bounds.min - moved.position).abs().max((bounds.max - moved.position).abs()).length();
        let most_m = POSITION_LOSS * farthest_m;
        if !counts(most_m, moved.snap_m) || !reference.bvh.takes_thickness(2.0 * most_m) {
            return false;
        }
        let Some(way) = reference.bvh.way_to_light(moved.points[0], light, 2.0 * most_m) else {
            return false;
        };
        let mut differs = false;
        reference.bvh.walk(&way, stack, |leaf| {
            differs |= reference.triangles[leaf].iter().any(|triangle| {
                triangle.casts
                    && casters.contains(triangle.instance)
                    && !triangle.holds(moved.surface, reference.coordinate_m)
                    && is_doubtful(triangle, moved, light, reference.coordinate_m)
            });
            differs.then_some(-1.0)
        });
        differs
    }
}

/// Whether a triangle, moved by what its corners may be off, may stand in the light's way where it does not or the other way round.
fn is_doubtful(triangle: &Triangle, moved: &Moved<'_>, light: DVec4, coordinate_m: f64) -> bool {
    let lost_m = lost_m(triangle, moved.position, moved.snap_m);
    if lost_m == 0.0 {
        return false;
    }
    // Moving the triangle one way is moving the point the other way, farther by how much farther it is from a lamp.
    let point = moved.points[0];
    let to_light = light.truncate() - point * light.w;
    let met = triangle.plane_parameter(point, to_light).unwrap_or(0.0).clamp(0.0, 1.0 - 1.0 / FARTHEST);
    let aside_m = if light.w == 0.0 { lost_m } else { lost_m / (1.0 - met) };
    let (u, v) = to_light.normalize_or(DVec3::Y).any_orthonormal_pair();
    let normal = triangle.normal().normalize_or_zero();
    let blocks = |by: DVec3| triangle.blocks(point + by, light, coordinate_m);
    let here = blocks(DVec3::ZERO);
    [u * aside_m, v * aside_m, normal * lost_m]
        .into_iter()
        .any(|by| blocks(by) != here || blocks(-by) != here)
}
