//! Sums of logarithms and products of factors: what Kim, Kim & Turk accumulate, and a grid on which it is exact.
//!
//! *The grid.* A logarithm rounded to a multiple of 2^−q is a whole number of quanta, and sums of whole numbers cancel
//! exactly as long as they stay below 2^24. The finest q is taken, up to 22, for which that holds; where it would be so
//! coarse that a factor may lose 7e-4, the scene is refused.

use std::sync::Arc;

use bytemuck::cast_slice;
use glam::DVec3;
use shadowgraph_engine::geometry::GroupMember;
use shadowgraph_engine::plan::{
    BufferDesc, DrawState, Lifetime, Load, MULTIPLY, ShaderError, TextureDesc, TextureFormat,
};
use shadowgraph_engine::shadow::{
    Binding, ColorTarget, Contribution, DepthTarget, Draw, Features, LightContext, Pass, PassList,
    ShadowError, hash_of,
};

use super::{Accumulate, Tinted, counting_draws, layers_of, shader, transmit, weight_of};
use crate::common::volume::Weights;
use crate::common::volume_draws::{Volume, float_state, upload, volume_draws};

/// Less than this, 2^−32, no half float can show.
const SMALLEST_LOG: f64 = -32.0;
/// What a product of half floats can be divided by again.
const SMALLEST_HALF_FACTOR: f64 = 1.0 / 16384.0;
const SMALLEST_FLOAT_FACTOR: f64 = 1.0 / 4_294_967_296.0;
/// The finest grid of logarithms is 2 to minus this: finer than what half floats show behind a thousand surfaces.
const FINEST_GRID: i32 = 22;
/// What the grid may take from a factor, beside the rounding to half floats.
const MAX_GRID_ERROR: f64 = 7e-4;

