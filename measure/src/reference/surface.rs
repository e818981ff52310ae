//! World-space triangles and the decisions about one of them: is it hit, on which side of it is a point, does it stand
//! between a point and a light?
//!
//! All in f64. A line passes through a triangle when the three edge functions det(d, u, v), u and v running from the
//! line's origin to the edge's ends, agree in sign, zero counting as either. The product u×v is evaluated so that
//! swapping u and v negates it *exactly*: the two triangles at an edge see the same number with opposite signs, so no
//! line slips between them, whichever way each of them runs along the edge.

use glam::{DVec3, DVec4};
use shadowgraph_engine::math::{Aabb, POSITION_EPSILON, facing_sign, orient_sign};
use shadowgraph_engine::scene::{Instance, Material, SceneSnapshot};

use super::holes::Mask;
use super::tracer::Hit;

/// A ray does not hit a triangle when the determinant of two edges and the ray's direction is below this share of their
/// lengths' product: it looks along the triangle, or the triangle is a needle. Where it would hit is then decided by
/// rounding, and no pixel is that narrow.
const EDGE_ON: f64 = 1e-9;

/// A triangle of an opaque or masked surface, or of a transparent one ([`super::glass`]).
#[derive(Clone, Debug)]
pub(crate) struct Triangle {
    /// In the world, in the mesh's order.
    pub(crate) corners: [DVec3; 3],
    /// The index of its instance.
    pub(crate) instance: u32,
    /// Its number in the mesh.
    pub(crate) triangle: u32,
    /// Which way its front lies: +1 where the corners run counter-clockwise, −1 under a mirroring transform, 0 when
    /// both sides are drawn.
    front: i8,
    /// Whether it may stand in the light's way.
    pub(crate) casts: bool,
    /// Whether shadows fall on it.
    pub(crate) receives: bool,
    /// Whether it is transparent: then no side of it is dark by itself.
    pub(crate) lets_light_pass: bool,
    /// Where it has holes; `None` when it is whole.
    pub(crate) mask: Option<Box<Mask>>,
}

impl Triangle {
    /// All triangles that hide what is behind them, in the order of drawing.
    pub(crate) fn of_scene(snapshot: &SceneSnapshot) -> Vec<Self> {
        Self::wearing(snapshot, Material::is_opaque)
    }

    /// All triangles of the materials that are `wanted`, in the order of drawing.
    pub(crate) fn wearing(snapshot: &SceneSnapshot, wanted: fn(&Material) -> bool) -> Vec<Self> {
        snapshot
            .instances
            .iter()
            .enumerate()
            .flat_map(|(index, instance)| of_instance(snapshot, index, instance, wanted))
            .collect()
    }

    /// What a ray that meets it hits.
    pub(crate) fn as_hit(&self) -> Hit {
        Hit { instance: self.instance, triangle: self.triangle }
    }

    /// Whether `other` is this very triangle.
    pub(crate) fn is(&self, other: &Self) -> bool {
        self.as_hit() == other.as_hit()
    }

    /// The box around it.
    pub(crate) fn bounds(&self) -> Aabb {
        Aabb::from_points(self.corners)
    }

    /// Whether it has a hole at `point`.
    fn has_hole_at(&self, point: DVec3) -> bool {
        self.mask.as_ref().is_some_and(|mask| mask.has_hole_at(point))
    }

    /// Whether the line through `from` along `direction` passes through it, its edges included.
    #[inline(always)]
    fn is_crossed(&self, from: DVec3, direction: DVec3) -> bool {
        let [e0, e1, e2] = self.edge_functions(from, direction);
        !(e0.min(e1).min(e2) < 0.0 && e0.max(e1).max(e2) > 0.0)
    }

    /// On which side of each of its edges the line passes, in the order of the corners that edges begin at.
    #[inline(always)]
    pub(crate) fn edge_functions(&self, from: DVec3, direction: DVec3) -> [f64; 3] {
        let [u, v, w] = self.corners.map(|corner| corner - from);
        [direction.dot(u.cross(v)), direction.dot(v.cross(w)), direction.dot(w.cross(u))]
    }

