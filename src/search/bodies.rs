//! What stands in the scenes: solids, soups, sheets, panes, strips.

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::{self, Ends};

use super::Random;
use super::recipe::{Bend, Body, Wear};

/// A solid of any shape about the origin, of about a metre; wound outwards, double-sided.
pub(super) fn solid(random: &mut Random) -> Body {
    let size = random.within_f32(0.25, 0.9);
    let data = match random.whole(0, 6) {
        0..=2 => {
            let half = Vec3::from_array([(); 3].map(|()| random.within_f32(0.15, 0.8)));
            shapes::cuboid(-half, half)
        }
        3 => shapes::icosphere(size, 1),
        4 => shapes::cylinder(size * 0.6, size * 1.5, random.whole(3, 9) as u32, Ends::Closed),
        5 => shapes::cone(size, size * 1.5, random.whole(3, 8) as u32, Ends::Closed),
        _ => shapes::torus(size, size * 0.35, random.whole(5, 9) as u32, random.whole(3, 6) as u32),
    };
    Body::of(data)
}

/// The box of these half sides.
pub(super) fn block(half: Vec3) -> Body {
    Body::of(shapes::cuboid(-half, half))
}

/// A shape with openings.
pub(super) fn opened(random: &mut Random) -> Body {
    let ends = random.pick(&[Ends::Top, Ends::Bottom, Ends::Open]);
    match random.whole(0, 2) {
        0 => Body::of(shapes::cylinder(0.5, 1.0, random.whole(3, 9) as u32, ends)),
        1 => {
            let mut body = solid(random);
            let gone = random.whole(0, body.triangles.len() - 1);
            body.triangles.remove(gone);
            body
        }
        _ => wave(random),
    }
}

/// A wavy sheet.
pub(super) fn wave(random: &mut Random) -> Body {
    let (columns, rows) = (random.whole(1, 5) as u32, random.whole(1, 5) as u32);
    let bumps: Vec<f32> = (0..36).map(|_| random.within_f32(-0.3, 0.3)).collect();
    let at = |u: f32, v: f32| {
        let bump = bumps[((u * 5.0) as usize * 6 + (v * 5.0) as usize) % 36];
        Vec3::new(u * 2.0 - 1.0, bump, v * 2.0 - 1.0)
    };
    Body::of(shapes::sheet(columns, rows, at))
}

/// How the corners of a soup are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Corners {
    /// Anywhere.
    Free,
    /// On a grid of quarters: edges and planes coincide.
    Grid,
}

/// Triangles without any order. From few corners they share edges, three and more to one; on a grid they lie in one plane,
/// and some come twice, turned, reversed or without area.
pub(super) fn soup(random: &mut Random, triangles: usize, corners: Corners) -> Body {
    let pool = random.whole(5, 5 + triangles * 2);
    let positions: Vec<Vec3> = (0..pool)
        .map(|_| match corners {
            Corners::Free => random.point(1.2),
            Corners::Grid => random.grid_point(1.2),
        })
        .collect();
    let mut faces: Vec<[u32; 3]> = Vec::new();
    while faces.len() < triangles {
        let mut corner = || random.whole(0, pool - 1) as u32;
        let [a, b, c] = [corner(), corner(), corner()];
        let is_degenerate = a == b || b == c || a == c;
        if is_degenerate && (corners == Corners::Free || !random.chance(0.1)) {
            continue;
        }
        faces.push([a, b, c]);
        if corners == Corners::Grid && random.chance(0.25) {
            faces.push(random.pick(&[[a, b, c], [b, c, a], [a, c, b], [c, b, a]]));
        }
    }
    Body::new("soup", positions, faces)
}

