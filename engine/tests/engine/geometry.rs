//! Shadow chains, orientation signs and layer bounds against brute force.
//!
//! The oracle works on integers: vertices, lights and points are whole numbers, so that all determinants are exact in
//! f64, and a segment that merely touches an edge is known to, and passed over. Points at infinity are ordinary homogeneous
//! vectors here, so that one crossing test serves sides, caps and far caps.

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use glam::{DAffine3, DVec3, DVec4, Vec3};
use proptest::prelude::*;
use shadowgraph_engine::geometry::{
    CastTriangles, Chain, GroupMember, LayerGrid, Topology, facing_signs, layer_groups, restricted_signs,
};
use shadowgraph_engine::math::{Aabb, facing_sign, orient_sign};

type Triangle = [DVec4; 3];

fn det4([a, b, c, d]: [DVec4; 4]) -> f64 {
    let det3 = |u: DVec4, v: DVec4, w: DVec4| u.truncate().dot(v.truncate().cross(w.truncate()));
    -a.w * det3(b, c, d) + b.w * det3(a, c, d) - c.w * det3(a, b, d) + d.w * det3(a, b, c)
}

/// How the segment crosses the triangle: +1 coming from its front, −1 from its back, 0 not at all; `None` when it
/// touches an edge or lies in the plane. Solves λ·from + μ·to = α·a + β·b + γ·c for non-negative coefficients.
fn crossing(from: DVec4, to: DVec4, [a, b, c]: Triangle) -> Option<i32> {
    let coefficients = [
        det4([to, a, b, c]),
        -det4([from, a, b, c]),
        -det4([from, to, b, c]),
        det4([from, to, a, c]),
        -det4([from, to, a, b]),
    ];
    let positive = coefficients.iter().filter(|x| **x > 0.0).count();
    let negative = coefficients.iter().filter(|x| **x < 0.0).count();
    match (positive, negative) {
        (5, 0) => Some(-1),
        (0, 5) => Some(1),
        (0, _) | (_, 0) => None,
        _ => Some(0),
    }
}

/// A caster with whole-numbered world positions, and a light.
#[derive(Debug)]
struct Case {
    world_from_local: DAffine3,
    world: Vec<DVec3>,
    topology: Topology,
    light: DVec4,
}

impl Case {
    /// `x_scale` is ±1: −1 mirrors between local and world space.
    fn new(world: Vec<DVec3>, indices: &[u32], light: DVec4, x_scale: f64) -> Self {
        let world_from_local = DAffine3::from_scale(DVec3::new(x_scale, 1.0, 1.0));
        let local: Vec<Vec3> =
            world.iter().map(|p| world_from_local.transform_point3(*p).as_vec3()).collect();
        let topology = Topology::new(&local, indices);
        Self { world_from_local, world, topology, light }
    }

    fn signs(&self) -> Vec<i8> {
        facing_signs(&self.world, self.topology.triangles(), self.light)
    }

    fn near(&self, vertex: u32) -> DVec4 {
        self.world[vertex as usize].extend(1.0)
    }

    fn far(&self, vertex: u32) -> DVec4 {
        (self.world[vertex as usize] * self.light.w - self.light.truncate()).extend(0.0)
    }

    /// The triangles of the chain, exactly as documented: side quads (q, p, p∞, q∞), caps (a, b, c), (a∞, c∞, b∞).
    fn chain_triangles(&self, signs: &[i8]) -> Vec<(Triangle, i32)> {
        let chain = Chain::extract(&self.topology, signs);
        let mut triangles = Vec::new();
        for &[p, q] in &chain.sides {
            triangles.push(([self.near(q), self.near(p), self.far(p)], 1));
            if self.light.w != 0.0 {
                triangles.push(([self.near(q), self.far(p), self.far(q)], 1));
            }
        }
        for (caps, weight) in [(&chain.caps_front, 1), (&chain.caps_back, -1)] {
            for &triangle in caps {
                let [a, b, c] = self.topology.triangles()[triangle as usize];
                triangles.push(([self.near(a), self.near(b), self.near(c)], weight));
                if self.light.w != 0.0 {
                    triangles.push(([self.far(a), self.far(c), self.far(b)], weight));
                }
            }
        }
        triangles
    }

