//! Rendering a scene on the GPU and judging every light's factor against the reference.

use std::sync::Arc;

use shadowgraph_engine::gpu::Timing;
use shadowgraph_engine::manager::{Frame, FrameRequest, RenderError, RenderOptions, Renderer};
use shadowgraph_engine::scene::{Posed, Scene};
use shadowgraph_engine::shadow::Registry;
use thiserror::Error;

use super::{CompareError, LightError, LightQuery, Measured, Progress, Reference, ReferenceImage, compare};

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
    pub reference: ReferenceImage,
    /// One entry for each light that a shadow node serves.
    pub errors: Vec<LightError>,
}

/// What the reference is asked about: every light that a shadow node serves, with its casters.
pub fn queries(registry: &Registry) -> Vec<LightQuery> {
    let served = registry.lights.iter().enumerate().filter(|(_, claims)| !claims.is_empty());
    served.map(|(light, _)| LightQuery { light, casters: registry.casters_of(light) }).collect()
}

/// What a frame with factors measured, in the reference's terms: NaN where nothing is hit.
///
/// # Errors
/// When the frame's factors cannot be read as floats.
pub fn measured(frame: &Frame, size_px: [u32; 2]) -> Result<Measured, RenderError> {
    let ids = frame.visible_triangles.clone().unwrap_or_default();
    let mut lights = Vec::new();
    for factor in &frame.factors {
        let floats = factor.pixels.floats()?;
        let channels = floats.len() / ids.len().max(1);
        let values = ids.iter().zip(floats.chunks_exact(channels.max(1)));
        let values = values.map(|(id, texel)| if id[0] == u32::MAX { f32::NAN } else { texel[0] });
        lights.push((factor.light.clone(), values.collect()));
    }
    Ok(Measured { size_px, ids, lights })
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
    let request = FrameRequest { factors: true, ..request.clone() };
    let options = RenderOptions { read_picture: true, timing: Timing::Off, ..RenderOptions::default() };
    let frame = renderer.render(scene, &request, &options)?;
    let (posed, registry): (Arc<Posed>, Arc<Registry>) = renderer.posed(scene)?;
    let queries = queries(&registry);
    if queries.is_empty() {
        return Err(EvaluateError::NothingToCompare);
    }
    let reference = Reference::new(&posed).render(&request.camera, request.size_px, &queries, progress);
    let measured = measured(&frame, request.size_px)?;
    let errors = compare(&measured, &reference)?;
    Ok(Evaluation { frame, measured, reference, errors })
}
