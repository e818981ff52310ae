//! How wrong a technique is: its factors beside the reference's, light by light.
//!
//! A pixel is compared for a light when the reference hits something there that the light reaches, and the technique
//! saw the same triangle; pixels where they see different triangles are counted apart. It is *wrong* when the factors
//! differ by more than ½: a **leak** where the technique is lit and the reference dark, a **false** shadow the other
//! way round. The distribution (RMSE, mean, P99, maximum) is that of the linear difference over all compared pixels;
//! for fractional factors the RMSE over the **penumbra**, where the reference is neither 0 nor 1, is told apart, and so are
//! the means of what is too light (leak) and of what is too dark (false shadow).
//!
//! Every pixel has **bounds**: for a hard light its factor, or anything within the ambiguity band; for a light with a size
//! what its ambiguous samples allow, anywhere. Outside of them is outside, however little; that alone decides whether a
//! picture is exact. So that the band excuses nothing but edges, it may not be wider than what edges need: the band of a
//! light with a size is the mean of the bands of its samples' own shadows (the sum of all pixels' bounds), and compared with
//! the mean of their boundaries: the rule of hard shadows, sample by sample, averaged. Pixels that the light but grazes
//! ([`crate::GRAZED`]) do not count for that: they are in the band by whole surfaces, and nothing of the light is seen there. Nor do
//! those next to which the surface, or a caster in its plane, ends (`reference::ties`), and surfaces thinner than a pixel
//! (`reference::moved`): these are edges, by which no shadow may begin.
//!
//! A factor has one channel or three. A coloured one is judged channel by channel, and as a whole by the channel that
//! differs most at each pixel.

use std::cell::OnceCell;

use thiserror::Error;

use super::verdict::Verdict;
use crate::reference::channels::{HALF_FLOAT_LOSS, at, boundary, channels};
use crate::reference::render::{LightReference, ReferenceImage};
use crate::reference::tracer::Hit;

/// The band may hold this many pixels for each pixel of shadow boundary.
pub const BAND_PIXELS_PER_BOUNDARY_PIXEL: usize = 3;

/// The band may hold this many pixels beside that: shadows and gaps thinner than a pixel pass between pixel centres,
/// and then have pixels in the band but none on the boundary. More than a handful would excuse errors.
pub const BAND_FLOOR_PIXELS: usize = 16;

/// The largest share of hit pixels at which technique and reference may see different triangles before the comparison
/// says nothing: edges cross a pixel centre's 1/256 neighbourhood in about 1 % of pixels even when every pixel has one.
pub const MAX_DIFFERENT_SHARE: f64 = 0.1;

/// So many may differ in any picture: of a strip that ten pixels show, two exceed that share.
pub const DIFFERENT_FLOOR_PIXELS: usize = 4;

/// Factors that differ by more are wrong.
const WRONG_FROM: f64 = 0.5;

/// Below this factor a pixel is in shadow: what is lighter no eight-bit picture can show.
const LIT_FROM: f32 = 1.0 - 1.0 / 256.0;

/// A technique's output to be judged.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measured {
    /// Width and height in pixels; everything below is row by row, the top row first.
    pub size_px: [u32; 2],
    /// Instance and triangle of the visible surface; `u32::MAX` where nothing is.
    pub ids: Vec<[u32; 2]>,
    /// Each light's name and linear factors, one value for each pixel, or red, green and blue. Only finite values are
    /// compared; what they are where nothing is hit does not matter.
    pub lights: Vec<(String, Vec<f32>)>,
}

