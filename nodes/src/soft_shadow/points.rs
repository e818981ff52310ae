//! Fixed points that stand for a light with a size.
//!
//! *Why fixed.* A shadow is flattened onto a plane from one point, the same for the whole plane. But the light is
//! defined as the disc each receiver point sees ([`shadowgraph_engine::shadow::LightSize`]), and these discs turn
//! from receiver to receiver.
//!
//! *Points of a ball that look like a disc.* A uniform density on the unit sphere in four dimensions, of which one
//! coordinate is dropped, is the density 1/√(1 − r²) in the ball; drop any second one, and a uniform disc is left. So
//! points that are spread well over the 3-sphere, seen from afar from any direction, are spread well over the disc: no
//! point is lost on the far side, and all count the same. From nearby each counts a little more or less, by a weight in
//! closed form that the shader has (`weight` in soft_shadow.wgsl), so the mean converges to the light's factor wherever
//! the receiver is.
//!
//! *Spread well.* As the engine's own points of a disc ([`light_samples`]) are, one dimension up: points look along
//! many directions of space, and each moves towards where the point of its rank should be (sliced optimal transport).
//! What a ball of this density shows along any direction is what a disc does. They start from super-Fibonacci spirals
//! on the 3-sphere (Alexa 2022). RMS error of half-planes' shadows, over all directions within 60° of the plane's
//! normal:
//!
//! | points | these | the spirals | random | a sphere's surface, weighed by the cosine | the best disc, seen face on |
//! |---|---|---|---|---|---|
//! | 16 | 0.0430 | 0.055 | 0.102 | 0.075 | 0.033 |
//! | 64 | 0.0165 | 0.023 | 0.048 | 0.025 | 0.0115 |
//! | 256 | 0.0066 | 0.0081 | 0.022 | 0.0089 | 0.0040 |
//! | 1024 | 0.0024 | 0.0028 | 0.008 | 0.0031 | |
//!
//! Directional lights need none of this: their disc of directions is the same everywhere, and its points the engine's.

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::{DQuat, DVec2, DVec3, DVec4};
use shadowgraph_engine::scene::LightSnapshot;
use shadowgraph_engine::shadow::{Cache, LightSize, light_samples};

/// Rounds of moving, and directions looked along in each.
const ROUNDS: u32 = 24;
const DIRECTIONS: u32 = 24;
/// The turn between neighbours of the second spiral: the root of ψ⁴ = ψ + 4.
const PSI: f64 = 1.533_751_168_755_204;

/// The points of one light for one plane.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct LightPoints {
    /// Where they are: (position, 1), or (direction towards it, 0).
    pub(super) positions: Vec<DVec4>,
    /// From the centre, in radii.
    pub(super) offsets: Vec<DVec3>,
    /// The radius by which they are weighed; 0 where all count the same.
    pub(super) radius_m: f64,
    /// The point that alone counts inside the sphere.
    pub(super) center_point: Option<usize>,
}

impl LightPoints {
    /// `count` points for `light`, or one where it has no size. `normal` is the plane's, and `nearest_m` the distance
    /// from the light's centre to the nearest receiver.
    pub(super) fn new(
        cache: &Cache,
        light: &LightSnapshot,
        size: LightSize,
        count: u32,
        (normal, nearest_m): (DVec3, f64),
    ) -> Self {
        let center = light.position;
        if !size.is_wide(center) {
            return Self {
                positions: vec![center],
                offsets: vec![DVec3::ZERO],
                radius_m: 0.0,
                center_point: None,
            };
        }
        if center.w == 0.0 {
            let disc = size.disc(center);
            let offset = |p: &DVec2| disc.u * p.x + disc.v * p.y;
            let offsets: Vec<DVec3> = light_samples(count).iter().map(offset).collect();
            let positions = offsets.iter().map(|o| center + (*o * disc.radius).extend(0.0)).collect();
            return Self { positions, offsets, radius_m: 0.0, center_point: None };
        }
        let ball = cache.get_or_compute("points of a ball", count.into(), || ball_points(count));
        // Their best two directions lie in the plane.
        let turn = DQuat::from_rotation_arc(DVec3::Z, normal);
        let mut offsets: Vec<DVec3> = ball.iter().map(|point| turn * *point).collect();
        let reaches_inside = nearest_m <= size.radius_m * (1.0 + 1e-6);
        let center_point = reaches_inside.then_some(offsets.len());
        offsets.extend(reaches_inside.then_some(DVec3::ZERO));
        let positions = offsets.iter().map(|o| center + (*o * size.radius_m).extend(0.0)).collect();
        Self { positions, offsets, radius_m: size.radius_m, center_point }
    }
}

