//! `ShadowVolumeSoft` against the reference, sample by sample.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "rows of measurements are what a reader of the log is after")]

mod common;

use shadowgraph::cases::{self, Case};
use shadowgraph::engine::scene::{ParamValue, Params};
use shadowgraph::measure::{Measured, Reference, ReferenceImage, measured, queries};
use shadowgraph::prelude::*;

/// What the half floats that factors are kept in may lose; a sample is sixteen times as much at least.
const LOSS: f32 = 1e-3;

/// The factors of `case` by a soft node with `params`, and the reference's with the same samples; `None` where the node
/// refuses.
fn both(
    renderer: &mut Renderer,
    case: &Case,
    params: &Params,
) -> Result<(Measured, ReferenceImage), RenderError> {
    let scene = case.scene_with(&ShadowVolumeSoft::ENTRY, params).unwrap();
    let request = FrameRequest { factors: true, ..case.request() };
    let frame = renderer.render(&scene, &request, &RenderOptions::default())?;
    let measured = measured(&frame, request.antialias.factor_size_px(request.size_px))?;
    let (posed, registry) = renderer.posed(&scene).unwrap();
    let reference = Reference::new(&posed);
    let image = reference.render(&case.camera, case.size_px, &queries(&registry), &|_, _| {});
    Ok((measured, image))
}

/// Pixels compared, those in a penumbra, those that differ outside the ambiguity band and in it, and the first of them.
#[derive(Clone, Debug, Default, PartialEq)]
struct Found {
    compared: usize,
    penumbra: usize,
    outside: usize,
    inside: usize,
    first: Vec<(usize, usize, [u32; 2], f32, f32)>,
}

fn found(measured: &Measured, reference: &ReferenceImage) -> Found {
    let mut found = Found::default();
    for light in &reference.lights {
        let (_, factor) = measured.lights.iter().find(|(name, _)| *name == light.name).unwrap();
        for pixel in 0..factor.len() {
            let hit = reference.hits[pixel].map(|hit| [hit.instance, hit.triangle]);
            if !light.compared[pixel] || hit != Some(measured.ids[pixel]) {
                continue;
            }
            found.compared += 1;
            let right = light.factor[pixel];
            found.penumbra += usize::from(right > 0.0 && right < 1.0);
            if (factor[pixel] - right).abs() <= LOSS {
                continue;
            }
            if light.ambiguous[pixel] {
                found.inside += 1;
            } else {
                found.outside += 1;
                if found.first.len() < 4 {
                    let width = reference.size_px[0] as usize;
                    found.first.push((
                        pixel % width,
                        pixel / width,
                        measured.ids[pixel],
                        factor[pixel],
                        right,
                    ));
                }
            }
        }
    }
    found
}

fn number(name: &str, value: f64) -> (String, ParamValue) {
    (name.into(), ParamValue::Number(value))
}

/// Every case, with its own size of the light and, where it has none, a small and a large one.
#[test]
fn every_sample_is_judged_as_the_reference_does() {
    let Some(mut renderer) = common::renderer() else { return };
    let filter = std::env::var("CASE").unwrap_or_default();
    let sizes = [(0.1, 0.27), (0.6, 4.0)];
    let mut failures = Vec::new();
    let (mut penumbra, mut accepted) = (0, 0);
    for case in cases::all().into_iter().flat_map(|entry| entry.build()) {
        if !case.name().contains(&filter) {
            continue;
        }
        for (radius_m, angle_deg) in sizes {
            let params = Params::from([number("radius", radius_m), number("angle", angle_deg)]);
            let own = case.options.contains_key("radius") || case.options.contains_key("angle");
            let (measured, reference) = match both(&mut renderer, &case, &params) {
                Ok(both) => both,
                Err(RenderError::Shadow(error)) => {
                    println!("{:<40} refused: {error}", case.name());
                    break;
                }
                Err(RenderError::Frame(error)) => {
                    println!("{:<40} refused: {error}", case.name());
                    break;
                }
                Err(error) => panic!("{}: {error}", case.name()),
            };
            let found = found(&measured, &reference);
            let row = format!("{:<40} {radius_m}: {found:?}", case.name());
            println!("{row}");
            accepted += 1;
            penumbra += found.penumbra;
            if found.outside > 0 {
                failures.push(row);
            }
            if own {
                break;
            }
        }
    }
    println!("{accepted} accepted, {penumbra} penumbra pixels");
    assert!(failures.is_empty(), "{} differ:\n{}", failures.len(), failures.join("\n"));
    assert!(penumbra > 0);
}