/// A flat rectangle at height 0 reaching `half` to each side, in one of the ways to cut it into triangles, facing up or down.
pub(super) fn sheet(random: &mut Random, half: Vec2) -> Body {
    let at = |x: f32, z: f32| Vec3::new(x * half.x, 0.0, z * half.y);
    let corners = vec![at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0), at(-1.0, -1.0)];
    let mut body = match random.whole(0, 4) {
        0 => Body::new("sheet", corners, vec![[0, 1, 2], [0, 2, 3]]),
        1 => Body::new("sheet", corners, vec![[0, 1, 3], [1, 2, 3]]),
        2 => {
            let inner = at(random.within_f32(-0.8, 0.8), random.within_f32(-0.8, 0.8));
            let corners = corners.into_iter().chain([inner]).collect();
            Body::new("sheet", corners, vec![[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
        }
        3 => {
            let (columns, rows) = (random.whole(1, 4) as u32, random.whole(1, 4) as u32);
            let on_sheet = |u: f32, v: f32| at(u * 2.0 - 1.0, 1.0 - v * 2.0);
            let mut body = Body::of(shapes::sheet(columns, rows, on_sheet));
            body.uvs.clear();
            body.name = "sheet".into();
            body
        }
        _ => {
            // The same corners, another first one.
            let turned = |[a, b, c]: [u32; 3]| [b, c, a];
            Body::new("sheet", corners, vec![turned([0, 1, 2]), turned([0, 2, 3])])
        }
    };
    let uv = |p: &Vec3| Vec2::new(p.x / half.x, p.z / half.y) * 0.5 + 0.5;
    body.uvs = body.positions.iter().map(uv).collect();
    if random.chance(0.5) {
        flip(&mut body);
    }
    body
}

/// The same body wound the other way.
pub(super) fn flip(body: &mut Body) {
    body.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
}

/// A floor at height 0, facing up.
pub(super) fn floor(random: &mut Random) -> Body {
    let half = random.within_f32(2.0, 6.0);
    let mut floor = Body { name: "floor".into(), ..Body::of(shapes::plane(Vec2::splat(half))) };
    floor.uvs.clear();
    floor
}

/// A strip, road or cable: one side up to 100 000 times as long as the other, lying about the origin.
pub(super) fn strip(random: &mut Random) -> Body {
    let width = random.by_powers(0.01, 1.0) as f32;
    let length = width * random.by_powers(1e2, 1e5) as f32;
    let rows = random.whole(1, 4) as u32;
    let start = random.within_f32(-0.9, -0.1);
    let heights: Vec<f32> = (0..=rows).map(|_| random.within_f32(-0.2, 0.2) * width).collect();
    let at = |u: f32, v: f32| {
        let row = (v * rows as f32).round();
        Vec3::new((start + u) * length, heights[row as usize], (row - rows as f32 * 0.5) * width)
    };
    Body { name: "strip".into(), ..Body::of(shapes::sheet(1, rows, at)) }
}

/// A piece of coloured glass.
pub(super) fn glass(random: &mut Random) -> Wear {
    let [red, green, blue] = [(); 3].map(|()| random.within_f32(0.05, 1.0));
    let alpha = random.within_f32(0.05, 0.9);
    let transmission = if random.chance(0.15) { random.within_f32(0.2, 1.0) } else { 0.0 };
    Wear::Glass { color: [red, green, blue, alpha], transmission }
}

/// A surface with holes.
pub(super) fn mask(random: &mut Random) -> Wear {
    Wear::Mask { pattern: random.word(), smooth: random.chance(0.5) }
}

/// Somewhere in the open, turned.
pub(super) fn place(random: &mut Random, body: &mut Body) {
    let at = DVec3::new(random.within(-1.8, 1.8), random.within(0.4, 2.2), random.within(-1.8, 1.8));
    let size = random.within(0.5, 1.2);
    let place = DAffine3::from_scale_rotation_translation(DVec3::splat(size), random.turn(), at);
    body.transforms = vec![place];
}

/// Mirrored, squashed, stretched or sheared, in the middle of its other transforms.
pub(super) fn distort(random: &mut Random, body: &mut Body) {
    let axis = random.whole(0, 2);
    let mut columns = [DVec3::X, DVec3::Y, DVec3::Z];
    match random.whole(0, 3) {
        0 => columns[axis] *= -1.0,
        1 => columns[axis] *= random.by_powers(1e-3, 0.3) * if random.chance(0.3) { -1.0 } else { 1.0 },
        2 => columns[axis][(axis + 1) % 3] = random.within(-1.5, 1.5),
        _ => columns[axis] *= random.within(1.5, 4.0),
    }
    body.transforms.push(DAffine3::from_mat3(DMat3::from_cols(columns[0], columns[1], columns[2])));
}

/// Bent by a morph target, or by two joints.
pub(super) fn bend(random: &mut Random, body: &mut Body) {
    if random.chance(0.5) {
        let pull = random.point(0.8);
        let along = random.direction().as_vec3();
        let moves = body.positions.iter().map(|p| pull * p.dot(along).max(0.0) + *p * 0.1).collect();
        body.bend = Bend::Morph { moves, weight: random.within(-0.5, 1.5) };
    } else {
        let share = |p: &Vec3| (p.y + 0.5).clamp(0.0, 1.0);
        let shares = body.positions.iter().map(share).collect();
        let at = random.point(0.3).as_dvec3();
        body.bend = Bend::Skin { shares, tip: DAffine3::from_rotation_translation(random.turn(), at) };
    }
}
