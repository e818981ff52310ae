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
use shadowgraph::measure::{ErrorTable, Evaluation, Hit, Reference, Samples, evaluate, queries};
use shadowgraph::prelude::*;
use shadowgraph_nodes::SoftShadow;

/// A case of hard shadows, on the planes there are.
fn hard(case: &Case, renderer: &mut Renderer) -> Option<Evaluation> {
    let mut params: Params =
        [("radius", 0.0), ("angle", 0.0)].map(|(n, v)| (n.into(), ParamValue::Number(v))).into();
    if std::env::var("TEXTURE").is_ok() {
        params.insert("mode".into(), ParamValue::Text("texture".into()));
    }
    let scene = case.scene_with(&SoftShadow::ENTRY, &params).unwrap();
    evaluate(renderer, &scene, &case.request(), &|_, _| {})
        .inspect_err(|error| println!("{}: {error}", case.name()))
        .ok()
}

/// Whether a case is about a light with a size.
fn is_soft(case: &Case) -> bool {
    let size = |name: &str| case.options.get(name).is_some_and(|value| *value != ParamValue::Number(0.0));
    size("radius") || size("angle")
}

#[test]
fn without_a_size_shadows_are_exact_on_planes() {
    let Some(mut renderer) = renderer() else { return };
    let filter = std::env::var("CASE").unwrap_or_default();
    let (mut tried, mut failures) = (0, Vec::new());
    for case in cases::all().into_iter().flat_map(|entry| entry.build()) {
        if !case.name().contains(&filter) || is_soft(&case) {
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

/// How far a setting is from the light's exact factor, over the receivers: RMS over penumbra pixels, and over all.
fn soft_error(case: &Case, renderer: &mut Renderer, samples: u32, reference: &[Option<f32>]) -> (f64, f64) {
    let params = [("samples".into(), ParamValue::Number(samples.into()))].into();
    let scene = case.scene_with(&SoftShadow::ENTRY, &params).unwrap();
    let measured = common::measure(renderer, &scene, &case.request()).unwrap();
    let (mut penumbra, mut frame) = ((0.0, 0), (0.0, 0));
    for (right, factor) in reference.iter().zip(&measured.lights[0].1) {
        let Some(right) = right else { continue };
        let squared = f64::from(factor - right).powi(2);
        frame = (frame.0 + squared, frame.1 + 1);
        if *right > 0.0 && *right < 1.0 {
            penumbra = (penumbra.0 + squared, penumbra.1 + 1);
        }
    }
    let rms = |(sum, count): (f64, i32)| (sum / f64::from(count.max(1))).sqrt();
    (rms(penumbra), rms(frame))
}

/// What the light's exact factor is at the receivers' pixels; `None` elsewhere.
fn soft_reference(case: &Case, renderer: &mut Renderer, samples: u32) -> Vec<Option<f32>> {
    let scene = case.scene_with(&SoftShadow::ENTRY, &Params::new()).unwrap();
    let (posed, registry) = renderer.posed(&scene).unwrap();
    let claim = &registry.lights[0][0];
    // Planar shadows take no samples of the disc: what is asked for is the whole light.
    let mut lights = queries(&registry);
    for part in lights.iter_mut().flat_map(|query| &mut query.sized) {
        part.samples = Samples::Converged(samples);
    }
    let image = Reference::new(&posed).render(&case.camera, case.size_px, &lights[..1], &|_, _| {});
    let receives = |hit: &Hit| claim.receivers.contains(&(hit.instance as usize));
    let compared = image.hits.iter().zip(&image.lights[0].compared);
    let factors = compared.zip(&image.lights[0].factor);
    factors.map(|((hit, c), f)| (*c && hit.as_ref().is_some_and(receives)).then_some(*f)).collect()
}

#[test]
fn factors_converge_to_the_lights() {
    let Some(mut renderer) = renderer() else { return };
    let filter = std::env::var("CASE").unwrap_or_default();
    for case in cases::all().into_iter().flat_map(|entry| entry.build()) {
        if !is_soft(&case) || !case.name().contains(&filter) {
            continue;
        }
        let reference = soft_reference(&case, &mut renderer, 1024);
        let errors: Vec<_> =
            [16, 64, 256, 1024].map(|samples| soft_error(&case, &mut renderer, samples, &reference)).into();
        let text: Vec<String> = errors.iter().map(|(p, f)| format!("{p:.4} {f:.4}")).collect();
        println!("{:30} {}", case.name(), text.join("   "));
    }
}
