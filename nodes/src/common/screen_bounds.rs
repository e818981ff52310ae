//! Which pixels a shadow volume may touch: passes over the picture that only look at what it left are confined to them.
//!
//! A volume lies in the convex hull of the caster's box and of that box carried to the volume's end, which sixteen points
//! span. Seen by the eye, it lies in the rectangle around these points.

use glam::{DVec3, DVec4};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::shadow::View;

use super::extrusion::End;

/// x, y, width and height of the pixels that the volume of a caster within `caster` may touch; `None` where it touches
/// none. A pixel is added on every side.
pub fn volume_pixels(view: &View, light: DVec4, caster: &Aabb, end: End) -> Option<[u32; 4]> {
    // The light is next to the caster or within it: shadows go anywhere.
    if matches!(end, End::Reach(_)) {
        return Some([0, 0, view.size_px[0], view.size_px[1]]);
    }
    let near = caster.corners().map(|corner| corner.extend(1.0));
    let ends = caster.corners().map(|corner| end_of(corner, light, end));
    let points: Vec<DVec4> = near.into_iter().chain(ends).collect();
    view.pixels_around(&points)
}

/// Where a point of the caster is carried to, homogeneous.
fn end_of(p: DVec3, light: DVec4, end: End) -> DVec4 {
    let away = p * light.w - light.truncate();
    match end {
        End::Infinite => away.extend(0.0),
        End::Plane(plane) => {
            let stretch = (plane.offset - plane.normal.dot(p)) / plane.normal.dot(away);
            (p + away * stretch).extend(1.0)
        }
        End::Scaled(scale) => (p + away * scale).extend(1.0),
        End::Reach(reach_m) => (p + away.normalize_or_zero() * reach_m).extend(1.0),
    }
}

/// The smallest rectangle that contains both.
pub fn united(a: Option<[u32; 4]>, b: Option<[u32; 4]>) -> Option<[u32; 4]> {
    let (Some(a), Some(b)) = (a, b) else { return a.or(b) };
    let (left, top) = (a[0].min(b[0]), a[1].min(b[1]));
    let (right, bottom) = ((a[0] + a[2]).max(b[0] + b[2]), (a[1] + a[3]).max(b[1] + b[3]));
    Some([left, top, right - left, bottom - top])
}

#[cfg(test)]
mod tests {
    use super::*;
    use shadowgraph_engine::math::{Plane, ViewFrustum};
    use shadowgraph_engine::scene::{Camera, CameraSnapshot};

    fn view(camera: Camera, eye: DVec3, target: DVec3) -> View {
        let camera = CameraSnapshot::looking(camera, eye, target);
        let size_px = [640, 480];
        let frustum: ViewFrustum = camera.frustum(size_px);
        View {
            samples: 1,
            camera,
            size_px,
            frustum,
            receiver_bounds: Aabb { min: DVec3::splat(-9.0), max: DVec3::splat(9.0) },
        }
    }

    /// Points of the volume, near to far, that are in view lie in the rectangle; and it is no larger than needed where all
    /// of the volume is before the eye.
    #[test]
    fn what_is_in_the_volume_is_in_the_rectangle() {
        let caster = Aabb { min: DVec3::new(-0.5, 1.0, -0.4), max: DVec3::new(0.3, 1.8, 0.6) };
        let floor = Plane { normal: DVec3::Y, offset: -0.1 };
        let lights = [DVec4::new(0.7, 5.0, 0.2, 1.0), DVec4::new(0.3, 1.0, -0.4, 0.0)];
        let eyes = [DVec3::new(2.0, 3.0, 5.0), DVec3::new(0.1, 0.5, 0.1), DVec3::new(-6.0, 1.4, 0.0)];
        let mut seen = 0;
        for (light, eye) in lights.into_iter().flat_map(|light| eyes.map(|eye| (light, eye))) {
            for end in [End::Infinite, End::Plane(floor), End::Scaled(3.0)] {
                let view = view(Camera::perspective("eye", 0.9), eye, DVec3::new(0.0, 0.6, 0.0));
                let found = volume_pixels(&view, light, &caster, end);
                for i in 0..4000_u32 {
                    let part = |salt: u32| f64::from(i.wrapping_mul(2_654_435_761) >> salt & 0xff) / 255.0;
                    let p = caster.min + (caster.max - caster.min) * DVec3::new(part(3), part(11), part(19));
                    let far = end_of(p, light, end);
                    let along = if far.w == 0.0 { part(7) * 40.0 } else { part(7) };
                    let point =
                        if far.w == 0.0 { p + far.truncate() * along } else { p.lerp(far.truncate(), along) };
                    let clip = view.camera.projection.clip_from_view(640.0 / 480.0)
                        * view.camera.world_from_view.inverse().transform_point3(point).extend(1.0);
                    let (x, y) = (clip.x / clip.w, clip.y / clip.w);
                    if clip.w <= view.camera.projection.near_m() || x.abs() > 1.0 || y.abs() > 1.0 {
                        continue;
                    }
                    seen += 1;
                    let (x, y) = ((x * 0.5 + 0.5) * 640.0, (0.5 - y * 0.5) * 480.0);
                    let [left, top, width, height] = found.expect("something is in view").map(f64::from);
                    assert!(
                        x >= left && x <= left + width && y >= top && y <= top + height,
                        "{x} {y} {found:?}"
                    );
                }
            }
        }
        assert!(seen > 10_000);
        let above = view(Camera::perspective("eye", 0.9), eyes[0], DVec3::new(0.0, 0.6, 0.0));
        let [.., width, height] =
            volume_pixels(&above, lights[0], &caster, End::Plane(floor)).expect("in view");
        assert!(width < 400 && height < 400, "{width} {height}");
        let away = view(Camera::perspective("eye", 0.9), eyes[0], DVec3::new(4.0, 9.0, 10.0));
        assert_eq!(volume_pixels(&away, lights[0], &caster, End::Plane(floor)), None);
        assert_eq!(united(Some([1, 2, 3, 4]), Some([3, 0, 5, 3])), Some([1, 0, 7, 6]));
    }
}
