//! Reference pictures: the first hit of every pixel, each light's factor there, and where that factor is ambiguous.
//!
//! **Ambiguity band.** A rasteriser knows positions to 1/256 pixel and depth to some ulps of f32. A pixel is ambiguous
//! for a light when its factor changes under such a move of the receiver point: four moves by [`PIXEL_MOVE`] on the
//! receiving triangle's plane, two along the ray by [`DEPTH_ULPS`] or by what the snap of the triangle's own corners does to
//! depth, whichever is more (derived in [`super::moved`]). The receiving triangle is kept throughout, and what lies in its
//! plane casts nothing on it wherever its point is moved. A move that leads nowhere (parallel to the plane, behind the
//! eye) makes the pixel ambiguous as well. What that means for lights with a size is told in [`super::area`].
//!
//! **Ties.** Of several surfaces in one plane any may be the visible one, by rounding. The reference names them all
//! ([`ReferenceImage::ties`]), so that such a pixel is compared by their common plane, as the surface that was seen. Where
//! one of them ends within [`PIXEL_MOVE`], and a volume begins there, the pixel is ambiguous (derived in [`super::ties`]).

use std::sync::atomic::{AtomicUsize, Ordering};

use glam::Vec3;
use rayon::prelude::*;
use shadowgraph_engine::plan::Antialias;
use shadowgraph_engine::scene::CameraSnapshot;

use super::answers::Pixels;
use super::area::{SizedCasters, SoftBounds};
use super::moved::Moved;
use super::query::Asker;
use super::tracer::{Hit, Reference};
use super::view::View;

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

/// How far a rasteriser moves each coordinate of a corner, in pixels, when it snaps it to the nearest [`PIXEL_MOVE`].
pub const CORNER_SNAP: f64 = PIXEL_MOVE / 2.0;

/// A surface that gets no more than this share of a light is only grazed by it: under half a grey level of a picture
/// that the light's full share just fills. A lamp in a floor's own plane, as near as f32 can tell, lights all of the
/// floor or none; its ambiguity band has no edge to be compared with, and whatever it holds is invisible.
pub const GRAZED: f64 = 1e-3;

/// Told (rows done, rows in all) from any thread, in no certain order.
pub type Progress<'a> = dyn Fn(usize, usize) + Sync + 'a;

/// A light to judge, and what casts for it. Its factor is the product of those of all parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightQuery {
    /// The index of the light in `SceneSnapshot::lights`.
    pub light: usize,
    /// Indices into `SceneSnapshot::instances`: what casts as if the light had no size.
    pub casters: Vec<usize>,
    /// What casts for a light with a size.
    pub sized: Vec<SizedCasters>,
    /// Whether something that is not asked about here gives the light a size: what turns away from the light's centre is
    /// then not dark by itself.
    pub beside_size: bool,
    /// Indices into `SceneSnapshot::instances`: their transparent surfaces cast too, as if the light had no size, and the factor
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
    /// Other surfaces that lie in one plane with what a pixel's centre shows, and may be seen there instead: the pixel's number
    /// and the surface, pixel after pixel. See [`ReferenceImage::as_seen`].
    pub ties: Vec<(u32, Hit)>,
    /// One for each query, in order.
    pub lights: Vec<LightReference>,
}

/// One light's part of a [`ReferenceImage`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightReference {
    /// The light's name, as in `SceneSnapshot::lights`.
    pub name: String,
    /// 1 lit, 0 dark, NaN where nothing is hit; one value for each pixel, or red, green and blue.
    pub factor: Vec<f32>,
    /// Whether the factor counts: something is hit, and the light's range and cone reach it.
    pub compared: Vec<bool>,
    /// Whether the factor changes under the moves of the ambiguity band.
    pub ambiguous: Vec<bool>,
    /// Whether an ambiguous pixel is left out of the band's limit: where the light only grazes the surface
    /// ([`GRAZED`]), so that its factor is invisible; and where the surface is thinner than a pixel, or it or a caster in its
    /// plane ends within the snap: there an edge is, whether or not a shadow begins at it. Empty where not asked for.
    pub uncounted: Vec<bool>,
    /// The bounds of ambiguous factors, where the light has a size; without one, an ambiguous factor may be anything
    /// from 0 to 1.
    pub soft: Option<SoftBounds>,
    /// The answers for those [`ReferenceImage::ties`], by their places in that list, that differ from the answer for
    /// what the pixel's centre shows: such a surface may not receive shadows at all.
    pub tied: Vec<(u32, PixelReference)>,
}

