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
    /// As a copy of the caster scaled about the light by 1 + this; for orthographic views, in which a point at
    /// infinity has no place. The factor puts the copy beyond everything in view.
    Scaled(f64),
}

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

/// Where the volume of a caster within `caster` ends in this view: on a plane where that is exact, else at infinity, or
/// where an orthographic view has its place.
pub fn end_in_view(view: &View, light: DVec4, caster: &Aabb) -> End {
    match end_plane(view, light, caster) {
        Some(plane) => End::Plane(plane),
        None if view.frustum.eye.w == 0.0 => End::Scaled(scaled_end(view, light, caster)),
        None => End::Infinite,
    }
}

/// The factor of [`End::Scaled`] that puts the far copy beyond everything in view.
pub fn scaled_end(view: &View, light: DVec4, caster: &Aabb) -> f64 {
    let everything = Aabb::from_points(view.frustum.near_corners).union(&view.receiver_bounds).union(caster);
    let far_m = 4.0 * (everything.radius() + view.camera.projection.far_m());
    if light.w == 0.0 {
        return far_m / light.truncate().length();
    }
    let light = light.truncate();
    let reach_m = far_m + everything.center().distance(light);
    // A caster that touches the light would need an infinite factor; its nearest part is taken as 10⁻⁶ of its size.
    reach_m / caster.distance(light).max(1e-6 * caster.radius())
}
