//! What every technique and setting owes on the hard cases: the one table of tolerances.
//!
//! A technique or setting without a row fails. What an exact technique owes is fixed in `shadowgraph::measure`, and no
//! row loosens it: an approximation is declared here in advance, with its bound and its reason, or it is an error. A
//! technique from outside brings its own rows.

use super::tolerances_found as found;
use super::tolerances_maps::{
    BARS_IN_SAMPLES, FEW_TEXELS, LAMPS_ON_FACES, LONG_TEXELS, LONGER_TEXELS, MAP, SILHOUETTE, WIDE_BAND, map,
    map_texels, silhouettes,
};

/// What is owed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Tolerance {
    /// 0 wrong pixels outside the ambiguity band, in every channel. For a light with a size the technique says how many
    /// samples it takes; then no pixel at all may be outside of what its ambiguous samples allow.
    Exact,
    /// The same, or a typed error: the setting forces what only some views and casters allow.
    ExactWhereAccepted,
    /// An approximation, at most so far off.
    Within(Bound),
    /// A typed error.
    Refused,
}

/// How far an approximation may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bound {
    /// Leaks outside the band, as a share of the pixels compared.
    pub(crate) leak_share: f64,
    /// False shadows outside the band, as a share of the pixels compared.
    pub(crate) false_share: f64,
    /// Root of the mean squared difference over the frame.
    pub(crate) rmse: f64,
    /// Root of the mean squared difference over the penumbra, where the whole light's factor is neither 0 nor 1.
    pub(crate) penumbra_rmse: f64,
    /// The largest difference at any pixel.
    pub(crate) max: f64,
    /// Why it cannot be exact.
    pub(crate) why: &'static str,
}

/// What is owed on single cases and sweeps, by id or by full name; the first that fits holds.
pub(crate) type Group = &'static [(&'static str, Tolerance)];

/// What one setting of one technique owes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// The technique's type name.
    pub(crate) technique: &'static str,
    /// The setting's name.
    pub(crate) setting: &'static str,
    /// On every case that `except` does not name.
    pub(crate) owes: Tolerance,
    /// On single cases, group by group.
    pub(crate) except: &'static [Group],
    /// How many variants of the cases it must accept, so that refusing is no way to pass.
    pub(crate) accepts_at_least: usize,
}

impl Row {
    /// What is owed on the case of this id and name.
    pub(crate) fn on(&self, id: &str, name: &str) -> Tolerance {
        let named = self.exceptions().find(|(case, _)| *case == id || *case == name);
        named.map_or(self.owes, |(_, tolerance)| *tolerance)
    }

    /// What is owed on single cases: by `except`, then by what [`found`] has for the setting.
    pub(crate) fn exceptions(&self) -> impl Iterator<Item = &'static (&'static str, Tolerance)> {
        self.except.iter().chain(found::groups(self.technique, self.setting)).copied().flatten()
    }
}

const fn exact(technique: &'static str, setting: &'static str) -> Row {
    Row { technique, setting, owes: Tolerance::Exact, except: &[], accepts_at_least: 240 }
}

const fn forced(technique: &'static str, setting: &'static str, accepts_at_least: usize) -> Row {
    Row { technique, setting, owes: Tolerance::ExactWhereAccepted, except: &[], accepts_at_least }
}

pub(crate) const HARD: &str = "ShadowVolumeHard";
pub(crate) const TRANSPARENT: &str = "TransparentShadow";

/// Lids over open casters: nothing dark is lit, but light that shines through an opening is lost, as much of it as the
/// opening is large in the frame.
pub(crate) const fn lids(false_share: f64) -> Tolerance {
    // Factors are 0 or 1: the shares say it all.
    let why = "lids shadow what lies behind an opening, and what lies inside it";
    Tolerance::Within(Bound { leak_share: 0.0, false_share, rmse: 1.0, penumbra_rmse: 1.0, max: 1.0, why })
}

/// Points of a light: steps in penumbrae, so RMSE is the mean over whole penumbrae or frames. No pixel is wrong by more than
/// half outside the band, but for a texture's rounding of edges to texels.
pub(crate) const fn points(rmse: f64, wrong_share: f64) -> Tolerance {
    let why = "so many points stand for a light; the reference takes 1024";
    let (leak_share, false_share) = (wrong_share, wrong_share);
    // A pixel whose centre is on the edge of something that touches the receiver is wrong altogether, and within the band.
    Tolerance::Within(Bound { leak_share, false_share, rmse, penumbra_rmse: rmse, max: 1.0, why })
}

