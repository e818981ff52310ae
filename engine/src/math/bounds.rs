//! Axis-aligned boxes in f64.

use glam::{DAffine3, DVec3};

/// An axis-aligned box. The empty box has `min > max` and is the neutral element of [`Aabb::union`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The smallest corner.
    pub min: DVec3,
    /// The largest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The box that contains nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn from_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        points
            .into_iter()
            .fold(Self::EMPTY, |bounds, p| Self { min: bounds.min.min(p), max: bounds.max.max(p) })
    }

    /// Whether the box contains no point at all.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box grown by `margin` on every side; the empty box stays empty.
    #[must_use]
    pub fn expanded(&self, margin: f64) -> Self {
        if self.is_empty() {
            return *self;
        }
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// The middle of the box; zero for the empty box.
    pub fn center(&self) -> DVec3 {
        if self.is_empty() { DVec3::ZERO } else { self.min.midpoint(self.max) }
    }

    /// Half the diagonal: the radius of the sphere around the centre that contains the box.
    pub fn radius(&self) -> f64 {
        if self.is_empty() { 0.0 } else { (self.max - self.min).length() * 0.5 }
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            DVec3::new(
                if i & 1 == 0 { self.min.x } else { self.max.x },
                if i & 2 == 0 { self.min.y } else { self.max.y },
                if i & 4 == 0 { self.min.z } else { self.max.z },
            )
        })
    }

    /// The box around this box's image under `transform`.
    #[must_use]
    pub fn transformed(&self, transform: &DAffine3) -> Self {
        if self.is_empty() {
            return *self;
        }
        Self::from_points(self.corners().map(|corner| transform.transform_point3(corner)))
    }

    /// Whether `point` lies in the box or on it.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// Whether the two boxes have a point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Whether the closed segment `from + t·(to − from)`, t ∈ \[0, 1\], touches the box.
    pub fn intersects_segment(&self, from: DVec3, to: DVec3) -> bool {
        self.intersects_ray(from, to - from, 1.0)
    }

    /// Whether `from + t·direction`, t ∈ \[0, `t_max`\], touches the box (slab test; a zero component counts as
    /// parallel to its slab).
    pub fn intersects_ray(&self, from: DVec3, direction: DVec3, t_max: f64) -> bool {
        if self.is_empty() {
            return false;
        }
        let (mut t_enter, mut t_leave) = (0.0_f64, t_max);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if from[axis] < self.min[axis] || from[axis] > self.max[axis] {
                    return false;
                }
                continue;
            }
            let t0 = (self.min[axis] - from[axis]) / direction[axis];
            let t1 = (self.max[axis] - from[axis]) / direction[axis];
            t_enter = t_enter.max(t0.min(t1));
            t_leave = t_leave.min(t0.max(t1));
        }
        t_enter <= t_leave
    }

    /// The distance from `point` to the nearest point of the box; 0 inside, infinite for the empty box.
    pub fn distance(&self, point: DVec3) -> f64 {
        if self.is_empty() {
            return f64::INFINITY;
        }
        (point - point.clamp(self.min, self.max)).length()
    }
}
