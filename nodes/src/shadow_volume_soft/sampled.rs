//! Quality `sampled`: every sample of the light is blocked or not, exactly.
//!
//! One draw over the picture. Each pixel rebuilds its point, looks up the edges that may cross the light's disc and the
//! triangles that may hide its centre, and keeps a count for each sample: see shadow_volume_soft.wgsl.

use std::sync::Arc;

use bytemuck::cast_slice;
use shadowgraph_engine::plan::{
    Binding, BufferUsage, CompareFunction, Draw, DrawState, Geometry, MULTIPLY, Pass, Shader,
};
use shadowgraph_engine::shadow::{Channels, LightPlan, ShadowError, hash_of, light_samples};

use super::ShadowVolumeSoft;
use super::gather::Gathered;

impl ShadowVolumeSoft {
    pub(super) fn plan_sampled(&self, light: &mut LightPlan<'_>) -> Result<(), ShadowError> {
        let Gathered { mut bindings, casters, edges, triangles, most_layers } = self.gather(light)?;
        if light.view.receiver_bounds.is_empty() {
            return Ok(());
        }
        let name = light.light().name.clone();
        let samples: Vec<[f32; 2]> =
            light_samples(self.samples).iter().map(|sample| sample.as_vec2().to_array()).collect();
        let samples = Arc::new(cast_slice::<_, u8>(&samples).to_vec());
        let key = hash_of(("light samples", self.samples));
        let reason = "where on the light's disc it is asked";
        let samples = light.buffer("light samples", BufferUsage::Storage, key, samples, reason);
        bindings.push((5, Binding::Storage(samples)));
        light.decides_own_shadow();
        let target = light.multiply_visibility(Channels::One);
        light.pass(Pass {
            name: format!("soft shadow of {name}"),
            reason: format!("{} samples of {name} before {casters} casters, at every pixel", self.samples),
            colors: vec![target],
            depth: None,
            draws: vec![Draw {
                name: format!("{edges} edges, {triangles} triangles"),
                shader: Some(shader(most_layers)),
                state: DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)]),
                geometry: Geometry::Procedural { vertices: 3, instances: 1 },
                bindings,
                scissor_px: None,
            }],
        });
        Ok(())
    }
}

/// The shader, with casters if there are any, and counters for so many layers.
fn shader(most_layers: u32) -> Shader {
    let flags: &[&str] = match most_layers {
        0 => &[],
        1..256 => &["CASTERS"],
        _ => &["CASTERS", "DEEP"],
    };
    let source = shadowgraph_shaders::compose_named("shadow_volume_soft", flags).unwrap_or_default();
    let name: Vec<&str> = std::iter::once("shadow_volume_soft").chain(flags.iter().copied()).collect();
    Shader {
        name: name.join(" ").into(),
        source: source.into(),
        vertex: "fullscreen_vertex".into(),
        fragment: Some("sampled".into()),
    }
}
