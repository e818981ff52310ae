//! Where the light stands: in a triangle's plane, on the mesh, inside it, parallel to it, at the horizon.

use glam::{DVec3, Vec2};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cylinder, plane, quad, uv_sphere};

use super::Expect;
use super::stage::{Stage, at, block, p, triangles, v};

/// A box that lacks faces (+x, −x, +y, −y, +z, −z count from 0).
pub(super) fn open_block(center: glam::Vec3, half: glam::Vec3, missing: &[usize]) -> MeshData {
    block(center, half).without_triangles(|triangle| missing.contains(&(triangle / 2))).named("open box")
}

pub(super) fn light_in_plane() -> Vec<Stage> {
    let upright = triangles("upright", &[v(0.0, 1.0, -1.0), v(0.0, 1.0, 1.0), v(0.0, 2.0, 0.0)], &[0, 1, 2]);
    // The light is a combination of three vertices that f64 cannot write exactly: the determinant is tiny, not 0.
    let corners = [v(-1.1, 1.3, -0.7), v(-0.2, 1.9, 0.9), v(-0.9, 1.1, 0.6)];
    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
    let in_plane = a + (b - a) * 3.37 + (c - a) * -2.9;
    vec![
        Stage::new("triangle")
            .floor()
            .control()
            .caster(upright)
            .point(p(0.0, 4.0, 0.0))
            .lit(&[p(0.05, 0.0, 0.0), p(-0.05, 0.0, 0.4)])
            .dark(&[p(2.6, 0.0, 1.3)]),
        Stage::new("face-of-box")
            .floor()
            .caster(block(v(0.5, 1.0, 0.0), v(0.5, 0.5, 0.5)))
            .point(p(0.0, 4.0, 0.0))
            .lit(&[p(-0.1, 0.0, 0.3)])
            .dark(&[p(1.3, 0.0, 0.7)]),
        Stage::new("oblique")
            .floor()
            .control()
            .caster(triangles("oblique", &corners, &[0, 1, 2]))
            .point(in_plane),
    ]
}

pub(super) fn light_on_edge() -> Vec<Stage> {
    let box_up = || block(v(0.0, 1.5, 0.0), v(0.5, 0.5, 0.5));
    let leaf = quad([v(-1.0, 1.5, 0.0), v(0.0, 1.5, 0.0), v(0.0, 2.5, 0.0), v(-1.0, 2.5, 0.0)]);
    vec![
        Stage::new("closed-box")
            .floor()
            .caster(box_up())
            .point(p(0.0, 2.0, 0.5))
            .lit(&[p(0.0, 0.0, 2.0)])
            .dark(&[p(1.0, 0.0, 0.3), p(-0.9, 0.0, 0.0)]),
        Stage::new("open-box")
            .floor()
            .caster(open_block(v(0.0, 1.5, 0.0), v(0.5, 0.5, 0.5), &[3]))
            .point(p(0.0, 2.0, 0.5))
            .lit(&[p(0.0, 0.0, 2.0)])
            .dark(&[p(-1.3, 0.0, 0.3)]),
        Stage::new("quad")
            .floor()
            .control()
            .caster(leaf)
            .point(p(0.0, 2.0, 0.0))
            .lit(&[p(-0.5, 0.0, 0.3), p(0.3, 0.0, 0.0)]),
    ]
}

pub(super) fn light_on_vertex() -> Vec<Stage> {
    vec![
        Stage::new("closed-box")
            .floor()
            .caster(block(v(0.0, 1.5, 0.0), v(0.5, 0.5, 0.5)))
            .point(p(0.5, 2.0, 0.5))
            .lit(&[p(2.0, 0.0, 0.0), p(0.0, 0.0, 2.0)])
            .dark(&[p(-0.9, 0.0, 0.2)]),
        Stage::new("sphere-pole")
            .floor()
            .caster_at(uv_sphere(0.5, 24, 12), at(0.0, 1.5, 0.0))
            .point(p(0.0, 2.0, 0.0))
            .expects(Expect::Matches)
            .dark(&[p(1.0, 0.0, 0.0), p(-1.0, 0.0, 0.5)]),
    ]
}

