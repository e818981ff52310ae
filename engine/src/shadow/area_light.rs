//! The one definition of a light with a size, which techniques and measures share.
//!
//! A spherical light of radius R at distance d from the receiver's point is the disc of radius R·d/√(d² − R²) about its
//! centre, perpendicular to the line between them, in uniform measure; inside the sphere (d ≤ R) only the centre counts.
//! A directional light of half-angle a is the disc of directions within a. Samples on the other side of the receiving
//! triangle than the eye are dark.

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DVec2, DVec3, DVec4};

use crate::scene::{ParamValue, Params};

/// The largest radius of a point or spot light that techniques take, in metres.
pub const MAX_RADIUS_M: f64 = 1e9;
/// The widest directional light that techniques take, in degrees from its middle: beyond, it would reach around the receiver.
pub const MAX_ANGLE_DEG: f64 = 60.0;

/// How large a light is: a radius for point and spot lights, an angle for directional ones. Where both are 0 it has
/// no size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightSize {
    /// The radius of a point or spot light, in metres.
    pub radius_m: f64,
    /// Half the angle under which a directional light is seen, in radians.
    pub half_angle_rad: f64,
}

/// The disc that stands for a light, as one point of a receiver sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightDisc {
    /// Its radius: in metres for w = 1, as the tangent of an angle for w = 0. 0 where only the centre counts.
    pub radius: f64,
    /// Unit axes in the disc's plane: a sample (x, y) of the unit disc lies at centre + radius·(x·u + y·v).
    pub u: DVec3,
    /// The second axis.
    pub v: DVec3,
}

impl LightSize {
    /// No size: a point, or a single direction.
    pub const NONE: Self = Self { radius_m: 0.0, half_angle_rad: 0.0 };

    /// A light of this radius, or of this half-angle in degrees if it is directional: what the options `radius` and `angle` say.
    pub fn new(radius_m: f64, angle_deg: f64) -> Self {
        Self { radius_m, half_angle_rad: angle_deg.to_radians() }
    }

    /// The size that the options `radius` (metres) and `angle` (degrees) say; an option that is left out is 0.
    pub fn of(options: &Params) -> Self {
        let number = |name: &str| match options.get(name) {
            Some(ParamValue::Number(value)) => *value,
            _ => 0.0,
        };
        Self::new(number("radius"), number("angle"))
    }

    /// Whether a light at (position, 1) or (direction towards it, 0) has a size.
    pub fn is_wide(&self, light: DVec4) -> bool {
        (if light.w == 0.0 { self.half_angle_rad } else { self.radius_m }) > 0.0
    }

    /// The disc as it is seen along `offset`: the way from the receiver's point to the light's centre for w = 1, the
    /// direction towards it for w = 0.
    pub fn disc(&self, offset: DVec4) -> LightDisc {
        let distance = offset.truncate().length();
        let radius = if offset.w == 0.0 {
            distance * self.half_angle_rad.tan()
        } else {
            let tangent = distance * distance - self.radius_m * self.radius_m;
            if tangent > 0.0 { self.radius_m * distance / tangent.sqrt() } else { 0.0 }
        };
        let (u, v) = axes_across(offset.truncate() / distance);
        LightDisc { radius, u, v }
    }
}

/// Unit axes across the unit vector `towards`: where it is +Y they are +X and −Z, from where the shortest turn takes
/// them along. Continuous but at −Y.
fn axes_across(towards: DVec3) -> (DVec3, DVec3) {
    let DVec3 { x, y, z } = towards;
    let across_squared = x * x + z * z;
    // 1/(1 + y), without cancellation where y is near −1.
    let a = if y >= 0.0 {
        1.0 / (1.0 + y)
    } else if across_squared > 0.0 {
        (1.0 - y) / across_squared
    } else {
        return (DVec3::X, DVec3::Z);
    };
    (DVec3::new(1.0 - x * x * a, -x, -x * z * a), DVec3::new(x * z * a, z, z * z * a - 1.0))
}

