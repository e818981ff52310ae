//! `counter=float`: counts added up by blending in a float target, any weight at once.
//!
//! Blending knows no operation for fragments that fail the depth test, so z-fail draws with the inverse comparison.
//!
//! *How large a number gets.* What ends at a pixel is the number of layers between it and the light. What a sum reaches
//! *on the way* depends on the order of drawing: all entries may come before the first exit, also where a lit surface is
//! seen through many volumes and the end is 0. A format is taken that holds every integer up to all that is drawn for
//! the light, each triangle as often as it weighs: no order of drawing can lead beyond.

use shadowgraph_engine::geometry::GroupMember;
use shadowgraph_engine::plan::{
    BlendState, CompareFunction, DrawState, Load, Resource, ShaderError, TextureDesc, TextureFormat,
};
use shadowgraph_engine::shadow::{
    Binding, Channels, ColorTarget, Contribution, DepthTarget, Draw, Features, Geometry, LightContext, Pass,
    PassList, ShadowError,
};

use super::draws::{Counter, counting_draws, volume_shader};
use super::{Reach, ShadowVolumeHard, volumes_pass};
use crate::common::layer_groups::Caster;
use crate::common::volume::Weights;
use crate::common::volume_draws::{Volume, upload};

/// Layers between every pixel and a light, for techniques that add fractions to them.
pub(crate) struct Layers<'a> {
    /// The target of one channel in which they were counted.
    pub(crate) counts: Resource,
    /// The casters that were counted, with the triangles that cast.
    pub(crate) casters: Vec<Caster<'a>>,
}

impl ShadowVolumeHard {
    /// Counts all casters of the light in a float target, those too whose shadow from the light's centre is not in view,
    /// and leaves it at that. `None` when there is nothing to count.
    ///
    /// # Errors
    /// What the options do not accept.
    pub(crate) fn count_layers<'a>(
        &self,
        light: &LightContext<'a>,
        out: &mut PassList<'_>,
    ) -> Result<Option<Layers<'a>>, ShadowError> {
        let volumes = self.volumes(light, out, Reach::BeyondShadow)?.volumes;
        if volumes.is_empty() {
            return Ok(None);
        }
        let fractions = light.features.contains(Features::FLOAT32_BLENDABLE);
        let counts = count(light, out, &volumes, fractions)?;
        Ok(Some(Layers { counts, casters: volumes.into_iter().map(|volume| volume.caster).collect() }))
    }
}

/// A half float holds every integer up to here.
const MAX_IN_HALF: u64 = 1 << 11;
/// A float holds every integer up to here.
const MAX_IN_FLOAT: u64 = 1 << 24;

/// Counts in a float target and darkens the light's visibility where the count is not zero.
pub(super) fn count_in_float(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    volumes: &[Volume<'_>],
) -> Result<Contribution, ShadowError> {
    let counts = count(light, out, volumes, false)?;
    let name = light.light().name.clone();
    let shader = volume_shader("fullscreen_vertex", Some("darken_counted"), &[])?;
    let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
    let draw = Draw::new("darken", Geometry::fullscreen(shader), state);
    out.pass(Pass {
        name: format!("darken {name}"),
        reason: "where its count is not zero, nothing of the light is left".into(),
        colors: vec![ColorTarget::VISIBILITY],
        depth: None,
        draws: vec![draw.reading(vec![(2, Binding::Texture(counts))])],
    });
    Ok(Contribution::visibility(Channels::One))
}

/// Counts in a target of its own: in the smallest format that holds the sums, or in a float that holds `fractions` too.
fn count(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    volumes: &[Volume<'_>],
    fractions: bool,
) -> Result<Resource, ShadowError> {
    let everything: Vec<GroupMember> = (0..volumes.len()).map(GroupMember::whole).collect();
    let buffers = upload(light, out, volumes, &[everything], Weights::Apart);
    let draws = volumes.iter().zip(0..);
    let draws = draws.map(|(volume, record)| counting_draws(volume, record, &buffers, Counter::Float));
    let draws = draws.collect::<Result<Vec<_>, ShaderError>>()?.concat();
    let largest: u64 =
        draws.iter().map(|draw| draw.vertices() / 3 * draw.state.blend_constant[0].abs() as u64).sum();
    let format = if fractions {
        format_for(light, largest.max(MAX_IN_HALF + 1))?
    } else {
        format_for(light, largest)?
    };
    let name = light.light().name.clone();
    let reason = format!("sums of up to {largest}, whatever the order of drawing");
    let desc = TextureDesc::new(&name, format, light.view.size_px, &reason);
    let counts = out.texture(TextureDesc { name: &format!("counts of {name}"), ..desc });
    let target = ColorTarget::new(counts, Load::Clear([0.0; 4]));
    out.pass(volumes_pass(light, volumes.len(), vec![target], DepthTarget::TEST, draws));
    Ok(counts)
}

/// The smallest format that holds every integer up to `largest`.
fn format_for(light: &LightContext<'_>, largest: u64) -> Result<TextureFormat, ShadowError> {
    match largest {
        ..=MAX_IN_HALF => Ok(TextureFormat::R16Float),
        sum if sum <= MAX_IN_FLOAT => {
            let why = format!("counter=float, and sums of up to {largest} are no integers of half floats");
            light.require(Features::FLOAT32_BLENDABLE, &why)?;
            Ok(TextureFormat::R32Float)
        }
        _ => Err(light.unsupported(format!(
            "counter=float, but sums of up to {largest} are beyond the {MAX_IN_FLOAT} a float holds exactly \
             (accepted: auto, stencil8)"
        ))),
    }
}
