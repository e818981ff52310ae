//! Stretched triangles, cracked meshes and receivers thinner than a pixel: what terrain, roads and dense models are made of.

use glam::{DAffine3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{icosphere, sheet, torus_knot};

use super::stage::{Stage, at, block, p, triangles, v};

/// A furrow of two strips a metre wide each and `half_m` long to either side: its banks rise by 0.3 m.
fn furrow(half_m: f32, from_m: f32) -> MeshData {
    let [x0, x1] = [from_m - half_m, from_m + half_m];
    let corners = [
        v(x0, 0.3, 3.0),
        v(x1, 0.3, 3.0),
        v(x1, 0.0, 4.0),
        v(x0, 0.0, 4.0),
        v(x1, 0.3, 5.0),
        v(x0, 0.3, 5.0),
    ];
    triangles("furrow", &corners, &[0, 1, 2, 0, 2, 3, 3, 2, 4, 3, 4, 5]).flipped()
}

/// An eye that looks along what is stretched.
fn along(name: &str) -> Stage {
    Stage::small(name).eye(p(0.0, 2.0, 0.0), p(50.0, 0.0, 40.0)).lens(60.0, 0.1).size(80, 45)
}

/// Furrows so long: as they lie, turned in their vertices and by a node, and from near their end with a box on them.
fn furrows(half_m: f32) -> Vec<Stage> {
    let turn = DAffine3::from_rotation_y(-0.5);
    // Light that comes at 11° from the side leaves the bank it meets first behind it in shadow.
    let across = |stage: Stage| stage.sun(p(0.1, -0.2, 1.0));
    let end = along("from-its-end")
        .caster(furrow(half_m, half_m - 20.0))
        .caster(block(v(12.0, 0.6, 4.0), v(0.4, 0.5, 0.4)));
    vec![
        across(along("straight").caster(furrow(half_m, 0.0))),
        across(along("turned").caster(furrow(half_m, 0.0).transformed(&turn))),
        across(along("turned-by-node").caster_at(furrow(half_m, 0.0), turn)),
        across(end),
        along("lamp")
            .caster(furrow(half_m, 0.0))
            .caster(block(v(12.0, 0.6, 4.0), v(0.4, 0.5, 0.4)))
            .point(p(13.0, 3.0, 5.5))
            .radius(0.3),
    ]
}

pub(super) fn strip_500m() -> Vec<Stage> {
    furrows(250.0)
}

pub(super) fn strip_5km() -> Vec<Stage> {
    furrows(2500.0)
}

pub(super) fn road_50km() -> Vec<Stage> {
    // A road, flat, with a car on it and a cable over it.
    let road = || {
        let at = |s: f32, t: f32| v((s - 0.5) * 50_000.0, 0.0, 6.0 - 4.0 * t);
        sheet(1, 2, at).named("road")
    };
    let cable = |y: f32| {
        let at = |s: f32, t: f32| v((s - 0.5) * 50_000.0, y + 0.02 * t, 4.5);
        sheet(1, 1, at).named("cable")
    };
    let car = || block(v(9.0, 0.5, 4.0), v(1.0, 0.5, 0.5)).named("car");
    let stage = |name: &str| along(name).caster(road()).caster(car());
    let turn = DAffine3::from_rotation_y(-0.4);
    vec![
        stage("sun").sun(p(-0.3, -0.6, -1.0)).dark(&[p(8.9, 0.0, 3.0)]).lit(&[p(12.0, 0.0, 4.0)]),
        stage("cable").caster(cable(3.0)).sun(p(0.3, -2.0, -0.3)),
        stage("lamp").point(p(7.0, 3.0, 2.0)).radius(0.3).lit(&[p(12.0, 0.0, 3.0)]),
        along("turned-by-node").caster_at(road(), turn).caster_at(car(), turn).sun(p(0.3, -0.6, 1.0)),
    ]
}

pub(super) fn stretched_at_grazing() -> Vec<Stage> {
    // A needle of a plank over a floor, hundreds of times as long as it is wide, seen from a hand's breadth above.
    let plank = |length: f32, slope: f32| {
        let at = |s: f32, t: f32| v((s - 0.3) * length, 0.4 + slope * (s - 0.3), 0.1 - 0.3 * t);
        sheet(1, 1, at).named("plank")
    };
    let low = |name: &str| {
        Stage::small(name).floor().eye(p(-3.5, 0.15, 1.2), p(0.5, 0.0, -0.4)).lens(40.0, 0.05).size(80, 45)
    };
    vec![
        low("sun-2-m").caster(plank(2.0, 0.3)).sun(p(-0.2, -1.0, 0.4)),
        low("sun-200-m").caster(plank(200.0, 2.0)).sun(p(-0.2, -1.0, 0.4)),
        low("lamp-200-m").caster(plank(200.0, 1.0)).point(p(0.5, 2.0, -0.6)).radius(0.2),
        // The eye is a few millimetres above the plank's own plane.
        low("along-the-plank")
            .caster(plank(200.0, 0.0))
            .point(p(0.5, 2.0, -0.6))
            .eye(p(-3.5, 0.405, 0.3), p(1.0, 0.2, -0.3)),
    ]
}

/// No two triangles share a vertex, and every corner is moved by up to 2 µm to each side: by a number made of its place in
/// the list, the same at every run.
fn cracked(data: &MeshData) -> MeshData {
    let mut state = 12_345_u32;
    let mut jitter = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        ((state >> 8) as f32 / 8_388_608.0 - 1.0) * 2e-6
    };
    let corners: Vec<Vec3> = data
        .indices
        .iter()
        .map(|vertex| data.positions[*vertex as usize] + Vec3::new(jitter(), jitter(), jitter()))
        .collect();
    let indices: Vec<u32> = (0..corners.len() as u32).collect();
    triangles("cracked", &corners, &indices)
}

