//! Camera projections with reversed depth, and the camera's frustum in the world.

use glam::{DAffine3, DMat4, DVec3, DVec4};

use super::{Aabb, Plane};

/// How a camera maps view space (x right, y up, looking along −z) to clip space, near = 1 and far = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// A perspective camera without a far plane: depth = near / distance, and directions (w = 0) land at depth
    /// exactly 0.
    Perspective {
        /// The vertical opening angle, in radians.
        fov_y_rad: f64,
        /// The distance of the near plane, in metres.
        near_m: f64,
    },
    /// An orthographic camera: depth falls linearly from 1 at `near_m` to 0 at `far_m`.
    Orthographic {
        /// Half the height of the view, in metres.
        half_height_m: f64,
        /// The distance of the near plane, in metres.
        near_m: f64,
        /// The distance of the far plane, in metres.
        far_m: f64,
    },
}

impl Projection {
    /// The matrix clip_from_view for a target of the given `aspect` (width / height).
    ///
    /// A perspective matrix's third row is (0, 0, 0, near): depth does not depend on z before the division, so a
    /// vertex at infinity has depth exactly 0.
    pub fn clip_from_view(&self, aspect: f64) -> DMat4 {
        match *self {
            Self::Perspective { fov_y_rad, near_m } => {
                let f = 1.0 / (fov_y_rad * 0.5).tan();
                DMat4::from_cols(
                    DVec4::new(f / aspect, 0.0, 0.0, 0.0),
                    DVec4::new(0.0, f, 0.0, 0.0),
                    DVec4::new(0.0, 0.0, 0.0, -1.0),
                    DVec4::new(0.0, 0.0, near_m, 0.0),
                )
            }
            Self::Orthographic { half_height_m, near_m, far_m } => {
                let depth_per_m = 1.0 / (far_m - near_m);
                DMat4::from_cols(
                    DVec4::new(1.0 / (half_height_m * aspect), 0.0, 0.0, 0.0),
                    DVec4::new(0.0, 1.0 / half_height_m, 0.0, 0.0),
                    DVec4::new(0.0, 0.0, depth_per_m, 0.0),
                    DVec4::new(0.0, 0.0, far_m * depth_per_m, 1.0),
                )
            }
        }
    }

    /// The ray through normalised device coordinates (x right, y up, −1 … 1), in view space: origin and direction
    /// (not normalised; its −z component is 1). The near plane is where t = near.
    pub fn view_ray(&self, ndc_x: f64, ndc_y: f64, aspect: f64) -> (DVec3, DVec3) {
        match *self {
            Self::Perspective { fov_y_rad, .. } => {
                let t = (fov_y_rad * 0.5).tan();
                (DVec3::ZERO, DVec3::new(ndc_x * t * aspect, ndc_y * t, -1.0))
            }
            Self::Orthographic { half_height_m, .. } => {
                (DVec3::new(ndc_x * half_height_m * aspect, ndc_y * half_height_m, 0.0), DVec3::NEG_Z)
            }
        }
    }

    /// The distance of the near plane, in metres.
    pub fn near_m(&self) -> f64 {
        match *self {
            Self::Perspective { near_m, .. } | Self::Orthographic { near_m, .. } => near_m,
        }
    }

    /// The distance of the far plane, in metres; infinite for a perspective camera.
    pub fn far_m(&self) -> f64 {
        match *self {
            Self::Perspective { .. } => f64::INFINITY,
            Self::Orthographic { far_m, .. } => far_m,
        }
    }

    /// Whether the near plane is strictly before the far plane and everything is finite and positive.
    pub fn is_valid(&self) -> bool {
        match *self {
            Self::Perspective { fov_y_rad, near_m } => {
                fov_y_rad > 0.0 && fov_y_rad < std::f64::consts::PI && near_m > 0.0 && near_m.is_finite()
            }
            Self::Orthographic { half_height_m, near_m, far_m } => {
                half_height_m > 0.0
                    && half_height_m.is_finite()
                    && near_m.is_finite()
                    && near_m >= 0.0
                    && far_m > near_m
                    && far_m.is_finite()
            }
        }
    }
}

