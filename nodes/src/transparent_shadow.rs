//! `TransparentShadow`: coloured shadows of casters that let light through.
//!
//! *The idea.* A surface lets a share r of the light pass, red, green and blue apart; what arrives is the product of all
//! shares on the way, T = Π rᵢ^nᵢ. The exponents are what shadow volumes count: nᵢ is the number of surfaces of
//! material i between a point and the light. So the chain of every material's triangles is drawn as an opaque caster's
//! would be, into a float target instead of the stencil, and one look at every pixel turns sums into light.
//!
//! *Source.* Kim, Kim & Turk, *Real Time Shadow of Transparent Casters Using Shadow Volume*: cap counts of any polygon
//! soup, light caps signed by the eye's side, the map of light intensity.
//!
//! *What differs here.*
//! - Whole numbers are added up, not powers or logarithms of shares: whole numbers cancel exactly, so that what is lit
//!   is lit exactly and the order of drawing changes no pixel. Several materials share a channel, each in bits of its
//!   own (see [`classes`]). The paper's sums are there to be measured: `accumulate` log16, product16, and in 32 bits.
//! - A side is drawn once, whatever it counts; blending multiplies.
//! - z-pass where the near plane is certainly unshadowed by the caster, z-fail elsewhere. Front caps are drawn in both:
//!   what is transparent is not in the depth buffer, so the view may go on behind it.
//! - A share of 0 is a share like any other, and one of 1 casts nothing.
//! - Textured panes cast texel by texel: see [`panes`].
//! - Opaque and masked parts cast black, as through [`ShadowVolumeHard`]: one light's factors multiply.
//!
//! *Limits.* As [`ShadowVolumeHard`]: pixels within 1/256 pixel of a shadow's edge; lights that all but touch a caster.
//! Half floats hold the light's visibility, so factors are rounded to 11 bits.

mod classes;
mod options;
mod panes;
mod sums;

use glam::{DVec3, DVec4};
use shadowgraph_engine::geometry::{CastTriangles, GroupMember, max_layers};
use shadowgraph_engine::plan::{BlendState, CompareFunction, DrawState, MULTIPLY, Shader, ShaderError};
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Binding, Channels, ColorTarget, Contribution, Draw, Features, Geometry, Layers, LightContext, Options,
    Pass, PassList, ShadowError, ShadowTechnique, Traits, hash_of,
};

use crate::ShadowVolumeHard;
use crate::common::culling::near_plane_may_be_shadowed;
use crate::common::extrusion::end_in_view;
use crate::common::facing::CasterFacing;
use crate::common::layer_groups::Caster;
use crate::common::ray_candidates::Layout;
use crate::common::screen_bounds::{united, volume_pixels};
use crate::common::volume::{CastShape, Half, Weights};
use crate::common::volume_draws::{Volume, begin_of, falls_on_itself, float_state, upload, volume_draws};
pub use options::{Accumulate, SelfShadow, TransparentShadow};

impl ShadowTechnique for TransparentShadow {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        let known_error = match self.accumulate {
            Accumulate::Counts => {
                "rounding to half floats; and rasterisation: pixels whose centre is within 1/256 pixel of a shadow edge"
            }
            Accumulate::GridLog => {
                "logarithms rounded to a grid, which takes no more than 7e-4 from a factor; and rasterisation: pixels \
                 whose centre is within 1/256 pixel of a shadow edge"
            }
            Accumulate::Log16 => {
                "sums of half-float logarithms do not cancel: ghosts, up to 0.16 behind 128 surfaces, and lit pixels \
                 that are not quite lit; they depend on the order of drawing"
            }
            Accumulate::Product16 => {
                "half-float products do not cancel, and leave the range of half floats: behind some dozen surfaces, or \
                 three or four dark ones, the factor may be anything; surfaces that let less than 6e-5 pass are taken to let that much pass"
            }
            Accumulate::Log32 => {
                "sums of 32-bit logarithms do not quite cancel: about 2e-5 behind 128 surfaces"
            }
            Accumulate::Product32 => {
                "32-bit products do not quite cancel, and may leave the range of floats behind many dark surfaces"
            }
        };
        let receiver_layers = match self.self_shadow {
            SelfShadow::Full => Layers::All,
            SelfShadow::Partial => Layers::First,
            SelfShadow::None => Layers::OpaqueOnly,
        };
        let approximates = matches!(self.accumulate, Accumulate::Log16 | Accumulate::Product16);
        Traits { known_error, approximates, casts_transparent: true, receiver_layers, ..Traits::default() }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.materials.iter().any(|material| !material.unlit))
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        // What is opaque or masked casts black.
        let black = ShadowVolumeHard::default().plan(light, out)?;
        let glass = tinted_volumes(light, out)?;
        let glass = match self.accumulate {
            _ if glass.is_empty() => Contribution::default(),
            Accumulate::Counts => classes::count(light, out, &glass)?,
            sum => sums::add_up(light, out, &glass, sum)?,
        };
        Ok(black.and(glass).and(cast_panes(light, out)?))
    }
}