pub(super) fn light_in_closed() -> Vec<Stage> {
    let stage =
        |name: &str, eye: DVec3| Stage::new(name).floor().point(p(0.0, 1.5, 0.0)).eye(eye, p(0.0, 0.5, 0.0));
    let everywhere = [p(1.5, 0.0, 1.5), p(-1.5, 0.0, 0.0), p(0.0, 0.0, 1.0)];
    vec![
        stage("box", p(3.0, 4.0, 6.0))
            .caster(block(v(0.0, 1.5, 0.0), v(0.5, 0.5, 0.5)))
            .expects(Expect::Matches)
            .dark(&everywhere),
        stage("sphere", p(3.0, 4.0, 6.0))
            .caster_at(uv_sphere(0.6, 24, 12), at(0.0, 1.5, 0.0))
            .expects(Expect::Matches)
            .dark(&everywhere),
        // Eye, light and a small box share one closed room: its own walls must not darken it.
        stage("room", p(1.6, 2.2, 1.7))
            .caster(block(v(0.0, 1.45, 0.0), v(2.0, 1.5, 2.0)).named("room"))
            .caster(block(v(0.0, 0.8, 0.0), v(0.3, 0.3, 0.3)))
            .lens(70.0, 0.1)
            .lit(&[p(-1.4, 0.0, 0.0)])
            .dark(&[p(0.4, 0.0, 0.4)]),
    ]
}

pub(super) fn light_in_open_box() -> Vec<Stage> {
    let lamp = |name: &str, missing: usize| {
        let half = v(0.5, 0.5, 0.5);
        Stage::new(name)
            .floor()
            .caster(open_block(v(0.0, 1.0, 0.0), half, &[missing]))
            .point(p(0.0, 1.0, 0.0))
    };
    vec![
        lamp("front", 4).lit(&[p(0.0, 0.0, 2.2)]).dark(&[p(2.0, 0.0, 0.0), p(-1.5, 0.0, 0.0)]),
        lamp("side", 0).lit(&[p(2.2, 0.0, 0.0)]).dark(&[p(0.0, 0.0, 2.0), p(-1.5, 0.0, 0.0)]),
        lamp("below", 3).lit(&[p(0.5, 0.0, 0.8)]).dark(&[p(2.0, 0.0, 0.0), p(0.0, 0.0, 2.0)]),
    ]
}

pub(super) fn directional_parallel() -> Vec<Stage> {
    let wall =
        || quad([v(-4.0, 0.0, -3.0), v(4.0, 0.0, -3.0), v(4.0, 4.0, -3.0), v(-4.0, 4.0, -3.0)]).named("wall");
    vec![
        // Four of the box's faces are edge-on.
        Stage::new("box-sides")
            .floor()
            .caster(block(v(0.0, 1.0, 0.0), v(0.5, 0.5, 0.5)))
            .sun(p(0.0, -1.0, 0.0))
            .lit(&[p(0.7, 0.0, 0.7)])
            .dark(&[p(0.4, 0.0, 0.45)]),
        // The floor is edge-on, its shadow has no width; the wall receives.
        Stage::new("floor")
            .floor()
            .caster(wall())
            .caster(block(v(0.0, 1.5, 0.0), v(0.5, 0.5, 0.5)))
            .sun(p(0.0, 0.0, -1.0))
            .lit(&[p(-1.5, 1.5, -3.0)])
            .dark(&[p(-0.45, 1.9, -3.0)])
            .eye(p(2.5, 3.5, 6.0), p(0.0, 1.0, -2.0)),
        // An upright quad edge-on to the light casts nothing.
        Stage::new("quad")
            .floor()
            .control()
            .caster(quad([v(-1.0, 0.5, 0.0), v(1.0, 0.5, 0.0), v(1.0, 1.5, 0.0), v(-1.0, 1.5, 0.0)]))
            .sun(p(0.0, -1.0, 0.0))
            .lit(&[p(0.0, 0.0, 0.02), p(0.5, 0.0, 0.1)])
            .dark(&[p(2.0, 0.0, 1.2)]),
    ]
}

pub(super) fn low_sun() -> Vec<Stage> {
    let down = 1.0_f64.to_radians();
    let sun = p(-down.cos(), -down.sin(), 0.0);
    let field = || Stage::new("").caster(plane(Vec2::splat(80.0)).named("floor")).sun(sun);
    let posts = |stage: Stage| {
        stage
            .caster(block(v(20.0, 0.5, 0.0), v(0.2, 0.5, 0.2)))
            .caster_at(cylinder(0.25, 0.8, 16, Ends::Open), at(12.0, 0.0, 2.0))
            .eye(p(-6.0, 3.0, 7.0), p(4.0, 0.0, 0.0))
            .lit(&[p(0.0, 0.0, 0.6)])
            // A metre of height throws 57 m of shadow.
            .dark(&[p(0.0, 0.0, 0.1), p(10.0, 0.0, 0.1)])
    };
    vec![posts(field())]
}

