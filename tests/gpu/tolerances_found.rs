//! What approximations owe on the rows that ordinary content brought: measured, with a third more. Exact settings owe there
//! what they owe everywhere.

use super::tolerances::{
    FROM_THE_CENTRE, Group, HARD, LAYERS, PLANAR, SOFT, TRANSPARENT, Tolerance, areas, casters_within,
    half_sums, lids, points, texels,
};

/// What a setting owes on single cases.
pub(crate) fn groups(technique: &str, setting: &str) -> &'static [Group] {
    match (technique, setting) {
        (HARD, "cap") => &[LIDS],
        (SOFT, "per-receiver") => &[AREAS, LAYERED, BEFORE_ONE_CASTER],
        (SOFT, "wedge") => &[WEDGES, LAYERED, BEFORE_ONE_CASTER],
        (PLANAR, "direct 16") => &[CASTERS_WITHIN, NARROW],
        (PLANAR, "direct 64") => {
            &[CASTERS_WITHIN, CASTERS_TOUCHING, NARROW, NARROW_IN_MANY_POINTS, FEW_POINTS]
        }
        (PLANAR, "direct 256") => &[CASTERS_WITHIN, CASTERS_TOUCHING, NARROW, NARROW_IN_MANY_POINTS],
        (PLANAR, "default") => &[CASTERS_WITHIN, TEXELS],
        (TRANSPARENT, "log16" | "product16") => &[HALF_SUMS],
        _ => &[],
    }
}

/// Boxes and rooms without their lid, furrows and waves: the lid that closes them lies off their surface.
const LIDS: Group = &[
    ("culled-underside/box-without-lid", lids(0.02)),
    ("room-through-culled-walls/no-ceiling", lids(0.45)),
    ("strip-500m", lids(0.8)),
    ("strip-5km", lids(0.8)),
    ("thin-receiver/grazing-floor", lids(0.1)),
];

/// A caster that touches the light, or almost, is within its sphere.
const CASTERS_WITHIN: Group =
    &[("lamp-1e-9-over-edge", casters_within(0.13)), ("ortho-lamp-beside", casters_within(0.13))];

/// The same, within what 16 points owe anyway.
const CASTERS_TOUCHING: Group = &[
    ("lamp-1e-9-over-face", casters_within(0.13)),
    ("lamp-1e-9-over-vertex", casters_within(0.13)),
    ("soft-lamp-on-edge", casters_within(0.13)),
    ("soft-lamp-on-corner", casters_within(0.13)),
    ("soft-lamp-in-floor/on-a-cube-level-with-another", casters_within(0.13)),
];

/// Penumbrae of a pixel or two, since frames are small: where within 1/256 pixel an edge is drawn is a good part of them.
const NARROW: Group = &[("thin-receiver/slats-ortho", points(0.12, 0.0005))];

/// The same, within what 16 points owe anyway.
const NARROW_IN_MANY_POINTS: Group = &[
    ("culled-underside/box-without-lid", points(0.1, 0.0005)),
    ("glass-on-box/sun", points(0.1, 0.0005)),
    ("road-50km/cable", points(0.1, 0.0005)),
    ("stretched-at-grazing/sun-200-m", points(0.1, 0.0005)),
    ("thin-receiver/slats-sun", points(0.1, 0.0005)),
];

/// Hardly any of the light is above the horizon there, and few points.
const FEW_POINTS: Group = &[
    ("soft-no-caster/lamp", points(0.06, 0.0005)),
    ("soft-no-caster/ortho", points(0.06, 0.0005)),
    ("planar-no-caster/lamp", points(0.06, 0.0005)),
];

/// Textures whose texels are wider than penumbrae of a pixel.
const TEXELS: Group = &[
    ("back-to-back-panels", texels()),
    ("coincident-panes/moved-by-node", texels()),
    ("cracked-2e-6", texels()),
    ("culled-underside", texels()),
    ("directional-parallel/box-sides", texels()),
    ("glass-on-floor", texels()),
    ("glass-on-box/sun", texels()),
    ("inconsistent-winding/patch", texels()),
    ("inward-shell/shell-in-shell", texels()),
    ("lamp-in-far-plane/ortho-1e-7-m", texels()),
    ("lights-4", texels()),
    ("lights-16", texels()),
    ("lights-64", texels()),
    ("resize/17x13", texels()),
    ("two-sided-leaf/sun-ortho", texels()),
    ("wide-band/two-floors-grid", texels()),
    ("room-through-culled-walls", texels()),
    ("road-50km", texels()),
    ("stretched-at-grazing", texels()),
    ("thin-receiver", texels()),
];

