//! Reference pictures: the first hit of every pixel, each light's factor there, and where that factor is ambiguous.
//!
//! **Ambiguity band.** A rasteriser knows positions to 1/256 pixel and depth to some ulps of f32. A pixel is ambiguous
//! for a light when its factor changes under such a move of the receiver point: four moves by [`PIXEL_MOVE`] on the
//! receiving triangle's plane, two by [`DEPTH_ULPS`] along the ray. The receiving triangle is kept throughout. A move
//! that leads nowhere (parallel to the plane, behind the eye) makes the pixel ambiguous as well. What that means for lights
//! with a size is told in [`super::area`].

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::{DVec3, DVec4, Vec3};
use rayon::prelude::*;
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::plan::Antialias;
use shadowgraph_engine::scene::PosedCamera;

use super::area::{SizedCasters, SizedQuery, SoftBounds, boundary_px};
use super::disc::DiscTracer;
use super::moved::{MOVES, Moved};
use super::reference::{CasterSet, Hit, Probe, Reference, Tracer};

/// How far a pixel centre moves for the ambiguity band: rasterisers snap vertices to this fraction of a pixel.
pub const PIXEL_MOVE: f64 = 1.0 / 256.0;

/// How many ulps of f32 the receiver's depth moves for the ambiguity band.
///
/// A rasteriser evaluates depth as a plane over the target: an anchor plus two products of up to a thousand pixels
/// with slopes that are themselves quotients of rounded differences. Its absolute error is a few 2⁻²⁴ of the largest
/// depth that plane reaches over the triangle, and a triangle's depth may well vary by a factor of ten and more: some
/// tens of ulps at its far end. 64 is the next power of two. At depth near/z that is 4·10⁻⁶ to 8·10⁻⁶ of the distance
/// z, about as much as [`PIXEL_MOVE`] moves a point sideways at 1280×720, so that neither move dwarfs the other.
pub const DEPTH_ULPS: u32 = 64;

/// Told (rows done, rows in all) from any thread, in no certain order.
pub type Progress<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// A light to judge, and what casts for it. The factors of all parts are multiplied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightQuery {
    /// The index of the light in `Posed::lights`.
    pub light: usize,
    /// Indices into `Posed::instances`: what casts as if the light had no size.
    pub casters: Vec<usize>,
    /// What casts for a light with a size.
    pub sized: Vec<SizedCasters>,
    /// Indices into `Posed::instances`: their transparent surfaces cast too, as if the light had no size, and the factor
    /// is one of red, green and blue.
    pub transparent: Vec<usize>,
}

/// What is seen at every pixel, and every light's factor there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReferenceImage {
    /// Width and height in pixels; everything below is row by row, the top row first.
    pub size_px: [u32; 2],
    /// What the pixel's centre shows.
    pub hits: Vec<Option<Hit>>,
    /// One for each query, in order.
    pub lights: Vec<LightReference>,
}

/// One light's part of a [`ReferenceImage`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightReference {
    /// The light's name, as in `Posed::lights`.
    pub name: String,
    /// 1 lit, 0 dark, NaN where nothing is hit; one value for each pixel, or red, green and blue.
    pub factor: Vec<f32>,
    /// Whether the factor counts: something is hit, and the light's range and cone reach it.
    pub compared: Vec<bool>,
    /// Whether the factor changes under the moves of the ambiguity band.
    pub ambiguous: Vec<bool>,
    /// By how much, where the light has a size; without one, an ambiguous factor may be anything.
    pub soft: Option<SoftBounds>,
}

impl LightReference {
    /// The least and the largest factor that is right at a pixel, whose factor is `exact` (of one channel).
    pub(super) fn bounds(&self, pixel: usize, exact: f32) -> [f32; 2] {
        match (&self.soft, self.ambiguous[pixel]) {
            (Some(soft), _) => soft.bounds[pixel],
            (None, true) => [0.0, 1.0],
            (None, false) => [exact, exact],
        }
    }
}