    /// The triangles with a sign that lie between `point` and the light, +1 for each whose sign is the right one and
    /// −1 for the others: without tampering, the number of triangles crossed.
    fn count_at(&self, point: DVec4, signs: &[i8]) -> Option<i32> {
        let cast = self.topology.triangles().iter().zip(signs).filter(|(_, sign)| **sign != 0);
        // Who comes from the back goes to where the light sees the front.
        cast.map(|(corners, sign)| {
            let crossed = crossing(point, self.light, corners.map(|corner| self.near(corner)))?;
            Some(-i32::from(*sign) * crossed)
        })
        .sum()
    }

    /// z-pass: everything entered minus everything left on the way from the eye to the point.
    fn z_pass(&self, eye: DVec4, point: DVec4, signs: &[i8]) -> Option<i32> {
        let chain = self.chain_triangles(signs).into_iter();
        chain.map(|(triangle, weight)| Some(weight * crossing(eye, point, triangle)?)).sum()
    }

    /// z-fail: everything left minus everything entered behind the point. The ray runs through infinity, where the
    /// far caps are, to the antipode of the eye.
    fn z_fail(&self, eye: DVec4, point: DVec4, signs: &[i8]) -> Option<i32> {
        let chain = self.chain_triangles(signs).into_iter();
        chain.map(|(triangle, weight)| Some(-weight * crossing(point, -eye, triangle)?)).sum()
    }
}

fn position(reach: i32) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-reach..=reach).prop_map(|p| DVec3::from_array(p.map(f64::from)))
}

fn points(count: usize) -> impl Strategy<Value = Vec<DVec4>> {
    prop::collection::vec(position(50).prop_map(|p| p.extend(1.0)), count)
}

fn light() -> impl Strategy<Value = DVec4> {
    (position(60), prop::sample::select(vec![0.0, 1.0]))
        .prop_filter("a direction", |(l, w)| *w == 1.0 || *l != DVec3::ZERO)
        .prop_map(|(l, w)| l.extend(w))
}

fn x_scale() -> impl Strategy<Value = f64> {
    prop::sample::select(vec![1.0, -1.0])
}

/// Soups over few vertices, so that edges are shared by many triangles; each triangle may come again, the same way
/// round or the other, and with its own copies of the vertices.
fn soup() -> impl Strategy<Value = Case> {
    let triangle = (prop::array::uniform3(0..8_u32), 0..3_u8, any::<[bool; 3]>());
    (prop::collection::vec(position(30), 8), prop::collection::vec(triangle, 1..10), light(), x_scale())
        .prop_map(|(vertices, triangles, light, x_scale)| {
            let mut indices = Vec::new();
            for ([a, b, c], again, seams) in triangles {
                indices.extend([a, b, c]);
                let copy = |corner: usize, vertex: u32| vertex + if seams[corner] { 8 } else { 0 };
                match again {
                    1 => indices.extend([copy(0, a), copy(1, b), copy(2, c)]),
                    2 => indices.extend([copy(0, a), copy(2, c), copy(1, b)]),
                    _ => {}
                }
            }
            Case::new([vertices.clone(), vertices].concat(), &indices, light, x_scale)
        })
}