/// Why two pictures cannot be compared, or the comparison would be hollow.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum CompareError {
    #[error("the measured picture is {measured:?} pixels, the reference {reference:?}")]
    Size { measured: [u32; 2], reference: [u32; 2] },
    #[error("{what} has {count} values where the picture has {expected} pixels")]
    Length { what: String, count: usize, expected: usize },
    #[error("light '{light}' was not measured (measured: {measured:?})")]
    MissingLight { light: String, measured: Vec<String> },
    #[error("light '{light}' was measured, but the reference does not have it (it has {reference:?})")]
    UnknownLight { light: String, reference: Vec<String> },
    #[error(
        "light '{light}': the measured factor at pixel ({x}, {y}) is {value}, where the reference has one"
    )]
    NotFinite { light: String, x: usize, y: usize, value: f32 },
    #[error("light '{light}': no pixel could be compared")]
    NothingCompared { light: String },
    #[error(
        "light '{light}': a shadow was expected, but the {picture} has none in {compared} compared pixels"
    )]
    NoShadow { light: String, picture: &'static str, compared: usize },
}

/// The errors of one light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightError {
    /// The light.
    pub name: String,
    /// Pixels compared.
    pub compared: usize,
    /// Pixels where the reference hits something.
    pub hit_pixels: usize,
    /// Pixels at which one sees another triangle than the other, or nothing; none of them is compared.
    pub different_triangle: usize,
    /// Compared pixels that are in shadow in the reference, fully or partly.
    pub shadow_pixels: usize,
    /// Compared pixels that are in shadow in the measured picture.
    pub measured_shadow_pixels: usize,
    /// Pixels whose reference factor differs from that of the pixel to the right or below.
    pub boundary_pixels: usize,
    /// Pixels of the ambiguity band.
    pub band_pixels: usize,
    /// How wide the band is, in pixels: for a light without a size as many as it holds, for one with a size the mean of the
    /// bands of its samples' own shadows; without pixels that are [not counted](LightReference::uncounted).
    pub band_px: f64,
    /// How wide it may be: [`BAND_PIXELS_PER_BOUNDARY_PIXEL`] for each pixel of boundary, and [`BAND_FLOOR_PIXELS`].
    pub band_limit_px: f64,
    /// Whether the band is wider than it may be.
    pub band_too_wide: bool,
    /// Wrong pixels.
    pub wrong: usize,
    /// Wrong pixels that should be dark.
    pub leak: usize,
    /// Wrong pixels that should be lit.
    pub false_shadow: usize,
    /// Wrong pixels outside the band.
    pub wrong_outside_band: usize,
    /// Leaks outside the band.
    pub leak_outside_band: usize,
    /// False shadows outside the band.
    pub false_outside_band: usize,
    /// Pixels whose factor is outside its bounds by more than [`HALF_FLOAT_LOSS`] or half a sample.
    pub outside_bounds: usize,
    /// How far a factor lies outside its bounds at most: for hard lights the largest difference outside the band.
    pub max_outside_band: f64,
    /// How many samples the technique took, and the reference with it; `None` for hard lights and for whole ones.
    pub same_samples: Option<u32>,
    /// Whether some samples stand for the whole light: then what is outside bounds is no mistake but an approximation.
    pub is_converged: bool,
    /// Whether a technique of the light [approximates](shadowgraph_engine::shadow::Traits::approximates) by design.
    pub approximates: bool,
    /// Beside the whole light: what the samples that the technique took were found to be.
    pub by_samples: Option<Verdict>,
    /// Mean of what the factor is too light, 0 where it is not.
    pub leak_mean: f64,
    /// Mean of what the factor is too dark, 0 where it is not.
    pub false_mean: f64,
    /// Compared pixels whose reference factor is neither 0 nor 1.
    pub penumbra_pixels: usize,
    /// Root of the mean squared difference over those.
    pub penumbra_rmse: f64,
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Mean of measured − reference.
    pub signed_mean: f64,
    /// The absolute difference that 99 % of pixels do not exceed.
    pub p99: f64,
    /// The largest absolute difference.
    pub max: f64,
    /// Mean distance of wrong pixels from the nearest boundary pixel; 0 without wrong pixels, infinite without boundary.
    pub boundary_distance_mean_px: f64,
    /// Largest distance of a wrong pixel from the nearest boundary pixel.
    pub boundary_distance_max_px: f64,
    /// The same of red, green and blue where the factor is coloured; empty otherwise.
    pub channels: Vec<Self>,
}

