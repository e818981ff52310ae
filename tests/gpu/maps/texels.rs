//! How wrong maps are, in texels: whether next to a wrong pixel, within so many texels of its map, brute force finds what was
//! drawn.

use bytemuck::{cast_slice, pod_read_unaligned};
use glam::DMat4;
use shadowgraph::engine::plan::FramePlan;
use shadowgraph::engine::scene::{CameraSnapshot, SceneSnapshot};
use shadowgraph::measure::{EvaluateError, KnownReferences, evaluate_again};
use shadowgraph::prelude::*;
use shadowgraph_nodes::common::shadow_maps::{MapViewRecord, ShadowMapsRecord};

/// What was found of one light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct InTexels {
    /// Pixels that were compared, and those of them in shadow.
    pub(crate) compared: usize,
    pub(crate) in_shadow: usize,
    /// Pixels off by more than half, lit and dark.
    pub(crate) leaks: usize,
    pub(crate) dark: usize,
    /// Those of them next to which nothing is as drawn.
    pub(crate) far_leaks: usize,
    pub(crate) acne: usize,
}

/// A view of a map: from view space to texels and depth, and back.
struct MapView {
    map_from_view: DMat4,
    view_from_map: DMat4,
    texels: f64,
}

fn views(plan: &FramePlan, light: &str) -> Vec<MapView> {
    let (bytes, _) = shadowgraph_testing::buffer(plan, &format!("map views of {light}"));
    let (head, views) = bytes.split_at(size_of::<ShadowMapsRecord>());
    let head: ShadowMapsRecord = pod_read_unaligned(head);
    let views: Vec<MapViewRecord> = bytemuck::pod_collect_to_vec(views);
    let view = |view: &MapViewRecord| {
        let rows = [view.texel_x, view.texel_y, view.depth, view.w];
        let rows: Vec<f64> = cast_slice::<_, f32>(&rows).iter().map(|n| f64::from(*n)).collect();
        let map_from_view = DMat4::from_cols_slice(&rows).transpose();
        MapView { map_from_view, view_from_map: map_from_view.inverse(), texels: f64::from(head.texels) }
    };
    views.iter().filter(|view| view.layer != u32::MAX).map(view).collect()
}

/// Renders and judges the only light of `scene`: pixels off by more than half, and whether brute force finds what they show
/// within `texels` of their place in the map. Pixels beyond the map's view are asked too.
///
/// # Errors
/// What the renderer refuses.
pub(crate) fn judge(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &CameraSnapshot,
    size_px: [u32; 2],
    texels: f64,
    references: &mut KnownReferences,
) -> Result<InTexels, EvaluateError> {
    let request = FrameRequest::new(camera.clone(), size_px);
    let evaluation = evaluate_again(renderer, scene, &request, references, &|_, _| {})?;
    let snapshot = scene.snapshot().unwrap();
    let views = views(&evaluation.frame.plan, &snapshot.lights[0].name);
    let reference = &evaluation.reference.lights[0];
    let drawn = &evaluation.measured.lights[0].1;
    let mut found = InTexels::default();
    for (pixel, hit) in evaluation.reference.hits.iter().enumerate() {
        let Some(hit) = hit.filter(|_| reference.compared[pixel]) else { continue };
        if [hit.instance, hit.triangle] != evaluation.measured.ids[pixel] {
            continue;
        }
        found.compared += 1;
        let (drawn, exact) = (f64::from(drawn[pixel]), f64::from(reference.factor[pixel]));
        found.in_shadow += usize::from(exact == 0.0);
        if (drawn - exact).abs() <= 0.5 {
            continue;
        }
        let corners = snapshot.instances[hit.instance as usize].world_triangle(hit.triangle as usize);
        let point = seen_point(camera, size_px, pixel, corners);
        let is_near = near(&snapshot, camera, &views, point, corners, texels, drawn > 0.5);
        found.leaks += usize::from(drawn > 0.5);
        found.dark += usize::from(drawn <= 0.5);
        found.far_leaks += usize::from(drawn > 0.5 && !is_near);
        found.acne += usize::from(drawn <= 0.5 && !is_near);
    }
    Ok(found)
}

