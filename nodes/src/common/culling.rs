//! What a view may see that the cheaper ways of casting do not hold for: whether its near plane may lie in a caster's
//! shadow, and whether a solid's inside may be seen.
//!
//! Answered conservatively: z-pass, and casting with half the triangles, are chosen only when that is certainly right.

use glam::{DVec3, DVec4};
use shadowgraph_engine::geometry::Topology;
use shadowgraph_engine::math::{Aabb, Plane, ViewFrustum};
use shadowgraph_engine::scene::Instance;

/// Whether an eye outside a solid may see its inside; the triangles that face the light outwards are then not enough
/// to cast. An eye sees through single-sided walls that turn their backs to it. Solids wound inwards (closed rooms,
/// usually) show their inside to every eye outside, and bending can push parts of a mesh through others, inside out.
/// (A mirroring transform turns winding and culling alike.)
pub fn shows_its_inside(instance: &Instance, topology: &Topology) -> bool {
    let single_sided = instance.materials.iter().any(|material| !material.double_sided);
    let wound_inwards = || topology.components().iter().any(|component| component.signed_volume < 0.0);
    single_sided && (instance.mesh.is_posed() || wound_inwards())
}

/// Whether a caster within `bounds` may shadow some point of the near rectangle. False only where it certainly does
/// not, so that counting from the near plane (z-pass) is right for it.
pub fn near_plane_may_be_shadowed(frustum: &ViewFrustum, light: DVec4, bounds: &Aabb) -> bool {
    !segments_from_eye_miss(frustum, light, bounds) && !near_pyramid_misses(frustum, light, bounds)
}

/// The segment from a near-plane point n to the light, and that from the eye, are nowhere further apart than n is
/// from the eye. So if the eye's misses the box grown by the distance to the near rectangle's corners, all miss it.
fn segments_from_eye_miss(frustum: &ViewFrustum, light: DVec4, bounds: &Aabb) -> bool {
    // For orthographic cameras, the middle of the near rectangle serves as the eye.
    let middle = frustum.near_corners.iter().sum::<DVec3>() * 0.25;
    let eye = if frustum.eye.w > 0.0 { frustum.eye.truncate() } else { middle };
    let reach_m = frustum.near_corners.iter().map(|corner| corner.distance(eye)).fold(0.0, f64::max);
    let grown = bounds.expanded(reach_m * (1.0 + 1e-9) + 1e-12 * (eye.length() + bounds.radius()));
    if light.w > 0.0 {
        !grown.intersects_segment(eye, light.truncate())
    } else {
        !grown.intersects_ray(eye, light.truncate(), f64::INFINITY)
    }
}

/// The pyramid over the near rectangle with its tip at the light, tested plane by plane.
fn near_pyramid_misses(frustum: &ViewFrustum, light: DVec4, bounds: &Aabb) -> bool {
    let corners = frustum.near_corners;
    let middle = corners.iter().sum::<DVec3>() * 0.25;
    if light.w > 0.0 {
        let around = Aabb::from_points(corners.into_iter().chain([light.truncate()]));
        let around = around.expanded(1e-9 * (around.radius() + around.center().length()));
        if !around.overlaps(bounds) {
            return true;
        }
    }
    let to_light = light.truncate() - middle * light.w;
    let normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]);
    let span = normal.length().sqrt();
    let height = to_light.dot(normal.normalize_or_zero());
    // A light about in the near plane makes the pyramid flat: no decision from here.
    if height.abs() <= 1e-6 * (to_light.length() + span) {
        return false;
    }
    let toward = if height > 0.0 { normal } else { -normal };
    let mut planes = vec![Plane::through(corners[0], toward)];
    if light.w > 0.0 {
        planes.push(Plane::through(light.truncate(), -toward));
    }
    for i in 0..4 {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        let mut plane = Plane::through(a, (b - a).cross(light.truncate() - a * light.w));
        if plane.height(middle) < 0.0 {
            plane = Plane { normal: -plane.normal, offset: -plane.offset };
        }
        planes.push(plane);
    }
    let margin = 1e-9 * (middle.length() + bounds.center().length() + bounds.radius());
    let box_corners = bounds.corners();
    planes.iter().any(|plane| {
        plane.normal != DVec3::ZERO && box_corners.iter().all(|corner| plane.height(*corner) < -margin)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DAffine3;
    use shadowgraph_engine::math::Projection;

    fn unit_box_at(center: DVec3) -> Aabb {
        Aabb { min: center - 0.5, max: center + 0.5 }
    }

    #[test]
    fn near_plane_is_shadowed_only_by_casters_towards_the_light() {
        for projection in [
            Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1 },
            Projection::Orthographic { half_height_m: 1.0, near_m: 0.1, far_m: 50.0 },
        ] {
            let frustum = ViewFrustum::new(&DAffine3::IDENTITY, &projection, 1.5);
            let light = DVec4::new(0.0, 10.0, 0.0, 1.0);
            let shadowed = |center, light| near_plane_may_be_shadowed(&frustum, light, &unit_box_at(center));
            assert!(shadowed(DVec3::new(0.0, 5.0, 0.0), light));
            assert!(!shadowed(DVec3::new(0.0, 5.0, -6.0), light));
            assert!(!shadowed(DVec3::new(0.0, 12.0, 0.0), light), "behind the light");
            assert!(shadowed(DVec3::new(0.0, 12.0, 0.0), DVec4::new(0.0, 1.0, 0.0, 0.0)));
        }
    }
}