/// The mean factor over each pixel, edges between surfaces included.
#[derive(Clone, Debug, PartialEq)]
pub struct SupersampledImage {
    /// Width and height in pixels.
    pub size_px: [u32; 2],
    /// For each query the light's name and, row by row, the mean factor of those sub-pixels that hit something, NaN
    /// where none does; red, green and blue where transparent surfaces cast.
    pub lights: Vec<(String, Vec<f32>)>,
}

impl Reference {
    /// The reference picture through pixel centres. A query for a light that the scene does not have is skipped.
    pub fn render(
        &self,
        camera: &PosedCamera,
        size_px: [u32; 2],
        lights: &[LightQuery],
        progress: &Progress<'_>,
    ) -> ReferenceImage {
        self.render_samples(camera, size_px, Antialias::None, lights, progress)
    }

    /// The reference through every sample of a picture that is antialiased so: a texel for each sample, as factor
    /// images have them.
    pub fn render_samples(
        &self,
        camera: &PosedCamera,
        size_px: [u32; 2],
        antialias: Antialias,
        lights: &[LightQuery],
        progress: &Progress<'_>,
    ) -> ReferenceImage {
        let mut image = self.render_untinted(camera, size_px, antialias, lights, progress);
        self.tint(camera, size_px, antialias, &self.resolve(lights), &mut image, progress);
        image
    }

    /// The same without what transparent surfaces cast.
    fn render_untinted(
        &self,
        camera: &PosedCamera,
        size_px: [u32; 2],
        antialias: Antialias,
        lights: &[LightQuery],
        progress: &Progress<'_>,
    ) -> ReferenceImage {
        let view = View::new(camera, antialias.drawn_size_px(size_px));
        let size_px = antialias.factor_size_px(size_px);
        let queries = self.resolve(lights);
        let rows = for_rows(size_px, progress, |y| {
            let mut tracers: Vec<_> = queries.iter().map(|_| self.tracer()).collect();
            let mut discs: Vec<_> = queries.iter().map(|_| self.disc_tracer()).collect();
            let mut first = self.tracer();
            let width = size_px[0] as usize;
            let mut hits = Vec::with_capacity(width);
            let mut judged = vec![Vec::with_capacity(width); queries.len()];
            // Which samples are lit, where that is wanted: a row for each part of each query.
            let mut lit: Vec<Vec<Vec<u64>>> = queries.iter().map(|query| query.lit_row(width)).collect();
            for x in 0..size_px[0] {
                let pixel = antialias.sample_place_px([x, y]);
                let seen = view.first_hit(&mut first, pixel);
                hits.push(seen.map(|(hit, _)| hit));
                let moved = seen.and_then(|(hit, t)| Moved::new(self, &view, pixel, hit, t));
                for (index, query) in queries.iter().enumerate() {
                    let (tracer, disc) = (&mut tracers[index], &mut discs[index]);
                    let judge = |moved| query.judge_all(tracer, disc, moved, &mut lit[index], x as usize);
                    judged[index].push(moved.as_ref().map(judge));
                }
            }
            (hits, judged, lit)
        });
        let hits = rows.iter().flat_map(|(hits, _, _)| hits).copied().collect();
        let lights = queries.iter().enumerate().map(|(index, query)| {
            let pixels = || rows.iter().flat_map(|(_, judged, _)| &judged[index]);
            let compared: Vec<bool> = pixels().map(|p| p.is_some_and(|p| p.compared)).collect();
            let soft = (!query.sized.is_empty()).then(|| {
                let part = |part: usize| -> Vec<u64> {
                    rows.iter().flat_map(|(_, _, lit)| &lit[index][part]).copied().collect()
                };
                SoftBounds {
                    same_samples: query.same_samples(),
                    bounds: pixels().map(|p| p.map_or([0.0, 1.0], |p| p.bounds)).collect(),
                    boundary_px: query.boundary_px(part, &compared, size_px[0] as usize),
                }
            });
            LightReference {
                name: self.lights[query.light].name.clone(),
                factor: pixels().map(|p| p.map_or(f32::NAN, |p| p.factor)).collect(),
                compared,
                ambiguous: pixels().map(|p| p.is_some_and(|p| p.ambiguous)).collect(),
                soft,
            }
        });
        ReferenceImage { size_px, hits, lights: lights.collect() }
    }