/// Adds the passes that sum up `glass` in one target of three channels, and darken the light by the sum.
pub(super) fn add_up(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    glass: &[Tinted<'_>],
    accumulate: Accumulate,
) -> Result<Contribution, ShadowError> {
    let format = match accumulate {
        Accumulate::Log16 | Accumulate::Product16 => TextureFormat::Rgba16Float,
        _ => {
            light.require(Features::FLOAT32_BLENDABLE, "sums of 32-bit floats")?;
            TextureFormat::Rgba32Float
        }
    };
    let name = light.light().name.clone();
    let (draws, empty, fragment, binding) = match accumulate {
        Accumulate::Product16 => {
            (product_draws(light, out, glass, SMALLEST_HALF_FACTOR)?, 1.0, "transmit_product", None)
        }
        Accumulate::Product32 => {
            (product_draws(light, out, glass, SMALLEST_FLOAT_FACTOR)?, 1.0, "transmit_product", None)
        }
        _ => {
            let (draws, unit) = log_draws(light, out, glass, accumulate)?;
            let bytes = (unit as f32).to_ne_bytes().to_vec();
            let key = hash_of(("unit of logarithms", &bytes));
            let reason = "what logarithms are counted in";
            let name = format!("log unit of {name}");
            let slot = out.buffer(BufferDesc::storage(&name, key, Arc::new(bytes), reason));
            (draws, 0.0, "transmit_logarithms", Some((1, Binding::Storage(slot))))
        }
    };
    let what = if empty == 0.0 { "logarithms" } else { "products" };
    let reason = format!("{what} of what {} casters let pass", glass.len());
    let why = "logarithms or products of what surfaces let pass";
    let desc = TextureDesc::new("glass before a light", format, light.view.size_px, why);
    let sums = out.texture(TextureDesc { lifetime: Lifetime::Scratch, ..desc });
    out.pass(Pass {
        name: format!("transparent volumes of {name}"),
        reason,
        colors: vec![ColorTarget::new(sums, Load::Clear([empty; 4]))],
        depth: Some(DepthTarget::TEST),
        draws,
    });
    let bindings = binding.into_iter().chain([(3, Binding::Texture(sums))]).collect();
    let draws = vec![(shader(&[], "fullscreen_vertex", fragment)?, bindings)];
    Ok(transmit(light, out, glass, draws, format!("{what} become what is left of the light")))
}

/// The draws that add logarithms, and the unit they are counted in.
fn log_draws(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    glass: &[Tinted<'_>],
    accumulate: Accumulate,
) -> Result<(Vec<Draw>, f64), ShadowError> {
    let draws = counting_draws(light, out, glass)?;
    let log = |share: f64| share.log2().max(SMALLEST_LOG);
    let logs: Vec<DVec3> =
        glass.iter().map(|tinted| DVec3::from_array(tinted.transmission.to_array().map(log))).collect();
    let unit = if accumulate == Accumulate::GridLog { grid(light, glass, &draws, &logs)? } else { 1.0 };
    let mut summed = Vec::new();
    for (draws, log) in draws.into_iter().zip(&logs) {
        let quanta = if accumulate == Accumulate::GridLog { (*log / unit).round() } else { *log };
        summed.extend(draws.into_iter().map(|mut draw| {
            let weight = draw.state.blend_constant[0];
            draw.state.blend_constant = (quanta * weight).extend(0.0).to_array();
            draw
        }));
    }
    Ok((summed, unit))
}

/// The quantum on which no sum of `logs` is rounded: volumes are drawn one after the other, and of the one in the making
/// all entries may come before the first exit (as [`super::classes`] has it for counts).
fn grid(
    light: &LightContext<'_>,
    glass: &[Tinted<'_>],
    draws: &[Vec<Draw>],
    logs: &[DVec3],
) -> Result<f64, ShadowError> {
    let layers = layers_of(light, &glass.iter().collect::<Vec<_>>());
    let layers = f64::from(layers);
    let deepest = logs.iter().map(|log| -log.min_element()).fold(0.0, f64::max);
    let heaviest = draws.iter().map(|draws| weight_of(draws) as f64).fold(0.0, f64::max);
    let volumes = draws.iter().zip(logs).map(|(draws, log)| weight_of(draws) as f64 * -log.min_element());
    let largest = layers * deepest + 0.5 * (volumes.fold(0.0, f64::max) + layers * deepest);
    // Every logarithm may be rounded up by half a quantum.
    let fits = |unit: f64| largest / unit + heaviest + 2.0 * layers <= f64::from(1 << 24);
    let quantum = (0..=FINEST_GRID).rev().map(|q| 2.0_f64.powi(-q)).find(|unit| fits(*unit));
    // Behind n surfaces T is off by n·T·δ, δ = ln 2·quantum/2, and T is at most the n-th power of what the clearest
    // surface lets pass: n·rⁿ has its maximum where n = −1/ln r.
    let shares = logs.iter().flat_map(|log| log.to_array()).filter(|log| *log < 0.0);
    let clearest = shares.fold(f64::NEG_INFINITY, f64::max) * std::f64::consts::LN_2;
    let surfaces = (-1.0 / clearest).min(layers).max(1.0);
    let error =
        |quantum: f64| surfaces * (surfaces * clearest).exp() * 0.5 * std::f64::consts::LN_2 * quantum;
    quantum.filter(|quantum| error(*quantum) <= MAX_GRID_ERROR).ok_or_else(|| {
        light.unsupported(format!(
            "accumulate=gridLog, but sums of logarithms of up to {largest:.0} behind up to {layers} surfaces need a \
             finer grid than 32-bit floats have (accepted for it: counts, log32)"
        ))
    })
}

/// The draws that multiply and divide by what surfaces let pass, at least `smallest`.
fn product_draws(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    glass: &[Tinted<'_>],
    smallest: f64,
) -> Result<Vec<Draw>, ShaderError> {
    let volumes: Vec<Volume<'_>> = glass.iter().map(|tinted| tinted.volume.clone()).collect();
    let everything: Vec<GroupMember> = (0..volumes.len()).map(GroupMember::whole).collect();
    // A face is multiplied as often as it weighs.
    let buffers = upload(light, out, &volumes, &[everything], Weights::Repeated);
    let factors: Vec<[f32; 4]> = glass
        .iter()
        .map(|tinted| tinted.transmission.max(DVec3::splat(smallest)).as_vec3().extend(1.0).to_array())
        .collect();
    let bytes: &[u8] = cast_slice(&factors);
    let factors = out.buffer(BufferDesc::storage(
        &format!("glass of {}", light.light().name),
        hash_of(("glass factors", bytes)),
        Arc::new(bytes.to_vec()),
        "what a surface of each caster lets pass",
    ));
    let draws = |(volume, record): (&Volume<'_>, u32)| {
        let mut draws = volume_draws(volume, record, &buffers, |how, flags| {
            let compare = float_state(volume.z_fail, how).depth_compare;
            let turned = (how.weight < 0) != volume.z_fail;
            let fragment = match (how.front_faces(), turned) {
                (None, false) => "multiply",
                (None, true) => "divide",
                (Some(true), false) => "multiply_front",
                (Some(true), true) => "divide_front",
                (Some(false), false) => "divide_back",
                (Some(false), true) => "multiply_back",
            };
            Ok((shader(flags, "vertex", fragment)?, DrawState::new(compare, vec![Some(MULTIPLY)])))
        })?;
        draws.iter_mut().for_each(|draw| draw.bindings.push((2, Binding::Storage(factors))));
        Ok(draws)
    };
    Ok(volumes.iter().zip(0..).map(draws).collect::<Result<Vec<_>, ShaderError>>()?.concat())
}
