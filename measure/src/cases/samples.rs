//! Targets of several samples a pixel: edges of surfaces and of shadows that cross each other within a pixel.

use shadowgraph_engine::geometry::shapes::torus_knot;
use shadowgraph_engine::plan::Antialias;

use super::Expect;
use super::stage::{Stage, at, block, p, v};

/// A fence of bars about a pixel wide before the shadow of a box: most pixels of the fence show both, with shadows of
/// their own, and few have their middle where their edges are.
fn fence(name: &str) -> Stage {
    let bars = (0..24).fold(Stage::new(name).floor(), |stage, bar| {
        let x = -1.4 + 0.12 * bar as f32;
        stage.caster(block(v(x, 0.6, 1.6), v(0.012, 0.6, 0.012)).named("bar"))
    });
    bars.caster(block(v(0.0, 0.7, 0.0), v(0.5, 0.5, 0.5))).size(160, 120)
}

pub(super) fn msaa() -> Vec<Stage> {
    let [four, twice] = [Antialias::Multisample4, Antialias::Supersample4];
    let lamp = p(-1.5, 4.0, 1.0);
    let knot = |name: &str| {
        let knot = torus_knot([2, 3], 0.6, 0.18, [96, 12]);
        Stage::new(name).floor().caster_at(knot, at(0.0, 1.2, 0.0)).size(160, 120)
    };
    let box_only = |name: &str| Stage::new(name).floor().caster(block(v(0.0, 0.7, 0.0), v(0.5, 0.5, 0.5)));
    let lamps = |name: &str, count: usize| {
        (0..count).fold(fence(name), |stage, light| {
            let turn = light as f64 * 2.4;
            stage.point(p(2.0 * turn.sin(), 3.0 + 0.1 * light as f64, 2.0 * turn.cos()))
        })
    };
    vec![
        fence("lamp").point(lamp).antialias(four),
        fence("lamp-ssaa").point(lamp).antialias(twice),
        fence("sun").sun(p(0.4, -1.0, -0.6)).antialias(four),
        // Two lights share the mask's bits, twelve its channels.
        lamps("two-lamps", 2).antialias(four),
        lamps("twelve-lamps", 12).antialias(four).size(64, 48),
        knot("knot").point(lamp).antialias(four),
        knot("knot-ssaa").point(lamp).antialias(twice),
        // The eye is in the knot's shadow: counts from behind.
        knot("in-shadow").point(p(3.0, 6.0, 6.0)).eye(p(-0.4, 0.3, -0.7), p(-3.0, 0.0, -3.0)).antialias(four),
        knot("ortho").sun(p(-0.5, -1.0, -0.4)).ortho(1.6, 0.5, 20.0).antialias(four),
        // Odd sizes, and the largest.
        box_only("odd").point(lamp).size(133, 71).antialias(four),
        box_only("odd-ssaa").point(lamp).size(133, 71).antialias(twice),
        box_only("one-pixel").point(lamp).size(1, 1).antialias(four).expects(Expect::Matches),
        box_only("one-pixel-ssaa").point(lamp).size(1, 1).antialias(twice).expects(Expect::Matches),
        box_only("wide").point(lamp).lens(0.8, 0.1).size(4096, 24).antialias(four).expects(Expect::Matches),
        box_only("wide-ssaa")
            .point(lamp)
            .lens(0.8, 0.1)
            .size(4096, 24)
            .antialias(twice)
            .expects(Expect::Matches),
    ]
}