    /// The mean over `n`×`n` sub-pixels, each with its own first hit: what a picture without aliasing would show.
    pub fn render_supersampled(
        &self,
        camera: &PosedCamera,
        size_px: [u32; 2],
        lights: &[LightQuery],
        progress: &Progress<'_>,
        n: u32,
    ) -> SupersampledImage {
        let view = View::new(camera, size_px);
        let queries = self.resolve(lights);
        let n = n.max(1);
        let rows = for_rows(size_px, progress, |y| {
            let mut tracers: Vec<_> = queries.iter().map(|_| self.tracer()).collect();
            let (mut first, mut disc) = (self.tracer(), self.disc_tracer());
            let mut means = vec![Vec::with_capacity(size_px[0] as usize); queries.len()];
            for x in 0..size_px[0] {
                let mut sums = vec![Vec3::ZERO; queries.len()];
                let mut count = 0;
                for sub in 0..n * n {
                    let within = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
                    let pixel = [f64::from(x) + within(sub % n), f64::from(y) + within(sub / n)];
                    let Some((hit, t)) = view.first_hit(&mut first, pixel) else { continue };
                    let Some(point) = view.point_on(self, pixel, hit, t) else { continue };
                    count += 1;
                    for ((query, tracer), sum) in queries.iter().zip(&mut tracers).zip(&mut sums) {
                        let light = &self.lights[query.light];
                        let mut factor = Vec3::ONE;
                        if !query.sized.is_empty() {
                            let Some(moved) = Moved::new(self, &view, pixel, hit, t) else { continue };
                            factor *= query.judge_all(tracer, &mut disc, &moved, &mut [], 0).factor;
                        } else if light.reaches(point) {
                            factor *=
                                tracer.visibility_at(point, hit, view.eye, light.position, &query.casters);
                        }
                        if light.reaches(point) {
                            factor *= query.tint_at(tracer, point, hit);
                        }
                        *sum += factor;
                    }
                }
                for ((mean, sum), query) in means.iter_mut().zip(sums).zip(&queries) {
                    let channels = if query.transparent.is_some() { 3 } else { 1 };
                    let value = if count == 0 { Vec3::NAN } else { sum / count as f32 };
                    mean.extend(&value.to_array()[..channels]);
                }
            }
            means
        });
        let lights = queries.iter().enumerate().map(|(index, query)| {
            let factor = rows.iter().flat_map(|means| &means[index]).copied().collect();
            (self.lights[query.light].name.clone(), factor)
        });
        SupersampledImage { size_px, lights: lights.collect() }
    }

    pub(super) fn resolve(&self, lights: &[LightQuery]) -> Vec<Query> {
        lights
            .iter()
            .filter(|query| query.light < self.lights.len())
            .map(|query| {
                let position = self.lights[query.light].position;
                let (sized, points): (Vec<_>, Vec<_>) =
                    query.sized.iter().partition(|part| part.size.is_wide(position));
                let points = points.into_iter().flat_map(|part| &part.casters).chain(&query.casters);
                let casters: Vec<usize> = points.copied().collect();
                Query {
                    light: query.light,
                    is_hard: sized.is_empty() || !casters.is_empty(),
                    casters: self.caster_set(&casters),
                    transparent: self.transparent_set(&query.transparent),
                    sized: sized.into_iter().map(|part| SizedQuery::new(self, part)).collect(),
                }
            })
            .collect()
    }
}

