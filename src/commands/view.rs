//! What a camera sees of a scene, before anything is drawn: enough to say that a picture will be empty, and why.

use glam::DVec3;
use shadowgraph::engine::math::Projection;
use shadowgraph::engine::scene::SceneSnapshot;
use shadowgraph::prelude::*;

use super::Failure;
use super::output::note;

/// What is in the way of seeing anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Empty {
    /// All that lies before the eye is nearer than the near plane.
    TooNear,
    /// Everything is beside the view or behind it.
    OutOfView,
}

/// Says on stderr if nothing will be seen.
pub(crate) fn note_empty(scene: &Scene, camera: &CameraSnapshot, size_px: [u32; 2]) -> Result<(), Failure> {
    let snapshot = scene.snapshot().map_err(RenderError::from)?;
    if let Some(text) = empty_text(&snapshot, camera, size_px) {
        note!("note: {text}");
    }
    Ok(())
}

/// What is to be said of a view in which nothing is.
pub(crate) fn empty_text(
    snapshot: &SceneSnapshot,
    camera: &CameraSnapshot,
    size_px: [u32; 2],
) -> Option<String> {
    let (Projection::Perspective { near_m, .. } | Projection::Orthographic { near_m, .. }) =
        camera.projection;
    let near = shadowgraph::engine::gltf::few_digits(near_m);
    match empty(snapshot, camera, size_px)? {
        Empty::TooNear => Some(format!(
            "nothing is seen: all that is before camera '{}' is nearer than its near plane ({near} m)",
            camera.name
        )),
        Empty::OutOfView => Some(format!("nothing is seen: nothing is in view of camera '{}'", camera.name)),
    }
}

/// `None` as soon as one triangle may be seen.
fn empty(snapshot: &SceneSnapshot, camera: &CameraSnapshot, size_px: [u32; 2]) -> Option<Empty> {
    let view = View::new(camera, size_px);
    let mut anything_near = false;
    for instance in snapshot.instances.iter().filter(|instance| instance.mesh.triangle_count() > 0) {
        let bounds = &instance.world_bounds;
        let corner = |i: usize| {
            let pick = |axis: usize| if i >> axis & 1 == 0 { bounds.min[axis] } else { bounds.max[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let outside = view.outside((0..8).map(corner));
        if outside & !NEAR != 0 {
            // Beside the view; what is beside it and too near is not missed for being near.
            continue;
        }
        // A box may reach into the view where none of its triangles does.
        for triangle in 0..instance.mesh.triangle_count() {
            let corners = instance.mesh.triangle(triangle).map(|vertex| {
                let local = instance.mesh.positions()[vertex as usize].as_dvec3();
                instance.world_from_local.transform_point3(local)
            });
            match view.outside(corners.into_iter()) {
                0 => return None,
                NEAR => anything_near = true,
                _ => {}
            }
        }
    }
    Some(if anything_near { Empty::TooNear } else { Empty::OutOfView })
}

/// Nearer than the near plane, though before the eye.
const NEAR: u32 = 1;

/// The sides of a view.
struct View {
    view_from_world: DAffine3,
    projection: Projection,
    aspect: f64,
}

impl View {
    fn new(camera: &CameraSnapshot, size_px: [u32; 2]) -> Self {
        let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
        Self { view_from_world: camera.world_from_view.inverse(), projection: camera.projection, aspect }
    }

    /// A bit for each side of the view that all points are beyond.
    fn outside(&self, points: impl Iterator<Item = DVec3>) -> u32 {
        points.fold(u32::MAX, |outside, point| outside & self.sides(point))
    }

    /// A bit for each side of the view that a point is beyond.
    fn sides(&self, point: DVec3) -> u32 {
        let at = self.view_from_world.transform_point3(point);
        let depth_m = -at.z;
        let (half_height_m, near_m, far_m) = match self.projection {
            Projection::Perspective { fov_y_rad, near_m } => {
                (depth_m * (fov_y_rad * 0.5).tan(), near_m, f64::INFINITY)
            }
            Projection::Orthographic { half_height_m, near_m, far_m } => (half_height_m, near_m, far_m),
        };
        let half_width_m = half_height_m * self.aspect;
        let beyond = [
            depth_m < near_m,
            depth_m < 0.0,
            depth_m > far_m,
            at.x > half_width_m,
            at.x < -half_width_m,
            at.y > half_height_m,
            at.y < -half_height_m,
        ];
        beyond.iter().enumerate().fold(0, |bits, (bit, beyond)| bits | u32::from(*beyond) << bit)
    }
}
