//! Where the eye stands: inside volumes, in the plane of a cap, at the light, with a near plane that cuts sides;
//! and odd frames: no surface, orthographic, one pixel, very wide.

use glam::{DVec3, Vec2};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{plane, quad, torus_knot, uv_sphere};

use super::Expect;
use super::stage::{Stage, at, block, p, v};

pub(super) fn eye_in_shadow() -> Vec<Stage> {
    let stage = |name: &str, caster: MeshData| {
        Stage::new(name)
            .floor()
            .caster(caster)
            .point(p(-4.0, 3.0, 0.0))
            .eye(p(2.5, 0.6, 0.0), p(4.0, 0.0, -3.0))
            .lens(70.0, 0.1)
            .lit(&[p(3.9, 0.0, -3.0)])
            .dark(&[p(3.2, 0.0, -0.9)])
    };
    let panel = quad([v(0.0, 0.4, 0.8), v(0.0, 0.4, -0.8), v(0.0, 2.0, -0.8), v(0.0, 2.0, 0.8)]);
    let solid = || block(v(0.0, 1.2, 0.0), v(0.05, 0.8, 0.8));
    vec![
        stage("closed", solid()),
        stage("open", panel.clone()),
        stage("open-back", panel.clone().flipped()),
        // In two volumes at once, one of them open.
        stage("both", solid()).caster(panel.moved(v(-0.5, 0.3, 0.0))),
    ]
}

/// A box under a light 5 m up; at height y its shadow reaches (5 − y)/4 to each side. The camera is given by the
/// centre of its near rectangle and looks 35° down along −z.
fn under_lamp(name: &str, caster: MeshData, near_center: DVec3) -> Stage {
    let forward = p(0.0, -0.7, -1.0).normalize();
    let eye = near_center - forward * 0.5;
    Stage::new(name)
        .floor()
        .caster(caster)
        .point(p(0.0, 5.0, 0.0))
        .eye(eye, eye + forward)
        // The near rectangle is 58 cm wide and half a metre away: as large as the volume's own parts.
        .lens(60.0, 0.5)
}

fn lid() -> MeshData {
    block(v(0.0, 2.9, 0.0), v(0.5, 0.1, 0.5))
}

fn open_lid() -> MeshData {
    quad([v(-0.5, 3.0, 0.5), v(0.5, 3.0, 0.5), v(0.5, 3.0, -0.5), v(-0.5, 3.0, -0.5)])
}

pub(super) fn near_clips_side() -> Vec<Stage> {
    let mut stages = Vec::new();
    for (name, caster) in [("closed", lid as fn() -> MeshData), ("open", open_lid)] {
        stages.push(under_lamp(&format!("{name}-right"), caster(), p(1.0, 1.0, 0.1)));
        stages.push(under_lamp(&format!("{name}-left"), caster(), p(-1.0, 1.0, 0.1)));
        // The eye outside, the side that faces it leaning through the near rectangle.
        stages.push(under_lamp(&format!("{name}-facing"), caster(), p(0.1, 1.0, 1.0)));
    }
    stages
}

pub(super) fn near_clips_corner() -> Vec<Stage> {
    let mut stages = Vec::new();
    for (name, caster) in [("closed", lid as fn() -> MeshData), ("open", open_lid)] {
        // The rectangle's left edge runs from 0.76 m to 1.24 m above the floor: only its lower end is in the shadow.
        stages.push(under_lamp(&format!("{name}-left"), caster(), p(1.289, 1.0, 0.1)));
        stages.push(under_lamp(&format!("{name}-right"), caster(), p(-1.289, 1.0, 0.1)));
        // An edge of the volume stands in the near rectangle.
        stages.push(under_lamp(&format!("{name}-edge"), caster(), p(1.0, 1.0, 1.0)));
    }
    stages
}

pub(super) fn eye_in_cap_plane() -> Vec<Stage> {
    let stage = |name: &str, caster: MeshData| {
        Stage::new(name)
            .floor()
            .caster(
                quad([v(-4.0, 0.0, -3.0), v(4.0, 0.0, -3.0), v(4.0, 4.0, -3.0), v(-4.0, 4.0, -3.0)])
                    .named("wall"),
            )
            .caster(caster)
            .point(p(1.0, 4.0, 1.0))
            .eye(p(0.3, 1.5, 5.0), p(-0.1, 1.5, -1.0))
            .dark(&[p(-0.35, 0.0, -0.35)])
            .lit(&[p(1.2, 0.0, 0.5), p(-1.5, 1.5, -3.0)])
    };
    vec![
        stage("quad", quad([v(-0.5, 1.5, 0.5), v(0.5, 1.5, 0.5), v(0.5, 1.5, -0.5), v(-0.5, 1.5, -0.5)])),
        stage("box-top", block(v(0.0, 1.4, 0.0), v(0.5, 0.1, 0.5))),
        // The eye lies in a side plane of the volume: light, edge and eye are coplanar.
        Stage::new("side-plane")
            .floor()
            .caster(block(v(0.0, 1.4, 0.0), v(0.5, 0.1, 0.5)))
            .point(p(1.0, 4.0, 1.0))
            .eye(p(0.75, 2.75, 4.0), p(0.25, 0.25, -1.0)),
    ]
}

