//! Sweeps: one thing of a scene goes from harmless to extreme, and nothing may be wrong on the way.
//!
//! Every step is judged by the exact reference: 0 wrong pixels outside the ambiguity band, the band no wider than it
//! may be, and a shadow to get wrong. Each step prints a row.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "rows of measurements are what a reader of the log is after")]

mod common;

use shadowgraph::cases::sweeps::{self, Sweep};
use shadowgraph::measure::{evaluate, expect_shadow};
use shadowgraph::prelude::*;

/// Known: a lamp nearer to a caster than about 10⁻⁵ of its size, but not touching it. Seen from there an edge of one
/// metre spans all but some roundings of a half circle, and extruded directions, f32 in view space, lose what is left
/// of it. The cure would be to split such edges before they are extruded.
const ALMOST_TOUCHING_M: std::ops::RangeInclusive<f64> = 1e-8..=1.1e-5;

fn is_known(sweep: &Sweep, value: f64) -> bool {
    sweep.id.starts_with("light-near-") && ALMOST_TOUCHING_M.contains(&value)
}

/// Judges the default options and, where they choose z-pass, z-fail to infinity too.
fn judge(renderer: &mut Renderer, sweep: &Sweep) -> Vec<String> {
    let mut failures = Vec::new();
    let infinite = ShadowVolumeHard {
        depth_test: DepthTest::ZFail,
        extrusion: Extrusion::Infinite,
        ..ShadowVolumeHard::default()
    };
    for (value, case) in sweep.steps() {
        for (word, node) in [("auto", ShadowVolumeHard::default()), ("zfail", infinite)] {
            let node = ShadowNode::from(node);
            let scene = case.scene_with(&ShadowVolumeHard::ENTRY, &node.params).unwrap();
            let request = FrameRequest::new(case.camera.clone(), case.size_px);
            let row = format!("{} {word}", case.name());
            let errors = match evaluate(renderer, &scene, &request, &|_, _| {}) {
                Ok(evaluation) => evaluation.errors,
                Err(error) => {
                    failures.push(format!("{row}: {error}"));
                    continue;
                }
            };
            let error = &errors[0];
            println!(
                "{row:<36} wrong {:>2}  out of band {}  band {:>4} of boundary {:>4}  shadow {:>5} of {:>5}  \
                 other triangle {}",
                error.wrong,
                error.wrong_outside_band,
                error.band_pixels,
                error.boundary_pixels,
                error.shadow_pixels,
                error.compared,
                error.different_triangle,
            );
            let lit = error.shadow_pixels < error.compared;
            let wrong = !error.passes() || !lit || expect_shadow(&errors).is_err();
            if wrong && is_known(sweep, value) {
                println!("{row}: known to be wrong");
            } else if wrong {
                failures.push(format!("{row}: {error:?}"));
            }
        }
    }
    failures
}

#[test]
fn every_sweep_is_right_at_every_step() {
    let Some(mut renderer) = common::renderer() else { return };
    let filter = std::env::var("CASE").unwrap_or_default();
    let sweeps: Vec<Sweep> = sweeps::all().into_iter().filter(|sweep| sweep.id.contains(&filter)).collect();
    assert!(!sweeps.is_empty(), "no sweep is called '{filter}'");
    let failures: Vec<_> = sweeps.iter().flat_map(|sweep| judge(&mut renderer, sweep)).collect();
    assert!(failures.is_empty(), "{} fail:\n{}", failures.len(), failures.join("\n"));
}
