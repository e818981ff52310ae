//! A receiver's point and the copies of it that the ambiguity band asks about (see [`super::render`]).

use glam::DVec3;

use super::reference::{Hit, Reference};
use super::render::{DEPTH_ULPS, PIXEL_MOVE, View};

/// The centre, four moves on the plane, two in depth.
pub(super) const MOVES: usize = 7;

/// A receiver point and its moved copies.
pub(super) struct Moved {
    pub(super) hit: Hit,
    /// The last two are those moved in depth.
    pub(super) points: [DVec3; MOVES],
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
        [x, y]: [f64; 2],
        hit: Hit,
        t: f64,
    ) -> Option<Self> {
        let surface = reference.surface(hit)?;
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
        let eye_side = surface.facing(view.eye);
        Some(Self { hit, points, lost, receives: surface.receives, eye_side })
    }
}
