//! References on transparent surfaces: the factor on the n-th of them along each pixel's ray.
//!
//! A layer is judged as the opaque surface is ([`crate::reference`]), but for one thing: no side of it is dark by itself,
//! since light passes it. Its own plane, and what lies in it, stands between nothing; of a light with a size that is said
//! of each sample.
//!
//! What lies in the plane of the opaque surface is not before it. By rounding it may be seen before it all the same, and is
//! then compared as what it is ([`ReferenceImage::ties`]).

use std::ops::Range;
use std::sync::Arc;

use shadowgraph_engine::gpu::Timing;
use shadowgraph_engine::plan::Antialias;
use shadowgraph_engine::render::{FrameRequest, RenderOptions, Renderer};
use shadowgraph_engine::scene::{CameraSnapshot, Scene};
use shadowgraph_engine::shadow::{Layer, Layers, Registry};

use super::evaluate::{compared, layer_measured, queries};
use crate::reference::answers::Pixels;
use crate::reference::moved::Moved;
use crate::reference::query::Asker;
use crate::reference::render::for_rows;
use crate::reference::surface::Triangle;
use crate::reference::tracer::{Reference, Tracer};
use crate::reference::view::View;
use crate::{EvaluateError, LightError, LightQuery, Measured, Progress, ReferenceImage};

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
/// [`EvaluateError`].
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
    let (snapshot, registry) = renderer.snapshot(scene)?;
    let size_px = request.antialias.factor_size_px(request.size_px);
    let reference = Reference::new(&snapshot);
    let FrameRequest { camera, size_px: picture_px, antialias, .. } = &request;
    let mut evaluations = Vec::new();
    // The first layer may be that of more lights than the rest.
    let first = layers.start..layers.end.min(layers.start + 1);
    for layers in [first.clone(), first.end..layers.start + frame.layers.len() as u32] {
        if layers.is_empty() {
            continue;
        }
        let queries = queries_on_layer(&registry, layers.start);
        if queries.is_empty() {
            continue;
        }
        let images =
            reference.render_layers(camera, *picture_px, *antialias, &queries, layers.clone(), progress);
        for (layer, image) in layers.zip(images) {
            let Some(drawn) = frame.layers.get((layer - request.layer_factors.start) as usize) else { break };
            let mut measured = layer_measured(drawn, size_px)?;
            measured.lights.retain(|(name, _)| image.lights.iter().any(|light| light.name == *name));
            let image = image.as_seen(&measured.ids).into_owned();
            let errors = compared((&snapshot, &registry), &measured, &image)?;
            evaluations.push(LayerEvaluation { layer, measured, reference: Arc::new(image), errors });
        }
    }
    Ok(evaluations)
}

/// What the reference is asked about on a layer: the lights whose shadows fall on it.
fn queries_on_layer(registry: &Registry, layer: u32) -> Vec<LightQuery> {
    let falls = |light: usize| match registry.receiver_layers(light) {
        Layers::OpaqueOnly => false,
        Layers::First => layer == 0,
        Layers::All => true,
    };
    queries(registry).into_iter().filter(|query| falls(query.light)).collect()
}