    /// The parameter at which the ray hits a side of it that is drawn.
    #[inline(always)]
    pub(crate) fn hit(&self, from: DVec3, direction: DVec3) -> Option<f64> {
        if !self.is_crossed(from, direction) {
            return None;
        }
        let [a, b, c] = self.corners;
        let slope = self.normal().dot(direction);
        let edge_on = slope.abs() <= EDGE_ON * (b - a).length() * (c - a).length() * direction.length();
        if edge_on || f64::from(self.front) * slope > 0.0 {
            return None;
        }
        let t = self.plane_parameter(from, direction)?;
        (!self.has_hole_at(from + direction * t)).then_some(t)
    }

    /// Where the ray meets the triangle's plane, if it does.
    pub(crate) fn plane_parameter(&self, from: DVec3, direction: DVec3) -> Option<f64> {
        let normal = self.normal();
        let t = normal.dot(self.corners[0] - from) / normal.dot(direction);
        t.is_finite().then_some(t)
    }

    /// `point`, which lies on the triangle's plane but for rounding, with most of the rounding taken out: what is left
    /// no longer grows with the distance of the eye.
    pub(crate) fn onto_plane(&self, point: DVec3) -> DVec3 {
        let normal = self.normal();
        let moved = point - normal * (normal.dot(point - self.corners[0]) / normal.length_squared());
        if moved.is_finite() { moved } else { point }
    }

    /// The normal, as long as twice the area.
    pub(crate) fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }

    /// On which side of the triangle's plane `position` lies, a point or a direction: the facing sign.
    pub(crate) fn facing(&self, position: DVec4) -> i32 {
        let [a, b, c] = self.corners;
        facing_sign(a, b, c, position)
    }

    /// On which side of the triangle's plane `point` lies; 0 also when the rounding of positions around
    /// `coordinate_m`, the largest coordinate of the scene, leaves it open.
    ///
    /// Without this, two neighbours in one plane would shade each other wherever a transform has bent that plane by
    /// an ulp.
    pub(crate) fn side_of(&self, point: DVec3, coordinate_m: f64) -> i32 {
        let [a, b, c] = self.corners;
        let (ab, ac, d) = (b - a, c - a, point - a);
        let sign = orient_sign(ab, ac, d);
        if ab.cross(ac).dot(d).abs() <= self.side_tolerance(point, coordinate_m) { 0 } else { sign }
    }

    /// Whether `other` lies in this triangle's plane, as far as the rounding of positions can tell.
    ///
    /// A triangle that holds the receiver casts nothing on it, wherever a move of the ambiguity band takes the
    /// receiver's point: it is the receiver's own surface. That its plane holds the *point* is not enough, since that is so at
    /// the foot of a wall too, and there a move crosses the shadow's edge.
    pub(crate) fn holds(&self, other: &Self, coordinate_m: f64) -> bool {
        other.corners.iter().all(|corner| self.side_of(*corner, coordinate_m) == 0)
    }

    /// Whether both lie in one plane.
    pub(crate) fn shares_plane(&self, other: &Self, coordinate_m: f64) -> bool {
        self.holds(other, coordinate_m) && other.holds(self, coordinate_m)
    }

    /// The determinant of two edges and the way to `point` up to which its side is open: see [`Triangle::side_of`].
    pub(crate) fn side_tolerance(&self, point: DVec3, coordinate_m: f64) -> f64 {
        let [a, b, c] = self.corners;
        let (ab, ac, d) = (b - a, c - a, point - a);
        let coordinate_m = coordinate_m.max(point.abs().max_element());
        let reach = (ab.length() + ac.length()) * d.length() + ab.cross(ac).length();
        POSITION_EPSILON * coordinate_m * reach
    }

    /// The product of two edges' lengths: what the normal's components are differences of.
    pub(crate) fn edges_product(&self) -> f64 {
        let [a, b, c] = self.corners;
        (b - a).length() * (c - a).length()
    }

    /// Whether it may have holes.
    pub(crate) fn is_masked(&self) -> bool {
        self.mask.is_some()
    }

    /// Whether it stands strictly between `point` and `light` (a point or a direction towards it).
    #[inline(always)]
    pub(crate) fn blocks(&self, point: DVec3, light: DVec4, coordinate_m: f64) -> bool {
        let direction = light.truncate() - point * light.w;
        if !self.is_crossed(point, direction) {
            return false;
        }
        let facing = self.facing(light);
        facing != 0
            && self.side_of(point, coordinate_m) == -facing
            && !(self.is_masked() && self.has_hole_towards(point, light))
    }

    /// Whether all of it within the hull of `points`, which lie on it, is hole (true) or solid; `None` where it may be both.
    pub(crate) fn is_hole_within(&self, points: &[DVec3]) -> Option<bool> {
        self.mask.as_ref().map_or(Some(false), |mask| mask.is_hole_within(points))
    }

    /// Whether there is a hole where the way from `point` to `light` crosses it, which it does.
    pub(crate) fn has_hole_towards(&self, point: DVec3, light: DVec4) -> bool {
        let direction = light.truncate() - point * light.w;
        self.has_hole_at(self.plane_parameter(point, direction).map_or(point, |t| point + direction * t))
    }
}