/// Points of the unit ball with density 1/√(1 − r²), spread evenly across every plane.
fn ball_points(count: u32) -> Vec<DVec3> {
    if count == 1 {
        return vec![DVec3::ZERO];
    }
    let of_count = |index: u32| (f64::from(index) + 0.5) / f64::from(count);
    let spirals = |index: u32| {
        let s = f64::from(index) + 0.5;
        let first = DVec2::from_angle(TAU * s / SQRT_2) * of_count(index).sqrt();
        let second = DVec2::from_angle(TAU * s / PSI) * (1.0 - of_count(index)).sqrt();
        // The fourth coordinate is dropped.
        first.extend(second.x)
    };
    let mut points: Vec<DVec3> = (0..count).map(spirals).collect();
    let ideal: Vec<f64> = (0..count).map(|index| quantile(of_count(index))).collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    let mut along = vec![0.0; points.len()];
    for round in 0..ROUNDS {
        let mut moves = vec![DVec3::ZERO; points.len()];
        for number in 0..DIRECTIONS {
            let direction = direction(round * DIRECTIONS + number);
            for (along, point) in along.iter_mut().zip(&points) {
                *along = point.dot(direction);
            }
            order.sort_by(|a, b| along[*a].total_cmp(&along[*b]));
            for (ideal, index) in ideal.iter().zip(&order) {
                moves[*index] += direction * (ideal - along[*index]);
            }
        }
        // Of a point's whole way every direction sees, on average, a third.
        let share = 3.0 / f64::from(DIRECTIONS);
        for (point, way) in points.iter_mut().zip(moves) {
            *point = (*point + way * share).clamp_length_max(1.0);
        }
    }
    points
}

/// Direction number `number` of a sequence that is spread evenly over the sphere.
fn direction(number: u32) -> DVec3 {
    // The plane's two most irrational steps (Roberts' R2).
    let [u, v] = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|step| f64::from(number) * step % 1.0);
    let z = 2.0 * u - 1.0;
    (DVec2::from_angle(v * TAU) * (1.0 - z * z).sqrt()).extend(z)
}

/// Where a line across the unit disc has `share` of its area on one side, which is also where a plane across the ball
/// has that share of its points: the signed distance from the centre.
fn quantile(share: f64) -> f64 {
    let below = |t: f64| 0.5 + (t * (1.0 - t * t).max(0.0).sqrt() + t.asin()) / PI;
    let (mut low, mut high) = (-1.0, 1.0);
    for _ in 0..52 {
        let middle = 0.5 * (low + high);
        if below(middle) < share {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The root of the mean squared error of half-planes' shadows, over directions within 60° of the z axis.
    fn error(points: &[DVec3]) -> f64 {
        let (mut sum, mut tried) = (0.0, 0);
        for (tilt, turn) in (0..7).flat_map(|tilt| (0..12).map(move |turn| (tilt, turn))) {
            let (tilt, turn) = (f64::from(tilt) * TAU / 36.0, f64::from(turn) * TAU / 12.0);
            let turned = DQuat::from_rotation_z(turn) * DQuat::from_rotation_y(tilt);
            for (edge, place) in (0..12).flat_map(|edge| (-9..=9).map(move |place| (edge, place))) {
                let across = turned * DVec2::from_angle(f64::from(edge) * TAU / 12.0).extend(0.0);
                let x = f64::from(place) * 0.1;
                let share = points.iter().filter(|p| p.dot(across) < x).count() as f64 / points.len() as f64;
                let exact = 1.0 - (x.acos() - x * (1.0 - x * x).sqrt()) / PI;
                sum += (share - exact).powi(2);
                tried += 1;
            }
        }
        (sum / f64::from(tried)).sqrt()
    }

    #[test]
    fn points_of_the_ball_cover_the_disc_from_everywhere() {
        for (count, bound) in [(16, 0.055), (64, 0.022), (256, 0.0095), (1024, 0.0035)] {
            let points = ball_points(count);
            assert!(points.iter().all(|p| p.length() <= 1.0 + 1e-12));
            let error = error(&points);
            assert!(error < bound, "{count} points: {error}");
        }
    }
}
