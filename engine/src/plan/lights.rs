//! What a plan says of each light: where its factor is, and what it takes from the picture.

use super::SlotId;

/// Where the shading pass finds the factor of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FactorAt {
    /// Nothing shadows the light: 1 everywhere.
    Lit,
    /// Dark where the stencil is not zero.
    Counts,
    /// Dark where this bit of the light mask is set.
    MaskBit(u32),
    /// The value in this layer of the visibility array.
    Visibility(u32),
    /// 1 while shading; the finished picture is darkened where the counts of all such lights are not zero.
    Darkening,
}

/// What was planned for one light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightPlanned {
    /// The light's name.
    pub name: String,
    /// Where its factor ends up; the first of its factors when several nodes are weighted apart.
    pub factor: FactorAt,
    /// What the picture loses of the light where that factor is 0, for red, green and blue: weight · (1 − colour),
    /// from 0 to 1. [`FULL_DARKENING`] unless a node says otherwise.
    pub max_darkening: [f32; 3],
    /// Factors of nodes that are weighted apart: the picture is shaded with the product of all.
    pub more_factors: Vec<FactorPart>,
    /// The techniques that shadow it, by type name and what options are not at their default; empty
    /// without any.
    pub techniques: Vec<String>,
    /// Instances whose terminator follows their shading normals.
    pub smooth_terminators: Vec<u32>,
    /// Whether its factor holds the receiver's own shadow too: surfaces turned away from the light's centre are as
    /// dark as the factor says, not dark by themselves.
    pub own_shadow: bool,
    /// Index of the factor image slot, when one was asked for.
    pub factor_image: Option<SlotId>,
    /// The slots with its factors on transparent layers, of those that were asked for: nearest first.
    pub layer_factor_images: Vec<SlotId>,
}

/// The `max_darkening` of a black shadow, which takes all of the light.
pub const FULL_DARKENING: [f32; 3] = [1.0; 3];

/// The factor of nodes that are weighted apart from others of the same light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FactorPart {
    /// Where it ends up.
    pub at: FactorAt,
    /// What the picture loses of the light where it is 0; see [`LightPlanned::max_darkening`].
    pub max_darkening: [f32; 3],
}

impl FactorAt {
    /// `factor_kind` and `factor_index` of common/lights.wgsl.
    pub(crate) fn kind_and_index(self) -> [u32; 2] {
        match self {
            Self::Lit | Self::Darkening => [0, 0],
            Self::Counts => [1, 0],
            Self::MaskBit(bit) => [2, bit],
            Self::Visibility(layer) => [3, layer],
        }
    }
}

impl LightPlanned {
    /// All its factors: the first and those weighted apart.
    pub fn factors(&self) -> impl Iterator<Item = FactorPart> {
        let first = FactorPart { at: self.factor, max_darkening: self.max_darkening };
        std::iter::once(first).chain(self.more_factors.iter().copied())
    }
}

/// What the picture loses of a light in a shadow of this weight and linear colour, for red, green and blue: weight ·
/// (1 − colour). Both are clamped to 0 … 1; NaN gives full darkening.
pub fn max_darkening(weight: f64, color: [f64; 3]) -> [f32; 3] {
    let share = |value: f64, otherwise: f64| if value.is_nan() { otherwise } else { value.clamp(0.0, 1.0) };
    color.map(|channel| (share(weight, 1.0) * (1.0 - share(channel, 0.0))) as f32)
}
