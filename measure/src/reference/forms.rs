//! How a triangle stands before a disc: linear functions over it, and what they settle.

use glam::DVec2;

use super::samples::Group;

/// A linear function over the unit disc, and what it may be off.
#[derive(Clone, Copy)]
pub(crate) struct Form {
    center: f64,
    slope: DVec2,
    /// How far it rises from the disc's centre.
    rise: f64,
    pub(crate) margin: f64,
}

impl Form {
    /// Positive beyond doubt.
    pub(crate) const EVERYWHERE: Self = Self { center: 1.0, slope: DVec2::ZERO, rise: 0.0, margin: 0.0 };

    pub(crate) fn new(center: f64, slope: DVec2, margin: f64) -> Self {
        Self { center, slope, rise: slope.length() * (1.0 + 1e-12), margin }
    }

    pub(crate) fn times(self, sign: f64) -> Self {
        Self { center: self.center * sign, slope: self.slope * sign, ..self }
    }

    /// The smallest and the largest value.
    pub(crate) fn range(&self) -> [f64; 2] {
        [self.center - self.rise, self.center + self.rise]
    }

    /// The smallest and the largest value within a group.
    #[inline(always)]
    pub(crate) fn range_in(&self, group: &Group) -> [f64; 2] {
        let (center, rise) = (self.at(group.center), self.rise * group.radius);
        [center - rise, center + rise]
    }

    #[inline(always)]
    pub(crate) fn at(&self, sample: DVec2) -> f64 {
        self.center + self.slope.dot(sample)
    }

    /// +1 or −1 where the value's sign is beyond doubt.
    #[inline(always)]
    pub(crate) fn sign_of(&self, value: f64) -> i32 {
        i32::from(value > self.margin) - i32::from(value < -self.margin)
    }
}

/// A triangle that may stand before part of the disc.
pub(crate) struct Partial {
    pub(crate) place: u32,
    /// Where what each move says of it by itself begins, once that was asked.
    pub(crate) moves: Option<u32>,
    /// The three edges and the side of the light, positive where the triangle is in the way. The side is 1 everywhere
    /// where on which side the point lies is open: then edges only exclude, by different signs.
    pub(crate) forms: [Form; 4],
    /// Whether it may have holes: then forms only exclude.
    pub(crate) is_masked: bool,
    /// On which side of its plane the point lies is open.
    pub(crate) open: bool,
}

impl Partial {
    /// Whether it stands before `sample`, but for holes, where the forms settle that.
    #[inline(always)]
    pub(crate) fn decides(&self, sample: DVec2) -> Option<bool> {
        let mut all_clear = !self.open;
        let mut excluding = [false; 2];
        for form in &self.forms {
            let value = form.at(sample);
            if value < -form.margin {
                excluding[0] = true;
                if !self.open || excluding[1] {
                    return Some(false);
                }
            } else if value <= form.margin {
                all_clear = false;
            } else if self.open && form.slope != DVec2::ZERO {
                // The side of the light, which is 1 everywhere, excludes nothing.
                excluding[1] = true;
                if excluding[0] {
                    return Some(false);
                }
            }
        }
        all_clear.then_some(true)
    }
}

impl Partial {
    /// The same for all samples of a group at once.
    pub(crate) fn decides_all(&self, group: &Group) -> Option<bool> {
        let mut all_clear = !self.open;
        let mut excluding = [false; 2];
        for form in &self.forms {
            let [least, largest] = form.range_in(group);
            excluding[0] |= largest < -form.margin;
            excluding[1] |= least > form.margin && form.slope != DVec2::ZERO;
            all_clear &= least > form.margin;
        }
        if excluding[0] && (!self.open || excluding[1]) {
            return Some(false);
        }
        all_clear.then_some(true)
    }
}

pub(crate) enum Class {
    Misses,
    Covers,
    Partly(Partial),
}