/// What a camera sees, in world space: the eye, the near rectangle and the inward-facing planes.
#[derive(Clone, Debug, PartialEq)]
pub struct ViewFrustum {
    /// The eye as a homogeneous point: (position, 1), or (direction towards the eye, 0) for orthographic cameras.
    pub eye: DVec4,
    /// The corners of the near rectangle, counter-clockwise as the eye sees them.
    pub near_corners: [DVec3; 4],
    /// Near, left, right, bottom, top and, for orthographic cameras, far; positive inside.
    pub planes: Vec<Plane>,
}

impl ViewFrustum {
    /// The frustum of a camera that stands at `world_from_view`.
    pub fn new(world_from_view: &DAffine3, projection: &Projection, aspect: f64) -> Self {
        let near_m = projection.near_m();
        let forward = world_from_view.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
        let ndc_corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        let rays = ndc_corners.map(|(x, y)| {
            let (origin, direction) = projection.view_ray(x, y, aspect);
            (world_from_view.transform_point3(origin), world_from_view.transform_vector3(direction))
        });
        let near_corners = rays.map(|(origin, direction)| origin + direction * near_m);
        let mut planes = vec![Plane::through(near_corners[0], forward)];
        let middle = near_corners.iter().sum::<DVec3>() * 0.25 + forward * near_m.max(1e-3);
        for i in 0..4 {
            let edge = near_corners[(i + 1) % 4] - near_corners[i];
            let mut plane = Plane::through(near_corners[i], edge.cross(rays[i].1));
            if plane.height(middle) < 0.0 {
                plane = Plane { normal: -plane.normal, offset: -plane.offset };
            }
            planes.push(plane);
        }
        if projection.far_m().is_finite() {
            planes.push(Plane::through(rays[0].0 + rays[0].1 * projection.far_m(), -forward));
        }
        let eye = match projection {
            Projection::Perspective { .. } => DVec4::from((world_from_view.translation, 1.0)),
            Projection::Orthographic { .. } => DVec4::from((-forward, 0.0)),
        };
        Self { eye, near_corners, planes }
    }

    /// Whether the box may be seen: false only when it lies wholly outside one plane.
    pub fn may_see(&self, bounds: &Aabb) -> bool {
        let corners = bounds.corners();
        !bounds.is_empty() && self.planes.iter().all(|plane| corners.iter().any(|c| plane.height(*c) >= 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_one_at_near_and_zero_at_infinity() {
        let m = Projection::Perspective { fov_y_rad: 1.0, near_m: 0.25 }.clip_from_view(1.5);
        let near = m * DVec4::new(0.0, 0.0, -0.25, 1.0);
        assert_eq!(near.z / near.w, 1.0);
        assert_eq!((m * DVec4::new(0.3, 0.1, -0.5, 0.0)).z, 0.0);
        let m = Projection::Orthographic { half_height_m: 2.0, near_m: 1.0, far_m: 5.0 }.clip_from_view(1.5);
        assert_eq!((m * DVec4::new(0.0, 0.0, -1.0, 1.0)).z, 1.0);
        assert_eq!((m * DVec4::new(0.0, 0.0, -5.0, 1.0)).z, 0.0);
    }

    #[test]
    fn frustum_planes_face_inwards() {
        for projection in [
            Projection::Perspective { fov_y_rad: 1.0, near_m: 0.1 },
            Projection::Orthographic { half_height_m: 1.0, near_m: 0.0, far_m: 10.0 },
        ] {
            let frustum =
                ViewFrustum::new(&DAffine3::from_translation(DVec3::new(3.0, 2.0, 1.0)), &projection, 2.0);
            let inside = DVec3::new(3.0, 2.0, -1.0);
            assert!(frustum.planes.iter().all(|plane| plane.height(inside) > 0.0), "{frustum:?}");
            assert!(frustum.may_see(&Aabb::from_points([inside])));
            assert!(!frustum.may_see(&Aabb::from_points([DVec3::new(3.0, 2.0, 4.0)])));
        }
    }
}