/// Areas that are added up.
const AREAS: Group = &[
    ("back-to-back-panels/double-sided", areas(0.0001, 0.004, 0.06, 0.5, LAYERS)),
    // The disc is cut by what its centre is on, and by layers of it.
    ("soft-lamp-on-edge/1-m", areas(0.0001, 0.001, 0.17, 0.2, LAYERS)),
    ("soft-lamp-on-corner/1-m", areas(0.0001, 0.001, 0.17, 0.2, LAYERS)),
    ("wide-band/two-floors-low-lamp", areas(0.0001, 0.002, 0.07, 0.2, LAYERS)),
    ("light-radius/3-m", areas(0.0001, 0.001, 0.055, 0.4, LAYERS)),
    ("light-radius/10-m", areas(0.0001, 0.001, 0.055, 0.4, LAYERS)),
];

const fn layered() -> Tolerance {
    areas(0.0001, 0.001, 0.06, 0.42, LAYERS)
}

/// Every layer of a caster that is open, wound at random or modelled twice is counted: what one of them hides of the light, two
/// hide twice, and no penumbra is left where it is half.
const LAYERED: Group = &[
    ("back-to-back-panels", layered()),
    ("cracked-2e-6", layered()),
    ("glass-on-box/grid-top", layered()),
    ("inconsistent-winding", layered()),
    ("inward-shell", layered()),
    ("light-crosses-frustum", layered()),
    ("low-sun", layered()),
    ("map-acne/waves", layered()),
    ("open-cylinder", layered()),
    ("opposite-duplicate", layered()),
    ("room-through-culled-walls", layered()),
    ("singular/box-to-quad", layered()),
    ("singular/disc", layered()),
    ("touching-receiver/bottomless", layered()),
    ("two-sided-leaf", layered()),
];

/// Before one caster, of which no two edges meet over the light, either way is exact: 0.002 of the penumbra is what the 1024
/// samples of the reference leave.
const fn before_one_caster() -> Tolerance {
    areas(0.0001, 0.0001, 0.002, 0.005, "the reference takes 1024 samples")
}

const BEFORE_ONE_CASTER: Group = &[
    ("eye-in-shadow", before_one_caster()),
    ("near-clips-side", before_one_caster()),
    ("near-clips-corner", before_one_caster()),
    ("edge-through-centre/sun", before_one_caster()),
    ("single-quad", before_one_caster()),
];

/// The centre is inside: nothing outside sees it, and all of the light is taken to be hidden with it.
const CENTRE_INSIDE: Tolerance = areas(0.005, 1.0, 0.9, 0.95, FROM_THE_CENTRE);
/// What of the light is below the receiver's plane hides as much as what is above, and here it is half and more.
const fn below(leak_share: f64, rmse: f64, penumbra_rmse: f64) -> Tolerance {
    areas(leak_share, 0.001, rmse, penumbra_rmse, FROM_THE_CENTRE)
}

/// Silhouettes from the light's centre.
const WEDGES: Group = &[
    ("back-to-back-panels/double-sided", areas(0.0001, 0.004, 0.11, 0.6, LAYERS)),
    ("wide-band", below(0.012, 0.12, 0.15)),
    ("light-radius/3-m", areas(0.001, 0.001, 0.11, 0.6, FROM_THE_CENTRE)),
    ("light-radius/10-m", areas(0.001, 0.001, 0.11, 0.6, FROM_THE_CENTRE)),
    ("planar-no-caster/two-receivers", below(0.001, 0.085, 0.15)),
    ("soft-lamp-in-floor", below(0.006, 0.27, 0.33)),
    ("lamp-1e-9-over-face/1e-9-m-inside", CENTRE_INSIDE),
    ("lamp-1e-9-over-edge/1e-9-m-inside", CENTRE_INSIDE),
    ("lamp-1e-9-over-vertex/1e-9-m-inside", CENTRE_INSIDE),
    ("lamp-1e-9-over-face", areas(0.05, 0.001, 0.27, 0.65, FROM_THE_CENTRE)),
    ("lamp-1e-9-over-edge", areas(0.02, 0.006, 0.45, 0.6, FROM_THE_CENTRE)),
    ("lamp-1e-9-over-vertex", areas(0.03, 0.001, 0.4, 0.45, FROM_THE_CENTRE)),
    ("soft-lamp-on-edge", areas(0.012, 0.001, 0.47, 0.6, FROM_THE_CENTRE)),
    ("soft-lamp-on-corner", areas(0.01, 0.001, 0.4, 0.45, FROM_THE_CENTRE)),
    // What is edge-on to the centre is no silhouette from there, or one too many.
    ("lamp-in-far-plane", areas(0.001, 0.001, 0.075, 0.24, FROM_THE_CENTRE)),
    ("ortho-lamp-beside", areas(0.45, 0.55, 0.66, 0.67, FROM_THE_CENTRE)),
];

/// Sums of half floats behind glass.
const HALF_SUMS: Group = &[
    ("glass-on-box", half_sums(0.001)),
    ("glass-on-glass", half_sums(0.001)),
    ("coincident-panes", half_sums(0.003)),
];
