//! Which lines part two triangles in one plane.

use glam::DVec2;

/// An edge of a triangle, and how far beyond it each corner of another one is; negative on its own side.
pub struct Parting {
    /// Where the edge begins.
    pub from: DVec2,
    /// Where it ends.
    pub to: DVec2,
    /// How far beyond it the other's corners are.
    pub beyond_m: [f64; 3],
}

impl Parting {
    /// How far beyond the edge the other begins: two triangles overlap by as much as this is below 0 at the edge, of either, where
    /// it is most.
    pub fn gap_m(&self) -> f64 {
        self.beyond_m.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// The edges of `own`, and where `other` is to them. An edge that is a point parts from everything.
pub fn partings(own: [DVec2; 3], other: [DVec2; 3]) -> impl Iterator<Item = Parting> {
    [(0, 1, 2), (1, 2, 0), (2, 0, 1)].into_iter().map(move |(from, to, opposite)| {
        let across = (own[to] - own[from]).perp().normalize_or_zero();
        let outwards = if across.dot(own[opposite] - own[from]) > 0.0 { -across } else { across };
        let beyond_m = other.map(|corner| outwards.dot(corner - own[from]));
        Parting { from: own[from], to: own[to], beyond_m }
    })
}
