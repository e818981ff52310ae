//! A wide floor that casts: its rim hangs sides of its own all around the view, right behind lit surfaces seen at
//! grazing angles. They must cancel no other caster's count.

use shadowgraph::demo;
use shadowgraph::measure::evaluate;
use shadowgraph::prelude::*;

/// A speed scene with a floor of 24 m that casts as well.
fn casting(name: &str) -> Scene {
    let (_, _, mut scene) = demo::speed().into_iter().find(|(stem, ..)| *stem == name).unwrap();
    let floor = scene.nodes().find(|(_, node)| node.name == "floor").unwrap().0;
    let Content::Mesh(mesh) = &mut scene.node_mut(floor).unwrap().content else { panic!("a mesh") };
    mesh.shadow.casts = true;
    scene
}

#[test]
fn a_rim_far_away_cancels_nothing() {
    let wrong = judged_around(Antialias::None);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Known issue: with four samples a pixel about one sample of two million is wrong out of band, at the rim. Depths at
/// samples off the pixel's middle are less exact than `BEHIND` in shadow_volume_hard.wgsl allows for; 32 and 64
/// roundings instead of 16 leave one such sample of the three, and widen what is wrong within the band.
#[test]
#[ignore = "a known issue, on the software driver"]
fn known_issue_samples_at_a_rim_far_away() {
    let wrong = judged_around(Antialias::Multisample4);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What is wrong in frames from eyes all around.
fn judged_around(antialias: Antialias) -> Vec<String> {
    let mut wrong = Vec::new();
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return wrong };
    for name in ["knot13k", "boxes1k"] {
        let scene = casting(name);
        for step in 0..6 {
            let (sin, cos) = (f64::from(step) * std::f64::consts::FRAC_PI_3).sin_cos();
            let around = DVec3::new(7.0 * sin, 0.6 + f64::from(step) * 0.7, 7.0 * cos);
            let eye = if step == 0 { DVec3::new(3.2, 3.6, 6.2) } else { around };
            let camera = Camera::perspective("eye", 45_f64.to_radians());
            let camera = CameraSnapshot::looking(camera, eye, DVec3::new(0.0, 0.9, 0.0));
            let request = FrameRequest { antialias, ..FrameRequest::new(camera, [640, 360]) };
            let found = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
            let error = &found.errors[0];
            println!(
                "{name} {antialias:?} eye {step}: wrong {} of {}, out of band {}",
                error.wrong, error.compared, error.wrong_outside_band
            );
            if !error.passes() {
                wrong.push(format!("{name} {antialias:?} eye {step}: {error:?}"));
            }
        }
    }
    wrong
}
