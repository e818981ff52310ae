//! How a mesh hangs together: open, closed, non-manifold, inside out, split by material, nested.

use std::f32::consts::TAU;

use glam::{DQuat, DVec3, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cylinder, icosphere, quad, sheet, uv_sphere};
use shadowgraph_engine::scene::{Material, placed};

use super::lights::open_block;
use super::stage::{Stage, at, block, p, triangles, v};

pub(super) fn fins() -> Vec<Stage> {
    let fan = |count: u32| {
        // All blades share the edge from (0, 1.3, −0.6) to (0, 1.3, 0.6), in alternating winding.
        let mut positions = vec![v(0.0, 1.3, -0.6), v(0.0, 1.3, 0.6)];
        let mut indices = Vec::new();
        for i in 0..count {
            let angle = TAU * (i as f32 + 0.2) / count as f32;
            positions.push(v(0.8 * angle.cos(), 1.3 + 0.8 * angle.sin(), 0.1 * i as f32));
            indices.extend(if i % 2 == 0 { [0, 1, i + 2] } else { [1, 0, i + 2] });
        }
        triangles("fins", &positions, &indices)
    };
    (3..=5)
        .map(|count| Stage::new(format!("{count}")).floor().caster(fan(count)).point(p(0.6, 4.0, 0.3)))
        .chain([Stage::new("5-sun").floor().caster(fan(5)).sun(p(-0.4, -1.0, -0.2))])
        .collect()
}

pub(super) fn two_cubes_one_edge() -> Vec<Stage> {
    let pair = || {
        let upper = block(v(0.35, 1.75, 0.0), v(0.35, 0.35, 0.5));
        MeshData::merged("cubes", [upper, block(v(-0.35, 1.05, 0.0), v(0.35, 0.35, 0.5))])
    };
    vec![
        Stage::new("lamp").floor().caster(pair()).point(p(0.5, 5.0, 0.8)),
        // The sun shines exactly through the common edge, where the cubes' other faces meet its plane.
        Stage::new("sun-through-edge")
            .floor()
            .caster(pair())
            .sun(p(1.0, -1.0, 0.0))
            .eye(p(3.0, 4.0, 6.0), p(1.0, 0.5, 0.0)),
    ]
}

pub(super) fn inconsistent_winding() -> Vec<Stage> {
    let mixed = |data: MeshData, every: usize| {
        let mut mixed = data.named("mixed");
        for corners in mixed.indices.chunks_exact_mut(3).step_by(every) {
            corners.swap(1, 2);
        }
        mixed
    };
    vec![
        Stage::new("box")
            .floor()
            .caster(mixed(block(v(0.0, 1.2, 0.0), v(0.5, 0.5, 0.5)), 3))
            .point(p(-1.0, 4.0, 1.0))
            .dark(&[p(0.3, 0.0, -0.3)])
            .lit(&[p(-1.5, 0.0, 1.5)]),
        Stage::new("sphere")
            .floor()
            .caster_at(mixed(icosphere(0.6, 2), 2), at(0.0, 1.2, 0.0))
            .point(p(-1.0, 4.0, 1.0))
            .dark(&[p(0.4, 0.0, -0.4)]),
        Stage::new("patch")
            .floor()
            .caster_at(
                mixed(sheet(6, 6, |u, v| Vec3::new(u, 0.2 * (u * 5.0).sin(), -v)), 2),
                at(-0.5, 1.2, 0.5),
            )
            .sun(p(0.3, -1.0, -0.2))
            .dark(&[p(0.4, 0.0, -0.3)]),
    ]
}

pub(super) fn moebius() -> Vec<Stage> {
    const COLUMNS: u32 = 48;
    const ROWS: u32 = 3;
    // The strip's last column is its first one upside down, by index: the seam is welded and has no orientation.
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for column in 0..COLUMNS {
        let angle = TAU * column as f32 / COLUMNS as f32;
        for row in 0..=ROWS {
            let across = (row as f32 / ROWS as f32 - 0.5) * 0.7;
            let r = 0.8 + across * (angle * 0.5).cos();
            positions.push(Vec3::new(r * angle.cos(), across * (angle * 0.5).sin(), r * angle.sin()));
        }
    }
    let index = |column: u32, row: u32| {
        if column == COLUMNS { ROWS - row } else { column * (ROWS + 1) + row }
    };
    for column in 0..COLUMNS {
        for row in 0..ROWS {
            let [a, b] = [index(column, row), index(column + 1, row)];
            let [c, d] = [index(column + 1, row + 1), index(column, row + 1)];
            indices.extend([a, b, c, a, c, d]);
        }
    }
    let strip = triangles("moebius", &positions, &indices);
    vec![
        Stage::new("lamp").floor().caster_at(strip.clone(), at(0.0, 1.2, 0.0)).point(p(0.5, 4.0, 0.5)),
        Stage::new("sun").floor().caster_at(strip, at(0.0, 1.2, 0.0)).sun(p(0.5, -1.0, 0.3)),
    ]
}