/// Tetrahedra, some inside-out, free to lie in each other.
fn solids() -> impl Strategy<Value = Case> {
    let solid = (prop::array::uniform4(position(30)), any::<bool>())
        .prop_filter("a volume", |([a, b, c, d], _)| (b - a).dot((c - a).cross(d - a)) != 0.0);
    (prop::collection::vec(solid, 1..4), light(), x_scale()).prop_map(|(solids, light, x_scale)| {
        let (mut vertices, mut indices) = (Vec::new(), Vec::new());
        for (corners, inside_out) in solids {
            let base = vertices.len() as u32;
            vertices.extend(corners);
            for [a, b, c] in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
                indices.extend(if inside_out { [a, b, c] } else { [a, c, b] }.map(|vertex| base + vertex));
            }
        }
        Case::new(vertices, &indices, light, x_scale)
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    /// The heart of it: z-pass, z-fail and brute force agree, for any soup and for any signs.
    #[test]
    fn chains_count_the_triangles_between_point_and_light(
        case in soup(),
        tampering in prop::collection::vec(prop::sample::select(vec![1_i8, 1, 1, -1, 0]), 32),
        eyes in points(4),
        receivers in points(4),
    ) {
        let honest = case.signs();
        let tampered: Vec<i8> = honest.iter().zip(&tampering).map(|(sign, by)| sign * by).collect();
        let mut decided = 0;
        for (&eye, &point) in eyes.iter().zip(&receivers).filter(|(eye, point)| eye != point) {
            for signs in [&honest, &tampered] {
                let (Some(at_eye), Some(at_point), Some(z_pass), Some(z_fail)) = (
                    case.count_at(eye, signs),
                    case.count_at(point, signs),
                    case.z_pass(eye, point, signs),
                    case.z_fail(eye, point, signs),
                ) else { continue };
                prop_assert_eq!(z_fail, at_point);
                prop_assert_eq!(at_eye + z_pass, at_point);
                prop_assert!(at_point >= 0 || signs == &tampered);
                decided += 1;
            }
        }
        // Cases that decide nothing are drawn anew; too many of them fail the test.
        prop_assume!(decided > 0);
    }

    /// Groups of triangles are chains of their own, and their counts add up.
    #[test]
    fn groups_add_up(case in soup(), cut in 0..20_u32, eyes in points(3), receivers in points(3)) {
        let signs = case.signs();
        let mut decided = 0;
        let groups = [restricted_signs(&signs, 0..cut), restricted_signs(&signs, cut..99)];
        for (&eye, &point) in eyes.iter().zip(&receivers) {
            let counted = groups.each_ref().map(|group| case.z_fail(eye, point, group));
            if let ([Some(a), Some(b)], Some(count)) = (counted, case.count_at(point, &signs)) {
                prop_assert_eq!(a + b, count);
                decided += 1;
            }
        }
        prop_assume!(decided > 0);
    }

    /// Casting with the lit half darkens what all triangles darken, inside-out and mirrored solids included. Points
    /// inside solids are what tells a solid turned the wrong way.
    #[test]
    fn closed_casters_darken_the_same(case in solids(), eyes in points(6), receivers in points(6)) {
        prop_assert_eq!(case.topology.closedness().unbalanced_edges, 0);
        let light = case.light.truncate();
        let light_in_local = case.world_from_local.inverse().transform_point3(light);
        prop_assume!(case.light.w == 0.0 || !case.topology.may_enclose(light_in_local));
        let all = case.signs();
        let lit = case.topology.orientation(&case.world_from_local).map(|o| o.lit_only(&all));
        prop_assert!(lit.is_some());
        let lit = lit.unwrap_or_default();
        let mut decided = 0;
        for (&eye, &point) in eyes.iter().zip(&receivers) {
            if let (Some(all), Some(lit)) = (case.z_fail(eye, point, &all), case.z_fail(eye, point, &lit)) {
                prop_assert_eq!(all > 0, lit > 0, "{} triangles, {} of them lit", all, lit);
                decided += 1;
            }
        }
        prop_assume!(decided > 0);
    }

    /// Where the sign is not 0 it is the exact sign, however close to the plane.
    #[test]
    fn orientation_signs_are_exact_or_zero(
        [a, b, c] in prop::array::uniform3(real_point(1e3)),
        barycentric in (-2.0..2.0_f64, -2.0..2.0_f64),
        offset in real_point(1.0),
        exponent in -20..0_i32,
    ) {
        let d = a + (b - a) * barycentric.0 + (c - a) * barycentric.1 + offset * 10.0_f64.powi(exponent);
        let exact = exact_side(a, b, c, d);
        for sign in [orient_sign(b - a, c - a, d - a), facing_sign(a, b, c, DVec4::from((d, 1.0)))] {
            prop_assert!(sign == 0 || f64::from(sign) == exact.signum(), "{} for {}", sign, exact);
            // Nor may the zero swallow what is plainly off the plane.
            prop_assert!(sign != 0 || exact.abs() < 0.1);
        }
    }

    /// No ray may cross more triangles than the grid allows: rays are aimed at the insides and the edges.
    #[test]
    fn layer_bounds_are_never_too_low(
        corners in prop::collection::vec(prop::array::uniform3(real_point(1.0)), 1..40),
        size in prop::sample::select(vec![1.0, 0.1, 0.01]),
        light in (real_point(3.0), prop::sample::select(vec![0.0, 1.0])),
        aims in prop::collection::vec((any::<prop::sample::Index>(), 0.0..1.0_f64, 0.0..1.0_f64), 24),
    ) {
        // Small triangles crowd around the light, or around the first corner of the first.
        let center = if corners.len() % 2 == 0 { light.0 } else { corners[0][0] };
        let positions: Vec<DVec3> = corners.iter().flatten().map(|p| center + (p - corners[0][0]) * size).collect();
        let triangles: Vec<[u32; 3]> = (0..corners.len() as u32).map(|i| [0, 1, 2].map(|k| 3 * i + k)).collect();
        let light = DVec4::from(light);
        let corners_of = |triangle: u32| triangles[triangle as usize].map(|corner| positions[corner as usize]);
        let layers = |list: &[u32]| {
            let list: Vec<[DVec3; 3]> = list.iter().map(|triangle| corners_of(*triangle)).collect();
            aims.iter().map(|aim| layers_on_ray(light, &list, aim)).max().unwrap_or(0)
        };
        let bounds = Aabb::from_points(positions.iter().copied());
        let mut grid = LayerGrid::new(light, &bounds, triangles.len());
        let all: Vec<u32> = (0..triangles.len() as u32).collect();
        all.iter().for_each(|triangle| grid.add_triangle(corners_of(*triangle)));
        prop_assert!(layers(&all) <= grid.max_layers());
        let mut mesh = LayerGrid::new(light, &bounds, triangles.len());
        mesh.add_mesh(&positions, &triangles, &all);
        prop_assert!(layers(&all) <= mesh.max_layers());
        let caster = CastTriangles { p_in_world: &positions, triangles: &triangles, cast: &all };
        let triangles_of = |member: GroupMember| member.triangles.unwrap_or_else(|| all.clone());
        let groups: Vec<Vec<u32>> = layer_groups(light, &[caster], 3)
            .into_iter()
            .map(|group| group.into_iter().flat_map(triangles_of).collect())
            .collect();
        prop_assert_eq!(groups.concat(), all.clone());
        for group in groups {
            prop_assert!(layers(&group) <= 3);
        }
    }
}

/// The oracle itself, on a triangle one can picture: in the plane z = 0, lit from above.
#[test]
fn the_oracle_knows_inside_outside_and_the_edge() {
    let corners = [DVec3::ZERO, DVec3::new(8.0, 0.0, 0.0), DVec3::new(0.0, 8.0, 0.0)];
    let case = Case::new(corners.to_vec(), &[0, 1, 2], DVec4::new(0.0, 0.0, 1.0, 0.0), 1.0);
    let signs = case.signs();
    let eye = DVec4::new(20.0, 11.0, 5.0, 1.0);
    for (x, y, z, count) in [
        (2.0, 3.0, -4.0, Some(1)),
        (2.0, 3.0, 4.0, Some(0)),
        (7.0, 3.0, -4.0, Some(0)),
        (0.0, 3.0, -4.0, None),
    ] {
        let point = DVec4::new(x, y, z, 1.0);
        assert_eq!(case.count_at(point, &signs), count);
        if count.is_some() {
            assert_eq!((case.z_pass(eye, point, &signs), case.z_fail(eye, point, &signs)), (count, count));
        }
    }
}

fn real_point(reach: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-reach..reach).prop_map(DVec3::from_array)
}

