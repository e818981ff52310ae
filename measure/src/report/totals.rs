//! A frame's errors, all lights together.

use crate::compare::metrics::{LightError, Measured, sees_same};
use crate::reference::channels::at;
use crate::reference::render::ReferenceImage;

/// What all lights of a frame get wrong together: counts are sums, root mean squares and means are taken over the
/// pixels of all lights, P99 and the largest values are those of the worst light.
#[derive(Clone, Debug, Default, PartialEq)]
#[allow(missing_docs, reason = "the fields are those of LightError")]
pub struct Totals {
    pub compared: usize,
    pub different_triangle: usize,
    pub boundary_pixels: usize,
    pub band_pixels: usize,
    pub wrong: usize,
    pub leak: usize,
    pub false_shadow: usize,
    pub wrong_outside_band: usize,
    pub leak_outside_band: usize,
    pub false_outside_band: usize,
    pub rmse: f64,
    /// The root mean square of what is outside its bounds, over compared pixels outside the ambiguity band of hard lights: the
    /// error of the plots.
    pub rmse_outside_band: f64,
    /// Compared pixels whose exact factor is neither 0 nor 1.
    pub penumbra_pixels: usize,
    /// The root mean square over those; 0 where there are none.
    pub penumbra_rmse: f64,
    pub signed_mean: f64,
    pub leak_mean: f64,
    pub false_mean: f64,
    pub outside_bounds: usize,
    pub p99: f64,
    pub max: f64,
    pub max_outside_band: f64,
    pub boundary_distance_mean_px: f64,
    pub boundary_distance_max_px: f64,
    /// Whether every light has what an exact technique must deliver.
    pub is_exact: bool,
}

/// A root mean square under way.
#[derive(Clone, Copy, Debug, Default)]
struct Square {
    sum: f64,
    count: usize,
}

impl Square {
    fn add(&mut self, difference: f64) {
        self.sum += difference * difference;
        self.count += 1;
    }

    fn root_mean(self) -> f64 {
        (self.sum / self.count.max(1) as f64).sqrt()
    }
}

impl Totals {
    /// The totals of `errors`, which `measured` and `reference` gave.
    pub fn of(errors: &[LightError], measured: &Measured, reference: &ReferenceImage) -> Self {
        let sum = |value: fn(&LightError) -> usize| errors.iter().map(value).sum::<usize>();
        let worst = |value: fn(&LightError) -> f64| errors.iter().map(value).fold(0.0, f64::max);
        let compared = sum(|e| e.compared);
        let wrong = sum(|e| e.wrong);
        // Weighted by the pixels that each light's mean is over; a light without any weighs nothing, whatever its mean.
        let mean = |value: fn(&LightError) -> f64, weight: fn(&LightError) -> usize| {
            let weighted = errors.iter().filter(|e| weight(e) > 0).map(|e| value(e) * weight(e) as f64);
            weighted.sum::<f64>() / sum(weight).max(1) as f64
        };
        Self {
            compared,
            different_triangle: sum(|e| e.different_triangle),
            boundary_pixels: sum(|e| e.boundary_pixels),
            band_pixels: sum(|e| e.band_pixels),
            wrong,
            leak: sum(|e| e.leak),
            false_shadow: sum(|e| e.false_shadow),
            wrong_outside_band: sum(|e| e.wrong_outside_band),
            leak_outside_band: sum(|e| e.leak_outside_band),
            false_outside_band: sum(|e| e.false_outside_band),
            rmse: mean(|e| e.rmse * e.rmse, |e| e.compared).sqrt(),
            rmse_outside_band: outside_band(measured, reference).root_mean(),
            penumbra_pixels: sum(|e| e.penumbra_pixels),
            penumbra_rmse: mean(|e| e.penumbra_rmse * e.penumbra_rmse, |e| e.penumbra_pixels).sqrt(),
            signed_mean: mean(|e| e.signed_mean, |e| e.compared),
            leak_mean: mean(|e| e.leak_mean, |e| e.compared),
            false_mean: mean(|e| e.false_mean, |e| e.compared),
            outside_bounds: sum(|e| e.outside_bounds),
            p99: worst(|e| e.p99),
            max: worst(|e| e.max),
            max_outside_band: worst(|e| e.max_outside_band),
            boundary_distance_mean_px: mean(|e| e.boundary_distance_mean_px, |e| e.wrong),
            boundary_distance_max_px: worst(|e| e.boundary_distance_max_px),
            is_exact: !errors.is_empty() && errors.iter().all(LightError::passes),
        }
    }

