//! On which sides of an edge's triangles do the receivers of a cell and slice lie? Where all of them lie so that the edge is no
//! silhouette, it need not be listed there.
//!
//! A cell and a slice hold a piece of a pyramid (of a prism, for a directional light). Over it a plane's height is linear in the
//! place on the grid's plane and in the depth, each for itself: least and largest at corners. What the shader cannot tell by
//! its rounding, [`Piece::unsure`], is left open here too.

use glam::DVec3;
use shadowgraph_engine::geometry::LightPlane;

use super::chain::{AGAINST_1, AGAINST_2, BEFORE_ONLY, BEHIND_ONLY, SoftEdge};

/// A plane's height over points of a grid's plane: a sum of what is constant and what grows with the depth, both linear across.
#[derive(Clone, Copy, Debug, Default)]
struct Height {
    at: f64,
    at_across: [f64; 2],
    rate: f64,
    rate_across: [f64; 2],
}

/// The triangles at an edge, as the receivers that one plane of the grid shows see them.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeSides {
    heights: [Option<Height>; 2],
    bits: u32,
}

/// A part of a grid's plane, and of the depths behind it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// Its middle on the plane, where what is in view is within −1 … 1.
    pub middle: [f64; 2],
    /// Half its size.
    pub half: f64,
    /// The least and the largest depth: along the plane's axis from the light's centre; from the origin, for a direction.
    pub depths: [f64; 2],
    /// At less than this height over a plane, in metres, the shader may not know the side of it.
    pub unsure: f64,
}

impl EdgeSides {
    /// `edge` of the caster whose middle is `center`.
    pub(super) fn new(edge: &SoftEdge, center: DVec3, view: &LightPlane) -> Self {
        let [x, y] = [view.x_axis, view.y_axis].map(|axis| axis / axis.length_squared());
        let height = |plane: [f32; 4]| {
            let [a, b, c, offset] = plane.map(f64::from);
            let normal = DVec3::new(a, b, c);
            if normal == DVec3::ZERO {
                return None;
            }
            let over = |point: DVec3| normal.dot(point - center) - offset;
            let (across, away) = ([normal.dot(x), normal.dot(y)], normal.dot(view.away));
            Some(if view.z_axis == DVec3::ZERO {
                Height { at: over(view.origin), at_across: across, rate: away, ..Height::default() }
            } else {
                let from = view.origin - view.z_axis * view.z_offset;
                Height { at: over(from), rate: away, rate_across: across, ..Height::default() }
            })
        };
        Self { heights: [height(edge.plane_1), height(edge.plane_2)], bits: edge.bits }
    }

    /// Whether the edge may be a silhouette for a receiver in `piece`: whether it may weigh anything.
    pub(super) fn may_weigh(&self, piece: &Piece) -> bool {
        let mut weight = 0;
        for (height, against) in self.heights.iter().zip([AGAINST_1, AGAINST_2]) {
            let Some(height) = height else { continue };
            let [least, largest] = height.range(piece);
            let side = if least > piece.unsure {
                1
            } else if largest < -piece.unsure {
                -1
            } else {
                return true;
            };
            let counted = match self.bits & (BEHIND_ONLY | BEFORE_ONLY) {
                BEHIND_ONLY => side.min(0),
                BEFORE_ONLY => side.max(0),
                _ => side,
            };
            weight += if self.bits & against == 0 { counted } else { -counted };
        }
        weight != 0
    }
}

impl Height {
    /// The least and the largest over a piece.
    fn range(&self, piece: &Piece) -> [f64; 2] {
        let over = |middle: f64, across: [f64; 2]| {
            let spread = (across[0].abs() + across[1].abs()) * piece.half;
            let middle = middle + across[0] * piece.middle[0] + across[1] * piece.middle[1];
            [middle - spread, middle + spread]
        };
        let (at, rate) = (over(self.at, self.at_across), over(self.rate, self.rate_across));
        let [near, far] = piece.depths;
        // Where rates spread, depths are not negative.
        let [least, largest] = [0, 1].map(|end| [at[end] + near * rate[end], at[end] + far * rate[end]]);
        [least[0].min(least[1]), largest[0].max(largest[1])]
    }
}
