//! The speed scenes: one thing over a floor under one point light, with the triangles where a technique pays for them.
//! They are made like the meshes that other engines were timed on, so that ratios can be put beside each other.

use glam::{DAffine3, DVec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::scene::{Camera, Light, Scene, ShadowNode};
use shadowgraph_measure::cases::strewn::{knot, over_floor, small_box, strewn};

use super::plant::{Habit, potted};
use super::set::Set;

/// Every speed scene: file stem, what it shows, the scene.
pub fn speed() -> Vec<(&'static str, &'static str, Scene)> {
    let knot_eye = [DVec3::new(3.2, 3.6, 6.2), DVec3::new(0.0, 0.9, 0.0)];
    vec![
        (
            "knot13k",
            "a closed torus knot of 13 056 triangles",
            lit(over_floor(vec![(knot([272, 24]), DAffine3::from_translation(DVec3::Y * 1.6))]), knot_eye),
        ),
        (
            "knot63k",
            "the same knot in 62 976 triangles",
            lit(over_floor(vec![(knot([656, 48]), DAffine3::from_translation(DVec3::Y * 1.6))]), knot_eye),
        ),
        (
            "boxes1k",
            "1 024 boxes in one mesh: many silhouettes that overlap",
            lit(
                over_floor(vec![(boxes(1024), DAffine3::IDENTITY)]),
                [DVec3::new(3.6, 4.4, 7.0), DVec3::new(0.0, 0.5, 0.0)],
            ),
        ),
        ("plant", "a potted plant of open leaves, wound either way", plant()),
    ]
}

/// `count` small boxes strewn over and above a square of 4 m, as one mesh.
fn boxes(count: u32) -> MeshData {
    MeshData::merged("boxes", (0..count).map(|i| small_box().moved(strewn(i).as_vec3())))
}

fn plant() -> Scene {
    let mut set = Set { scene: over_floor(vec![]) };
    let group = set.scene.add_group("things");
    let habit = Habit { leaves: 8, length_m: 1.1, width_m: 0.4, height_m: 1.0 };
    potted(&mut set, group, &habit, [0.35, 0.5], [0.0, 0.0]);
    lit(set.scene, [DVec3::new(2.6, 2.6, 5.0), DVec3::new(0.0, 1.0, 0.0)])
}

/// With one lamp, a camera "main" and hard shadows.
fn lit(mut scene: Scene, [eye, target]: [DVec3; 2]) -> Scene {
    scene.add_light(Light::point("lamp", 160.0), DVec3::new(3.0, 6.5, 2.0), DVec3::ZERO);
    finished(scene, [eye, target])
}

/// With a camera "main" of 45° and hard shadows.
fn finished(mut scene: Scene, [eye, target]: [DVec3; 2]) -> Scene {
    scene.add_camera(Camera::perspective("main", 45_f64.to_radians()), eye, target);
    scene.add_shadow("shadows", ShadowNode::new("ShadowVolumeHard"));
    scene
}

#[cfg(test)]
mod tests {
    #[test]
    fn speed_scenes_have_the_triangles_their_names_say() {
        let triangles = |name: &str| {
            let (_, _, scene) =
                super::speed().into_iter().find(|(stem, ..)| *stem == name).expect("it is there");
            let snapshot = scene.snapshot().expect("speed scenes pose");
            assert_eq!((snapshot.lights.len(), snapshot.cameras.len()), (1, 1));
            let casters = snapshot.instances.iter().filter(|instance| instance.shadow.casts);
            casters.map(|instance| instance.mesh.triangle_count()).sum::<usize>()
        };
        assert_eq!(triangles("knot13k"), 13_056);
        assert_eq!(triangles("knot63k"), 62_976);
        assert_eq!(triangles("boxes1k"), 12_288);
        assert!((800..3000).contains(&triangles("plant")));
    }
}
