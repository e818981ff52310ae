//! Orientation signs: on which side of a triangle's plane does a point, or a light, lie?
//!
//! Every decision of the shadow techniques and of the reference goes through these two functions, so that
//! "the light lies in the triangle's plane" means the same everywhere.

use glam::{DVec3, DVec4};

/// Relative size under which an orientation determinant counts as zero: |det| ≤ ε · permanent.
///
/// The determinant of three differences carries a rounding error below about 8·2⁻⁵³ ≈ 9·10⁻¹⁶ of its permanent
/// (the same sum with every term taken absolute). The differences themselves come from transformed f32 input and
/// have lost another few ulps, hence the generous hundredfold margin: what is within it of a plane lies in the
/// plane as far as the input can tell.
pub const ORIENT_EPSILON: f64 = 1e-13;

/// The sign of det(`b`−`a`, `c`−`a`, `d`), with the relative zero of [`ORIENT_EPSILON`].
///
/// `d` is a *vector*: a direction, or a point minus `a`. Positive when (b−a, c−a, d) is right-handed, that is when
/// `d` points to the side from which a, b, c run counter-clockwise. Returns 0 for degenerate triangles and for
/// anything not finite.
pub fn orient_sign(ab: DVec3, ac: DVec3, d: DVec3) -> i32 {
    let (p, q, r) = (ab.y * ac.z, ab.z * ac.y, ab.z * ac.x);
    let (s, t, u) = (ab.x * ac.z, ab.x * ac.y, ab.y * ac.x);
    let det = (p - q) * d.x + (r - s) * d.y + (t - u) * d.z;
    let permanent =
        (p.abs() + q.abs()) * d.x.abs() + (r.abs() + s.abs()) * d.y.abs() + (t.abs() + u.abs()) * d.z.abs();
    if det.abs() > ORIENT_EPSILON * permanent { if det > 0.0 { 1 } else { -1 } } else { 0 }
}

/// The rounding error of a world position, relative to the largest coordinate nearby: an f32 position under an f64
/// transform loses about 4·2⁻⁵³ in each coordinate, and a determinant of differences feels it at most 2√3 times in
/// each factor.
pub const POSITION_EPSILON: f64 = 4e-15;

/// The least angle between a direction and a triangle that f32 positions can tell from 0, in radians. A sun that
/// grazes a surface at less does not light it, and the shadow is thinner than the corners are known.
const DIRECTION_EPSILON: f64 = 1.2e-7;

/// The facing sign s_T of triangle (a, b, c) towards the homogeneous `light` (l, w): w = 1 a point at l, w = 0 a
/// direction l *towards* the light. +1 where the light sees the triangle counter-clockwise, −1 where clockwise. 0
/// where it has no area, is edge-on (for a direction within 1.2e-7 rad), or the point is so near to its plane that
/// positions, with their error of [`POSITION_EPSILON`], cannot tell.
pub fn facing_sign(a: DVec3, b: DVec3, c: DVec3, light: DVec4) -> i32 {
    let (ab, ac, d) = (b - a, c - a, light.truncate() - a * light.w);
    // A point next to a corner has a difference from it of which few digits are left.
    let coordinate = a.abs().max(light.truncate().abs()).max_element() * light.w;
    let normal = ab.cross(ac);
    let lost = POSITION_EPSILON * coordinate * normal.length();
    let lost = if light.w == 0.0 { DIRECTION_EPSILON * normal.length() * d.length() } else { lost };
    if normal.dot(d).abs() <= lost { 0 } else { orient_sign(ab, ac, d) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sign_follows_the_right_hand_rule() {
        let (a, b, c) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        assert_eq!(facing_sign(a, b, c, DVec4::new(0.2, 0.2, 1.0, 1.0)), 1);
        assert_eq!(facing_sign(a, c, b, DVec4::new(0.2, 0.2, 1.0, 1.0)), -1);
        assert_eq!(facing_sign(a, b, c, DVec4::new(5.0, 7.0, 0.0, 1.0)), 0);
        assert_eq!(facing_sign(a, b, c, DVec4::new(0.0, 0.0, -1.0, 0.0)), -1);
        assert_eq!(facing_sign(a, b, b, DVec4::new(0.0, 0.0, -1.0, 0.0)), 0);
        assert_eq!(facing_sign(a, b, c, DVec4::new(1.0, 0.0, 1e-7, 0.0)), 0);
        assert_eq!(facing_sign(a, b, c, DVec4::new(1.0, 0.0, 2e-7, 0.0)), 1);
        assert_eq!(facing_sign(a, b, DVec3::NAN, DVec4::new(0.0, 0.0, -1.0, 0.0)), 0);
    }
}