impl Reference {
    /// What is seen, and every light's factor, on each of the `layers` of transparent surfaces before the opaque one, 0
    /// the nearest; through every sample as [`Reference::render_samples`]. A query for a light that the scene does not
    /// have is skipped.
    pub fn render_layers(
        &self,
        camera: &CameraSnapshot,
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
        camera: &CameraSnapshot,
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
        (camera, size_px, antialias): (&CameraSnapshot, [u32; 2], Antialias),
        lights: &[LightQuery],
        chosen: &Chosen,
        progress: &Progress<'_>,
    ) -> Vec<ReferenceImage> {
        let camera = camera.fitted_to(&self.world_bounds);
        let view = View::new(&camera, antialias.drawn_size_px(size_px));
        let size_px = antialias.factor_size_px(size_px);
        let queries = self.resolve(lights);
        let rows = for_rows(size_px, progress, |y| {
            let mut askers: Vec<Asker<'_>> = queries.iter().map(|query| query.asker(self)).collect();
            let mut tracer = self.tracer();
            let mut layers: Vec<Pixels> = (0..chosen.count).map(|_| Pixels::new(self, &queries)).collect();
            for x in 0..size_px[0] {
                let place = antialias.sample_place_px([x, y]);
                self.push_pixel((&view, place), &mut tracer, chosen, &mut layers, &mut askers);
            }
            layers
        });
        let mut pictures: Vec<Vec<Pixels>> = (0..chosen.count).map(|_| Vec::new()).collect();
        for row in rows {
            pictures.iter_mut().zip(row).for_each(|(rows, row)| rows.push(row));
        }
        let picture = |rows| Pixels::new(self, &queries).picture(rows, &queries, size_px);
        pictures.into_iter().map(picture).collect()
    }

    /// Adds what is seen at a place of the target to each of the `layers`.
    fn push_pixel<'a>(
        &'a self,
        (view, place): (&View<'_>, [f64; 2]),
        tracer: &mut Tracer<'a>,
        chosen: &Chosen,
        layers: &mut [Pixels],
        askers: &mut [Asker<'_>],
    ) {
        let Seen { layers: seen, in_opaque_plane } = self.seen(view, place, tracer);
        let before = seen.len();
        let seen: Vec<_> = chosen.of(seen).collect();
        for (number, pixels) in layers.iter_mut().enumerate() {
            let Some((surface, t)) = seen.get(number) else {
                pixels.push(None, askers);
                // What is not before the opaque surface may only be seen behind all that is.
                let extra = (chosen.skipped + number).checked_sub(before);
                if extra.is_some_and(|extra| extra < in_opaque_plane.len()) && !chosen.from_behind {
                    for (other, t) in &in_opaque_plane {
                        let other = Moved::on(other, view, place, *t);
                        let in_plane = tracer.in_plane_of(&other, view, place);
                        pixels.push_tie(self, None, &other.among(&in_plane), askers);
                    }
                }
                continue;
            };
            let moved = Moved::on(surface, view, place, *t);
            let in_plane = tracer.in_plane_of(&moved, view, place);
            let moved = moved.among(&in_plane);
            pixels.push(Some(&moved), askers);
            for other in &in_plane.showing {
                let other = Moved::on(other, view, place, *t).among(&in_plane);
                pixels.push_tie(self, Some(&moved), &other, askers);
            }
        }
    }

    /// All transparent surfaces at a place of the target, the nearest first.
    fn seen<'a>(&'a self, view: &View<'_>, place: [f64; 2], tracer: &mut Tracer<'a>) -> Seen<'a> {
        let (from, direction) = view.ray(place);
        let [near_m, far_m] = view.range_m();
        let opaque = view.first_hit(tracer, place);
        let t_end = opaque.map_or(far_m, |(_, t)| t);
        let opaque = opaque.and_then(|(hit, _)| self.surface(hit));
        // Beyond what rounding makes of a plane's distance nothing can lie in it.
        let doubt = t_end * 1e-6;
        let all =
            tracer.layers(from, direction, near_m, if opaque.is_some() { t_end + doubt } else { t_end });
        let is_in_plane = |(surface, t): &(&Triangle, f64)| {
            (*t - t_end).abs() <= doubt
                && opaque.is_some_and(|opaque| surface.shares_plane(opaque, self.coordinate_m))
        };
        let (in_opaque_plane, mut layers): (Vec<_>, Vec<_>) = all.into_iter().partition(is_in_plane);
        layers.retain(|(_, t)| *t < t_end);
        Seen { layers, in_opaque_plane }
    }
}

/// The transparent surfaces at a pixel, each with its distance.
struct Seen<'a> {
    layers: Vec<(&'a Triangle, f64)>,
    /// Those in the plane of the opaque surface.
    in_opaque_plane: Vec<(&'a Triangle, f64)>,
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
