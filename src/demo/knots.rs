//! Torus knots and spheres over a floor: curved silhouettes, self-shadows, three coloured lamps.

use glam::{DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::{icosphere, plane, torus_knot};
use shadowgraph_engine::scene::{Camera, Light, Scene, ShadowNode, placed};

use super::set::{Set, stand};

pub(super) fn knots() -> Scene {
    let mut set = Set::new();
    let group = set.scene.add_group("things");
    let ground = set.paint("ground", [0.62, 0.6, 0.57], 0.9);
    let enamel = set.paint("enamel", [0.75, 0.72, 0.66], 0.35);
    let clay = set.paint("clay", [0.5, 0.2, 0.1], 0.7);
    let brass = set.metal("brass", [0.83, 0.6, 0.28], 0.35);
    set.put(group, "floor", plane(Vec2::splat(9.0)), ground, stand(0.0, 0.0, 0.0, 0.0));
    let knots = [
        ([2, 3], enamel, DVec3::new(0.0, 1.15, 0.0), 0.3),
        ([3, 4], brass, DVec3::new(-1.9, 0.95, -1.1), 1.2),
        ([2, 5], clay, DVec3::new(1.8, 0.85, -1.3), -0.7),
    ];
    for (i, (winding, material, at, turn)) in knots.into_iter().enumerate() {
        let size = [0.6, 0.5, 0.45][i];
        let knot = torus_knot(winding, size, size * 0.2, [240, 20]);
        let place = placed(at, DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(0.25), DVec3::ONE);
        set.put(group, &format!("knot {}-{}", winding[0], winding[1]), knot, material, place);
    }
    let ball = set.shape(icosphere(0.22, 4).named("ball"));
    let spots =
        [(-1.0, 0.9, clay), (0.9, 1.1, enamel), (-0.2, 1.5, brass), (1.9, 0.4, enamel), (-2.2, 0.6, enamel)];
    for (x, z, material) in spots {
        set.place(group, "ball", ball, material, stand(x, 0.22, z, 0.0));
    }
    let lamps = [
        ("rose", [1.0, 0.32, 0.25], DVec3::new(-2.6, 3.2, 1.6)),
        ("mint", [0.3, 1.0, 0.5], DVec3::new(2.8, 3.0, 1.2)),
        ("azure", [0.28, 0.45, 1.0], DVec3::new(0.3, 3.6, -2.6)),
    ];
    for (name, color, at) in lamps {
        set.scene.add_light(Light::point(name, 14.0).with_color(Vec3::from(color)), at, DVec3::ZERO);
    }
    set.scene.add_camera(
        Camera::perspective("main", 0.66),
        DVec3::new(0.0, 3.1, 6.0),
        DVec3::new(0.0, 0.55, -0.2),
    );
    set.scene.add_shadow("shadows", ShadowNode::new("ShadowVolumeHard"));
    set.scene
}
