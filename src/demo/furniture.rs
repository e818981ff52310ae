//! Furniture from boxes, lathes and sheets; each piece stands on the origin and faces +z.

use std::f32::consts::TAU;

use glam::{DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cylinder, extruded, frustum, lathe, quad, sheet};
use shadowgraph_engine::scene::placed;

use shadowgraph_measure::cases::strewn::noise;

use super::set::{slab, slabs};

/// A table: top, aprons and tapering legs.
pub(super) fn table(half_x: f32, half_z: f32, height: f32) -> MeshData {
    let (x, z) = (half_x - 0.07, half_z - 0.07);
    let leg = |sx: f32, sz: f32| {
        frustum(0.022, 0.034, height - 0.035, 12, Ends::Closed).moved(Vec3::new(sx * x, 0.0, sz * z))
    };
    let (low, high) = (height - 0.11, height - 0.035);
    MeshData::merged(
        "table",
        [
            slab([-half_x, height - 0.035, -half_z], [half_x, height, half_z]),
            slab([-x, low, z - 0.01], [x, high, z + 0.01]),
            slab([-x, low, -z - 0.01], [x, high, -z + 0.01]),
            slab([x - 0.01, low, -z], [x + 0.01, high, z]),
            slab([-x - 0.01, low, -z], [-x + 0.01, high, z]),
            leg(1.0, 1.0),
            leg(-1.0, 1.0),
            leg(1.0, -1.0),
            leg(-1.0, -1.0),
        ],
    )
}

/// A chair with a back of thin rods, which throw the finest shadows of the room.
pub(super) fn chair() -> MeshData {
    let rod = |x: f32, z: f32, foot: f32, height: f32, radius: f32, lean: f64| {
        let turn = placed(
            DVec3::new(f64::from(x), f64::from(foot), f64::from(z)),
            DQuat::from_rotation_x(lean),
            DVec3::ONE,
        );
        cylinder(radius, height, 10, Ends::Closed).transformed(&turn)
    };
    let mut parts = vec![slab([-0.21, 0.43, -0.21], [0.21, 0.465, 0.22])];
    parts.extend(
        [(-0.18, 0.19), (0.18, 0.19), (-0.18, -0.18), (0.18, -0.18)]
            .map(|(x, z)| rod(x, z, 0.0, 0.44, 0.016, 0.0)),
    );
    parts.extend((0..7).map(|i| {
        rod((i as f32 - 3.0) * 0.06, -0.19, 0.46, 0.42, if i % 6 == 0 { 0.014 } else { 0.008 }, -0.16)
    }));
    let rail: Vec<Vec2> =
        [[-0.23, 0.0], [0.23, 0.0], [0.22, 0.075], [0.0, 0.095], [-0.22, 0.075]].map(Vec2::from).to_vec();
    parts.push(extruded(&rail, -0.011, 0.011).moved(Vec3::new(0.0, 0.85, -0.262)));
    MeshData::merged("chair", parts)
}

/// The upholstery of an armchair, from profiles with rounded corners.
pub(super) fn armchair() -> MeshData {
    let round = |x: [f32; 2], y: [f32; 2], r: f32, z: [f32; 2]| {
        let corners = [
            (x[1] - r, y[0] + r, -0.25),
            (x[1] - r, y[1] - r, 0.0),
            (x[0] + r, y[1] - r, 0.25),
            (x[0] + r, y[0] + r, 0.5),
        ];
        let outline: Vec<Vec2> = corners
            .iter()
            .flat_map(|&(cx, cy, start)| {
                (0..=6).map(move |i| {
                    Vec2::new(cx, cy) + Vec2::from_angle(TAU * (start + 0.25 * i as f32 / 6.0)) * r
                })
            })
            .collect();
        extruded(&outline, z[0], z[1])
    };
    let back = round([-0.3, 0.3], [0.0, 0.56], 0.09, [-0.09, 0.09]);
    let lean = placed(DVec3::new(0.0, 0.36, -0.27), DQuat::from_rotation_x(-0.2), DVec3::ONE);
    MeshData::merged(
        "armchair",
        [
            round([-0.31, 0.31], [0.16, 0.32], 0.05, [-0.34, 0.36]),
            round([-0.29, 0.29], [0.32, 0.45], 0.055, [-0.24, 0.38]),
            round([-0.44, -0.3], [0.16, 0.6], 0.065, [-0.38, 0.36]),
            round([0.3, 0.44], [0.16, 0.6], 0.065, [-0.38, 0.36]),
            back.transformed(&lean),
        ],
    )
}

/// Four short legs for an armchair or a sideboard.
pub(super) fn feet(half_x: f32, half_z: f32, height: f32) -> MeshData {
    let foot = |x: f32, z: f32| {
        frustum(0.014, 0.022, height, 12, Ends::Closed).moved(Vec3::new(x * half_x, 0.0, z * half_z))
    };
    MeshData::merged("feet", [foot(1.0, 1.0), foot(-1.0, 1.0), foot(1.0, -1.0), foot(-1.0, -1.0)])
}

