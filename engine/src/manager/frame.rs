//! Planning a frame: prepass, each light's passes, one shading pass; and nothing the scene does not call for.

use wgpu::TextureFormat;

use super::assembly::{Assembly, Segment};
use super::request::{Adapter, FrameError, FrameRequest, PictureFormat};
use super::surface_functions;
use super::surfaces::{Surfaces, receiver_bounds};
use crate::plan::{Antialias, FramePlan, PlanBuilder, SlotId, SlotKind};
use crate::scene::Posed;
use crate::shadow::{Cache, Channels, Claim, LightPlan, Registry, ShadowError, View};

/// Plans one frame of `posed`. Needs no device.
///
/// # Errors
/// [`FrameError::Size`] for sizes the adapter cannot do; whatever the techniques refuse.
pub fn plan_frame(
    posed: &Posed,
    registry: &Registry,
    request: &FrameRequest,
    adapter: &Adapter<'_>,
    cache: &mut Cache,
) -> Result<FramePlan, FrameError> {
    let [width, height] = request.size_px;
    let limit = adapter.max_size_px;
    if width == 0 || height == 0 || width > limit || height > limit {
        return Err(FrameError::Size { width, height, limit });
    }
    if !request.camera.projection.is_valid() || !request.camera.world_from_view.is_finite() {
        return Err(FrameError::Camera { name: request.camera.name.clone() });
    }
    surface_functions::check(posed)?;
    let size_px = drawn_size_px(request, adapter)?;
    let frustum = request.camera.frustum(size_px);
    let view = View {
        camera: request.camera.clone(),
        size_px,
        receiver_bounds: receiver_bounds(posed, &frustum),
        frustum,
    };
    let surfaces = Surfaces::of(posed, &view);
    let mut b = PlanBuilder::new(size_px);
    b.notes.clone_from(&registry.notes);
    if surfaces.outside > 0 {
        b.note(format!("{} meshes outside the view are not drawn (their shadows may be)", surfaces.outside));
    }
    let format = match request.picture {
        PictureFormat::Srgb8 => TextureFormat::Rgba8UnormSrgb,
        PictureFormat::LinearF32 => TextureFormat::Rgba32Float,
    };
    let samples = request.antialias.samples();
    let picture = b.texture_sized("picture", format, request.size_px, 1, "what was asked for");
    let drawn = match request.antialias {
        Antialias::None => picture,
        Antialias::Multisample4 => {
            adapter.check_multisampled("the picture", format)?;
            b.samples("picture in samples", format, samples, "msaa4: edges of surfaces")
        }
        Antialias::Supersample4 => {
            b.texture("picture at twice the size", format, 1, "ssaa4: every sample is drawn in full")
        }
    };
    let depth = b.samples("depth", TextureFormat::Depth32Float, samples, "hidden surfaces");
    // A placeholder that is removed again when no light needs it: techniques must be able to name it.
    let visibility =
        b.texture("visibility", TextureFormat::R16Float, 1, "factors of lights that are not hard");

    // Each light's own passes.
    let mut segments = Vec::new();
    let mut layers = 0;
    let mut darkening = None;
    let (mut triangles, mut normals) = (None, None);
    for (index, claims) in registry.lights.iter().enumerate() {
        let mut segment = Segment {
            passes: vec![],
            counts: false,
            visibility: None,
            techniques: vec![],
            claimed: !claims.is_empty(),
            darkens: false,
            smooth_terminators: vec![],
            own_shadow: false,
        };
        let light = &posed.lights[index];
        if claims.is_empty() {
            b.note(format!("light '{}' has no shadow node: no passes", light.name));
        } else if !light.may_reach(&view.receiver_bounds) {
            b.note(format!("light '{}' reaches nothing in view: no passes", light.name));
        } else {
            let mut counts_bound = 0;
            let mut last: Option<&String> = None;
            for claim in claims {
                segment.techniques.push(claim.label.clone());
                if claim.casters.is_empty() {
                    b.note(format!("'{}' has no casters for light '{}': no passes", claim.node, light.name));
                    continue;
                }
                let darkened_before = segment.darkens;
                let (mut darkens, mut own_shadow) = (false, false);
                let passes_before = b.passes.len();
                let required = claim.technique.requirements().required;
                let mut light_plan = LightPlan {
                    posed,
                    view: &view,
                    features: adapter.features,
                    adapter: adapter.name,
                    cache: &mut *cache,
                    light_index: index,
                    claim,
                    builder: &mut b,
                    depth,
                    visibility,
                    uses_counts: &mut segment.counts,
                    uses_visibility: &mut segment.visibility,
                    counts_bound: &mut counts_bound,
                    visibility_layer: layers,
                    darkening: &mut darkening,
                    darkens: &mut darkens,
                    smooth_terminators: &mut segment.smooth_terminators,
                    visible_triangles: &mut triangles,
                    receiver_normals: &mut normals,
                    own_shadow: &mut own_shadow,
                };
                light_plan.require(required, "always")?;
                claim.technique.plan(&mut light_plan)?;
                segment.darkens |= darkens;
                let own = b.passes.get(passes_before..).unwrap_or_default();
                let mut targets = own.iter().flat_map(|pass| &pass.colors);
                segment.own_shadow |= own_shadow && targets.any(|color| color.slot == visibility);
                if segment.darkens && (segment.counts || segment.visibility.is_some()) {
                    let (own, other) = (claim.node.clone(), last.unwrap_or(&claim.node).clone());
                    let (darkening, other) = if darkened_before { (other, own) } else { (own, other) };
                    let light = light.name.clone();
                    return Err(ShadowError::DarkenedTwice { light, darkening, other }.into());
                }
                last = Some(&claim.node);
                check_per_sample(&b, claim, depth, segment.visibility, [triangles, normals])?;
            }
            segment.passes = std::mem::take(&mut b.passes);
            layers += u32::from(segment.visibility.is_some());
        }
        segments.push(segment);
    }

    if let (Some(darkening), PictureFormat::LinearF32) = (&darkening, request.picture) {
        let needed = wgpu::Features::FLOAT32_BLENDABLE;
        if !adapter.features.contains(needed) {
            return Err(FrameError::Shadow(ShadowError::MissingFeature {
                node: darkening.node.clone(),
                technique: darkening.technique,
                needed: format!("{needed:?} (darkening a picture of 32-bit floats)"),
                adapter: adapter.name.into(),
            }));
        }
    }
    let assembly = Assembly {
        posed,
        view: &view,
        surfaces,
        request,
        adapter,
        b,
        picture,
        drawn,
        depth,
        visibility,
        triangles,
        normals,
    };
    let plan = assembly.assemble(segments, darkening.map(|darkening| darkening.weight))?;
    plan.validate().map_err(ShadowError::from)?;
    Ok(plan)
}

