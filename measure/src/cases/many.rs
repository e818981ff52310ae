//! Many of something: vertices, instances, lights.

use glam::{DAffine3, DQuat, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{quad, sheet, torus_knot};

use super::stage::{Stage, at, block, p, v};

pub(super) fn index_65536() -> Vec<Stage> {
    // Vertices no triangle uses push the box's indices beyond 16 bits; truncated, they would all name one corner.
    let mut padded = block(v(0.0, 1.0, 0.0), v(0.5, 0.5, 0.5)).named("padded box");
    let padding = 65_600;
    let pad = |stream: &mut Vec<Vec3>| {
        let first = stream[0];
        stream.splice(0..0, std::iter::repeat_n(first, padding as usize));
    };
    pad(&mut padded.positions);
    pad(&mut padded.normals);
    padded.uvs.clear();
    padded.indices.iter_mut().for_each(|index| *index += padding);
    let waves = sheet(260, 252, |u, v| {
        let (x, z) = (u * 2.0 - 1.0, 1.0 - v * 2.0);
        Vec3::new(x, 1.0 + 0.15 * (7.0 * x).sin() * (5.0 * z).cos(), z)
    });
    vec![
        Stage::new("padded")
            .floor()
            .caster(padded)
            .point(p(-1.0, 4.0, 1.0))
            .dark(&[p(0.4, 0.0, -0.4)])
            .lit(&[p(-1.5, 0.0, 1.5)]),
        Stage::new("sheet").floor().caster(waves).point(p(-1.0, 4.0, 1.0)).dark(&[p(0.9, 0.0, -0.5)]),
    ]
}

pub(super) fn instanced_1000() -> Vec<Stage> {
    let places = |i: u32| {
        let (x, y, z) = (f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100));
        let turn = DQuat::from_rotation_y(f64::from(i) * 0.7);
        let shift = p(x * 0.25 - 1.125, y * 0.2 + 0.3, z * 0.25 - 1.125);
        DAffine3::from_rotation_translation(turn, shift)
    };
    let leaf = quad([v(-0.06, 0.0, 0.06), v(0.06, 0.0, 0.06), v(0.06, 0.03, -0.06), v(-0.06, 0.03, -0.06)]);
    vec![
        Stage::new("closed")
            .floor()
            .instances(block(v(0.0, 0.0, 0.0), v(0.05, 0.05, 0.05)), (0..1000).map(places))
            .point(p(-1.0, 6.0, 1.5)),
        Stage::new("open").floor().instances(leaf, (0..1000).map(places)).point(p(-1.0, 6.0, 1.5)),
    ]
}

fn lights(count: u32) -> Vec<Stage> {
    // All three kinds in turn, on a spiral above an open and a closed caster.
    let mut stage = Stage::new("")
        .floor()
        .caster(block(v(0.6, 0.8, 0.0), v(0.3, 0.3, 0.3)))
        .caster_at(torus_knot([2, 3], 0.3, 0.08, [48, 6]), at(-0.6, 0.9, 0.3))
        .caster(open_leaf());
    for i in 0..count {
        let angle = f64::from(i) * 2.4;
        let reach = 0.8 + 2.0 * f64::from(i) / f64::from(count);
        let place = p(reach * angle.cos(), 3.0, reach * angle.sin());
        stage = match i % 3 {
            0 => stage.point(place),
            1 => stage.sun(-place),
            _ => stage.spot(place, p(0.0, 0.5, 0.0), 0.5),
        };
    }
    vec![stage]
}

fn open_leaf() -> MeshData {
    quad([v(-0.3, 0.4, 1.2), v(0.3, 0.4, 1.2), v(0.3, 0.7, 0.7), v(-0.3, 0.7, 0.7)])
}

pub(super) fn lights_1() -> Vec<Stage> {
    lights(1)
}

pub(super) fn lights_4() -> Vec<Stage> {
    lights(4)
}

pub(super) fn lights_16() -> Vec<Stage> {
    lights(16)
}

pub(super) fn lights_64() -> Vec<Stage> {
    lights(64)
}
