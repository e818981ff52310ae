//! Lights with a size: none at all, larger than what they meet, touching it, or seen edge-on.
//!
//! The size is an option of the case ([`super::Case::options`]): a technique that has none is judged by its own light,
//! a point.

use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cylinder, quad};
use shadowgraph_engine::scene::ParamValue;

use super::Expect;
use super::stage::{Stage, block, p, v};

impl Stage {
    /// Point and spot lights are spheres of this radius.
    pub(super) fn radius(self, radius_m: f64) -> Self {
        self.option("radius", ParamValue::Number(radius_m))
    }

    /// Directional lights are discs of this half-angle.
    pub(super) fn half_angle(self, degrees: f64) -> Self {
        self.option("angle", ParamValue::Number(degrees))
    }
}

/// A square board at height `y`, from `x0` to `x1`, 4 m deep.
fn board(x0: f32, x1: f32, y: f32) -> MeshData {
    quad([v(x0, y, 2.0), v(x1, y, 2.0), v(x1, y, -2.0), v(x0, y, -2.0)]).named("board")
}

pub(super) fn radius_0() -> Vec<Stage> {
    let stage = |name: &str| {
        Stage::new(name).floor().caster(block(v(0.0, 1.2, 0.0), v(0.5, 0.5, 0.5))).radius(0.0).half_angle(0.0)
    };
    vec![
        stage("lamp").point(p(-1.0, 4.0, 1.0)).dark(&[p(0.4, 0.0, -0.4)]).lit(&[p(-1.5, 0.0, 1.5)]),
        stage("sun").sun(p(0.4, -1.0, -0.3)).dark(&[p(0.5, 0.0, -0.4)]).lit(&[p(-1.5, 0.0, 1.5)]),
        stage("spot").spot(p(-1.0, 4.0, 1.0), p(0.0, 0.5, 0.0), 0.5).dark(&[p(0.4, 0.0, -0.4)]),
    ]
}

pub(super) fn receiver_inside_light() -> Vec<Stage> {
    // The sphere dips into the floor: a disc of it, 1.1 m to each side, is inside.
    vec![
        Stage::new("")
            .floor()
            .caster(block(v(0.3, 0.5, 0.0), v(0.1, 0.1, 0.1)))
            .point(p(0.0, 1.0, 0.0))
            .radius(1.5)
            .dark(&[p(0.6, 0.0, 0.0)])
            .lit(&[p(-0.5, 0.0, 0.0), p(0.0, 0.0, 0.9)]),
    ]
}

pub(super) fn light_touches_caster() -> Vec<Stage> {
    let caster = || block(v(0.0, 1.5, 0.0), v(0.5, 0.5, 0.5));
    vec![
        Stage::new("face")
            .floor()
            .caster(caster())
            .point(p(0.0, 2.3, 0.0))
            .radius(0.3)
            .dark(&[p(0.9, 0.0, 0.0)]),
        Stage::new("edge").floor().caster(caster()).point(p(0.7, 2.2, 0.0)).radius(0.2f64.hypot(0.2)),
        Stage::new("corner").floor().caster(caster()).point(p(0.7, 2.2, 0.7)).radius(0.12f64.sqrt()),
    ]
}

pub(super) fn caster_in_light() -> Vec<Stage> {
    let leaf = quad([v(-0.2, 2.3, 0.2), v(0.2, 2.3, 0.2), v(0.2, 2.3, -0.2), v(-0.2, 2.3, -0.2)]);
    // From the floor below, the leaf hides a square of (0.4 · 2.5/2.3)² of a disc of radius 0.5103.
    let hidden = (0.4_f32 * 2.5 / 2.3).powi(2) / (std::f32::consts::PI * 0.510_31_f32.powi(2));
    vec![
        Stage::new("leaf")
            .floor()
            .caster(leaf)
            .point(p(0.0, 2.5, 0.0))
            .radius(0.5)
            .factor(&[p(0.0, 0.0, 0.0)], [1.0 - hidden; 3]),
        Stage::new("box")
            .floor()
            .caster(block(v(0.0, 2.2, 0.0), v(0.1, 0.1, 0.1)))
            .point(p(0.0, 2.5, 0.0))
            .radius(0.5),
        // The centre is in the caster: where its sphere reaches out of it, light does too.
        Stage::new("centre-inside")
            .expects(Expect::Matches)
            .floor()
            .caster(block(v(0.0, 2.5, 0.0), v(0.2, 0.2, 0.2)))
            .point(p(0.0, 2.5, 0.0))
            .radius(0.5),
    ]
}

pub(super) fn edge_at_centre() -> Vec<Stage> {
    // The lines of edges go through the light's centre.
    vec![
        Stage::new("upright-edge")
            .floor()
            .caster(block(v(0.0, 1.0, 0.0), v(0.5, 0.5, 0.5)))
            .point(p(0.5, 4.0, 0.5))
            .radius(0.25),
        Stage::new("level-edge")
            .floor()
            .caster(block(v(0.0, 1.0, 0.0), v(0.5, 0.5, 0.5)))
            .point(p(3.0, 1.5, 0.5))
            .radius(0.25),
    ]
}

