//! What a technique hands back for one light.

use wgpu::TextureFormat;

/// The channels of a light's visibility.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channels {
    /// One value for all colours.
    One,
    /// Red, green and blue apart.
    Rgb,
}

impl Channels {
    /// The texture format of a visibility with these channels.
    pub fn format(self) -> TextureFormat {
        match self {
            Self::One => TextureFormat::R16Float,
            Self::Rgb => TextureFormat::Rgba16Float,
        }
    }
}

/// What the passes of one node leave for one light, and how the picture applies it. The default leaves nothing: the
/// light stays unshadowed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contribution {
    /// Where the passes count in the stencil: an upper bound on what they add to the final count of any pixel.
    pub counts_bound: Option<u32>,
    /// Where the passes multiply the light's visibility: its channels.
    pub visibility: Option<Channels>,
    /// Whether the visibility holds the receiver's own shadow too: the part of the light that lies below the
    /// surface's horizon. The engine then darkens no surface for being turned away from the light's centre (in
    /// pictures, beyond the cosine of its normal), whatever other techniques serve the light: its factor is the
    /// product of all contributions, and only this one has the horizon in it.
    pub own_shadow: bool,
    /// Instances whose terminator for this light follows their shading normals: the technique leaves surfaces that
    /// are turned away from the light undecided. In pictures only; in factors they are dark. Only the first
    /// [`MAX_SMOOTH_LIGHTS`](super::MAX_SMOOTH_LIGHTS) lights of a scene can have any.
    pub smooth_terminators: Vec<usize>,
    /// How the picture applies the factor.
    pub apply: Apply,
}

/// How a picture applies the factor of a node. Weights and linear colours are clamped to 0 … 1. Factors that are
/// asked for are never weighted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Apply {
    /// The light is multiplied by 1 − weight · (1 − factor) · (1 − colour), for each node that serves it. (With four samples
    /// a pixel, where shadow edges of two nodes of different weights cross within a pixel, it gets the product of their
    /// means.)
    Light {
        /// How much of the light a shadow takes.
        weight: f64,
        /// What is left, in linear red, green and blue.
        color: [f64; 3],
    },
    /// The light is shaded as if unshadowed. Its counts are added to those of all other lights whose nodes say the
    /// same, and the finished picture is darkened once where the sum is not zero. (Counts are never negative, so they
    /// do not cancel.) All such nodes must have one weight, and may only count.
    DarkenOnce {
        /// How much of the picture's light is taken away.
        weight: f64,
    },
    /// The light is shaded as if unshadowed, and the finished picture is multiplied by 1 − weight · (1 − factor) · (1
    /// − colour), for one node and light after the other (the black rectangle over the screen of the second method of
    /// paper 002 §6.4). Highlights of hidden lights stay, darkened. All nodes of such a light must say the same, or
    /// the frame is refused.
    DarkenPicture {
        /// How much of the picture's light is taken away.
        weight: f64,
        /// What is left, in linear red, green and blue.
        color: [f64; 3],
    },
}

impl Default for Apply {
    /// A shadow takes all of the light.
    fn default() -> Self {
        Self::Light { weight: 1.0, color: [0.0; 3] }
    }
}

impl Contribution {
    /// A contribution that multiplies the light's visibility in these channels.
    pub fn visibility(channels: Channels) -> Self {
        Self { visibility: Some(channels), ..Self::default() }
    }

    /// A contribution that adds at most `bound` to the count of any pixel.
    pub fn counts(bound: u32) -> Self {
        Self { counts_bound: Some(bound), ..Self::default() }
    }

    /// This contribution and that of `more` passes of the same node. The picture applies both as this one says.
    #[must_use]
    pub fn and(mut self, more: Self) -> Self {
        self.counts_bound = match (self.counts_bound, more.counts_bound) {
            (Some(bound), Some(more)) => Some(bound.saturating_add(more)),
            (bound, more) => bound.or(more),
        };
        self.visibility = self.visibility.max(more.visibility);
        self.own_shadow |= more.own_shadow;
        self.smooth_terminators.extend(more.smooth_terminators);
        self
    }

    /// Whether the passes leave a factor at all.
    pub fn is_some(&self) -> bool {
        self.counts_bound.is_some() || self.visibility.is_some()
    }
}

impl Apply {
    /// What the picture loses where the factor is 0, for red, green and blue: weight · (1 − colour). What is no number takes
    /// everything.
    pub(crate) fn max_darkening(self) -> [f32; 3] {
        let (weight, color) = match self {
            Self::Light { weight, color } | Self::DarkenPicture { weight, color } => (weight, color),
            Self::DarkenOnce { .. } => (1.0, [0.0; 3]),
        };
        crate::plan::max_darkening(weight, color)
    }
}
