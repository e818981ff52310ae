//! A caster as points on a receiver see it: the edges that can be silhouettes for some of them, and the triangles.
//!
//! For a receiver's point p let s_T(p) = ±1 be the side of triangle T's plane that p lies on. The number of triangles
//! between p and a sample s of the light changes along any path of s only where the segment crosses an edge e, by
//! m_e(p) = Σ σ(T, e)·s_T(p) over the triangles at e: the chain of a shadow volume, with p for the light. So it is known at
//! s when it is known at the light's centre, from the edges that the triangle (p; centre, s) meets. That holds for *any*
//! integers s_T(p), so p's own triangle and those coplanar with it, for which s_T(p) = 0, simply drop out.
//!
//! *Which edges.* Where both triangles of an edge have the whole light on one same side, m_e(p) ≠ 0 says that p is on that
//! side of one of them; then so is the way to every sample, and it does not meet the edge. All other edges are kept.
//!
//! *Solids.* Where the light is outside a solid, only triangles whose outer side the light sees count: p is behind them
//! ([`Half::Lit`]). Where receivers are outside, those alone will do of which they see the outer side ([`Half::Unlit`]):
//! every way into the solid begins with one.
//!
//! *Near triangles.* A triangle close to the light may be met beyond it or in it. Those are left out of the
//! chain, which any subset of triangles is closed for, and asked one by one.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4, Vec3};
use shadowgraph_engine::math::{Aabb, facing_sign};
use shadowgraph_engine::scene::Instance;

use super::masks::{MaskedTriangle, masked_triangles};
use super::stretched::Stretched;
use crate::common::beside_light::{distance_to_segment, distance_to_triangle};
use crate::common::volume::{CastShape, Half};

/// An edge in four texels: see soft_seen.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub(super) struct SoftEdge {
    pub a: [f32; 3],
    pub caster: u32,
    pub b: [f32; 3],
    pub bits: u32,
    pub plane_1: [f32; 4],
    pub plane_2: [f32; 4],
}

/// A triangle in four texels: see soft_seen.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub(super) struct SoftTriangle {
    pub a: [f32; 3],
    pub caster: u32,
    pub b: [f32; 3],
    pub bits: u32,
    pub c: [f32; 3],
    pub pad_0: u32,
    pub plane: [f32; 4],
}

/// The first triangle runs against the edge.
pub(super) const AGAINST_1: u32 = 1;
/// The second triangle runs against the edge.
pub(super) const AGAINST_2: u32 = 2;
/// The triangles count for points behind their planes only.
pub(super) const BEHIND_ONLY: u32 = 4;
/// The triangles count for points before their planes only.
pub(super) const BEFORE_ONLY: u32 = 32;
/// The triangle's plane faces the other way than its corners a, b, c run.
pub(super) const TURNED: u32 = 1;
/// The light's centre is before the triangle's plane.
pub(super) const CENTER_BEFORE: u32 = 8;
/// The light's centre is behind the triangle's plane.
pub(super) const CENTER_BEHIND: u32 = 16;

/// The light as a ball about its centre that no disc leaves, whichever receiver it is turned to; or as a cone of directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct LightBall {
    /// (centre, 1), or (unit direction towards it, 0).
    pub position: DVec4,
    /// Its radius in metres; for w = 0 the tangent of half the angle it is seen under.
    pub radius: f64,
}

impl LightBall {
    /// On which side of the plane {x : normal·x = normal·through} the whole light lies; 0 where the plane cuts it.
    pub(super) fn side(&self, normal: DVec3, through: DVec3) -> i32 {
        let to_center = self.position.truncate() - through * self.position.w;
        let height = normal.dot(to_center);
        let reach = if self.position.w == 0.0 {
            self.radius * (normal - to_center * height).length()
        } else {
            self.radius
        };
        // 1e-6: far above what f64 loses, and no edge more for it.
        if height.abs() <= reach * (1.0 + 1e-6) + 1e-9 * to_center.length() {
            return 0;
        }
        if height > 0.0 { 1 } else { -1 }
    }

    /// Whether the light is beside a caster of these triangles within `bounds`, and within which distance they are asked one by one.
    fn is_beside(&self, mut triangles: impl Iterator<Item = [DVec3; 3]>, bounds: &Aabb) -> (bool, f64) {
        let radius_m = bounds.radius();
        let near_m = NEAR * self.radius;
        let is_small = self.radius < BESIDE * radius_m;
        let share_m = if is_small { BESIDE_SMALL } else { BESIDE } * radius_m;
        // What cuts a light parts its samples, which lie no farther apart than the light is large.
        let is_cut_finely = self.radius < BESIDE_SMALL * radius_m;
        let limit_m = if is_cut_finely { share_m.max(self.radius) } else { share_m };
        // Most lights are far from all of it: no triangle need be asked.
        let is_beside = self.position.w > 0.0
            && bounds.distance(self.position.truncate()) < limit_m
            && triangles.any(|corners| self.distance_to_triangle(corners) < limit_m);
        (is_beside, if is_beside { near_m.max(limit_m) } else { near_m })
    }

