//! What a comparison comes to, in one word.

use std::fmt;

use super::metrics::{CompareError, LightError};

/// What the errors of a light say about the technique.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Every pixel that was compared is right.
    Exact,
    /// Nothing was compared: no surface is in view, or within the light's range and cone, or turned but edge-on to it.
    NothingCompared,
    /// Some pixels are off, but the technique approximates by design, or takes no samples that would have to be right: the
    /// errors say how well it does.
    Approximates,
    /// Technique and reference see different surfaces at too many pixels for the rest to say anything.
    SeesOtherSurfaces,
    /// The ambiguity band is wider than it may be.
    BandTooWide,
    /// Some pixels are wrong.
    Wrong,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Exact => "ok",
            Self::NothingCompared => "nothing compared",
            Self::Approximates => "approximates",
            Self::SeesOtherSurfaces => "other surfaces",
            Self::BandTooWide => "band too wide",
            Self::Wrong => "FAILS",
        })
    }
}

impl LightError {
    /// The verdict on these errors. A technique that takes samples is judged by them even when compared with the
    /// whole light: a light has one verdict.
    pub fn verdict(&self) -> Verdict {
        let is_right = self.wrong_outside_band == 0 && self.outside_bounds == 0;
        match self.by_samples {
            Some(verdict) => verdict,
            None if !self.sees_same() => Verdict::SeesOtherSurfaces,
            None if self.compared == 0 => Verdict::NothingCompared,
            None if self.band_too_wide => Verdict::BandTooWide,
            None if is_right => Verdict::Exact,
            None if self.is_converged || self.approximates => Verdict::Approximates,
            None => Verdict::Wrong,
        }
    }

    /// Whether this is what an exact technique must deliver: something was compared, nearly everywhere the same
    /// surface was seen, the band is no wider than it may be, and nothing is wrong outside it.
    pub fn passes(&self) -> bool {
        self.verdict() == Verdict::Exact
    }

    /// Whether an exact technique must not deliver this; nothing compared is neither passed nor failed.
    pub fn fails(&self) -> bool {
        !matches!(self.verdict(), Verdict::Exact | Verdict::NothingCompared)
    }
}

/// Refuses comparisons in which there was no shadow to get wrong: without dark pixels in the reference a test cannot
/// fail, and without dark pixels in the measured picture the technique has done nothing.
///
/// # Errors
/// [`CompareError::NothingCompared`] and [`CompareError::NoShadow`], for the first light concerned.
pub fn expect_shadow(errors: &[LightError]) -> Result<(), CompareError> {
    for error in errors {
        let light = error.name.clone();
        if error.compared == 0 {
            return Err(CompareError::NothingCompared { light });
        }
        let compared = error.compared;
        for (picture, count) in
            [("reference", error.shadow_pixels), ("measured picture", error.measured_shadow_pixels)]
        {
            if count == 0 {
                return Err(CompareError::NoShadow { light, picture, compared });
            }
        }
    }
    Ok(())
}