/// The size of what is drawn, when the adapter has targets that large, factor images among them.
fn drawn_size_px(request: &FrameRequest, adapter: &Adapter<'_>) -> Result<[u32; 2], FrameError> {
    let (size_px, limit) = (request.size_px, adapter.max_size_px);
    let drawn = request.antialias.drawn_size_px(size_px);
    let needed = if request.factors { request.antialias.factor_size_px(size_px) } else { drawn };
    if needed.iter().any(|n| *n > limit) {
        return Err(FrameError::AntialiasedSize {
            antialias: request.antialias,
            width: size_px[0],
            height: size_px[1],
            needed_width: needed[0],
            needed_height: needed[1],
            limit,
        });
    }
    Ok(drawn)
}

/// Counts are kept for every sample by the stencil itself. A visibility target is written once for each fragment: its
/// samples would all hold the factor of one point, and edges would be as wrong as without antialiasing. So would the
/// `images` of what each pixel shows.
fn check_per_sample(
    b: &PlanBuilder,
    claim: &Claim,
    depth: SlotId,
    visibility: Option<Channels>,
    images: [Option<SlotId>; 2],
) -> Result<(), FrameError> {
    if b.slots[depth.0].samples() == 1 {
        return Ok(());
    }
    // A counter of its own beside the receivers' depth, or the visibility target.
    let beside_depth = b.passes.iter().filter(|pass| pass.depth.as_ref().is_some_and(|d| d.slot == depth));
    let counter =
        beside_depth.flat_map(|pass| &pass.colors).find_map(|color| match b.slots.get(color.slot.0)?.kind {
            SlotKind::Texture { format, samples: 1, .. } => Some(format),
            _ => None,
        });
    let image = images.into_iter().flatten().find_map(|slot| match b.slots[slot.0].kind {
        SlotKind::Texture { format, .. } => Some(format),
        _ => None,
    });
    let Some(format) = counter.or(visibility.map(Channels::format)).or(image) else { return Ok(()) };
    Err(FrameError::Shadow(ShadowError::NotPerSample {
        node: claim.node.clone(),
        technique: claim.technique.type_name(),
        format,
    }))
}
