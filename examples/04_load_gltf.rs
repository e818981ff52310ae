//! A scene from a file: `cargo run --example 04_load_gltf -- SCENE.glb` (assets/room.glb when left out) draws
//! `out/04_load_gltf.png`.
//!
//! The file's own camera, lights and shadow nodes are used where it has them; a plain model is framed, lit by a sun and
//! shadowed, so that any glTF 2.0 file gives a picture.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "it tells what it found in the file")]

mod common;

use std::error::Error;
use std::process::ExitCode;

use shadowgraph::engine::gltf;
use shadowgraph::engine::scene::SceneSnapshot;
use shadowgraph::prelude::*;

const DEFAULT_SCENE: &str = "assets/room.glb";

fn main() -> ExitCode {
    let path = std::env::args().nth(1).unwrap_or_else(|| DEFAULT_SCENE.into());
    match draw(&path) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{path}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn draw(path: &str) -> Result<(), Box<dyn Error>> {
    if !std::path::Path::new(path).exists() {
        return Err("there is no such file (usage: 04_load_gltf SCENE.glb)".into());
    }
    let gltf::Loaded { mut scene, warnings, .. } = gltf::load(path)?;
    warnings.iter().for_each(|warning| println!("left out: {warning}"));

    // Posing flattens the graph into what is visible, shines, and casts.
    let snapshot = scene.snapshot()?;
    let triangles: usize = snapshot.instances.iter().map(|instance| instance.mesh.triangle_count()).sum();
    println!("{path}: {} meshes, {triangles} triangles", snapshot.instances.len());
    for light in &snapshot.lights {
        println!("  light '{}', {:?}", light.name, light.light.kind);
    }
    for node in &snapshot.shadow_nodes {
        let (lights, casters) = (node.lights.len(), node.casters.len());
        println!(
            "  shadow node '{}': {}, {lights} lights, {casters} casters",
            node.name, node.shadow.technique
        );
    }
    if snapshot.lights.is_empty() {
        println!("  no light: a sun is added");
        scene.add_light(Light::directional("sun", 3.0), DVec3::new(2.0, 5.0, 3.0), DVec3::ZERO);
    }
    if snapshot.shadow_nodes.is_empty() {
        println!("  no shadow node: every mesh casts a hard shadow");
        scene.add_shadow("shadows", ShadowVolumeHard::default());
    }

    let main = snapshot.cameras.iter().find(|camera| camera.name == "main").or(snapshot.cameras.first());
    let camera = main.cloned().map_or_else(|| framed(&snapshot), Ok)?;
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &camera, Exposure::Auto, "04_load_gltf")
}

/// A camera that has everything in view, from the front, the right and above.
fn framed(snapshot: &SceneSnapshot) -> Result<CameraSnapshot, Box<dyn Error>> {
    const FOV_Y_RAD: f64 = 0.7;
    if snapshot.world_bounds.is_empty() {
        return Err("the scene has no mesh to look at".into());
    }
    let (center, radius_m) = (snapshot.world_bounds.center(), snapshot.world_bounds.radius());
    // The sphere around everything touches the upper and lower edge of the view.
    let distance_m = radius_m / (FOV_Y_RAD * 0.5).sin();
    let eye = center + DVec3::new(0.5, 0.45, 0.85).normalize() * distance_m;
    let mut camera = Camera::perspective("framed", FOV_Y_RAD);
    // Models come in every unit: the near plane goes with the size, not with the metre.
    let near_m = (distance_m - radius_m).max(distance_m * 1e-2) * 0.5;
    camera.projection = shadowgraph::engine::math::Projection::Perspective { fov_y_rad: FOV_Y_RAD, near_m };
    Ok(CameraSnapshot::looking(camera, eye, center))
}
