//! What is seen pixel by pixel and what each query says of it, gathered into pictures.

use std::borrow::Cow;

use super::moved::Moved;
use super::query::{Asker, Query};
use super::render::{LightReference, PixelReference, ReferenceImage};
use super::tracer::{Hit, Reference};
use super::{SoftBounds, channels};

/// A picture on the way: some of its pixels, in order.
pub(crate) struct Pixels {
    image: ReferenceImage,
    /// For each query what [`ReferenceImage`] does not keep.
    samples: Vec<LitSamples>,
}

/// Which of a query's samples are lit, where it has any.
struct LitSamples {
    /// For each part of the query so many words a pixel.
    words: Vec<usize>,
    lit: Vec<Vec<u64>>,
    /// What transparent surfaces leave, for a light with a size: its steps are boundaries too.
    tints: Option<Vec<[f32; 3]>>,
}

impl Pixels {
    pub(crate) fn new(reference: &Reference, queries: &[Query]) -> Self {
        let light = |query: &Query| LightReference {
            name: reference.lights[query.light].name.clone(),
            soft: (!query.sized.is_empty())
                .then(|| SoftBounds { same_samples: query.same_samples(), ..SoftBounds::default() }),
            ..LightReference::default()
        };
        let samples = |query: &Query| {
            let words = query.words();
            let tints = (!query.sized.is_empty() && query.transparent.is_some()).then(Vec::new);
            LitSamples { lit: vec![Vec::new(); words.len()], words, tints }
        };
        Self {
            image: ReferenceImage {
                lights: queries.iter().map(light).collect(),
                ..ReferenceImage::default()
            },
            samples: queries.iter().map(samples).collect(),
        }
    }

    /// Adds a pixel at which `seen` is seen, or nothing.
    pub(crate) fn push(&mut self, seen: Option<&Moved<'_>>, askers: &mut [Asker<'_>]) {
        self.image.hits.push(seen.map(|moved| moved.surface.as_hit()));
        for ((light, samples), asker) in self.image.lights.iter_mut().zip(&mut self.samples).zip(askers) {
            for (lit, words) in samples.lit.iter_mut().zip(&samples.words) {
                lit.resize(lit.len() + words, u64::MAX);
            }
            let answer = seen.map(|moved| asker.judge(moved, &mut samples.lit));
            let answer = answer.unwrap_or(PixelReference::NOTHING);
            light.push(&answer, asker.query.channels());
            if let Some(tints) = &mut samples.tints {
                tints.push(answer.tint);
            }
        }
    }

    /// Says that at the pixel last added `other`, in the plane of what is seen there, may be seen instead.
    pub(crate) fn push_tie(
        &mut self,
        reference: &Reference,
        seen: Option<&Moved<'_>>,
        other: &Moved<'_>,
        askers: &mut [Asker<'_>],
    ) {
        let tie = self.image.ties.len() as u32;
        self.image.ties.push((self.image.hits.len() as u32 - 1, other.surface.as_hit()));
        for (light, asker) in self.image.lights.iter_mut().zip(askers) {
            if !seen.is_some_and(|seen| asker.query.says_same(reference, [seen, other])) {
                light.tied.push((tie, asker.judge(other, &mut [])));
            }
        }
    }

    /// Adds the pixels of `next` behind its own.
    fn append(&mut self, next: Self) {
        let (pixels, ties) = (self.image.hits.len() as u32, self.image.ties.len() as u32);
        self.image.hits.extend(next.image.hits);
        self.image.ties.extend(next.image.ties.into_iter().map(|(pixel, hit)| (pixel + pixels, hit)));
        for (light, next) in self.image.lights.iter_mut().zip(next.image.lights) {
            light.factor.extend(next.factor);
            light.compared.extend(next.compared);
            light.ambiguous.extend(next.ambiguous);
            light.uncounted.extend(next.uncounted);
            light.tied.extend(next.tied.into_iter().map(|(tie, answer)| (tie + ties, answer)));
            if let (Some(soft), Some(next)) = (&mut light.soft, next.soft) {
                soft.bounds.extend(next.bounds);
            }
        }
        for (samples, next) in self.samples.iter_mut().zip(next.samples) {
            samples.lit.iter_mut().zip(next.lit).for_each(|(lit, next)| lit.extend(next));
            if let (Some(tints), Some(next)) = (&mut samples.tints, next.tints) {
                tints.extend(next);
            }
        }
    }

    /// The picture of these rows.
    pub(crate) fn picture(
        mut self,
        rows: impl IntoIterator<Item = Self>,
        queries: &[Query],
        size_px: [u32; 2],
    ) -> ReferenceImage {
        rows.into_iter().for_each(|row| self.append(row));
        let Self { mut image, samples } = self;
        image.size_px = size_px;
        let width = size_px[0] as usize;
        for ((light, samples), query) in image.lights.iter_mut().zip(&samples).zip(queries) {
            if let Some(soft) = &mut light.soft {
                soft.boundary_px = query.boundary_px(&samples.lit, &light.compared, width);
                if let Some(tints) = &samples.tints {
                    let steps = channels::boundary(tints.as_flattened(), &light.compared, width);
                    soft.boundary_px += steps.iter().filter(|is_step| **is_step).count() as f64;
                }
            }
        }
        image
    }
}

