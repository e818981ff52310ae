//! The reference as a technique: pictures whose shadows are the exact answer.
//!
//! It plugs in like any other. Its plan traces the reference on the CPU and multiplies the result into the light's
//! visibility, so `--technique reference` shows what every other technique is compared with.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph_engine::plan::{BufferDesc, CompareFunction, DrawState, MULTIPLY, Shader};
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Binding, Channels, ColorTarget, Contribution, Draw, Geometry, Layers, LightContext, LightSize,
    MAX_ANGLE_DEG, MAX_LIGHT_SAMPLES, MAX_RADIUS_M, Options, Pass, PassList, ShadowError, ShadowTechnique,
    TechniqueEntry, Traits, hash_of,
};

use super::{LightQuery, Reference, Samples, SizedCasters};

/// Exact shadows, traced on the CPU for every pixel: seconds for a frame.
///
/// A light with a size has the visible share of `samples` of [`light_samples`](crate::light_samples) as its factor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct ReferenceShadow {
    /// The radius of point and spot lights, in metres; 0 for hard shadows.
    #[serde(rename = "radius")]
    #[schemars(range(min = 0.0, max = MAX_RADIUS_M))]
    pub radius_m: f64,
    /// Half the angle under which a directional light is seen, in degrees; 0 for hard shadows.
    #[serde(rename = "angle")]
    #[schemars(range(min = 0.0, max = MAX_ANGLE_DEG))]
    pub angle_deg: f64,
    /// Samples of a light that has a size.
    #[schemars(range(min = 1, max = MAX_LIGHT_SAMPLES))]
    pub samples: u32,
    /// On which transparent surfaces its shadows fall; each layer is traced by itself.
    pub self_shadow: OnTransparent,
}

/// On which transparent surfaces shadows fall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum OnTransparent {
    /// On none: they are drawn as if lit.
    #[default]
    None,
    /// On the nearest at each pixel.
    Partial,
    /// On all.
    Full,
}

impl Default for ReferenceShadow {
    fn default() -> Self {
        Self { radius_m: 0.0, angle_deg: 0.0, samples: 64, self_shadow: OnTransparent::None }
    }
}

impl Options for ReferenceShadow {
    const TYPE_NAME: &'static str = "Reference";
}

impl ReferenceShadow {
    /// How a catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry::of::<Self>(
        "reference",
        "exact shadows, hard or of a light with a size, traced on the CPU",
        &[],
    );
}

impl ReferenceShadow {
    fn light_size(&self) -> LightSize {
        LightSize::new(self.radius_m, self.angle_deg)
    }
}

impl ShadowTechnique for ReferenceShadow {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        let receiver_layers = match self.self_shadow {
            OnTransparent::None => Layers::OpaqueOnly,
            OnTransparent::Partial => Layers::First,
            OnTransparent::Full => Layers::All,
        };
        Traits {
            known_error: "none: it is what errors are measured against",
            light_size: self.light_size(),
            light_samples: Some(self.samples),
            casts_transparent: true,
            receiver_layers,
            ..Traits::default()
        }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.materials.iter().any(|material| !material.unlit))
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let name = light.light().name.clone();
        let casters: Vec<usize> = light.casters().map(|(index, _)| index).collect();
        let (snapshot, view) = (light.snapshot, light.view);
        let index = snapshot.lights.iter().position(|other| other.name == name).unwrap_or_default();
        // Everything a pixel depends on: the geometry, who casts, the light, the camera and the size.
        let poses: Vec<(u64, bool)> =
            snapshot.instances.iter().map(|i| (i.pose_key, i.shadow.receives)).collect();
        let worn = snapshot.instances.iter().flat_map(|instance| &instance.materials);
        let worn: Vec<String> = worn
            .map(|m| {
                let color = (m.base_color, m.base_color_texture, m.transmission);
                format!("{:?}", (m.alpha_mode, color, m.double_sided, m.unlit))
            })
            .collect();
        let seen_from = (format!("{:?}", view.camera), format!("{:?}", light.light()), view.size_px);
        let layer = light.layer();
        let key = hash_of((
            "reference",
            poses,
            worn,
            &casters,
            seen_from,
            format!("{self:?}"),
            layer,
            light.is_beside_size(),
        ));
        let transparent =
            |index: &&usize| snapshot.instances[**index].materials.iter().any(|m| m.is_transparent());
        let transparent: Vec<usize> = casters.iter().filter(transparent).copied().collect();
        let factors = light.cache.get_or_compute("reference factors", key, || {
            let (size, samples) = (self.light_size(), Samples::Same(self.samples));
            let query = LightQuery {
                light: index,
                sized: vec![SizedCasters { casters, transparent, size, samples }],
                beside_size: light.is_beside_size(),
                ..LightQuery::default()
            };
            let (reference, camera, size_px) = (Reference::new(snapshot), &view.camera, view.size_px);
            let image = match layer {
                None => reference.render(camera, size_px, &[query], &|_, _| {}),
                Some(layer) => reference.render_layer(camera, size_px, &[query], layer),
            };
            let factor = image.lights.into_iter().next().map(|light| light.factor).unwrap_or_default();
            // Where nothing is hit, nothing is shaded.
            let factor: Vec<f32> = factor.into_iter().map(|f| if f.is_nan() { 1.0 } else { f }).collect();
            bytemuck::cast_slice(&factor).to_vec()
        });
        // Red, green and blue only where transparent surfaces cast.
        let colored = factors.len() > view.size_px[0] as usize * view.size_px[1] as usize * 4;
        let reason = "traced on the CPU";
        let traced = format!("reference of {name}");
        let slot = out.buffer(BufferDesc::storage(&traced, key, factors, reason));
        let (channels, flags): (_, &[&str]) =
            if colored { (Channels::Rgb, &["COLORED"]) } else { (Channels::One, &[]) };
        let text = include_str!("technique.wgsl");
        let shader = Shader::written(Self::TYPE_NAME, text, flags, "fullscreen_vertex", Some("traced"))?;
        let state = DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)]);
        let draw = Draw::new("every pixel", Geometry::fullscreen(shader), state);
        out.pass(Pass {
            name: traced,
            reason: "the exact answer, for looking at".into(),
            colors: vec![ColorTarget::VISIBILITY],
            depth: None,
            draws: vec![draw.reading(vec![(0, Binding::Storage(slot))])],
        });
        // Samples on the other side of the surface than the eye are dark; those of a point are the engine's business.
        let own_shadow = self.light_size().is_wide(light.light().position);
        Ok(Contribution { own_shadow, ..Contribution::visibility(channels) })
    }
}
