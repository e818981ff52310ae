//! What is known to be wrong, and why: all of it, so that nothing else is excused; and what is tried less than fully. The README
//! has it in full (`known_docs`). What has become right fails the test that tries it.

use super::tolerances::{HARD, PLANAR, SOFT};

/// A case or step of a sweep that is known to be wrong, and why. It still runs, so that mending it shows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Known {
    /// The technique's type name.
    pub(crate) technique: &'static str,
    /// The settings.
    pub(crate) settings: &'static [&'static str],
    /// Full names of cases or steps, or the ids of all variants of a case.
    pub(crate) cases: &'static [&'static str],
    /// Why, and what the cure would be.
    pub(crate) why: &'static str,
}

impl Known {
    /// Whether it is about this technique, setting and case.
    pub(crate) fn is_about(&self, technique: &str, setting: &str, case: &str) -> bool {
        let id = case.split('/').next().unwrap_or_default();
        self.technique == technique
            && self.settings.contains(&setting)
            && (self.cases.contains(&case) || self.cases.contains(&id))
    }
}

/// Every known issue. One that is no longer wrong anywhere has to be struck out.
pub(crate) const KNOWN: &[Known] = &[Known {
    technique: PLANAR,
    settings: &["default"],
    cases: &["scale/1e3", "light-angle/0.01-deg"],
    why: "texels are several times wider than penumbrae: pixels at the edge are off by up to half of one",
}];

/// What is known to be wrong on hard cases: everything listed here, and nothing else.
pub(crate) const KNOWN_ON_CASES: &[Known] = &[
    Known {
        technique: PLANAR,
        settings: &["default"],
        cases: &[
            "map-grazing/1-deg",
            "thin-receiver/grazing-floor",
            "room-through-culled-walls/turned-by-node",
        ],
        why: "texels are long where light grazes, and wider than penumbrae are",
    },
    Known {
        technique: PLANAR,
        settings: &["direct 64", "direct 256"],
        cases: &["1x1/64x1"],
        why: "half of one pixel of 52 is more than the bound for whole frames",
    },
    Known {
        technique: SOFT,
        settings: &["per-receiver"],
        cases: &[
            "soft-lamp-on-edge/5-m",
            "soft-lamp-on-edge/5-m-in-the-air",
            "soft-lamp-on-corner/5-m",
            "soft-lamp-on-corner/5-m-in-the-air",
            "soft-lamp-on-corner/1e-6-m-ortho",
        ],
        why: "areas of a disc of a micrometre keep few digits, and on the edge of the light's own sphere no bound of areas holds",
    },
    Known {
        technique: HARD,
        settings: &["cap"],
        cases: &["road-50km/turned-by-node"],
        why: "the lid of a flat road lies in the road's own plane, and its triangles are thinner than a pixel: depths of the two \
              agree to fewer digits than a tie needs",
    },
];

/// Fixed seeds of the random search that are known to be wrong, and why.
pub(crate) const KNOWN_SEEDS: &[(u64, &str)] = &[];

/// A case on which pixels may be outside their bounds under large lights (`soft_shadows`).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tolerated {
    /// The case's id.
    pub(crate) case: &'static str,
    /// How many pixels, of a light.
    pub(crate) pixels: usize,
    /// Why.
    pub(crate) why: &'static str,
}

const TWO_CREASES: &str = "on stacks of boxes a quarter of a millimetre thin, points within rounding of two creases at once, \
    which the bounds' six moves do not all reach";

/// All of them. With the default size there is none.
pub(crate) const TOLERATED: &[Tolerated] = &[
    Tolerated { case: "overlap-2049", pixels: 20, why: TWO_CREASES },
    Tolerated { case: "overlap-4096", pixels: 20, why: TWO_CREASES },
];

/// What compares ways to one picture, and large lights, take one case in so many of all.
pub(crate) const COMPARED_ONE_CASE_IN: usize = 3;
/// A sweep is tried at one step in so many, and at its last.
pub(crate) const SWEPT_ONE_STEP_IN: usize = 2;
/// The technique from outside is tried on one case in so many.
pub(crate) const OUTSIDE_ONE_CASE_IN: usize = 10;
