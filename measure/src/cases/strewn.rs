//! What stands over a floor where things are counted: knots, strewn boxes, instances. The report's axes and the speed scenes
//! are made of it.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::{cuboid, plane, torus_knot};
use shadowgraph_engine::geometry::{Mesh, MeshData};
use shadowgraph_engine::scene::{Content, Material, MeshNode, NodeKey, Scene, placed};

/// A (2, 3) torus knot about as large as a person.
pub fn knot(segments: [u32; 2]) -> MeshData {
    torus_knot([2, 3], 0.8, 0.2, segments).named("knot")
}

/// One of many boxes, about its own middle.
pub fn small_box() -> MeshData {
    cuboid(Vec3::splat(-0.05), Vec3::splat(0.05)).named("box")
}

/// Where the box of this number is.
pub fn strewn(i: u32) -> DVec3 {
    let n = |salt: u32| f64::from(noise(i.wrapping_mul(3) + salt));
    DVec3::new(n(0) * 4.0 - 2.0, 0.08 + n(1) * 1.6, n(2) * 4.0 - 2.0)
}

/// Meshes over a light-grey floor of 24 m that casts nothing.
///
/// Invalid data here is a mistake in a scene's own code, so it ends the program with the reason.
pub fn over_floor(things: Vec<(MeshData, DAffine3)>) -> Scene {
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
pub fn add_instances(scene: &mut Scene, data: MeshData, places: impl Iterator<Item = DVec3>) {
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

/// A number in 0 … 1 that looks random and is the same on every machine.
pub fn noise(seed: u32) -> f32 {
    let mut x = seed.wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
    x = (x ^ (x >> 15)).wrapping_mul(0x2C1B_3C6D);
    x = (x ^ (x >> 12)).wrapping_mul(0x297A_2D39);
    ((x ^ (x >> 15)) >> 8) as f32 / (1 << 24) as f32
}
