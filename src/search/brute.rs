//! A tracer that asks every triangle: no tree, no lists, and no line shared with the reference, so that a mistake which both
//! techniques and reference make can still be seen.
//!
//! It knows hard shadows of whole triangles, opaque and evenly coloured, and says nothing where it is not sure: next to edges,
//! and where a pixel's neighbourhood is not all of one kind.

use glam::{DVec3, DVec4};
use shadowgraph_engine::math::facing_sign;
use shadowgraph_engine::render::FrameRequest;
use shadowgraph_engine::scene::{CameraSnapshot, LightSnapshot, SceneSnapshot};

use shadowgraph_measure::{Evaluation, LightQuery, LightReference};

/// Moves within which a pixel's factor must be the same for it to be sure, in pixels: twice what the reference's band has.
const MOVE_PX: f64 = 1.0 / 128.0;
/// The same along the ray, as a share of the distance: 128 roundings.
const MOVE_IN_DEPTH: f64 = 8e-6;
/// Edges seen closer to a ray than this angle are touched by it.
const TOUCHES: f64 = 1e-11;
/// Points closer to a plane than this share of the scene's size lie in it.
const IN_PLANE: f64 = 1e-9;
/// Factors that differ by less are the same: what half floats lose, doubled.
const SAME: f64 = 2e-3;

/// A triangle in the way of light.
#[derive(Clone, Debug)]
struct Blocker {
    instance: usize,
    corners: [DVec3; 3],
    /// What passes it: nothing for opaque ones.
    passes: DVec3,
    is_opaque: bool,
}

/// What a blocker does to the light on its way to a point.
enum Way {
    Clear,
    Crossed,
    /// Too close to an edge, or to the blocker itself, to say.
    Touched,
}

/// The triangles of a scene's snapshot, one after the other.
#[derive(Clone, Debug)]
pub struct Brute {
    blockers: Vec<Blocker>,
    in_plane_m: f64,
}

/// Where brute force differs, of one light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disagreement {
    /// Pixels at which the reference says something else and calls it certain.
    pub reference: usize,
    /// Pixels at which the picture is wrong and the reference's band excuses it, although nothing near is otherwise.
    pub excused: usize,
}

impl Brute {
    /// The triangles of `snapshot`; `None` where some have holes or a coloured picture, which it does not know.
    pub fn new(snapshot: &SceneSnapshot) -> Option<Self> {
        let mut blockers = Vec::new();
        for (instance, placed) in snapshot.instances.iter().enumerate() {
            for triangle in 0..placed.mesh.triangle_count() {
                let material = placed.material_of(triangle);
                if material.cutoff().is_some() || material.base_color_texture.is_some() {
                    return None;
                }
                if material.unlit {
                    continue;
                }
                let is_opaque = material.is_opaque();
                let color = material.base_color.as_dvec4();
                let passes = if is_opaque { DVec3::ZERO } else { material.transmission_at(color) };
                let corners = placed.world_triangle(triangle);
                blockers.push(Blocker { instance, corners, passes, is_opaque });
            }
        }
        let bounds = snapshot.world_bounds;
        let farthest_m = bounds.min.abs().max(bounds.max.abs()).max_element();
        // Far from the origin, places themselves are rounded.
        let in_plane_m = IN_PLANE * bounds.radius().min(10.0) + farthest_m * 1e-14;
        Some(Self { blockers, in_plane_m })
    }

    /// The factor at `point` on a triangle seen from `eye`; `None` where it is not sure.
    fn factor(
        &self,
        point: DVec3,
        receiver: &[DVec3; 3],
        eye: DVec4,
        light: &LightSnapshot,
        query: &LightQuery,
    ) -> Option<DVec3> {
        let [a, b, c] = *receiver;
        let (to_light, to_eye) = (facing_sign(a, b, c, light.position), facing_sign(a, b, c, eye));
        if to_light == 0 || to_eye == 0 {
            return None;
        }
        if to_light != to_eye {
            return Some(DVec3::ZERO);
        }
        let mut factor = DVec3::ONE;
        let mut is_sure = true;
        for blocker in &self.blockers {
            let casters = if blocker.is_opaque { &query.casters } else { &query.transparent };
            if casters.binary_search(&blocker.instance).is_err() {
                continue;
            }
            match self.way(blocker, point, receiver, light.position) {
                Way::Clear => {}
                Way::Touched => is_sure = false,
                // Darker than dark it does not get, whatever else is touched.
                Way::Crossed if blocker.is_opaque => return Some(DVec3::ZERO),
                Way::Crossed => factor *= blocker.passes,
            }
        }
        is_sure.then_some(factor)
    }

