//! The exact reference for lights with a size, sample by sample.
//!
//! **The light.** A spherical light of radius R at distance d from the receiver's point is the disc of radius
//! R·d/√(d² − R²) about its centre, perpendicular to the line between them, in uniform measure; inside the sphere
//! (d ≤ R) the factor is the centre's. A directional light of half-angle a is the disc of directions within a. Samples on
//! the other side of the receiving triangle than the eye are dark.
//!
//! **The factor** is the share of samples that nothing blocks, each judged by the very segment test of hard shadows. The
//! samples ([`disc_samples`]) are stratified and the same at every pixel, so that a technique with the same samples can
//! be compared bit by bit; with S of them the deviation from the integral is at most 0.5/√S, and far less where an edge
//! crosses the disc once.
//!
//! **Where it is cast.** A pixel gets all samples unless a pilot of [`PILOT_SAMPLES`] is of one mind there and at all
//! eight neighbours. A penumbra pixel is ambiguous when one of its samples is.

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::{DVec2, DVec4};
use shadowgraph_engine::scene::{ParamValue, Params, PosedCamera};

use super::reference::{Probe, Reference, Tracer};
use super::render::{
    Judged, LightQuery, LightReference, MOVES, Moved, Progress, Query, ReferenceImage, View, for_rows,
};

/// Samples that decide whether a pixel lies in a penumbra.
pub const PILOT_SAMPLES: u32 = 64;

/// How large a light is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightSize {
    /// The radius of a point or spot light.
    pub radius_m: f64,
    /// Half the angle under which a directional light is seen.
    pub half_angle_rad: f64,
}

impl LightSize {
    /// A point, or a single direction.
    pub const NONE: Self = Self { radius_m: 0.0, half_angle_rad: 0.0 };

    /// What the options `radius` (metres) and `angle` (degrees) say; what is left out is 0.
    pub fn of(options: &Params) -> Self {
        let number = |name: &str| match options.get(name) {
            Some(ParamValue::Number(value)) => *value,
            _ => 0.0,
        };
        Self { radius_m: number("radius"), half_angle_rad: number("angle").to_radians() }
    }

    /// The radius of the disc that stands for the light at `offset`: the way from the receiver's point to its centre for
    /// w = 1, the direction towards it for w = 0. 0 where the centre alone counts.
    fn disc_radius(&self, offset: DVec4) -> f64 {
        let distance = offset.truncate().length();
        if offset.w == 0.0 {
            return distance * self.half_angle_rad.tan();
        }
        let tangent = distance * distance - self.radius_m * self.radius_m;
        if tangent > 0.0 { self.radius_m * distance / tangent.sqrt() } else { 0.0 }
    }
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

impl Reference {
    /// The reference picture through pixel centres for lights of these sizes, one for each query. Lights without size
    /// are those of [`Reference::render`]; for the others `samples` are cast in penumbrae.
    pub fn render_sized(
        &self,
        camera: &PosedCamera,
        size_px: [u32; 2],
        lights: &[(LightQuery, LightSize)],
        samples: &[DVec2],
        progress: &Progress<'_>,
    ) -> ReferenceImage {
        let queries: Vec<LightQuery> = lights.iter().map(|(query, _)| query.clone()).collect();
        let mut image = self.render(camera, size_px, &queries, progress);
        let sizes = lights.iter().filter(|(query, _)| query.light < self.lights.len()).map(|(_, size)| *size);
        let sized: Vec<(Query, LightSize)> = self.resolve(&queries).into_iter().zip(sizes).collect();
        for ((query, size), light) in sized.iter().zip(&mut image.lights) {
            let directional = self.lights[query.light].position.w == 0.0;
            if (if directional { size.half_angle_rad } else { size.radius_m }) > 0.0 {
                self.soften(camera, size_px, (query, *size), samples, light, progress);
            }
        }
        image
    }

