//! What moves casts where it is: a skinned, morphing, animated scene at five times, with the error and the frame time of
//! each.
//!
//! `cargo run --example 10_animation [FILE.glb]` prints a row for each time and draws `out/10_animation-<n>.png`; without a
//! file it shows the demo scene "tentacles".
#![allow(clippy::print_stdout, reason = "printing its measurements is what it is for")]

mod common;

use std::error::Error;
use std::time::Instant;

use shadowgraph::engine::gltf;
use shadowgraph::measure::evaluate;
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [640, 360];
const TIMES: u32 = 5;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = match std::env::args_os().nth(1) {
        Some(path) => gltf::load(path)?.scene,
        None => {
            let tentacles = shadowgraph::demo::all().into_iter().find(|(name, ..)| *name == "tentacles");
            tentacles.ok_or("the demo scene is gone")?.2
        }
    };
    let (clip, animation) = scene.animations().next().ok_or("the scene has no animation")?;
    let (name, duration_s) = (animation.name.clone(), animation.duration_s());
    println!("'{name}', {duration_s} s");
    let camera = scene.snapshot()?.cameras.into_iter().next().ok_or("the scene has no camera")?;
    let request = FrameRequest::new(camera.clone(), SIZE_PX);

    // One renderer for all times: what it keeps belongs to the pose it was computed for.
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    println!("{:>8} {:>12} {:>8} {:>12} {:>10}", "time", "compared", "wrong", "out of band", "frame");
    for step in 0..TIMES {
        let seconds = duration_s * f64::from(step) / f64::from(TIMES);
        scene.animate(clip, seconds)?;
        // The first frame of a pose bends the meshes and finds the silhouettes anew.
        let start = Instant::now();
        renderer.render(&scene, &request, &RenderOptions::default())?;
        let frame_ms = start.elapsed().as_secs_f64() * 1e3;
        let evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {})?;
        let sum = |of: fn(&shadowgraph::measure::LightError) -> usize| {
            evaluation.errors.iter().map(of).sum::<usize>()
        };
        println!(
            "{seconds:>6.2} s {:>12} {:>8} {:>12} {frame_ms:>7.1} ms",
            sum(|error| error.compared),
            sum(|error| error.wrong),
            sum(|error| error.wrong_outside_band),
        );
        common::picture(&mut renderer, &scene, &camera, Exposure::Auto, &format!("10_animation-{step}"))?;
    }
    Ok(())
}