/// Penumbrae of a pixel or two: where within 1/256 pixel an edge is drawn is a good part of them.
const NARROW: Group = &[("scale/1e3", points(0.1, 0.0005)), ("light-far/1e3-m", points(0.1, 0.0005))];

/// Textures whose texels are wider than penumbrae are.
pub(crate) const fn texels() -> Tolerance {
    let why = "texels are wider there than penumbrae, or drawn out where light grazes: edges are off by up to half of one";
    let (leak_share, false_share) = (0.002, 0.002);
    Tolerance::Within(Bound { leak_share, false_share, rmse: 0.07, penumbra_rmse: 0.4, max: 1.0, why })
}

/// What hides the light from within its sphere does so before points in the ball, or behind them, where the disc has it
/// the other way round.
pub(crate) const fn casters_within(rmse: f64) -> Tolerance {
    let why =
        "a caster within the light's sphere is before some points of the ball that are behind it on the disc";
    let (leak_share, false_share) = (0.02, 0.02);
    Tolerance::Within(Bound { leak_share, false_share, rmse, penumbra_rmse: rmse, max: 1.0, why })
}

pub(crate) const SOFT: &str = "ShadowVolumeSoft";

/// Sample by sample, holes too; its factors are computed for each fragment, so that four samples a pixel are refused.
const fn sampled(setting: &'static str) -> Row {
    let except: &[Group] = &[&[("msaa", Tolerance::ExactWhereAccepted)]];
    Row { except, ..exact(SOFT, setting) }
}

pub(crate) const PLANAR: &str = "SoftShadow";

const fn planar(setting: &'static str, owes: Tolerance, except: &'static [Group]) -> Row {
    Row { technique: PLANAR, setting, owes, except, accepts_at_least: 240 }
}

/// Areas added up, at most so far off: leaks and false shadows as shares of the frame, and the root mean square over frame
/// and penumbra. Single pixels may be off by anything: a box's whole inside may overlap its lid.
pub(crate) const fn areas(
    leak_share: f64,
    false_share: f64,
    rmse: f64,
    penumbra_rmse: f64,
    why: &'static str,
) -> Tolerance {
    Tolerance::Within(Bound { leak_share, false_share, rmse, penumbra_rmse, max: 1.0, why })
}

/// Where layers overlap.
pub(crate) const LAYERS: &str =
    "areas add up where casters, or layers of one that is open, overlap before the light";
/// Where holes are asked by samples beside areas.
const MASKS: &str =
    "what masks leave is multiplied with what areas do, though both may hide the same part of the light";
/// Where a face is edge-on to the light's centre.
const EDGE_ON: &str = "on faces in whose plane the light's centre lies, rounding decides on which side of their own edges \
    the centre is, and half of the light is at stake";
/// Where silhouettes are not those of the light's centre.
pub(crate) const FROM_THE_CENTRE: &str = "silhouettes are those of the light's centre, and what of the light lies below the receiver's \
    plane counts as light";

/// Sums of half floats behind transparent casters: nothing is lit or dark that should not be, but factors are off by what
/// rounding leaves at every step.
pub(crate) const fn half_sums(rmse: f64) -> Tolerance {
    let why = "half floats do not cancel what they add, nor what they multiply";
    Tolerance::Within(Bound { leak_share: 0.0, false_share: 0.0, rmse, penumbra_rmse: rmse, max: 0.4, why })
}

/// Factors are computed for each fragment: four samples a pixel are refused, four pixels for one are not.
const NOT_MULTISAMPLED: Group = &[
    ("msaa/in-shadow", Tolerance::Refused),
    ("msaa/knot", Tolerance::Refused),
    ("msaa/lamp", Tolerance::Refused),
    ("msaa/odd", Tolerance::Refused),
    ("msaa/one-pixel", Tolerance::Refused),
    ("msaa/ortho", Tolerance::Refused),
    ("msaa/sun", Tolerance::Refused),
    ("msaa/twelve-lamps", Tolerance::Refused),
    ("msaa/two-lamps", Tolerance::Refused),
    ("msaa/wide", Tolerance::Refused),
];

const fn overlapping() -> Tolerance {
    areas(0.0001, 0.012, 0.1, 0.7, LAYERS)
}