    /// Puts the share of unblocked samples in the place of hard factors.
    fn soften(
        &self,
        camera: &PosedCamera,
        size_px: [u32; 2],
        (query, size): (&Query, LightSize),
        samples: &[DVec2],
        light: &mut LightReference,
        progress: &Progress<'_>,
    ) {
        let view = View::new(camera, size_px);
        let width = size_px[0] as usize;
        let pilot = disc_samples(PILOT_SAMPLES, 0);
        let judge_row =
            |y: u32, samples: &[DVec2], wanted: &(dyn Fn(usize) -> bool + Sync)| -> Vec<Option<Judged>> {
                let (mut first, mut tracer) = (self.tracer(), self.tracer());
                let judge = |x: u32| {
                    wanted(y as usize * width + x as usize).then_some(())?;
                    let pixel = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                    let (hit, t) = view.first_hit(&mut first, pixel)?;
                    let moved = Moved::new(self, &view, pixel, hit, t)?;
                    Some(query.judge_samples(&mut tracer, &moved, size, samples))
                };
                (0..size_px[0]).map(judge).collect()
            };
        let pilots = for_rows(size_px, progress, |y| judge_row(y, &pilot, &|_| true)).concat();
        let of_one_mind = |pixel: usize| {
            let (x, y) = ((pixel % width) as i64, (pixel / width) as i64);
            let factor = |x: i64, y: i64| {
                let inside = x >= 0 && x < width as i64 && y >= 0 && y < i64::from(size_px[1]);
                inside.then(|| pilots[y as usize * width + x as usize])?.map(|judged| judged.factor)
            };
            let own = factor(x, y);
            let same = |factor: Option<f32>| factor.is_none() || factor == own;
            matches!(own, Some(0.0 | 1.0)) && (0..9).all(|i| same(factor(x + i % 3 - 1, y + i / 3 - 1)))
        };
        let wanted = |pixel: usize| pilots[pixel].is_some() && !of_one_mind(pixel);
        let full = for_rows(size_px, progress, |y| judge_row(y, samples, &wanted)).concat();
        for (pixel, judged) in full.iter().zip(&pilots).map(|(full, pilot)| full.or(*pilot)).enumerate() {
            if let Some(judged) = judged {
                light.factor[pixel] = judged.factor;
                light.compared[pixel] = judged.compared;
                light.ambiguous[pixel] = judged.ambiguous;
            }
        }
    }
}

impl Query {
    /// The share of `samples` that reach the point.
    fn judge_samples(
        &self,
        tracer: &mut Tracer<'_>,
        moved: &Moved,
        size: LightSize,
        samples: &[DVec2],
    ) -> Judged {
        let light = &tracer.reference.lights[self.light];
        let center = moved.points[0];
        let compared = light.reaches(center);
        let Some(surface) = tracer.reference.surface(moved.hit).filter(|_| moved.receives && compared) else {
            return Judged { factor: 1.0, compared, ambiguous: false };
        };
        let to_light = light.position.truncate() - center * light.position.w;
        let radius = size.disc_radius(to_light.extend(light.position.w));
        let (u, v) = to_light.normalize_or(glam::DVec3::Y).any_orthonormal_pair();
        let position = |sample: &DVec2| light.position + ((u * sample.x + v * sample.y) * radius).extend(0.0);
        let just_the_center = [DVec2::ZERO];
        let samples = if radius > 0.0 { samples } else { &just_the_center };
        let all = (1_u8 << MOVES) - 1;
        let (mut lit, mut ambiguous) = (0_u32, moved.lost);
        for sample in samples {
            let light = position(sample);
            if surface.facing(light) * moved.eye_side <= 0 {
                continue;
            }
            let (receiver, casters) = (Some(moved.hit), &self.casters);
            let dark =
                tracer.blocked(&Probe { points: &moved.points, off_plane_from: 5, receiver, light, casters });
            lit += u32::from(dark & 1 == 0);
            ambiguous |= dark != 0 && dark != all;
        }
        Judged { factor: (f64::from(lit) / samples.len() as f64) as f32, compared, ambiguous }
    }
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
        let at = |d: f64, w: f64| DVec4::new(0.0, d, 0.0, w);
        assert!((size.disc_radius(at(5.0, 1.0)) - 3.75).abs() < 1e-12);
        assert_eq!(size.disc_radius(at(3.0, 1.0)), 0.0);
        assert_eq!(size.disc_radius(at(1.0, 1.0)), 0.0);
        assert!((size.disc_radius(at(2.0, 0.0)) - 2.0 * 0.25_f64.tan()).abs() < 1e-12);
    }
}
