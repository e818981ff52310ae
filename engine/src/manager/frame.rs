//! Planning a frame: prepass, each light's passes, one shading pass; and nothing the scene does not call for.

use thiserror::Error;
use wgpu::TextureFormat;

use super::assembly::{Assembly, Segment};
use super::surfaces::{Surfaces, receiver_bounds};
use crate::plan::{FramePlan, PlanBuilder};
use crate::scene::{Posed, PosedCamera};
use crate::shadow::{Cache, LightPlan, Registry, ShadowError, View};

/// Why a frame could not be planned.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum FrameError {
    #[error("a picture of {width}x{height} was asked for; width and height must be from 1 to {limit}")]
    Size { width: u32, height: u32, limit: u32 },
    #[error(
        "camera '{name}' is not valid: it needs 0 < near < far, and a field of view between 0 and pi or a positive height, all finite"
    )]
    Camera { name: String },
    #[error(transparent)]
    Shadow(#[from] ShadowError),
}

/// What the finished picture is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PictureFormat {
    /// Tone-mapped, 8 bits, sRGB.
    #[default]
    Srgb8,
    /// Linear radiance times exposure in f32, not tone-mapped.
    LinearF32,
}

/// What is wanted of a frame.
#[derive(Clone, Debug)]
pub struct FrameRequest {
    /// From where.
    pub camera: PosedCamera,
    /// Width and height, in pixels.
    pub size_px: [u32; 2],
    /// The picture's format.
    pub picture: PictureFormat,
    /// Whether each shadowed light's factor is kept as an image, with the visible triangle of every pixel.
    pub factors: bool,
}

impl FrameRequest {
    /// An sRGB picture of this size from `camera`.
    pub fn new(camera: PosedCamera, size_px: [u32; 2]) -> Self {
        Self { camera, size_px, picture: PictureFormat::Srgb8, factors: false }
    }
}

/// What the adapter offers a plan: its name, features and largest texture.
#[derive(Clone, Debug)]
pub struct Adapter<'a> {
    /// The adapter's name, for errors.
    pub name: &'a str,
    /// Its features.
    pub features: wgpu::Features,
    /// Its largest texture side, in pixels.
    pub max_size_px: u32,
}

impl Adapter<'static> {
    /// An imagined adapter with every feature a plan may ask for: for planning without a device.
    pub fn imagined() -> Self {
        Self { name: "no adapter", features: wgpu::Features::all(), max_size_px: 16384 }
    }
}

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
    let frustum = request.camera.frustum(request.size_px);
    let view = View {
        camera: request.camera.clone(),
        size_px: request.size_px,
        receiver_bounds: receiver_bounds(posed, &frustum),
        frustum,
    };
    let surfaces = Surfaces::of(posed, &view);
    let mut b = PlanBuilder::new(request.size_px);
    b.notes.clone_from(&registry.notes);
    if surfaces.outside > 0 {
        b.note(format!("{} meshes outside the view are not drawn (their shadows may be)", surfaces.outside));
    }
    let format = match request.picture {
        PictureFormat::Srgb8 => TextureFormat::Rgba8UnormSrgb,
        PictureFormat::LinearF32 => TextureFormat::Rgba32Float,
    };
    let picture = b.texture("picture", format, 1, "what was asked for");
    let depth = b.texture("depth", TextureFormat::Depth32Float, 1, "hidden surfaces");
    // A placeholder that is removed again when no light needs it: techniques must be able to name it.
    let visibility =
        b.texture("visibility", TextureFormat::R16Float, 1, "factors of lights that are not hard");

    // Each light's own passes.
    let mut segments = Vec::new();
    let mut layers = 0;
    for (index, claims) in registry.lights.iter().enumerate() {
        let mut segment = Segment {
            passes: vec![],
            counts: false,
            visibility: None,
            techniques: vec![],
            claimed: !claims.is_empty(),
        };
        let light = &posed.lights[index];
        if claims.is_empty() {
            b.note(format!("light '{}' has no shadow node: no passes", light.name));
        } else if !light.may_reach(&view.receiver_bounds) {
            b.note(format!("light '{}' reaches nothing in view: no passes", light.name));
        } else {
            let mut counts_bound = 0;
            for claim in claims {
                segment.techniques.push(claim.technique.type_name().to_owned());
                if claim.casters.is_empty() {
                    b.note(format!("'{}' has no casters for light '{}': no passes", claim.node, light.name));
                    continue;
                }
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
                };
                light_plan.require(required, "always")?;
                claim.technique.plan(&mut light_plan)?;
            }
            segment.passes = std::mem::take(&mut b.passes);
            layers += u32::from(segment.visibility.is_some());
        }
        segments.push(segment);
    }

    let plan =
        Assembly { posed, view: &view, surfaces, request, b, picture, depth, visibility }.assemble(segments);
    plan.validate().map_err(ShadowError::from)?;
    Ok(plan)
}