/// The volume of those parts of one caster that let the same share of the light pass.
struct Tinted<'a> {
    volume: Volume<'a>,
    /// What one surface lets pass, each from 0 to 1.
    transmission: DVec3,
}

/// The volumes of all evenly tinted parts that can matter, with depth test and end chosen.
fn tinted_volumes<'a>(
    light: &LightContext<'a>,
    out: &mut PassList<'_>,
) -> Result<Vec<Tinted<'a>>, ShadowError> {
    let (position, view) = (light.light().position, light.view);
    let mut tinted = Vec::new();
    for (index, instance) in light.casters() {
        let mut parts_by_tint: Vec<(DVec3, Vec<usize>)> = Vec::new();
        for part in 0..instance.materials.len() {
            let Some(transmission) = tint(instance, part) else { continue };
            match parts_by_tint.iter_mut().find(|(other, _)| *other == transmission) {
                Some((_, parts)) => parts.push(part),
                None => parts_by_tint.push((transmission, vec![part])),
            }
        }
        if parts_by_tint.is_empty() {
            continue;
        }
        if let Err(reason) = light.may_shadow(&instance.world_bounds) {
            out.note(format!("transparent caster of '{}' '{}': {reason}", light.light().name, instance.name));
            continue;
        }
        let z_fail = near_plane_may_be_shadowed(&view.frustum, position, &instance.world_bounds);
        let perspective = view.frustum.eye.w > 0.0;
        if z_fail && !perspective {
            let purpose = "counting behind surfaces seen by an orthographic camera";
            light.require(Features::DEPTH_CLIP_CONTROL, purpose)?;
        }
        for (transmission, parts) in parts_by_tint {
            let shape = CastShape::Own(instance.mesh.topology());
            let position_bits = position.to_array().map(f64::to_bits);
            let key = hash_of((instance.pose_key, position_bits, "tinted", &parts));
            let facing = light.cache.get_or_compute("facing", key, || {
                CasterFacing::of_parts(light, instance, &shape, Half::Both, |part| parts.contains(&part))
            });
            if facing.cast.is_empty() {
                continue;
            }
            let volume = Volume {
                caster: Caster { index, instance, shape, key, facing },
                z_fail,
                hidden_caps_count: true,
                falls_on_itself: falls_on_itself(light),
                begin: begin_of(light, Half::Both),
                end: end_in_view(view, position, &instance.world_bounds),
                clamp_depth: z_fail && !perspective,
                directional: position.w == 0.0,
                half: Half::Both,
            };
            tinted.push(Tinted { volume, transmission });
        }
    }
    Ok(tinted)
}

/// Casts the parts that are not evenly tinted, if one of their casters can matter: what the light sees of them is then kept
/// however the eye turns.
fn cast_panes(light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
    let parts_of = |instance| uneven_parts(instance).map(move |part| (instance, part));
    let parts: Vec<(&Instance, usize)> =
        light.casters().flat_map(|(_, instance)| parts_of(instance)).collect();
    if parts.iter().any(|(instance, _)| light.may_shadow(&instance.world_bounds).is_ok()) {
        return panes::cast(light, out, &parts);
    }
    Ok(Contribution::default())
}

/// The transparent parts of which not every surface lets the same pass.
fn uneven_parts(instance: &Instance) -> impl Iterator<Item = usize> + '_ {
    let parts = instance.materials.iter().enumerate();
    parts
        .filter(|(part, material)| material.is_transparent() && color_of(instance, *part).is_none())
        .map(|(part, _)| part)
}

/// What every surface of a part lets pass, if that is the same everywhere; `None` too for what casts no colour: opaque
/// parts, and those through which everything passes.
fn tint(instance: &Instance, part: usize) -> Option<DVec3> {
    let material = &instance.materials[part];
    if !material.is_transparent() {
        return None;
    }
    let transmission = material.transmission_at(color_of(instance, part)?);
    (transmission != DVec3::ONE).then_some(transmission)
}

