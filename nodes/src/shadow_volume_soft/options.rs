//! The options of `ShadowVolumeSoft`: their values, their names in scenes, and how they are read and saved.

use std::sync::Arc;

use shadowgraph_engine::scene::{ParamValue, Params, ShadowNode};
use shadowgraph_engine::shadow::{LightSize, OptionError, OptionReader, Setting, TechniqueEntry};

use crate::shadow_volume_hard::options::{CLOSURES, COUNTERS, DEPTH_TESTS, GEOMETRIES, name_of};
use crate::{Closure, CounterKind, DepthTest, GeometryMode, ShadowVolumeHard};

/// How the visible part of a light is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Quality {
    /// Sample by sample: each of the light's samples is blocked or not, exactly.
    #[default]
    Sampled,
    /// By areas, over the silhouette that each point sees.
    PerReceiver,
    /// By areas, over the silhouette that the light's centre sees, in wedges about a hard shadow.
    Wedge,
}

/// What the factor is applied to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Apply {
    /// To the light, at every pixel.
    #[default]
    PerPixel,
    /// To the finished picture, which is darkened by it.
    Darken,
}

/// The node and its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowVolumeSoft {
    /// The radius of point and spot lights, in metres; 0 for hard shadows.
    pub radius_m: f64,
    /// Half the angle under which a directional light is seen, in degrees; 0 for hard shadows.
    pub half_angle_deg: f64,
    /// How much of the light, or of the picture, a shadow takes away, from 0 to 1. Factors stay what they are.
    pub weight: f64,
    /// Which triangles cast.
    pub geometry: GeometryMode,
    /// How open casters are closed.
    pub closure: Closure,
    /// From where crossings are counted, wherever volumes are drawn: for lights without size, and by `wedge`.
    pub depth_test: DepthTest,
    /// Where counts are kept, wherever volumes are drawn.
    pub counter: CounterKind,
    /// How the visible part of the light is found.
    pub quality: Quality,
    /// Samples of a light, for `sampled`.
    pub samples: u32,
    /// What the factor is applied to.
    pub apply: Apply,
}

impl Default for ShadowVolumeSoft {
    fn default() -> Self {
        Self {
            radius_m: 0.1,
            half_angle_deg: 0.27,
            weight: 1.0,
            geometry: GeometryMode::default(),
            closure: Closure::default(),
            depth_test: DepthTest::default(),
            counter: CounterKind::default(),
            quality: Quality::default(),
            samples: 64,
            apply: Apply::default(),
        }
    }
}

/// The type name scenes use.
pub(super) const TYPE_NAME: &str = "ShadowVolumeSoft";
const QUALITIES: &[(&str, Quality)] =
    &[("sampled", Quality::Sampled), ("perReceiver", Quality::PerReceiver), ("wedge", Quality::Wedge)];
const APPLIES: &[(&str, Apply)] = &[("perPixel", Apply::PerPixel), ("darken", Apply::Darken)];

/// The largest light, in metres: as far away as anything may be.
const LARGEST_RADIUS_M: f64 = 1e15;
/// The widest directional light: beyond, it would reach around the receiver.
const WIDEST_HALF_ANGLE_DEG: f64 = 60.0;
/// Fewer samples than that are seen one by one, more take more memory at every pixel than shaders have.
const SAMPLES: std::ops::RangeInclusive<u32> = 16..=256;

/// What reports and tests try beside the default.
const SETTINGS: &[Setting] = &[
    Setting {
        name: "per-receiver",
        why: "areas instead of samples: smooth, and exact before one convex caster",
        params: || {
            ShadowVolumeSoft { quality: Quality::PerReceiver, ..ShadowVolumeSoft::default() }.to_params()
        },
    },
    Setting {
        name: "wedge",
        why: "penumbra wedges as of 2003, the baseline",
        params: || ShadowVolumeSoft { quality: Quality::Wedge, ..ShadowVolumeSoft::default() }.to_params(),
    },
    Setting {
        name: "samples 16",
        why: "a quarter of the samples: faster, and steps of a sixteenth",
        params: || ShadowVolumeSoft { samples: 16, ..ShadowVolumeSoft::default() }.to_params(),
    },
    Setting {
        name: "samples 256",
        why: "four times the samples, for wide penumbrae",
        params: || ShadowVolumeSoft { samples: 256, ..ShadowVolumeSoft::default() }.to_params(),
    },
];

impl ShadowVolumeSoft {
    /// How the catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry {
        type_name: TYPE_NAME,
        short_name: "soft",
        summary: "soft shadows of any triangles from lights with a size",
        from_params: |params| Ok(Arc::new(Self::from_params(params)?)),
        settings: SETTINGS,
    };

    /// Reads the options.
    ///
    /// # Errors
    /// [`OptionError`] names the option and what is accepted.
    pub fn from_params(params: &Params) -> Result<Self, OptionError> {
        let mut options = OptionReader::new(TYPE_NAME, params);
        let default = Self::default();
        let node = Self {
            radius_m: options.number("radius", default.radius_m, 0.0, LARGEST_RADIUS_M)?,
            half_angle_deg: options.number("angle", default.half_angle_deg, 0.0, WIDEST_HALF_ANGLE_DEG)?,
            weight: options.number("weight", default.weight, 0.0, 1.0)?,
            geometry: options.choice("geometry", GEOMETRIES)?,
            closure: options.choice("closure", CLOSURES)?,
            depth_test: options.choice("depthTest", DEPTH_TESTS)?,
            counter: options.choice("counter", COUNTERS)?,
            quality: options.choice("quality", QUALITIES)?,
            samples: {
                let (least, most) = (f64::from(*SAMPLES.start()), f64::from(*SAMPLES.end()));
                let samples = options.number("samples", f64::from(default.samples), least, most)?;
                if samples.fract() != 0.0 {
                    return Err(options.conflict("samples", "a whole number from 16 to 256"));
                }
                samples as u32
            },
            apply: options.choice("apply", APPLIES)?,
        };
        options.finish()?;
        Ok(node)
    }

    /// All options with their values.
    pub(super) fn to_params(self) -> Params {
        Params::from([
            ("radius".into(), ParamValue::Number(self.radius_m)),
            ("angle".into(), ParamValue::Number(self.half_angle_deg)),
            ("weight".into(), ParamValue::Number(self.weight)),
            ("geometry".into(), name_of(GEOMETRIES, &self.geometry)),
            ("closure".into(), name_of(CLOSURES, &self.closure)),
            ("depthTest".into(), name_of(DEPTH_TESTS, &self.depth_test)),
            ("counter".into(), name_of(COUNTERS, &self.counter)),
            ("quality".into(), name_of(QUALITIES, &self.quality)),
            ("samples".into(), ParamValue::Number(f64::from(self.samples))),
            ("apply".into(), name_of(APPLIES, &self.apply)),
        ])
    }

    /// How large its lights are.
    pub(super) fn size(&self) -> LightSize {
        LightSize { radius_m: self.radius_m, half_angle_rad: self.half_angle_deg.to_radians() }
    }

    /// The same options for a light without size.
    pub(super) fn hard(&self) -> ShadowVolumeHard {
        ShadowVolumeHard {
            depth_test: self.depth_test,
            geometry: self.geometry,
            closure: self.closure,
            counter: self.counter,
            ..ShadowVolumeHard::default()
        }
    }
}

impl From<ShadowVolumeSoft> for ShadowNode {
    fn from(node: ShadowVolumeSoft) -> Self {
        Self { technique: TYPE_NAME.into(), params: node.to_params(), ..Self::default() }
    }
}
