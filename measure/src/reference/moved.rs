//! A receiver's point and the copies of it that the ambiguity band asks about (see [`super::render`]).
//!
//! **Depth** is off by rounding ([`DEPTH_ULPS`]) and by the snap of the triangle's own corners. A rasteriser draws the
//! triangle of the snapped corners sᵢ + εᵢ, each component of εᵢ at most [`CORNER_SNAP`], with the depth dᵢ of the exact
//! ones. Depth is a linear function over the target: exactly d, with gradient ∇d; drawn d′. Their difference g = d′ − d
//! is linear too, and at a snapped corner it is dᵢ − d(sᵢ + εᵢ) = −∇d·εᵢ. A pixel that shows the triangle is a mean of the snapped
//! corners, Σ λᵢ (sᵢ + εᵢ) with λᵢ ≥ 0 and Σ λᵢ = 1, so g there is −∇d·ε̄ with ε̄ = Σ λᵢ εᵢ, no larger than a single snap:
//!
//! > **the depth of a pixel is the exact depth of a place within one snap of it**, however thin the triangle is.
//!
//! This is no estimate. On a triangle seen from the front it is about as much as rounding; on one seen edge-on, an eighth of a
//! pixel thin, it is a share of the whole triangle, which no fixed number of ulps is. It also holds
//! where the near plane cuts the triangle: the corners that are snapped then lie on the same plane, and that is all that
//! was used. And since d′ is a mean of the dᵢ, depth never leaves the range of the triangle's own corners.
//!
//! On what is thicker than a pixel ε̄ is much the same for all pixels around: the snap shifts the surface, with the edges from
//! which shadows hang, and shifts are what the moves sideways stand for. So depth is moved by a snap only where the surface
//! is [thinner than a pixel](thickness_px): there one pixel's ε̄ says nothing of the next one's.
//!
//! **Far corners.** Positions are f32 from the eye. Of a corner at distance R they keep what is more than about [`POSITION_LOSS`]·R:
//! a coordinate's last digit, which a transform's products and sums may cost. That is far less than the snap, but for triangles that
//! reach far beyond what is seen of them: on a strip of 30 km, seen at a centimetre a pixel, it is a dozen snaps. There all
//! moves are longer by that much.
//!
//! **Its own shadow.** Behind its triangle a point is in that triangle's shadow, which does not count: cap and surface have
//! the same depth, however it is off. The sides of that shadow have not. Where depth moves a point so far that it comes
//! out of its own shadow through a side, next to an edge of the triangle, that side is before it or behind it by the snap alone.

use glam::{DVec3, DVec4};

use super::render::{CORNER_SNAP, DEPTH_ULPS, PIXEL_MOVE};
use super::surface::Triangle;
use super::ties::{InPlane, Rim};
use super::tracer::{CasterSet, Hit, Reference};
use super::view::View;

/// The centre, four moves on the plane, two in depth.
pub(crate) const MOVES: usize = 7;

/// Points moved in all three ways at once.
pub(crate) const CORNERS: usize = 8;

/// A receiver point and its moved copies.
pub(crate) struct Moved<'a> {
    /// What the point lies on.
    pub(crate) surface: &'a Triangle,
    /// The last two are those moved in depth.
    pub(crate) points: [DVec3; MOVES],
    /// Moved up or down, left or right and in depth: the corners of the box that the moves span. A sample next to two
    /// edges at once may see between them from there alone.
    pub(crate) corners: [DVec3; CORNERS],
    /// Some move led nowhere; its point is then the centre's.
    pub(crate) lost: bool,
    /// Whether the snap of the triangle's corners moves depth further than rounding does.
    pub(crate) is_tilted: bool,
    /// The side on which the eye is.
    pub(crate) eye_side: i32,
    /// Where the camera is.
    pub(super) position: DVec3,
    /// How far the snap moves a point at its distance, across the view.
    pub(super) snap_m: f64,
    /// How many times as long as the snap the moves are: more than 1 where corners are far away.
    pub(super) longer: f64,
    /// Where casters' surfaces in its plane end, as far as anybody has looked.
    pub(crate) rims: Vec<Rim<'a>>,
    /// Whether the surface itself ends within its moves, as far as anybody has looked.
    pub(crate) at_edge: bool,
}