/// Runs `row` for every row, in parallel, and returns what it gave from top to bottom.
pub(super) fn for_rows<T: Send>(
    size_px: [u32; 2],
    progress: &Progress<'_>,
    row: impl Fn(u32) -> T + Sync,
) -> Vec<T> {
    let done = AtomicUsize::new(0);
    (0..size_px[1])
        .into_par_iter()
        .map(|y| {
            let result = row(y);
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, size_px[1] as usize);
            result
        })
        .collect()
}

/// A camera with a target.
pub(super) struct View<'a> {
    camera: &'a PosedCamera,
    size_px: [f64; 2],
    pub(super) eye: DVec4,
}

impl<'a> View<'a> {
    pub(super) fn new(camera: &'a PosedCamera, size_px: [u32; 2]) -> Self {
        Self { camera, size_px: size_px.map(f64::from), eye: camera.frustum(size_px).eye }
    }

    /// The ray through a place of the target, in pixels from its top left corner; its parameter is the distance from
    /// the eye along the axis of view.
    pub(super) fn ray(&self, [x, y]: [f64; 2]) -> (DVec3, DVec3) {
        let [width, height] = self.size_px;
        let (ndc_x, ndc_y) = (2.0 * x / width - 1.0, 1.0 - 2.0 * y / height);
        let (origin, direction) = self.camera.projection.view_ray(ndc_x, ndc_y, width / height);
        let world_from_view = &self.camera.world_from_view;
        (world_from_view.transform_point3(origin), world_from_view.transform_vector3(direction))
    }

    pub(super) fn first_hit(&self, tracer: &mut Tracer<'_>, pixel: [f64; 2]) -> Option<(Hit, f64)> {
        let (from, direction) = self.ray(pixel);
        let projection = &self.camera.projection;
        tracer.first_hit(from, direction, projection.near_m(), projection.far_m())
    }

    /// Where the ray at distance `t` lies on the triangle of `hit`.
    fn point_on(&self, reference: &Reference, pixel: [f64; 2], hit: Hit, t: f64) -> Option<DVec3> {
        let (from, direction) = self.ray(pixel);
        Some(reference.surface(hit)?.onto_plane(from + direction * t))
    }

    /// The distance at which the depth is `ulps` ulps away from that at distance `t`.
    pub(super) fn distance_moved(&self, t: f64, ulps: f64) -> f64 {
        match self.camera.projection {
            Projection::Perspective { near_m, .. } => {
                let depth = (near_m / t) as f32;
                let ulp = f64::from(depth.next_up()) - f64::from(depth);
                near_m / (near_m / t + ulps * ulp)
            }
            // Orthographic depth is a difference of two numbers around 1 whatever its own size: an ulp is one of 1.
            Projection::Orthographic { near_m, far_m, .. } => {
                t - ulps * f64::from(f32::EPSILON) * (far_m - near_m)
            }
        }
    }
}

pub(super) struct Query {
    pub(super) light: usize,
    /// Whether anything casts as if the light had no size, or nothing casts at all.
    is_hard: bool,
    pub(super) casters: CasterSet,
    sized: Vec<SizedQuery>,
    /// Where some transparent surface casts.
    pub(super) transparent: Option<CasterSet>,
}

/// What a query says about a pixel.
#[derive(Clone, Copy)]
pub(super) struct Judged {
    pub(super) factor: f32,
    pub(super) compared: bool,
    pub(super) ambiguous: bool,
    /// The least and the largest factor that is right.
    pub(super) bounds: [f32; 2],
}

