//! Lists of the triangles that are left out of the chains, for coming close to the light or being seen wide from there:
//! walls, mostly. Indoors there are a hundred, and of each receiver's way to the light few are near.
//!
//! Around the light's centre c lies a cube of cells of directions. A way from a receiver p to a sample of the light's disc
//! stays within R of the way to c, R the radius of the ball that holds the discs. What it meets at a distance of h or more
//! from c, h > R, is seen from c within asin(R/h) of p's own direction: so a triangle is listed in the cells within that
//! angle of it, h being how near it comes to c; and in all cells where h is no more than R.

use glam::{DVec2, DVec3};

use super::chain::LightBall;

/// Cells along a side of each of the cube's six faces: NEAR_SIDE of soft_lists.wgsl.
const SIDE: usize = 12;
/// More triangles than that are asked cluster by cluster.
const MOST: usize = 1024;
/// How far off, as an angle, the direction may be for which the shader looks up a cell: NEAR_MARGIN of soft_lists.wgsl, and
/// as much again for what f32 makes of the cell's border.
const MARGIN: f64 = 2e-3;

/// For each cell, face by face and row by row, the numbers of the triangles that ways from there may meet; `None` where
/// there are no triangles or too many.
pub(super) fn near_lists(light: &LightBall, triangles: &[[DVec3; 3]]) -> Option<Vec<Vec<u32>>> {
    if triangles.is_empty() || triangles.len() > MOST {
        return None;
    }
    let seen: Vec<SeenTriangle> =
        triangles.iter().map(|corners| SeenTriangle::new(light, *corners)).collect();
    let cells = (0..6 * SIDE * SIDE).map(|cell| {
        let (axis, half_angle) = cell_cone(cell);
        let meets =
            |triangle: &SeenTriangle| triangle.angle_from(axis) <= triangle.reach + half_angle + MARGIN;
        (0..).zip(&seen).filter(|(_, triangle)| meets(triangle)).map(|(number, _)| number).collect()
    });
    Some(cells.collect())
}

/// A cell's middle direction, and the widest angle from there to any other of its directions.
fn cell_cone(cell: usize) -> (DVec3, f64) {
    let (face, row, column) = (cell / (SIDE * SIDE), cell / SIDE % SIDE, cell % SIDE);
    let sign = if face % 2 == 0 { 1.0 } else { -1.0 };
    let direction = |x: f64, y: f64| {
        let at = DVec2::new(column as f64 + x, row as f64 + y) / SIDE as f64 * 2.0 - 1.0;
        // As the shader has it: away, then across and up, in the order of the axes.
        let d = match face / 2 {
            0 => DVec3::new(sign, at.x, at.y),
            1 => DVec3::new(at.y, sign, at.x),
            _ => DVec3::new(at.x, at.y, sign),
        };
        d.normalize()
    };
    let axis = direction(0.5, 0.5);
    let corners = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| direction(x, y));
    let widest = corners.into_iter().map(|corner| axis.angle_between(corner)).fold(0.0, f64::max);
    (axis, widest)
}

/// A triangle as the light's centre sees it.
struct SeenTriangle {
    /// Unit directions to its corners.
    corners: [DVec3; 3],
    /// Beyond this angle from it no way comes near it.
    reach: f64,
}

impl SeenTriangle {
    fn new(light: &LightBall, corners: [DVec3; 3]) -> Self {
        let nearest = light.distance_to_triangle(corners) * (1.0 - 1e-9);
        let reach = if nearest > light.radius { (light.radius / nearest).asin() } else { f64::INFINITY };
        let center = light.position.truncate();
        Self { corners: corners.map(|corner| (corner - center).normalize_or_zero()), reach }
    }

    /// The angle between a direction and the nearest one in which the triangle is seen.
    fn angle_from(&self, direction: DVec3) -> f64 {
        if self.reach == f64::INFINITY {
            return 0.0;
        }
        let [a, b, c] = self.corners;
        // Inside each edge, on the side that the triangle itself is on: however nearly half a circle they span.
        let turn = a.cross(b).dot(c).signum();
        let is_inside = |p: DVec3, q: DVec3| p.cross(q).dot(direction) * turn >= 0.0;
        if is_inside(a, b) && is_inside(b, c) && is_inside(c, a) {
            return 0.0;
        }
        let angles = [(a, b), (b, c), (c, a)].map(|(p, q)| angle_from_arc(direction, p, q));
        angles.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// The angle between a direction and the arc from `p` to `q`.
fn angle_from_arc(direction: DVec3, p: DVec3, q: DVec3) -> f64 {
    let normal = p.cross(q);
    let beside = normal.cross(p).dot(direction) >= 0.0 && q.cross(normal).dot(direction) >= 0.0;
    match normal.try_normalize() {
        Some(normal) if beside => normal.dot(direction).abs().min(1.0).asin(),
        _ => direction.angle_between(p).min(direction.angle_between(q)),
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec4;

    use super::*;

    /// A number in −1 … 1, the same for the same seed.
    fn random(seed: &mut u64) -> f64 {
        *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn random_point(seed: &mut u64) -> DVec3 {
        DVec3::new(random(seed), random(seed), random(seed))
    }

    /// The cell of a direction, as soft_lists.wgsl finds it.
    fn cell_of(d: DVec3) -> usize {
        let size = d.abs();
        let axis = if size.z > size.x.max(size.y) { 2 } else { usize::from(size.y > size.x) };
        let (away, across, up) = match axis {
            0 => (d.x, d.y, d.z),
            1 => (d.y, d.z, d.x),
            _ => (d.z, d.x, d.y),
        };
        let place = |v: f64| (((v / away.abs() * 0.5 + 0.5) * SIDE as f64) as usize).min(SIDE - 1);
        ((axis * 2 + usize::from(away < 0.0)) * SIDE + place(up)) * SIDE + place(across)
    }

    #[test]
    fn whatever_a_way_to_the_disc_meets_is_listed() {
        let mut seed = 7;
        let light = LightBall { position: DVec4::new(0.3, -0.2, 0.1, 1.0), radius: 0.2 };
        let center = light.position.truncate();
        let triangles: Vec<[DVec3; 3]> = (0..200)
            .map(|_| {
                let middle = center + random_point(&mut seed) * 2.0;
                [0; 3].map(|_| middle + random_point(&mut seed) * 1.5)
            })
            .collect();
        let lists = near_lists(&light, &triangles).expect("few enough");
        let (mut met, mut listed) = (0, 0);
        for _ in 0..3000 {
            let p = center + random_point(&mut seed) * 3.0;
            if p.distance(center) < 2.0 * light.radius {
                continue;
            }
            let sample =
                center + random_point(&mut seed).normalize_or_zero() * light.radius * random(&mut seed);
            let cell = &lists[cell_of(p - center)];
            listed += cell.len();
            for (number, [a, b, c]) in (0_u32..).zip(&triangles) {
                let volume = |x: DVec3, y: DVec3, z: DVec3| (y - x).cross(z - x).dot(sample - x);
                let side = |q: DVec3| (*b - *a).cross(*c - *a).dot(q - *a) > 0.0;
                let through = [(a, b), (b, c), (c, a)].map(|(x, y)| volume(p, *x, *y) > 0.0);
                let is_met = side(p) != side(sample) && (through == [true; 3] || through == [false; 3]);
                met += usize::from(is_met);
                assert!(!is_met || cell.contains(&number), "{p} to {sample} meets {a} {b} {c}");
            }
        }
        assert!(met > 5000 && listed < 3000 * 80, "{met} met, {listed} listed");
    }
}
