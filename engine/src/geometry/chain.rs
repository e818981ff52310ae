//! The chain of a shadow volume: the weighted side quads and caps that bound what one caster darkens.
//!
//! For a light L = (l, w), w = 1 a point at l and w = 0 a direction l *towards* the light, every triangle T has a
//! facing sign s_T, decided once ([`facing_signs`]). Every edge e = (p < q) then has the weight
//! m_e = Σ s_T·σ(T, e) over the triangles that use it. With v∞ = (w·v − l, 0) the chain consists of
//!
//! * side quads (q, p, p∞, q∞), m_e times,
//! * front caps s_T·(a, b, c),
//! * far caps s_T·(a∞, c∞, b∞), none for w = 0, where all v∞ coincide and sides are single triangles.
//!
//! *Orientation.* Quads and caps are wound outwards: seen from outside the volume they run counter-clockwise. A ray
//! that crosses one whose front faces the eye *enters* a volume: +1; one that shows its back: −1. A triangle seen
//! counter-clockwise by the light (s = +1) keeps its winding as the front cap; its edge a→b is followed by the cap,
//! so the side quad runs along it from b to a.
//!
//! *Why it cannot leak.* The sides are the boundary operator applied to the caps, so the chain is closed for **any**
//! integers s_T. A wrong facing sign changes the shadow of that one triangle and never leaves a streak. Nothing is
//! asked of the mesh: inconsistent winding is harmless (flipping T flips both s_T and σ), edges may have any number
//! of triangles, boundaries are edges with one. The count at a point P is the number of triangles with s ≠ 0 that
//! the segment from P to the light crosses.
//!
//! *Sets of triangles.* s_T = 0 drops a triangle from its three edges and from both caps. Casting with some of the
//! triangles is therefore casting with some of the signs: [`Orientation::lit_only`](super::Orientation::lit_only)
//! for closed casters, [`restricted_signs`] for the groups of a caster with more layers than a counter holds.
//!
//! Source: Bergeron 1986 for the weights ±2, ±1, 0 of general polygons, here for edges of any valence.

use glam::{DVec3, DVec4};
use rayon::prelude::*;

use super::topology::TwoUses;
use super::{Edge, Topology};
use crate::math::facing_sign;

/// Under this many elements work is not worth handing to another thread.
pub(super) const MIN_PARALLEL: usize = 4096;

/// The facing sign s_T ∈ {−1, 0, +1} of every triangle towards the homogeneous `light`: +1 when the light sees it
/// counter-clockwise, 0 when edge-on or without area.
///
/// `triangles` are corners as indices into `p_in_world`, best the welded ones of [`Topology::triangles`].
///
/// # Panics
/// When a corner is out of range.
pub fn facing_signs(p_in_world: &[DVec3], triangles: &[[u32; 3]], light: DVec4) -> Vec<i8> {
    triangles
        .par_iter()
        .with_min_len(MIN_PARALLEL)
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| p_in_world[corner as usize]);
            facing_sign(a, b, c, light) as i8
        })
        .collect()
}

/// The signs of the listed triangles, 0 for all others; numbers out of range are passed over.
#[must_use]
pub fn restricted_signs(signs: &[i8], triangles: impl IntoIterator<Item = u32>) -> Vec<i8> {
    let mut restricted = vec![0; signs.len()];
    for triangle in triangles {
        if let Some(sign) = signs.get(triangle as usize) {
            restricted[triangle as usize] = *sign;
        }
    }
    restricted
}

/// The chain of one caster and one light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chain {
    /// The side quads: \[p, q\] stands for the quad (q, p, p∞, q∞) with weight +1, wound outwards. p and q are
    /// welded vertices, not in ascending order: an edge of negative weight is listed turned. An edge of weight ±k is
    /// listed k times in a row.
    pub sides: Vec<[u32; 2]>,
    /// The triangles with s = +1, ascending: front cap (a, b, c), far cap (a∞, c∞, b∞).
    pub caps_front: Vec<u32>,
    /// The triangles with s = −1, ascending: the same caps with weight −1, that is wound the other way round.
    pub caps_back: Vec<u32>,
    /// The number of different edges in `sides`.
    pub silhouette_edges: usize,
    /// The largest |m_e|; 0 for the empty chain.
    pub max_edge_weight: u32,
}

