//! The facing signs of one pose, again and again as lights move.

use glam::{DVec3, DVec4};
use rayon::prelude::*;

use super::chain::MIN_PARALLEL;
use crate::math::{Aabb, facing_sign};

/// The planes of a pose's triangles in f32, which decide nearly every sign; where they cannot, [`facing_sign`] does.
///
/// *Why the signs are those of [`facing_sign`].* A plane's height at the light is off by less than 16·2⁻²⁴ of how far light and corners
/// are from the pose's centre: normal, offset and light are rounded once each, and four products are added. Heights beyond
/// that have the right sign. They are also far beyond what `facing_sign` calls 0: 1.2·10⁻⁷ rad of a direction, 4·10⁻¹⁵ of a coordinate,
/// and 10⁻¹³ of a determinant's permanent, which is 3.5·10⁻⁹ of the distance for the thinnest triangle that has a plane here.
#[derive(Clone, Debug)]
pub struct FacingPlanes {
    center: DVec3,
    radius_m: f64,
    /// The unit normal, and how high the plane is over the centre along it; not numbers where a triangle is too thin.
    planes: Vec<[f32; 4]>,
}

/// Triangles whose first corner has a smaller sine have no plane here.
const THINNEST: f64 = 1e-4;
/// How far off a height may be, as a share of the distances: 16·2⁻²⁴.
const HEIGHT_EPSILON: f64 = 1e-6;
/// The same, as a share of the coordinates: over what [`facing_sign`] allows for.
const POSITION_EPSILON: f64 = 1e-14;
/// Poses smaller than this, with their light, leave the range in which f32 has all its digits.
const SMALLEST_M: f64 = 1e-30;

impl FacingPlanes {
    /// The planes of `triangles`, corners as indices into `p_in_world`.
    ///
    /// # Panics
    /// When a corner is out of range.
    pub fn new(p_in_world: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let bounds = Aabb::from_points(p_in_world.iter().copied());
        let center = bounds.center();
        let plane = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| p_in_world[corner as usize]);
            let (ab, ac) = (b - a, c - a);
            let normal = ab.cross(ac);
            let (area, widest) = (normal.length(), ab.length() * ac.length());
            // Whatever is no number is not above anything.
            if area > THINNEST * widest {
                let normal = normal / area;
                normal.extend(normal.dot(a - center)).as_vec4().to_array()
            } else {
                [f32::NAN; 4]
            }
        };
        let planes = triangles.par_iter().with_min_len(MIN_PARALLEL).map(plane).collect();
        Self { center, radius_m: bounds.radius(), planes }
    }

    /// What [`facing_signs`](super::facing_signs) gives for the same pose and this `light`.
    ///
    /// # Panics
    /// When a corner is out of range.
    pub fn signs(&self, p_in_world: &[DVec3], triangles: &[[u32; 3]], light: DVec4) -> Vec<i8> {
        let to_light = light.truncate() - self.center * light.w;
        let reach_m = to_light.length() + self.radius_m * light.w;
        let coordinate = self.center.abs().max(light.truncate().abs()).max_element() + self.radius_m;
        let uncertain = HEIGHT_EPSILON * reach_m + POSITION_EPSILON * coordinate * light.w;
        let uncertain = if reach_m > SMALLEST_M { uncertain as f32 } else { f32::INFINITY };
        let ([x, y, z], w) = (to_light.as_vec3().to_array(), light.w as f32);
        let sign = |(plane, corners): (&[f32; 4], &[u32; 3])| {
            let height = plane[0] * x + plane[1] * y + plane[2] * z - plane[3] * w;
            if height > uncertain {
                1
            } else if height < -uncertain {
                -1
            } else {
                let [a, b, c] = corners.map(|corner| p_in_world[corner as usize]);
                facing_sign(a, b, c, light) as i8
            }
        };
        self.planes.par_iter().zip(triangles).with_min_len(MIN_PARALLEL).map(sign).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::facing_signs;
    use super::*;
    use crate::random::{random, random_point};

    #[test]
    fn signs_are_the_exact_ones_wherever_pose_and_light_are() {
        let mut seed = 3;
        let (mut asked, mut edge_on) = (0, 0);
        for (round, size_m) in [1.0, 1e-3, 1e6, 1e-36, 1e30].into_iter().cycle().take(400).enumerate() {
            let place = random_point(&mut seed) * size_m * [0.0, 1.0, 1e3, 1e8][round % 4];
            let mut corners = Vec::new();
            for _ in 0..50 {
                let (a, ab, ac) = (random_point(&mut seed), random_point(&mut seed), random_point(&mut seed));
                // Thin ones, and some without area.
                let thin = [1.0, 1e-3, 1e-7, 1e-13, 0.0][round % 5];
                corners
                    .extend([a, a + ab, a + ab * random(&mut seed) + ac * thin].map(|p| place + p * size_m));
            }
            let triangles: Vec<[u32; 3]> = (0..50).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
            let planes = FacingPlanes::new(&corners, &triangles);
            // In the planes of triangles, beside them, and anywhere.
            let [a, b, c] = [corners[0], corners[1], corners[2]];
            let in_plane = a + (b - a) * random(&mut seed) * 3.0 + (c - a) * random(&mut seed);
            let off_plane =
                (b - a).cross(c - a).normalize_or_zero() * size_m * 10_f64.powi(-(round as i32 % 16));
            let far = place + random_point(&mut seed) * size_m * 10_f64.powi(round as i32 % 12);
            for light in [a, b, in_plane, in_plane + off_plane, in_plane - off_plane, far] {
                for light in [light.extend(1.0), (light - c).normalize_or_zero().extend(0.0)] {
                    let exact = facing_signs(&corners, &triangles, light);
                    assert_eq!(planes.signs(&corners, &triangles, light), exact, "{round}: {light}");
                    asked += exact.len();
                    edge_on += exact.iter().filter(|sign| **sign == 0).count();
                }
            }
        }
        assert!(edge_on > 1000 && edge_on * 2 < asked, "{edge_on} of {asked}");
        let nothing = FacingPlanes::new(&[], &[]);
        assert!(nothing.signs(&[], &[], DVec4::W).is_empty());
        let broken = [DVec3::NAN, DVec3::X, DVec3::Y];
        assert_eq!(FacingPlanes::new(&broken, &[[0, 1, 2]]).signs(&broken, &[[0, 1, 2]], DVec4::W), [0]);
    }
}
