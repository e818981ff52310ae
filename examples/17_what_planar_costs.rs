//! What `SoftShadow` costs: whole frames with direct shadows, with kept textures while nothing moves, and with a textured
//! rectangle in their place.
//!
//! `cargo run --example 17_what_planar_costs` prints medians of rounds in which every row draws one frame, and what each
//! adds to a frame without shadows in the same round, which is what to read.
#![allow(clippy::print_stdout, reason = "printing rows is what it is for")]

mod common;

use std::error::Error;
use std::sync::Arc;
use std::time::Duration;

use shadowgraph::engine::scene::{AlphaMode, Image, TextureRef};
use shadowgraph::measure::timing::{Pace, Runner, Spread, take_turns};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [1280, 720];
const PACE: Pace = Pace { min_rounds: 15, max_rounds: 51, budget: Duration::from_secs(15) };
/// Half the floor's side, in metres, and the texels along a whole one.
const FLOOR_HALF_M: f32 = 4.0;
const TEXELS: u32 = 1024;

fn main() -> Result<(), Box<dyn Error>> {
    let soft = |mode, samples| SoftShadow { mode, samples, resolution: TEXELS, ..SoftShadow::default() };
    let rows = [
        ("no shadows", None),
        ("a textured rectangle", None),
        ("texture, 16 points, nothing moves", Some(soft(PlanarMode::Texture, 16))),
        ("texture, 256 points, nothing moves", Some(soft(PlanarMode::Texture, 256))),
        ("direct, 16 points", Some(soft(PlanarMode::Direct, 16))),
        ("direct, 64 points", Some(soft(PlanarMode::Direct, 64))),
    ];
    let mut runners = Vec::new();
    for (name, node) in &rows {
        let mut scene = knot_over_floor(*node)?;
        if name.contains("rectangle") {
            add_rectangle(&mut scene)?;
        }
        let camera = scene.snapshot()?.cameras.first().ok_or("a scene has no camera")?.clone();
        let renderer = common::renderer(shadowgraph_nodes::catalog())?;
        runners.push(Runner { renderer, scene, request: FrameRequest::new(camera, SIZE_PX) });
    }
    let times_ms = take_turns(&mut runners, &PACE)?;
    let adapter = runners[0].renderer.gpu().name();
    println!("{}x{}, {adapter}, {} rounds", SIZE_PX[0], SIZE_PX[1], times_ms[0].len());
    println!("{:<36} {:>9} {:>9} {:>15}", "", "median ms", "adds ms", "quartiles");
    for ((name, _), times) in rows.iter().zip(&times_ms) {
        let adds = Spread::of(times.iter().zip(&times_ms[0]).map(|(own, without)| own - without).collect());
        let quartiles = format!("{:.2} to {:.2}", adds.lower, adds.upper);
        println!("{name:<36} {:>9.2} {:>9.2} {quartiles:>15}", Spread::of(times.clone()).median, adds.median);
    }
    Ok(())
}

fn knot_over_floor(node: Option<SoftShadow>) -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new();
    let floor = shapes::plane(Vec2::splat(FLOOR_HALF_M)).named("floor");
    let floor =
        scene.add_mesh(Mesh::new(floor)?, Material::matt("floor", Vec3::splat(0.7)), DAffine3::IDENTITY);
    let knot = shapes::torus_knot([2, 3], 0.8, 0.2, [271, 24]).moved(Vec3::Y * 1.3).named("knot");
    let knot = scene.add_mesh(
        Mesh::new(knot)?,
        Material::matt("knot", Vec3::new(0.8, 0.4, 0.2)),
        DAffine3::IDENTITY,
    );
    scene.add_lamp(Light::point("lamp", 160.0), DVec3::new(3.0, 6.5, 2.0));
    let camera = Camera::perspective("main", 45.0_f64.to_radians());
    scene.add_camera(camera, DVec3::new(3.2, 3.6, 6.2), DVec3::new(0.0, 0.9, 0.0));
    if let Some(node) = node {
        scene.add_shadow("shadows", ShadowNode::from(node).with_casters([knot]).with_receivers([floor]));
    }
    Ok(scene)
}

/// A rectangle where the floor's texture would be, with as many texels.
fn add_rectangle(scene: &mut Scene) -> Result<(), Box<dyn Error>> {
    let spots = (0..TEXELS * TEXELS).flat_map(|i| [0, 0, 0, ((i / 64 + i / TEXELS / 64) % 2 * 128) as u8]);
    let spots = Image { name: "spots".into(), width: TEXELS, height: TEXELS, rgba8: spots.collect() };
    let image = scene.add_image(Arc::new(spots));
    let material = Material {
        base_color_texture: Some(TextureRef::new(image)),
        alpha_mode: AlphaMode::Blend,
        unlit: true,
        ..Material::default()
    };
    let quad = shapes::plane(Vec2::splat(FLOOR_HALF_M)).moved(Vec3::Y * 0.001).named("rectangle");
    scene.add_mesh(Mesh::new(quad)?, material, DAffine3::IDENTITY);
    Ok(())
}
