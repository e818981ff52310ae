//! Generated shapes: what demo scenes, hard cases and tests are built from.
//!
//! Every shape comes as [`MeshData`] with unit normals and texture coordinates, wound outwards (counter-clockwise
//! seen from outside), y up. Where a surface meets itself (the seam of a sphere, the ends of a torus) the
//! positions are *the same numbers*, taken by wrapped index from one table and never recomputed, so that welding by
//! exact position closes the seam. Shapes with sharp edges repeat vertices and share positions the same way.

mod edit;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec3, Vec2, Vec3};

use super::MeshData;

/// Which ends of a tube are closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ends {
    /// Both: a solid.
    #[default]
    Closed,
    /// The upper end only.
    Top,
    /// The lower end only.
    Bottom,
    /// None.
    Open,
}

/// Neighbouring pieces of a profile are shaded smoothly across when their normals differ by less than 40°.
const CREASE_COS: f32 = 0.766;

/// The flat quad a, b, c, d, counter-clockwise seen from its front; split along a–c.
pub fn quad(corners: [Vec3; 4]) -> MeshData {
    let [a, b, c, d] = corners;
    let normal = (c - a).cross(d - b).normalize_or(Vec3::Y);
    MeshData {
        name: "quad".into(),
        positions: corners.to_vec(),
        normals: vec![normal; 4],
        uvs: vec![Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.0)],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..MeshData::default()
    }
}

/// A horizontal rectangle at height 0, facing up, reaching `half` to each side in x and z.
pub fn plane(half: Vec2) -> MeshData {
    let at = |x: f32, z: f32| Vec3::new(x * half.x, 0.0, z * half.y);
    quad([at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0), at(-1.0, -1.0)]).named("plane")
}

/// The box between two corners: 24 vertices, two triangles a face, faces in the order +x, −x, +y, −y, +z, −z.
pub fn cuboid(min: Vec3, max: Vec3) -> MeshData {
    let mut faces = Vec::with_capacity(6);
    for axis in 0..3 {
        for side in [max, min] {
            let corner = |u: f32, v: f32| {
                let mut p = min;
                p[axis] = side[axis];
                p[(axis + 1) % 3] = if u > 0.0 { max[(axis + 1) % 3] } else { min[(axis + 1) % 3] };
                p[(axis + 2) % 3] = if v > 0.0 { max[(axis + 2) % 3] } else { min[(axis + 2) % 3] };
                p
            };
            let (a, b, c, d) = (corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0));
            let mut face = quad(if side == max { [a, b, c, d] } else { [a, d, c, b] });
            let normal = if side == max { Vec3::AXES[axis] } else { -Vec3::AXES[axis] };
            face.normals.fill(normal);
            faces.push(face);
        }
    }
    MeshData::merged("box", faces)
}

