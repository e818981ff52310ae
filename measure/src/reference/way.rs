//! All ways from a receiver's point to a light's disc, with what the moves of the ambiguity band do to them.

use glam::{DVec2, DVec3, DVec4};
use shadowgraph_engine::shadow::{LightDisc, LightSize};

use super::bvh::{Bvh, Cone};
use super::forms::Form;
use super::moved::{CORNERS, MOVES, Moved};
use super::surface::Triangle;
use super::tracer::CasterSet;

/// Rounding of forms and of what they stand in for, in shares of the products they are sums of: some tens of roundings.
pub(crate) const ROUNDING: f64 = 1e-14;

/// All ways from a receiver's point, and its moved copies, to the light.
pub(crate) struct Way<'a> {
    pub(crate) moved: &'a Moved<'a>,
    pub(crate) casters: &'a CasterSet,
    pub(crate) light: DVec4,
    /// The point with the margins that cover its moves, then the point and each moved copy by itself.
    aims: [Aim; 1 + MOVES + CORNERS],
    /// The disc that the unmoved point sees.
    disc: LightDisc,
    /// Whether samples lie anywhere, as far as the moves can tell.
    pub(crate) unsettled: bool,
}

/// All ways from one point to the disc that it sees.
pub(crate) struct Aim {
    pub(crate) point: DVec3,
    /// From the point to the disc's centre, and to where the disc's axes end from there.
    pub(crate) to_center: DVec3,
    pub(crate) axes: [DVec3; 2],
    /// The disc's radius.
    pub(crate) radius: f64,
    /// How far the point moves, and how far a sample.
    pub(crate) point_moves: f64,
    pub(crate) sample_moves: f64,
}

/// A disc is unsettled when its samples move by more than this share of its radius.
const UNSETTLED: f64 = 1.0 / 16.0;

impl<'a> Way<'a> {
    pub(crate) fn new(size: LightSize, casters: &'a CasterSet, light: DVec4, moved: &'a Moved<'a>) -> Self {
        let points = moved.everywhere();
        let center = points[0];
        let position = light.truncate();
        let to_light = |point: DVec3| position - point * light.w;
        let discs = points.map(|point| size.disc(to_light(point).extend(light.w)));
        let axes = |disc: &LightDisc| [disc.u * disc.radius, disc.v * disc.radius];
        let own = axes(&discs[0]);
        let turns = discs.iter().map(axes).map(|[u, v]| (u - own[0]).length() + (v - own[1]).length());
        let sample_moves = turns.fold(0.0, f64::max);
        let point_moves = points.iter().map(|point| point.distance(center)).fold(0.0, f64::max);
        let aim = |index: usize, moves: [f64; 2]| Aim {
            point: points[index],
            to_center: to_light(points[index]),
            axes: axes(&discs[index]),
            radius: discs[index].radius,
            point_moves: moves[0],
            sample_moves: moves[1] + 1e-15 * (position.length() + discs[index].radius),
        };
        Self {
            moved,
            casters,
            light,
            aims: std::array::from_fn(|index| match index.checked_sub(1) {
                None => aim(0, [point_moves, sample_moves]),
                Some(index) => aim(index, [0.0; 2]),
            }),
            disc: discs[0],
            unsettled: sample_moves > discs[0].radius * UNSETTLED,
        }
    }

    /// The disc that the unmoved point sees.
    pub(crate) fn disc(&self) -> &LightDisc {
        &self.disc
    }

    /// The point with all its moves.
    pub(crate) fn all_moves(&self) -> &Aim {
        &self.aims[0]
    }

    /// The point alone, or one of its moved copies.
    pub(crate) fn move_alone(&self, index: usize) -> &Aim {
        &self.aims[index + 1]
    }

    /// Everything between the point, wherever it moves, and the disc.
    pub(crate) fn cone(&self, bvh: &Bvh) -> Cone {
        let aim = self.all_moves();
        let spread = |axis: usize| aim.axes[0][axis].hypot(aim.axes[1][axis]) + aim.sample_moves;
        let far_m = DVec3::new(spread(0), spread(1), spread(2));
        bvh.cone(aim.point, aim.point_moves, aim.to_center, far_m, self.light.w != 0.0)
    }

    /// Where a moved point sees `sample`.
    pub(crate) fn sample(&self, index: usize, sample: DVec2) -> DVec4 {
        let [u, v] = self.move_alone(index).axes;
        self.light + (u * sample.x + v * sample.y).extend(0.0)
    }
}

impl Aim {
    /// The largest distance of a sample from the point, and of one from `corner`.
    pub(crate) fn reach(&self, corner: DVec3, light: DVec4) -> [f64; 2] {
        let beyond = self.radius + self.sample_moves;
        let length = self.to_center.length() + beyond;
        [length, if light.w == 0.0 { length } else { corner.distance(light.truncate()) + beyond }]
    }

    /// How `normal` · sample changes over the disc, from `center` on.
    pub(crate) fn form(&self, center: f64, normal: DVec3, margin: f64) -> Form {
        Form::new(center, DVec2::new(normal.dot(self.axes[0]), normal.dot(self.axes[1])), margin)
    }

    /// On which side of `triangle` samples lie.
    pub(crate) fn light_side(&self, triangle: &Triangle, light: DVec4, moves: f64) -> Form {
        let normal = triangle.normal();
        let corner = triangle.corners[0];
        let center = normal.dot(light.truncate() - corner * light.w);
        let [_, reach] = self.reach(corner, light);
        let rounding = ROUNDING * reach * triangle.edges_product();
        self.form(center, normal, normal.length() * (self.sample_moves + moves) + rounding)
    }
}
