//! Light that passes glass on its way to a plane takes on its colours.
//!
//! *The idea.* For each point of the light the glass before it is flattened as what is opaque is, and multiplies what passes into
//! a layer of a texture of its own: a surface counts as often as the way to that point crosses it. Four points at a time, their
//! layers are weighed as bits are, those that something opaque marked being dark, and added to a sum of the colours that arrive,
//! with the weights in its alpha.
//!
//! *Limits.* Where the adapter cannot blend 32-bit floats, half floats hold products and sums: up to 5e-4 of a factor is lost for
//! each surface, and for each four points. The plan says so.

use std::sync::Arc;

use bytemuck::bytes_of;
use shadowgraph_engine::plan::{
    ADD, Access, BufferDesc, CompareFunction, DrawState, Lifetime, Load, MULTIPLY, Resource, Shader,
    ShaderError, Stencil, StencilFaceState, TextureDesc, TextureFormat,
};
use shadowgraph_engine::shadow::{
    Binding, ColorTarget, DepthTarget, Draw, Features, Geometry, LightContext, Pass, PassList, ShadowError,
    hash_of,
};

use super::Lit;
use super::canvas::{Canvas, Targets};
use super::casters::Casters;
use super::draws::{caster_shader, flattened, shade, shader, visible_draws};
use super::receivers::Receiver;

/// Points whose tints are kept at a time.
const POINTS_AT_A_TIME: usize = 4;

/// Adds what arrives on `canvas` of the light through glass, and multiplies the light's visibility by it. What is opaque has
/// marked `targets` before.
pub(super) fn weigh(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    (canvas, targets): (&Canvas, Targets),
    (receiver, lit, casters): (&Receiver, &Lit, &Casters),
) -> Result<(), ShadowError> {
    let lifetime = canvas.key.map_or(Lifetime::Scratch, Lifetime::Kept);
    let format = if light.features.contains(Features::FLOAT32_BLENDABLE) {
        light.require(Features::FLOAT32_BLENDABLE, "products of what many surfaces let pass")?;
        TextureFormat::Rgba32Float
    } else {
        out.note(format!("glass over '{}': half floats, the adapter blends no wider ones", receiver.name));
        TextureFormat::Rgba16Float
    };
    let mut target = |name: &str, layers: usize, reason: &str| {
        let desc = TextureDesc::new(name, format, canvas.size_px, reason);
        out.texture(TextureDesc { layers: layers as u32, lifetime, ..desc })
    };
    let count = lit.heights.len();
    let layers = count.min(POINTS_AT_A_TIME);
    let tints = target("tints", layers, "what glass lets pass of each of some points of a light");
    let sum = target("tinted light", 1, "what arrives of all points, and how much they weigh");
    let matrices = canvas.matrices(light, out, (receiver, lit, casters));
    let points = canvas.points(light, out, (receiver, lit));
    let shaders = casters.glass().map(caster_shader).collect::<Result<Vec<_>, _>>()?;
    for first in (0..count).step_by(POINTS_AT_A_TIME) {
        let numbers = first..(first + POINTS_AT_A_TIME).min(count);
        for number in numbers.clone().filter(|number| lit.heights[*number] > 0.0) {
            tint(light, out, (receiver, casters, &shaders), (targets, tints, matrices), (number, first));
        }
        let chunk = [first as u32, numbers.end as u32];
        add(light, out, canvas, receiver, (chunk, [targets.bits, tints, points], sum))?;
    }
    if canvas.key.is_none() {
        let reason = "the colour of the light that reaches the receiver through glass";
        shade(light, out, receiver, ("tinted_share", reason), &[(6, Binding::Texture(sum))])?;
        return Ok(());
    }
    let place = canvas.place(light, out, receiver);
    let bindings = [(6, Binding::Texture(sum)), (7, Binding::Storage(place))];
    shade(light, out, receiver, ("tinted_share_from_texture", "the receiver wears its texture"), &bindings)?;
    Ok(())
}

/// Adds the pass that multiplies what glass lets pass of point `number` into its layer.
fn tint(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    (receiver, casters, shaders): (&Receiver, &Casters, &[Shader]),
    (targets, tints, matrices): (Targets, Resource, Resource),
    (number, first): (usize, usize),
) {
    // Only where the receiver is: there something has marked the stencil.
    let face = StencilFaceState { compare: CompareFunction::Less, ..StencilFaceState::IGNORE };
    let stencil = Stencil { front: face, back: face, read_mask: 0xff, write_mask: 0, reference: 0 };
    let mut draws = Vec::new();
    for (batch, shader) in casters.glass().zip(shaders).filter(|(batch, _)| batch.runs[number].1 > 0) {
        let state = DrawState {
            stencil: Some(stencil),
            ..DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)])
        };
        let first_caster = (number * casters.centers.len()) as u32;
        draws.push(flattened((batch, shader), matrices, (number, first_caster), state));
    }
    out.pass(Pass {
        name: format!("tints on {} from {}", receiver.name, light.light().name),
        reason: format!("glass before point {number} of the light"),
        colors: vec![ColorTarget {
            layer: (number - first) as u32,
            ..ColorTarget::new(tints, Load::Clear([1.0; 4]))
        }],
        depth: Some(DepthTarget {
            stencil: Some(Access::ReadOnly),
            ..DepthTarget::new(targets.stencil, Access::ReadOnly)
        }),
        draws,
    });
}

/// Adds the pass that adds what arrives of the points of a chunk to the sum.
fn add(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    canvas: &Canvas,
    receiver: &Receiver,
    (chunk, [bits, tints, points], sum): ([u32; 2], [Resource; 3], Resource),
) -> Result<(), ShaderError> {
    let [first, end] = chunk;
    let bytes = Arc::new(bytes_of(&chunk).to_vec());
    let key = hash_of(("planar chunk", chunk));
    let reason = "which points of the light are added";
    let chunk = out.buffer(BufferDesc::storage(&format!("points {first} to {end}"), key, bytes, reason));
    let bindings = vec![
        (4, Binding::TextureArray(bits)),
        (5, Binding::Storage(points)),
        (9, Binding::Storage(chunk)),
        (10, Binding::TextureArray(tints)),
    ];
    let (draws, depth) = if canvas.key.is_some() {
        let geometry = Geometry::fullscreen(shader(&["RECEIVER"], "fullscreen_vertex", "tinted_texel")?);
        let state = DrawState::new(CompareFunction::Always, vec![Some(ADD)]);
        (vec![Draw::new("texels", geometry, state).reading(bindings)], None)
    } else {
        let draws = visible_draws(light, out, receiver, ("tinted_points", ADD), &bindings)?;
        (draws, Some(DepthTarget::TEST))
    };
    let load = if first == 0 { Load::Clear([0.0; 4]) } else { Load::Keep };
    out.pass(Pass {
        name: format!("tinted light of {} on {}", light.light().name, receiver.name),
        reason: format!("points {first} to {} of the light", end - 1),
        colors: vec![ColorTarget::new(sum, load)],
        depth,
        draws,
    });
    Ok(())
}
