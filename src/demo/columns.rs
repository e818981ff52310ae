//! A colonnade in low sun: fluted columns, steps and a roof beam, banners and a broken drum; shadows many times as
//! long as their casters.

use std::f32::consts::TAU;

use glam::{DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, extruded, frustum, lathe, plane, sheet};
use shadowgraph_engine::scene::{Camera, Light, Scene, ShadowNode, placed};

use super::set::{Set, slab, stand};

/// A fluted shaft: a prism over a scalloped circle, standing on the origin; closed.
fn shaft(radius: f32, height: f32) -> MeshData {
    const FLUTES: u32 = 20;
    let outline: Vec<Vec2> = (0..FLUTES * 4)
        .map(|i| {
            let angle = TAU * i as f32 / (FLUTES * 4) as f32;
            Vec2::from_angle(angle) * radius * [1.0, 0.94, 0.92, 0.94][i as usize % 4]
        })
        .collect();
    let upright = placed(DVec3::ZERO, DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2), DVec3::ONE);
    extruded(&outline, 0.0, height).transformed(&upright)
}

/// Base, shaft and capital as one mesh of closed pieces.
fn column(height: f32) -> MeshData {
    let torus = [[0.0, 0.14], [0.36, 0.14], [0.4, 0.18], [0.4, 0.24], [0.34, 0.28], [0.0, 0.28]];
    let echinus = height - 0.4;
    MeshData::merged(
        "column",
        [
            slab([-0.42, 0.0, -0.42], [0.42, 0.14, 0.42]),
            lathe(&torus.map(Vec2::from), 32),
            shaft(0.3, height - 0.68).moved(Vec3::Y * 0.28),
            frustum(0.29, 0.42, 0.22, 32, Ends::Closed).moved(Vec3::Y * echinus),
            slab([-0.45, height - 0.18, -0.45], [0.45, height, 0.45]),
        ],
    )
}

/// A bowl on three legs.
fn tripod() -> MeshData {
    let bowl = [[0.0, 0.9], [0.18, 0.93], [0.32, 1.05], [0.38, 1.22]];
    let leg = |turn: f64| {
        let lean =
            placed(DVec3::ZERO, DQuat::from_rotation_y(turn) * DQuat::from_rotation_z(0.16), DVec3::ONE);
        frustum(0.02, 0.02, 1.0, 8, Ends::Closed).moved(Vec3::X * 0.36).transformed(&lean)
    };
    MeshData::merged("tripod", [lathe(&bowl.map(Vec2::from), 32), leg(0.0), leg(2.094), leg(4.189)])
}

pub(super) fn columns() -> Scene {
    let mut set = Set::new();
    let temple = set.scene.add_group("temple");
    let sand = set.paint("sand", [0.56, 0.44, 0.3], 0.95);
    let stone = set.paint("limestone", [0.74, 0.68, 0.57], 0.85);
    let cloth = set.paint("banner", [0.42, 0.06, 0.05], 0.9);
    let bronze = set.metal("bronze", [0.55, 0.36, 0.18], 0.45);
    set.put(temple, "ground", plane(Vec2::splat(40.0)), sand, stand(0.0, 0.0, 0.0, 0.0));
    for (i, inset) in [0.0_f32, 0.35, 0.7].into_iter().enumerate() {
        let (foot, head) = (i as f32 * 0.18, (i + 1) as f32 * 0.18);
        let step = slab([-7.7 + inset, foot, -3.2 + inset], [7.7 - inset, head, 1.5 - inset]);
        set.put(temple, "step", step, stone, stand(0.0, 0.0, 0.0, 0.0));
    }
    let pillar = set.shape(column(3.6));
    for row in 0..2 {
        for i in 0..7 {
            let (x, z) = (f64::from(i) * 2.1 - 6.3, if row == 0 { 0.3 } else { -2.0 });
            // Two of the front row have fallen.
            if row == 0 && (i == 2 || i == 5) {
                continue;
            }
            set.place(temple, "column", pillar, stone, stand(x, 0.54, z, 0.0));
        }
    }
    let beam = slab([-6.8, 4.14, -2.45], [6.8, 4.6, -1.55]);
    set.put(temple, "architrave", beam, stone, stand(0.0, 0.0, 0.0, 0.0));

    let stump = set.shape(shaft(0.3, 0.9).named("stump"));
    set.place(temple, "stump", stump, stone, stand(-2.1, 0.54, 0.3, 0.0));
    let fallen = placed(
        DVec3::new(5.4, 0.4, 3.3),
        DQuat::from_rotation_y(-0.2) * DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
        DVec3::ONE,
    );
    set.place(temple, "fallen column", pillar, stone, fallen);

    // Open casters: banners between columns, and bowls on tripods.
    let banner = sheet(10, 12, |u, v| {
        let sway = 0.12 * (u * TAU * 1.3).sin() * (1.0 - v) + 0.05 * (v * 7.0).sin();
        Vec3::new((u - 0.5) * 1.1, (v - 1.0) * 2.2, sway)
    });
    let banner = set.shape(banner.named("banner"));
    for (i, x) in [-5.25, -3.15, 1.05, 3.15].into_iter().enumerate() {
        set.place(temple, "banner", banner, cloth, stand(x, 4.14, -2.0, f64::from(i as u32 % 2) * 180.0));
    }
    let tripod = set.shape(tripod());
    for (x, z) in [(0.6, 2.6), (-4.4, 2.8)] {
        set.place(temple, "tripod", tripod, bronze, stand(x, 0.0, z, 20.0));
    }

    let sun = Light::directional("sun", 4.0).with_color(Vec3::new(1.0, 0.74, 0.45));
    set.scene.add_light(sun, DVec3::ZERO, DVec3::new(-0.88, -0.25, 0.26));
    let sky = Light::directional("sky", 0.35).with_color(Vec3::new(0.45, 0.62, 1.0));
    set.scene.add_light(sky, DVec3::ZERO, DVec3::new(0.4, -1.0, -0.6));
    set.scene.set_background(Vec3::new(0.2, 0.33, 0.52));
    set.scene.set_ambient(Vec3::new(0.075, 0.09, 0.12));
    set.scene.add_camera(
        Camera::perspective("main", 0.7),
        DVec3::new(8.6, 2.5, 8.8),
        DVec3::new(0.2, 1.35, -0.2),
    );
    set.scene.add_shadow("shadows", ShadowNode::new("ShadowVolumeHard"));
    set.scene
}