/// Judges every light of `reference`.
///
/// # Errors
/// Each way in which the pictures do not belong together is one variant of [`CompareError`].
pub fn compare(measured: &Measured, reference: &ReferenceImage) -> Result<Vec<LightError>, CompareError> {
    if measured.size_px != reference.size_px {
        return Err(CompareError::Size { measured: measured.size_px, reference: reference.size_px });
    }
    let expected = reference.size_px[0] as usize * reference.size_px[1] as usize;
    let length = |what: &dyn Fn() -> String, count: usize| {
        if count == expected { Ok(()) } else { Err(CompareError::Length { what: what(), count, expected }) }
    };
    let factor_length = |what: &dyn Fn() -> String, count: usize| {
        if count == 3 * expected { Ok(()) } else { length(what, count) }
    };
    length(&|| "the measured id picture".into(), measured.ids.len())?;
    let reference = &*reference.as_seen(&measured.ids);
    length(&|| "the reference".into(), reference.hits.len())?;
    for (name, factor) in &measured.lights {
        factor_length(&|| format!("the measured factor of light '{name}'"), factor.len())?;
        if !reference.lights.iter().any(|light| light.name == *name) {
            let reference = reference.lights.iter().map(|light| light.name.clone()).collect();
            return Err(CompareError::UnknownLight { light: name.clone(), reference });
        }
    }
    reference
        .lights
        .iter()
        .map(|light| {
            factor_length(
                &|| format!("the reference's factor of light '{}'", light.name),
                light.factor.len(),
            )?;
            for (what, count) in [("compared", light.compared.len()), ("ambiguous", light.ambiguous.len())] {
                length(&|| format!("the reference's '{what}' of light '{}'", light.name), count)?;
            }
            let (_, factor) =
                measured.lights.iter().find(|(name, _)| *name == light.name).ok_or_else(|| {
                    let measured = measured.lights.iter().map(|(name, _)| name.clone()).collect();
                    CompareError::MissingLight { light: light.name.clone(), measured }
                })?;
            compare_light(measured, factor, reference, light)
        })
        .collect()
}

/// Whether both see the same surface, or both none.
pub(crate) fn sees_same(ids: [u32; 2], hit: Option<Hit>) -> bool {
    hit.map_or([u32::MAX; 2], |hit| [hit.instance, hit.triangle]) == ids
}

/// What is judged at one pixel.
#[derive(Clone, Copy)]
struct Sample {
    /// Of a coloured factor judged as a whole: the channel that differs most.
    difference: f64,
    /// How far it lies outside its bounds.
    outside: f64,
    is_dark: bool,
    measured_dark: bool,
    in_penumbra: bool,
}

impl Sample {
    fn of(value: f32, exact: f32, [least, largest]: [f32; 2]) -> Self {
        Self {
            difference: f64::from(value) - f64::from(exact),
            outside: (f64::from(least) - f64::from(value))
                .max(f64::from(value) - f64::from(largest))
                .max(0.0),
            is_dark: exact < LIT_FROM,
            measured_dark: value < LIT_FROM,
            in_penumbra: exact > 0.0 && exact < 1.0,
        }
    }

    /// The whole of what two channels say.
    fn with(self, other: Self) -> Self {
        let differs_more = other.difference.abs() > self.difference.abs();
        Self {
            difference: if differs_more { other.difference } else { self.difference },
            outside: self.outside.max(other.outside),
            is_dark: self.is_dark || other.is_dark,
            measured_dark: self.measured_dark || other.measured_dark,
            in_penumbra: self.in_penumbra || other.in_penumbra,
        }
    }
}

