//! Oriented planes in f64.

use glam::DVec3;

/// The oriented plane {x : normal·x = offset}; its positive side is where normal·x > offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// The plane's normal; unit length unless a function says otherwise.
    pub normal: DVec3,
    /// The signed distance of the plane from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// The plane through `point` with `normal`, which is normalised; a zero normal gives the all-zero plane.
    pub fn through(point: DVec3, normal: DVec3) -> Self {
        let normal = normal.normalize_or_zero();
        Self { normal, offset: normal.dot(point) }
    }

    /// The signed distance of `point`: positive on the side the normal points to.
    pub fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }
}