pub(super) fn single_quad() -> Vec<Stage> {
    let leaf = || quad([v(-0.5, 1.2, 0.5), v(0.5, 1.2, 0.5), v(0.5, 1.2, -0.5), v(-0.5, 1.2, -0.5)]);
    let board = || quad([v(-0.6, 0.3, 0.0), v(0.6, 0.3, 0.0), v(0.6, 1.5, 0.0), v(-0.6, 1.5, 0.0)]);
    let lamp = |name: &str, data: MeshData| Stage::new(name).floor().caster(data).point(p(0.0, 4.0, 0.0));
    let lying = |stage: Stage| stage.dark(&[p(0.5, 0.0, 0.3)]).lit(&[p(0.9, 0.0, 0.0), p(0.2, 1.2, 0.0)]);
    vec![
        lying(lamp("up", leaf())),
        lying(lamp("down", leaf().flipped())),
        // An upright board between eye and lamp: its visible side is turned away and dark.
        Stage::new("board-from-behind")
            .floor()
            .caster(board())
            .point(p(0.0, 2.0, -3.0))
            .dark(&[p(0.0, 0.9, 0.0), p(0.0, 0.0, 0.9)])
            .lit(&[p(-1.5, 0.0, 0.0)]),
        Stage::new("board-from-front")
            .floor()
            .caster(board())
            .point(p(0.0, 2.0, 3.0))
            .lit(&[p(0.0, 0.9, 0.0), p(0.0, 0.0, 0.5)])
            .eye(p(1.0, 3.0, 6.0), p(0.0, 0.5, 0.0)),
    ]
}

pub(super) fn open_cylinder() -> Vec<Stage> {
    let can = |ends: Ends| cylinder(0.5, 1.0, 32, ends);
    let stage = |name: &str, ends: Ends, height: f64| {
        Stage::new(name).floor().caster_at(can(ends), at(0.0, height, 0.0)).point(p(-2.5, 2.5, 1.0))
    };
    vec![
        stage("floating", Ends::Top, 0.5).dark(&[p(0.6, 0.0, -0.3)]).lit(&[p(-1.0, 0.0, 0.0)]),
        stage("standing", Ends::Top, 0.0).dark(&[p(0.9, 0.0, -0.4)]),
        stage("open-both", Ends::Open, 0.5).dark(&[p(0.9, 0.0, -0.4)]),
        // Light falls in through the open top and the inner wall is seen.
        stage("inside", Ends::Bottom, 0.2).eye(p(1.5, 3.5, 2.0), p(0.0, 0.8, 0.0)),
    ]
}

pub(super) fn material_split() -> Vec<Stage> {
    let solid = block(v(0.0, 1.0, 0.0), v(0.5, 0.5, 0.5));
    let halves = [0, 6].map(|first| {
        solid.clone().without_triangles(move |t| !(first..first + 6).contains(&t)).in_slot(first / 6)
    });
    let paints = [("red", v(0.7, 0.2, 0.1)), ("blue", v(0.1, 0.2, 0.7))];
    let paints = paints.map(|(name, color)| Material::matt(name, color)).to_vec();
    let split = MeshData::merged("two materials", halves);
    vec![
        Stage::new("box")
            .floor()
            .caster_in(split, paints)
            .point(p(-1.0, 4.0, 1.0))
            .dark(&[p(0.4, 0.0, -0.4)])
            .lit(&[p(-1.5, 0.0, 1.5)]),
    ]
}

