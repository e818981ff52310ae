//! How the edges of surfaces and shadows are smoothed.

use std::fmt;
use std::str::FromStr;

use thiserror::Error;
use wgpu::TextureFormat;

/// How a frame's edges are smoothed. Both ways average four values of tone-mapped linear light, as the eye would:
/// averaged before tone mapping, one sample of a highlight fifty times as bright as paper would whiten its whole pixel,
/// and the edge would be as jagged as without. (Factors of one fragment's samples are averaged before, since it is
/// shaded once.)
///
/// Recommended: [`Antialias::Multisample4`] where every shadow is counted; it errs as little along shadow edges and shades
/// once. On software adapters, which spend their time on samples too, the two cost nearly the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Antialias {
    /// One value a pixel.
    #[default]
    None,
    /// Four samples a pixel: depth, stencil counts and light mask are kept for each, a surface is shaded once for each
    /// pixel with the mean factor of the samples that show it. Only factors that are counted can be kept for each.
    Multisample4,
    /// Twice as many pixels in both directions, each drawn in full, then averaged: any technique, any format.
    Supersample4,
}

/// Where the samples of [`Antialias::Multisample4`] lie within their pixel, from its top left corner: the standard
/// positions of graphics interfaces.
pub const STANDARD_SAMPLES_PX: [[f64; 2]; 4] =
    [[0.375, 0.125], [0.875, 0.375], [0.125, 0.625], [0.625, 0.875]];

/// The formats a multisampled plan may ask for; every adapter has targets of four samples in these.
pub const MULTISAMPLED_EVERYWHERE: &[TextureFormat] = &[
    TextureFormat::R8Unorm,
    TextureFormat::Rg8Unorm,
    TextureFormat::Rgba8Unorm,
    TextureFormat::Rgba8UnormSrgb,
    TextureFormat::Rgba16Uint,
    TextureFormat::Depth32Float,
    TextureFormat::Depth32FloatStencil8,
];

const NAMES: [(&str, Antialias); 3] =
    [("none", Antialias::None), ("msaa4", Antialias::Multisample4), ("ssaa4", Antialias::Supersample4)];

impl Antialias {
    /// Samples of a pixel of what is drawn.
    pub fn samples(self) -> u32 {
        if self == Self::Multisample4 { 4 } else { 1 }
    }

    /// The size of what is drawn for a picture of `size_px`.
    pub fn drawn_size_px(self, size_px: [u32; 2]) -> [u32; 2] {
        if self == Self::Supersample4 { size_px.map(|n| n.saturating_mul(2)) } else { size_px }
    }

    /// The size of factor images of a picture of `size_px`: a texel for each sample. Texel (2x + s % 2, 2y + s / 2) is
    /// sample s of pixel (x, y).
    pub fn factor_size_px(self, size_px: [u32; 2]) -> [u32; 2] {
        if self == Self::None { size_px } else { size_px.map(|n| n.saturating_mul(2)) }
    }

    /// Where, in pixels of what is drawn from its top left corner, texel (x, y) of a factor image was sampled.
    pub fn sample_place_px(self, [x, y]: [u32; 2]) -> [f64; 2] {
        if self == Self::Multisample4 {
            let [dx, dy] = STANDARD_SAMPLES_PX[(x % 2 + y % 2 * 2) as usize];
            [f64::from(x / 2) + dx, f64::from(y / 2) + dy]
        } else {
            [x, y].map(|n| f64::from(n) + 0.5)
        }
    }
}

impl fmt::Display for Antialias {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(NAMES.iter().find(|(_, antialias)| antialias == self).map_or("", |(name, _)| name))
    }
}

/// A name that is no [`Antialias`].
#[derive(Clone, Debug, Error, PartialEq)]
#[error("'{0}' is no way of antialiasing; accepted: none, msaa4, ssaa4")]
pub struct UnknownAntialias(pub String);

impl FromStr for Antialias {
    type Err = UnknownAntialias;

    fn from_str(text: &str) -> Result<Self, UnknownAntialias> {
        let found = NAMES.iter().find(|(name, _)| *name == text);
        found.map(|(_, antialias)| *antialias).ok_or_else(|| UnknownAntialias(text.into()))
    }
}
