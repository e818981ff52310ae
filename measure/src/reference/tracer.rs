//! The exact reference: which triangle does a ray see, and does a light reach a point of it?
//!
//! The geometry is that of the scene's snapshot, f32 positions under f64 transforms, and every decision is made in f64
//! ([`super::surface`]); the tree of boxes only proposes triangles. Opaque and masked surfaces are seen, receive and
//! cast; transparent ones are looked through, and what light passes them takes their colour on ([`super::glass`]); unlit
//! ones are seen, lit by definition and cast nothing.
//!
//! **Factor.** 0 when light and eye are strictly on opposite sides of the receiving triangle. Otherwise 0 exactly if
//! some other triangle stands strictly between the point and the light; what lies in the point's own plane, or has the
//! light in its plane, stands between nothing. Else 1.

use glam::{DVec3, DVec4};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::scene::{LightSnapshot, SceneSnapshot};

use super::bvh::{Bvh, Open};
use super::cover::share_covers;
use super::glass::Panes;
use super::surface::Triangle;

/// What a ray sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Hit {
    /// The index of the instance in [`SceneSnapshot::instances`].
    pub instance: u32,
    /// The number of the triangle in the instance's mesh.
    pub triangle: u32,
}

/// Which instances cast for a light.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CasterSet(pub(crate) Vec<bool>);

impl CasterSet {
    /// Whether the instance of this index casts.
    #[inline(always)]
    pub(crate) fn contains(&self, instance: u32) -> bool {
        self.0.get(instance as usize).copied().unwrap_or_default()
    }
}

/// The scene as the reference sees it.
pub struct Reference {
    /// In the order of the tree's leaves.
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) bvh: Bvh,
    /// Where each triangle of each instance stands in `triangles`; `u32::MAX` for those that are no surface.
    places: Vec<Vec<u32>>,
    pub(crate) lights: Vec<LightSnapshot>,
    /// The largest coordinate of any surface, in metres.
    pub(crate) coordinate_m: f64,
    /// The box around all of them, as renderers have it.
    pub(crate) world_bounds: Aabb,
    /// The transparent surfaces, where there are any.
    pub(crate) panes: Option<Panes>,
}

impl Reference {
    /// Takes over what `snapshot` shows at this moment.
    pub fn new(snapshot: &SceneSnapshot) -> Self {
        let mut drawn = Triangle::of_scene(snapshot);
        share_covers(&mut drawn);
        let boxes: Vec<Aabb> = drawn.iter().map(Triangle::bounds).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |sum, b| sum.union(b));
        let (bvh, order) = Bvh::new(&boxes, &bounds);
        let triangles: Vec<Triangle> = order.iter().map(|index| drawn[*index as usize].clone()).collect();
        let mut places: Vec<Vec<u32>> =
            snapshot.instances.iter().map(|i| vec![u32::MAX; i.mesh.triangle_count()]).collect();
        for (place, triangle) in triangles.iter().enumerate() {
            places[triangle.instance as usize][triangle.triangle as usize] = place as u32;
        }
        let panes = Panes::of_scene(snapshot);
        let bounds = panes.as_ref().map_or(bounds, |panes| bounds.union(&panes.bounds));
        let coordinate_m =
            if bounds.is_empty() { 0.0 } else { bounds.min.abs().max(bounds.max.abs()).max_element() };
        Self {
            triangles,
            bvh,
            places,
            lights: snapshot.lights.clone(),
            coordinate_m,
            world_bounds: snapshot.world_bounds,
            panes,
        }
    }

    /// The number of triangles that are seen or cast.
    pub fn triangle_count(&self) -> usize {
        self.triangles.len()
    }

    /// The set of the instances with these indices; indices beyond the scene are ignored.
    pub fn caster_set(&self, instances: &[usize]) -> CasterSet {
        let mut casts = vec![false; self.places.len()];
        for instance in instances {
            if let Some(entry) = casts.get_mut(*instance) {
                *entry = true;
            }
        }
        CasterSet(casts)
    }

    /// A tracer: the reference together with what one thread needs for asking it.
    pub fn tracer(&self) -> Tracer<'_> {
        Tracer { reference: self, stack: Vec::with_capacity(64), last_blocker: u32::MAX }
    }

    /// The triangle behind `hit`, if it is a surface.
    pub(crate) fn surface(&self, hit: Hit) -> Option<&Triangle> {
        let place = *self.places.get(hit.instance as usize)?.get(hit.triangle as usize)?;
        self.triangles.get(place as usize)
    }
}

