//! What a technique hands back for one light.

use wgpu::TextureFormat;

/// Channels of a visibility target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Channels {
    /// One value for all colours.
    One,
    /// Red, green and blue apart.
    Rgb,
}

impl Channels {
    /// The format of visibility targets that hold these.
    pub fn format(self) -> TextureFormat {
        match self {
            Self::One => TextureFormat::R16Float,
            Self::Rgb => TextureFormat::Rgba16Float,
        }
    }
}

/// What the passes of one node leave of one light, and what the picture is to make of it. The default is nothing: the light
/// stays as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contribution {
    /// Whether anything is counted in the stencil, and an upper bound on what is added to any pixel's final count.
    pub counts_bound: Option<u32>,
    /// Whether the light's visibility is multiplied, and in which channels.
    pub visibility: Option<Channels>,
    /// Whether what is left in the visibility holds the receiver's own shadow too: what part of the light lies beyond the
    /// horizon of the surface. Nothing else darkens surfaces then for being turned away from the light's centre, neither
    /// in pictures, beyond the cosine of their normals, nor in factors, whatever other techniques serve the light: a
    /// light's factor is the product of what they leave, and the horizon is in one of them.
    pub own_shadow: bool,
    /// Instances that are shaded by their normals alone where they turn away from this light: the technique leaves what is
    /// there undecided. For pictures; in factors, what is turned away stays dark. None beyond the first
    /// [`MAX_SMOOTH_LIGHTS`](super::MAX_SMOOTH_LIGHTS) lights of a scene.
    pub smooth_terminators: Vec<usize>,
    /// What the picture is to make of the factor.
    pub apply: Apply,
}

/// What a picture makes of a node's factor. Weights and linear colours are confined to 0 … 1. A factor that is asked for is
/// never weighted.
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
    /// The light is shaded as if nothing shadowed it. Its counts are put together with those of all other lights of which
    /// a node says so, and where the sum is not zero, the finished picture is darkened, once. (No count is negative, so they
    /// do not cancel.) All such nodes have one weight. Only counts can be put together so.
    DarkenOnce {
        /// How much of the picture's light is taken away.
        weight: f64,
    },
    /// The light is shaded as if nothing shadowed it, and the finished picture multiplied by
    /// 1 − weight · (1 − factor) · (1 − colour), for one node and light after the other (the black rectangle over the screen
    /// of the second method of paper 002 §6.4). Highlights of lights that are blocked stay, darkened. A light whose shadows
    /// darken the picture for one node does so for all of its nodes, or the frame is refused.
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
    /// What multiplies the light's visibility in these channels.
    pub fn visibility(channels: Channels) -> Self {
        Self { visibility: Some(channels), ..Self::default() }
    }

    /// What counts in the stencil, this much at most.
    pub fn counts(bound: u32) -> Self {
        Self { counts_bound: Some(bound), ..Self::default() }
    }

    /// This one and what `more` passes of the same node leave. What the picture makes of it is what this one says.
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

    /// Whether there is a factor at all.
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
