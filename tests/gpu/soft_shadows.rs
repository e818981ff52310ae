//! `ShadowVolumeSoft`, quality `sampled`, against the reference, sample by sample: every hard case with a small light and
//! with one that is large beside the casters, solids as solids and as soups, and other numbers of samples.

use std::collections::BTreeMap;

use crate::known::{COMPARED_ONE_CASE_IN, KNOWN_ON_CASES, TOLERATED};
use crate::tolerances::SOFT;
use crate::trials::tries_everything;

use shadowgraph::cases::{self, Case};
use shadowgraph::measure::{EvaluateError, evaluate};
use shadowgraph::prelude::*;

/// What one node gives on the cases whose name contains `filter`.
fn judge(
    renderer: &mut Renderer,
    filter: &str,
    node: ShadowVolumeSoft,
    failures: &mut Vec<String>,
) -> (usize, usize) {
    let params = ShadowNode::from(node).params;
    let only = std::env::var("CASE").unwrap_or_default();
    let (mut penumbra, mut accepted) = (0, 0);
    // Of the cases on which pixels are tolerated, how many are outside their bounds.
    let mut outside: BTreeMap<&str, usize> = BTreeMap::new();
    let cases = cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST));
    let named = |case: &Case| case.name().contains(filter) && case.name().contains(&only);
    // The conformance test has every case with the default size; of all of them, every third is enough here. `CASE=` or
    // `EVERY_CASE=1` tries all.
    let is_thinned = filter.is_empty() && !tries_everything();
    for case in cases.filter(named).step_by(if is_thinned { COMPARED_ONE_CASE_IN } else { 1 }) {
        let scene = case.scene_with(&ShadowVolumeSoft::ENTRY, &params).unwrap();
        let row = format!("{:<40} radius {}", case.name(), node.radius_m);
        match evaluate(renderer, &scene, &case.request(), &|_, _| {}) {
            Ok(evaluation) => {
                accepted += 1;
                for error in &evaluation.errors {
                    penumbra += error.penumbra_pixels;
                    println!(
                        "{row} {}: {} penumbra pixels, {} wrong samples",
                        error.name, error.penumbra_pixels, error.wrong
                    );
                    if tolerated(&case) > 0 {
                        *outside.entry(case.id).or_default() += error.outside_bounds;
                    }
                    // How wide the band of a light may be that no case was made for, is nobody's fault.
                    let right = error.wrong_outside_band == 0
                        && error.outside_bounds <= tolerated(&case)
                        && (error.compared > 0 || error.hit_pixels == 0);
                    let known =
                        KNOWN_ON_CASES.iter().any(|known| known.is_about(SOFT, "default", &case.name()));
                    if !right && !known {
                        failures.push(format!("{row}: {error:?}"));
                    }
                }
            }
            Err(EvaluateError::Render(RenderError::Shadow(_) | RenderError::Frame(_))) => {}
            Err(error) => failures.push(format!("{row}: {error}")),
        }
    }
    let right = outside.iter().filter(|(_, pixels)| **pixels == 0);
    failures
        .extend(right.map(|(case, _)| format!("{case} is right now: strike it out of what is tolerated")));
    (accepted, penumbra)
}

/// Pixels that may be outside their bounds.
fn tolerated(case: &Case) -> usize {
    TOLERATED.iter().find(|tolerated| tolerated.case == case.id).map_or(0, |tolerated| tolerated.pixels)
}

fn check(filter: &str, nodes: &[ShadowVolumeSoft]) {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut failures = Vec::new();
    for node in nodes {
        let (accepted, penumbra) = judge(&mut renderer, filter, *node, &mut failures);
        println!("{node:?}: {accepted} cases, {penumbra} penumbra pixels");
        assert!(
            std::env::var_os("CASE").is_some() || (accepted > 0 && penumbra > 0),
            "{node:?} was not tried"
        );
    }
    assert!(failures.is_empty(), "{} fail:\n{}", failures.len(), failures.join("\n"));
}

fn sized(radius_m: f64, angle_deg: f64) -> ShadowVolumeSoft {
    ShadowVolumeSoft { radius_m, angle_deg, ..ShadowVolumeSoft::default() }
}

/// Conformance tries the default size: here is a light larger than many casters.
#[test]
fn large_lights_are_judged_sample_by_sample() {
    check("", &[sized(0.6, 4.0)]);
}

#[test]
fn solids_are_soups_too() {
    let open = ShadowVolumeSoft { geometry: GeometryMode::Open, ..sized(0.3, 1.0) };
    for filter in ["light-", "nested-shells", "overlap-256", "tripod", "mirrored"] {
        check(filter, &[open]);
    }
}

#[test]
fn any_number_of_samples_is_taken() {
    let of = |samples: u32| ShadowVolumeSoft { samples, ..sized(0.3, 1.0) };
    check("penumbra-overlap", &[of(16), of(31), of(33), of(65), of(96), of(127), of(256)]);
}