/// Where the eye sees the plane of a triangle in the middle of a pixel.
fn seen_point(camera: &CameraSnapshot, size_px: [u32; 2], pixel: usize, corners: [DVec3; 3]) -> DVec3 {
    let [width, height] = size_px.map(f64::from);
    let (x, y) = (pixel % size_px[0] as usize, pixel / size_px[0] as usize);
    let ndc = [(x as f64 + 0.5) / width * 2.0 - 1.0, 1.0 - (y as f64 + 0.5) / height * 2.0];
    let (origin, direction) = camera.projection.view_ray(ndc[0], ndc[1], width / height);
    let origin = camera.world_from_view.transform_point3(origin);
    let direction = camera.world_from_view.transform_vector3(direction);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    origin + direction * (normal.dot(corners[0] - origin) / normal.dot(direction))
}

/// Whether somewhere within so many texels of a point, on its plane, the light is as `lit` says.
fn near(
    snapshot: &SceneSnapshot,
    camera: &CameraSnapshot,
    views: &[MapView],
    point: DVec3,
    corners: [DVec3; 3],
    texels: f64,
    lit: bool,
) -> bool {
    let in_view = camera.world_from_view.inverse().transform_point3(point);
    let seen = views.iter().filter_map(|view| {
        let map = view.map_from_view * in_view.extend(1.0);
        let at = map / map.w;
        let inside = map.w > 0.0 && at.x.min(at.y) > 0.0 && at.x.max(at.y) < view.texels;
        inside.then_some((view, at))
    });
    seen.into_iter().any(|(view, at)| {
        let steps = 8;
        (0..=steps).any(|row| {
            (0..=steps).any(|column| {
                let off = |step: i32| (f64::from(step) / f64::from(steps) * 2.0 - 1.0) * texels;
                let ray = [0.25, 0.75].map(|depth| {
                    let p = view.view_from_map
                        * glam::DVec4::new(at.x + off(column), at.y + off(row), depth, 1.0);
                    camera.world_from_view.transform_point3(p.truncate() / p.w)
                });
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                let direction = ray[1] - ray[0];
                let share = normal.dot(corners[0] - ray[0]) / normal.dot(direction);
                is_lit(snapshot, ray[0] + direction * share, normal) == lit
            })
        })
    })
}

/// Whether nothing lies strictly between a point and the light, nor is the point's plane turned away.
fn is_lit(snapshot: &SceneSnapshot, point: DVec3, normal: DVec3) -> bool {
    let light = snapshot.lights[0].position;
    let to_light = light.truncate() - point * light.w;
    let blocks = |[a, b, c]: [DVec3; 3]| {
        let own = (b - a).cross(c - a);
        let t = own.dot(a - point) / own.dot(to_light);
        let off = own.normalize_or_zero().dot(a - point).abs();
        if !(t > 0.0 && (light.w == 0.0 || t < 1.0)) || off < 1e-7 {
            return false;
        }
        let crossing = point + to_light * t;
        let side = |a: DVec3, b: DVec3| own.dot((b - a).cross(crossing - a));
        let sides = [side(a, b), side(b, c), side(c, a)];
        // What lies in the receiver's own plane casts nothing on it.
        let unit = normal.normalize();
        let in_plane = [a, b, c].iter().all(|corner| unit.dot(*corner - point).abs() < 1e-6);
        !in_plane && sides.iter().all(|side| *side >= 0.0)
    };
    let mut triangles =
        snapshot.instances.iter().filter(|instance| instance.shadow.casts).flat_map(|instance| {
            (0..instance.mesh.triangle_count()).map(|triangle| instance.world_triangle(triangle))
        });
    !triangles.any(blocks)
}

/// For each view of a light's maps and each of its axes the size of its texels in metres (of a direction), and at which of them a
/// point of the world is.
pub(crate) fn places(
    plan: &FramePlan,
    light: &str,
    camera: &CameraSnapshot,
    point: DVec3,
) -> Vec<(usize, f64, f64)> {
    let in_view = camera.world_from_view.inverse().transform_point3(point);
    let place = |view: MapView| {
        let at = view.map_from_view * in_view.extend(1.0);
        [0, 1].map(|axis| (axis, 1.0 / view.map_from_view.row(axis).truncate().length(), at[axis]))
    };
    views(plan, light).into_iter().flat_map(place).collect()
}
