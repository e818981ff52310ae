//! Frame time against the number of lights, with hard shadows and without, of any scene. (`shadowgraph report --papers` fits a line
//! through such times, as Fig. 8 of paper 001 does.)
//!
//! `cargo run --example 09_time_against_lights [SCENE.glb]` prints rows of comma-separated values; lights stand in a ring
//! above the scene.
#![allow(clippy::print_stdout, reason = "printing rows is what it is for")]

mod common;

use std::error::Error;
use std::time::Duration;

use shadowgraph::demo;
use shadowgraph::engine::gltf;
use shadowgraph::measure::timing::{Pace, Runner, Spread, take_turns};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [1280, 720];
const PACE: Pace = Pace { min_rounds: 3, max_rounds: 11, budget: Duration::from_secs(3) };
const LIGHTS: [u32; 10] = [1, 2, 3, 4, 6, 8, 12, 16, 32, 64];

fn main() -> Result<(), Box<dyn Error>> {
    let base = match std::env::args().nth(1) {
        Some(path) => gltf::load(path)?.scene,
        None => demo::speed().swap_remove(0).2,
    };
    let base = base.without_shadows();
    println!("lights,unshadowed_ms,shadowed_ms,shadow_ms_per_light,unshadowed_fps,shadowed_fps");
    for count in LIGHTS {
        let lit = demo::under_lamps(&base, count);
        let mut shadowed = lit.clone();
        shadowed.add_shadow("shadows", ShadowVolumeHard::default());
        let mut runners = Vec::new();
        for scene in [lit, shadowed] {
            let snapshot = scene.snapshot()?;
            let camera = snapshot.cameras.first().ok_or("the scene has no camera")?.clone();
            let renderer = common::renderer(shadowgraph_nodes::catalog())?;
            runners.push(Runner { renderer, scene, request: FrameRequest::new(camera, SIZE_PX) });
        }
        let times_ms = take_turns(&mut runners, &PACE)?;
        let [without_ms, with_ms] = [0, 1].map(|index| Spread::of(times_ms[index].clone()).median);
        println!(
            "{count},{without_ms:.2},{with_ms:.2},{:.2},{:.1},{:.1}",
            (with_ms - without_ms) / f64::from(count),
            1e3 / without_ms,
            1e3 / with_ms
        );
    }
    Ok(())
}