pub(super) fn cracked_2e_6() -> Vec<Stage> {
    let knot = || cracked(&torus_knot([2, 3], 0.5, 0.15, [48, 8]));
    let ball = || cracked(&icosphere(0.7, 2));
    let up = at(0.0, 1.2, 0.0);
    let lamp = p(-1.0, 4.0, 1.0);
    let stage = |name: &str| Stage::small(name).floor().size(96, 72);
    vec![
        stage("knot-lamp").caster_at(knot(), up).point(lamp),
        stage("knot-sun").caster_at(knot(), up).sun(p(0.5, -1.0, 0.3)),
        stage("ball-lamp").caster_at(ball(), up).point(lamp).dark(&[p(0.3, 0.0, -0.3)]),
        stage("ball-ortho")
            .caster_at(ball(), up)
            .sun(p(0.5, -1.0, 0.3))
            .ortho(2.2, 0.1, 30.0)
            .dark(&[p(0.6, 0.0, 0.3)]),
        // The floor is cracked as well.
        Stage::small("grid-of-floors")
            .size(96, 72)
            .caster(cracked(&sheet(6, 6, |s, t| v(s * 8.0 - 4.0, 0.0, 4.0 - t * 8.0))))
            .caster(cracked(&block(v(0.0, 1.2, 0.0), v(0.5, 0.5, 0.5))))
            .point(lamp)
            .dark(&[p(0.4, 0.0, -0.4)])
            .lit(&[p(-1.4, 0.0, 1.7)]),
    ]
}

pub(super) fn thin_receiver() -> Vec<Stage> {
    // Slats a third of a pixel wide and less: their corners, drawn at 1/256 pixel, tilt them.
    let slats = |width: f32, lean: f32| {
        let slat = |i: u32| {
            let x = -1.6 + 0.08 * i as f32;
            let at =
                |s: f32, t: f32| v(x + width * s + lean * t, 0.05 + 0.9 * t, 1.0 - 0.6 * s * width - 0.3 * t);
            sheet(1, 1, at)
        };
        MeshData::merged("slats", (0..40).map(slat))
    };
    let stage = |name: &str| Stage::small(name).floor().caster(block(v(0.0, 1.6, 0.3), v(0.5, 0.2, 0.5)));
    vec![
        stage("slats-lamp").caster(slats(0.02, 0.0)).point(p(-1.0, 4.0, 1.0)),
        stage("slats-sun").caster(slats(0.008, 0.3)).sun(p(0.3, -1.0, 0.2)),
        stage("slats-ortho").caster(slats(0.02, 0.2)).sun(p(0.3, -1.0, 0.2)).ortho(2.2, 0.1, 30.0),
        // Dense for so few pixels, as models seen from afar are.
        stage("knot")
            .caster_at(torus_knot([2, 3], 0.3, 0.08, [96, 12]), at(0.2, 0.6, 0.9))
            .point(p(-1.0, 4.0, 1.0)),
        stage("grazing-floor")
            .caster(sheet(40, 40, |s, t| {
                let xz = Vec2::new(s * 3.0 - 1.5, 2.0 - t * 3.0);
                v(xz.x, 0.03 + 0.02 * (xz.x * 9.0).sin() * (xz.y * 7.0).cos(), xz.y)
            }))
            .sun(p(0.3, -1.0, 0.2))
            .eye(p(-3.0, 0.3, 3.0), p(0.0, 0.1, 0.0)),
    ]
}
