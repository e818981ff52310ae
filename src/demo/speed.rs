//! The speed scenes: one thing over a floor under one point light, with the triangles where a technique pays for them.
//! They are made like the meshes that other engines were timed on, so that ratios can be put beside each other.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::{cuboid, plane, torus_knot};
use shadowgraph_engine::geometry::{Mesh, MeshData};
use shadowgraph_engine::scene::{
    Camera, Content, Light, Material, MeshNode, NodeKey, Scene, ShadowNode, placed,
};

use super::plant::{Habit, potted};
use super::set::{Set, noise};

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

/// A (2, 3) torus knot about as large as a person.
pub(crate) fn knot(segments: [u32; 2]) -> MeshData {
    torus_knot([2, 3], 0.8, 0.2, segments).named("knot")
}

/// `count` small boxes strewn over and above a square of 4 m, as one mesh.
fn boxes(count: u32) -> MeshData {
    MeshData::merged("boxes", (0..count).map(|i| small_box().moved(strewn(i).as_vec3())))
}

/// One of many boxes, about its own middle.
pub(crate) fn small_box() -> MeshData {
    cuboid(Vec3::splat(-0.05), Vec3::splat(0.05)).named("box")
}

/// Where the box of this number is.
pub(crate) fn strewn(i: u32) -> DVec3 {
    let n = |salt: u32| f64::from(noise(i.wrapping_mul(3) + salt));
    DVec3::new(n(0) * 4.0 - 2.0, 0.08 + n(1) * 1.6, n(2) * 4.0 - 2.0)
}

fn plant() -> Scene {
    let mut set = Set { scene: over_floor(vec![]) };
    let group = set.scene.add_group("things");
    let habit = Habit { leaves: 8, length_m: 1.1, width_m: 0.4, height_m: 1.0 };
    potted(&mut set, group, &habit, [0.35, 0.5], [0.0, 0.0]);
    lit(set.scene, [DVec3::new(2.6, 2.6, 5.0), DVec3::new(0.0, 1.0, 0.0)])
}

/// Meshes over a light-grey floor of 24 m that casts nothing.
///
/// Invalid data here is a mistake in a scene's own code, so it ends the program with the reason.
pub(crate) fn over_floor(things: Vec<(MeshData, DAffine3)>) -> Scene {
    let mut scene = Scene::new();
    let valid = |data| Mesh::new(data).unwrap_or_else(|error| panic!("a speed scene: {error}"));
    let floor = valid(plane(Vec2::splat(12.0)).named("floor"));
    let floor = scene.add_mesh(floor, Material::matt("floor", Vec3::splat(0.7)), DAffine3::IDENTITY);
    receive_only(&mut scene, floor);
    let clay = Material::matt("clay", Vec3::new(0.6, 0.42, 0.3));
    for (data, place) in things {
        scene.add_mesh(valid(data), clay.clone(), place);
    }
    scene
}

/// The same mesh in many places.
pub(crate) fn add_instances(scene: &mut Scene, data: MeshData, places: impl Iterator<Item = DVec3>) {
    let name = data.name.clone();
    let mesh = Mesh::new(data).unwrap_or_else(|error| panic!("a speed scene: {error}"));
    let mesh = scene.add_mesh_data(Arc::new(mesh));
    let clay = scene.add_material(Material::matt("clay", Vec3::new(0.6, 0.42, 0.3)));
    for (i, place) in places.enumerate() {
        let turn = DQuat::from_rotation_y(i as f64 * 0.7);
        let content = Content::Mesh(MeshNode::new(mesh, clay));
        scene.add(None, &name, placed(place, turn, DVec3::ONE), content);
    }
}

fn receive_only(scene: &mut Scene, node: NodeKey) {
    if let Some(node) = scene.node_mut(node)
        && let Content::Mesh(content) = &mut node.content
    {
        content.shadow.casts = false;
    }
}

/// With one lamp, a camera "main" and hard shadows.
fn lit(mut scene: Scene, [eye, target]: [DVec3; 2]) -> Scene {
    scene.add_light(Light::point("lamp", 160.0), DVec3::new(3.0, 6.5, 2.0), DVec3::ZERO);
    finished(scene, [eye, target])
}

/// With a camera "main" of 45° and hard shadows.
pub(crate) fn finished(mut scene: Scene, [eye, target]: [DVec3; 2]) -> Scene {
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
            let posed = scene.pose().expect("speed scenes pose");
            assert_eq!((posed.lights.len(), posed.cameras.len()), (1, 1));
            let casters = posed.instances.iter().filter(|instance| instance.shadow.casts);
            casters.map(|instance| instance.mesh.triangle_count()).sum::<usize>()
        };
        assert_eq!(triangles("knot13k"), 13_056);
        assert_eq!(triangles("knot63k"), 62_976);
        assert_eq!(triangles("boxes1k"), 12_288);
        assert!((800..3000).contains(&triangles("plant")));
    }
}