/// The reference's answer for a light at one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelReference {
    /// Red, green and blue; three times the same for a factor of one channel.
    pub factor: [f32; 3],
    /// For each channel the least and the largest factor that is right.
    pub bounds: [[f32; 2]; 3],
    /// What transparent surfaces let pass of it, red, green and blue.
    pub tint: [f32; 3],
    /// Whether the factor counts.
    pub compared: bool,
    /// Whether it changes under the moves of the ambiguity band.
    pub ambiguous: bool,
    /// See [`LightReference::uncounted`].
    pub uncounted: bool,
}

impl LightReference {
    /// Whether a pixel does not count for the band's limit.
    pub(crate) fn is_uncounted(&self, pixel: usize) -> bool {
        self.uncounted.get(pixel).copied().unwrap_or_default()
    }

    /// The least and the largest factor that is right at a pixel, whose factor is `exact` in this `channel`.
    pub(crate) fn bounds(&self, pixel: usize, channel: usize, exact: f32) -> [f32; 2] {
        match (&self.soft, self.ambiguous[pixel]) {
            (Some(soft), _) if soft.bounds.len() == self.compared.len() => soft.bounds[pixel],
            (Some(soft), _) => soft.bounds[pixel * 3 + channel],
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
        camera: &CameraSnapshot,
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
        camera: &CameraSnapshot,
        size_px: [u32; 2],
        antialias: Antialias,
        lights: &[LightQuery],
        progress: &Progress<'_>,
    ) -> ReferenceImage {
        let camera = camera.fitted_to(&self.world_bounds);
        let view = View::new(&camera, antialias.drawn_size_px(size_px));
        let size_px = antialias.factor_size_px(size_px);
        let queries = self.resolve(lights);
        let rows = for_rows(size_px, progress, |y| {
            let mut askers: Vec<Asker<'_>> = queries.iter().map(|query| query.asker(self)).collect();
            let mut first = self.tracer();
            let mut pixels = Pixels::new(self, &queries);
            for x in 0..size_px[0] {
                let place = antialias.sample_place_px([x, y]);
                let seen = view.first_hit(&mut first, place);
                let moved = seen.and_then(|(hit, t)| Moved::new(self, &view, place, hit, t));
                let (Some(moved), Some((_, t))) = (moved, seen) else {
                    pixels.push(None, &mut askers);
                    continue;
                };
                let in_plane = first.in_plane_of(&moved, &view, place);
                let moved = moved.among(&in_plane);
                pixels.push(Some(&moved), &mut askers);
                for other in &in_plane.showing {
                    let other = Moved::on(other, &view, place, t).among(&in_plane);
                    pixels.push_tie(self, Some(&moved), &other, &mut askers);
                }
            }
            pixels
        });
        Pixels::new(self, &queries).picture(rows, &queries, size_px)
    }

    /// The mean over `n`×`n` sub-pixels, each with its own first hit: what a picture without aliasing would show.
    pub fn render_supersampled(
        &self,
        camera: &CameraSnapshot,
        size_px: [u32; 2],
        lights: &[LightQuery],
        progress: &Progress<'_>,
        n: u32,
    ) -> SupersampledImage {
        let camera = camera.fitted_to(&self.world_bounds);
        let view = View::new(&camera, size_px);
        let queries = self.resolve(lights);
        let n = n.max(1);
        let rows = for_rows(size_px, progress, |y| {
            let mut askers: Vec<Asker<'_>> = queries.iter().map(|query| query.asker(self)).collect();
            let mut first = self.tracer();
            let mut means = vec![Vec::with_capacity(size_px[0] as usize); queries.len()];
            for x in 0..size_px[0] {
                let mut sums = vec![Vec3::ZERO; queries.len()];
                let mut count = 0;
                for sub in 0..n * n {
                    let within = |i: u32| (f64::from(i) + 0.5) / f64::from(n);
                    let place = [f64::from(x) + within(sub % n), f64::from(y) + within(sub / n)];
                    let Some((hit, t)) = view.first_hit(&mut first, place) else { continue };
                    let Some(surface) = self.surface(hit) else { continue };
                    count += 1;
                    for (asker, sum) in askers.iter_mut().zip(&mut sums) {
                        *sum += asker.factor(surface, &view, place, t);
                    }
                }
                for ((mean, sum), query) in means.iter_mut().zip(sums).zip(&queries) {
                    let value = if count == 0 { Vec3::NAN } else { sum / count as f32 };
                    mean.extend(&value.to_array()[..query.channels()]);
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
}

/// Runs `row` for every row, in parallel, and returns what it gave from top to bottom.
pub(crate) fn for_rows<T: Send>(
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
