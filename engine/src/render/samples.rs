//! Images with a texel for every sample, where a picture has several samples a pixel: what each sample shows, for techniques
//! that ask each and for measures. Texel (2x + s % 2, 2y + s / 2) is sample s of pixel (x, y).

use super::lights::ReceiverPasses;
use super::request::FrameError;
use super::resolve::fullscreen;
use super::schedule::{Inputs, Needs, RECEIVER_PLANES, Schedule, Scope, Seen};
use super::seen::{NO_PLANE, PLANES_REASON, seen_pass, triangles_reason};
use crate::plan::{
    Access, BlendState, CompareFunction, DepthId, DrawState, Load, Resource, ShaderError, SlotId, Symbol,
    TextureDesc, TextureFormat,
};
use crate::shadow::{Binding, ColorTarget, DepthTarget, Pass};

/// No format of 64 bits and two channels has samples, nor one of 128 bits; this one does.
const HALVES: TextureFormat = TextureFormat::Rgba16Uint;

/// Draws what every sample of the opaque surfaces shows, as far as techniques ask or factors are measured.
///
/// # Errors
/// What the adapter cannot do with four samples a pixel.
pub(super) fn add(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'_>,
    opaque: &ReceiverPasses,
) -> Result<Seen, FrameError> {
    let mut seen = Seen::default();
    if opaque.ask(Symbol::ReceiverDepth) {
        seen.depth = Some(depth(inputs, needs, schedule)?);
    }
    if opaque.ask(Symbol::ReceiverPlanes) {
        let what = ("receiver planes", PLANES_REASON, RECEIVER_PLANES);
        let drawn = ("plane_halves", &["PLANES"][..], NO_PLANE, 2);
        seen.planes = Some(in_halves(inputs, needs, schedule, what, drawn, ("plane", 5))?);
    }
    if inputs.request.factors || opaque.ask(Symbol::VisibleTriangles) {
        let what = ("visible triangles", triangles_reason(inputs), TextureFormat::Rg32Uint);
        let drawn = ("visible_triangle", &["HALVES"][..], Load::Clear([65535.0; 4]), 1);
        seen.triangles = Some(in_halves(inputs, needs, schedule, what, drawn, ("triangle", 0))?);
    }
    Ok(seen)
}

/// An image of this name, reason and format: drawn by (fragment entry point, flags) of surface_measure into samples, in so many
/// textures of halves that begin as said, and put together by an entry point of sample_images, which reads these from a
/// binding on.
fn in_halves(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    schedule: &mut Schedule<'_>,
    (name, reason, format): (&str, &str, TextureFormat),
    (fragment, flags, nothing, count): (&'static str, &[&str], Load, u32),
    (together, binding): (&'static str, u32),
) -> Result<SlotId, FrameError> {
    inputs.adapter.check_multisampled(name, HALVES)?;
    let samples = inputs.request.antialias.samples();
    let in_samples = format!("{name} in samples");
    let desc = TextureDesc { samples, ..TextureDesc::new(&in_samples, HALVES, inputs.view.size_px, reason) };
    let halves: Vec<SlotId> = (0..count).map(|_| needs.slots.texture(desc)).collect();
    let colors = halves.iter().map(|slot| ColorTarget::new(*slot, nothing)).collect();
    let pass = seen_pass(inputs, needs, (name, reason), (fragment, flags), (colors, samples))?;
    schedule.push(&Scope::default(), pass);
    let image = texture(inputs, needs, name, format);
    let read = halves.iter().map(|slot| Binding::Texture((*slot).into()));
    let pass = sample_pass(name, image, (together, &[]), (binding..).zip(read).collect())?;
    schedule.push(&Scope::default(), pass);
    Ok(image)
}

fn texture(inputs: &Inputs<'_>, needs: &mut Needs, name: &str, format: TextureFormat) -> SlotId {
    let size_px = inputs.request.antialias.factor_size_px(inputs.request.size_px);
    needs.texture(name, format, size_px, "a texel for every sample")
}

/// The depth of the opaque surfaces.
fn depth(inputs: &Inputs<'_>, needs: &mut Needs, schedule: &mut Schedule<'_>) -> Result<SlotId, ShaderError> {
    let slot = texture(inputs, needs, "depth of samples", TextureFormat::Depth32Float);
    let mut state = DrawState::new(CompareFunction::Always, vec![]);
    state.depth_write = true;
    let draw = fullscreen("samples", ("sample_images", &[], "depth"), state)?;
    schedule.push(
        &Scope::default(),
        Pass {
            name: "depth of samples".into(),
            reason: "a technique asks how far away the surface is that each sample shows".into(),
            colors: vec![],
            depth: Some(DepthTarget::new(slot, Access::Clear(0.0))),
            draws: vec![draw.reading(vec![(7, Binding::Texture(DepthId::default().resource()))])],
        },
    );
    Ok(slot)
}

/// A pass that writes a texel for every sample by an entry point of sample_images.
pub(super) fn sample_pass(
    name: &str,
    slot: SlotId,
    shader: (&'static str, &[&str]),
    bindings: Vec<(u32, Binding)>,
) -> Result<Pass, ShaderError> {
    let reason = "put together from samples, a texel for each";
    into_texels(
        (format!("{name} of samples"), reason),
        ColorTarget::new(slot, Load::Clear([0.0; 4])),
        shader,
        bindings,
    )
}

/// Writes darkness where a light that also has a visibility was counted as shadowed.
pub(super) fn to_visibility(light: &str) -> Result<Pass, ShaderError> {
    let what = (format!("resolve {light}"), "its counts darken its visibility, a texel for every sample");
    let counts = vec![(4, Binding::StencilOf(Resource::RECEIVER_DEPTH))];
    into_texels(what, ColorTarget::VISIBILITY, ("darken", &["COUNTS"]), counts)
}

fn into_texels(
    (name, reason): (String, &str),
    target: ColorTarget,
    (fragment, flags): (&'static str, &[&str]),
    bindings: Vec<(u32, Binding)>,
) -> Result<Pass, ShaderError> {
    let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
    let draw = fullscreen("samples", ("sample_images", flags, fragment), state)?.reading(bindings);
    Ok(Pass { name, reason: reason.into(), colors: vec![target], depth: None, draws: vec![draw] })
}