    /// How near the segment from `a` to `b` comes to the centre; infinite for directional lights.
    pub(super) fn distance_to_segment(&self, a: DVec3, b: DVec3) -> f64 {
        let is_point = self.position.w > 0.0;
        if is_point { distance_to_segment(self.position.truncate(), a, b) } else { f64::INFINITY }
    }

    /// How near a triangle comes to the centre; infinite for directional lights.
    pub(super) fn distance_to_triangle(&self, corners: [DVec3; 3]) -> f64 {
        let is_point = self.position.w > 0.0;
        if is_point { distance_to_triangle(self.position.truncate(), corners) } else { f64::INFINITY }
    }

    /// Whether a triangle is left out of the chain: it comes within `near_m` of the light, or it is seen from there so wide
    /// that an edge of it may be met before the light and beyond it.
    fn is_near(&self, corners: [DVec3; 3], near_m: f64) -> bool {
        if self.position.w == 0.0 {
            return false;
        }
        let center = self.position.truncate();
        let towards = corners.map(|corner| (corner - center).normalize_or_zero());
        let wide = |i: usize, j: usize| towards[i].dot(towards[j]) < 0.5;
        wide(0, 1) || wide(1, 2) || wide(2, 0) || self.distance_to_triangle(corners) < near_m
    }
}

/// Triangles nearer to the light's centre than this many radii of its ball are asked one by one.
const NEAR: f64 = 3.0;
/// A light is beside a caster when it is nearer to it than this share of the caster's radius, or when it is smaller and ..
const BESIDE: f64 = 1e-3;
/// .. nearer than this share, or cut by the caster and smaller than this share: positions of f32 about the caster's middle then tell
/// too little of the disc. All triangles as near as this are then asked one by one, by what they are as the light sees them.
const BESIDE_SMALL: f64 = 0.05;

/// A triangle of a caster, as the shader reads it and as it stands in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChainTriangle {
    /// What the shader reads; `caster` is not yet set.
    pub record: SoftTriangle,
    /// Its corners in the world.
    pub corners: [DVec3; 3],
    /// Left out of the chain, to be asked by itself.
    pub near: bool,
    /// Whether it counts when it hides the light's centre: of a solid, what turns its back to the whole light hides nothing
    /// that its front does not.
    pub hides_center: bool,
    /// Where the light is beside the caster.
    pub beside: BesideTriangle,
}

/// A triangle as the light sees it, in six texels: its corners relative to the light's centre, in the order of its record; and
/// the moments a × b, b × c and a × c of its edges about the centre. Rounded once, they keep their digits however near the light is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented above")]
pub(super) struct BesideTriangle {
    pub a: [f32; 3],
    /// How high the light's centre is over the triangle's plane.
    pub center_height: f32,
    pub b: [f32; 3],
    pub pad_0: f32,
    pub c: [f32; 3],
    pub pad_1: f32,
    pub ab: [f32; 3],
    pub pad_2: f32,
    pub bc: [f32; 3],
    pub pad_3: f32,
    pub ac: [f32; 3],
    pub pad_4: f32,
}

impl BesideTriangle {
    /// Of `sorted` corners in the world, on a plane with this normal.
    fn new([a, b, c]: [DVec3; 3], normal: DVec3, light: &LightBall) -> Self {
        if light.position.w == 0.0 {
            return Self::default();
        }
        let [a, b, c] = [a, b, c].map(|corner| corner - light.position.truncate());
        let short = |v: DVec3| v.as_vec3().to_array();
        // From the edge itself: of two nearly parallel corners the product would lose its digits.
        let moment = |p: DVec3, q: DVec3| short(p.cross(q - p));
        Self {
            a: short(a),
            center_height: -normal.dot(a) as f32,
            b: short(b),
            c: short(c),
            ab: moment(a, b),
            bc: moment(b, c),
            ac: moment(a, c),
            ..Self::default()
        }
    }
}

/// An edge of a caster that may be a silhouette.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChainEdge {
    /// What the shader reads; `caster` is not yet set.
    pub record: SoftEdge,
    /// Its ends in the world.
    pub ends: [DVec3; 2],
}