/// The surface a profile sweeps around the y axis.
///
/// The profile's points are (radius, height); outside lies to the right of its direction, so a solid's profile
/// starts at its lower pole and ends at its upper one. A profile whose last point equals its first closes into a ring.
/// Kinks sharper than 40° stay sharp.
pub fn lathe(profile: &[Vec2], segments: u32) -> MeshData {
    let segments = segments.max(3) as usize;
    let circle = circle(segments);
    let pieces = profile.len().saturating_sub(1);
    let is_ring = pieces > 2 && profile[0] == profile[pieces];
    let outwards = |piece: usize| {
        let along = profile[piece + 1] - profile[piece];
        Vec2::new(along.y, -along.x).normalize_or_zero()
    };
    // The normal at one end of a piece: the mean with its neighbour's, or its own across a crease and at open ends.
    let end_normal = |piece: usize, neighbour: Option<usize>, at: Vec2| {
        let own = outwards(piece);
        match neighbour.map(outwards) {
            Some(other) if own.dot(other) > CREASE_COS => (own + other).normalize_or(own),
            None if at.x == 0.0 && own.y.abs() > CREASE_COS => Vec2::new(0.0, own.y.signum()),
            _ => own,
        }
    };
    let length: f32 = profile.windows(2).map(|p| p[0].distance(p[1])).sum();
    let mut walked = 0.0;
    let mut data = MeshData { name: "lathe".into(), ..MeshData::default() };
    for piece in 0..pieces {
        let ends = [profile[piece], profile[piece + 1]];
        let before = if piece > 0 { Some(piece - 1) } else { is_ring.then(|| pieces - 1) };
        let after = if piece + 1 < pieces { Some(piece + 1) } else { is_ring.then_some(0) };
        let normals = [end_normal(piece, before, ends[0]), end_normal(piece, after, ends[1])];
        let v = [walked, walked + ends[0].distance(ends[1])].map(|l| 1.0 - l / length.max(f32::MIN_POSITIVE));
        walked += ends[0].distance(ends[1]);
        let first = data.positions.len() as u32;
        for column in 0..=segments {
            let around = circle[column % segments];
            for end in 0..2 {
                let turned = |p: Vec2| Vec3::new(p.x * around.x, p.y, -p.x * around.y);
                data.positions.push(turned(ends[end]));
                data.normals.push(turned(normals[end]));
                data.uvs.push(Vec2::new(column as f32 / segments as f32, v[end]));
            }
        }
        for column in 0..segments as u32 {
            let [a, d, b, c] = [0, 1, 2, 3].map(|i| first + column * 2 + i);
            // On the axis one edge of the quad has shrunk to a point.
            if ends[0].x != 0.0 {
                data.indices.extend([a, b, c]);
            }
            if ends[1].x != 0.0 {
                data.indices.extend([a, c, d]);
            }
        }
    }
    data
}

/// A sphere around the origin from `rings` bands of latitude.
pub fn uv_sphere(radius: f32, segments: u32, rings: u32) -> MeshData {
    let rings = rings.max(2);
    let profile: Vec<Vec2> = (0..=rings)
        .map(|ring| {
            let angle = f64::from(ring) / f64::from(rings) * TAU * 0.5;
            let at = Vec2::new(angle.sin() as f32, -angle.cos() as f32) * radius;
            // The poles lie on the axis exactly; sin π does not.
            if ring == 0 || ring == rings { Vec2::new(0.0, at.y) } else { at }
        })
        .collect();
    lathe(&profile, segments).named("sphere")
}

/// A sphere from an icosahedron whose triangles are split in four `subdivisions` times: 20·4ⁿ triangles, no
/// repeated vertices. Texture coordinates are longitude and latitude and jump across the date line.
pub fn icosphere(radius: f32, subdivisions: u32) -> MeshData {
    let golden = 0.5 + 1.25_f64.sqrt();
    let mut directions = Vec::new();
    for (s, t) in [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)] {
        let p = DVec3::new(0.0, s, t).normalize();
        directions.extend([p, DVec3::new(p.z, p.x, p.y), DVec3::new(p.y, p.z, p.x)]);
    }
    let mut triangles = hull_of_icosahedron(&directions);
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut split = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let mut middle = |p: u32, q: u32| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    directions.push((directions[p as usize] + directions[q as usize]).normalize());
                    directions.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            split.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = split;
    }
    let uv = |d: &DVec3| DVec3::new(0.5 - d.z.atan2(d.x) / TAU, d.y.clamp(-1.0, 1.0).acos() / TAU * 2.0, 0.0);
    MeshData {
        name: "icosphere".into(),
        positions: directions.iter().map(|d| (*d * f64::from(radius)).as_vec3()).collect(),
        normals: directions.iter().map(|d| d.as_vec3()).collect(),
        uvs: directions.iter().map(|d| uv(d).as_vec3().truncate()).collect(),
        indices: triangles.concat(),
        ..MeshData::default()
    }
}

