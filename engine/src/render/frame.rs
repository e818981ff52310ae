//! Planning a frame: [`plan_frame`] names its stages in order. Nothing is in the plan that the scene does not call for.

use wgpu::Features;

use super::factors::Factors;
use super::layered::Layered;
use super::picture::Picture;
use super::request::{Adapter, FrameError, FrameRequest, PictureFormat, check_size};
use super::schedule::{Inputs, Needs, Schedule, Scope};
use super::shading::Before;
use super::surfaces::{Surfaces, receiver_bounds};
use super::{
    darkening, layer_images, layers, light_passes, lights, lower, prepass, seen, shading, surface_functions,
};
use crate::plan::FramePlan;
use crate::scene::SceneSnapshot;
use crate::shadow::{Apply, Cache, Registry, ShadowError, View};

/// Plans one frame of `snapshot`. Needs no device.
///
/// # Errors
/// [`FrameError::Size`] for sizes the adapter cannot do; whatever the techniques refuse.
pub fn plan_frame(
    snapshot: &SceneSnapshot,
    registry: &Registry,
    request: &FrameRequest,
    adapter: &Adapter<'_>,
    cache: &Cache,
) -> Result<FramePlan, FrameError> {
    surface_functions::check(snapshot)?;
    let view = view(snapshot, request, adapter)?;
    let surfaces = &Surfaces::of(snapshot, &view);
    let inputs = &Inputs { snapshot, registry, request, adapter, cache, view: &view, surfaces };
    let mut needs = first_needs(inputs);
    let picture = Picture::new(inputs, &mut needs)?;

    // What the nodes of every light plan for the opaque surfaces, and for each layer of transparent ones.
    let depth = needs.depth("depth", request.antialias.samples(), "hidden surfaces");
    let opaque = lights::plan(inputs, &mut needs, (depth, None), &|_| false)?;
    let layers = layers::plan(inputs, &mut needs, &opaque)?;
    check_darkening(inputs, &opaque)?;

    // Where all these factors are going to be.
    let factors = Factors::place(inputs, &mut needs, &opaque, layers.as_ref())?;
    let layer_count = layers.as_ref().map_or(0, Layered::count);
    let picture = picture.of_layers(inputs, &mut needs, layer_count);

    // The passes: what is seen, each light's factors, all lights at once, transparent layers, the finished picture.
    let (needs_mut, passes) = (&mut needs, &mut Schedule::default());
    let prepass = prepass::add(inputs, passes, factors.are_left_by_passes(&opaque));
    let seen = seen::add(inputs, needs_mut, passes, &opaque)?;
    let scope = &Scope { seen, each_sample: inputs.is_multisampled(), ..Scope::default() };
    let mut lights = light_passes::add(inputs, needs_mut, passes, scope, &factors, &opaque)?;
    let before = Before { prepass, layered: layers.is_some() };
    shading::add(inputs, needs_mut, passes, (picture.drawn, before), &factors, &lights)?;
    darkening::add(inputs, needs_mut, passes, (picture.drawn, scope), &factors, &opaque)?;
    if let Some(layered) = &layers {
        layers::draw(inputs, needs_mut, passes, (layered, picture.drawn), (&factors, &lights))?;
        layer_images::draw(inputs, needs_mut, passes, layered, (&factors, &mut lights))?;
    }
    picture.finish(inputs, passes)?;

    // Symbols become textures, as all passes together need them.
    let kept = || layers.iter().flat_map(|layers| &layers.looked_at).filter(|layer| layer.kept);
    let lowered = lower::lower(inputs, needs, passes, &factors, picture)?;
    let plan = FramePlan {
        size_px: view.size_px,
        antialias: request.antialias,
        slots: lowered.slots,
        passes: lowered.passes,
        lights,
        picture: picture.finished,
        visibility: lowered.visibility,
        light_mask: factors.mask,
        visible_triangles: seen.triangles.filter(|_| request.factors),
        layers: layer_count,
        layer_triangles: kept().map(|layer| layer.triangles).collect(),
        shadowed_px: lowered.shadowed_px,
        notes: lowered.notes,
    };
    plan.validate().map_err(ShadowError::from)?;
    Ok(plan)
}

/// The view that is asked for, when it can be drawn: sizes the adapter has targets for, factor images among them.
fn view(snapshot: &SceneSnapshot, request: &FrameRequest, adapter: &Adapter<'_>) -> Result<View, FrameError> {
    let ([width, height], limit) = (request.size_px, adapter.max_size_px);
    if width == 0 || height == 0 || width > limit || height > limit {
        return Err(FrameError::Size { width, height, limit });
    }
    if !request.camera.projection.is_valid() || !request.camera.world_from_view.is_finite() {
        return Err(FrameError::Camera { name: request.camera.name.clone() });
    }
    let size_px = request.antialias.drawn_size_px(request.size_px);
    let needed = if request.factors { request.antialias.factor_size_px(request.size_px) } else { size_px };
    check_size(request, adapter, needed)?;
    let camera = request.camera.fitted_to(&snapshot.world_bounds);
    let frustum = camera.frustum(size_px);
    let receiver_bounds = receiver_bounds(snapshot, &frustum);
    let samples = request.antialias.samples();
    Ok(View { camera, size_px, samples, receiver_bounds, frustum })
}

/// What is said before anything is planned.
fn first_needs(inputs: &Inputs<'_>) -> Needs {
    let mut needs = Needs { notes: inputs.registry.notes.clone(), ..Needs::default() };
    if inputs.surfaces.outside > 0 {
        let outside = inputs.surfaces.outside;
        needs.note(format!("{outside} meshes outside the view are not drawn (their shadows may be)"));
    }
    needs
}

/// Refuses to darken a finished picture that the adapter cannot blend into.
fn check_darkening(inputs: &Inputs<'_>, opaque: &lights::ReceiverPasses) -> Result<(), ShadowError> {
    let needed = Features::FLOAT32_BLENDABLE;
    if inputs.request.picture != PictureFormat::LinearF32 || inputs.adapter.features.contains(needed) {
        return Ok(());
    }
    let darkens = |apply: Apply| !matches!(apply, Apply::Light { .. });
    for (claims, nodes) in inputs.registry.lights.iter().zip(&opaque.lights) {
        let mut nodes = claims.iter().zip(nodes);
        let found = nodes.find(|(_, n)| n.contribution.is_some() && darkens(n.contribution.apply));
        if let Some((claim, _)) = found {
            return Err(ShadowError::MissingFeature {
                node: claim.node.clone(),
                technique: claim.type_name,
                needed: format!("{needed:?} (darkening a picture of 32-bit floats)"),
                adapter: inputs.adapter.name.into(),
            });
        }
    }
    Ok(())
}
