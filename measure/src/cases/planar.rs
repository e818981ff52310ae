//! Shadows cast onto a plane: casters behind the light, across its height, under the plane; shadows that run over the
//! plane's edge or over each other.

use glam::Vec2;
use shadowgraph_engine::geometry::shapes::{plane, quad, uv_sphere};
use shadowgraph_engine::scene::ParamValue;

use super::stage::{Stage, at, block, p, v};

/// A light without size over a floor that is named as the receiver.
fn over_floor(name: &str, half_m: f32) -> Stage {
    Stage::new(name)
        .receiver(plane(Vec2::splat(half_m)).named("floor"))
        .option("radius", ParamValue::Number(0.0))
        .option("angle", ParamValue::Number(0.0))
}

pub(super) fn planar_behind() -> Vec<Stage> {
    vec![
        // Projected through the light, the upper box would land on the floor mirrored.
        over_floor("above", 4.0)
            .caster(block(v(0.4, 1.0, 0.0), v(0.2, 0.2, 0.2)))
            .caster(block(v(-0.6, 3.0, 0.3), v(0.2, 0.2, 0.2)))
            .point(p(0.0, 2.0, 0.0))
            .dark(&[p(0.8, 0.0, 0.0)])
            .lit(&[p(1.2, 0.0, -0.6), p(-1.0, 0.0, 0.6)]),
        over_floor("only-above", 4.0)
            .caster(block(v(-0.6, 3.0, 0.3), v(0.2, 0.2, 0.2)))
            .caster(block(v(2.0, 0.3, 1.0), v(0.2, 0.2, 0.2)))
            .point(p(0.0, 2.0, 0.0))
            .lit(&[p(1.2, 0.0, -0.6)]),
    ]
}

pub(super) fn planar_crossing() -> Vec<Stage> {
    vec![
        // The pillar reaches past the light's height; its shadow ends nowhere.
        over_floor("pillar", 4.0)
            .caster(block(v(1.0, 1.5, 0.0), v(0.15, 1.4, 0.15)))
            .point(p(0.0, 2.0, 0.0))
            .dark(&[p(2.0, 0.0, 0.0)])
            .lit(&[p(-1.0, 0.0, 0.3), p(-2.0, 0.0, 0.0)]),
        over_floor("leaf", 4.0)
            .caster(quad([v(0.8, 0.5, 0.4), v(0.8, 0.5, -0.4), v(0.8, 3.0, -0.4), v(0.8, 3.0, 0.4)]))
            .point(p(0.0, 2.0, 0.0))
            .dark(&[p(1.6, 0.0, 0.2)])
            .lit(&[p(-1.0, 0.0, 0.3)]),
    ]
}

pub(super) fn planar_below() -> Vec<Stage> {
    vec![
        // Upwards, away from the light, nothing throws a shadow.
        over_floor("under", 1.5)
            .caster(block(v(0.3, -0.6, 0.2), v(0.3, 0.3, 0.3)))
            .caster(block(v(-0.5, 0.8, -0.3), v(0.2, 0.2, 0.2)))
            .point(p(0.0, 3.0, 0.0))
            .lit(&[p(0.25, 0.0, 0.2)])
            .dark(&[p(-0.68, 0.0, -0.4)]),
        // Half of it stands below.
        over_floor("through", 1.5)
            .caster_at(uv_sphere(0.5, 24, 12), at(0.3, 0.1, 0.0))
            .point(p(-0.6, 3.0, 0.4))
            .lit(&[p(-0.6, 0.0, 0.6)]),
    ]
}

pub(super) fn planar_overhang() -> Vec<Stage> {
    vec![
        over_floor("edge", 1.0)
            .caster(block(v(0.6, 0.8, 0.0), v(0.4, 0.1, 0.4)))
            .point(p(-0.5, 3.0, 0.3))
            .dark(&[p(0.9, 0.0, 0.0)])
            .lit(&[p(-0.5, 0.0, 0.5)]),
        // What lies beyond the edge is no receiver of the node's, but the floor of a deeper one.
        over_floor("over-a-deeper-floor", 1.0)
            .caster(plane(Vec2::splat(4.0)).moved(v(0.0, -0.5, 0.0)).named("lower floor"))
            .caster(block(v(0.6, 0.8, 0.0), v(0.4, 0.1, 0.4)))
            .point(p(-0.5, 3.0, 0.3))
            .dark(&[p(0.9, 0.0, 0.0)]),
    ]
}

pub(super) fn planar_overlap() -> Vec<Stage> {
    vec![
        over_floor("lamp", 4.0)
            .caster(block(v(0.0, 0.8, 0.0), v(0.4, 0.1, 0.4)))
            .caster(block(v(0.1, 1.2, 0.1), v(0.4, 0.1, 0.4)))
            .caster(quad([v(-0.5, 1.6, 0.4), v(0.2, 1.6, 0.4), v(0.2, 1.6, -0.4), v(-0.5, 1.6, -0.4)]))
            .point(p(-0.5, 4.0, 0.5))
            .dark(&[p(0.45, 0.0, -0.1)]),
        over_floor("sun", 4.0)
            .caster(block(v(0.0, 0.8, 0.0), v(0.4, 0.1, 0.4)))
            .caster(block(v(0.1, 1.2, 0.1), v(0.4, 0.1, 0.4)))
            .sun(p(0.3, -1.0, -0.2))
            .dark(&[p(0.5, 0.0, -0.2)]),
    ]
}