fn around_eye(name: &str, light: DVec3) -> Stage {
    Stage::new(name)
        .floor()
        .caster(block(v(0.0, 0.6, 0.0), v(0.4, 0.4, 0.4)))
        .caster(quad([v(0.8, 0.3, 0.5), v(1.4, 0.3, 0.2), v(1.4, 1.2, 0.2), v(0.8, 1.2, 0.5)]))
        .point(light)
        .eye(p(0.0, 1.5, 4.0), p(0.0, 1.5, 3.0))
        .lens(60.0, 0.5)
}

pub(super) fn light_in_near_plane() -> Vec<Stage> {
    vec![
        around_eye("inside-rectangle", p(0.1, 1.6, 3.5)),
        around_eye("above-rectangle", p(0.0, 2.5, 3.5)),
        around_eye("beside-rectangle", p(2.0, 1.4, 3.5)),
        // Within rounding of the plane, on either side.
        around_eye("just-before", p(0.6, 2.0, 3.499_999)),
        around_eye("just-behind", p(0.6, 2.0, 3.500_001)),
    ]
}

pub(super) fn light_behind_eye() -> Vec<Stage> {
    vec![
        around_eye("above", p(0.5, 3.0, 7.0)).lit(&[p(-1.5, 0.0, 0.5)]),
        // A caster between light and eye: the eye and all in front of it may be dark.
        around_eye("screened", p(0.3, 2.5, 7.0)).caster(block(v(0.0, 2.0, 5.0), v(0.3, 0.3, 0.1))),
        around_eye("below-floor", p(0.0, -1.0, 6.0)).expects(Expect::Matches).dark(&[p(-1.5, 0.0, 0.5)]),
    ]
}

pub(super) fn light_at_eye() -> Vec<Stage> {
    let eye = p(0.0, 1.5, 4.0);
    vec![
        // What the eye sees, the light sees: no visible point is in shadow.
        around_eye("exactly", eye).expects(Expect::NoShadow).lit(&[p(0.0, 0.9, 0.4), p(-1.5, 0.0, 0.5)]),
        around_eye("almost", eye + p(1e-7, 0.0, 1e-7)).expects(Expect::Matches),
        around_eye("a-millimetre", eye + p(1e-3, 1e-3, 0.0)).expects(Expect::Matches),
    ]
}

pub(super) fn sky() -> Vec<Stage> {
    // Half the frame has no surface; the box's volume runs through it to infinity.
    let stage = |name: &str| {
        Stage::new(name)
            .caster(plane(Vec2::splat(1.5)).named("floor"))
            .caster_at(uv_sphere(0.5, 24, 12), at(0.0, 1.0, 0.0))
            .eye(p(0.0, 1.5, 6.0), p(0.0, 1.5, 0.0))
    };
    vec![
        stage("lamp").point(p(-1.0, 3.0, 0.5)).dark(&[p(0.5, 0.0, -0.2)]).lit(&[p(-1.2, 0.0, 0.8)]),
        stage("sun-below").sun(p(0.2, 1.0, -0.3)).expects(Expect::Matches),
        // Nothing at all is in view.
        stage("empty")
            .sun(p(0.2, -1.0, -0.3))
            .eye(p(0.0, 1.5, 6.0), p(0.0, 9.0, 9.0))
            .expects(Expect::NoShadow),
    ]
}

pub(super) fn ortho_camera() -> Vec<Stage> {
    let stage = |name: &str| {
        Stage::new(name)
            .floor()
            .caster_at(torus_knot([2, 3], 0.5, 0.12, [64, 8]), at(0.0, 1.2, 0.0))
            .caster(quad([v(-1.6, 0.4, 0.5), v(-0.9, 0.4, 0.5), v(-0.9, 1.4, 0.2), v(-1.6, 1.4, 0.2)]))
            .ortho(2.0, 0.5, 20.0)
    };
    vec![
        stage("lamp").point(p(1.0, 4.0, 1.0)),
        stage("sun").sun(p(-0.5, -1.0, -0.4)),
        stage("plan").sun(p(-0.5, -1.0, -0.4)).eye(p(0.0, 8.0, 0.0), p(0.0, 0.0, 0.0)),
        // The near plane cuts through casters and volumes.
        stage("cut").point(p(1.0, 4.0, 1.0)).ortho(1.5, 6.2, 12.0),
        // The light shines along the view.
        stage("along-view").sun(p(-3.0, -3.5, -6.0)).expects(Expect::NoShadow),
    ]
}

fn of_size(width: u32, height: u32) -> Stage {
    // A wide frame keeps its horizontal angle.
    let half_tan = 0.42 * (f64::from(height) / f64::from(width)).min(1.0);
    Stage::new(format!("{width}x{height}"))
        .floor()
        .caster(block(v(0.0, 0.7, 0.0), v(0.5, 0.5, 0.5)))
        .point(p(-1.0, 4.0, 1.5))
        .eye(p(3.0, 4.0, 6.0), p(0.4, 0.0, -0.3))
        .lens(half_tan.atan().to_degrees() * 2.0, 0.1)
        .size(width, height)
}

pub(super) fn resize() -> Vec<Stage> {
    let odd = [(255, 131), (64, 257), (333, 64), (17, 13)];
    odd.into_iter().map(|(width, height)| of_size(width, height)).collect()
}

pub(super) fn one_pixel() -> Vec<Stage> {
    let small = [(1, 1), (1, 64), (64, 1)];
    small.into_iter().map(|(width, height)| of_size(width, height).expects(Expect::Matches)).collect()
}

pub(super) fn four_thousand() -> Vec<Stage> {
    vec![of_size(4096, 64), of_size(64, 4096)]
}
