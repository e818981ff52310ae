//! `SoftShadow`: planar shadows.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

mod common;

use common::renderer;
use shadowgraph::cases::{self, Case};
use shadowgraph::engine::scene::{ParamValue, Params};
use shadowgraph::measure::{ErrorTable, Evaluation, evaluate};
use shadowgraph::prelude::*;
use shadowgraph_nodes::SoftShadow;

/// Every case of hard shadows, on the planes there are.
fn hard(case: &Case, renderer: &mut Renderer) -> Option<Evaluation> {
    let params: Params =
        [("radius", 0.0), ("angle", 0.0)].map(|(n, v)| (n.into(), ParamValue::Number(v))).into();
    let scene = case.scene_with(&SoftShadow::ENTRY, &params).unwrap();
    evaluate(renderer, &scene, &case.request(), &|_, _| {})
        .inspect_err(|error| println!("{}: {error}", case.name()))
        .ok()
}

#[test]
fn without_a_size_shadows_are_exact_on_planes() {
    let Some(mut renderer) = renderer() else { return };
    let filter = std::env::var("CASE").unwrap_or_default();
    let (mut tried, mut failures) = (0, Vec::new());
    for case in cases::all().into_iter().flat_map(|entry| entry.build()) {
        if !case.name().contains(&filter) {
            continue;
        }
        let Some(Evaluation { errors, frame, .. }) = hard(&case, &mut renderer) else { continue };
        tried += 1;
        if !filter.is_empty() {
            println!("{}\n{}", frame.plan, ErrorTable(&errors));
        }
        for error in errors.iter().filter(|error| !error.passes()) {
            failures.push(format!("{}\n{}", case.name(), ErrorTable(std::slice::from_ref(error))));
        }
    }
    println!("{tried} cases");
    assert!(failures.is_empty(), "{} fail:\n{}", failures.len(), failures.join("\n"));
}