fn compare_light(
    measured: &Measured,
    factor: &[f32],
    reference: &ReferenceImage,
    light: &LightReference,
) -> Result<LightError, CompareError> {
    let width = reference.size_px[0] as usize;
    let pixels = reference.hits.len();
    let channels = channels(factor, pixels).max(channels(&light.factor, pixels));
    let boundary = boundary(&light.factor, &light.compared, width);
    let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
    let mut error = LightError {
        name: light.name.clone(),
        hit_pixels: reference.hits.iter().flatten().count(),
        boundary_pixels: count(&boundary),
        same_samples: light.soft.as_ref().and_then(|soft| soft.same_samples),
        is_converged: light.soft.as_ref().is_some_and(|soft| soft.same_samples.is_none()),
        ..LightError::default()
    };
    let mut compared = Vec::new();
    for (pixel, (ids, hit)) in measured.ids.iter().zip(&reference.hits).enumerate() {
        if !sees_same(*ids, *hit) {
            error.different_triangle += 1;
        } else if light.compared[pixel] {
            let value = at(factor, pixels, pixel).find(|value| !value.is_finite());
            if let Some(value) = value {
                let (x, y) = (pixel % width, pixel / width);
                return Err(CompareError::NotFinite { light: light.name.clone(), x, y, value });
            }
            compared.push(pixel);
        }
    }
    (error.band_pixels, error.band_px) = band(light, channels);
    let boundary_px = boundary_px(&error, light, width);
    error.band_limit_px = BAND_PIXELS_PER_BOUNDARY_PIXEL as f64 * boundary_px + BAND_FLOOR_PIXELS as f64;
    error.band_too_wide = error.band_px > error.band_limit_px;
    let distances = OnceCell::new();
    let judge = |name: &str, sample: &dyn Fn(usize) -> Sample| {
        let mut error = LightError { name: name.into(), compared: compared.len(), ..error.clone() };
        error.judge(&compared, sample, &|pixel| {
            distances.get_or_init(|| super::distance::distances(&boundary, width))[pixel]
        });
        error
    };
    let channel = |pixel: usize, channel: usize| {
        let of = |values: &[f32]| at(values, pixels, pixel).nth(channel).unwrap_or(f32::NAN);
        let exact = of(&light.factor);
        Sample::of(of(factor), exact, light.bounds(pixel, channel, exact))
    };
    if channels == 1 {
        return Ok(judge(&light.name, &|pixel| channel(pixel, 0)));
    }
    let whole = |pixel: usize| channel(pixel, 0).with(channel(pixel, 1)).with(channel(pixel, 2));
    let parts = ["red", "green", "blue"]
        .iter()
        .enumerate()
        .map(|(index, name)| judge(&format!("{} {name}", light.name), &|pixel| channel(pixel, index)));
    Ok(LightError { channels: parts.collect(), ..judge(&light.name, &whole) })
}

/// How many pixels the band has, and how many it has if each counts as far as its bounds are apart.
fn band(light: &LightReference, channels: usize) -> (usize, f64) {
    let (mut pixels, mut px) = (0, 0.0);
    for pixel in (0..light.compared.len()).filter(|pixel| light.compared[*pixel] && light.ambiguous[*pixel]) {
        let width = |channel| light.bounds(pixel, channel, 0.0).into_iter().rev().reduce(|a, b| a - b);
        pixels += 1;
        let counts = if light.is_uncounted(pixel) { 0..0 } else { 0..channels };
        px += counts.filter_map(width).map(f64::from).fold(0.0, f64::max);
    }
    (pixels, px)
}

/// The length of the shadow's boundary in pixels, which bounds its band.
fn boundary_px(error: &LightError, light: &LightReference, width: usize) -> f64 {
    match &light.soft {
        None => error.boundary_pixels as f64,
        Some(soft) if !error.is_converged => soft.boundary_px,
        // Of a whole light the samples' own boundaries are not known. Together they are no less than the steps of the factor.
        Some(_) => steps_px(&light.factor, &light.compared, width),
    }
}

impl LightError {
    /// Whether technique and reference see the same surfaces, but for what edges next to pixel centres explain.
    pub fn sees_same(&self) -> bool {
        let share = MAX_DIFFERENT_SHARE * self.hit_pixels as f64;
        self.different_triangle as f64 <= share.max(DIFFERENT_FLOOR_PIXELS as f64)
    }