    /// How far the edges of shadows are off on average, in pixels: the area between an edge and the true one over its length. 0
    /// where nothing is wrong; infinite without an edge.
    pub fn edge_distance_px(&self) -> f64 {
        if self.wrong == 0 { 0.0 } else { self.wrong as f64 / self.boundary_pixels as f64 }
    }

    /// The share of compared pixels that are wrong.
    pub fn wrong_share(&self) -> f64 {
        self.wrong as f64 / self.compared.max(1) as f64
    }
}

/// How far the factors of all lights are outside their bounds, squared; of a coloured factor the channel that is farthest
/// outside. Pixels in the band of a hard light have no bounds, and do not count.
fn outside_band(measured: &Measured, reference: &ReferenceImage) -> Square {
    let mut outside = Square::default();
    let pixels = reference.hits.len();
    for light in &reference.lights {
        let Some((_, factor)) = measured.lights.iter().find(|(name, _)| *name == light.name) else {
            continue;
        };
        for pixel in 0..pixels {
            let is_judged = light.compared[pixel] && (light.soft.is_some() || !light.ambiguous[pixel]);
            if is_judged && sees_same(measured.ids[pixel], reference.hits[pixel]) {
                let channels = at(factor, pixels, pixel).zip(at(&light.factor, pixels, pixel)).enumerate();
                let beyond = channels.map(|(channel, (value, exact))| {
                    let [least, largest] = light.bounds(pixel, channel, exact).map(f64::from);
                    (least - f64::from(value)).max(f64::from(value) - largest)
                });
                outside.add(beyond.fold(0.0, f64::max));
            }
        }
    }
    outside
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Hit, LightReference, compare};

    /// One light over four pixels.
    fn pictures(factor: [f32; 4], exact: [f32; 4], ambiguous: [bool; 4]) -> (Measured, ReferenceImage) {
        let measured = Measured {
            size_px: [4, 1],
            ids: vec![[0, 0]; 4],
            lights: vec![("lamp".into(), factor.to_vec())],
        };
        let light = LightReference {
            name: "lamp".into(),
            factor: exact.to_vec(),
            compared: vec![true; 4],
            ambiguous: ambiguous.to_vec(),
            ..LightReference::default()
        };
        let hits = vec![Some(Hit { instance: 0, triangle: 0 }); 4];
        (measured, ReferenceImage { size_px: [4, 1], hits, lights: vec![light], ..ReferenceImage::default() })
    }

    #[test]
    fn the_band_and_the_penumbra_are_told_apart() {
        let (measured, reference) =
            pictures([1.0, 1.0, 0.5, 0.0], [0.0, 1.0, 0.25, 0.0], [true, false, false, false]);
        let errors = compare(&measured, &reference).expect("they belong together");
        let totals = Totals::of(&errors, &measured, &reference);
        assert_eq!((totals.wrong, totals.wrong_outside_band, totals.penumbra_pixels), (1, 0, 1));
        assert!((totals.rmse - ((1.0 + 0.0625) / 4.0_f64).sqrt()).abs() < 1e-12);
        assert!((totals.rmse_outside_band - (0.0625 / 3.0_f64).sqrt()).abs() < 1e-12);
        assert!((totals.penumbra_rmse - 0.25).abs() < 1e-12 && !totals.is_exact);
        assert_eq!(totals.max_outside_band, 0.25);
    }

    #[test]
    fn a_coloured_factor_counts_by_its_worst_channel() {
        let (mut measured, mut reference) = pictures([1.0; 4], [1.0; 4], [false; 4]);
        measured.lights[0].1 = vec![1.0, 1.0, 1.0, 1.0, 0.5, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.5];
        reference.lights[0].factor = vec![1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.25, 0.5];
        let errors = compare(&measured, &reference).expect("they belong together");
        let totals = Totals::of(&errors, &measured, &reference);
        assert!((totals.rmse_outside_band - ((0.25 + 0.0625) / 4.0_f64).sqrt()).abs() < 1e-12);
        assert_eq!((totals.rmse, errors[0].channels.len()), (totals.rmse_outside_band, 3));
    }

    #[test]
    fn no_light_is_not_exact() {
        let (measured, reference) = pictures([1.0; 4], [1.0; 4], [false; 4]);
        assert!(!Totals::of(&[], &measured, &reference).is_exact);
    }
}