/// Hundreds of layers.
const OVERLAPS: Group = &[
    ("overlap-256", overlapping()),
    ("overlap-512", overlapping()),
    ("overlap-open-128", overlapping()),
    ("overlap-2049", overlapping()),
    ("overlap-4096", overlapping()),
    ("overlap-seen-through", overlapping()),
    ("overlap-closed", overlapping()),
    ("overlap-open", overlapping()),
];

/// A caster that touches the light, or almost, is within its sphere.
const CASTERS_WITHIN: Group = &[
    ("light-on-edge", casters_within(0.13)),
    ("caster-in-light", casters_within(0.13)),
    ("light-near-face", casters_within(0.13)),
    ("light-near-edge", casters_within(0.13)),
    ("light-near-corner", casters_within(0.13)),
    ("light-near-side", casters_within(0.13)),
    ("light-radius/3-m", casters_within(0.13)),
];

/// The same, within what 16 points owe anyway.
const CASTERS_TOUCHING: Group =
    &[("light-on-vertex", casters_within(0.13)), ("light-touches-caster", casters_within(0.13))];

/// Techniques whose settings other than the default are tried on one case in [`THINNED_TO_ONE_IN`], so that all of it ends
/// in time, ...
pub(crate) const THINNED: &[&str] = &[SOFT, PLANAR, TRANSPARENT, MAP, SILHOUETTE];
pub(crate) const THINNED_TO_ONE_IN: usize = 6;
/// ... and on none of these, which are large: a thousand instances, thousands of layers, 64 lights. They are about a number, which
/// every technique meets by its default; other settings of theirs take a fifth of all time.
pub(crate) const LARGE_CASES: &[&str] =
    &["instanced-1000", "overlap-4096", "lights-64", "index-65536", "overlap-closed", "overlap-open"];

/// The heavy steps of sweeps are about counting. What counts nothing is tried on the table's `overlap-4096` instead of on them.
pub(crate) const COUNT_NOTHING: &[&str] = &[PLANAR, MAP, SILHOUETTE];