pub(super) fn edge_through_centre() -> Vec<Stage> {
    // From everywhere in the plane of edge and centre, half of the light is hidden.
    let on_edge = [p(0.0, 0.0, 0.8), p(0.0, 0.0, 0.0), p(0.0, 0.0, -0.9)];
    let stage = |name: &str, caster: MeshData| {
        Stage::new(name)
            .floor()
            .caster(caster)
            .eye(p(2.5, 3.0, 5.0), p(0.3, 0.0, 0.0))
            .factor(&on_edge, [0.5; 3])
            .lit(&[p(1.0, 0.0, 0.0)])
    };
    vec![
        stage("lamp", board(-2.0, 0.0, 1.5)).point(p(0.0, 4.0, 0.0)).radius(0.3),
        stage("turned", board(-2.0, 0.0, 1.5).flipped()).point(p(0.0, 4.0, 0.0)).radius(0.3),
        stage("sun", board(-2.0, 0.0, 1.5)).sun(p(0.0, -1.0, 0.0)).half_angle(3.0),
        // The box's side lies in that plane.
        stage("box", block(v(-1.0, 1.5, 0.0), v(1.0, 0.2, 2.0))).point(p(0.0, 4.0, 0.0)).radius(0.3),
    ]
}

pub(super) fn penumbra_overlap() -> Vec<Stage> {
    let stage = |name: &str| {
        Stage::new(name).floor().point(p(0.0, 4.0, 0.0)).radius(0.4).eye(p(2.5, 3.0, 5.0), p(0.0, 0.0, 0.0))
    };
    let across = |y: f32| {
        quad([v(-2.0, y, 0.0), v(2.0, y, 0.0), v(2.0, y, -2.0), v(-2.0, y, -2.0)]).named("board across")
    };
    vec![
        // Half-planes crossing at right angles: a quarter of the light is left.
        stage("half-planes")
            .caster(board(-2.0, 0.0, 1.5))
            .caster(across(1.2))
            .factor(&[p(0.0, 0.0, 0.0)], [0.25; 3]),
        // One above the other: areas that are added hide everything, half the light is left.
        stage("same-side")
            .caster(board(-2.0, 0.0, 1.5))
            .caster(board(-2.0, 0.0, 1.2))
            .factor(&[p(0.0, 0.0, 0.8)], [0.5; 3]),
        // A slit through which half of the light's width passes.
        stage("slit").caster(board(-2.0, -0.05, 1.5)).caster(board(0.05, 2.0, 1.5)),
        // No light passes between boxes that touch.
        stage("abutting")
            .caster(block(v(-0.5, 1.2, 0.0), v(0.5, 0.2, 0.5)))
            .caster(block(v(0.5, 1.2, 0.0), v(0.5, 0.2, 0.5)))
            .dark(&[p(0.3, 0.0, 0.2)]),
    ]
}

pub(super) fn tripod() -> Vec<Stage> {
    let leg = |x: f32, z: f32| {
        let mut leg = cylinder(0.04, 1.2, 12, Ends::Closed).named("leg");
        // Sheared outwards: its foot stands aside by (x, z).
        for position in &mut leg.positions {
            let down = 1.0 - position.y / 1.2;
            *position += v(x, 0.0, z) * down;
        }
        leg
    };
    let legs = [(0.5, 0.0), (-0.25, 0.43), (-0.25, -0.43)].map(|(x, z)| leg(x, z));
    let stage = legs.into_iter().fold(Stage::new("").floor(), Stage::caster);
    vec![
        stage
            .caster(block(v(0.0, 1.25, 0.0), v(0.3, 0.05, 0.3)).named("seat"))
            .point(p(-1.5, 3.5, 1.0))
            .radius(0.25),
    ]
}

pub(super) fn penumbra_width() -> Vec<Stage> {
    [("low", 0.3), ("middle", 1.0), ("high", 2.0)]
        .map(|(name, height): (&str, f32)| {
            // A light of radius R at height L over an edge at height h: the penumbra reaches R·h/(L − h) to each side;
            // to the outside from the box's upper edge, to the inside from its lower one.
            let reach = |height: f32| f64::from(0.2 * height / (4.0 - height));
            Stage::new(name)
                .floor()
                .caster(block(v(-1.0, height + 0.1, 0.0), v(1.0, 0.1, 1.5)))
                .point(p(0.0, 4.0, 0.0))
                .radius(0.2)
                .eye(p(2.0, 3.0, 4.5), p(0.0, 0.0, 0.0))
                .lit(&[p(reach(height + 0.2) * 1.1, 0.0, 0.4)])
                .dark(&[p(-reach(height) * 1.1, 0.0, 0.4)])
        })
        .to_vec()
}