/// The exact determinant's sign and rough size: positive where a, b, c run counter-clockwise seen from d. (The
/// library's own convention is the opposite.)
fn exact_side(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let [a, b, c, d] = [a, b, c, d].map(|p| robust::Coord3D { x: p.x, y: p.y, z: p.z });
    -robust::orient3d(a, b, c, d)
}

/// The triangles that the light ray through a point of one of them strictly crosses, decided exactly.
fn layers_on_ray(light: DVec4, triangles: &[[DVec3; 3]], aim: &(prop::sample::Index, f64, f64)) -> u32 {
    let [a, b, c] = *aim.0.get(triangles);
    let target = a.lerp(b, aim.1).lerp(c, aim.2);
    let away = target * light.w - light.truncate();
    let from = if light.w == 0.0 { target - away * 1e3 } else { light.truncate() };
    let to = target + away * 1e3;
    let is_crossed = |&&[a, b, c]: &&[DVec3; 3]| {
        let edges = [exact_side(from, a, b, to), exact_side(from, b, c, to), exact_side(from, c, a, to)];
        exact_side(a, b, c, from) * exact_side(a, b, c, to) < 0.0
            && (edges.iter().all(|side| *side > 0.0) || edges.iter().all(|side| *side < 0.0))
    };
    triangles.iter().filter(is_crossed).count() as u32
}

