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
    Binding, BlendState, ColorTarget, CompareFunction, Draw, DrawState, Geometry, Load, Pass, SlotId,
    TextureFormat,
};
use shadowgraph_engine::shadow::{Channels, Features, LightPlan, ShadowError};

use super::draws::{Counter, counting_draws, volume_shader};
use super::{Reach, ShadowVolumeHard, volumes_pass};
use crate::common::layer_groups::Caster;
use crate::common::volume::Weights;
use crate::common::volume_draws::{Volume, upload};

/// Layers between every pixel and a light, for techniques that add fractions to them.
pub(crate) struct Layers<'a> {
    /// The target of one channel in which they were counted.
    pub(crate) counts: SlotId,
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
        light: &mut LightPlan<'a>,
    ) -> Result<Option<Layers<'a>>, ShadowError> {
        let volumes = self.volumes(light, Reach::BeyondShadow)?;
        if volumes.is_empty() {
            return Ok(None);
        }
        let fractions = light.features.contains(Features::FLOAT32_BLENDABLE);
        let counts = count(light, &volumes, fractions)?;
        Ok(Some(Layers { counts, casters: volumes.into_iter().map(|volume| volume.caster).collect() }))
    }
}

/// A half float holds every integer up to here.
const MAX_IN_HALF: u64 = 1 << 11;
/// A float holds every integer up to here.
const MAX_IN_FLOAT: u64 = 1 << 24;

/// Counts in a float target and darkens the light's visibility where the count is not zero.
pub(super) fn count_in_float(light: &mut LightPlan<'_>, volumes: &[Volume<'_>]) -> Result<(), ShadowError> {
    let counts = count(light, volumes, false)?;
    let name = light.light().name.clone();
    let target = light.multiply_visibility(Channels::One);
    light.pass(Pass {
        name: format!("darken {name}"),
        reason: "where its count is not zero, nothing of the light is left".into(),
        colors: vec![target],
        depth: None,
        draws: vec![Draw {
            name: "darken".into(),
            shader: Some(volume_shader("fullscreen_vertex", Some("darken_counted"), &[])),
            state: DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]),
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings: vec![(2, Binding::Texture(counts))],
            scissor_px: None,
        }],
    });
    Ok(())
}

/// Counts in a target of its own: in the smallest format that holds the sums, or in a float that holds `fractions` too.
fn count(light: &mut LightPlan<'_>, volumes: &[Volume<'_>], fractions: bool) -> Result<SlotId, ShadowError> {
    let everything: Vec<GroupMember> = (0..volumes.len()).map(GroupMember::whole).collect();
    let buffers = upload(light, volumes, &[everything], Weights::Apart);
    let draws: Vec<Draw> = volumes
        .iter()
        .zip(0..)
        .flat_map(|(volume, record)| counting_draws(volume, record, &buffers, Counter::Float))
        .collect();
    let largest: u64 =
        draws.iter().map(|draw| draw.vertices() / 3 * draw.state.blend_constant[0].abs() as u64).sum();
    let format = if fractions {
        format_for(light, largest.max(MAX_IN_HALF + 1))?
    } else {
        format_for(light, largest)?
    };
    let name = light.light().name.clone();
    let reason = format!("sums of up to {largest}, whatever the order of drawing");
    let counts = light.texture(&format!("counts of {name}"), format, light.view.size_px, 1, &reason);
    let target = ColorTarget { slot: counts, layer: 0, load: Load::Clear([0.0; 4]), resolve: None };
    light.pass(volumes_pass(light, volumes.len(), vec![target], light.test_depth(), draws));
    Ok(counts)
}

/// The smallest format that holds every integer up to `largest`.
fn format_for(light: &LightPlan<'_>, largest: u64) -> Result<TextureFormat, ShadowError> {
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
