//! What tests and reports compare: each light's factor as a linear image; of every sample, where edges are smoothed by
//! several samples a pixel.

use std::sync::Arc;

use super::factors::Factors;
use super::samples::sample_pass;
use super::schedule::{Group, Inputs, Needs};
use crate::math::facing_sign;
use crate::plan::{
    BlendState, BufferDesc, BufferUsage, CompareFunction, DrawState, FactorAt, Load, Resource, ShaderError,
    SlotId, TextureFormat,
};
use crate::shadow::{Binding, Channels, ColorTarget, DepthTarget, Pass, hash_of};

/// The factor of light number `light`, which is `at` this place: of the visibility, in the layer of the group. It holds the
/// receivers' own shadows, or the image gets them.
pub(super) fn add(
    inputs: &Inputs<'_>,
    needs: &mut Needs,
    group: &mut Group<'_>,
    factors: &Factors,
    light: usize,
    (at, own_shadow): (FactorAt, bool),
) -> Result<SlotId, ShaderError> {
    let name = format!("factor of {}", inputs.snapshot.lights[light].name);
    let size_px = inputs.request.antialias.factor_size_px(inputs.request.size_px);
    let slot = needs.texture(&name, format_of(factors, at), size_px, "asked for");
    let mut bindings = Vec::new();
    if !own_shadow {
        bindings.push((3, Binding::Storage(turned_away(inputs, needs, light).into())));
    }
    let flags: &[&str] = match at {
        FactorAt::Counts | FactorAt::MaskBit(_) | FactorAt::Darkening => {
            bindings.push((4, Binding::StencilOf(Resource::RECEIVER_DEPTH)));
            &["COUNTS"]
        }
        FactorAt::Visibility(_) => {
            bindings.push((4, Binding::Texture(Resource::VISIBILITY)));
            if own_shadow { &["VISIBILITY", "OWN_SHADOW"] } else { &["VISIBILITY"] }
        }
        FactorAt::Lit => &[],
    };
    if let (true, Some(triangles)) = (inputs.is_multisampled(), group.scope.seen.triangles) {
        bindings.push((1, Binding::Texture(triangles.into())));
        group.push(sample_pass(&name, slot, ("factor", flags), bindings)?);
        return Ok(slot);
    }
    let state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
    let shader = ("surface_factor", flags, "factor");
    let draws = inputs.pulled_runs(&inputs.surfaces.opaque, shader, &state, &bindings)?;
    group.push(Pass {
        name,
        reason: "the factor was asked for as an image".into(),
        colors: vec![ColorTarget::new(slot, Load::Clear([1.0; 4]))],
        depth: Some(DepthTarget::TEST),
        draws,
    });
    Ok(slot)
}

/// The format of an image of what is at this place.
pub(super) fn format_of(factors: &Factors, at: FactorAt) -> TextureFormat {
    match (at, factors.channels) {
        (FactorAt::Visibility(_), Channels::Rgb) => TextureFormat::Rgba32Float,
        _ => TextureFormat::R32Float,
    }
}

/// One bit for each triangle of the frame: the eye sees the side turned away from the light. Decided in f64.
fn turned_away(inputs: &Inputs<'_>, needs: &mut Needs, light: usize) -> SlotId {
    let light = &inputs.snapshot.lights[light];
    let mut bits: Vec<u32> = Vec::new();
    let mut first = 0;
    for instance in &inputs.snapshot.instances {
        let count = instance.mesh.triangle_count();
        bits.resize((first + count).div_ceil(32).max(1), 0);
        let world: Vec<_> =
            (0..instance.mesh.positions().len() as u32).map(|v| instance.world_position(v)).collect();
        for triangle in 0..count {
            let [a, b, c] = instance.mesh.triangle(triangle).map(|v| world[v as usize]);
            let eye_side = facing_sign(a, b, c, inputs.view.frustum.eye);
            if eye_side * facing_sign(a, b, c, light.position) < 0 {
                bits[(first + triangle) / 32] |= 1 << ((first + triangle) % 32);
            }
        }
        first += count;
    }
    if bits.is_empty() {
        bits.push(0);
    }
    needs.slots.buffer(BufferDesc {
        name: &format!("turned away from {}", light.name),
        usage: BufferUsage::Storage,
        revision_key: hash_of(("turned away", &bits)),
        contents: Arc::new(bytemuck::cast_slice(&bits).to_vec()),
        reason: "surfaces turned away from a light are dark",
    })
}