    fn way(&self, blocker: &Blocker, point: DVec3, receiver: &[DVec3; 3], light: DVec4) -> Way {
        let [a, b, c] = blocker.corners;
        let light_side = facing_sign(a, b, c, light);
        if light_side == 0 {
            return Way::Clear;
        }
        let [ra, rb, rc] = *receiver;
        let to_light = light.truncate() - point * light.w;
        let arms = [a - point, b - point, c - point];
        let edge = |i: usize| {
            let (from, to) = (arms[i], arms[(i + 1) % 3]);
            let volume = from.cross(to).dot(to_light);
            let touches = TOUCHES * from.length() * to.length() * to_light.length();
            if volume.abs() <= touches { 0 } else { volume.signum() as i32 }
        };
        let sides = [edge(0), edge(1), edge(2)];
        if sides.contains(&1) && sides.contains(&-1) {
            return Way::Clear;
        }
        // What lies in the receiver's own plane casts nothing on it, nor on points moved a little off it.
        let receiver_normal = (rb - ra).cross(rc - ra).normalize_or_zero();
        let off_receiver = |corner: &DVec3| receiver_normal.dot(*corner - ra).abs() > self.in_plane_m;
        if !blocker.corners.iter().any(off_receiver) {
            return Way::Clear;
        }
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let height_m = normal.dot(point - a);
        if height_m.abs() <= self.in_plane_m {
            return Way::Touched;
        }
        if (height_m > 0.0) == (light_side > 0) {
            return Way::Clear;
        }
        if sides.contains(&0) { Way::Touched } else { Way::Crossed }
    }

    /// How one light of an evaluation fares; `query` says what casts, all of it as if the light had no size.
    pub fn compare(
        &self,
        snapshot: &SceneSnapshot,
        request: &FrameRequest,
        evaluation: &Evaluation,
        (place, query): (usize, &LightQuery),
    ) -> Disagreement {
        let reference = &evaluation.reference.lights[place];
        let light = &snapshot.lights[query.light];
        let Some((_, measured)) = evaluation.measured.lights.iter().find(|(name, _)| *name == reference.name)
        else {
            return Disagreement::default();
        };
        let mut found = Disagreement::default();
        let width = request.size_px[0] as usize;
        for (pixel, id) in evaluation.measured.ids.iter().enumerate() {
            let instance = snapshot.instances.get(id[0] as usize);
            if !reference.compared[pixel] || !instance.is_some_and(|instance| instance.shadow.receives) {
                continue;
            }
            let hit = evaluation.reference.hits[pixel];
            let same = hit.is_some_and(|hit| [hit.instance, hit.triangle] == *id);
            let Some(corners) = instance.map(|i| i.world_triangle(id[1] as usize)).filter(|_| same) else {
                continue;
            };
            let place = [(pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5];
            let pixel_of = |values: &[f32]| channels(values, evaluation.measured.ids.len(), pixel);
            let (drawn, exact) = (pixel_of(measured), pixel_of(&reference.factor));
            let at = |move_px: [f64; 2], in_depth: f64| {
                let place = [place[0] + move_px[0], place[1] + move_px[1]];
                let (point, eye) = on_triangle(&request.camera, request.size_px, place, &corners, in_depth)?;
                self.factor(point, &corners, eye, light, query)
            };
            let Some(center) = at([0.0, 0.0], 0.0) else { continue };
            let differs = |factor: DVec3| (factor - center).abs().max_element() > SAME;
            if !differs(drawn) && !differs(exact) {
                continue;
            }
            if !is_sure(&at, center) {
                continue;
            }
            found.count(reference, pixel, differs(exact), differs(drawn));
        }
        found
    }
}

impl Disagreement {
    fn count(
        &mut self,
        reference: &LightReference,
        pixel: usize,
        reference_differs: bool,
        drawn_differs: bool,
    ) {
        if reference.ambiguous[pixel] {
            self.excused += usize::from(drawn_differs);
        } else {
            self.reference += usize::from(reference_differs);
        }
    }
}

/// Whether everything close to a pixel's point has the factor of the point itself.
fn is_sure(at: &dyn Fn([f64; 2], f64) -> Option<DVec3>, center: DVec3) -> bool {
    let same = |factor: Option<DVec3>| factor.is_some_and(|f| (f - center).abs().max_element() <= SAME);
    let steps = [-MOVE_PX, 0.0, MOVE_PX];
    steps.iter().all(|x| {
        steps.iter().all(|y| [-MOVE_IN_DEPTH, MOVE_IN_DEPTH].iter().all(|depth| same(at([*x, *y], *depth))))
    })
}

fn channels(values: &[f32], pixels: usize, pixel: usize) -> DVec3 {
    match values.len() == pixels {
        true => DVec3::splat(values[pixel].into()),
        false => DVec3::from_array([0, 1, 2].map(|i| values[pixel * 3 + i].into())),
    }
}

/// Where the ray through a place of the picture meets the triangle's plane, moved along it by a share of its length; and the
/// eye.
fn on_triangle(
    camera: &CameraSnapshot,
    size_px: [u32; 2],
    place: [f64; 2],
    corners: &[DVec3; 3],
    in_depth: f64,
) -> Option<(DVec3, DVec4)> {
    let [width, height] = size_px.map(f64::from);
    let (x, y) = (2.0 * place[0] / width - 1.0, 1.0 - 2.0 * place[1] / height);
    let (from, direction) = camera.projection.view_ray(x, y, width / height);
    let from = camera.world_from_view.transform_point3(from);
    let direction = camera.world_from_view.transform_vector3(direction);
    let [a, b, c] = *corners;
    let normal = (b - a).cross(c - a);
    let distance = (a - from).dot(normal) / direction.dot(normal);
    if !(distance.is_finite() && distance > 0.0) {
        return None;
    }
    let eye = match camera.projection {
        shadowgraph_engine::math::Projection::Perspective { .. } => from.extend(1.0),
        shadowgraph_engine::math::Projection::Orthographic { .. } => (-direction).extend(0.0),
    };
    Some((from + direction * (distance * (1.0 + in_depth)), eye))
}
