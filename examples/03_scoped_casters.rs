//! Who casts from which light: two shadow nodes, each over one light and one subtree of the scene.
//!
//! The balls block the warm lamp only, the boxes the cool one only, and the pyramids, which neither node names, none.
//! So every shadow shows the colour of the lamp that still reaches it.
//!
//! `cargo run --example 03_scoped_casters` draws `out/03_scoped_casters.png`.

mod common;

use std::error::Error;
use std::sync::Arc;

use shadowgraph::engine::geometry::shapes::Ends;
use shadowgraph::engine::scene::NodeKey;
use shadowgraph::prelude::*;

/// A group of three of the same mesh in a row, at depth `z`.
fn row(
    scene: &mut Scene,
    name: &str,
    shape: MeshData,
    color: Vec3,
    z: f64,
) -> Result<NodeKey, Box<dyn Error>> {
    let group = scene.add_group(name);
    let mesh = scene.add_mesh_data(Arc::new(Mesh::new(shape)?));
    let material = scene.add_material(Material::matt(name, color));
    for i in 0..3 {
        let place = DAffine3::from_translation(DVec3::new(f64::from(i - 1) * 1.9, 0.0, z));
        scene.add(Some(group), name, place, Content::Mesh(MeshNode::new(mesh, material)));
    }
    Ok(group)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let ground = Material::matt("ground", Vec3::splat(0.75));
    scene.add_mesh(Mesh::new(shapes::plane(Vec2::splat(14.0)))?, ground, DAffine3::IDENTITY);
    let ball = shapes::icosphere(0.42, 5).moved(Vec3::Y * 0.42);
    let cube = shapes::cuboid(Vec3::new(-0.36, 0.0, -0.36), Vec3::new(0.36, 0.85, 0.36));
    let pyramid = shapes::cone(0.5, 0.9, 4, Ends::Closed).flat_shaded();
    let balls = row(&mut scene, "balls", ball, Vec3::new(0.8, 0.36, 0.2), 2.0)?;
    let boxes = row(&mut scene, "boxes", cube, Vec3::new(0.25, 0.42, 0.75), 0.0)?;
    row(&mut scene, "pyramids", pyramid, Vec3::splat(0.6), -2.0)?;

    let warm = Light::point("warm", 45.0).with_color(Vec3::new(1.0, 0.6, 0.25));
    let warm = scene.add_lamp(warm, DVec3::new(-4.6, 4.6, 1.5));
    let cool = Light::point("cool", 45.0).with_color(Vec3::new(0.25, 0.5, 1.0));
    let cool = scene.add_lamp(cool, DVec3::new(4.6, 4.6, 1.5));

    // A scope names nodes of the graph and stands for everything under them.
    let hard = || ShadowNode::from(ShadowVolumeHard::default());
    scene.add_shadow("balls from the warm lamp", hard().with_lights([warm]).with_casters([balls]));
    scene.add_shadow("boxes from the cool lamp", hard().with_lights([cool]).with_casters([boxes]));

    let camera = Camera::perspective("eye", 0.5);
    let camera = CameraSnapshot::looking(camera, DVec3::new(0.0, 8.2, 7.6), DVec3::new(0.0, 0.0, 0.1));
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(2.2), "03_scoped_casters")
}