impl Chain {
    /// Extracts the chain of `topology` with the given facing signs (of which only the sign counts; triangles beyond
    /// the end of the slice have 0).
    pub fn extract(topology: &Topology, signs: &[i8]) -> Self {
        let sign_of = |triangle: u32| signs.get(triangle as usize).map_or(0, |sign| i32::from(sign.signum()));
        // Loops, here and wherever every edge or triangle is met: chains of iterators took several times as long.
        let weigh = |(chunk, edges): (usize, &[Edge])| {
            let mut weighted = Vec::new();
            let first = chunk * MIN_PARALLEL;
            for ((index, edge), uses) in (first..).zip(edges).zip(&topology.two_uses()[first..]) {
                let weight = match TwoUses::unpacked(*uses) {
                    Some([a, b]) => sign_of(a.triangle) * a.sigma + sign_of(b.triangle) * b.sigma,
                    None => topology.uses(index).iter().map(|u| sign_of(u.triangle) * u.sigma).sum(),
                };
                if weight != 0 {
                    let side = if weight > 0 { [edge.p, edge.q] } else { [edge.q, edge.p] };
                    weighted.push((side, weight.unsigned_abs()));
                }
            }
            weighted
        };
        let chunks: Vec<_> = topology.edges().par_chunks(MIN_PARALLEL).enumerate().map(weigh).collect();
        let weighted = chunks.concat();
        let half = topology.triangles().len() / 2;
        let [mut caps_front, mut caps_back] = [Vec::with_capacity(half), Vec::with_capacity(half)];
        for (triangle, sign) in signs.iter().enumerate().take(topology.triangles().len()) {
            match sign.signum() {
                1 => caps_front.push(triangle as u32),
                -1 => caps_back.push(triangle as u32),
                _ => {}
            }
        }
        Self {
            sides: weighted
                .iter()
                .flat_map(|&(side, weight)| std::iter::repeat_n(side, weight as usize))
                .collect(),
            caps_front,
            caps_back,
            silhouette_edges: weighted.len(),
            max_edge_weight: weighted.iter().map(|(_, weight)| *weight).max().unwrap_or(0),
        }
    }

    /// Whether it darkens nothing.
    pub fn is_empty(&self) -> bool {
        self.sides.is_empty() && self.caps_front.is_empty() && self.caps_back.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const FROM_ABOVE: DVec4 = DVec4::new(0.0, 0.0, 1.0, 0.0);

    fn chain_of(positions: &[Vec3], indices: &[u32]) -> Chain {
        let topology = Topology::new(positions, indices);
        let p_in_world: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
        Chain::extract(&topology, &facing_signs(&p_in_world, topology.triangles(), FROM_ABOVE))
    }

    #[test]
    fn sides_follow_the_lit_triangle() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let chain = chain_of(&positions, &[0, 1, 2]);
        assert_eq!(chain.sides, [[0, 1], [2, 0], [1, 2]]);
        assert_eq!((chain.caps_front, chain.caps_back), (vec![0], vec![]));
        // Wound the other way it is the same volume, its caps with the opposite weight.
        let turned = chain_of(&positions, &[0, 2, 1]);
        assert_eq!(turned.sides, [[0, 1], [2, 0], [1, 2]]);
        assert_eq!((turned.caps_front, turned.caps_back), (vec![], vec![0]));
    }

    #[test]
    fn weights_add_up_and_cancel() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE];
        // The same face twice, once turned: every side twice.
        let double = chain_of(&positions, &[0, 1, 2, 0, 2, 1]);
        assert_eq!(double.sides, [[0, 1], [0, 1], [2, 0], [2, 0], [1, 2], [1, 2]]);
        assert_eq!((double.silhouette_edges, double.max_edge_weight), (3, 2));
        // Two lit neighbours, wound the same way and not: the common edge (1, 2) is no silhouette.
        for second in [[1, 3, 2], [1, 2, 3]] {
            let chain = chain_of(&positions, &[[0, 1, 2], second].concat());
            assert_eq!(chain.sides, [[0, 1], [2, 0], [1, 3], [3, 2]]);
        }
    }

    #[test]
    fn edge_on_and_collapsed_triangles_cast_nothing() {
        let positions = [Vec3::ZERO, Vec3::X, Vec3::Z];
        assert!(chain_of(&positions, &[0, 1, 2, 0, 0, 1, 1, 1, 1]).is_empty());
        assert!(chain_of(&[], &[]).is_empty());
        assert_eq!(restricted_signs(&[1, -1, 1], [2, 1, 9]), [0, -1, 1]);
    }
}