impl PixelReference {
    /// Where nothing is seen.
    const NOTHING: Self = Self {
        factor: [f32::NAN; 3],
        bounds: [[0.0, 1.0]; 3],
        tint: [1.0; 3],
        compared: false,
        ambiguous: false,
        uncounted: false,
    };
}

impl LightReference {
    /// Adds a pixel.
    fn push(&mut self, answer: &PixelReference, channels: usize) {
        self.factor.extend(&answer.factor[..channels]);
        self.compared.push(answer.compared);
        self.ambiguous.push(answer.ambiguous);
        self.uncounted.push(answer.uncounted);
        if let Some(soft) = &mut self.soft {
            soft.bounds.extend(&answer.bounds[..channels]);
        }
    }

    /// Replaces what is said of a pixel.
    fn put(&mut self, pixel: usize, answer: &PixelReference) {
        let channels = channels::channels(&self.factor, self.compared.len());
        let values = pixel * channels..(pixel + 1) * channels;
        self.factor[values.clone()].copy_from_slice(&answer.factor[..channels]);
        self.compared[pixel] = answer.compared;
        self.ambiguous[pixel] = answer.ambiguous;
        self.uncounted[pixel] = answer.uncounted;
        if let Some(soft) = &mut self.soft {
            soft.bounds[values].copy_from_slice(&answer.bounds[..channels]);
        }
    }
}

impl ReferenceImage {
    /// What is right for a picture that shows `ids` (instance and triangle at each pixel): the same, but where that shows another
    /// surface in the plane of what the reference sees first ([`ReferenceImage::ties`]), what is right for that surface.
    pub fn as_seen(&self, ids: &[[u32; 2]]) -> Cow<'_, Self> {
        let is_seen =
            |(pixel, hit): &(u32, Hit)| ids.get(*pixel as usize) == Some(&[hit.instance, hit.triangle]);
        if !self.ties.iter().any(is_seen) {
            return Cow::Borrowed(self);
        }
        let mut image = self.clone();
        for (pixel, hit) in self.ties.iter().filter(|tie| is_seen(tie)) {
            image.hits[*pixel as usize] = Some(*hit);
        }
        for light in &mut image.lights {
            for (tie, answer) in std::mem::take(&mut light.tied) {
                let tie = &self.ties[tie as usize];
                if is_seen(tie) {
                    light.put(tie.0 as usize, &answer);
                }
            }
        }
        image.ties.clear();
        Cow::Owned(image)
    }
}
