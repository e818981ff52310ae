//! The options of `SoftShadow`: their values, their names in scenes, and how they are read and saved.

use std::sync::Arc;

use shadowgraph_engine::scene::{ParamValue, Params, ShadowNode};
use shadowgraph_engine::shadow::{MAX_LIGHT_SAMPLES, OptionError, OptionReader, Setting, TechniqueEntry};

/// Where shadows are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PlanarMode {
    /// In the picture, at its resolution.
    #[default]
    Direct,
    /// In a texture on the receiver, which is kept until light, caster or receiver move.
    Texture,
}

/// The node and its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoftShadow {
    /// How many points stand for a light that has a size, from 1 to [`MAX_SAMPLES`].
    pub samples: u32,
    /// The radius of point and spot lights, in metres.
    pub radius_m: f64,
    /// Half the angle under which directional lights are seen, in degrees, below 90.
    pub angle_deg: f64,
    /// Where shadows are drawn.
    pub mode: PlanarMode,
    /// The longer side of a receiver's texture in texels, from 1 to [`MAX_RESOLUTION`].
    pub resolution: u32,
    /// How dark shadows are in pictures, from 0 to 1.
    pub weight: f64,
    /// What shadows look like in pictures: linear red, green and blue from 0 to 1, the share of the light that is left
    /// where none arrives.
    pub color: [f64; 3],
}

impl Default for SoftShadow {
    fn default() -> Self {
        Self {
            samples: 16,
            radius_m: 0.1,
            angle_deg: 0.27,
            mode: PlanarMode::Direct,
            resolution: 1024,
            weight: 1.0,
            color: [0.0; 3],
        }
    }
}

/// The most points that may stand for a light.
pub const MAX_SAMPLES: u32 = MAX_LIGHT_SAMPLES;
/// The longest side of a receiver's texture, in texels.
pub const MAX_RESOLUTION: u32 = 8192;

/// The type name scenes use.
pub(super) const TYPE_NAME: &str = "SoftShadow";
const MODES: &[(&str, PlanarMode)] = &[("direct", PlanarMode::Direct), ("texture", PlanarMode::Texture)];

/// What reports and tests try beside the default.
const SETTINGS: &[Setting] = &[
    Setting {
        name: "64 samples",
        why: "four times the points, and about a third of the error",
        params: || SoftShadow { samples: 64, ..SoftShadow::default() }.to_params(),
    },
    Setting {
        name: "256 samples",
        why: "what a still picture can afford",
        params: || SoftShadow { samples: 256, ..SoftShadow::default() }.to_params(),
    },
    Setting {
        name: "texture",
        why: "drawn once, on a texture that each receiver wears until something moves",
        params: || SoftShadow { mode: PlanarMode::Texture, ..SoftShadow::default() }.to_params(),
    },
];

impl SoftShadow {
    /// How the catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry {
        type_name: TYPE_NAME,
        short_name: "planar",
        summary: "soft shadows on planes, flattened from each point of a light",
        from_params: |params| Ok(Arc::new(Self::from_params(params)?)),
        settings: SETTINGS,
    };

    /// Reads the options.
    ///
    /// # Errors
    /// [`OptionError`] names the option and what is accepted.
    pub fn from_params(params: &Params) -> Result<Self, OptionError> {
        let default = Self::default();
        let mut options = OptionReader::new(TYPE_NAME, params);
        let node = Self {
            samples: whole(&mut options, "samples", default.samples, MAX_SAMPLES)?,
            radius_m: options.number("radius", default.radius_m, 0.0, 1e9)?,
            angle_deg: options.number("angle", default.angle_deg, 0.0, 89.0)?,
            mode: options.choice("mode", MODES)?,
            resolution: whole(&mut options, "resolution", default.resolution, MAX_RESOLUTION)?,
            weight: options.number("weight", default.weight, 0.0, 1.0)?,
            color: color(&mut options, params)?,
        };
        options.finish()?;
        Ok(node)
    }

    /// All options with their values.
    pub(super) fn to_params(self) -> Params {
        let mode = MODES.iter().find(|(_, mode)| *mode == self.mode).map_or("", |(name, _)| name);
        let number = |number: f64| ParamValue::Number(number);
        Params::from([
            ("samples".into(), number(self.samples.into())),
            ("radius".into(), number(self.radius_m)),
            ("angle".into(), number(self.angle_deg)),
            ("mode".into(), ParamValue::Text(mode.into())),
            ("resolution".into(), number(self.resolution.into())),
            ("weight".into(), number(self.weight)),
            ("color".into(), ParamValue::Numbers(self.color.to_vec())),
        ])
    }
}

/// A whole number from 1 to `max`.
fn whole(
    options: &mut OptionReader<'_>,
    option: &'static str,
    default: u32,
    max: u32,
) -> Result<u32, OptionError> {
    let number = options.number(option, default.into(), 1.0, max.into())?;
    if number.fract() != 0.0 {
        return Err(options.conflict(option, &format!("a whole number from 1 to {max}")));
    }
    Ok(number as u32)
}

/// Red, green and blue: three numbers from 0 to 1, `[r, g, b]` in glTF and `r/g/b` on the command line.
fn color(options: &mut OptionReader<'_>, params: &Params) -> Result<[f64; 3], OptionError> {
    options.known("color");
    match params.get("color") {
        None => Ok(SoftShadow::default().color),
        Some(ParamValue::Numbers(numbers)) => match numbers[..] {
            [r, g, b] if [r, g, b].iter().all(|channel| (0.0..=1.0).contains(channel)) => Ok([r, g, b]),
            _ => Err(options.conflict("color", ACCEPTED_COLORS)),
        },
        Some(_) => Err(options.conflict("color", ACCEPTED_COLORS)),
    }
}

const ACCEPTED_COLORS: &str = "red, green and blue from 0 to 1: [r, g, b], or r/g/b on the command line";

impl From<SoftShadow> for ShadowNode {
    fn from(node: SoftShadow) -> Self {
        Self { technique: TYPE_NAME.into(), params: node.to_params(), ..Self::default() }
    }
}