pub(super) fn uv_seam() -> Vec<Stage> {
    // Light and eye look at the seam, where every vertex is there twice.
    vec![
        Stage::new("sphere")
            .floor()
            .caster_at(uv_sphere(0.6, 32, 16), at(0.0, 1.0, 0.0))
            .point(p(3.0, 3.0, 0.0))
            .eye(p(5.0, 3.0, 3.0), p(0.0, 0.5, 0.0))
            .dark(&[p(-1.0, 0.0, 0.3)])
            .lit(&[p(0.6, 1.0, 0.0)]),
        Stage::new("flat")
            .floor()
            .caster_at(uv_sphere(0.6, 16, 8).flat_shaded(), at(0.0, 1.0, 0.0))
            .point(p(3.0, 3.0, 0.0))
            .dark(&[p(-0.6, 0.0, 0.5)]),
    ]
}

pub(super) fn closed_inside_out() -> Vec<Stage> {
    let solid = || block(v(0.0, 0.0, 0.0), v(0.5, 0.5, 0.5));
    let mirror = placed(p(0.0, 1.2, 0.0), DQuat::from_rotation_y(0.5), DVec3::new(-1.0, 1.0, 1.0));
    let stage = |name: &str, data: MeshData, place| {
        Stage::new(name)
            .floor()
            .caster_at(data, place)
            .point(p(-1.0, 4.0, 1.0))
            .dark(&[p(0.4, 0.0, -0.4)])
            .lit(&[p(-1.5, 0.0, 1.5)])
    };
    vec![
        stage("inwards", solid().flipped(), at(0.0, 1.2, 0.0)),
        stage("mirrored", solid(), mirror),
        stage("both", solid().flipped(), mirror),
        stage("inwards-sphere", icosphere(0.6, 2).flipped(), at(0.0, 1.2, 0.0)),
    ]
}

pub(super) fn closed_open_mixed() -> Vec<Stage> {
    let leaf = |x: f32, y: f32| {
        quad([v(x - 0.5, y, 0.5), v(x + 0.5, y, 0.5), v(x + 0.5, y + 0.2, -0.5), v(x - 0.5, y + 0.2, -0.5)])
    };
    vec![
        // The leaf and the ball overlap in shadow; one lies above, one below the other.
        Stage::new("overlapping")
            .floor()
            .caster_at(uv_sphere(0.4, 24, 12), at(0.0, 1.0, 0.0))
            .caster(leaf(0.4, 1.6))
            .caster(leaf(-0.5, 0.4))
            .point(p(0.0, 4.0, 0.0))
            .dark(&[p(0.3, 0.0, 0.3), p(1.0, 0.0, 0.0), p(-0.9, 0.0, 0.3)]),
        Stage::new("one-mesh")
            .floor()
            .caster(MeshData::merged("mixed", [block(v(-0.3, 1.0, 0.0), v(0.3, 0.3, 0.3)), leaf(0.4, 1.4)]))
            .point(p(0.0, 4.0, 0.0))
            .dark(&[p(-0.4, 0.0, 0.2), p(0.8, 0.0, 0.3)]),
    ]
}

pub(super) fn nested_shells() -> Vec<Stage> {
    let shells = |stage: Stage| {
        [0.9, 0.6, 0.3]
            .iter()
            .fold(stage, |stage, radius| stage.caster_at(icosphere(*radius, 2), at(0.0, 1.2, 0.0)))
    };
    vec![
        shells(Stage::new("spheres").floor())
            .point(p(-1.0, 4.0, 1.0))
            .dark(&[p(0.4, 0.0, -0.4), p(1.1, 0.0, -0.4)])
            .lit(&[p(-1.5, 0.0, 1.8)]),
        // The outer shell has a window, the eye looks in.
        shells(Stage::new("window").floor())
            .caster(open_block(v(0.0, 1.2, 0.0), v(1.0, 1.0, 1.0), &[4]))
            .point(p(0.0, 2.0, 4.0))
            .eye(p(2.0, 3.0, 5.0), p(0.0, 1.0, 0.0)),
    ]
}

pub(super) fn terminator() -> Vec<Stage> {
    // Few facets, smooth normals: shading and geometry disagree about the terminator.
    [(2.5, 2.0), (0.5, 3.0), (-2.5, 1.8)]
        .map(|(x, y)| {
            Stage::new(format!("light-x={x}"))
                .floor()
                .caster_at(uv_sphere(0.9, 10, 6), at(0.0, 1.2, 0.0))
                .point(p(x, y, 2.0))
                .eye(p(1.0, 2.0, 4.5), p(0.0, 1.0, 0.0))
        })
        .to_vec()
}
