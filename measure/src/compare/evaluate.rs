//! Rendering a scene on the GPU and judging every light's factor against the reference.

use std::borrow::Cow;
use std::sync::Arc;

use shadowgraph_engine::gpu::Timing;
use shadowgraph_engine::plan::Antialias;
use shadowgraph_engine::render::{
    FactorImage, Frame, FrameLayer, FrameRequest, RenderError, RenderOptions, Renderer,
};
use shadowgraph_engine::scene::{Scene, SceneSnapshot};
use shadowgraph_engine::shadow::{Claim, LightSize, Registry};
use thiserror::Error;

use crate::{
    CONVERGED_SAMPLES, CompareError, Hit, LightError, LightQuery, Measured, Progress, Reference,
    ReferenceImage, Samples, SizedCasters, compare,
};

/// Why a scene could not be judged.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "each is explained where it is defined")]
pub enum EvaluateError {
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Compare(#[from] CompareError),
    #[error("no shadow node serves any light of the scene: there is nothing to compare")]
    NothingToCompare,
}

/// A frame with its factors, the reference's, and how they differ.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The frame, factors read back.
    pub frame: Frame,
    /// What was measured.
    pub measured: Measured,
    /// What is right.
    pub reference: Arc<ReferenceImage>,
    /// One entry for each light that a shadow node serves.
    pub errors: Vec<LightError>,
    /// What the reference was asked.
    pub queries: Vec<LightQuery>,
}

/// A picture beside the whole light, where [`Evaluation`] has it beside the samples that a technique takes itself.
#[derive(Clone, Debug)]
pub struct Converged {
    /// What is right.
    pub reference: Arc<ReferenceImage>,
    /// One entry for each light that a shadow node serves.
    pub errors: Vec<LightError>,
}

/// What the reference is asked about: every light that a shadow node serves, with its casters, each as large as the
/// technique that it casts through takes the light to be. A technique that takes samples is asked for the same ones; for the
/// others [`CONVERGED_SAMPLES`] stand for the whole light.
pub fn queries(registry: &Registry) -> Vec<LightQuery> {
    queries_with(registry, CONVERGED_SAMPLES)
}

/// [`queries`] with so many samples for a whole light.
pub fn queries_with(registry: &Registry, converged: u32) -> Vec<LightQuery> {
    let served = registry.lights.iter().enumerate().filter(|(_, claims)| !claims.is_empty());
    let query = |(light, claims): (usize, &Vec<Claim>)| {
        let mut query = LightQuery { light, ..LightQuery::default() };
        for Claim { technique, casters, .. } in claims {
            let traits = technique.traits();
            let size = traits.light_size;
            let transparent = if traits.casts_transparent { &casters[..] } else { &[] };
            if size == LightSize::NONE {
                query.casters.extend(casters);
                query.transparent.extend(transparent);
                continue;
            }
            let samples = traits.light_samples.map_or(Samples::Converged(converged), Samples::Same);
            match query.sized.iter_mut().find(|part| part.size == size && part.samples == samples) {
                // One light's casters hide the union of what they hide, however many nodes claim them.
                Some(part) => {
                    part.casters.extend(casters);
                    part.transparent.extend(transparent);
                }
                None => query.sized.push(SizedCasters {
                    casters: casters.clone(),
                    transparent: transparent.to_vec(),
                    size,
                    samples,
                }),
            }
        }
        query.casters.sort_unstable();
        query.transparent.sort_unstable();
        for part in &mut query.sized {
            part.casters.sort_unstable();
            part.transparent.sort_unstable();
        }
        query
    };
    served.map(query).collect()
}

/// The same queries with `count` samples for the whole light in the place of a technique's own; `None` where no technique
/// takes its own.
pub fn converged_queries(queries: &[LightQuery], count: u32) -> Option<Vec<LightQuery>> {
    let mut converged = queries.to_vec();
    let parts = converged.iter_mut().flat_map(|query| &mut query.sized);
    let own = parts.filter(|part| matches!(part.samples, Samples::Same(_)));
    let own = own.map(|part| part.samples = Samples::Converged(count)).count();
    (own > 0).then_some(converged)
}

/// What a frame with factors measured, in the reference's terms: NaN where nothing is hit, red, green and blue apart
/// where a technique left them so.
/// `size_px` is the size of the factor images: see [`Antialias::factor_size_px`].
///
/// # Errors
/// When the frame's factors cannot be read as floats.
pub fn measured(frame: &Frame, size_px: [u32; 2]) -> Result<Measured, RenderError> {
    let ids = frame.visible_triangles.clone().unwrap_or_default();
    measured_of(ids, &frame.factors, size_px)
}