/// Answers questions about the scene, one after the other; cheap to make, one for each thread.
pub struct Tracer<'a> {
    pub(crate) reference: &'a Reference,
    pub(crate) stack: Vec<Open>,
    /// What stood in the light's way last: neighbouring points are likely to be blocked by the same triangle.
    last_blocker: u32,
}

/// Points whose way to the light is asked for together, at most eight; they lie close to the first.
pub(crate) struct Probe<'a> {
    /// The points; the first is the one the others are moved copies of.
    pub(crate) points: &'a [DVec3],
    /// The triangle they lie on: neither it nor what lies in its plane is in the way, wherever the points were moved.
    pub(crate) receiver: Option<&'a Triangle>,
    /// The light: (position, 1) or (direction towards it, 0).
    pub(crate) light: DVec4,
    /// What may be in the way.
    pub(crate) casters: &'a CasterSet,
}

impl Probe<'_> {
    /// Whether `triangle` is the receiver, or lies in its plane.
    pub(crate) fn is_own_plane(&self, triangle: &Triangle, coordinate_m: f64) -> bool {
        self.receiver.is_some_and(|receiver| receiver.is(triangle) || triangle.holds(receiver, coordinate_m))
    }
}

impl Tracer<'_> {
    /// The first surface along `from + t·direction` with t in \[`t_min`, `t_max`\], and its t. Of several at exactly
    /// the same t it is the first drawn.
    pub fn first_hit(&mut self, from: DVec3, direction: DVec3, t_min: f64, t_max: f64) -> Option<(Hit, f64)> {
        let Self { reference, stack, .. } = self;
        let ray = reference.bvh.ray(from, direction, t_min..t_max, 0.0)?;
        let mut best: Option<(Hit, f64)> = None;
        reference.bvh.walk(&ray, stack, |leaf| {
            let mut limit = None;
            for triangle in &reference.triangles[leaf] {
                let Some(t) = triangle.hit(from, direction).filter(|t| (t_min..=t_max).contains(t)) else {
                    continue;
                };
                let hit = Hit { instance: triangle.instance, triangle: triangle.triangle };
                if best.is_none_or(|(first, nearest)| t < nearest || (t == nearest && hit < first)) {
                    best = Some((hit, t));
                    limit = Some(ray.limit(t));
                }
            }
            limit
        });
        best
    }

    /// Whether one of `casters` stands strictly between `point`, which lies on `receiver` if on anything, and `light`:
    /// (position, 1) or (direction towards the light, 0).
    pub fn is_blocked(
        &mut self,
        point: DVec3,
        receiver: Option<Hit>,
        light: DVec4,
        casters: &CasterSet,
    ) -> bool {
        let receiver = receiver.and_then(|hit| self.reference.surface(hit));
        self.blocked(&Probe { points: &[point], receiver, light, casters }) != 0
    }

    /// The factor of the light at `light` for a `point` on the triangle `receiver`, seen from `eye`; both are
    /// (position, 1) or (direction towards it, 0). Range and cone are the caller's concern. 1 on what receives nothing
    /// or is no surface.
    pub fn visibility_at(
        &mut self,
        point: DVec3,
        receiver: Hit,
        eye: DVec4,
        light: DVec4,
        casters: &CasterSet,
    ) -> f32 {
        let Some(surface) = self.reference.surface(receiver).filter(|surface| surface.receives) else {
            return 1.0;
        };
        let turned_away = surface.facing(eye) * surface.facing(light) < 0;
        if turned_away || self.is_blocked(point, Some(receiver), light, casters) { 0.0 } else { 1.0 }
    }

    /// One bit for each point of `probe`: 1 where something stands between it and the light.
    pub(crate) fn blocked(&mut self, probe: &Probe<'_>) -> u8 {
        let all = ((1_u32 << probe.points.len()) - 1) as u8;
        let mut blocked = 0;
        if let Some(triangle) = self.reference.triangles.get(self.last_blocker as usize) {
            blocked |= self.reference.blocked_by(triangle, probe, all);
        }
        if blocked == all {
            return all;
        }
        let center = probe.points[0];
        let spread_m = probe.points.iter().map(|p| (*p - center).abs().max_element()).fold(0.0_f64, f64::max);
        if self.reference.bvh.takes_thickness(spread_m) {
            return self.follow(probe, center, spread_m, all, blocked);
        }
        // Points too far apart for one thick ray, as on surfaces seen edge-on, go one by one.
        for (index, point) in probe.points.iter().enumerate() {
            blocked = self.follow(probe, *point, 0.0, 1 << index, blocked);
        }
        blocked
    }

    /// Adds to `blocked` the bits of `wanted` for which something within `thickness_m` of the way from `from` to the
    /// light is in the way.
    fn follow(
        &mut self,
        probe: &Probe<'_>,
        from: DVec3,
        thickness_m: f64,
        wanted: u8,
        mut blocked: u8,
    ) -> u8 {
        let Self { reference, stack, last_blocker } = self;
        let Some(way) = reference.bvh.way_to_light(from, probe.light, thickness_m) else { return blocked };
        reference.bvh.walk(&way, stack, |leaf| {
            for place in leaf {
                let found = reference.blocked_by(&reference.triangles[place], probe, wanted & !blocked);
                if found != 0 {
                    *last_blocker = place as u32;
                    blocked |= found;
                    if wanted & !blocked == 0 {
                        return Some(-1.0);
                    }
                }
            }
            None
        });
        blocked
    }
}