/// A sideboard with three drawers, without its feet.
pub(super) fn sideboard(half_x: f32, depth: f32, foot: f32, height: f32) -> MeshData {
    let mut boxes = vec![([-half_x, foot, 0.0], [half_x, height, depth - 0.02])];
    let third = half_x * 2.0 / 3.0;
    for i in 0..3 {
        let left = -half_x + third * i as f32;
        boxes
            .push(([left + 0.012, foot + 0.015, depth - 0.02], [left + third - 0.012, height - 0.03, depth]));
    }
    boxes.push(([-half_x - 0.015, height, 0.0], [half_x + 0.015, height + 0.022, depth + 0.015]));
    slabs("sideboard", &boxes)
}

/// A bookcase of single sheets without thickness: inside it up to four quads share an edge, and it has no inside.
pub(super) fn shelf(half_x: f32, depth: f32, shelves: u32, pitch: f32) -> MeshData {
    let cells = 3;
    let width = half_x * 2.0 / cells as f32;
    let sheet = |a: Vec3, b: Vec3| {
        let into = Vec3::Z * depth;
        quad([a, b, b + into, a + into])
    };
    let mut parts = Vec::new();
    for column in 0..=cells {
        for row in 0..shelves {
            let (x, y) = (-half_x + width * column as f32, row as f32 * pitch);
            parts.push(sheet(Vec3::new(x, y, 0.0), Vec3::new(x, y + pitch, 0.0)));
        }
    }
    for row in 0..=shelves {
        for column in 0..cells {
            let (x, y) = (-half_x + width * column as f32, row as f32 * pitch);
            parts.push(sheet(Vec3::new(x, y, 0.0), Vec3::new(x + width, y, 0.0)));
        }
    }
    MeshData::merged("shelf", parts)
}

/// Books side by side between two x, standing on height 0 with their backs at `depth`; `tone` picks which of three
/// sets of books is returned, so that each set can have its colour.
pub(super) fn books(from_x: f32, to_x: f32, depth: f32, seed: u32, tone: u32) -> MeshData {
    let mut parts = Vec::new();
    let (mut x, mut i) = (from_x, seed * 64);
    loop {
        let (width, height) = (0.018 + 0.028 * noise(i), 0.19 + 0.07 * noise(i + 7));
        if x + width > to_x {
            break;
        }
        if (noise(i + 13) * 3.0) as u32 == tone {
            parts.push(slab([x, 0.001, 0.02], [x + width - 0.002, height, depth - 0.05 * noise(i + 29)]));
        }
        x += width;
        i += 1;
    }
    MeshData::merged("books", parts)
}

/// A picture frame around a canvas of this size, hanging in the plane z = 0.
pub(super) fn frame(half_x: f32, half_y: f32, bar: f32) -> MeshData {
    let (x, y) = (half_x + bar, half_y + bar);
    slabs(
        "frame",
        &[
            ([-x, half_y, 0.0], [x, y, 0.03]),
            ([-x, -y, 0.0], [x, -half_y, 0.03]),
            ([-x, -half_y, 0.0], [-half_x, half_y, 0.03]),
            ([half_x, -half_y, 0.0], [x, half_y, 0.03]),
        ],
    )
}

/// A curtain: one sheet in folds, `width` along x, hanging down from `height`.
pub(super) fn curtain(width: f32, height: f32) -> MeshData {
    let folds = (width * 9.0).round();
    sheet(96, 6, |u, v| {
        let sway = (u * TAU * folds).sin() * (0.035 + 0.02 * (1.0 - v)) + 0.01 * (u * 17.0 + v * 4.0).sin();
        Vec3::new((u - 0.5) * width, 0.03 + v * (height - 0.03), sway)
    })
}

/// The open shade of a lamp: a band of a cone.
pub(super) fn shade(bottom: f32, top: f32, height: f32) -> MeshData {
    frustum(bottom, top, height, 48, Ends::Open)
}

/// A vase with a wall of no thickness and an open mouth.
pub(super) fn vase(scale: f32) -> MeshData {
    let profile = [
        [0.0, 0.0],
        [0.05, 0.0],
        [0.085, 0.06],
        [0.09, 0.11],
        [0.065, 0.19],
        [0.032, 0.25],
        [0.034, 0.29],
        [0.045, 0.315],
    ];
    lathe(&smoothed(&profile.map(|p| Vec2::from(p) * scale)), 40)
}

/// A shallow bowl, open.
pub(super) fn bowl(radius: f32) -> MeshData {
    let profile = [[0.0, 0.0], [0.4, 0.0], [0.75, 0.14], [0.95, 0.32], [1.0, 0.45]];
    lathe(&smoothed(&profile.map(|p| Vec2::from(p) * radius)), 48)
}

/// A profile with its corners cut twice (Chaikin), ends kept.
pub(super) fn smoothed(profile: &[Vec2]) -> Vec<Vec2> {
    let cut = |points: Vec<Vec2>| {
        let mut finer = vec![points[0]];
        for pair in points.windows(2) {
            finer.extend([pair[0].lerp(pair[1], 0.25), pair[0].lerp(pair[1], 0.75)]);
        }
        finer.push(points[points.len() - 1]);
        finer
    };
    cut(cut(profile.to_vec()))
}
