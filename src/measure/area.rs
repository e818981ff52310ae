//! The exact reference for lights with a size, sample by sample.
//!
//! **The light** is a disc, as `shadowgraph_engine::shadow` defines it for every technique ([`LightSize::disc`]).
//!
//! **The factor** is the share of samples that nothing blocks, each judged by the very segment test of hard shadows. The
//! samples ([`disc_samples`]) are stratified and the same at every pixel, so that a technique with the same samples can
//! be compared bit by bit; with S of them the deviation from the integral is at most 0.5/√S, and far less where an edge
//! crosses the disc once.
//!
//! **Where it is cast.** A pixel gets all samples unless a pilot of [`PILOT_SAMPLES`] is of one mind there and at all
//! eight neighbours. A penumbra pixel is ambiguous when one of its samples is.

use glam::DVec2;
use shadowgraph_engine::scene::PosedCamera;
use shadowgraph_engine::shadow::{LightDisc, LightSize, disc_samples};

use super::reference::{Probe, Reference, Tracer};
use super::render::{
    Judged, LightQuery, LightReference, MOVES, Moved, Progress, Query, ReferenceImage, View, for_rows,
};

/// Samples that decide whether a pixel lies in a penumbra.
pub const PILOT_SAMPLES: u32 = 64;

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
            if size.is_wide(self.lights[query.light].position) {
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
        let LightDisc { radius, u, v } = size.disc(to_light.extend(light.position.w));
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