impl<'a> Moved<'a> {
    pub(crate) fn new(
        reference: &'a Reference,
        view: &View<'_>,
        place: [f64; 2],
        hit: Hit,
        t: f64,
    ) -> Option<Self> {
        Some(Self::on(reference.surface(hit)?, view, place, t))
    }

    /// The point that the ray through a place of the target meets at distance `t`, on `surface`.
    pub(crate) fn on(surface: &'a Triangle, view: &View<'_>, [x, y]: [f64; 2], t: f64) -> Self {
        let (from, direction) = view.ray([x, y]);
        let center = surface.onto_plane(from + direction * t);
        let mut points = [center; MOVES];
        let mut lost = false;
        for (point, [dx, dy]) in points[1..5].iter_mut().zip(SIDEWAYS) {
            let (from, direction) = view.ray([x + dx, y + dy]);
            match surface.plane_parameter(from, direction).filter(|t| *t > 0.0) {
                Some(t) => *point = surface.onto_plane(from + direction * t),
                None => lost = true,
            }
        }
        let (beside, towards) = view.ray([x + PIXEL_MOVE, y]);
        let snap_m = (beside - from + (towards - direction) * t).length();
        let lost_m = lost_m(surface, view.position(), snap_m);
        let longer = if lost_m > 0.0 { 1.0 + lost_m / snap_m } else { 1.0 };
        for point in &mut points[1..5] {
            *point = center + (*point - center) * longer;
        }
        let depth_moves = depth_moves(surface, view, [x, y], t);
        let rounding = f64::from(DEPTH_ULPS) * view.depth_ulp(t);
        let is_tilted = depth_moves[0] < -rounding;
        let [deeper, nearer] = lost_depth(surface, view, (direction, t), lost_m);
        let depth_moves = [depth_moves[0] - deeper, depth_moves[1] + nearer];
        for (point, by) in points[5..].iter_mut().zip(depth_moves) {
            let t = view.distance_moved(t, by);
            if t.is_finite() && t > 0.0 {
                *point = from + direction * t;
            } else {
                lost = true;
            }
        }
        let mut corners = [center; CORNERS];
        for (index, corner) in corners.iter_mut().enumerate() {
            let sign = |bit: usize| if index >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let by = PIXEL_MOVE * longer;
            let (from, direction) = view.ray([x + sign(0) * by, y + sign(1) * by]);
            let t = surface.plane_parameter(from, direction).filter(|t| *t > 0.0);
            let t = t.map(|t| view.distance_moved(t, depth_moves[index >> 2 & 1]));
            // Where it leads nowhere, single moves are lost too.
            if let Some(t) = t.filter(|t| t.is_finite() && *t > 0.0) {
                *corner = from + direction * t;
            }
        }
        let eye_side = surface.facing(view.eye);
        let position = view.position();
        Self {
            surface,
            points,
            corners,
            lost,
            is_tilted,
            eye_side,
            position,
            snap_m,
            longer,
            rims: Vec::new(),
            at_edge: false,
        }
    }

    /// With what lies in its plane.
    pub(crate) fn among(self, in_plane: &InPlane<'a>) -> Self {
        Self { rims: in_plane.rims.clone(), at_edge: in_plane.at_edge, ..self }
    }

    /// Whether a volume of one of `casters` may hang from an edge that is as near to it, in its own plane, as corners are snapped.
    pub(crate) fn is_at_rim(&self, light: DVec4, casters: &CasterSet) -> bool {
        self.rims.iter().any(|rim| rim.counts(light, casters))
    }

    /// Its points and corners.
    pub(crate) fn everywhere(&self) -> [DVec3; MOVES + CORNERS] {
        std::array::from_fn(|index| *self.points.get(index).unwrap_or_else(|| &self.corners[index - MOVES]))
    }
}

/// How a pixel's centre moves, in pixels.
pub(crate) const SIDEWAYS: [[f64; 2]; 4] =
    [[-PIXEL_MOVE, 0.0], [PIXEL_MOVE, 0.0], [0.0, -PIXEL_MOVE], [0.0, PIXEL_MOVE]];

