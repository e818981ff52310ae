//! Table 1 of Kim, Kim & Turk, again: whole frames with opaque casters and with transparent ones, on casters of as many
//! triangles as theirs.
//!
//! `cargo run --example 15_what_glass_costs [WORD]` (only scenes with that word in their name) prints medians of rounds in
//! which every row draws one frame, and each row's ratio to opaque casters, which is what to read; theirs stands beside it.
#![allow(clippy::print_stdout, reason = "printing rows is what it is for")]

mod common;

use std::error::Error;
use std::time::Duration;

use shadowgraph::engine::scene::AlphaMode;
use shadowgraph::measure::timing::{Pace, Runner, Spread, take_turns};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [1280, 720];
const PACE: Pace = Pace { min_rounds: 9, max_rounds: 101, budget: Duration::from_secs(30) };

/// A row: its name, whether casters are of glass, and the shadow node if there is one.
type Row = (&'static str, bool, Option<ShadowNode>);

fn main() -> Result<(), Box<dyn Error>> {
    let glass =
        |accumulate, self_shadow| Some(ShadowNode::from(TransparentShadow { accumulate, self_shadow }));
    let rows: [Row; 9] = [
        ("opaque, no shadows", false, None),
        ("opaque, ShadowVolumeHard", false, Some(ShadowVolumeHard::default().into())),
        ("glass, no shadows", true, None),
        ("glass, counts", true, glass(Accumulate::Counts, SelfShadow::None)),
        ("glass, gridLog", true, glass(Accumulate::GridLog, SelfShadow::None)),
        ("glass, log16", true, glass(Accumulate::Log16, SelfShadow::None)),
        ("glass, product16", true, glass(Accumulate::Product16, SelfShadow::None)),
        ("glass, counts, partial", true, glass(Accumulate::Counts, SelfShadow::Partial)),
        ("glass, counts, full", true, glass(Accumulate::Counts, SelfShadow::Full)),
    ];
    // What theirs took with transparent casters, and with partial shadows on these, as multiples of opaque ones.
    for (name, casters, theirs) in [
        ("ball and cubes", ball_and_cubes(), [1.37, 2.44]),
        ("text", letters(), [1.96, 3.45]),
        ("jellyfish", jellyfish(), [1.41, 2.35]),
        ("knot", knot(), [1.91, 3.21]),
    ] {
        if std::env::args().nth(1).is_none_or(|word| name.contains(&word)) {
            table(name, &casters, theirs, &rows)?;
        }
    }
    Ok(())
}

/// A ball over a field of cubes: 1 116 triangles.
fn ball_and_cubes() -> Vec<MeshData> {
    let cube = |i: i32| {
        let (x, z) = ((i % 6) as f32 * 0.6 - 1.5, (i / 6) as f32 * 0.6 - 1.5);
        shapes::cuboid(Vec3::new(x - 0.15, 0.1, z - 0.15), Vec3::new(x + 0.15, 0.4, z + 0.15))
    };
    let cubes = MeshData::merged("cubes", (0..33).map(cube));
    vec![shapes::uv_sphere(0.7, 24, 16).moved(Vec3::Y * 1.6).named("ball"), cubes]
}

/// Rows of rings and bars, much as extruded letters are: about 13 600 triangles.
fn letters() -> Vec<MeshData> {
    let ring = |i: i32| {
        let (x, y) = ((i % 7) as f32 * 0.5 - 1.5, 0.5 + (i / 7) as f32 * 0.5);
        shapes::torus(0.16, 0.05, 32, 10).moved(Vec3::new(x, y, 0.0))
    };
    let bar = |i: i32| {
        let (x, y) = ((i % 7) as f32 * 0.5 - 1.25, 0.5 + (i / 7) as f32 * 0.5);
        shapes::cuboid(Vec3::new(x - 0.03, y - 0.2, -0.05), Vec3::new(x + 0.03, y + 0.2, 0.05))
    };
    let line = |name: &str, i: i32| {
        let (rings, bars) = ((i * 7..i * 7 + 7).map(ring), (i * 7..i * 7 + 7).map(bar));
        MeshData::merged(name, rings.chain(bars))
    };
    vec![line("first line", 0), line("second line", 1), line("third line", 2)]
}

/// Open bells over many thin arms: about 27 700 triangles.
fn jellyfish() -> Vec<MeshData> {
    let bell = |radius: f32| {
        let rim = |t: f32| {
            let angle = t * std::f32::consts::FRAC_PI_2;
            Vec2::new(angle.sin() * radius, 1.6 + angle.cos() * radius * 0.7)
        };
        shapes::lathe(&(0..=24).map(|i| rim(i as f32 / 24.0)).collect::<Vec<_>>(), 96)
    };
    let arm = |i: u32| {
        let turn = i as f32 / 24.0 * std::f32::consts::TAU;
        let at = |s: f32, t: f32| {
            let (wave, around) = ((s * 9.0 + turn * 3.0).sin() * 0.12, t * std::f32::consts::TAU);
            let r = 0.5 + wave + around.cos() * 0.025;
            Vec3::new(turn.cos() * r, 1.55 - s * 1.3, turn.sin() * r + around.sin() * 0.025)
        };
        shapes::sheet(64, 6, at)
    };
    let arms = MeshData::merged("arms", (0..24).map(arm));
    vec![bell(0.8).named("bell"), bell(0.55).named("inner bell"), arms]
}

/// A torus knot of 62 976 triangles.
fn knot() -> Vec<MeshData> {
    vec![shapes::torus_knot([2, 3], 0.8, 0.2, [656, 48]).moved(Vec3::Y * 1.3).named("knot")]
}

/// The casters over a floor under a lamp, opaque or of glass, with a shadow node over them all.
fn scene(casters: &[MeshData], glass: bool, node: Option<ShadowNode>) -> Result<Scene, Box<dyn Error>> {
    let mut scene = Scene::new();
    let floor = shapes::plane(Vec2::splat(12.0)).named("floor");
    scene.add_mesh(Mesh::new(floor)?, Material::matt("floor", Vec3::splat(0.7)), DAffine3::IDENTITY);
    let tints = [Vec3::new(0.9, 0.35, 0.25), Vec3::new(0.3, 0.6, 0.95), Vec3::new(0.5, 0.85, 0.4)];
    let mut keys = Vec::new();
    for (data, tint) in casters.iter().zip(tints) {
        let mut material = Material::matt("tint", tint);
        if glass {
            material.alpha_mode = AlphaMode::Blend;
            material.base_color.w = 0.3;
        }
        keys.push(scene.add_mesh(Mesh::new(data.clone())?, material, DAffine3::IDENTITY));
    }
    scene.add_lamp(Light::point("lamp", 160.0), DVec3::new(3.0, 6.5, 2.0));
    let camera = Camera::perspective("main", 45.0_f64.to_radians());
    scene.add_camera(camera, DVec3::new(3.2, 3.6, 6.2), DVec3::new(0.0, 0.9, 0.0));
    if let Some(node) = node {
        scene.add_shadow("shadows", node.with_casters(keys));
    }
    Ok(scene)
}

fn table(name: &str, casters: &[MeshData], theirs: [f64; 2], rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let mut runners = Vec::new();
    let mut timed = Vec::new();
    for (row, glass, node) in rows {
        let scene = scene(casters, *glass, node.clone())?;
        let camera = scene.snapshot()?.cameras.first().ok_or("a scene has no camera")?.clone();
        let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
        let request = FrameRequest::new(camera, SIZE_PX);
        // A refusal is an answer.
        if let Err(refusal) = renderer.plan(&scene, &request) {
            println!("{row}: {refusal}");
            continue;
        }
        timed.push(*row);
        runners.push(Runner { renderer, scene, request });
    }
    let times_ms = take_turns(&mut runners, &PACE)?;
    let triangles: usize = casters.iter().map(|data| data.indices.len() / 3).sum();
    let adapter = runners[0].renderer.gpu().name();
    println!("{name}, {triangles} triangles ({adapter}, {} rounds)", times_ms[0].len());
    println!("  {:<26} {:>9} {:>9} {:>10} {:>10}", "", "median ms", "least ms", "of opaque", "bytes");
    for (index, (row, runner)) in timed.iter().zip(&mut runners).enumerate() {
        let spread = Spread::of(times_ms[index].clone());
        let mut ratios: Vec<f64> =
            times_ms[index].iter().zip(&times_ms[1]).map(|(own, opaque)| own / opaque).collect();
        ratios.sort_by(f64::total_cmp);
        let plan = runner.renderer.plan(&runner.scene, &runner.request)?;
        let ratio = ratios[ratios.len() / 2];
        println!("  {row:<26} {:>9.2} {:>9.2} {ratio:>10.2} {:>10}", spread.median, spread.min, plan.bytes());
    }
    let [plain, partial] = theirs;
    println!("  (Kim, Kim & Turk: {plain:.2} of opaque, with partial self-shadowing {partial:.2})");
    Ok(())
}