impl Query {
    /// All parts' factors, multiplied; `lit` is what [`Query::lit_row`] gave, or empty.
    fn judge_all(
        &self,
        tracer: &mut Tracer<'_>,
        disc: &mut DiscTracer<'_>,
        moved: &Moved,
        lit: &mut [Vec<u64>],
        x: usize,
    ) -> Judged {
        let hard = self.is_hard.then(|| self.judge(tracer, moved));
        if let (Some(hard), Some(row)) = (hard, lit.get_mut(self.sized.len())) {
            row[x] = u64::from(hard.factor > 0.0);
        }
        let parts = self.sized.iter().enumerate().map(|(index, part)| {
            let words = part.words();
            let row = lit.get_mut(index).map_or(&mut [][..], |row| &mut row[x * words..(x + 1) * words]);
            part.judge(disc, self.light, moved, row)
        });
        let whole = hard.into_iter().chain(parts).reduce(|a, b| Judged {
            factor: a.factor * b.factor,
            compared: a.compared && b.compared,
            ambiguous: a.ambiguous || b.ambiguous,
            bounds: [a.bounds[0] * b.bounds[0], a.bounds[1] * b.bounds[1]],
        });
        whole.unwrap_or(Judged { factor: 1.0, compared: false, ambiguous: false, bounds: [1.0; 2] })
    }

    /// How many of `light_samples` all sized parts take, if all do: the most of them.
    fn same_samples(&self) -> Option<u32> {
        self.sized
            .iter()
            .map(|part| part.same_samples)
            .reduce(|a, b| a.zip(b).map(|(a, b)| a.max(b)))
            .flatten()
    }

    /// For each sized part, and for what casts as if the light had no size, a row of lit samples; none for a light that
    /// has none, or where some samples stand for the whole light.
    fn lit_row(&self, width: usize) -> Vec<Vec<u64>> {
        let hard = (self.is_hard && !self.sized.is_empty()).then_some(width);
        let parts = self.sized.iter().map(|part| part.words() * width);
        parts.chain(hard).map(|words| vec![u64::MAX; words]).collect()
    }

    /// The boundary pixels of all parts' samples, given each part's lit samples.
    fn boundary_px(&self, lit: impl Fn(usize) -> Vec<u64>, compared: &[bool], width: usize) -> f64 {
        let parts = self.sized.iter().map(|part| (part.words(), part.samples.len()));
        let parts = parts.chain(self.is_hard.then_some((1, 1))).enumerate();
        parts.map(|(index, (words, samples))| boundary_px(&lit(index), words, samples, compared, width)).sum()
    }
}

impl Query {
    fn judge(&self, tracer: &mut Tracer<'_>, moved: &Moved) -> Judged {
        let light = &tracer.reference.lights[self.light];
        // A surface that lies in the light's own direction gets no light from it, shadowed or not: along its plane
        // every edge it shares with a caster is grazed, and which side a ray passes is rounding.
        let surface = tracer.reference.surface(moved.hit);
        let facing = surface.map_or(0, |s| s.facing(light.position));
        let compared = light.reaches(moved.points[0]) && facing != 0;
        let reached =
            (0..MOVES).filter(|i| light.reaches(moved.points[*i])).fold(0_u8, |bits, i| bits | 1 << i);
        if !moved.receives || reached == 0 {
            return Judged { factor: 1.0, compared, ambiguous: false, bounds: [1.0; 2] };
        }
        // The horizon is decided once: for a light with a size, sample by sample.
        let turned_away = facing * moved.eye_side < 0 && self.sized.is_empty();
        let dark = if turned_away {
            reached
        } else {
            let probe = Probe {
                points: &moved.points,
                off_plane_from: 5,
                receiver: Some(moved.hit),
                light: light.position,
                casters: &self.casters,
            };
            tracer.blocked(&probe) & reached
        };
        // Every move agrees when all are dark or none is. A surface turned away stays so wherever the point moves.
        let all = (1_u8 << MOVES) - 1;
        let factor = if dark & 1 == 0 { 1.0 } else { 0.0 };
        let ambiguous = (dark != 0 && dark != all) || (moved.lost && !turned_away);
        Judged { factor, compared, ambiguous, bounds: if ambiguous { [0.0, 1.0] } else { [factor; 2] } }
    }
}
