//! Shadows on named planes: a floor, a wall and a tilted board receive, each with crisp contacts and soft edges; and
//! the fill light's shadow is tinted, and drawn once into textures that the receivers wear.
//!
//! The table's own legs and the ball are no receivers, so no shadow falls on them: `SoftShadow` flattens casters onto
//! planes, and asks for their names. Its plan says which passes a second frame does not run.
//!
//! `cargo run --example 12_planar` draws `out/12_planar.png`.

#![allow(clippy::print_stdout, reason = "an example tells what it finds")]

mod common;

use std::error::Error;

use shadowgraph::engine::geometry::shapes::Ends;
use shadowgraph::engine::scene::NodeKey;
use shadowgraph::prelude::*;

/// A square plane of half side `half_m` whose front looks along `normal`.
fn board(
    scene: &mut Scene,
    (name, half_m, color): (&str, Vec2, Vec3),
    center: DVec3,
    normal: DVec3,
) -> Result<NodeKey, Box<dyn Error>> {
    let turn = DQuat::from_rotation_arc(DVec3::Y, normal.normalize());
    let place = DAffine3::from_rotation_translation(turn, center);
    Ok(scene.add_mesh(Mesh::new(shapes::plane(half_m))?, Material::matt(name, color), place))
}

/// A table: a top on four legs.
fn table(scene: &mut Scene) -> Result<(), Box<dyn Error>> {
    let wood = || Material::matt("wood", Vec3::new(0.55, 0.36, 0.2));
    let top = shapes::cuboid(Vec3::new(-0.9, 0.82, -0.5), Vec3::new(0.9, 0.88, 0.5));
    scene.add_mesh(Mesh::new(top)?, wood(), DAffine3::IDENTITY);
    for (x, z) in [(-0.8, -0.4), (0.8, -0.4), (-0.8, 0.4), (0.8, 0.4)] {
        let leg = shapes::cylinder(0.04, 0.82, 24, Ends::Closed).moved(Vec3::new(x, 0.0, z));
        scene.add_mesh(Mesh::new(leg)?, wood(), DAffine3::IDENTITY);
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let light_grey = Vec3::splat(0.72);
    let floor = board(&mut scene, ("floor", Vec2::splat(4.0), light_grey), DVec3::ZERO, DVec3::Y)?;
    let wall = DVec3::new(0.0, 2.0, -2.2);
    let wall = board(&mut scene, ("wall", Vec2::new(4.0, 2.0), Vec3::new(0.68, 0.7, 0.66)), wall, DVec3::Z)?;
    let tilted = DVec3::new(1.75, 0.45, 0.3);
    let tilted =
        board(&mut scene, ("board", Vec2::new(0.5, 0.65), light_grey), tilted, DVec3::new(-0.9, 1.0, 0.25))?;
    table(&mut scene)?;
    let ball = shapes::icosphere(0.26, 5).moved(Vec3::new(0.35, 1.14, 0.0));
    let ball = Mesh::new(ball)?;
    scene.add_mesh(ball, Material::matt("ball", Vec3::new(0.75, 0.2, 0.15)), DAffine3::IDENTITY);

    let lamp = Light::point("lamp", 90.0).with_color(Vec3::new(1.0, 0.9, 0.75));
    let lamp = scene.add_lamp(lamp, DVec3::new(-1.7, 3.4, 1.9));
    let sky = Light::directional("sky", 1.4).with_color(Vec3::new(0.75, 0.85, 1.0));
    let sky = scene.add_light(sky, DVec3::ZERO, DVec3::new(-0.6, -1.0, -0.45));

    let receivers = [floor, wall, tilted];
    let soft = SoftShadow { samples: 64, radius_m: 0.25, ..SoftShadow::DIRECT };
    scene.add_shadow("the lamp's", ShadowNode::from(soft).with_lights([lamp]).with_receivers(receivers));
    let worn = SoftShadow {
        samples: 64,
        angle_deg: 2.5,
        weight: 0.9,
        color: [0.1, 0.15, 0.6],
        ..SoftShadow::default()
    };
    scene.add_shadow("the sky's", ShadowNode::from(worn).with_lights([sky]).with_receivers(receivers));

    let camera = Camera::perspective("eye", 0.62);
    let camera = CameraSnapshot::looking(camera, DVec3::new(1.1, 2.3, 6.0), DVec3::new(0.1, 0.75, -0.4));
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(0.45), "12_planar")?;
    // Nothing has moved since: what was drawn into textures is there.
    let request = FrameRequest::new(camera, common::SIZE_PX);
    let frame = renderer.render(&scene, &request, &RenderOptions::default())?;
    println!(
        "passes: {}, of which not run, since nothing moved: {}",
        frame.plan.passes.len(),
        frame.kept.len()
    );
    Ok(())
}
