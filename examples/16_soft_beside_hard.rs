//! Soft shadows beside hard ones: figure 12 of Lindrud & Löfgren 2004, made again, with what each costs and how wrong it is.
//!
//! The furnished room four times: hard shadows, the penumbra wedges of their time, areas over the silhouette that each
//! point sees, and 64 samples of every light. Their soft room took 15 times as long as their hard one (4 frames a second
//! to 60).
//!
//! `cargo run --example 16_soft_beside_hard` draws `out/16_soft_beside_hard.png` (hard, wedge; perReceiver, sampled) and
//! prints medians of rounds in which each draws one frame, their ratios to hard, and the error in the penumbrae against
//! the whole light, which is no error of hard shadows: of that light they know the centre only.
#![allow(clippy::print_stdout, reason = "printing rows is what it is for")]

mod common;

use std::error::Error;
use std::time::Duration;

use image::{RgbaImage, imageops};
use shadowgraph::engine::scene::Node;
use shadowgraph::measure::timing::{Pace, Runner, Spread, take_turns};
use shadowgraph::measure::{Converged, KnownReferences, LightError, evaluate_again, evaluate_converged};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [640, 360];
/// Where factors are compared: each pixel with so many samples of five lights.
const JUDGED_PX: [u32; 2] = [160, 90];
const PACE: Pace = Pace { min_rounds: 3, max_rounds: 9, budget: Duration::from_secs(20) };

/// The room with soft shadows of this quality; `None` leaves the hard ones.
fn room(quality: Option<Quality>) -> Result<Scene, Box<dyn Error>> {
    let demos = shadowgraph::demo::all();
    let (_, _, mut scene) = demos.into_iter().find(|(stem, ..)| *stem == "room").ok_or("there is no room")?;
    let Some(quality) = quality else { return Ok(scene) };
    let shadow = |node: &Node| match node.content {
        Content::Shadow(key) => Some((key, node.name.clone())),
        _ => None,
    };
    let names: Vec<_> = scene.nodes().filter_map(|(_, node)| shadow(node)).collect();
    for (key, name) in names {
        // A window's worth of sky, and bulbs; the sun is as wide as it is.
        let radius_m = if name == "daylight" { 0.3 } else { 0.05 };
        let soft = ShadowVolumeSoft { quality, radius_m, ..ShadowVolumeSoft::default() };
        let node = scene.shadow_mut(key).ok_or("a shadow node has no content")?;
        let soft = ShadowNode::from(soft);
        (node.technique, node.params) = (soft.technique, soft.params);
    }
    Ok(scene)
}

/// The picture.
fn picture(runner: &mut Runner) -> Result<RgbaImage, Box<dyn Error>> {
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    let frame = runner.renderer.render(&runner.scene, &runner.request, &options)?;
    let bytes = frame.picture.ok_or("the frame has no picture")?.bytes;
    let [width, height] = SIZE_PX;
    Ok(RgbaImage::from_raw(width, height, bytes).ok_or("the picture is cut short")?)
}

/// The error in the penumbrae, over all lights, against the whole light.
fn penumbra_rmse(runner: &mut Runner) -> Result<f64, Box<dyn Error>> {
    let Runner { renderer, scene, request } = runner;
    let request = FrameRequest { size_px: JUDGED_PX, ..request.clone() };
    let mut references = KnownReferences::default();
    let evaluation = evaluate_again(renderer, scene, &request, &mut references, &|_, _| {})?;
    let converged: Option<Converged> =
        evaluate_converged(renderer, scene, &request, &evaluation, &mut references, &|_, _| {})?;
    let errors: &[LightError] = converged.as_ref().map_or(&evaluation.errors, |converged| &converged.errors);
    let (mut sum, mut pixels) = (0.0, 0);
    for error in errors {
        sum += error.penumbra_rmse.powi(2) * error.penumbra_pixels as f64;
        pixels += error.penumbra_pixels;
    }
    Ok((sum / pixels.max(1) as f64).sqrt())
}

fn main() -> Result<(), Box<dyn Error>> {
    let rows = [
        ("hard", None),
        ("soft, wedge", Some(Quality::Wedge)),
        ("soft, perReceiver", Some(Quality::PerReceiver)),
        ("soft, sampled (64)", Some(Quality::Sampled)),
    ];
    let mut runners = Vec::new();
    for (_, quality) in rows {
        let scene = room(quality)?;
        let snapshot = scene.snapshot()?;
        let camera =
            snapshot.cameras.iter().find(|camera| camera.name == "main").ok_or("the room has no camera")?;
        let request = FrameRequest::new(camera.clone(), SIZE_PX);
        runners.push(Runner { renderer: common::renderer(shadowgraph_nodes::catalog())?, scene, request });
    }
    let [width, height] = SIZE_PX;
    let mut all = RgbaImage::new(width * 2, height * 2);
    for (place, runner) in runners.iter_mut().enumerate() {
        let (column, row) = (place as u32 % 2, place as u32 / 2);
        let (x, y) = (column * width, row * height);
        imageops::replace(&mut all, &picture(runner)?, x.into(), y.into());
    }
    let path = common::out_dir()?.join("16_soft_beside_hard.png");
    all.save(&path)?;
    common::told(&runners[0].renderer, &path);

    let times_ms = take_turns(&mut runners, &PACE)?;
    println!("the room, five lights, {width}x{height}, {} rounds", times_ms[0].len());
    println!(
        "  {:<20} {:>9} {:>17} {:>8} {:>14}",
        "", "median ms", "half of them", "of hard", "penumbra rmse"
    );
    for ((row, _), (own, runner)) in rows.iter().zip(times_ms.iter().zip(&mut runners)) {
        let spread = Spread::of(own.clone());
        let mut ratios: Vec<f64> = own.iter().zip(&times_ms[0]).map(|(own, hard)| own / hard).collect();
        ratios.sort_by(f64::total_cmp);
        let half = format!("{:.1} to {:.1}", spread.lower, spread.upper);
        let error = match *row {
            "hard" => String::new(),
            _ => format!("{:.4}", penumbra_rmse(runner)?),
        };
        let ratio = ratios[ratios.len() / 2];
        println!("  {row:<20} {:>9.1} {half:>17} {ratio:>8.2} {error:>14}", spread.median);
    }
    println!("  (Lindrud & Löfgren: 250 ms soft, 17 ms hard: 15)");
    Ok(())
}