/// A torus of 2·`rings`·`segments` triangles, of the size and shape of a real caster.
fn torus(rings: u32, segments: u32) -> (Vec<Vec3>, Vec<u32>) {
    let angle_rad = |i: u32, count: u32| f64::from(i) / f64::from(count) * TAU;
    let position = |i: u32| {
        let (u, v) = (angle_rad(i / segments, rings), angle_rad(i % segments, segments));
        let from_axis = 1.0 + 0.4 * v.cos();
        DVec3::new(from_axis * u.cos(), 0.4 * v.sin(), -from_axis * u.sin()).as_vec3()
    };
    let quad = |i: u32| {
        let vertex = |ring: u32, segment: u32| ring % rings * segments + segment % segments;
        let (r, s) = (i / segments, i % segments);
        let [a, b, c, d] = [vertex(r, s), vertex(r + 1, s), vertex(r + 1, s + 1), vertex(r, s + 1)];
        [a, b, c, a, c, d]
    };
    ((0..rings * segments).map(position).collect(), (0..rings * segments).flat_map(quad).collect())
}

/// Runs `work` and tells how long it took (`--nocapture` shows it).
fn timed<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    eprintln!("{what}: {:.2} ms", start.elapsed().as_secs_f64() * 1e3);
    result
}

#[test]
fn a_torus_of_70k_triangles_is_quick_solid_and_within_eight_bits() {
    let (positions, indices) = torus(350, 100);
    let p_in_world: Vec<DVec3> = positions.iter().map(|p| p.as_dvec3()).collect();
    let bounds = Aabb::from_points(p_in_world.iter().copied());
    timed("topology, first", || Topology::new(&positions, &indices));
    let topology = timed("topology", || Topology::new(&positions, &indices));
    let closedness = topology.closedness();
    assert_eq!((topology.triangles().len(), topology.edges().len()), (70_000, 105_000));
    assert_eq!((closedness.unbalanced_edges, closedness.components), (0, 1));
    // 2π²·R·r², less what the facets cut off.
    assert!((closedness.signed_volume / (2.0 * PI.powi(2) * 0.16) - 1.0).abs() < 2e-3);
    for light in
        [DVec4::new(0.3, 1.0, 0.2, 0.0), DVec4::new(3.0, 6.0, 1.0, 1.0), DVec4::new(0.1, 0.5, 0.1, 1.0)]
    {
        let signs = timed("facing signs", || facing_signs(&p_in_world, topology.triangles(), light));
        let chain = timed("chain", || Chain::extract(&topology, &signs));
        let edge_on = signs.iter().filter(|sign| **sign == 0).count();
        assert_eq!(chain.caps_front.len() + chain.caps_back.len() + edge_on, 70_000);
        assert!(chain.sides.len() < 4000 && chain.max_edge_weight == 2);
        let layers = timed("layers", || {
            let mut grid = LayerGrid::new(light, &bounds, 70_000);
            let corners = topology.triangles().iter();
            corners.for_each(|t| grid.add_triangle(t.map(|corner| p_in_world[corner as usize])));
            grid.max_layers()
        });
        eprintln!("{} sides, at most {layers} layers", chain.sides.len());
        assert!((2..=255).contains(&layers));
    }
}