impl Reference {
    /// Which of the `wanted` points of `probe` have `triangle` between them and the light.
    #[inline(always)]
    fn blocked_by(&self, triangle: &Triangle, probe: &Probe<'_>, wanted: u8) -> u8 {
        if !triangle.casts || !probe.casters.contains(triangle.instance) {
            return 0;
        }
        let mut blocked = 0;
        for (index, point) in probe.points.iter().enumerate() {
            if wanted & (1 << index) != 0 && triangle.blocks(*point, probe.light, self.coordinate_m) {
                blocked |= 1 << index;
            }
        }
        if blocked != 0 && probe.is_own_plane(triangle, self.coordinate_m) { 0 } else { blocked }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, Vec3};
    use proptest::prelude::*;
    use shadowgraph_engine::geometry::{Mesh, MeshData};
    use shadowgraph_engine::scene::{Material, Scene, placed};

    use super::*;

    /// A soup of triangles, some without area, some twice, placed anywhere and as large as `size_m`.
    /// Small triangles leave gaps, so that it matters which of them are asked.
    fn soup(
        corners: &[[i8; 3]],
        (fine, small): (bool, bool),
        offset: DVec3,
        size_m: f64,
        turn: f64,
    ) -> SceneSnapshot {
        let unit = if fine { 1.0 / 127.0 } else { 1.0 / 4.0 };
        let position = |c: &[i8; 3]| Vec3::from(c.map(|v| f32::from(if fine { v } else { v / 32 }) * unit));
        let mut positions: Vec<Vec3> = corners.iter().map(position).collect();
        if small {
            for triangle in positions.chunks_exact_mut(3) {
                triangle[1] = triangle[0] + triangle[1] / 16.0;
                triangle[2] = triangle[0] + triangle[2] / 16.0;
            }
        }
        let indices = (0..positions.len() as u32 / 3 * 3).collect();
        let mesh = Mesh::new(MeshData { positions, indices, ..MeshData::default() }).unwrap();
        let mut scene = Scene::new();
        let place = placed(offset, DQuat::from_rotation_z(turn), DVec3::splat(size_m));
        scene.add_mesh(mesh, Material::default(), place);
        scene.snapshot().unwrap()
    }