/// The base colour of a part that is the same at every point.
fn color_of(instance: &Instance, part: usize) -> Option<DVec4> {
    let (mesh, material) = (&instance.mesh, &instance.materials[part]);
    let triangles = mesh.data().parts[part].triangles.clone();
    let vertices = triangles.flat_map(|triangle| mesh.triangle(triangle as usize));
    let mut colors = vertices.map(|vertex| mesh.color8(vertex));
    let first = colors.next().unwrap_or([255; 4]);
    let differ = !mesh.data().colors.is_empty() && colors.any(|color| color != first);
    if material.base_color_texture.is_some() || differ {
        return None;
    }
    let color = DVec4::from_array(first.map(|byte| f64::from(byte) / 255.0));
    Some(material.base_color.as_dvec4() * color)
}

/// A shader of this technique's own.
fn shader(flags: &[&str], vertex: &'static str, fragment: &'static str) -> Result<Shader, ShaderError> {
    Shader::composed("transparent_shadow", flags, vertex, Some(fragment))
}

/// The draws of all volumes, apart, as sums of whole numbers: every channel of the blend constant is what one face counts.
fn counting_draws(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    glass: &[Tinted<'_>],
) -> Result<Vec<Vec<Draw>>, ShaderError> {
    let volumes: Vec<Volume<'_>> = glass.iter().map(|tinted| tinted.volume.clone()).collect();
    let everything: Vec<GroupMember> = (0..volumes.len()).map(GroupMember::whole).collect();
    let buffers = upload(light, out, &volumes, &[everything], Weights::Apart);
    let draws = |(volume, record): (&Volume<'_>, u32)| {
        volume_draws(volume, record, &buffers, |how, flags| {
            let fragment = match how.front_faces() {
                None => "add",
                Some(true) => "add_front",
                Some(false) => "add_back",
            };
            Ok((shader(flags, "vertex", fragment)?, float_state(volume.z_fail, how)))
        })
    };
    volumes.iter().zip(0..).map(draws).collect()
}

/// How many crossings the draws of a volume add at most to one pixel, each as often as it weighs.
fn weight_of(draws: &[Draw]) -> u64 {
    draws.iter().map(|draw| draw.vertices() / 3 * draw.state.blend_constant[0].abs() as u64).sum()
}

/// A bound on the surfaces of `glass` between any point and the light. Kept until a caster or the light moves.
fn layers_of(light: &LightContext<'_>, glass: &[&Tinted<'_>]) -> u32 {
    let (position, keys) = (light.light().position, glass.iter().map(|tinted| tinted.volume.caster.key));
    let key = hash_of(keys.collect::<Vec<u64>>());
    *light.cache.get_or_compute("glass layers", key, || {
        let triangles: Vec<CastTriangles<'_>> =
            glass.iter().map(|tinted| tinted.volume.caster.triangles()).collect();
        let everything: Vec<GroupMember> = (0..triangles.len()).map(GroupMember::whole).collect();
        max_layers(position, &triangles, &everything, 1)
    })
}

/// The pass that multiplies the light's visibility by what the sums of `glass` say, with these shaders and what they read.
fn transmit(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    glass: &[Tinted<'_>],
    draws: Vec<(Shader, Vec<(u32, Binding)>)>,
    reason: String,
) -> Contribution {
    let (view, position) = (light.view, light.light().position);
    let pixels =
        |volume: &Volume<'_>| volume_pixels(view, position, &volume.caster.instance.world_bounds, volume.end);
    // Nothing in view: one pixel, since there is no empty scissor.
    let touched =
        glass.iter().map(|tinted| pixels(&tinted.volume)).fold(None, united).unwrap_or([0, 0, 1, 1]);
    let untouched = !out.visibility_is_touched();
    let draw = |((shader, bindings), place): ((Shader, Vec<(u32, Binding)>), usize)| {
        // What nothing has darkened yet need not be read.
        let blend = if untouched && place == 0 { BlendState::REPLACE } else { MULTIPLY };
        let state = DrawState::new(CompareFunction::Always, vec![Some(blend)]);
        let draw = Draw::new("transmit", Geometry::fullscreen(shader), state).reading(bindings);
        Draw { scissor_px: Some(touched), ..draw }
    };
    out.pass(Pass {
        name: format!("light through glass of {}", light.light().name),
        reason,
        colors: vec![ColorTarget::VISIBILITY],
        depth: None,
        draws: draws.into_iter().zip(0..).map(draw).collect(),
    });
    Contribution::visibility(Channels::Rgb)
}

/// The structures of this technique's shaders as they are here, by module: what the layout test compares.
pub fn layouts() -> Vec<(&'static str, &'static str, Layout)> {
    let panes = panes::layouts().map(|(structure, layout)| ("transparent_panes", structure, layout));
    panes.into_iter().chain([("transparent_shadow", "Class", classes::layout())]).collect()
}
