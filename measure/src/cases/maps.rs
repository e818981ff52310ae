//! What shadow maps get wrong by nature: surfaces that shade themselves, shadows that come off, seams between faces.

use glam::{Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::{icosphere, plane, quad, sheet};

use super::stage::{Stage, at, block, p, v};

pub(super) fn map_acne() -> Vec<Stage> {
    let waves = sheet(24, 24, |u, v| {
        let (x, z) = (u * 4.0 - 2.0, 2.0 - v * 4.0);
        Vec3::new(x, 0.12 * (3.0 * x).sin() * (2.0 * z).cos(), z)
    });
    vec![
        // A wide floor under an oblique light: a texel covers a slope.
        Stage::new("floor")
            .caster(plane(Vec2::splat(40.0)).named("floor"))
            .caster(block(v(0.0, 0.7, 0.0), v(0.5, 0.5, 0.5)))
            .sun(p(1.0, -0.6, -0.4))
            .lit(&[p(-1.5, 0.0, 1.5), p(0.0, 0.0, 1.5)]),
        Stage::new("ball").floor().caster_at(icosphere(0.8, 3), at(0.0, 1.0, 0.0)).point(p(-2.0, 3.0, 2.0)),
        Stage::new("waves").caster(waves).sun(p(1.0, -0.2, 0.3)),
    ]
}

pub(super) fn map_peter_panning() -> Vec<Stage> {
    vec![
        // A wall thinner than a bias, on the floor.
        Stage::new("thin-wall")
            .floor()
            .caster(block(v(0.0, 0.5, 0.0), v(0.8, 0.5, 0.01)))
            .sun(p(0.2, -1.0, -0.8))
            .dark(&[p(0.0, 0.0, -0.05), p(0.1, 0.0, -0.4)])
            .lit(&[p(1.5, 0.0, -0.3)])
            .eye(p(2.0, 3.0, -4.0), p(0.0, 0.2, 0.0)),
        Stage::new("sheet-on-floor")
            .floor()
            .caster(block(v(0.0, 0.01, 0.0), v(0.6, 0.01, 0.6)))
            .point(p(-3.0, 0.8, 0.5))
            .eye(p(1.5, 1.5, 2.5), p(0.4, 0.0, 0.0)),
    ]
}

pub(super) fn map_cube_seam() -> Vec<Stage> {
    // The lamp's cube of six views has its edges along the diagonals, where these stand.
    let room = block(v(0.0, 0.0, 0.0), v(2.0, 2.0, 2.0)).flipped().named("room");
    let corners = [(0.5, 0.5), (-0.5, 0.5), (0.5, -0.5), (-0.5, -0.5)];
    let pillars = corners.map(|(x, z)| block(v(x * 1.6, -0.9, z * 1.6), v(0.12, 0.7, 0.12)).named("pillar"));
    let leaf = quad([v(0.5, 0.7, 0.4), v(0.7, 0.5, 0.4), v(0.7, 0.5, -0.4), v(0.5, 0.7, -0.4)]);
    let stage = |name: &str, eye| {
        let stage = Stage::new(name).caster(room.clone()).caster(leaf.clone()).point(p(0.0, 0.0, 0.0));
        pillars.iter().cloned().fold(stage, Stage::caster).eye(eye, p(0.0, -1.2, 0.0)).lens(80.0, 0.05)
    };
    vec![stage("down", p(-1.2, 1.4, 1.5)), stage("along", p(-1.8, -0.5, 0.1))]
}

pub(super) fn map_grazing() -> Vec<Stage> {
    [5.0, 1.0_f64]
        .map(|degrees| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            Stage::new(format!("{degrees}-deg"))
                .caster(plane(Vec2::splat(20.0)).named("floor"))
                .caster(block(v(0.0, 0.3, 0.0), v(0.3, 0.3, 0.3)))
                .sun(p(cos, -sin, 0.2 * cos))
                .lit(&[p(0.0, 0.0, 1.2), p(-1.0, 0.0, 0.5)])
                .dark(&[p(0.9, 0.0, 0.15)])
        })
        .to_vec()
}
