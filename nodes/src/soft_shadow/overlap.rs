//! Whether a receiver's surface lies on itself: walls of no thickness, faces modelled twice, one mesh in another's plane.
//!
//! There more than one triangle may have the very depth that is seen, and a pixel's light would be multiplied for each.
//! Which triangle is seen then has to be asked for, and only then.

use glam::DVec2;
use shadowgraph_engine::scene::SceneSnapshot;

use super::receivers::Receiver;
use crate::common::parting::partings;

/// Triangles that lie on each other by less than this share of the receiver's extent only touch: far more than f64 leaves
/// of an edge that two share, far less than any pixel.
const TOUCHING: f64 = 1e-9;

impl Receiver {
    /// Whether two of its opaque triangles overlap.
    pub(super) fn overlaps_itself(&self, snapshot: &SceneSnapshot) -> bool {
        let normal = self.flat.plane.normal;
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let mut origin = None;
        let mut triangles = Vec::new();
        for instance in self.instances.iter().map(|index| &snapshot.instances[*index]) {
            let parts = instance.mesh.data().parts.iter().zip(&instance.materials);
            let opaque = parts.filter(|(_, material)| material.is_opaque());
            for triangle in opaque.flat_map(|(part, _)| part.triangles.clone()) {
                let corners = instance.world_triangle(triangle as usize);
                // Near its own origin, so that far from the world's no digits are lost.
                let origin = *origin.get_or_insert(corners[0]);
                triangles.push(Flattened::new(corners.map(|p| {
                    let d = p - origin;
                    DVec2::new(d.dot(u), d.dot(v))
                })));
            }
        }
        let low = triangles.iter().map(|t| t.low).fold(DVec2::INFINITY, DVec2::min);
        let high = triangles.iter().map(|t| t.high).fold(DVec2::NEG_INFINITY, DVec2::max);
        let touching = TOUCHING * (high - low).max_element();
        triangles.sort_by(|a, b| a.low.x.total_cmp(&b.low.x));
        (0..triangles.len()).any(|i| {
            let first = &triangles[i];
            let near = triangles[i + 1..].iter().take_while(|t| t.low.x < first.high.x - touching);
            near.into_iter().any(|second| first.overlaps(second, touching))
        })
    }
}

/// A triangle in its plane.
struct Flattened {
    corners: [DVec2; 3],
    low: DVec2,
    high: DVec2,
}

impl Flattened {
    fn new(corners: [DVec2; 3]) -> Self {
        let [a, b, c] = corners;
        Self { corners, low: a.min(b).min(c), high: a.max(b).max(c) }
    }

    /// Whether the two share more than a margin: whether no edge of either parts them.
    fn overlaps(&self, other: &Self, touching: f64) -> bool {
        let apart = self.low.y > other.high.y - touching || other.low.y > self.high.y - touching;
        let covers = self.covers(touching) && other.covers(touching);
        !apart && covers && !self.is_parted_from(other, touching) && !other.is_parted_from(self, touching)
    }

    /// Whether it is wider than a margin: a line covers nothing, whatever crosses it.
    fn covers(&self, touching: f64) -> bool {
        let [a, b, c] = self.corners;
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        (b - a).perp_dot(c - a).abs() > touching * longest
    }

    // Only triangles that cover something are asked, so no edge is a point.
    fn is_parted_from(&self, other: &Self, touching: f64) -> bool {
        partings(self.corners, other.corners).any(|edge| edge.gap_m() >= -touching)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangle(corners: [[f64; 2]; 3]) -> Flattened {
        Flattened::new(corners.map(DVec2::from))
    }

    #[test]
    fn neighbours_touch_and_others_overlap() {
        let first = triangle([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        let across_an_edge = triangle([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        let at_a_corner = triangle([[0.0, 1.0], [1.0, 1.0], [0.0, 2.0]]);
        let same = triangle([[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        let within = triangle([[0.1, 0.1], [0.2, 0.1], [0.1, 0.2]]);
        let line = triangle([[0.1, 0.1], [0.2, 0.2], [0.3, 0.3]]);
        for (other, expected) in
            [(across_an_edge, false), (at_a_corner, false), (same, true), (within, true), (line, false)]
        {
            assert_eq!(first.overlaps(&other, 1e-9), expected, "{:?}", other.corners);
            assert_eq!(other.overlaps(&first, 1e-9), expected, "{:?}", other.corners);
        }
    }
}
