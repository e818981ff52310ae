//! Volumes of casters that a lamp all but touches.
//!
//! From a lamp close over a face, the face's edges span almost half circles, and the face half of all directions. The way
//! between directions that are all but opposite is then nothing that f32 could tell, and whole regions would be dark or lit by
//! rounding. So at their far ends sides are cut where their edges pass the lamp, and far caps right under it as well: each part is
//! seen under a tame angle, from however near. What is extruded from a cut, and from corners next to the lamp, is computed in f64
//! and handed to the shader as a direction.
//!
//! *Why it cannot leak.* An edge is cut at a place that depends on its ends and the lamp alone, so far caps and sides at it are
//! cut there. The parts of a far cap have its triangle's sign; between them sides cancel and are not drawn. Near ends stay whole,
//! edges and front caps: only so do they begin where what is seen ends, and at its very depth. (Cut there too, they were off by
//! the rounding of the cut, which slivers closed: of those, depth was whatever the rounding of their three corners made it, and a
//! pixel in some thousand scenes of strips was dark.)

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DVec3, DVec4, Vec3};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::scene::Instance;

use super::extrusion::{BESIDE, End};
use super::ray_candidates::Layout;
use super::volume::far;
use crate::layout;

/// `struct CutVertex` of the shadow volume shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct CutVertex {
    pub position: [f32; 3],
    pub pad_0: u32,
    pub away: [f32; 3],
    pub pad_1: u32,
}

impl CutVertex {
    /// The structure as it is here: what the layout test compares.
    pub fn layout() -> Layout {
        layout!(CutVertex: position, pad_0, away, pad_1)
    }
}

/// Vertices from this number on are no vertices of the mesh: `FIRST_CUT` of common/volume.wgsl.
pub const FIRST_CUT: u32 = 1 << 29;

/// How wide the lamp may see what is not cut.
#[derive(Clone, Copy)]
struct Widest {
    /// Edges that it sees under a wider angle are cut: its cosine.
    cosine: f64,
    /// Faces this near under it are cut, as a share of the distance of their nearest corner.
    near_face: f64,
}

/// 172 degrees: half way between, directions still have nearly all digits.
const TAME: Widest = Widest { cosine: -0.99, near_face: 1e-2 };
/// For volumes that end at a distance, which is flat between directions.
const RIGHT_ANGLE: Widest = Widest { cosine: 0.0, near_face: f64::INFINITY };
/// Corners this near to the lamp are handed over as directions, in shares of the caster's radius.
const NEAR_CORNER: f64 = 1e-3;

/// How near the segment from `a` to `b` comes to `point`.
pub fn distance_to_segment(point: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (to_a, along) = (a - point, b - a);
    let t = (-to_a.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (to_a + along * t).length()
}

/// How near a triangle comes to `point`.
pub fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let above = |p: DVec3, q: DVec3| normal.cross(q - p).dot(point - p) >= 0.0;
    if above(a, b) && above(b, c) && above(c, a) && normal != DVec3::ZERO {
        return normal.normalize().dot(point - a).abs();
    }
    [(a, b), (b, c), (c, a)]
        .map(|(p, q)| distance_to_segment(point, p, q))
        .into_iter()
        .fold(f64::INFINITY, f64::min)
}

/// A side of a volume, before it is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// The ends of the edge that it hangs from.
    ends: [u32; 2],
    /// Where the lamp passes that edge, if that is wide.
    middle: Option<u32>,
}

impl Side {
    /// The side of an edge that is seen under a tame angle.
    pub(super) fn whole(ends: [u32; 2]) -> Self {
        Self { ends, middle: None }
    }

    /// The corners of the triangle that has the edge, which begins at `near` corners.
    pub(super) fn at_edge(self, near: fn(u32) -> u32) -> [u32; 3] {
        let [p, q] = self.ends;
        [near(q), near(p), far(self.middle.unwrap_or(p))]
    }

    /// Those of the others.
    pub(super) fn beyond(self, near: fn(u32) -> u32) -> impl Iterator<Item = u32> {
        let [p, q] = self.ends;
        let at_p = self.middle.map(|middle| [near(p), far(p), far(middle)]);
        let at_q = [near(q), far(self.middle.unwrap_or(p)), far(q)];
        at_p.into_iter().chain([at_q]).flatten()
    }
}

/// Cuts the far ends of one caster's volume.
pub(super) struct Cutter<'a> {
    instance: &'a Instance,
    p_in_world: &'a [DVec3],
    light: DVec3,
    radius_m: f64,
    widest: Widest,
    shader_from_world: DAffine3,
    /// What was cut so far.
    pub(super) cuts: Vec<CutVertex>,
    edges: HashMap<(u32, u32), Option<u32>>,
    corners: HashMap<u32, u32>,
}