/// One caster of one light.
#[derive(Clone, Debug, Default)]
pub(super) struct CasterChain {
    /// What the positions of its records are relative to, in the world.
    pub center: DVec3,
    /// The triangles that cast.
    pub triangles: Vec<ChainTriangle>,
    /// The edges of those that are not near, where these can be silhouettes.
    pub edges: Vec<ChainEdge>,
    /// The triangles with holes, which are in no chain.
    pub masked: Vec<MaskedTriangle>,
    /// Whether the light is beside the caster.
    pub beside: bool,
}

/// A triangle's plane on the way.
#[derive(Clone, Copy)]
struct Face {
    /// Unit normal and offset relative to the caster's centre, outwards where only triangles behind count.
    plane: [f32; 4],
    /// The normal with all digits.
    normal: DVec3,
    /// How the plane's normal goes with the triangle's own winding: ±1.
    orient: i32,
    /// The light's side of it.
    light_side: i32,
    near: bool,
}

impl CasterChain {
    /// The triangles with holes of `instance`; `whole` is the chain of its others, if it has any.
    pub(super) fn with_masks(instance: &Instance, light: &LightBall, whole: Option<Self>) -> Self {
        let mut chain =
            whole.unwrap_or_else(|| Self { center: instance.world_bounds.center(), ..Self::default() });
        chain.masked = masked_triangles(instance, light, chain.center);
        let corners = chain.masked.iter().map(|masked| masked.triangle.corners);
        chain.beside |= light.is_beside(corners, &instance.world_bounds).0;
        chain
    }

    /// The chain of `instance` with the triangles of `shape`, for `light`. `half` says which of its triangles, `stretched`
    /// whether and where they are cut.
    pub(super) fn new(
        instance: &Instance,
        shape: &CastShape<'_>,
        light: &LightBall,
        half: Half,
        stretched: Option<&Stretched>,
    ) -> Self {
        let topology = shape.topology();
        let center = stretched.map_or_else(|| instance.world_bounds.center(), |stretched| stretched.center);
        let in_world: Vec<DVec3> = (0..instance.mesh.positions().len() as u32)
            .map(|vertex| instance.world_position(vertex))
            .collect();
        let signs = shape.whole_only(instance, vec![1; topology.triangles().len()]);
        let orientation = match (half, shape) {
            (Half::Lit | Half::Unlit, CastShape::Own(_) | CastShape::Capped(_)) => {
                topology.orientation(&instance.world_from_local)
            }
            _ => None,
        };
        let corners = |vertices: &[u32; 3]| vertices.map(|vertex| in_world[vertex as usize]);
        let (beside, near_m) =
            light.is_beside(topology.triangles().iter().map(corners), &instance.world_bounds);
        let mut chain = Self { center, beside, ..Self::default() };
        let mut faces: Vec<Option<Face>> = Vec::with_capacity(signs.len());
        for (number, (vertices, sign)) in topology.triangles().iter().zip(&signs).enumerate() {
            let orient = orientation.as_ref().map_or(1, |orientation| i32::from(orientation.sign(number)));
            let corners = corners(vertices);
            let face =
                if *sign == 0 || orient == 0 { None } else { face(corners, center, orient, (light, near_m)) };
            if let Some(face) = &face {
                let hides_center = match half {
                    Half::Both => true,
                    Half::Lit => face.light_side >= 0,
                    Half::Unlit => face.light_side <= 0,
                };
                let parts = match stretched {
                    Some(stretched) if !face.near => stretched.parts(corners, *vertices),
                    _ => vec![corners],
                };
                chain.triangles.extend(parts.into_iter().map(|corners| {
                    let (record, beside, _) = triangle_record(corners, center, face, light, half);
                    ChainTriangle { record, corners, near: face.near, hides_center, beside }
                }));
            }
            faces.push(face.filter(|face| !face.near));
        }
        for (number, edge) in topology.edges().iter().enumerate() {
            let ends = [edge.p, edge.q].map(|vertex| in_world[vertex as usize]);
            let uses = topology.uses(number).iter();
            let uses: Vec<(i32, Face)> = uses
                .filter_map(|use_of| Some((use_of.sigma, faces[use_of.triangle as usize]?)))
                .map(|(sigma, face)| (sigma * face.orient, face))
                .collect();
            let cuts = stretched.map_or_else(Vec::new, |stretched| stretched.cuts(ends[0], ends[1]));
            let points: Vec<DVec3> = [ends[0]].into_iter().chain(cuts).chain([ends[1]]).collect();
            points.windows(2).for_each(|ends| chain.add_edge([ends[0], ends[1]], uses.clone(), half));
        }
        chain
    }