/// The icosahedron's 20 faces: all triples of mutual neighbours, wound outwards.
fn hull_of_icosahedron(corners: &[DVec3]) -> Vec<[u32; 3]> {
    let near = |i: usize, j: usize| corners[i].dot(corners[j]) > 0.4;
    let mut faces = Vec::with_capacity(20);
    for i in 0..corners.len() {
        for j in i + 1..corners.len() {
            for k in j + 1..corners.len() {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outwards = corners[i].dot(corners[j].cross(corners[k])) > 0.0;
                    let (i, j, k) = (i as u32, j as u32, k as u32);
                    faces.push(if outwards { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    faces
}

/// A cylinder standing on the origin.
pub fn cylinder(radius: f32, height: f32, segments: u32, ends: Ends) -> MeshData {
    frustum(radius, radius, height, segments, ends).named("cylinder")
}

/// A cone standing on the origin, its apex at `height`.
pub fn cone(radius: f32, height: f32, segments: u32, ends: Ends) -> MeshData {
    frustum(radius, 0.0, height, segments, ends).named("cone")
}

/// A truncated cone standing on the origin.
pub fn frustum(radius_bottom: f32, radius_top: f32, height: f32, segments: u32, ends: Ends) -> MeshData {
    let mut profile = vec![Vec2::new(radius_bottom, 0.0), Vec2::new(radius_top, height)];
    if matches!(ends, Ends::Closed | Ends::Bottom) && radius_bottom > 0.0 {
        profile.insert(0, Vec2::ZERO);
    }
    if matches!(ends, Ends::Closed | Ends::Top) && radius_top > 0.0 {
        profile.push(Vec2::new(0.0, height));
    }
    lathe(&profile, segments).named("frustum")
}

/// A ring around the y axis: a tube of radius `tube` around a circle of radius `ring`.
pub fn torus(ring: f32, tube: f32, segments: u32, tube_segments: u32) -> MeshData {
    let circle = circle(tube_segments.max(3) as usize);
    let mut profile: Vec<Vec2> = circle.iter().map(|c| Vec2::new(ring, 0.0) + *c * tube).collect();
    profile.push(profile[0]);
    lathe(&profile, segments).named("torus")
}

/// A tube of radius `tube` along the (p, q) knot on a torus of radii `ring` and `ring`/2: p turns around the axis of
/// symmetry (z), q through the hole.
pub fn torus_knot([p, q]: [u32; 2], ring: f32, tube: f32, [segments, tube_segments]: [u32; 2]) -> MeshData {
    let (segments, tube_segments) = (segments.max(3) as usize, tube_segments.max(3) as usize);
    let on_knot = |t: f64| {
        let (turn, through) = (t * TAU * f64::from(p), t * TAU * f64::from(q));
        let r = 1.0 + 0.5 * through.cos();
        DVec3::new(r * turn.cos(), r * turn.sin(), 0.5 * through.sin()) * f64::from(ring)
    };
    let circle = circle(tube_segments);
    wrapped_surface("torus knot", segments, tube_segments, |i, j| {
        let t = i as f64 / segments as f64;
        let (center, ahead) = (on_knot(t), on_knot(t + 1e-4));
        let along = (ahead - center).normalize();
        let binormal = along.cross(ahead + center).normalize();
        let around = circle[j].as_dvec2();
        let normal = binormal.cross(along) * around.x - binormal * around.y;
        ((center + normal * f64::from(tube)).as_vec3(), normal.as_vec3())
    })
}

/// A surface that closes on itself both ways, from position and normal at each of its `columns` × `rows` points;
/// outside is where (next column) × (next row) points to.
fn wrapped_surface(
    name: &str,
    columns: usize,
    rows: usize,
    at: impl Fn(usize, usize) -> (Vec3, Vec3),
) -> MeshData {
    let points: Vec<(Vec3, Vec3)> = (0..columns * rows).map(|i| at(i / rows, i % rows)).collect();
    let mut data = MeshData { name: name.into(), ..MeshData::default() };
    for column in 0..=columns {
        for row in 0..=rows {
            let (position, normal) = points[column % columns * rows + row % rows];
            data.positions.push(position);
            data.normals.push(normal);
            data.uvs.push(Vec2::new(column as f32 / columns as f32, row as f32 / rows as f32));
        }
    }
    data.indices = grid_indices(columns as u32, rows as u32);
    data
}

/// An open sheet of `columns` × `rows` quads: the image of the unit square under `at`. Its front is where
/// ∂/∂u × ∂/∂v points to.
pub fn sheet(columns: u32, rows: u32, at: impl Fn(f32, f32) -> Vec3) -> MeshData {
    const STEP: f32 = 1e-3;
    let mut data = MeshData { name: "sheet".into(), ..MeshData::default() };
    for column in 0..=columns {
        for row in 0..=rows {
            let (u, v) = (column as f32 / columns as f32, row as f32 / rows as f32);
            let along_u = at((u + STEP).min(1.0), v) - at((u - STEP).max(0.0), v);
            let along_v = at(u, (v + STEP).min(1.0)) - at(u, (v - STEP).max(0.0));
            data.positions.push(at(u, v));
            data.normals.push(along_u.as_dvec3().cross(along_v.as_dvec3()).normalize_or(DVec3::Y).as_vec3());
            data.uvs.push(Vec2::new(u, 1.0 - v));
        }
    }
    data.indices = grid_indices(columns, rows);
    data
}

fn grid_indices(columns: u32, rows: u32) -> Vec<u32> {
    let mut indices = Vec::with_capacity((columns * rows * 6) as usize);
    for column in 0..columns {
        for row in 0..rows {
            let a = column * (rows + 1) + row;
            let (b, c, d) = (a + rows + 1, a + rows + 2, a + 1);
            indices.extend([a, b, c, a, c, d]);
        }
    }
    indices
}

/// The prism over a simple polygon in the xy plane (counter-clockwise seen from +z), from `back_z` to `front_z`.
/// Flat-shaded; closed.
pub fn extruded(outline: &[Vec2], back_z: f32, front_z: f32) -> MeshData {
    let count = outline.len();
    let face = |z: f32, normal: Vec3| MeshData {
        positions: outline.iter().map(|p| p.extend(z)).collect(),
        normals: vec![normal; count],
        uvs: outline.to_vec(),
        indices: triangulated(outline),
        ..MeshData::default()
    };
    let mut parts = vec![face(front_z, Vec3::Z), face(back_z, Vec3::Z).flipped()];
    for i in 0..count {
        let (p, q) = (outline[i], outline[(i + 1) % count]);
        parts.push(quad([p.extend(back_z), q.extend(back_z), q.extend(front_z), p.extend(front_z)]));
    }
    MeshData::merged("prism", parts)
}

/// Ear clipping: triangles over a simple counter-clockwise polygon.
fn triangulated(outline: &[Vec2]) -> Vec<u32> {
    let mut open: Vec<usize> = (0..outline.len()).collect();
    let mut indices = Vec::new();
    let turn = |a: usize, b: usize, c: usize| {
        (outline[b] - outline[a]).as_dvec2().perp_dot((outline[c] - outline[a]).as_dvec2())
    };
    while open.len() >= 3 {
        let count = open.len();
        let corner = |i: usize| (open[(i + count - 1) % count], open[i], open[(i + 1) % count]);
        let is_ear = |i: &usize| {
            let (a, b, c) = corner(*i);
            let covers = |p: usize| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            turn(a, b, c) > 0.0 && !open.iter().any(|&p| p != a && p != b && p != c && covers(p))
        };
        // A polygon that is not simple has no ear at some point; clipping any corner then still ends.
        let ear = (0..count).find(is_ear).unwrap_or(0);
        let (a, b, c) = corner(ear);
        indices.extend([a as u32, b as u32, c as u32]);
        open.remove(ear);
    }
    indices
}

/// `segments` points of the unit circle, counter-clockwise from (1, 0).
fn circle(segments: usize) -> Vec<Vec2> {
    (0..segments)
        .map(|i| {
            let angle = i as f64 / segments as f64 * TAU;
            Vec2::new(angle.cos() as f32, angle.sin() as f32)
        })
        .collect()
}
