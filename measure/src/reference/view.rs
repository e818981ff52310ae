//! A camera with a target: rays through places of it, and the depth that a rasteriser keeps there. The camera is
//! [fitted to the scene](CameraSnapshot::fitted_to), as it is for a frame.

use glam::{DAffine3, DVec3, DVec4};
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::CameraSnapshot;

use super::tracer::{Hit, Tracer};

/// A camera with a target.
pub(crate) struct View<'a> {
    camera: &'a CameraSnapshot,
    view_from_world: DAffine3,
    size_px: [f64; 2],
    pub(crate) eye: DVec4,
}

impl<'a> View<'a> {
    pub(crate) fn new(camera: &'a CameraSnapshot, size_px: [u32; 2]) -> Self {
        let view_from_world = camera.world_from_view.inverse();
        Self { camera, view_from_world, size_px: size_px.map(f64::from), eye: camera.frustum(size_px).eye }
    }

    /// Where the camera is: what positions are taken from.
    pub(crate) fn position(&self) -> DVec3 {
        self.camera.world_from_view.translation
    }

    /// The ray through a place of the target, in pixels from its top left corner; its parameter is the distance from
    /// the eye along the axis of view.
    pub(crate) fn ray(&self, [x, y]: [f64; 2]) -> (DVec3, DVec3) {
        let [width, height] = self.size_px;
        let (ndc_x, ndc_y) = (2.0 * x / width - 1.0, 1.0 - 2.0 * y / height);
        let (origin, direction) = self.camera.projection.view_ray(ndc_x, ndc_y, width / height);
        let world_from_view = &self.camera.world_from_view;
        (world_from_view.transform_point3(origin), world_from_view.transform_vector3(direction))
    }

    pub(crate) fn first_hit(&self, tracer: &mut Tracer<'_>, pixel: [f64; 2]) -> Option<(Hit, f64)> {
        let (from, direction) = self.ray(pixel);
        let [near_m, far_m] = self.range_m();
        tracer.first_hit(from, direction, near_m, far_m)
    }

    /// The distances between which it sees.
    pub(crate) fn range_m(&self) -> [f64; 2] {
        [self.camera.projection.near_m(), self.camera.projection.far_m()]
    }

    /// The depth of a point, or of where the view is cut off on the way to it.
    pub(crate) fn clipped_depth(&self, point: DVec3) -> f64 {
        let t = -self.view_from_world.transform_point3(point).z;
        let is_behind = matches!(self.camera.projection, Projection::Perspective { .. }) && t <= 0.0;
        if is_behind { 1.0 } else { self.depth(t).clamp(0.0, 1.0) }
    }

    /// What a rasteriser keeps of distance `t`, 1 at the near plane; over the target it is linear on every plane.
    pub(crate) fn depth(&self, t: f64) -> f64 {
        match self.camera.projection {
            Projection::Perspective { near_m, .. } => near_m / t,
            Projection::Orthographic { near_m, far_m, .. } => (far_m - t) / (far_m - near_m),
        }
    }

    /// The depth at which a ray of this camera meets the plane through `corner`; negative behind the eye.
    pub(crate) fn depth_of_plane(&self, corner: DVec3, normal: DVec3, from: DVec3, direction: DVec3) -> f64 {
        let (height, slope) = (normal.dot(corner - from), normal.dot(direction));
        match self.camera.projection {
            // 0 at the horizon, without a quotient by nothing.
            Projection::Perspective { near_m, .. } => near_m * slope / height,
            Projection::Orthographic { .. } => self.depth(height / slope),
        }
    }

    /// The distance between neighbouring values of the depth at distance `t`; half of that right before 1 under an orthographic
    /// eye. There depth is a difference of two numbers up to 1 whatever its own size, and has no far end with finer ulps: of
    /// [`super::DEPTH_ULPS`] half remains, thirty-two roundings of 1.
    pub(crate) fn depth_ulp(&self, t: f64) -> f64 {
        match self.camera.projection {
            Projection::Perspective { near_m, .. } => {
                let depth = (near_m / t) as f32;
                f64::from(depth.next_up()) - f64::from(depth)
            }
            Projection::Orthographic { .. } => f64::from(f32::EPSILON) / 4.0,
        }
    }

    /// The distance at which the depth is larger, hence nearer, than that at distance `t` by so much.
    pub(crate) fn distance_moved(&self, t: f64, by: f64) -> f64 {
        match self.camera.projection {
            Projection::Perspective { near_m, .. } => near_m / (near_m / t + by),
            Projection::Orthographic { near_m, far_m, .. } => t - by * (far_m - near_m),
        }
    }
}
