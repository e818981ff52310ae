//! Which casters can matter for a view: answered conservatively from bounds, so that a caster is left out only when it
//! certainly shadows nothing in view.

use glam::{DVec3, DVec4};

use super::View;
use crate::math::{Aabb, Plane};
use crate::scene::LightSnapshot;

/// Whether a caster within `bounds` may shadow something in view; the reason when it certainly does not.
///
/// A shadowed point in view and the light span a segment that meets the caster, so the caster must meet the convex
/// hull of everything in view and the light. That hull lies within every half-space that contains both: those of
/// the frustum's planes, and of the receivers' box, on whose inner side the light is.
///
/// # Errors
/// The reason why it cannot matter.
pub(super) fn may_shadow(view: &View, light: &LightSnapshot, bounds: &Aabb) -> Result<(), &'static str> {
    if bounds.is_empty() {
        return Err("has no vertices");
    }
    if !light.may_reach(bounds) {
        return Err("outside the light's range or cone");
    }
    if view.receiver_bounds.is_empty() {
        return Err("nothing in view receives");
    }
    let corners = bounds.corners();
    let separates = |plane: &Plane| {
        height_of_light(plane, light.position) >= 0.0 && corners.iter().all(|c| plane.height(*c) < 0.0)
    };
    if view.frustum.planes.iter().any(separates) {
        return Err("its shadow misses the view");
    }
    let receivers = view.receiver_bounds;
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let low = Plane { normal: axis, offset: axis.dot(receivers.min) };
        let high = Plane { normal: -axis, offset: -axis.dot(receivers.max) };
        if separates(&low) || separates(&high) {
            return Err("its shadow misses all receivers in view");
        }
    }
    Ok(())
}

/// The height of the homogeneous `light` over `plane`; for a direction, how much it rises along the normal.
fn height_of_light(plane: &Plane, light: DVec4) -> f64 {
    plane.normal.dot(light.truncate()) - plane.offset * light.w
}
