//! What grows in the scaling part: the scenes of each axis.

use glam::{DAffine3, DVec3};
use shadowgraph_engine::scene::{Camera, CameraSnapshot, Light, Scene};

use super::effort::Effort;
use crate::cases::strewn::{add_instances, knot, over_floor, small_box, strewn};

/// One axis.
pub(super) struct Axis {
    pub(super) parameter: &'static str,
    pub(super) shows: &'static str,
    /// The value, the scene and the size of its frame, smallest first; made when it is its turn.
    pub(super) steps: Vec<AxisScene>,
}

/// One size of one axis.
pub(super) struct AxisScene {
    pub(super) value: f64,
    pub(super) size_px: [u32; 2],
    build: Box<dyn Fn() -> Scene>,
}

impl AxisScene {
    /// The scene with its camera.
    pub(super) fn build(&self) -> (Scene, CameraSnapshot) {
        seen((self.build)())
    }
}

/// A scene with the camera that all of them are seen by.
pub(super) fn seen(scene: Scene) -> (Scene, CameraSnapshot) {
    let camera = Camera::perspective("main", 45_f64.to_radians());
    (scene, CameraSnapshot::looking(camera, EYE[0], EYE[1]))
}

const EYE: [DVec3; 2] = [DVec3::new(3.2, 3.6, 6.2), DVec3::new(0.0, 0.9, 0.0)];
const LAMP: DVec3 = DVec3::new(3.0, 6.5, 2.0);
const RAISED: DVec3 = DVec3::new(0.0, 1.6, 0.0);

pub(super) fn all(effort: &Effort) -> Vec<Axis> {
    let size_px = effort.axis_size_px;
    let counted = |counts: &'static [u32], build: fn(u32) -> Scene| -> Vec<AxisScene> {
        let step = |count: &u32| {
            let count = *count;
            AxisScene { value: f64::from(count), size_px, build: Box::new(move || build(count)) }
        };
        counts.iter().map(step).collect()
    };
    let sized = effort.steps.sizes_px.iter().map(|size_px| AxisScene {
        value: f64::from(size_px[0]) * f64::from(size_px[1]),
        size_px: *size_px,
        build: Box::new(|| triangles(13_000)),
    });
    vec![
        Axis {
            parameter: "triangles",
            shows: "one closed knot over a floor, one lamp",
            steps: counted(effort.steps.triangles, triangles),
        },
        Axis {
            parameter: "lights",
            shows: "one closed knot of 13 000 triangles over a floor, lamps in a ring above",
            steps: counted(effort.steps.lights, lights),
        },
        Axis {
            parameter: "casters",
            shows: "instances of one small box over a floor, one lamp",
            steps: counted(effort.steps.casters, casters),
        },
        Axis {
            parameter: "pixels",
            shows: "one closed knot of 13 000 triangles over a floor, one lamp",
            steps: sized.collect(),
        },
    ]
}

/// A knot of about so many triangles, each about as long as wide.
fn knot_of(triangles: u32) -> Scene {
    let around = (f64::from(triangles) / 2.0 / 11.3).sqrt().round().max(3.0) as u32;
    let along = triangles.div_ceil(2 * around);
    over_floor(vec![(knot([along, around]), DAffine3::from_translation(RAISED))])
}

fn lamp(scene: &mut Scene, name: &str, at: DVec3, candela: f32) {
    scene.add_light(Light::point(name, candela), at, DVec3::ZERO);
}

pub(super) fn triangles(count: u32) -> Scene {
    let mut scene = knot_of(count);
    lamp(&mut scene, "lamp", LAMP, 160.0);
    scene
}

fn lights(count: u32) -> Scene {
    let mut scene = knot_of(13_000);
    for i in 0..count {
        // The golden angle spreads any number of lamps evenly.
        let angle = f64::from(i) * 2.399_963;
        let reach_m = 2.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(count);
        let at = DVec3::new(angle.cos() * reach_m, 6.5, angle.sin() * reach_m);
        lamp(&mut scene, &format!("lamp{i}"), at, 160.0 / count as f32);
    }
    scene
}

pub(super) fn casters(count: u32) -> Scene {
    let mut scene = over_floor(vec![]);
    add_instances(&mut scene, small_box(), (0..count).map(strewn));
    lamp(&mut scene, "lamp", LAMP, 160.0);
    scene
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_size_is_the_one_it_says() {
        for axis in all(&Effort::QUICK) {
            for step in &axis.steps {
                let (scene, _) = step.build();
                let snapshot = scene.snapshot().expect("axis scenes pose");
                let casting = || snapshot.instances.iter().filter(|instance| instance.shadow.casts);
                let found = match axis.parameter {
                    "triangles" => casting().map(|i| i.mesh.triangle_count()).sum::<usize>() as f64,
                    "lights" => snapshot.lights.len() as f64,
                    "casters" => casting().count() as f64,
                    "pixels" => f64::from(step.size_px[0]) * f64::from(step.size_px[1]),
                    other => panic!("a new axis '{other}'"),
                };
                let off = (found / step.value - 1.0).abs();
                assert!(off < if axis.parameter == "triangles" { 0.05 } else { 1e-9 }, "{found}");
            }
        }
    }
}
