//! Reading the plan: what a frame will do and why, as plain data, before any GPU is touched; and what changes when
//! the eye moves into the shadow.
//!
//! `cargo run --example 05_read_the_plan` prints one plan, and how the other differs; no adapter is needed.
#![allow(clippy::print_stdout, reason = "printing the plan is what it is for")]

use std::error::Error;

use shadowgraph::engine::plan::FramePlan;
use shadowgraph::engine::render::{Adapter, plan_frame};
use shadowgraph::engine::shadow::{Cache, Registry};
use shadowgraph::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let floor = Mesh::new(shapes::plane(Vec2::splat(10.0)).named("floor"))?;
    scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
    let tower = shapes::cuboid(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 2.0, 0.5));
    let tower = scene.add_mesh(Mesh::new(tower.named("tower"))?, Material::default(), DAffine3::IDENTITY);
    let ball = shapes::icosphere(0.5, 4).named("ball");
    let place = DAffine3::from_translation(DVec3::new(2.5, 0.5, 1.0));
    let ball = scene.add_mesh(Mesh::new(ball)?, Material::default(), place);
    scene.add_light(Light::directional("sun", 3.0), DVec3::new(-3.0, 4.0, 0.0), DVec3::ZERO);
    let node = ShadowNode::from(ShadowVolumeHard::default());
    scene.add_shadow("shadows", node.with_casters([tower, ball]));

    let in_the_sun = plan(&scene, DVec3::new(3.0, 3.0, 7.0))?;
    println!("The eye in the sun:\n\n{in_the_sun}");
    // A step behind the tower, below its shadow's upper edge. A view ray now begins inside the volume, so that counting
    // from the eye would miss one crossing: the tower is counted from infinity, which takes caps.
    let in_the_shadow = plan(&scene, DVec3::new(1.2, 0.4, 0.0))?;
    println!("The eye in the tower's shadow; '-' is gone, '+' is new:\n");
    print_difference(&in_the_sun.to_string(), &in_the_shadow.to_string());

    // The plan is data: what text shows, code can ask.
    for (place, plan) in [("in the sun", &in_the_sun), ("in the shadow", &in_the_shadow)] {
        let volumes = plan.passes_named("volumes of").flat_map(|pass| &pass.draws);
        let vertices: u64 = volumes.map(|draw| draw.vertices()).sum();
        println!("{place}: {vertices} vertices of shadow volumes, {} bytes on the GPU", plan.bytes());
    }
    Ok(())
}

/// The plan of a frame seen from `eye`, for an adapter that is only imagined.
fn plan(scene: &Scene, eye: DVec3) -> Result<FramePlan, Box<dyn Error>> {
    let snapshot = scene.snapshot()?;
    let registry = Registry::collect(&snapshot, &shadowgraph_nodes::catalog())?;
    let camera = CameraSnapshot::looking(Camera::perspective("eye", 0.8), eye, DVec3::new(2.5, 0.5, 1.0));
    let request = FrameRequest::new(camera, [1280, 720]);
    Ok(plan_frame(&snapshot, &registry, &request, &Adapter::imagined(), &Cache::new())?)
}

/// The lines that only one of two texts has, in their order.
fn print_difference(before: &str, after: &str) {
    for line in before.lines().filter(|line| !after.lines().any(|other| other == *line)) {
        println!("- {line}");
    }
    for line in after.lines().filter(|line| !before.lines().any(|other| other == *line)) {
        println!("+ {line}");
    }
    println!();
}
