//! What maps owe: texels are as large as they are, and the tests in texels (tests/gpu/maps.rs) say the rest.

use super::tolerances::{Bound, Group, Row, Tolerance};

pub(crate) const MAP: &str = "ShadowMap";
pub(crate) const SILHOUETTE: &str = "SilhouetteMap";

/// Texels of what a light sees: edges are off by up to one, drawn out where light grazes, and blurred over as many as are
/// averaged. Measured over all cases, with a third more; no leak or false shadow is farther than two texels from an edge, which
/// tests/gpu/maps.rs asks in texels.
pub(crate) const fn map_texels(leak_share: f64, false_share: f64, rmse: f64) -> Tolerance {
    let why = "edges are off by up to a texel of the map";
    Tolerance::Within(Bound { leak_share, false_share, rmse, penumbra_rmse: 1.0, max: 1.0, why })
}

pub(crate) const fn map(setting: &'static str, owes: Tolerance, except: &'static [Group]) -> Row {
    Row { technique: MAP, setting, owes, except, accepts_at_least: 240 }
}

/// The same where points of silhouettes are known: most cases have not one wrong pixel, waves and a thousand boxes some.
pub(crate) const fn silhouettes(setting: &'static str, owes: Tolerance, except: &'static [Group]) -> Row {
    Row { technique: SILHOUETTE, setting, owes, except, accepts_at_least: 240 }
}

/// A lamp that all but lies in a floor.
pub(crate) const WIDE_BAND: Group = &[("wide-band", map_texels(0.13, 0.001, 0.41))];

/// Kilometres in one map, lamps and suns that graze, so that one texel is many pixels long.
pub(crate) const LONG_TEXELS: Group = &[
    ("strip-500m", map_texels(0.008, 0.006, 0.13)),
    ("strip-5km", map_texels(0.13, 0.014, 0.41)),
    ("grazing-sun", map_texels(0.001, 0.001, 0.12)),
    ("grazing-lamp", map_texels(0.035, 0.001, 0.22)),
];

/// The same with a quarter of the texels along a side.
pub(crate) const LONGER_TEXELS: Group = &[
    ("wide-band", map_texels(0.13, 0.001, 0.41)),
    ("strip-500m", map_texels(0.13, 0.001, 0.41)),
    ("strip-5km", map_texels(0.22, 0.015, 0.5)),
    ("grazing-sun", map_texels(0.002, 0.001, 0.15)),
    ("grazing-lamp", map_texels(0.035, 0.001, 0.22)),
];

/// A yard of 8 m on 128 texels.
pub(crate) const FEW_TEXELS: Group = &[("texels/128", map_texels(0.0021, 0.0024, 0.08))];

/// Bars of a fence narrower than a texel, and their shadows, at every sample.
pub(crate) const BARS_IN_SAMPLES: Group = &[
    ("msaa/two-lamps", map_texels(0.005, 0.0034, 0.105)),
    ("msaa/twelve-lamps", map_texels(0.005, 0.0037, 0.11)),
];

/// Lamps a billionth of a metre over a face: nearer to it than f32 tells one direction from another.
pub(crate) const LAMPS_ON_FACES: Group = &[
    ("lamp-1e-9-over-face", map_texels(0.2, 0.012, 0.52)),
    ("lamp-1e-9-over-edge", map_texels(0.2, 0.012, 0.52)),
    ("lamp-1e-9-over-vertex", map_texels(1.0, 0.04, 1.0)),
];
