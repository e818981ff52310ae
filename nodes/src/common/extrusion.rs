//! Where shadow volumes end.
//!
//! Side fill dominates the cost of shadow volumes, and most of it lies behind everything that could receive. So the
//! sides of a caster end on *one plane*, where that is exact: light and caster strictly on its near side, the caster
//! between the two, every receiver in view and the near rectangle on the near side too. A view segment between
//! near-side points never crosses to the far side, so what is cut off there can change no count. (Ends on different
//! planes could cut a corner off; one plane cannot.) Otherwise sides run to infinity.

use glam::{DVec3, DVec4};
use shadowgraph_engine::math::{Aabb, Plane};
use shadowgraph_engine::shadow::View;

/// How the sides of one caster's volume end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// At infinity.
    Infinite,
    /// On this plane, in world space; light and receivers are on its positive side.
    Plane(Plane),
    /// As a copy of the caster scaled about the light by 1 + this factor, beyond everything in view: for orthographic
    /// views, which have no place for points at infinity.
    Scaled(f64),
    /// At this distance from where it begins, in metres, beyond everything in view: for orthographic views of casters
    /// that the light is next to or within, of which a scaled copy could have any size. Right as long as no edge
    /// spans more than a right angle as the light sees it: see [`super::beside_light`].
    Reach(f64),
}

/// A light is beside a caster within this share of the caster's radius.
pub const BESIDE: f64 = 0.1;

/// Stretches beyond this are not taken: sides that nearly miss the plane gain nothing.
const MAX_STRETCH: f64 = 1e3;

/// The plane on which the volume of a caster within `caster` may end exactly; `None` when there is none. Of the six
/// axis-aligned candidates the one with the shortest sides wins.
pub fn end_plane(view: &View, light: DVec4, caster: &Aabb) -> Option<Plane> {
    let near_side = Aabb::from_points(view.frustum.near_corners).union(&view.receiver_bounds).union(caster);
    let scale = near_side.radius() + near_side.center().length() * 1e-6;
    let margin = 1e-3 * scale;
    let candidates = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
    candidates
        .filter_map(|normal| {
            // Heights along the normal; the normal points to the light's side.
            let lowest = near_side.corners().iter().map(|c| normal.dot(*c)).fold(f64::INFINITY, f64::min);
            let top = caster.corners().iter().map(|c| normal.dot(*c)).fold(f64::NEG_INFINITY, f64::max);
            let plane = Plane { normal, offset: lowest - margin };
            let light_height = normal.dot(light.truncate());
            // For a vertex at height h the side is stretched by (h − offset) / (light's height above it).
            let above = if light.w > 0.0 { light_height - top } else { light_height * scale };
            let stretch = (top - plane.offset) / above;
            (above > 0.0 && stretch < MAX_STRETCH).then_some((stretch, plane))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, plane)| plane)
}

/// Where the volume of a caster within `caster` ends in this view: on a plane where that is exact, else beyond everything.
pub fn end_in_view(view: &View, light: DVec4, caster: &Aabb) -> End {
    end_plane(view, light, caster).map_or_else(|| end_beyond(view, light, caster), End::Plane)
}

/// The end beyond everything: at infinity, or where an orthographic view has its place.
pub fn end_beyond(view: &View, light: DVec4, caster: &Aabb) -> End {
    if view.frustum.eye.w > 0.0 {
        return End::Infinite;
    }
    let everything = Aabb::from_points(view.frustum.near_corners).union(&view.receiver_bounds).union(caster);
    let far_m = 4.0 * (everything.radius() + view.camera.projection.far_m());
    if light.w == 0.0 {
        return End::Scaled(far_m / light.truncate().length());
    }
    let light = light.truncate();
    let reach_m = far_m + everything.center().distance(light);
    let distance_m = caster.distance(light);
    // What is flat between directions at right angles comes nearer by up to the square root of 3.
    if distance_m > BESIDE * caster.radius() {
        End::Scaled(reach_m / distance_m)
    } else {
        End::Reach(2.0 * reach_m)
    }
}
