//! The options of `ShadowMap`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph_engine::shadow::{Options, Setting, TechniqueEntry};

use crate::common::shadow_maps::Biases;

/// Which triangles of casters the light sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Faces {
    /// All; beside biases that are set, of a solid with light and eye outside those that are turned away from the light.
    #[default]
    Auto,
    /// Those whose front is towards the light.
    Front,
    /// Those that are turned away from it: an open caster then casts nothing where it faces the light.
    Back,
    /// All.
    Both,
}

/// The most texels along a side of a map.
pub const MAX_MAP_RESOLUTION: u32 = 8192;
/// And the fewest: a window needs room for what is looked up beside a point.
pub const MIN_MAP_RESOLUTION: u32 = 32;
/// The largest bias, in metres or texels.
pub const MAX_BIAS: f64 = 1000.0;

/// The node and its options.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct ShadowMap {
    /// Texels along a side of each map.
    #[schemars(range(min = MIN_MAP_RESOLUTION, max = MAX_MAP_RESOLUTION))]
    pub resolution: u32,
    /// Which triangles are drawn into the map.
    pub faces: Faces,
    /// How many texels along a side are compared for a point, to take the mean; 1 for hard edges.
    #[schemars(range(min = 1, max = 7))]
    pub pcf: u32,
    /// How much nearer to the light receivers are taken to be, in metres. Where this or another bias is set, those that are not are
    /// 0; where none is, the planes of receiver and caster are asked instead, which needs none.
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
    /// How many maps a directional light has, one behind the other as the eye sees; other lights have one for each direction in
    /// which something casts.
    #[schemars(range(min = 1, max = 8))]
    pub cascades: u32,
}

impl Default for ShadowMap {
    fn default() -> Self {
        Self {
            resolution: 2048,
            faces: Faces::default(),
            pcf: 3,
            constant_bias_m: None,
            slope_bias_texels: None,
            normal_bias_texels: None,
            cascades: 1,
        }
    }
}

impl ShadowMap {
    /// The biases, if one is set.
    pub(super) fn biases(&self) -> Option<Biases> {
        biases(self.constant_bias_m, self.slope_bias_texels, self.normal_bias_texels)
    }
}

/// The biases, if one is set.
pub(crate) fn biases(constant: Option<f64>, slope: Option<f64>, normal: Option<f64>) -> Option<Biases> {
    let set = constant.or(slope).or(normal).is_some();
    set.then(|| Biases {
        constant_m: constant.unwrap_or_default(),
        slope_texels: slope.unwrap_or_default(),
        normal_texels: normal.unwrap_or_default(),
    })
}

/// What reports and tests try beside the default.
const SETTINGS: &[Setting] = &[
    Setting {
        name: "pcf 1",
        why: "hard edges: one comparison at every pixel",
        params: || ShadowMap { pcf: 1, ..ShadowMap::default() }.to_params(),
    },
    Setting {
        name: "512",
        why: "a sixteenth of the texels",
        params: || ShadowMap { resolution: 512, ..ShadowMap::default() }.to_params(),
    },
    Setting {
        name: "cascades 3",
        why: "three smaller maps for a directional light, the nearer the finer",
        params: || ShadowMap { cascades: 3, resolution: 1024, ..ShadowMap::default() }.to_params(),
    },
    Setting {
        name: "biased",
        why: "the textbook's way: back faces of solids, and biases that were set by hand",
        params: || {
            let (slope, normal) = (Some(2.0), Some(1.0));
            ShadowMap { slope_bias_texels: slope, normal_bias_texels: normal, ..ShadowMap::default() }
                .to_params()
        },
    },
];

impl ShadowMap {
    /// How the catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry::of::<Self>(
        "map",
        "hard shadows looked up in maps of what the light sees, averaged at their edges",
        SETTINGS,
    );
}

impl Options for ShadowMap {
    const TYPE_NAME: &'static str = "ShadowMap";
}
