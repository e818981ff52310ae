//! Flat casters, a floor usually: their shadows fall only on what lies behind them, so maps need not show more of them.

use glam::DVec3;
use shadowgraph_engine::math::{Aabb, Plane};
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::LightContext;

use super::boxes::{cut, faces_of};

/// What of all that receives can be behind a caster, as the light sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Behind {
    /// Nothing: the caster is flat, and all else is before it or in its plane.
    Nothing,
    /// What lies in this box: the caster is flat.
    Within(Aabb),
    /// Anything: the caster is not flat, or the light is in its plane.
    Anything,
}

/// What can be behind a caster of `receivers`, which are numbered boxes.
pub fn behind(
    light: &LightContext<'_>,
    (index, instance): (usize, &Instance),
    receivers: &[(usize, Aabb)],
) -> Behind {
    let plane = light.cache.get_or_compute("flat caster", instance.pose_key, || plane_of(instance));
    let Some(plane) = *plane else { return Behind::Anything };
    let position = light.light().position;
    let height = plane.normal.dot(position.truncate()) - plane.offset * position.w;
    let lost = lost_of(&instance.world_bounds);
    if height.abs() <= lost * position.w {
        return Behind::Anything;
    }
    let side = if height > 0.0 { plane } else { Plane { normal: -plane.normal, offset: -plane.offset } };
    let others = receivers.iter().filter(|(receiver, _)| *receiver != index);
    let parts = others.filter_map(|(_, bounds)| {
        let lost = lost + lost_of(bounds);
        let corners = bounds.corners();
        if corners.iter().all(|corner| side.height(*corner) >= -lost) {
            return None;
        }
        let beyond = Plane { normal: -side.normal, offset: lost - side.offset };
        Some(Aabb::from_points(cut(&faces_of(&corners), &beyond).into_iter().flatten()))
    });
    parts.reduce(|all, part| all.union(&part)).map_or(Behind::Nothing, Behind::Within)
}

/// How far off a plane something within `bounds` may be and yet lie in it: what f32 loses of its size, and f64 of its place.
fn lost_of(bounds: &Aabb) -> f64 {
    1e-7 * bounds.radius() + 1e-14 * bounds.center().length()
}

/// The plane in which all of an instance lies, if there is one.
fn plane_of(instance: &Instance) -> Option<Plane> {
    let mesh = &instance.mesh;
    let largest = (0..mesh.triangle_count())
        .map(|triangle| {
            let [a, b, c] = instance.world_triangle(triangle);
            (a, (b - a).cross(c - a))
        })
        .max_by(|(_, a), (_, b)| a.length_squared().total_cmp(&b.length_squared()))?;
    let plane = Plane::through(largest.0, largest.1);
    let lost = lost_of(&instance.world_bounds);
    let lies_in = |vertex: u32| plane.height(instance.world_position(vertex)).abs() <= lost;
    (plane.normal != DVec3::ZERO && (0..mesh.positions().len() as u32).all(lies_in)).then_some(plane)
}