/// The built-in techniques.
pub(crate) const ROWS: &[Row] = &[
    exact(HARD, "default"),
    forced(HARD, "z-pass", 200),
    exact(HARD, "z-fail"),
    exact(HARD, "open"),
    exact(HARD, "infinite"),
    exact(HARD, "backfaces"),
    Row {
        except: &[&[
            // Boxes, shells, cans and rooms with an opening through which light falls.
            ("light-on-edge/open-box", lids(0.1)),
            ("light-in-open-box", lids(0.5)),
            ("nested-shells/window", lids(0.4)),
            ("open-cylinder", lids(0.03)),
            ("moebius", lids(0.1)),
            // Creases and waves whose outline is not flat: the lid lies off the surface.
            ("fins", lids(0.03)),
            ("index-65536/sheet", lids(0.05)),
            ("map-acne/waves", lids(0.4)),
            // A flat caster's lid lies in its own plane, and rounding tells them apart on wide floors.
            ("grazing-sun", lids(0.001)),
            ("field-of-view-in-shadow", lids(0.06)),
            ("skinned-extreme/parted", lids(0.001)),
            // Cracks that a lid closes.
            ("t-junction", lids(0.001)),
        ]],
        ..exact(HARD, "cap")
    },
    // Float counters have no samples: four a pixel are refused.
    Row { except: &[&[("msaa", Tolerance::ExactWhereAccepted)]], ..exact(HARD, "float") },
    // Masked parts are no counts, which is all that a single pass takes; and it darkens the picture, other nodes the light.
    Row {
        except: &[&[
            ("alpha-mask", Tolerance::Refused),
            ("leaf-on-floor", Tolerance::Refused),
            ("turned-from-centre", Tolerance::Refused),
        ]],
        ..exact(HARD, "single")
    },
    exact(HARD, "smooth"),
    sampled("default"),
    sampled("samples 16"),
    sampled("samples 256"),
    planar("direct 16", points(0.07, 0.0005), &[NOT_MULTISAMPLED, CASTERS_WITHIN]),
    planar(
        "direct 64",
        points(0.024, 0.0005),
        &[
            NOT_MULTISAMPLED,
            CASTERS_WITHIN,
            CASTERS_TOUCHING,
            NARROW,
            // Hardly any of the light is above the horizon there, and few points.
            &[
                ("receiver-inside-light", points(0.04, 0.0005)),
                ("grazing-sun/0.05-deg", points(0.03, 0.0005)),
            ],
        ],
    ),
    planar(
        "direct 256",
        points(0.012, 0.0005),
        &[
            NOT_MULTISAMPLED,
            CASTERS_WITHIN,
            CASTERS_TOUCHING,
            NARROW,
            &[("receiver-inside-light", points(0.03, 0.0005))],
        ],
    ),
    planar(
        "default",
        points(0.07, 0.002),
        &[
            NOT_MULTISAMPLED,
            CASTERS_WITHIN,
            &[
                ("fins/5-sun", texels()),
                ("alpha-mask", texels()),
                ("leaf-on-floor/sun", texels()),
                ("low-sun", texels()),
                ("animated", texels()),
                ("field-of-view/150-deg", texels()),
                ("light-radius/0.001-m", texels()),
                ("light-angle", texels()),
                ("offset-exact", texels()),
                ("scale", texels()),
                ("light-far", texels()),
                ("texels/128", texels()),
                ("grazing-sun", texels()),
                ("grazing-lamp", texels()),
            ],
        ],
    ),
    // Measured over all cases, with a third more: what areas are worth depends on what overlaps.
    Row {
        except: &[
            NOT_MULTISAMPLED,
            OVERLAPS,
            &[
                ("alpha-mask", areas(0.0005, 0.012, 0.1, 0.6, MASKS)),
                ("duplicate-face", areas(0.0001, 0.004, 0.06, 0.5, LAYERS)),
                ("penumbra-overlap", areas(0.0001, 0.001, 0.09, 0.35, LAYERS)),
                ("light-on-edge", areas(0.0001, 0.001, 0.15, 0.2, LAYERS)),
                ("two-cubes-one-edge", areas(0.0001, 0.001, 0.09, 0.45, EDGE_ON)),
                ("edge-at-centre", areas(0.0001, 0.001, 0.09, 0.35, EDGE_ON)),
                ("directional-parallel", areas(0.0001, 0.001, 0.09, 0.4, EDGE_ON)),
            ],
        ],
        // Where nothing overlaps it is a tenth of that and less; a hard shadow in its place has 0.25 and more.
        owes: areas(0.0001, 0.001, 0.055, 0.15, LAYERS),
        ..exact(SOFT, "per-receiver")
    },
    Row {
        except: &[
            NOT_MULTISAMPLED,
            OVERLAPS,
            &[
                ("alpha-mask", areas(0.0005, 0.012, 0.1, 0.6, MASKS)),
                ("duplicate-face", areas(0.001, 0.004, 0.06, 0.5, LAYERS)),
                // The centre is inside: nothing outside sees it, and all of the light is taken to be hidden with it.
                ("caster-in-light/centre-inside", areas(0.001, 1.0, 0.95, 0.95, FROM_THE_CENTRE)),
                ("caster-in-light/leaf", areas(0.001, 0.001, 0.13, 0.13, FROM_THE_CENTRE)),
                // The light is cut in halves by what it stands on, and its centre sees neither of them.
                ("light-on-edge", areas(0.09, 0.001, 0.55, 0.65, FROM_THE_CENTRE)),
                ("light-on-vertex", areas(0.01, 0.001, 0.4, 0.45, FROM_THE_CENTRE)),
                ("directional-parallel", areas(0.001, 0.001, 0.06, 0.22, FROM_THE_CENTRE)),
                ("light-crosses-frustum", areas(0.001, 0.001, 0.07, 0.28, FROM_THE_CENTRE)),
                ("ortho-camera/cut", areas(0.001, 0.001, 0.075, 0.32, FROM_THE_CENTRE)),
                ("penumbra-overlap/same-side", areas(0.001, 0.001, 0.085, 0.25, LAYERS)),
                // Almost as when it is inside.
                ("light-near-face", areas(0.011, 0.001, 0.11, 0.45, FROM_THE_CENTRE)),
                ("light-near-edge", areas(0.008, 0.001, 0.39, 0.46, FROM_THE_CENTRE)),
                ("light-near-corner", areas(0.001, 0.001, 0.34, 0.38, FROM_THE_CENTRE)),
                ("light-near-side", areas(0.18, 0.001, 0.36, 0.52, FROM_THE_CENTRE)),
                // Half of the light and more is below the floor.
                ("grazing-sun", areas(0.001, 0.001, 0.16, 0.15, FROM_THE_CENTRE)),
                ("grazing-lamp", areas(0.03, 0.001, 0.165, 0.16, FROM_THE_CENTRE)),
            ],
        ],
        // A hard shadow in its place has 0.25 in its penumbra, and more.
        owes: areas(0.001, 0.001, 0.06, 0.15, FROM_THE_CENTRE),
        ..exact(SOFT, "wedge")
    },
    exact(TRANSPARENT, "default"),
    // Its grid is as fine as 24 bits allow: behind hundreds of surfaces that let almost all pass, too coarse.
    Row {
        except: &[&[
            ("glass-deep/128-boxes", Tolerance::ExactWhereAccepted),
            ("glass-depth", Tolerance::ExactWhereAccepted),
        ]],
        ..exact(TRANSPARENT, "grid-log")
    },
    Row {
        except: &[&[
            ("alpha-0/over-a-pane", half_sums(0.001)),
            ("glass-order", half_sums(0.001)),
            ("glass-deep", half_sums(0.02)),
            ("glass-self", half_sums(0.002)),
            ("folded-glass", half_sums(0.002)),
            ("panes-intersecting", half_sums(0.001)),
            ("tinted-bottle", half_sums(0.001)),
            ("glass-depth", half_sums(0.03)),
            ("glass-transmission", half_sums(0.001)),
        ]],
        ..exact(TRANSPARENT, "log16")
    },
    Row {
        except: &[&[
            ("channel-0", half_sums(0.001)),
            ("glass-order", half_sums(0.001)),
            ("glass-deep", half_sums(0.1)),
            ("glass-self", half_sums(0.002)),
            ("folded-glass", half_sums(0.002)),
            ("panes-intersecting", half_sums(0.001)),
            ("tinted-bottle", half_sums(0.001)),
            ("glass-depth", half_sums(0.2)),
            ("glass-transmission", half_sums(0.001)),
        ]],
        ..exact(TRANSPARENT, "product16")
    },
    exact(TRANSPARENT, "log32"),
    exact(TRANSPARENT, "product32"),
    map("default", map_texels(0.0011, 0.0011, 0.08), &[WIDE_BAND, LONG_TEXELS, FEW_TEXELS]),
    map("pcf 1", map_texels(0.0011, 0.0014, 0.08), &[WIDE_BAND, LONG_TEXELS, LAMPS_ON_FACES, FEW_TEXELS]),
    map("512", map_texels(0.005, 0.002, 0.105), &[LONGER_TEXELS, LAMPS_ON_FACES, BARS_IN_SAMPLES]),
    map("cascades 3", map_texels(0.0016, 0.0016, 0.08), &[WIDE_BAND, LONG_TEXELS, LAMPS_ON_FACES]),
    // Two texels times the slope, and one along the normal: as far as shadows come off.
    map(
        "biased",
        map_texels(0.008, 0.001, 0.11),
        &[
            LAMPS_ON_FACES,
            &[
                ("alpha-mask", map_texels(0.022, 0.001, 0.17)),
                ("msaa/in-shadow", map_texels(0.008, 0.0016, 0.11)),
                ("texels/128", map_texels(0.008, 0.0022, 0.11)),
                ("field-of-view-in-shadow", map_texels(0.008, 0.0015, 0.11)),
                ("map-acne", map_texels(0.033, 0.001, 0.21)),
                ("wide-band", map_texels(0.13, 0.001, 0.41)),
                ("strip-500m", map_texels(0.22, 0.001, 0.55)),
                ("strip-5km", map_texels(0.22, 0.001, 0.55)),
                ("stretched-at-grazing", map_texels(0.008, 0.003, 0.12)),
                ("grazing-sun", map_texels(0.08, 0.001, 0.32)),
                ("grazing-lamp", map_texels(0.035, 0.001, 0.22)),
            ],
        ],
    ),
    silhouettes("default", map_texels(0.0013, 0.001, 0.05), &[LONG_TEXELS]),
    silhouettes("256", map_texels(0.0075, 0.0045, 0.12), &[LONGER_TEXELS, LAMPS_ON_FACES]),
    silhouettes("one byte", map_texels(0.0017, 0.001, 0.055), &[WIDE_BAND, LONG_TEXELS, LAMPS_ON_FACES]),
    // Its factors are computed for each fragment: four samples a pixel are refused.
    Row { except: &[&[("msaa", Tolerance::ExactWhereAccepted)]], ..exact("Reference", "default") },
];