    fn local_point() -> impl Strategy<Value = DVec3> {
        // Often a multiple of ¼, so that rays run along axes and meet corners and edges.
        let coordinate = prop_oneof![(-6_i32..=6).prop_map(|v| f64::from(v) * 0.25), -1.5..1.5_f64];
        [coordinate.clone(), coordinate.clone(), coordinate].prop_map(DVec3::from)
    }

    /// A ray to try: from a point, through a corner, an edge or the inside of a triangle, or just past it.
    type Aim = (DVec3, prop::sample::Index, f64, f64);

    fn aim() -> impl Strategy<Value = Aim> {
        let share = || prop_oneof![Just(0.0), Just(1.0), -0.1..1.1_f64];
        (local_point(), any::<prop::sample::Index>(), share(), share())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        /// The tree finds what asking every triangle finds: the first hit, and every point's blockers, alone and in
        /// company.
        #[test]
        fn the_tree_misses_nothing(
            corners in prop::collection::vec(any::<[i8; 3]>(), 3..240),
            kind: (bool, bool),
            size_m in prop_oneof![Just(1.0), Just(1e-3), Just(1e5)],
            offset in prop_oneof![Just(DVec3::ZERO), Just(DVec3::new(3e4, -1e3, 7.0))],
            turn in prop_oneof![Just(0.0), Just(0.7)],
            aims in prop::collection::vec(aim(), 40),
            spread in prop_oneof![Just(1e-6), Just(8e-3), Just(0.3)],
            w in prop_oneof![Just(0.0), Just(1.0)],
        ) {
            let snapshot = soup(&corners, kind, offset, size_m, turn);
            let reference = Reference::new(&snapshot);
            let mut tracer = reference.tracer();
            let casters = reference.caster_set(&[0]);
            for (from, pick, u, v) in aims {
                let [a, b, c] = pick.get(&reference.triangles).corners;
                let start = offset + from * size_m;
                let direction = a.lerp(b, u).lerp(c, v) - start;

                let nearest = reference
                    .triangles
                    .iter()
                    .filter_map(|triangle| {
                        let hit = Hit { instance: triangle.instance, triangle: triangle.triangle };
                        let t = triangle.hit(start, direction).filter(|t| (0.1..=2.0).contains(t))?;
                        Some((hit, t))
                    })
                    .min_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
                prop_assert_eq!(tracer.first_hit(start, direction, 0.1, 2.0), nearest);

                let target = if w == 0.0 { direction } else { start + direction * 4.0 };
                let light = DVec4::from((target, w));
                let moves =
                    [DVec3::ZERO, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
                let points = moves.map(|m| start + m * (spread * size_m));
                let receiver = Hit { instance: 0, triangle: 0 };
                let surface = reference.surface(receiver);
                let probe = Probe { points: &points, receiver: surface, light, casters: &casters };
                let all = reference.triangles.iter();
                let expected = all.fold(0, |bits, t| bits | reference.blocked_by(t, &probe, 0x7f));
                prop_assert_eq!(tracer.blocked(&probe), expected);
                for (index, point) in points.iter().enumerate() {
                    let alone = tracer.is_blocked(*point, Some(receiver), light, &casters);
                    prop_assert_eq!(alone, expected & (1 << index) != 0);
                }
            }
        }
    }

    #[test]
    fn an_empty_scene_shows_and_blocks_nothing() {
        let reference = Reference::new(&Scene::new().snapshot().unwrap());
        let mut tracer = reference.tracer();
        assert_eq!(tracer.first_hit(DVec3::ZERO, DVec3::X, 0.0, f64::INFINITY), None);
        let nobody = reference.caster_set(&[7]);
        assert!(!tracer.is_blocked(DVec3::ZERO, None, DVec4::new(0.0, 1.0, 0.0, 0.0), &nobody));
    }
}
