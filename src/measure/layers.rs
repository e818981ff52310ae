//! References on transparent surfaces: the factor on the n-th of them along each pixel's ray.
//!
//! A layer is judged as the opaque surface is, but for one thing: no side of it is dark by itself, since light passes it.
//! Its own plane, and what lies in it, stands between nothing.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use shadowgraph_engine::gpu::Timing;
use shadowgraph_engine::manager::{FrameRequest, RenderOptions, Renderer};
use shadowgraph_engine::plan::Antialias;
use shadowgraph_engine::scene::{PosedCamera, Scene};
use shadowgraph_engine::shadow::{Layer, Layers, Registry};

use super::evaluate::{layer_measured, queries};
use super::glass::SAME_FACTOR;
use super::moved::{MOVES, Moved};
use super::reference::{Hit, Probe, Reference, Tracer};
use super::render::{LightReference, Query, View, for_rows};
use super::{EvaluateError, LightError, LightQuery, Measured, Progress, ReferenceImage, compare};

/// One layer of transparent surfaces with its factors, the reference's, and how they differ.
#[derive(Clone, Debug)]
pub struct LayerEvaluation {
    /// Which layer; 0 is the nearest.
    pub layer: u32,
    /// What was measured.
    pub measured: Measured,
    /// What is right.
    pub reference: Arc<ReferenceImage>,
    /// One entry for each light whose shadows fall on this layer.
    pub errors: Vec<LightError>,
}

/// Renders `scene` with its own shadow nodes and compares the factors of those of the `layers` that there are, for the
/// lights whose techniques ask for them. Empty where there is none.
///
/// # Errors
/// [`EvaluateError`]; among them [`EvaluateError::SizedLightOnLayers`] for a light that some technique takes to have a
/// size: what a layer shows of a disc that its own plane cuts is not defined here.
pub fn evaluate_layers(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
    layers: Range<u32>,
    progress: &Progress<'_>,
) -> Result<Vec<LayerEvaluation>, EvaluateError> {
    let request = FrameRequest { factors: true, layer_factors: layers.clone(), ..request.clone() };
    let options = RenderOptions { timing: Timing::Off, ..RenderOptions::default() };
    let frame = renderer.render(scene, &request, &options)?;
    let (posed, registry) = renderer.posed(scene)?;
    let size_px = request.antialias.factor_size_px(request.size_px);
    let reference = Reference::new(&posed);
    let FrameRequest { camera, size_px: picture_px, antialias, .. } = &request;
    let mut evaluations = Vec::new();
    // The first layer may be that of more lights than the rest.
    let first = layers.start..layers.end.min(layers.start + 1);
    for layers in [first.clone(), first.end..layers.start + frame.layers.len() as u32] {
        if layers.is_empty() {
            continue;
        }
        let queries = queries_on_layer(&reference, &registry, layers.start)?;
        if queries.is_empty() {
            continue;
        }
        let images =
            reference.render_layers(camera, *picture_px, *antialias, &queries, layers.clone(), progress);
        for (layer, image) in layers.zip(images) {
            let Some(drawn) = frame.layers.get((layer - request.layer_factors.start) as usize) else { break };
            let mut measured = layer_measured(drawn, size_px)?;
            measured.lights.retain(|(name, _)| image.lights.iter().any(|light| light.name == *name));
            let errors = compare(&measured, &image)?;
            evaluations.push(LayerEvaluation { layer, measured, reference: Arc::new(image), errors });
        }
    }
    Ok(evaluations)
}

/// What the reference is asked about on a layer: the lights whose shadows fall on it.
fn queries_on_layer(
    reference: &Reference,
    registry: &Registry,
    layer: u32,
) -> Result<Vec<LightQuery>, EvaluateError> {
    let falls = |light: usize| match registry.receiver_layers(light) {
        Layers::OpaqueOnly => false,
        Layers::First => layer == 0,
        Layers::All => true,
    };
    let on_layer = queries(registry).into_iter().filter(|query| falls(query.light));
    let judged = |query: LightQuery| {
        let Some(light) = reference.lights.get(query.light) else { return Ok(query) };
        if query.sized.iter().any(|part| part.size.is_wide(light.position)) {
            return Err(EvaluateError::SizedLightOnLayers { light: light.name.clone() });
        }
        Ok(query)
    };
    on_layer.map(judged).collect()
}

impl Reference {
    /// What is seen, and every light's factor, on each of the `layers` of transparent surfaces before the opaque one, 0
    /// the nearest; through every sample as [`Reference::render_samples`]. A query for a light that the scene does not
    /// have is skipped.
    pub fn render_layers(
        &self,
        camera: &PosedCamera,
        size_px: [u32; 2],
        antialias: Antialias,
        lights: &[LightQuery],
        layers: Range<u32>,
        progress: &Progress<'_>,
    ) -> Vec<ReferenceImage> {
        let chosen = Chosen { from_behind: false, skipped: layers.start as usize, count: layers.len() };
        self.render_chosen((camera, size_px, antialias), lights, &chosen, progress)
    }

