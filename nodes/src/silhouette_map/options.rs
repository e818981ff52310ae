//! The options of `SilhouetteMap`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph_engine::plan::TextureFormat;
use shadowgraph_engine::shadow::{Options, Setting, TechniqueEntry};

use crate::common::shadow_maps::Biases;
use crate::shadow_map::{MAX_BIAS, MAX_MAP_RESOLUTION, MIN_MAP_RESOLUTION, biases};

/// How a silhouette's point is stored in its texel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum PointFormat {
    /// Two bytes: it is off by up to 1/512 of a texel along each side.
    #[default]
    TwoBytes,
    /// One byte, four bits an offset: off by up to 1/32 of a texel.
    OneByte,
}

impl PointFormat {
    /// The texels of a map of points.
    pub(super) fn texture(self) -> TextureFormat {
        match self {
            Self::TwoBytes => TextureFormat::Rg8Unorm,
            Self::OneByte => TextureFormat::R8Unorm,
        }
    }

    /// What a texel holds that no silhouette passes: the middle, as nearly as it can.
    pub(super) fn middle(self) -> [f64; 4] {
        match self {
            Self::TwoBytes => [128.0 / 255.0; 4],
            Self::OneByte => [f64::from(8 * 16 + 8) / 255.0; 4],
        }
    }
}

/// What is looked up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Show {
    /// Shadows.
    #[default]
    Shadows,
    /// No shadows, but the points of silhouettes, as red discs where the light throws them: to look at the map.
    Points,
}

/// The node and its options.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct SilhouetteMap {
    /// Texels along a side of each map.
    #[schemars(range(min = MIN_MAP_RESOLUTION, max = MAX_MAP_RESOLUTION))]
    pub resolution: u32,
    /// How the points of silhouettes are stored.
    pub point_format: PointFormat,
    /// What is drawn: shadows, or to look at the map the points that it holds (004 Fig. 9).
    pub show: Show,
    /// How much nearer to the light receivers are taken to be, in metres, as `ShadowMap` has it.
    #[serde(rename = "constantBias", skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_BIAS))]
    pub constant_bias_m: Option<f64>,
    /// The same, in texels times the tangent of the angle at which the light meets the surface.
    #[serde(rename = "slopeBias", skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_BIAS))]
    pub slope_bias_texels: Option<f64>,
    /// How far receivers are moved along their normals, in texels.
    #[serde(rename = "normalBias", skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = MAX_BIAS))]
    pub normal_bias_texels: Option<f64>,
}

impl Default for SilhouetteMap {
    fn default() -> Self {
        Self {
            resolution: 1024,
            point_format: PointFormat::default(),
            show: Show::default(),
            constant_bias_m: None,
            slope_bias_texels: None,
            normal_bias_texels: None,
        }
    }
}

impl SilhouetteMap {
    /// The biases, if one is set.
    pub(super) fn biases(&self) -> Option<Biases> {
        biases(self.constant_bias_m, self.slope_bias_texels, self.normal_bias_texels)
    }
}

/// What reports and tests try beside the default.
const SETTINGS: &[Setting] = &[
    Setting {
        name: "256",
        why: "a sixteenth of the texels",
        params: || SilhouetteMap { resolution: 256, ..SilhouetteMap::default() }.to_params(),
    },
    Setting {
        name: "one byte",
        why: "points in one byte, as the paper would have had them",
        params: || {
            SilhouetteMap { point_format: PointFormat::OneByte, ..SilhouetteMap::default() }.to_params()
        },
    },
];

impl SilhouetteMap {
    /// How the catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry::of::<Self>(
        "silhouette",
        "hard shadows looked up in maps that know where outlines pass their texels",
        SETTINGS,
    );
}

impl Options for SilhouetteMap {
    const TYPE_NAME: &'static str = "SilhouetteMap";
}