/// The same of one layer of transparent surfaces.
///
/// # Errors
/// When the factors cannot be read as floats.
pub fn layer_measured(layer: &FrameLayer, size_px: [u32; 2]) -> Result<Measured, RenderError> {
    measured_of(layer.triangles.clone(), &layer.factors, size_px)
}

fn measured_of(
    ids: Vec<[u32; 2]>,
    factors: &[FactorImage],
    size_px: [u32; 2],
) -> Result<Measured, RenderError> {
    let mut lights = Vec::new();
    for factor in factors {
        let floats = factor.pixels.floats()?;
        let stored = (floats.len() / ids.len().max(1)).max(1);
        // A fourth channel only fills the texel.
        let channels = if stored == 1 { 1 } else { 3 };
        let texels = ids.iter().zip(floats.chunks_exact(stored));
        let values = texels.flat_map(|(id, texel)| {
            texel.iter().take(channels).map(|value| if id[0] == u32::MAX { f32::NAN } else { *value })
        });
        lights.push((factor.light.clone(), values.collect()));
    }
    Ok(Measured { size_px, ids, lights })
}

/// The mean of every pixel's four samples, of a frame that was antialiased: those that show a surface, NaN where none
/// does. `values` are those of [`Measured`] or [`crate::LightReference`], as large as `size_px`.
pub fn mean_of_samples(size_px: [u32; 2], values: &[f32]) -> Vec<f32> {
    let [width, height] = size_px.map(|n| n as usize);
    let channels = (values.len() / (width * height).max(1)).max(1);
    let mean = |x: usize, y: usize, channel: usize| {
        let samples = [(0, 0), (1, 0), (0, 1), (1, 1)]
            .map(|(dx, dy)| values[((y * 2 + dy) * width + x * 2 + dx) * channels + channel]);
        let seen: Vec<f32> = samples.into_iter().filter(|value| !value.is_nan()).collect();
        if seen.is_empty() { f32::NAN } else { seen.iter().sum::<f32>() / seen.len() as f32 }
    };
    let pixels = (0..height / 2).flat_map(|y| (0..width / 2).map(move |x| (x, y)));
    pixels.flat_map(|(x, y)| (0..channels).map(move |channel| mean(x, y, channel))).collect()
}

/// What a reference answers.
type Asked = (Antialias, Vec<LightQuery>);

/// References of one scene seen by one camera, so that several techniques and settings are judged by the same picture,
/// traced once for each choice of lights and casters.
#[derive(Clone, Debug)]
pub struct KnownReferences {
    known: Vec<(Asked, Arc<ReferenceImage>)>,
    converged_samples: u32,
}

impl Default for KnownReferences {
    fn default() -> Self {
        Self { known: Vec::new(), converged_samples: CONVERGED_SAMPLES }
    }
}

impl KnownReferences {
    /// None known yet; `count` samples stand for a whole light.
    pub fn with_samples(count: u32) -> Self {
        Self { converged_samples: count, ..Self::default() }
    }

    /// The picture that answers `queries`, traced if it is not known yet.
    fn answer(
        &mut self,
        snapshot: &SceneSnapshot,
        request: &FrameRequest,
        queries: Vec<LightQuery>,
        progress: &Progress<'_>,
    ) -> Arc<ReferenceImage> {
        let asked = (request.antialias, queries);
        if let Some((_, image)) = self.known.iter().find(|(known, _)| *known == asked) {
            return Arc::clone(image);
        }
        let FrameRequest { camera, size_px, antialias, .. } = request;
        let reference = Reference::new(snapshot);
        let image = Arc::new(reference.render_samples(camera, *size_px, *antialias, &asked.1, progress));
        self.known.push((asked, Arc::clone(&image)));
        image
    }
}

/// What is to be compared of a reference: where a technique shades receivers only, no other pixel. `None` where all of it
/// is.
pub(crate) fn on_receivers(registry: &Registry, image: &ReferenceImage) -> Option<ReferenceImage> {
    let mut restricted = None;
    let claims = registry.lights.iter().filter(|claims| !claims.is_empty());
    for (light, claims) in claims.enumerate() {
        for claim in claims.iter().filter(|claim| claim.technique.traits().shades_receivers_only) {
            let ReferenceImage { hits, lights, .. } = restricted.get_or_insert_with(|| image.clone());
            let receives = |hit: &Hit| claim.receivers.binary_search(&(hit.instance as usize)).is_ok();
            for (hit, compared) in hits.iter().zip(&mut lights[light].compared) {
                *compared &= hit.as_ref().is_some_and(receives);
            }
        }
    }
    restricted
}

