//! `quality=perReceiver`: what is left of the light, by areas, over the silhouette that each receiver sees.
//!
//! *The idea.* A first draw over the picture marks the pixels that may see a part of the light only. In the second, each
//! looks up the edges that may cross the light's disc and the triangles that may hide its centre, as `sampled` does, and
//! works with areas: an edge is a silhouette for p if p lies on opposite sides of its two triangles; the part of it within
//! the disc adds what it covers beside the centre, and the number of triangles over the centre is the constant of the sum:
//! see `common/disc_coverage`. The receiver's own plane cuts the disc, and casters with it, by a chord. Triangles near the light, which may be met beyond it, are cut to
//! what lies before it and asked one by one.
//!
//! *Sources.* The penumbra wedges of Assarsson & Akenine-Möller 2003, with their first two errors mended: silhouettes are
//! those of the receiver, and count and edges take their signs from the same numbers in one shader, so that nothing jumps
//! where an edge passes the light's centre.
//!
//! *What it is worth.* Exact, to f32, before one convex caster: no noise, no steps, the cost of one sample.
//!
//! *Limits.* Areas add up: where the images of two casters, or of two layers of one, overlap on the disc, it is too dark,
//! by as much as they overlap (two boards one behind the other: all of the half they both leave). What is
//! dark as a whole stays dark, and what is lit stays lit. Open casters count every layer. Receivers nearer to the
//! light than two of its radii ask all triangles. Parts with holes are asked sample by sample, see `masks`.

use shadowgraph_engine::plan::Shader;
use shadowgraph_engine::shadow::{Contribution, LightContext, PassList, ShadowError};

use super::ShadowVolumeSoft;
use super::light_data::{LightData, Parts};
use super::penumbra_mask::mark_and_ask;

impl ShadowVolumeSoft {
    pub(super) fn plan_per_receiver(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
    ) -> Result<Contribution, ShadowError> {
        let data = self.light_data(light, out, Parts::Whole)?;
        Ok(ask(light, out, data)?.and(self.plan_masks(light, out)?))
    }

    /// Adds what receivers see of the light beyond their horizon, whatever casts: nothing to ask of transparent surfaces, which
    /// have none.
    pub(super) fn plan_horizon(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
    ) -> Result<Contribution, ShadowError> {
        if light.layer().is_some() {
            return Ok(Contribution::default());
        }
        let data = self.bind(light, out, None)?;
        ask(light, out, data)
    }
}

fn ask(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    data: LightData,
) -> Result<Contribution, ShadowError> {
    let flags = flags_of(&data);
    let LightData { bindings, casters, edges, triangles, .. } = data;
    if light.view.receiver_bounds.is_empty() {
        return Ok(Contribution::default());
    }
    let shader = |fragment| Shader::composed("per_receiver", &flags, "soft_vertex", Some(fragment));
    let shaders = [shader("mark")?, shader("per_receiver")?];
    let reason = format!("what {casters} casters cover of {}, by areas", light.light().name);
    let asked = format!("{edges} edges, {triangles} triangles");
    Ok(mark_and_ask(light, out, bindings, shaders, (reason, asked)))
}

/// The shader's flags for what there is to ask.
fn flags_of(data: &LightData) -> Vec<&'static str> {
    let wanted = [
        ("CASTERS", data.casters > 0),
        ("CLUSTERS", data.clusters),
        ("BESIDE", data.beside),
        ("ON_LAYER", data.on_layer),
        ("ONE_CASTER", data.casters == 1),
    ];
    wanted.into_iter().filter(|(_, wanted)| *wanted).map(|(flag, _)| flag).collect()
}
