//! Nothing sparkles: while a light or a caster moves in small steps, no pixel's factor changes by more than the right one
//! does and a hundredth.

use crate::soft_areas::stage::{Lamp, Stage, block};
use glam::{DVec3, Vec3};
use shadowgraph::engine::scene::ParamValue;
use shadowgraph::measure::evaluate;
use shadowgraph::prelude::*;

/// What may be left over of a change, after the right one is taken away.
const JUMP: f64 = 0.01;
/// The same of samples: they are seen one by one, several at once where an edge passes a row of them. 0.5/√samples, what
/// they may be off as a whole.
const SAMPLES_JUMP: f64 = 0.5 / 16.0;

/// The stages of a motion, one after the other.
fn motions() -> Vec<(&'static str, Vec<Stage>)> {
    let lamp = |p, radius_m| Lamp { p, radius_m };
    let steps = 12;
    let step = |i: i32| f64::from(i - steps / 2) * 2e-3;
    vec![
        // The lamp passes the line of an upright edge, and the corner over it.
        (
            "over a corner",
            (0..steps)
                .map(|i| {
                    Stage::new(vec![block()], lamp(DVec3::new(0.5 + step(i), 4.0, 0.5 - 0.3 * step(i)), 0.25))
                })
                .collect(),
        ),
        // The planes of two faces pass through a wide lamp.
        (
            "along a face",
            (0..steps)
                .map(|i| Stage::new(vec![block()], lamp(DVec3::new(2.6, 1.25 + step(i), 0.1), 0.4)))
                .collect(),
        ),
        // The caster sinks towards the floor.
        (
            "sinking",
            (0..steps)
                .map(|i| {
                    let mut caster = block();
                    let down = Vec3::new(0.3, -1.0, 0.2) * (0.002 * i as f32);
                    caster.positions.iter_mut().for_each(|p| *p += down);
                    Stage::new(vec![caster], lamp(DVec3::new(-1.0, 3.0, 1.0), 0.8))
                })
                .collect(),
        ),
        // Steps that rounding alone can tell.
        (
            "hardly",
            (0..steps)
                .map(|i| Stage::new(vec![block()], lamp(DVec3::new(0.5 + step(i) * 1e-5, 4.0, 0.5), 0.5)))
                .collect(),
        ),
    ]
}

fn largest_jump(renderer: &mut Renderer, stages: Vec<Stage>, quality: &str, samples: Option<f64>) -> f64 {
    let mut last: Option<Vec<(f64, f64)>> = None;
    let mut largest = 0.0_f64;
    for mut stage in stages {
        stage.options.extend(samples.map(|count| ("samples", ParamValue::Number(count))));
        let pixels = stage.factors(renderer, quality);
        let now: Vec<(f64, f64)> = pixels.iter().map(|(p, factor)| (*factor, stage.right(*p))).collect();
        assert!(now.iter().any(|(factor, _)| *factor < 0.5), "no shadow");
        for (before, now) in last.iter().flatten().zip(&now) {
            let (own, right) = (now.0 - before.0, now.1 - before.1);
            largest = largest.max(own.abs() - right.abs());
        }
        last = Some(now);
    }
    largest
}

/// The same against the reference with the same samples.
fn largest_jump_beyond_the_samples_own(renderer: &mut Renderer, stages: Vec<Stage>) -> f64 {
    let mut last: Option<Vec<(f64, f64)>> = None;
    let mut largest = 0.0_f64;
    for mut stage in stages {
        // So that a sample, which rounding may decide either way, is less than what is allowed.
        stage.options.push(("samples", ParamValue::Number(256.0)));
        let judged = evaluate(renderer, &stage.scene("sampled"), &Stage::request(), &|_, _| {}).unwrap();
        let (own, right) = (&judged.measured.lights[0].1, &judged.reference.lights[0]);
        assert!(judged.errors[0].same_samples.is_some() && judged.errors[0].passes(), "{:?}", judged.errors);
        let seen = judged.measured.ids.iter().zip(&judged.reference.hits);
        let seen = seen.map(|(ids, hit)| hit.is_some_and(|hit| [hit.instance, hit.triangle] == *ids));
        let pairs = own.iter().zip(&right.factor).zip(seen.zip(&right.compared));
        let now: Vec<(f64, f64)> = pairs
            .map(|((own, right), (seen, compared))| match seen && *compared {
                true => (f64::from(*own), f64::from(*right)),
                false => (f64::NAN, f64::NAN),
            })
            .collect();
        // What is not seen in both is no number, and no maximum.
        for (before, now) in last.iter().flatten().zip(&now) {
            largest = largest.max((now.0 - before.0).abs() - (now.1 - before.1).abs());
        }
        last = Some(now);
    }
    largest
}

#[test]
fn samples_change_as_the_references_samples_do() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (name, mut stages) in motions() {
        // Those about the middle, where things pass each other.
        let stages = stages.drain(4..8).collect();
        let jump = largest_jump_beyond_the_samples_own(&mut renderer, stages);
        println!("sampled {name}: {jump:.5}");
        assert!(jump <= JUMP, "{name}: {jump}");
    }
}

#[test]
fn factors_change_as_slowly_as_what_is_right() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut failures = Vec::new();
    for (quality, samples, most) in [("perReceiver", None, JUMP), ("sampled", Some(256.0), SAMPLES_JUMP)] {
        for (name, stages) in motions() {
            let jump = largest_jump(&mut renderer, stages, quality, samples);
            println!("{quality} {name}: {jump:.5}");
            if jump > most {
                failures.push(format!("{quality} {name}: {jump}"));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:?}");
}
