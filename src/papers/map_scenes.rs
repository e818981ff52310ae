//! Scenes like those of paper 004: a crowd before a wall, a vehicle, a castle, and bowling pins.

use glam::{DAffine3, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{self, Ends};
use shadowgraph_engine::scene::Scene;

use super::models::{ModelError, add, add_at, block, matt, stage};

/// Thirty people before a wall, the lamp behind them.
pub(super) fn crowd() -> Result<Scene, ModelError> {
    let mut scene =
        stage(8.0, DVec3::new(1.5, 4.5, 7.0), [DVec3::new(2.0, 2.6, 8.0), DVec3::new(0.0, 0.9, 0.0)])?;
    let wall = block([-6.0, 0.0, -2.7], [6.0, 4.0, -2.5]).named("wall");
    add(&mut scene, wall, matt(Vec3::new(0.75, 0.7, 0.6)))?;
    for number in 0..30 {
        let (row, column) = (number / 10, number % 10);
        let x = f64::from(column) * 0.8 - 3.6 + 0.3 * f64::from(row % 2);
        let place = DVec3::new(x, 0.0, -1.6 + 0.9 * f64::from(row) + 0.1 * f64::from(number % 3));
        let color = Vec3::new(0.3 + 0.05 * (number % 7) as f32, 0.4, 0.7 - 0.06 * (number % 5) as f32);
        let limb = |radius: f32, length: f32| shapes::cylinder(radius, length, 16, Ends::Closed);
        let person = MeshData::merged(
            "person",
            [
                limb(0.07, 0.8).moved(Vec3::new(-0.1, 0.0, 0.0)),
                limb(0.07, 0.8).moved(Vec3::new(0.1, 0.0, 0.05)),
                shapes::frustum(0.16, 0.2, 0.6, 16, Ends::Closed).moved(Vec3::Y * 0.82),
                limb(0.04, 0.55).moved(Vec3::new(-0.26, 0.85, 0.0)),
                limb(0.04, 0.55).moved(Vec3::new(0.26, 0.85, 0.0)),
                shapes::uv_sphere(0.13, 10, 9).moved(Vec3::Y * 1.6),
            ],
        );
        add_at(&mut scene, person, matt(color), place)?;
    }
    Ok(scene)
}

/// An open vehicle of boxes, bars and wheels.
pub(super) fn vehicle() -> Result<Scene, ModelError> {
    vehicle_seen([DVec3::new(3.2, 2.4, 4.2), DVec3::new(0.0, 0.6, 0.0)])
}

/// The same from an eye towards a target.
pub(super) fn vehicle_seen(view: [DVec3; 2]) -> Result<Scene, ModelError> {
    let mut scene = stage(5.0, DVec3::new(-2.5, 4.5, 3.0), view)?;
    let body = Vec3::new(0.35, 0.42, 0.25);
    for (min, max) in [
        ([-1.5, 0.45, -0.7], [1.5, 0.6, 0.7]),
        ([0.5, 0.6, -0.6], [1.5, 0.95, 0.6]),
        ([-1.5, 0.6, -0.7], [-1.4, 1.0, 0.7]),
        ([-1.4, 0.6, 0.62], [0.4, 0.85, 0.7]),
        ([-1.4, 0.6, -0.7], [0.4, 0.85, -0.62]),
        ([-0.6, 0.6, 0.1], [-0.1, 0.8, 0.5]),
        ([-0.6, 0.6, -0.5], [-0.1, 0.8, -0.1]),
        ([-0.7, 0.8, 0.1], [-0.6, 1.3, 0.5]),
        ([-0.7, 0.8, -0.5], [-0.6, 1.3, -0.1]),
        ([0.6, 0.45, 0.7], [1.4, 0.55, 0.95]),
        ([0.6, 0.45, -0.95], [1.4, 0.55, -0.7]),
    ] {
        add(&mut scene, block(min, max).named("plate"), matt(body))?;
    }
    for (x, z) in [(0.95, 0.8), (0.95, -0.8), (-0.95, 0.8), (-0.95, -0.8)] {
        let wheel = shapes::torus(0.3, 0.12, 16, 8);
        let turned = wheel.transformed(&DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2));
        add_at(&mut scene, turned.named("wheel"), matt(Vec3::splat(0.15)), DVec3::new(x, 0.42, z))?;
    }
    for (from, to) in [([0.45, 0.95, 0.6], [0.45, 1.5, 0.6]), ([0.45, 0.95, -0.6], [0.45, 1.5, -0.6])] {
        let bar = block([from[0] - 0.02, from[1], from[2] - 0.02], [to[0] + 0.02, to[1], to[2] + 0.02]);
        add(&mut scene, bar.named("bar"), matt(body))?;
    }
    add(&mut scene, block([0.43, 1.46, -0.6], [0.47, 1.5, 0.6]).named("bar"), matt(body))?;
    let steering = shapes::torus(0.16, 0.02, 20, 8).moved(Vec3::new(0.25, 1.05, 0.3));
    add(&mut scene, steering.named("wheel"), matt(Vec3::splat(0.1)))?;
    Ok(scene)
}