    /// What is seen, and every light's factor, on one of the transparent surfaces before the opaque one.
    pub fn render_layer(
        &self,
        camera: &PosedCamera,
        size_px: [u32; 2],
        lights: &[LightQuery],
        layer: Layer,
    ) -> ReferenceImage {
        let (from_behind, number) = match layer {
            Layer::FromEye(number) => (false, number),
            Layer::FromBehind(number) => (true, number),
        };
        let chosen = Chosen { from_behind, skipped: number as usize, count: 1 };
        let view = (camera, size_px, Antialias::None);
        self.render_chosen(view, lights, &chosen, &|_, _| {}).pop().unwrap_or_default()
    }

    /// Judges those surfaces of each pixel that are `chosen`.
    fn render_chosen(
        &self,
        (camera, size_px, antialias): (&PosedCamera, [u32; 2], Antialias),
        lights: &[LightQuery],
        chosen: &Chosen,
        progress: &Progress<'_>,
    ) -> Vec<ReferenceImage> {
        let view = View::new(camera, antialias.drawn_size_px(size_px));
        let size_px = antialias.factor_size_px(size_px);
        let queries = self.resolve(lights);
        let rows = for_rows(size_px, progress, |y| {
            let mut tracer = self.tracer();
            let pixel = |x: u32| {
                let place = antialias.sample_place_px([x, y]);
                let (from, direction) = view.ray(place);
                let projection = &camera.projection;
                let t_end = view.first_hit(&mut tracer, place).map_or(projection.far_m(), |(_, t)| t);
                let seen = chosen.of(tracer.layers(from, direction, projection.near_m(), t_end));
                let judged = seen.map(|(surface, t)| {
                    let moved = Moved::on(surface, &view, place, t);
                    let judged = |query: &Query| {
                        let light = self.lights[query.light].position;
                        query.judge_layer(&mut tracer, &moved, surface.facing(light) != 0)
                    };
                    (moved.hit, queries.iter().map(judged).collect())
                });
                judged.collect()
            };
            (0..size_px[0]).map(pixel).collect::<Vec<Vec<LayerPixel>>>()
        })
        .concat();
        (0..chosen.count).map(|layer| self.layer_image(size_px, &queries, &rows, layer)).collect()
    }

    /// One layer of what was judged.
    fn layer_image(
        &self,
        size_px: [u32; 2],
        queries: &[Query],
        pixels: &[Vec<LayerPixel>],
        layer: usize,
    ) -> ReferenceImage {
        let lights = queries.iter().enumerate().map(|(index, query)| {
            let judged = || pixels.iter().map(|pixel| pixel.get(layer).map(|(_, judged)| &judged[index]));
            let channels = if query.transparent.is_some() { 3 } else { 1 };
            let factor = |judged: Option<&OnLayer>| judged.map_or([f32::NAN; 3], |judged| judged.factor);
            LightReference {
                name: self.lights[query.light].name.clone(),
                factor: judged().flat_map(|judged| factor(judged).into_iter().take(channels)).collect(),
                compared: judged().map(|judged| judged.is_some_and(|judged| judged.compared)).collect(),
                ambiguous: judged().map(|judged| judged.is_some_and(|judged| judged.ambiguous)).collect(),
                soft: None,
            }
        });
        let hits = pixels.iter().map(|pixel| pixel.get(layer).map(|(hit, _)| *hit)).collect();
        ReferenceImage { size_px, hits, lights: lights.collect() }
    }
}

/// Which of the surfaces at a pixel.
struct Chosen {
    /// Whether they are counted from behind, and the nearest is left out.
    from_behind: bool,
    skipped: usize,
    count: usize,
}

impl Chosen {
    /// Those of `seen`, which has the nearest first.
    fn of<T>(&self, mut seen: Vec<T>) -> impl Iterator<Item = T> + use<T> {
        if self.from_behind {
            seen.reverse();
            seen.pop();
        }
        seen.into_iter().skip(self.skipped).take(self.count)
    }
}

/// A surface, and what each query says about it.
type LayerPixel = (Hit, Vec<OnLayer>);

/// What a query says about a point on a layer.
#[derive(Clone, Copy)]
struct OnLayer {
    /// Red, green and blue.
    factor: [f32; 3],
    compared: bool,
    ambiguous: bool,
}

impl Query {
    /// The factor of a point on a layer, which may face the light or lie in its direction (`faces` false).
    fn judge_layer(&self, tracer: &mut Tracer<'_>, moved: &Moved, faces: bool) -> OnLayer {
        let light = &tracer.reference.lights[self.light];
        let reached: Vec<usize> = (0..MOVES).filter(|i| light.reaches(moved.points[*i])).collect();
        let compared = reached.contains(&0) && faces;
        if !moved.receives || !reached.contains(&0) {
            return OnLayer { factor: [1.0; 3], compared, ambiguous: false };
        }
        let probe = Probe {
            points: &moved.points,
            off_plane_from: 5,
            receiver: Some(moved.hit),
            light: light.position,
            casters: &self.casters,
        };
        let dark = tracer.blocked(&probe);
        let mut factors = [DVec3::ONE; MOVES];
        if let Some(casters) = &self.transparent {
            factors = tracer.tints(&probe, casters);
        }
        for (index, factor) in factors.iter_mut().enumerate() {
            *factor *= f64::from(1 - (dark >> index & 1));
        }
        let changes = |i: &usize| (factors[*i] - factors[0]).abs().max_element() > SAME_FACTOR;
        let ambiguous = moved.lost || reached.iter().any(changes);
        OnLayer { factor: factors[0].as_vec3().to_array(), compared, ambiguous }
    }
}