pub(super) fn directional_offscreen() -> Vec<Stage> {
    let tower = || block(v(8.0, 6.0, 0.0), v(0.5, 0.5, 0.5));
    let stage = |name: &str| Stage::new(name).floor().eye(p(0.0, 3.0, 5.0), p(0.0, 0.0, 0.0)).lens(45.0, 0.1);
    vec![
        stage("right")
            .caster(tower())
            .sun(p(-8.0, -6.0, 0.0))
            .dark(&[p(0.0, 0.0, 0.0)])
            .lit(&[p(0.0, 0.0, 1.5)]),
        // The caster floats behind the eye.
        stage("behind")
            .caster(block(v(0.0, 9.0, 12.0), v(0.5, 0.5, 0.5)))
            .sun(p(0.0, -9.0, -12.0))
            .dark(&[p(0.0, 0.0, 0.0)])
            .lit(&[p(1.5, 0.0, 0.0)]),
        stage("above")
            .caster(quad([v(-0.5, 30.0, 0.5), v(0.5, 30.0, 0.5), v(0.5, 30.0, -0.5), v(-0.5, 30.0, -0.5)]))
            .sun(p(0.0, -1.0, 0.0))
            .dark(&[p(0.0, 0.0, 0.0)])
            .lit(&[p(1.5, 0.0, 0.0)]),
    ]
}

pub(super) fn offscreen_caster() -> Vec<Stage> {
    let stage = |name: &str| Stage::new(name).floor().eye(p(0.0, 3.0, 5.0), p(0.0, 0.0, 0.0)).lens(40.0, 0.1);
    vec![
        // Light and caster both outside, on one side.
        stage("beside")
            .caster(block(v(-4.0, 2.0, 0.0), v(0.3, 0.3, 0.3)))
            .point(p(-8.0, 4.0, 0.0))
            .dark(&[p(0.0, 0.0, 0.0)])
            .lit(&[p(0.0, 0.0, 1.2)]),
        // The light is in view, the caster is not: it hangs above the frame.
        stage("above")
            .caster(block(v(0.0, 4.0, 0.0), v(0.2, 0.1, 0.2)))
            .point(p(0.0, 8.0, 0.0))
            .dark(&[p(0.0, 0.0, 0.1)]),
        stage("behind")
            .caster_at(uv_sphere(0.3, 16, 8), at(0.0, 4.0, 8.0))
            .spot(p(0.0, 8.0, 16.0), p(0.0, 0.0, 0.0), 0.3)
            .dark(&[p(0.0, 0.0, 0.0)])
            .lit(&[p(1.0, 0.0, 0.0)]),
    ]
}

pub(super) fn light_crosses_frustum() -> Vec<Stage> {
    // The light slides along x out of the picture's right edge, and along z through the eye's plane.
    let scene = |name: String, light: DVec3| {
        Stage::new(name)
            .floor()
            .caster(block(v(0.4, 0.5, 0.0), v(0.3, 0.3, 0.3)))
            .caster_at(cylinder(0.3, 0.8, 16, Ends::Top), at(-1.2, 0.2, 0.0))
            .point(light)
            .eye(p(0.0, 2.0, 5.0), p(0.0, 0.5, 0.0))
            .lens(45.0, 0.1)
    };
    let across = [1.5, 1.9, 2.0, 2.1, 2.5, 4.0];
    let along = [0.0, 2.5, 4.5, 5.0, 5.5];
    let mut stages: Vec<Stage> = across.iter().map(|&x| scene(format!("x={x}"), p(x, 1.6, 0.3))).collect();
    stages.extend(along.iter().map(|&z| scene(format!("z={z}"), p(0.0, 2.5, z))));
    stages
}

pub(super) fn casters_around_light() -> Vec<Stage> {
    let ring = |count: u32| {
        (0..count).map(move |i| {
            let angle = f64::from(i) / f64::from(count) * std::f64::consts::TAU;
            glam::DAffine3::from_rotation_y(angle) * at(1.2, 0.35, 0.0)
        })
    };
    let posts = |stage: Stage, data: MeshData| {
        stage
            .floor()
            .instances(data, ring(8))
            .point(p(0.0, 1.0, 0.0))
            .eye(p(3.0, 5.0, 5.0), p(0.0, 0.0, 0.0))
            // Behind a post, and between two.
            .dark(&[p(1.9, 0.0, 0.0), p(0.0, 0.0, -1.9), p(-1.9, 0.0, 0.0), p(0.0, 0.0, 1.9)])
            .lit(&[p(1.8, 0.0, 0.75), p(-0.75, 0.0, 1.8)])
    };
    let panel = quad([v(0.0, -0.35, 0.2), v(0.0, -0.35, -0.2), v(0.0, 0.35, -0.2), v(0.0, 0.35, 0.2)]);
    vec![
        posts(Stage::new("closed"), block(v(0.0, 0.0, 0.0), v(0.1, 0.35, 0.15))),
        posts(Stage::new("open"), panel.named("panel")),
    ]
}