impl<'a> Cutter<'a> {
    /// `None` where the light is nowhere near the caster, whose vertices are at `p_in_world`. The volume is to end at `end`.
    pub(super) fn new(
        instance: &'a Instance,
        p_in_world: &'a [DVec3],
        light: DVec4,
        end: End,
    ) -> Option<Self> {
        let bounds: &Aabb = &instance.world_bounds;
        let (radius_m, position) = (bounds.radius(), light.truncate());
        if light.w == 0.0 || bounds.distance(position) > BESIDE * radius_m {
            return None;
        }
        Some(Self {
            instance,
            p_in_world,
            light: position,
            radius_m,
            widest: if matches!(end, End::Reach(_)) { RIGHT_ANGLE } else { TAME },
            shader_from_world: instance.world_from_shader().inverse(),
            cuts: Vec::new(),
            edges: HashMap::new(),
            corners: HashMap::new(),
        })
    }

    fn away(&self, vertex: u32) -> DVec3 {
        self.p_in_world[vertex as usize] - self.light
    }

    /// A new vertex at `away` from the lamp.
    fn cut(&mut self, away: DVec3) -> u32 {
        let position = self.shader_from_world.transform_point3(self.light + away);
        self.cut_at(position.as_vec3(), away)
    }

    /// The same, `position` being where it is for shaders.
    fn cut_at(&mut self, position: Vec3, away: DVec3) -> u32 {
        // Of any length: as long as the caster, so that its square stays in the range of f32.
        let away = away * (self.radius_m / away.length().max(f64::MIN_POSITIVE));
        let away = self.shader_from_world.transform_vector3(away);
        self.cuts.push(CutVertex {
            position: position.to_array(),
            away: away.as_vec3().to_array(),
            ..CutVertex::default()
        });
        FIRST_CUT + self.cuts.len() as u32 - 1
    }

    /// The vertex itself, or what stands for it next to the lamp.
    fn corner(&mut self, vertex: u32) -> u32 {
        let away = self.away(vertex);
        // A lamp on the corner itself leaves no direction; all triangles there are edge-on.
        if away == DVec3::ZERO || away.length() > NEAR_CORNER * self.radius_m {
            return vertex;
        }
        if let Some(known) = self.corners.get(&vertex) {
            return *known;
        }
        let cut = self.cut_at(self.instance.mesh.shader_position(vertex), away);
        self.corners.insert(vertex, cut);
        cut
    }

    /// Where the edge between two vertices passes the lamp, if that is wide.
    fn middle(&mut self, p: u32, q: u32) -> Option<u32> {
        let ends = (p.min(q), p.max(q));
        if let Some(known) = self.edges.get(&ends) {
            return *known;
        }
        let (from, to) = (self.away(ends.0), self.away(ends.1));
        let along = to - from;
        let foot = from - along * (from.dot(along) / along.length_squared());
        let is_wide = from.dot(to) < self.widest.cosine * from.length() * to.length() && foot != DVec3::ZERO;
        let cut = is_wide.then(|| self.cut(foot));
        self.edges.insert(ends, cut);
        cut
    }

    /// The side that hangs from the edge from `p` to `q`.
    pub(super) fn side(&mut self, p: u32, q: u32) -> Side {
        let middle = self.middle(p, q);
        Side { ends: [self.corner(p), self.corner(q)], middle }
    }

    /// The triangles that a triangle is cut into, wound as it is; itself where it is not cut.
    pub(super) fn triangle(&mut self, [a, b, c]: [u32; 3]) -> Vec<[u32; 3]> {
        let mut outline = Vec::with_capacity(6);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let Side { ends: [p, _], middle } = self.side(p, q);
            outline.extend([Some(p), middle].into_iter().flatten());
        }
        if let Some(foot) = self.foot([a, b, c]) {
            let hub = self.cut(foot);
            return (0..outline.len()).map(|i| [hub, outline[i], outline[(i + 1) % outline.len()]]).collect();
        }
        // From a cut, if there is one: from a corner, parts along its cut edges would have no area.
        let is_middle = |vertex: &u32| !self.corners.values().any(|c| c == vertex) && *vertex >= FIRST_CUT;
        let hub = outline.iter().position(is_middle).unwrap_or(0);
        outline.rotate_left(hub);
        outline[1..].windows(2).map(|pair| [outline[0], pair[0], pair[1]]).collect()
    }

    /// The way from the lamp to the place right under it on a triangle, if that is near and on it.
    fn foot(&self, corners: [u32; 3]) -> Option<DVec3> {
        let [a, b, c] = corners.map(|vertex| self.away(vertex));
        let normal = (b - a).cross(c - a).try_normalize()?;
        let height = normal.dot(a);
        let nearest = a.length().min(b.length()).min(c.length());
        let inside = [(a, b), (b, c), (c, a)].iter().all(|(p, q)| normal.dot(p.cross(*q)) > 0.0);
        (inside && height != 0.0 && height.abs() < self.widest.near_face * nearest).then_some(normal * height)
    }
}
