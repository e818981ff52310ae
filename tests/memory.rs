//! A frame like the one before takes no more memory, in this process nor in the driver.
//!
//! A driver that compiles a shader anew for every draw, because uniforms alone decide a branch in it, and keeps what it
//! compiled, takes megabytes a frame: see `common/frame.wgsl`.

#![cfg(target_os = "linux")]
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

use std::sync::{Mutex, PoisonError};

use shadowgraph::cases::{self, Case};
use shadowgraph::demo;
use shadowgraph::engine::render::{Adapter, Planner};
use shadowgraph::measure::ReferenceShadow;
use shadowgraph::prelude::*;

/// Frames before memory is looked at, in which pipelines are made and stores fill; frames of a round, and rounds.
const WARM_UP: u64 = 6;
const FRAMES: u64 = 6;
const ROUNDS: u64 = 3;

/// What a frame may add: pages the allocator takes for the first time. A compiled shader has a megabyte and more.
const ALLOWED_KB_A_FRAME: u64 = 200;

fn resident_kb() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches("kB").trim().parse().unwrap()
}

/// Held by a test while it looks at what the process has, or takes of it.
static ALONE: Mutex<()> = Mutex::new(());

#[test]
fn a_frame_like_the_one_before_is_planned_without_allocating() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    for (name, _, mut scene) in demo::all() {
        let camera = scene.snapshot().unwrap().cameras[0].clone();
        let mut planner = Planner::new(shadowgraph_nodes::catalog());
        let (adapter, mut request) = (Adapter::imagined(), FrameRequest::new(camera, [320, 180]));
        let first = planner.plan(&scene, &request, &adapter).unwrap();
        let mut again = None;
        let asked = allocation_counter::measure(|| again = planner.plan(&scene, &request, &adapter).ok());
        assert!(asked.count_total == 0 && again.as_ref() == Some(&first), "{name}: {asked:?}");
        // Whatever changes is planned anew: the request, the adapter, the scene.
        request.size_px = [321, 180];
        let wider = planner.plan(&scene, &request, &adapter).unwrap();
        assert_eq!(wider.size_px, [321, 180], "{name}");
        let small = Adapter { max_size_px: 64, ..Adapter::imagined() };
        assert!(planner.plan(&scene, &request, &small).is_err(), "{name}");
        scene.add_lamp(Light::point("another", 1.0), DVec3::Y);
        let lamps = planner.plan(&scene, &request, &adapter).unwrap().lights.len();
        assert_eq!(lamps, wider.lights.len() + 1, "{name}");
    }
}

/// Scenes that differ in the shaders they need: one light, several; holes; panes; samples.
const CASES: [&str; 5] =
    ["light-in-near-plane/", "alpha-mask/face-of-box", "lights-4", "panes-intersecting", "msaa/odd"];

#[test]
fn a_frame_like_the_one_before_takes_no_more_memory() {
    let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let Some(renderer) = shadowgraph_testing::renderer() else { return };
    let mut catalog = shadowgraph_nodes::catalog();
    catalog.register(ReferenceShadow::ENTRY);
    let entries = catalog.entries().to_vec();
    let mut renderer = Renderer::new(renderer.gpu().clone(), catalog);
    let cases: Vec<Case> =
        cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST)).collect();
    let mut growing = Vec::new();
    for name in CASES {
        let case = cases.iter().find(|case| case.name().starts_with(name));
        let case = case.unwrap_or_else(|| panic!("no case is called '{name}'"));
        for entry in &entries {
            let setting = entry.all_settings().next().unwrap();
            let scene = case.scene_with(entry, &(setting.params)()).unwrap();
            for factors in [false, true] {
                let request = FrameRequest { factors, ..case.request() };
                let mut frames = |count: u64| -> Result<(), RenderError> {
                    (0..count).try_for_each(|_| {
                        renderer.render(&scene, &request, &RenderOptions::default()).map(|_| ())
                    })
                };
                // What a technique refuses is for other tests.
                if frames(WARM_UP).is_err() {
                    continue;
                }
                // The allocator takes pages for good now and then; what grows, grows every time.
                let grown = (0..ROUNDS).map(|_| {
                    let before = resident_kb();
                    frames(FRAMES).unwrap();
                    resident_kb().saturating_sub(before) / FRAMES
                });
                let kb = grown.min().unwrap();
                println!("{} by {}, factors {factors}: {kb} KB a frame", case.name(), entry.type_name);
                if kb > ALLOWED_KB_A_FRAME {
                    growing.push(format!("{} by {}: {kb} KB a frame", case.name(), entry.type_name));
                }
            }
        }
    }
    assert!(growing.is_empty(), "memory grows:\n{}", growing.join("\n"));
}
