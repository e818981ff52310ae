//! Which pixels a light can reach: what it lights and what shadows it are nowhere else.

use glam::DVec3;

use super::schedule::Group;
use crate::math::Aabb;
use crate::plan::Resource;
use crate::scene::{LightKind, LightSnapshot};
use crate::shadow::{Draw, View};

/// x, y, width and height of the pixels that hold all receivers that a light's range and cone let it reach in view; all pixels
/// where that is most of them. `None` where it reaches none.
pub(super) fn pixels(view: &View, light: &LightSnapshot) -> Option<[u32; 4]> {
    if light.position.w == 0.0 {
        return Some(everywhere(view));
    }
    let (origin, receivers) = (light.position.truncate(), &view.receiver_bounds);
    // Beyond the farthest receiver there is nothing to be shadowed.
    let farthest = receivers.corners().map(|corner| corner.distance(origin)).into_iter().fold(0.0, f64::max);
    let reach_m = light.light.range_m.map_or(farthest, |range_m| range_m.min(farthest));
    let sector = sector_bounds(light, reach_m);
    let lit = Aabb { min: sector.min.max(receivers.min), max: sector.max.min(receivers.max) };
    if lit.is_empty() { None } else { pixels_of(view, &lit) }
}

/// The same of all surfaces, receivers or not: they are lit within the light's range.
pub(super) fn lit_pixels(view: &View, light: &LightSnapshot) -> Option<[u32; 4]> {
    match light.light.range_m {
        Some(range_m) if light.position.w > 0.0 => pixels_of(view, &sector_bounds(light, range_m)),
        _ => Some(everywhere(view)),
    }
}

/// The pixels of a box.
fn pixels_of(view: &View, lit: &Aabb) -> Option<[u32; 4]> {
    let pixels = view.pixels_around(&lit.corners().map(|corner| corner.extend(1.0)))?;
    let area = |[_, _, width, height]: [u32; 4]| f64::from(width) * f64::from(height);
    let is_gain = area(pixels) < WORTH_IT * area(everywhere(view));
    Some(if is_gain { pixels } else { everywhere(view) })
}

/// What a light reaches is all of a picture where it is more than this share of it.
const WORTH_IT: f64 = 0.75;

fn everywhere(view: &View) -> [u32; 4] {
    [0, 0, view.size_px[0], view.size_px[1]]
}

/// The box around what lies within a light's cone and this distance.
fn sector_bounds(light: &LightSnapshot, reach_m: f64) -> Aabb {
    let (origin, reach_m) = (light.position.truncate(), reach_m * (1.0 + 1e-6));
    let half_angle_rad = match light.light.kind {
        LightKind::Spot { outer_rad, .. } => outer_rad,
        _ => std::f64::consts::PI,
    };
    // How far it reaches along a direction: to where that leaves the cone, and never behind the light.
    let along = |axis: DVec3| {
        let off_axis_rad = axis.dot(light.direction).clamp(-1.0, 1.0).acos();
        (reach_m * (off_axis_rad - half_angle_rad).max(0.0).cos()).max(0.0)
    };
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let (most, least) =
        (DVec3::new(along(x), along(y), along(z)), DVec3::new(along(-x), along(-y), along(-z)));
    Aabb { min: origin - least, max: origin + most }
}

/// Confines what a light's passes leave of it, counts and visibility, to the pixels that it reaches.
pub(super) fn confine(group: &mut Group<'_>, view: &View, light: &LightSnapshot) {
    let within = pixels(view, light);
    if within == Some(everywhere(view)) {
        return;
    }
    for pass in &mut group.passes {
        if pass.counts() || pass.draws_into(Resource::VISIBILITY) {
            let confined = |draw: &mut Draw| {
                draw.scissor_px = within.and_then(|within| common(within, draw.scissor_px.unwrap_or(within)));
                draw.scissor_px.is_some()
            };
            pass.to_mut().draws.retain_mut(confined);
        }
    }
}

/// What two rectangles have in common.
fn common(a: [u32; 4], b: [u32; 4]) -> Option<[u32; 4]> {
    let (left, top) = (a[0].max(b[0]), a[1].max(b[1]));
    let (right, bottom) = ((a[0] + a[2]).min(b[0] + b[2]), (a[1] + a[3]).min(b[1] + b[3]));
    (left < right && top < bottom).then(|| [left, top, right - left, bottom - top])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Projection;
    use crate::random::{random, random_point};
    use crate::scene::{Camera, CameraSnapshot, Light, Scene};

    #[test]
    fn whatever_a_light_reaches_is_within_its_pixels() {
        let (mut seed, size_px) = (11, [160, 120]);
        let (mut reached, mut confined) = (0, 0);
        for round in 0..300 {
            let name = format!("light {round}");
            let light = match round % 3 {
                0 => Light::point(&name, 1.0).with_range(0.3 + random(&mut seed).abs()),
                1 => Light::spot(&name, 1.0, 0.2 + 0.6 * random(&mut seed).abs()),
                _ => Light::spot(&name, 1.0, 1.5).with_range(0.8),
            };
            let mut scene = Scene::new();
            let at = random_point(&mut seed) * 2.0;
            scene.add_light(light, at, at + random_point(&mut seed));
            let snapshot = scene.snapshot().expect("one light is a scene");
            let eye = random_point(&mut seed) * 3.0;
            let mut camera = Camera::perspective("eye", 0.9);
            if round % 5 == 4 {
                camera.projection = Projection::Orthographic { half_height_m: 1.5, near_m: 0.1, far_m: 9.0 };
            }
            let camera = CameraSnapshot::looking(camera, eye, random_point(&mut seed));
            let receivers = Aabb { min: DVec3::new(-2.5, -1.0, -2.0), max: DVec3::new(2.0, 1.5, 2.5) };
            let frustum = camera.frustum(size_px);
            let view = View { camera, size_px, samples: 1, frustum, receiver_bounds: receivers };
            let found = pixels(&view, &snapshot.lights[0]);
            confined += usize::from(found != Some(everywhere(&view)));
            let clip_from_world = view.camera.clip_from_world(size_px);
            for _ in 0..1200 {
                let p = random_point(&mut seed) * 2.5;
                let clip = clip_from_world * p.extend(1.0);
                let (x, y) = (clip.x / clip.w * 0.5 + 0.5, 0.5 - clip.y / clip.w * 0.5);
                let is_seen = view.frustum.planes.iter().all(|plane| plane.height(p) > 0.0);
                if !snapshot.lights[0].reaches(p) || !is_seen {
                    continue;
                }
                reached += 1;
                let (x, y) = (x * 160.0, y * 120.0);
                // Surfaces are lit whether or not they receive shadows.
                let receives = receivers.contains(p).then_some(found);
                for found in receives.into_iter().chain([lit_pixels(&view, &snapshot.lights[0])]) {
                    let [left, top, width, height] = found.unwrap_or_default().map(f64::from);
                    let is_within = x >= left && x <= left + width && y >= top && y <= top + height;
                    assert!(is_within, "{round}: {p} at {x} {y}, not in {found:?}");
                }
            }
        }
        assert!(reached > 2000 && confined > 100, "{reached} points, {confined} lights");
    }

    #[test]
    fn rectangles_have_in_common_what_both_have() {
        assert_eq!(common([0, 0, 4, 4], [2, 1, 9, 2]), Some([2, 1, 2, 2]));
        assert_eq!(common([0, 0, 4, 4], [4, 0, 2, 2]), None);
    }
}