/// What `measured` is compared with: what is right for the surfaces that it shows, where it is compared.
fn as_compared(
    registry: &Registry,
    mut reference: Arc<ReferenceImage>,
    measured: &Measured,
) -> Arc<ReferenceImage> {
    if let Cow::Owned(image) = reference.as_seen(&measured.ids) {
        reference = Arc::new(image);
    }
    on_receivers(registry, &reference).map_or(reference, Arc::new)
}

/// [`compare`], with what is known of the techniques of each light.
pub(crate) fn compared(
    (snapshot, registry): (&SceneSnapshot, &Registry),
    measured: &Measured,
    reference: &ReferenceImage,
) -> Result<Vec<LightError>, CompareError> {
    let approximates = |claim: &Claim| claim.technique.traits().approximates;
    let mut errors = compare(measured, reference)?;
    for error in &mut errors {
        let mut lights = snapshot.lights.iter().zip(&registry.lights);
        let claims = lights.find(|(light, _)| light.name == error.name).map(|(_, claims)| claims);
        error.approximates = claims.is_some_and(|claims| claims.iter().any(approximates));
        error.channels.iter_mut().for_each(|channel| channel.approximates = error.approximates);
    }
    Ok(errors)
}

/// Renders `scene` with its own shadow nodes and compares.
///
/// # Errors
/// [`EvaluateError`].
pub fn evaluate(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    progress: &Progress<'_>,
) -> Result<Evaluation, EvaluateError> {
    evaluate_again(renderer, scene, request, &mut KnownReferences::default(), progress)
}

/// Renders `scene` with its own shadow nodes and compares with a reference that may be known already. `references` are
/// those of this scene but for the techniques and options of its shadow nodes, and of this camera and size.
///
/// # Errors
/// [`EvaluateError`].
pub fn evaluate_again(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    references: &mut KnownReferences,
    progress: &Progress<'_>,
) -> Result<Evaluation, EvaluateError> {
    let request = FrameRequest { factors: true, ..request.clone() };
    let options = RenderOptions { read_picture: true, timing: Timing::Off, ..RenderOptions::default() };
    let frame = renderer.render(scene, &request, &options)?;
    let (snapshot, registry): (Arc<SceneSnapshot>, Arc<Registry>) = renderer.snapshot(scene)?;
    let queries = queries_with(&registry, references.converged_samples);
    if queries.is_empty() {
        return Err(EvaluateError::NothingToCompare);
    }
    let reference = references.answer(&snapshot, &request, queries.clone(), progress);
    let measured = measured(&frame, request.antialias.factor_size_px(request.size_px))?;
    let reference = as_compared(&registry, reference, &measured);
    let errors = compared((&snapshot, &registry), &measured, &reference)?;
    Ok(Evaluation { frame, measured, reference, errors, queries })
}

/// Compares what [`evaluate_again`] measured with the whole light, where that judged samples; `None` where no technique
/// takes samples. `scene` and `request` are those that were evaluated.
///
/// # Errors
/// [`EvaluateError`].
pub fn evaluate_converged(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    evaluation: &Evaluation,
    references: &mut KnownReferences,
    progress: &Progress<'_>,
) -> Result<Option<Converged>, EvaluateError> {
    let Some(queries) = converged_queries(&evaluation.queries, references.converged_samples) else {
        return Ok(None);
    };
    let (snapshot, registry) = renderer.snapshot(scene)?;
    let reference = references.answer(&snapshot, request, queries, progress);
    let reference = as_compared(&registry, reference, &evaluation.measured);
    let mut errors = compared((&snapshot, &registry), &evaluation.measured, &reference)?;
    for error in &mut errors {
        let own = evaluation.errors.iter().find(|own| own.name == error.name);
        if let Some(own) = own.filter(|own| own.same_samples.is_some()) {
            error.by_samples = Some(own.verdict());
            for (channel, own) in error.channels.iter_mut().zip(&own.channels) {
                channel.by_samples = Some(own.verdict());
            }
        }
    }
    Ok(Some(Converged { reference, errors }))
}
