//! Planning a frame: prepass, each light's passes, one shading pass; and nothing the scene does not call for.

use wgpu::TextureFormat;

use super::assembly::Assembly;
use super::layers::Layered;
use super::request::{Adapter, FrameError, FrameRequest, PictureFormat};
use super::segments::{self, Left, Segment, VisibilityLayers};
use super::surface_functions;
use super::surfaces::{Surfaces, receiver_bounds};
use crate::plan::{ALL_TAKEN, Antialias, FramePlan, PlanBuilder, SlotId, SlotKind};
use crate::scene::{Posed, PosedLight};
use crate::shadow::{
    Cache, Channels, Claim, Darkening, Layer, Layers, LightPlan, Registry, ShadowError, View,
};

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
    let camera = request.camera.fitted_to(&posed.world_bounds);
    let frustum = camera.frustum(size_px);
    let view = View { camera, size_px, receiver_bounds: receiver_bounds(posed, &frustum), frustum };
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
    let mut planner = Planner {
        posed,
        view: &view,
        registry,
        adapter,
        cache,
        visibility,
        darkening: None,
        darkens_apart: None,
        visibility_layers: VisibilityLayers::new(visibility),
        darkens: vec![false; registry.lights.len()],
        factors: request.factors,
    };
    let mut seen = Seen::default();
    let opaque = Receivers { depth, layer: None };
    let mut segments = planner.lights(&mut b, opaque, &mut seen)?;
    let mut layers = planner.layers(&mut b, request, &surfaces)?;
    if let Some(layers) = &mut layers {
        planner.join(&mut segments, layers)?;
    }
    let Planner { darkening, darkens_apart, visibility_layers, .. } = planner;

    let once = darkening.as_ref().map(|darkening| (darkening.node.clone(), darkening.technique));
    if let (Some((node, technique)), PictureFormat::LinearF32) = (once.or(darkens_apart), request.picture) {
        let needed = wgpu::Features::FLOAT32_BLENDABLE;
        if !adapter.features.contains(needed) {
            return Err(FrameError::Shadow(ShadowError::MissingFeature {
                node,
                technique,
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
        triangles: seen.triangles,
        normals: seen.normals,
    };
    let weight = darkening.map(|darkening| darkening.weight);
    let plan = assembly.assemble(segments, visibility_layers.count, weight, layers)?;
    plan.validate().map_err(ShadowError::from)?;
    Ok(plan)
}

/// Refuses a light whose shadows darken the picture in two ways: it would be darkened twice. `left` is what its claims
/// have left so far, the last one new.
fn check_one_way(light: &PosedLight, left: &[(&String, Left)]) -> Result<(), ShadowError> {
    let find = |wanted: &dyn Fn(&Left) -> bool| {
        left.iter().find(|(_, left)| wanted(left)).map(|(node, _)| (*node).clone())
    };
    let once = find(&|left| left.once);
    let apart = find(&|left| left.apart);
    let light = light.name.clone();
    if let (Some(once), Some(apart)) = (&once, &apart) {
        let (once, apart) = (once.clone(), apart.clone());
        return Err(ShadowError::DarkeningsDiffer { light, once, apart });
    }
    let shaded = find(&|left| !left.apart && (left.counts || left.visibility));
    match (once.or(apart), shaded) {
        (Some(darkening), Some(other)) => Err(ShadowError::DarkenedTwice { light, darkening, other }),
        _ => Ok(()),
    }
}

/// What techniques asked to know about the surface that each pixel shows.
#[derive(Default)]
pub(super) struct Seen {
    /// Its instance and triangle.
    pub(super) triangles: Option<SlotId>,
    /// Its normal.
    pub(super) normals: Option<SlotId>,
}

/// What the passes of all lights are planned with, for the opaque surfaces and for each layer.
pub(super) struct Planner<'a> {
    pub(super) posed: &'a Posed,
    pub(super) view: &'a View,
    pub(super) registry: &'a Registry,
    pub(super) adapter: &'a Adapter<'a>,
    pub(super) cache: &'a mut Cache,
    pub(super) visibility: SlotId,
    pub(super) darkening: Option<Darkening>,
    /// The first node that darkens the finished picture by itself.
    pub(super) darkens_apart: Option<(String, &'static str)>,
    pub(super) visibility_layers: VisibilityLayers,
    /// The lights whose shadows darken the finished picture, which is that of the opaque surfaces.
    pub(super) darkens: Vec<bool>,
    /// Whether factors are asked for as images.
    pub(super) factors: bool,
}

/// The surfaces that shadows are planned to fall on.
#[derive(Clone, Copy)]
pub(super) struct Receivers {
    pub(super) depth: SlotId,
    /// Which layer of transparent surfaces; `None` for the opaque ones.
    pub(super) layer: Option<Layer>,
}

impl Planner<'_> {
    /// What each light's techniques plan for `receivers`.
    pub(super) fn lights(
        &mut self,
        b: &mut PlanBuilder,
        receivers: Receivers,
        seen: &mut Seen,
    ) -> Result<Vec<Segment>, FrameError> {
        let mut segments = Vec::new();
        for (index, claims) in self.registry.lights.iter().enumerate() {
            let mut segment = Segment { claimed: !claims.is_empty(), ..Segment::default() };
            let light = &self.posed.lights[index];
            let falls = match receivers.layer {
                None => true,
                Some(Layer::FromEye(0)) => self.registry.receiver_layers(index) >= Layers::First,
                Some(_) => self.registry.receiver_layers(index) == Layers::All,
            };
            if claims.is_empty() {
                b.note(format!("light '{}' has no shadow node: no passes", light.name));
            } else if !light.may_reach(&self.view.receiver_bounds) {
                b.note(format!("light '{}' reaches nothing in view: no passes", light.name));
            } else if falls && !self.darkens[index] {
                let left = self.claims(b, (index, claims), receivers, seen, &mut segment)?;
                let passes = std::mem::take(&mut b.passes);
                segment.sort(index, (&passes, &left), &mut self.visibility_layers, self.factors);
                self.darkens[index] = !segment.after.is_empty();
            }
            segments.push(segment);
        }
        Ok(segments)
    }

    /// What the techniques of light number `index` plan, into `b` and `segment`; and what each of them left.
    fn claims(
        &mut self,
        b: &mut PlanBuilder,
        (index, claims): (usize, &[Claim]),
        receivers: Receivers,
        seen: &mut Seen,
        segment: &mut Segment,
    ) -> Result<Vec<Left>, FrameError> {
        let light = &self.posed.lights[index];
        let is_wide = |claim: &Claim| claim.technique.light_size().is_wide(light.position);
        let has_size = claims.iter().any(is_wide);
        let mut counts_bound = 0;
        let mut left: Vec<(&String, Left)> = Vec::new();
        for claim in claims {
            segment.techniques.push(claim.label.clone());
            // Of a light with a size, part may be beyond a receiver's horizon, whether or not anything casts.
            if claim.casters.is_empty() && !is_wide(claim) {
                b.note(format!("'{}' has no casters for light '{}': no passes", claim.node, light.name));
                continue;
            }
            let (mut once, mut apart, mut own_shadow) = (false, false, false);
            let (mut counts, mut taken) = (false, ALL_TAKEN);
            let (passes_before, visibility_before) = (b.passes.len(), segment.visibility);
            let required = claim.technique.requirements().required;
            let mut light_plan = LightPlan {
                posed: self.posed,
                view: self.view,
                features: self.adapter.features,
                adapter: self.adapter.name,
                cache: &mut *self.cache,
                light_index: index,
                claim,
                builder: &mut *b,
                depth: receivers.depth,
                visibility: self.visibility,
                uses_counts: &mut counts,
                uses_visibility: &mut segment.visibility,
                counts_bound: &mut counts_bound,
                visibility_layer: self.visibility_layers.count,
                darkening: &mut self.darkening,
                darkens: &mut once,
                smooth_terminators: &mut segment.smooth_terminators,
                visible_triangles: &mut seen.triangles,
                receiver_planes: &mut seen.normals,
                own_shadow: &mut own_shadow,
                has_size,
                taken: &mut taken,
                darkens_apart: &mut apart,
                layer: receivers.layer,
            };
            light_plan.require(required, "always")?;
            claim.technique.plan(&mut light_plan)?;
            let own = b.passes.get(passes_before..).unwrap_or_default();
            let mut targets = own.iter().flat_map(|pass| &pass.colors);
            let visible = targets.any(|color| color.slot == self.visibility);
            segment.own_shadow |= own_shadow && visible;
            let passes = passes_before..b.passes.len();
            let visibility = visible || segment.visibility != visibility_before;
            // Casters may come to nothing: then nothing of the light is to be taken in any particular way.
            let is_planned = counts || visibility || once;
            let (taken, apart) = if is_planned { (taken, apart) } else { (ALL_TAKEN, false) };
            left.push((&claim.node, Left { passes, counts, visibility, taken, once, apart }));
            check_one_way(light, &left)?;
            if apart {
                self.darkens_apart.get_or_insert_with(|| (claim.node.clone(), claim.technique.type_name()));
            }
            check_per_sample(b, claim, receivers.depth, segment.visibility, [seen.triangles, seen.normals])?;
        }
        // What is darkened once is counted, whoever asks.
        Ok(left.into_iter().map(|(_, left)| Left { counts: left.counts || left.once, ..left }).collect())
    }

    /// Gives factors the same places on all surfaces.
    ///
    /// # Errors
    /// [`ShadowError::LayersDiffer`] for a light that has other parts on some layer.
    fn join(&self, opaque: &mut [Segment], layered: &mut Layered) -> Result<(), ShadowError> {
        for (index, segment) in opaque.iter_mut().enumerate() {
            let on_layers = layered.segments().map(|segments| &mut segments[index]).collect();
            if !segments::join(segment, on_layers, self.visibility) {
                let light = self.posed.lights[index].name.clone();
                return Err(ShadowError::LayersDiffer { light });
            }
        }
        Ok(())
    }
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
