//! A technique of one's own beside the built-in ones: a mobile of discs whose shadows `DiscShadow` computes, on wires
//! whose shadows `ShadowVolumeHard` counts, under the same two lights. See `own_technique/` for the technique.
//!
//! `cargo run --example 06_own_technique` draws `out/06_own_technique.png`.
#![allow(clippy::print_stdout, reason = "it tells how the lights were planned")]

mod common;
mod own_technique;

use std::error::Error;
use std::sync::Arc;

use own_technique::{DiscShadow, disc_mesh};
use shadowgraph::engine::geometry::shapes::Ends;
use shadowgraph::engine::scene::{MeshKey, NodeKey, placed};
use shadowgraph::prelude::*;

const RED: Vec3 = Vec3::new(0.72, 0.06, 0.03);
const YELLOW: Vec3 = Vec3::new(0.9, 0.6, 0.05);
const BLUE: Vec3 = Vec3::new(0.05, 0.16, 0.5);
const BLACK: Vec3 = Vec3::splat(0.03);
/// Where each disc hangs, how large it is, how it is turned about x and z, and its colour.
const DISCS: [([f64; 3], f64, [f64; 2], Vec3); 7] = [
    ([-1.75, 1.75, 0.35], 0.5, [0.75, 0.35], RED),
    ([-0.75, 1.35, -0.3], 0.34, [0.5, -0.3], BLACK),
    ([-0.2, 2.05, 0.5], 0.22, [0.9, 0.3], YELLOW),
    ([0.55, 1.5, 0.0], 0.4, [0.9, -0.35], BLUE),
    ([1.25, 1.9, -0.4], 0.27, [0.6, 0.5], RED),
    ([1.75, 1.3, 0.4], 0.33, [0.5, 0.3], YELLOW),
    ([2.35, 1.75, 0.0], 0.18, [1.0, -0.3], BLACK),
];
const TOP: DVec3 = DVec3::new(0.25, 3.2, 0.0);

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let wall = Material::matt("wall", Vec3::splat(0.8));
    let floor = Mesh::new(shapes::plane(Vec2::splat(8.0)).named("floor"))?;
    scene.add_mesh(floor, wall.clone(), DAffine3::IDENTITY);
    let back = shapes::cuboid(Vec3::new(-8.0, 0.0, -2.3), Vec3::new(8.0, 6.0, -2.0));
    scene.add_mesh(Mesh::new(back.named("wall"))?, wall, DAffine3::IDENTITY);

    // The mobile: one disc mesh at seven places, each on a wire from the top.
    let discs = scene.add_group("discs");
    let wires = scene.add_group("wires");
    let disc = scene.add_mesh_data(Arc::new(Mesh::new(disc_mesh("disc", 1.0, 256))?));
    let wire = shapes::cylinder(1.0, 1.0, 12, Ends::Closed).named("wire");
    let wire = scene.add_mesh_data(Arc::new(Mesh::new(wire)?));
    for (at, radius_m, [around_x, around_z], color) in DISCS {
        let at = DVec3::from(at);
        let turn = DQuat::from_rotation_z(around_z) * DQuat::from_rotation_x(around_x);
        add(&mut scene, discs, disc, color, placed(at, turn, DVec3::splat(radius_m)));
        let along = TOP - at;
        let turn = DQuat::from_rotation_arc(DVec3::Y, along.normalize());
        add(&mut scene, wires, wire, BLACK, placed(at, turn, DVec3::new(0.009, along.length(), 0.009)));
    }

    let lamp = Light::point("lamp", 60.0).with_color(Vec3::new(1.0, 0.84, 0.62));
    let lamp = scene.add_lamp(lamp, DVec3::new(-2.4, 3.0, 4.6));
    let sky = Light::directional("sky", 0.9).with_color(Vec3::new(0.5, 0.7, 1.0));
    let sky = scene.add_light(sky, DVec3::new(3.0, 2.6, 4.6), DVec3::ZERO);

    // On each light both techniques: what one leaves of it, the other multiplies. The sky's discs get a smooth rim.
    let hard = ShadowNode::from(ShadowVolumeHard::default()).with_casters([wires]);
    scene.add_shadow("wires", hard);
    let of_discs = |node: DiscShadow| ShadowNode::from(node).with_casters([discs]);
    scene.add_shadow("discs", of_discs(DiscShadow { edge_m: 0.0 }).with_lights([lamp]));
    scene.add_shadow("discs, smooth", of_discs(DiscShadow { edge_m: 0.12 }).with_lights([sky]));

    let camera = Camera::perspective("eye", 0.6);
    let camera = CameraSnapshot::looking(camera, DVec3::new(0.5, 2.1, 7.2), DVec3::new(0.3, 1.45, 0.0));
    let mut renderer = common::renderer(own_technique::catalog())?;
    let plan = renderer.plan(&scene, &FrameRequest::new(camera.clone(), common::SIZE_PX))?;
    for light in &plan.lights {
        println!("{}: {} -> {:?}", light.name, light.techniques.join(" and "), light.factor);
    }
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(1.8), "06_own_technique")
}

fn add(scene: &mut Scene, group: NodeKey, mesh: MeshKey, color: Vec3, place: DAffine3) {
    let material = scene.add_material(Material { roughness: 0.5, ..Material::matt("paint", color) });
    scene.add(Some(group), "part of the mobile", place, Content::Mesh(MeshNode::new(mesh, material)));
}
