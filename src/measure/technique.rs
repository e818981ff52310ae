//! The reference as a technique: pictures whose shadows are the exact answer.
//!
//! It plugs in like any other. Its plan traces the reference on the CPU and multiplies the result into the light's
//! visibility, so `--technique reference` shows what every other technique is compared with.

use std::sync::Arc;

use shadowgraph_engine::plan::{
    Binding, BufferUsage, CompareFunction, Draw, DrawState, Geometry, MULTIPLY, Pass, Shader,
};
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Channels, LightPlan, OptionReader, ShadowError, ShadowTechnique, TechniqueEntry, hash_of,
};

use super::{LightQuery, Reference};

/// Exact hard shadows, traced on the CPU for every pixel: seconds for a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReferenceShadow;

const TYPE_NAME: &str = "Reference";

impl ReferenceShadow {
    /// How a catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry {
        type_name: TYPE_NAME,
        short_name: "reference",
        summary: "exact hard shadows, traced on the CPU",
        from_params: |params| {
            OptionReader::new(TYPE_NAME, params).finish()?;
            Ok(Arc::new(Self))
        },
        settings: &[],
    };
}

impl ShadowTechnique for ReferenceShadow {
    fn type_name(&self) -> &'static str {
        TYPE_NAME
    }

    fn params(&self) -> Params {
        Params::new()
    }

    fn known_error(&self) -> &'static str {
        "none: it is what errors are measured against"
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.materials.iter().any(|material| material.is_opaque() && !material.unlit))
    }

    fn plan(&self, light: &mut LightPlan<'_>) -> Result<(), ShadowError> {
        let name = light.light().name.clone();
        let casters: Vec<usize> = light.casters().map(|(index, _)| index).collect();
        let (posed, view) = (light.posed, light.view);
        let index = posed.lights.iter().position(|other| other.name == name).unwrap_or_default();
        // Everything a pixel depends on: the geometry, who casts, the light, the camera and the size.
        let poses: Vec<(u64, bool)> =
            posed.instances.iter().map(|i| (i.pose_key, i.shadow.receives)).collect();
        let worn = posed.instances.iter().flat_map(|instance| &instance.materials);
        let worn: Vec<String> = worn
            .map(|m| {
                format!("{:?}", (m.alpha_mode, m.base_color.w, m.base_color_texture, m.double_sided, m.unlit))
            })
            .collect();
        let seen_from = (format!("{:?}", view.camera), format!("{:?}", light.light()), view.size_px);
        let key = hash_of(("reference", poses, worn, &casters, seen_from));
        let factors = light.cache.get_or_compute("reference factors", key, || {
            let query = LightQuery { light: index, casters };
            let image = Reference::new(posed).render(&view.camera, view.size_px, &[query], &|_, _| {});
            let factor = image.lights.into_iter().next().map(|light| light.factor).unwrap_or_default();
            bytemuck::cast_slice(&factor).to_vec()
        });
        let reason = "traced on the CPU";
        let slot = light.buffer(&format!("reference of {name}"), BufferUsage::Storage, key, factors, reason);
        let target = light.multiply_visibility(Channels::One);
        let text = include_str!("technique.wgsl");
        let source = shadowgraph_shaders::compose(TYPE_NAME, text, &[])
            .map_err(|error| light.unsupported(error.to_string()))?;
        light.pass(Pass {
            name: format!("reference of {name}"),
            reason: "the exact answer, for looking at".into(),
            colors: vec![target],
            depth: None,
            draws: vec![Draw {
                name: "every pixel".into(),
                shader: Some(Shader {
                    name: TYPE_NAME.into(),
                    source: source.into(),
                    vertex: "fullscreen_vertex".into(),
                    fragment: Some("traced".into()),
                }),
                state: DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)]),
                geometry: Geometry::Procedural { vertices: 3, instances: 1 },
                bindings: vec![(0, Binding::Storage(slot))],
                scissor_px: None,
            }],
        });
        Ok(())
    }
}
