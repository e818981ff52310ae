//! What each pixel shows, for techniques that ask and for measures: the visible triangle and its normal; of every
//! sample, where edges are smoothed by several samples a pixel.

use super::lights::ReceiverPasses;
use super::request::FrameError;
use super::samples;
use super::schedule::{Inputs, Needs, RECEIVER_PLANES, Schedule, Scope, Seen};
use crate::plan::{
    Access, BlendState, CompareFunction, DrawState, Load, PulledStyle, Shader, ShaderError, Symbol,
    TextureDesc, TextureFormat,
};
use crate::shadow::{ColorTarget, DepthTarget, Draw, Pass};

pub(super) const PLANES_REASON: &str = "a technique asks in which plane each pixel's surface lies";

/// Where nothing is seen.
pub(super) const NO_PLANE: Load = Load::Clear([0.0; 4]);

impl Seen {
    /// Textures for what the passes of these receivers ask to know.
    pub(super) fn asked_by<'a>(
        inputs: &Inputs<'_>,
        needs: &mut Needs,
        passes: impl Iterator<Item = &'a ReceiverPasses> + Clone,
    ) -> Self {
        let asks = |symbol| passes.clone().any(|passes| passes.ask(symbol));
        let (triangles, planes) = (asks(Symbol::VisibleTriangles), asks(Symbol::ReceiverPlanes));
        let mut texture = |wanted: bool, name: &str, format, reason: &str| {
            wanted.then(|| needs.texture(name, format, inputs.view.size_px, reason))
        };
        let reason = "a technique asks which triangle each pixel shows";
        let triangles = texture(triangles, "visible triangles", TextureFormat::Rg32Uint, reason);
        let planes = texture(planes, "receiver planes", RECEIVER_PLANES, PLANES_REASON);
        Self { triangles, planes, depth: None }
    }
}

/// How what pixels show is drawn by surface_measure.
struct Shown {
    name: &'static str,
    fragment: &'static str,
    flags: &'static [&'static str],
}

impl Shown {
    /// For those of the two images that there are; `None` where there is neither.
    fn of(seen: Seen) -> Option<Self> {
        let (name, fragment, flags): (_, _, &[&str]) = match (seen.triangles, seen.planes) {
            (None, None) => return None,
            (Some(_), None) => ("visible triangles", "visible_triangle", &[]),
            (None, Some(_)) => ("receiver planes", "receiver_plane", &["PLANES"]),
            (Some(_), Some(_)) => {
                ("visible triangles and receiver planes", "triangle_and_plane", &["PLANES"])
            }
        };
        Some(Self { name, fragment, flags })
    }
}

/// Draws what each pixel of the opaque surfaces shows, as far as techniques ask or factors are measured, with a depth test
/// of its own so that of two coincident surfaces the first drawn wins, as in the prepass.
///
/// # Errors
/// What the adapter cannot do with four samples a pixel.
pub(super) fn add(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'_>,
    opaque: &ReceiverPasses,
) -> Result<Seen, FrameError> {
    if inputs.is_multisampled() {
        return samples::add(inputs, needs, schedule, opaque);
    }
    let mut seen = Seen::asked_by(inputs, needs, [opaque].into_iter());
    if inputs.request.factors && seen.triangles.is_none() {
        let reason = "measuring compares where reference and GPU see the same triangle";
        let (format, size_px) = (TextureFormat::Rg32Uint, inputs.view.size_px);
        seen.triangles = Some(needs.texture("visible triangles", format, size_px, reason));
    }
    let triangles = seen.triangles.map(|slot| ColorTarget::new(slot, no_triangle()));
    let planes = seen.planes.map(|slot| ColorTarget::new(slot, NO_PLANE));
    let Some(Shown { name, fragment, flags }) = Shown::of(seen) else { return Ok(seen) };
    let reason = match seen.triangles {
        Some(_) => triangles_reason(inputs),
        None => PLANES_REASON,
    };
    let colors = triangles.into_iter().chain(planes).collect();
    let pass = seen_pass(inputs, needs, (name, reason), (fragment, flags), (colors, 1))?;
    schedule.push(&Scope::default(), pass);
    Ok(seen)
}

pub(super) fn triangles_reason(inputs: &Inputs<'_>) -> &'static str {
    if inputs.request.factors {
        "measuring compares where reference and GPU see the same triangle"
    } else {
        "a technique asks which triangle each pixel shows"
    }
}

/// What stands where no surface is.
pub(super) fn no_triangle() -> Load {
    let nothing = f64::from(u32::MAX);
    Load::Clear([nothing, nothing, 0.0, 0.0])
}

/// A pass over what is seen, one pixel or sample one triangle.
pub(super) fn seen_pass(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    (name, reason): (&str, &str),
    (fragment, flags): (&'static str, &[&str]),
    (colors, samples): (Vec<ColorTarget>, u32),
) -> Result<Pass, ShaderError> {
    let (format, size_px) = (TextureFormat::Depth32Float, inputs.view.size_px);
    let depth = TextureDesc::new("depth of visible triangles", format, size_px, reason);
    let depth = needs.slots.texture(TextureDesc { samples, ..depth });
    let mut state = DrawState::new(CompareFunction::Greater, vec![Some(BlendState::REPLACE); colors.len()]);
    state.depth_write = true;
    let shader = ("surface_measure", flags, fragment);
    Ok(Pass {
        name: name.into(),
        reason: reason.into(),
        colors,
        depth: Some(DepthTarget::new(depth, Access::Clear(0.0))),
        draws: inputs.pulled_runs(&inputs.surfaces.opaque, shader, &state, &[])?,
    })
}

/// Draws what techniques ask to know about the layer of this scope.
pub(super) fn add_on_layer(
    inputs: &Inputs<'_>,
    schedule: &mut Schedule<'_>,
    scope: &Scope,
) -> Result<(), ShaderError> {
    let Some(Shown { name, fragment, flags }) = Shown::of(scope.seen) else { return Ok(()) };
    let triangles = scope.seen.triangles.map(|slot| ColorTarget::new(slot, no_triangle()));
    let planes = scope.seen.planes.map(|slot| ColorTarget::new(slot, NO_PLANE));
    let colors: Vec<_> = triangles.into_iter().chain(planes).collect();
    let state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE); colors.len()]);
    let shader = Shader::composed("surface_measure", flags, "vertex", Some(fragment))?;
    let geometry = inputs.pulled(shader, PulledStyle::Pulled, &inputs.surfaces.transparent);
    schedule.push(
        scope,
        Pass {
            name: name.into(),
            reason: "a technique asks what it is that each pixel shows".into(),
            colors,
            depth: Some(DepthTarget::TEST),
            draws: vec![Draw::new("transparent surfaces", geometry, state)],
        },
    );
    Ok(())
}
