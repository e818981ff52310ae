//! The options of `SoftShadow`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph_engine::shadow::{
    Clash, MAX_ANGLE_DEG, MAX_LIGHT_SAMPLES, MAX_RADIUS_M, Options, Setting, TechniqueEntry,
};

/// Where shadows are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum PlanarMode {
    /// In a texture on the receiver, which is kept until light, caster or receiver move.
    #[default]
    Texture,
    /// In the picture, at its resolution.
    Direct,
}

/// The most points that may stand for a light.
pub const MAX_SAMPLES: u32 = MAX_LIGHT_SAMPLES;
/// The longest side of a receiver's texture, in texels.
pub const MAX_RESOLUTION: u32 = 8192;

/// Soft shadows on planes: the options of a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct SoftShadow {
    /// How many points stand for a light that has a size.
    #[schemars(range(min = 1, max = MAX_SAMPLES))]
    pub samples: u32,
    /// The radius of point and spot lights, in metres; 0 for hard shadows.
    #[serde(rename = "radius")]
    #[schemars(range(min = 0.0, max = MAX_RADIUS_M))]
    pub radius_m: f64,
    /// Half the angle under which a directional light is seen, in degrees; 0 for hard shadows.
    #[serde(rename = "angle")]
    #[schemars(range(min = 0.0, max = MAX_ANGLE_DEG))]
    pub angle_deg: f64,
    /// Where shadows are drawn: in a texture on the receiver that is kept until something moves, or in the picture.
    pub mode: PlanarMode,
    /// The longer side of a receiver's texture in texels, at most: it has about four along each pixel that the view has there. With
    /// `mode` `texture` only.
    #[schemars(range(min = 1, max = MAX_RESOLUTION))]
    pub resolution: u32,
    /// How dark shadows are in pictures.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub weight: f64,
    /// What shadows look like in pictures: the linear red, green and blue share of the light that is left where none arrives.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color: [f64; 3],
}

impl Default for SoftShadow {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What reports and tests try beside the default.
const SETTINGS: &[Setting] = &[
    Setting {
        name: "direct 16",
        why: "in the picture: crisp from nearby, and drawn in every frame; steps of a sixteenth",
        params: || SoftShadow::DIRECT.to_params(),
    },
    Setting {
        name: "direct 64",
        why: "four times the points, and about a third of the error",
        params: || SoftShadow { samples: 64, ..SoftShadow::DIRECT }.to_params(),
    },
    Setting {
        name: "direct 256",
        why: "what a still picture can afford",
        params: || SoftShadow { samples: 256, ..SoftShadow::DIRECT }.to_params(),
    },
];

impl SoftShadow {
    /// The default, but drawn in the picture.
    pub const DIRECT: Self = Self { mode: PlanarMode::Direct, ..Self::DEFAULT };

    /// While nothing moves, a texture costs a fraction of shadows that are drawn in the picture, whatever its samples. Made anew in
    /// every frame it costs more than they do, and by its samples: so there are few.
    const DEFAULT: Self = Self {
        samples: 16,
        radius_m: 0.1,
        angle_deg: 0.27,
        mode: PlanarMode::Texture,
        resolution: 1024,
        weight: 1.0,
        color: [0.0; 3],
    };

    /// Its entry in a catalog.
    pub const ENTRY: TechniqueEntry = TechniqueEntry::of::<Self>(
        "planar",
        "soft shadows on planes, flattened from each point of a light",
        SETTINGS,
    );
}

impl Options for SoftShadow {
    const TYPE_NAME: &'static str = "SoftShadow";

    fn check(&self) -> Vec<Clash> {
        match self.mode {
            PlanarMode::Direct => {
                vec![Clash::Idle { option: "resolution", accepted: "with mode=texture only" }]
            }
            PlanarMode::Texture => Vec::new(),
        }
    }
}