fn of_instance<'a>(
    snapshot: &'a SceneSnapshot,
    index: usize,
    instance: &'a Instance,
    wanted: fn(&Material) -> bool,
) -> impl Iterator<Item = Triangle> + 'a {
    let mirrored = instance.world_from_local.matrix3.determinant() < 0.0;
    (0..instance.mesh.triangle_count()).filter_map(move |triangle| {
        let material = instance.material_of(triangle);
        wanted(material).then(|| Triangle {
            corners: instance.world_triangle(triangle),
            instance: index as u32,
            triangle: triangle as u32,
            front: match (material.double_sided, mirrored) {
                (true, _) => 0,
                (false, false) => 1,
                (false, true) => -1,
            },
            casts: !material.unlit,
            receives: instance.shadow.receives && !material.unlit,
            lets_light_pass: !material.is_opaque(),
            mask: Mask::of(snapshot, instance, triangle),
        })
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn triangle(corners: [DVec3; 3]) -> Triangle {
        let (instance, triangle, front) = (0, 0, 0);
        let (casts, receives, lets_light_pass) = (true, true, false);
        Triangle { corners, instance, triangle, front, casts, receives, lets_light_pass, mask: None }
    }

    fn point() -> impl Strategy<Value = DVec3> {
        // A coarse grid half of the time, so that exact zeros are met too.
        let coordinate = prop_oneof![(-4_i32..4).prop_map(f64::from), -4.0..4.0_f64];
        [coordinate.clone(), coordinate.clone(), coordinate].prop_map(DVec3::from)
    }

    fn exact(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
        let coord = |p: DVec3| robust::Coord3D { x: p.x, y: p.y, z: p.z };
        robust::orient3d(coord(a), coord(b), coord(c), coord(d))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        /// A non-zero sign is the sign of exact arithmetic; `robust` counts the other way round.
        #[test]
        fn signs_are_exact_where_not_zero(corners in [point(), point(), point()], p in point()) {
            let [a, b, c] = corners;
            let sign = triangle(corners).side_of(p, 4.0);
            let exact = -exact(a, b, c, p);
            prop_assert!(sign == 0 || f64::from(sign) * exact > 0.0, "{sign} against {exact}");
            prop_assert!(sign != 0 || exact.abs() < 1e-9, "0 against {exact}");
        }

        /// Blocking agrees with five exact orientation tests where all of these are clear of zero.
        #[test]
        fn blocking_is_exact(corners in [point(), point(), point()], p in point(), light in point()) {
            let [a, b, c] = corners;
            let (from, to) = (exact(a, b, c, p), exact(a, b, c, light));
            let edges = [exact(a, b, p, light), exact(b, c, p, light), exact(c, a, p, light)];
            prop_assume!([from, to].iter().chain(&edges).all(|e| e.abs() > 1e-9));
            let through = edges.iter().all(|e| *e > 0.0) || edges.iter().all(|e| *e < 0.0);
            let expected = from * to < 0.0 && through;
            prop_assert_eq!(triangle(corners).blocks(p, DVec4::from((light, 1.0)), 4.0), expected);
        }

        /// No line leaves a quadrilateral through its diagonal, whichever way the halves are wound.
        #[test]
        fn no_line_slips_through_an_edge(p in point(), u in 0.0..1.0_f64, flip: bool, turn: bool) {
            let (a, b, c, d) = (DVec3::ZERO, DVec3::X, DVec3::new(0.9, 0.0, 1.1), DVec3::new(-0.1, 0.0, 0.8));
            let on_diagonal = a.lerp(c, u * 0.98 + 0.01);
            prop_assume!(p.y.abs() > 0.1);
            let first = if turn { [c, a, b] } else { [a, b, c] };
            let second = if flip { [c, a, d] } else { [a, c, d] };
            let direction = on_diagonal - p;
            let crossed = [first, second].map(|t| triangle(t).is_crossed(p, direction));
            prop_assert!(crossed[0] || crossed[1]);
        }
    }
}
