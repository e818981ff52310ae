//! The options of `ShadowVolumeSoft`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph_engine::shadow::{
    Clash, LightSize, MAX_ANGLE_DEG, MAX_RADIUS_M, Options, Setting, TechniqueEntry,
};

use crate::ShadowVolumeHard;
use crate::common::volume_options::{Closure, CounterKind, DepthTest, GeometryMode};

/// How the visible part of a light is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Quality {
    /// Sample by sample: each of the light's samples is blocked or not, exactly.
    #[default]
    Sampled,
    /// By areas, over the silhouette that each point sees.
    PerReceiver,
    /// By areas, over the silhouette that the light's centre sees, in wedges about a hard shadow.
    Wedge,
}

/// What the factor darkens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Apply {
    /// To the light, at every pixel.
    #[default]
    PerPixel,
    /// To the finished picture, which is darkened by it.
    Darken,
}

/// Soft shadows of lights with a size, on any surface: the options of a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct ShadowVolumeSoft {
    /// The radius of point and spot lights, in metres; 0 for hard shadows.
    #[serde(rename = "radius")]
    #[schemars(range(min = 0.0, max = MAX_RADIUS_M))]
    pub radius_m: f64,
    /// Half the angle under which a directional light is seen, in degrees; 0 for hard shadows.
    #[serde(rename = "angle")]
    #[schemars(range(min = 0.0, max = MAX_ANGLE_DEG))]
    pub angle_deg: f64,
    /// How the visible part of the light is found.
    pub quality: Quality,
    /// Samples of a light, with `quality` `sampled` only.
    #[schemars(range(min = LEAST_SAMPLES, max = MOST_SAMPLES))]
    pub samples: u32,
    /// How much of the light, or of the picture, a shadow takes away. Factors stay what they are.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub weight: f64,
    /// What the factor is applied to: to the light, or to the finished picture.
    pub apply: Apply,
    /// Which triangles cast: of a solid those that face the light, refused for what is no solid; or all.
    pub geometry: GeometryMode,
    /// How open casters are closed before they cast, as `ShadowVolumeHard` does.
    pub closure: Closure,
    /// From where crossings are counted, as `ShadowVolumeHard` does; where volumes are drawn: with `quality` `wedge`, and for
    /// lights without size.
    pub depth_test: DepthTest,
    /// Where counts are kept, as `ShadowVolumeHard` does; for lights without size only.
    pub counter: CounterKind,
}

impl Default for ShadowVolumeSoft {
    fn default() -> Self {
        Self {
            radius_m: 0.1,
            angle_deg: 0.27,
            quality: Quality::default(),
            samples: 64,
            weight: 1.0,
            apply: Apply::default(),
            geometry: GeometryMode::default(),
            closure: Closure::default(),
            depth_test: DepthTest::default(),
            counter: CounterKind::default(),
        }
    }
}

/// Fewer samples than that are seen one by one.
const LEAST_SAMPLES: u32 = 16;
/// More take more memory at every pixel than shaders have.
const MOST_SAMPLES: u32 = 256;

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
    /// Its entry in a catalog.
    pub const ENTRY: TechniqueEntry =
        TechniqueEntry::of::<Self>("soft", "soft shadows of any triangles from lights with a size", SETTINGS);

    /// How large its lights are.
    pub(super) fn size(&self) -> LightSize {
        LightSize::new(self.radius_m, self.angle_deg)
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

impl Options for ShadowVolumeSoft {
    const TYPE_NAME: &'static str = "ShadowVolumeSoft";

    fn check(&self) -> Vec<Clash> {
        let mut clashes = Vec::new();
        let mut idle = |option, accepted| clashes.push(Clash::Idle { option, accepted });
        let has_points = self.radius_m == 0.0 || self.angle_deg == 0.0;
        if self.quality != Quality::Sampled {
            idle("samples", "with quality=sampled only");
        }
        if self.quality != Quality::Wedge && !has_points {
            idle("depthTest", "with quality=wedge, or with a radius or an angle of 0");
        }
        if !has_points {
            idle("counter", "with a radius or an angle of 0 only");
        }
        clashes
    }
}