/// `count` points of the unit disc, one in each cell of a grid of equal areas. Equal seeds give equal points.
///
/// The grid has `count` cells, as square as the divisors of `count` allow: square numbers are best.
pub fn disc_samples(count: u32, seed: u64) -> Vec<DVec2> {
    let count = count.max(1);
    let rows = (1..=count.isqrt()).rev().find(|rows| count.is_multiple_of(*rows)).unwrap_or(1);
    let columns = count / rows;
    let mut state = seed;
    let mut random = move || {
        // SplitMix64; 53 bits make a number below 1.
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|index| {
            let cell = |place: u32, cells: u32, random: f64| {
                (f64::from(place) + random) / f64::from(cells) * 2.0 - 1.0
            };
            let x = cell(index % columns, columns, random());
            let y = cell(index / columns, rows, random());
            concentric(DVec2::new(x, y))
        })
        .collect()
}

/// The square \[−1, 1\]² onto the unit disc, equal areas onto equal areas (Shirley and Chiu).
fn concentric(square: DVec2) -> DVec2 {
    let DVec2 { x, y } = square;
    if x == 0.0 && y == 0.0 {
        return DVec2::ZERO;
    }
    let (radius, angle) =
        if x.abs() > y.abs() { (x, FRAC_PI_4 * (y / x)) } else { (y, TAU / 4.0 - FRAC_PI_4 * (x / y)) };
    DVec2::from_angle(angle) * radius
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_uniform_seeded_and_one_a_cell() {
        for count in [1, 16, 64, 1000, 4096] {
            let samples = disc_samples(count, 7);
            assert_eq!(samples.len(), count as usize);
            assert!(samples.iter().all(|sample| sample.length() <= 1.0));
            assert_eq!(samples, disc_samples(count, 7));
        }
        assert_ne!(disc_samples(16, 1), disc_samples(16, 2));
        let samples = disc_samples(4096, 3);
        let share = |inside: &dyn Fn(&DVec2) -> bool| {
            samples.iter().filter(|sample| inside(sample)).count() as f64 / 4096.0
        };
        // Half the radius is a quarter of the area, and every half-plane through the centre half of it.
        assert!((share(&|s| s.length() < 0.5) - 0.25).abs() < 0.005);
        for turn in 0..12 {
            let across = DVec2::from_angle(f64::from(turn) * TAU / 12.0);
            assert!((share(&|s| s.dot(across) > 0.0) - 0.5).abs() < 0.01, "{turn}");
        }
        let mean: DVec2 = samples.iter().sum::<DVec2>() / 4096.0;
        assert!(mean.length() < 0.002, "{mean}");
    }

    #[test]
    fn a_sphere_is_a_disc_from_outside_and_its_centre_from_inside() {
        let size = LightSize { radius_m: 3.0, half_angle_rad: 0.25 };
        let radius = |d: f64, w: f64| size.disc(DVec4::new(0.0, d, 0.0, w)).radius;
        assert!((radius(5.0, 1.0) - 3.75).abs() < 1e-12);
        assert_eq!(radius(3.0, 1.0), 0.0);
        assert_eq!(radius(1.0, 1.0), 0.0);
        assert!((radius(2.0, 0.0) - 2.0 * 0.25_f64.tan()).abs() < 1e-12);
    }

    #[test]
    fn axes_are_orthonormal_everywhere_and_turn_slowly() {
        let size = LightSize { radius_m: 0.1, half_angle_rad: 0.1 };
        let axes = |towards: DVec3| {
            let disc = size.disc(towards.extend(1.0));
            (disc.u, disc.v)
        };
        for (theta, phi) in (0..=180).flat_map(|theta| (0..36).map(move |phi| (theta, phi * 10))) {
            let (theta, phi) = (f64::from(theta).to_radians(), f64::from(phi).to_radians());
            let towards = DVec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin());
            let (u, v) = axes(towards * 2.0);
            let right = u.cross(v).dot(towards);
            assert!((u.length() - 1.0).abs() < 1e-9 && u.dot(towards).abs() < 1e-9, "{towards}: {u}");
            assert!(u.dot(v).abs() < 1e-9 && (right - 1.0).abs() < 1e-9, "{towards}: {u} {v}");
            if theta < 3.0 {
                let step = DVec3::new(1e-6, -2e-6, 1.5e-6);
                assert!((axes((towards + step).normalize()).0 - u).length() < 1e-4, "{towards}");
            }
        }
    }
}
