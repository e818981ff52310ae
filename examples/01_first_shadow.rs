//! The first shadow: a scene in code, one lamp, one shadow node.
//!
//! `cargo run --example 01_first_shadow` draws `out/01_first_shadow.png`.

mod common;

use std::error::Error;

use shadowgraph::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();

    // Things: each is a shape, a material and a place.
    let plaster = Material::matt("plaster", Vec3::new(0.72, 0.68, 0.62));
    let brick = Material::matt("brick", Vec3::new(0.62, 0.2, 0.12));
    let leaf = Material::matt("leaf", Vec3::new(0.2, 0.36, 0.16));
    let floor = Mesh::new(shapes::plane(Vec2::splat(40.0)))?;
    let knot = Mesh::new(shapes::torus_knot([2, 3], 0.62, 0.17, [320, 24]))?;
    let stand = Mesh::new(shapes::cuboid(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 0.7, 0.5)))?;
    let ball = Mesh::new(shapes::icosphere(0.4, 5))?;
    scene.add_mesh(floor, plaster.clone(), DAffine3::IDENTITY);
    scene.add_mesh(stand, plaster, DAffine3::from_rotation_y(0.5));
    scene.add_mesh(knot, brick, DAffine3::from_translation(DVec3::new(0.0, 1.75, 0.0)));
    scene.add_mesh(ball, leaf, DAffine3::from_translation(DVec3::new(-1.5, 0.4, 1.0)));

    // Light, and the node that makes it cast shadows: over all lights and all meshes, unless it is told otherwise.
    let lamp = Light::point("lamp", 60.0).with_color(Vec3::new(1.0, 0.88, 0.72));
    scene.add_lamp(lamp, DVec3::new(-3.4, 4.2, 2.6));
    scene.add_shadow("shadows", ShadowVolumeHard::default());

    let camera = Camera::perspective("eye", 0.62);
    let camera = CameraSnapshot::looking(camera, DVec3::new(1.6, 3.0, 6.6), DVec3::new(0.35, 0.85, 0.0));
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(1.6), "01_first_shadow")
}
