//! Fixed points that stand for a light with a size.
//!
//! *Why fixed.* A shadow is flattened onto a plane from one point, the same for the whole plane. But the light is defined
//! as the disc each receiver point sees ([`shadowgraph_engine::shadow::LightSize`]), and these discs turn from receiver to
//! receiver.
//!
//! *Points of a ball that look like a disc.* A uniform density on the unit sphere in four dimensions, of which one
//! coordinate is dropped, is the density 1/√(1 − r²) in the ball; drop any second one, and a uniform disc is left. So
//! points that are spread well over the 3-sphere, seen from afar from any direction, are spread well over the disc: no
//! point is lost on the far side, and all count the same. From nearby each counts a little more or less, by a weight in
//! closed form that the shader has (`weight` in soft_shadow.wgsl), so the mean converges to the light's factor wherever
//! the receiver is.
//!
//! *Spread well.* Super-Fibonacci spirals (Alexa 2022), and for up to [`RELAXED`] points a few rounds in which each moves
//! away from the others. Measured as the error of half-planes' shadows over all directions within 60° of the normal:
//! 16 points 0.045 (random points of the ball 0.10; a spiral on the sphere's surface, weighted by the cosine, 0.075), and
//! from there about N^-0.8.
//!
//! Directional lights need none of this: their disc of directions is the same everywhere, and its points are a spiral.

use std::f64::consts::{SQRT_2, TAU};

use glam::{DQuat, DVec2, DVec3, DVec4};
use shadowgraph_engine::scene::PosedLight;
use shadowgraph_engine::shadow::{Cache, LightSize};

/// Up to so many points are moved apart: the time grows with their square.
const RELAXED: u32 = 64;
/// How often they move.
const ROUNDS: i32 = 80;
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
    /// `count` points for `light`, or one where it has no size. `normal` is the plane's, and `nearest_m` the distance from
    /// the light's centre to the nearest receiver.
    pub(super) fn new(
        cache: &mut Cache,
        light: &PosedLight,
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
            let offset = |p: DVec2| disc.u * p.x + disc.v * p.y;
            let offsets: Vec<DVec3> = disc_spiral(count).map(offset).collect();
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

/// Points of the unit disc, evenly along a spiral.
fn disc_spiral(count: u32) -> impl Iterator<Item = DVec2> {
    let golden_rad = TAU * (1.0 - 2.0 / (1.0 + 5.0_f64.sqrt()));
    (0..count).map(move |i| {
        let radius = ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
        DVec2::from_angle(f64::from(i) * golden_rad) * radius
    })
}

/// Points of the unit ball with density 1/√(1 − r²).
fn ball_points(count: u32) -> Vec<DVec3> {
    let mut points: Vec<DVec4> = (0..count)
        .map(|i| {
            let s = f64::from(i) + 0.5;
            let share = s / f64::from(count);
            let first = DVec2::from_angle(TAU * s / SQRT_2) * share.sqrt();
            let second = DVec2::from_angle(TAU * s / PSI) * (1.0 - share).sqrt();
            DVec4::new(first.x, first.y, second.x, second.y)
        })
        .collect();
    if count <= RELAXED {
        move_apart(&mut points);
    }
    points.into_iter().map(DVec4::truncate).collect()
}

/// Moves points of the 3-sphere away from each other, in ever smaller steps.
fn move_apart(points: &mut [DVec4]) {
    let first_step = 0.2 / (points.len() as f64).cbrt();
    for round in 0..ROUNDS {
        let step = first_step * 0.6_f64.powi(round / 10);
        let before = points.to_vec();
        for (i, point) in points.iter_mut().enumerate() {
            let mut push = DVec4::ZERO;
            for (j, other) in before.iter().enumerate().filter(|(j, _)| *j != i) {
                debug_assert!(i != j);
                let away = before[i] - *other;
                push += away / away.length_squared().max(1e-9).powi(2);
            }
            *point = (before[i] + push.normalize_or_zero() * step).normalize();
        }
    }
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
                let exact = 1.0 - (x.acos() - x * (1.0 - x * x).sqrt()) / std::f64::consts::PI;
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