    /// The edge between `ends` with these triangles, two by two: those first that run against each other.
    fn add_edge(&mut self, ends: [DVec3; 2], uses: Vec<(i32, Face)>, half: Half) {
        let (mut along, mut against): (Vec<_>, Vec<_>) = uses.into_iter().partition(|(sigma, _)| *sigma > 0);
        loop {
            let pair = match (along.pop(), against.pop()) {
                (None, None) => return,
                (Some(first), Some(second)) => (first, Some(second)),
                (Some(first), None) => (first, along.pop()),
                (None, Some(first)) => (first, against.pop()),
            };
            let ((sigma, face), second) = pair;
            if let Some((other_sigma, other)) = second {
                let same = sigma * face.light_side == -other_sigma * other.light_side;
                let opposed = half == Half::Both || sigma == -other_sigma;
                if same && opposed && face.light_side != 0 {
                    continue;
                }
            }
            let [p, q] = ends.map(|end| rounded(end - self.center));
            let turned = q.to_array() < p.to_array();
            let (a, b) = if turned { (q, p) } else { (p, q) };
            let against = |sigma: i32| (sigma < 0) != turned;
            let mut bits = counted_from(half);
            bits |= if against(sigma) { AGAINST_1 } else { 0 };
            bits |= second.map_or(0, |(sigma, _)| if against(sigma) { AGAINST_2 } else { 0 });
            let record = SoftEdge {
                a: a.to_array(),
                caster: 0,
                b: b.to_array(),
                bits,
                plane_1: face.plane,
                plane_2: second.map_or([0.0; 4], |(_, face)| face.plane),
            };
            self.edges.push(ChainEdge { record, ends });
        }
    }
}

/// From which side of its plane a triangle counts.
fn counted_from(half: Half) -> u32 {
    match half {
        Half::Both => 0,
        Half::Lit => BEHIND_ONLY,
        Half::Unlit => BEFORE_ONLY,
    }
}

/// To f32, with one zero only.
fn rounded(p: DVec3) -> Vec3 {
    p.as_vec3() + 0.0
}

fn face(corners: [DVec3; 3], center: DVec3, orient: i32, (light, near_m): (&LightBall, f64)) -> Option<Face> {
    let [a, b, c] = corners;
    // The product of two edges from the corner between the shorter ones is the least rounded; scaled, so that tiny
    // triangles keep theirs.
    let (ab, ac) = (b - a, c - a);
    let size = ab.abs().max_element().max(ac.abs().max_element());
    let normal = (ab / size).cross(ac / size).try_normalize()? * f64::from(orient);
    Some(Face {
        plane: normal.extend(normal.dot(a - center)).as_vec4().to_array(),
        normal,
        orient,
        light_side: light.side(normal, a),
        near: light.is_near(corners, near_m),
    })
}

/// A triangle that is in no chain and casts from both sides, relative to `center`, and which of its corners are those of its
/// record; `None` where it has no area.
pub(super) fn chain_triangle(
    corners: [DVec3; 3],
    center: DVec3,
    light: &LightBall,
) -> Option<(ChainTriangle, [usize; 3])> {
    let face = face(corners, center, 1, (light, 0.0))?;
    let (record, beside, order) = triangle_record(corners, center, &face, light, Half::Both);
    Some((ChainTriangle { record, corners, near: false, hides_center: false, beside }, order))
}

/// What shaders read of a triangle, and which of its corners these are.
fn triangle_record(
    corners: [DVec3; 3],
    center: DVec3,
    face: &Face,
    light: &LightBall,
    half: Half,
) -> (SoftTriangle, BesideTriangle, [usize; 3]) {
    let mut sorted = [0, 1, 2].map(|number| (rounded(corners[number] - center), corners[number], number));
    let mut even = true;
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if sorted[j].0.to_array() < sorted[i].0.to_array() {
            sorted.swap(i, j);
            even = !even;
        }
    }
    let [a, b, c] = corners;
    let center_side = facing_sign(a, b, c, light.position) * face.orient;
    let mut bits = if even == (face.orient > 0) { 0 } else { TURNED };
    bits |= counted_from(half);
    // On neither side, where it lies in the plane: then nothing hides it.
    bits |= match center_side {
        1 => CENTER_BEFORE,
        -1 => CENTER_BEHIND,
        _ => 0,
    };
    let beside = BesideTriangle::new(sorted.map(|(_, corner, _)| corner), face.normal, light);
    let [a, b, c] = sorted.map(|(corner, _, _)| corner.to_array());
    let record = SoftTriangle { a, caster: 0, b, bits, c, pad_0: 0, plane: face.plane };
    (record, beside, sorted.map(|(_, _, number)| number))
}