/// Four round towers with cones, walls with battlements between them, and a keep.
pub(super) fn castle() -> Result<Scene, ModelError> {
    let mut scene =
        stage(7.0, DVec3::new(5.0, 6.0, 3.0), [DVec3::new(3.0, 5.2, 8.0), DVec3::new(0.0, 0.6, 0.0)])?;
    let stone = Vec3::new(0.62, 0.58, 0.52);
    for (x, z) in [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)] {
        let place = DVec3::new(x, 0.0, z);
        add_at(&mut scene, shapes::cylinder(0.5, 1.8, 16, Ends::Closed).named("tower"), matt(stone), place)?;
        let roof = shapes::cone(0.6, 0.9, 16, Ends::Closed).named("roof");
        add_at(&mut scene, roof, matt(Vec3::new(0.5, 0.2, 0.15)), place + DVec3::Y * 1.8)?;
    }
    for along_x in [true, false] {
        for side in [-2.0_f32, 2.0] {
            let bar = |from: f32, to: f32, bottom: f32, top: f32, half: f32| {
                if along_x {
                    block([from, bottom, side - half], [to, top, side + half])
                } else {
                    block([side - half, bottom, from], [side + half, top, to])
                }
            };
            add(&mut scene, bar(-1.6, 1.6, 0.0, 1.1, 0.15).named("wall"), matt(stone))?;
            for number in 0..8 {
                let from = -1.5 + 0.4 * number as f32;
                add(&mut scene, bar(from, from + 0.2, 1.1, 1.3, 0.15).named("merlon"), matt(stone))?;
            }
        }
    }
    add(&mut scene, block([-0.6, 0.0, -0.6], [0.6, 2.4, 0.6]).named("keep"), matt(stone))?;
    for number in 0..16 {
        let (side, place) = (number / 4, -0.6 + 0.32 * (number % 4) as f32);
        let [x, z] = match side {
            0 => [place, -0.6],
            1 => [0.4, place],
            2 => [place, 0.4],
            _ => [-0.6, place],
        };
        add(&mut scene, block([x, 2.4, z], [x + 0.2, 2.6, z + 0.2]).named("merlon"), matt(stone))?;
    }
    Ok(scene)
}

/// Ten bowling pins and a ball.
pub(super) fn strike() -> Result<Scene, ModelError> {
    strike_seen([DVec3::new(1.2, 1.4, 3.0), DVec3::new(0.0, 0.3, -0.2)])
}

/// The same from an eye towards a target.
pub(super) fn strike_seen(view: [DVec3; 2]) -> Result<Scene, ModelError> {
    let mut scene = stage(4.0, DVec3::new(-2.0, 3.0, 2.2), view)?;
    let profile = [
        (0.0, 0.0),
        (0.1, 0.0),
        (0.16, 0.15),
        (0.19, 0.32),
        (0.16, 0.5),
        (0.085, 0.75),
        (0.075, 0.85),
        (0.1, 0.98),
        (0.085, 1.08),
        (0.0, 1.13),
    ];
    let profile: Vec<Vec2> = profile.iter().map(|(x, y)| Vec2::new(*x, *y) * 0.8).collect();
    for row in 0..4 {
        for column in 0..=row {
            let x = (f64::from(column) - 0.5 * f64::from(row)) * 0.55;
            let place = DVec3::new(x, 0.0, -0.45 * f64::from(row));
            add_at(
                &mut scene,
                shapes::lathe(&profile, 28).named("pin"),
                matt(Vec3::new(0.9, 0.88, 0.82)),
                place,
            )?;
        }
    }
    let ball = shapes::icosphere(0.3, 3).named("ball");
    add_at(&mut scene, ball, matt(Vec3::new(0.15, 0.2, 0.5)), DVec3::new(0.35, 0.3, 1.0))?;
    Ok(scene)
}
