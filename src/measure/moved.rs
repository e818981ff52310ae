//! A receiver's point and the copies of it that the ambiguity band asks about (see [`super::render`]).

use glam::DVec3;

use super::reference::{Hit, Reference};
use super::render::{DEPTH_ULPS, PIXEL_MOVE, View};
use super::surface::Triangle;

/// The centre, four moves on the plane, two in depth.
pub(super) const MOVES: usize = 7;

/// Points moved in all three ways at once.
pub(super) const CORNERS: usize = 8;

/// A receiver point and its moved copies.
pub(super) struct Moved {
    pub(super) hit: Hit,
    /// The last two are those moved in depth.
    pub(super) points: [DVec3; MOVES],
    /// Moved up or down, left or right and in depth: the corners of the box that the moves span. A sample next to two
    /// edges at once may see between them from there alone.
    pub(super) corners: [DVec3; CORNERS],
    /// Some move led nowhere; its point is then the centre's.
    pub(super) lost: bool,
    pub(super) receives: bool,
    /// The side on which the eye is.
    pub(super) eye_side: i32,
}

impl Moved {
    pub(super) fn new(
        reference: &Reference,
        view: &View<'_>,
        place: [f64; 2],
        hit: Hit,
        t: f64,
    ) -> Option<Self> {
        Some(Self::on(reference.surface(hit)?, view, place, t))
    }

    /// The point that the ray through a place of the target meets at distance `t`, on `surface`.
    pub(super) fn on(surface: &Triangle, view: &View<'_>, [x, y]: [f64; 2], t: f64) -> Self {
        let hit = Hit { instance: surface.instance, triangle: surface.triangle };
        let (from, direction) = view.ray([x, y]);
        let center = surface.onto_plane(from + direction * t);
        let mut points = [center; MOVES];
        let mut lost = false;
        let moves = [[-PIXEL_MOVE, 0.0], [PIXEL_MOVE, 0.0], [0.0, -PIXEL_MOVE], [0.0, PIXEL_MOVE]];
        for (point, [dx, dy]) in points[1..5].iter_mut().zip(moves) {
            let (from, direction) = view.ray([x + dx, y + dy]);
            match surface.plane_parameter(from, direction).filter(|t| *t > 0.0) {
                Some(t) => *point = surface.onto_plane(from + direction * t),
                None => lost = true,
            }
        }
        for (point, sign) in points[5..].iter_mut().zip([-1.0, 1.0]) {
            let t = view.distance_moved(t, sign * f64::from(DEPTH_ULPS));
            if t.is_finite() && t > 0.0 {
                *point = from + direction * t;
            } else {
                lost = true;
            }
        }
        let mut corners = [center; CORNERS];
        for (index, corner) in corners.iter_mut().enumerate() {
            let sign = |bit: usize| if index >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let (from, direction) = view.ray([x + sign(0) * PIXEL_MOVE, y + sign(1) * PIXEL_MOVE]);
            let t = surface.plane_parameter(from, direction).filter(|t| *t > 0.0);
            let t = t.map(|t| view.distance_moved(t, sign(2) * f64::from(DEPTH_ULPS)));
            // Where it leads nowhere, single moves are lost too.
            if let Some(t) = t.filter(|t| t.is_finite() && *t > 0.0) {
                *corner = from + direction * t;
            }
        }
        let eye_side = surface.facing(view.eye);
        Self { hit, points, corners, lost, receives: surface.receives, eye_side }
    }

    /// Its points and corners.
    pub(super) fn everywhere(&self) -> [DVec3; MOVES + CORNERS] {
        std::array::from_fn(|index| *self.points.get(index).unwrap_or_else(|| &self.corners[index - MOVES]))
    }
}