/// What f32 loses of a position, as a share of its distance from the eye.
pub(super) const POSITION_LOSS: f64 = 1.0 / (1 << 23) as f64;

/// What positions lose counts where it is more than this share of how far the snap moves a point.
const LOSS_COUNTS: f64 = 0.5;

/// Whether what is lost so counts beside moves of `snap_m`.
pub(super) fn counts(lost_m: f64, snap_m: f64) -> bool {
    lost_m > LOSS_COUNTS * snap_m
}

/// How far off the corners of `triangle` may be, where that counts beside moves of `snap_m`; else 0.
pub(super) fn lost_m(triangle: &Triangle, eye: DVec3, snap_m: f64) -> f64 {
    let distance = triangle.corners.iter().map(|corner| corner.distance(eye)).fold(0.0, f64::max);
    let lost_m = POSITION_LOSS * distance;
    if counts(lost_m, snap_m) { lost_m } else { 0.0 }
}

/// How much depth changes, away from the eye and towards it, where a surface lies `lost_m` beside its plane; the ray that sees it
/// has this direction and distance.
fn lost_depth(surface: &Triangle, view: &View<'_>, (direction, t): (DVec3, f64), lost_m: f64) -> [f64; 2] {
    if lost_m == 0.0 {
        return [0.0; 2];
    }
    let along = lost_m / surface.normal().normalize_or_zero().dot(direction).abs();
    let nearer = if along < t { view.depth(t - along) - view.depth(t) } else { f64::INFINITY };
    [view.depth(t) - view.depth(t + along), nearer]
}

/// What is not as thick, in pixels, is tilted by the snap of its corners.
const THIN_PX: f64 = 1.0;

/// How much of `surface` a row or a column through a place of the target shows, whichever is less, in pixels.
fn thickness_px(surface: &Triangle, view: &View<'_>, [x, y]: [f64; 2]) -> f64 {
    let edges = |dx: f64, dy: f64| {
        let (from, direction) = view.ray([x + dx, y + dy]);
        surface.edge_functions(from, direction)
    };
    // Linear over the target, and of one sign inside.
    let here = edges(0.0, 0.0);
    let inside = here.iter().sum::<f64>().signum();
    let extent = |there: [f64; 3]| {
        let (mut before, mut behind) = (f64::INFINITY, f64::INFINITY);
        for (here, there) in here.iter().zip(there) {
            let (height, slope) = ((here * inside).max(0.0), (there - here) * inside);
            if slope > 0.0 {
                before = before.min(height / slope);
            } else if slope < 0.0 {
                behind = behind.min(height / -slope);
            }
        }
        before + behind
    };
    extent(edges(1.0, 0.0)).min(extent(edges(0.0, 1.0)))
}

/// By how much the depth of `surface` may be off at a place of the target that shows it at distance `t`: away from the
/// eye (negative), and towards it.
fn depth_moves(surface: &Triangle, view: &View<'_>, [x, y]: [f64; 2], t: f64) -> [f64; 2] {
    let depth = view.depth(t);
    let rounding = f64::from(DEPTH_ULPS) * view.depth_ulp(t);
    if thickness_px(surface, view, [x, y]) >= THIN_PX {
        return [-rounding, rounding];
    }
    // Depth is linear: it is least and largest at corners of the square of all snaps.
    let mut reach = [0.0_f64; 2];
    for [dx, dy] in [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]] {
        let (from, direction) = view.ray([x + dx * CORNER_SNAP, y + dy * CORNER_SNAP]);
        let by = view.depth_of_plane(surface.corners[0], surface.normal(), from, direction) - depth;
        // A plane through the eye has all depths at once.
        let by = if by.is_nan() { [f64::NEG_INFINITY, f64::INFINITY] } else { [by; 2] };
        reach = [reach[0].min(by[0]), reach[1].max(by[1])];
    }
    let corners = surface.corners.map(|corner| view.clipped_depth(corner) - depth);
    let nearest = corners.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let farthest = corners.into_iter().fold(f64::INFINITY, f64::min);
    [reach[0].max(farthest).min(-rounding), reach[1].min(nearest).max(rounding)]
}