    /// Fills in everything that depends on the factors, over the `compared` pixels.
    fn judge(
        &mut self,
        compared: &[usize],
        sample: &dyn Fn(usize) -> Sample,
        boundary_distance_px: &dyn Fn(usize) -> f64,
    ) {
        let mut differences = Vec::with_capacity(compared.len());
        let mut penumbra_sum = 0.0;
        let mut distance_sum_px = 0.0;
        // Of many samples a single one is less than half floats lose.
        let allowed = HALF_FLOAT_LOSS.min(0.5 / f64::from(self.same_samples.unwrap_or(1)));
        for &pixel in compared {
            let Sample { difference, outside, is_dark, measured_dark, in_penumbra } = sample(pixel);
            self.max_outside_band = self.max_outside_band.max(outside);
            let outside = outside > allowed;
            self.outside_bounds += usize::from(outside);
            self.shadow_pixels += usize::from(is_dark);
            self.measured_shadow_pixels += usize::from(measured_dark);
            differences.push(difference);
            if in_penumbra {
                self.penumbra_pixels += 1;
                penumbra_sum += difference * difference;
            }
            if difference.abs() > WRONG_FROM {
                let is_leak = difference > 0.0;
                self.wrong += 1;
                self.leak += usize::from(is_leak);
                self.false_shadow += usize::from(!is_leak);
                self.wrong_outside_band += usize::from(outside);
                self.leak_outside_band += usize::from(is_leak && outside);
                self.false_outside_band += usize::from(!is_leak && outside);
                let distance_px = boundary_distance_px(pixel);
                distance_sum_px += distance_px;
                self.boundary_distance_max_px = self.boundary_distance_max_px.max(distance_px);
            }
        }
        if self.wrong > 0 {
            self.boundary_distance_mean_px = distance_sum_px / self.wrong as f64;
        }
        if self.penumbra_pixels > 0 {
            self.penumbra_rmse = (penumbra_sum / self.penumbra_pixels as f64).sqrt();
        }
        self.describe(differences);
    }

    /// Fills in the distribution of the `differences`.
    fn describe(&mut self, mut differences: Vec<f64>) {
        let count = differences.len();
        if count == 0 {
            return;
        }
        self.signed_mean = differences.iter().sum::<f64>() / count as f64;
        self.leak_mean = differences.iter().map(|d| d.max(0.0)).sum::<f64>() / count as f64;
        self.false_mean = differences.iter().map(|d| (-d).max(0.0)).sum::<f64>() / count as f64;
        self.rmse = (differences.iter().map(|d| d * d).sum::<f64>() / count as f64).sqrt();
        for difference in &mut differences {
            *difference = difference.abs();
        }
        // Nearest rank: the smallest value that at least 99 % of pixels do not exceed.
        let rank = (count * 99).div_ceil(100) - 1;
        let (_, p99, above) = differences.select_nth_unstable_by(rank, f64::total_cmp);
        self.p99 = *p99;
        self.max = above.iter().copied().fold(*p99, f64::max);
    }
}

/// How much `factor` changes from each compared pixel to its right or lower neighbour, whichever is more; added up.
fn steps_px(factor: &[f32], compared: &[bool], width: usize) -> f64 {
    let pixels = compared.len();
    let step = |a: usize, b: usize| {
        let both = b < pixels && compared[a] && compared[b];
        let pairs = both.then(|| at(factor, pixels, a).zip(at(factor, pixels, b)));
        pairs.into_iter().flatten().map(|(a, b)| f64::from((a - b).abs())).fold(0.0, f64::max)
    };
    let steps = (0..pixels).map(|i| {
        let right = if (i + 1) % width == 0 { 0.0 } else { step(i, i + 1) };
        right.max(step(i, i + width))
    });
    steps.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p99_is_the_nearest_rank() {
        let mut error = LightError::default();
        error.describe((1..=200).map(f64::from).collect());
        assert_eq!((error.p99, error.max, error.signed_mean), (198.0, 200.0, 100.5));
    }
}
