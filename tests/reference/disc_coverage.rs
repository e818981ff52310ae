//! The mathematics of coverage by area, against columns of the disc summed up one by one.

use glam::{DVec2, DVec3};
use shadowgraph_testing::twin::{in_f32, in_f64};

/// A stream of numbers from −1 to 1 that is the same at every run.
struct Random(u64);

impl Random {
    fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn point(&mut self) -> DVec3 {
        DVec3::new(self.number(), self.number(), self.number())
    }
}

/// The part of a polygon where `inside` is not negative.
fn clipped(polygon: &[DVec3], inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (at_a, at_b) = (inside(a), inside(b));
        if at_a >= 0.0 {
            kept.push(a);
        }
        if (at_a >= 0.0) != (at_b >= 0.0) {
            kept.push(a.lerp(b, at_a / (at_a - at_b)));
        }
    }
    kept
}

/// The share of the disc over a triangle by columns: clipped in space, projected, summed up over x.
fn share_by_columns(disc: in_f64::DiscView, corners: [DVec3; 3]) -> f64 {
    const COLUMNS: u32 = 20_000;
    let ccw = corners[0].dot(corners[1].cross(corners[2])).signum();
    let mut polygon = clipped(&corners, |p| p.z - 1e-9);
    polygon = clipped(&polygon, |p| disc.far - p.z);
    if disc.dips {
        polygon = clipped(&polygon, |p| disc.horizon.dot(p));
    }
    let polygon: Vec<DVec2> = polygon.into_iter().map(|p| p.truncate() / p.z).collect();
    let column = |i: u32| {
        let x = (f64::from(i) + 0.5) / f64::from(COLUMNS) * 2.0 - 1.0;
        let half = (1.0 - x * x).sqrt();
        let mut crossings = (f64::INFINITY, f64::NEG_INFINITY);
        for (i, a) in polygon.iter().enumerate() {
            let b = polygon[(i + 1) % polygon.len()];
            if (a.x <= x) != (b.x <= x) {
                let y = a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x));
                crossings = (crossings.0.min(y), crossings.1.max(y));
            }
        }
        (crossings.1.min(half) - crossings.0.max(-half)).max(0.0)
    };
    ccw * (0..COLUMNS).map(column).sum::<f64>() * (2.0 / f64::from(COLUMNS)) / std::f64::consts::PI
}

/// A view of a disc whose horizon cuts it, or not, and that lies at 1 along Z.
fn any_view(random: &mut Random) -> in_f64::DiscView {
    let across = DVec2::from_angle(random.number() * 3.2);
    let horizon = across.extend(random.number() * 1.3);
    in_f64::DiscView { horizon, far: 1.0, dips: horizon.z.abs() < 1.0, margin: 0.0, lift: 0.0 }
}

/// Corners before and behind the receiver and the light, near the disc's cone and far from it.
fn any_corners(random: &mut Random, spread: f64) -> [DVec3; 3] {
    let middle = random.point();
    [(); 3].map(|()| {
        let p = middle + random.point() * spread;
        DVec3::new(p.x, p.y, p.z * 0.8 + 0.5)
    })
}

/// The same view in f32.
fn short(disc: in_f64::DiscView) -> in_f32::DiscView {
    let (horizon, far) = (disc.horizon.as_vec3(), disc.far as f32);
    in_f32::DiscView { horizon, far, dips: disc.dips, margin: disc.margin as f32, lift: disc.lift as f32 }
}

fn share_in_f32(disc: in_f64::DiscView, corners: [DVec3; 3]) -> f64 {
    f64::from(in_f32::triangle_share(short(disc), corners.map(|p| p.as_vec3())))
}

fn share(disc: in_f64::DiscView, corners: [DVec3; 3]) -> f64 {
    in_f64::triangle_share(disc, corners)
}

#[test]
fn a_triangle_hides_what_its_columns_hide() {
    let mut random = Random(1);
    let (mut largest, mut largest_in_f32, mut hidden) = (0.0_f64, 0.0_f64, 0);
    for spread in [0.2, 1.0, 3.0] {
        for _ in 0..800 {
            let (disc, corners) = (any_view(&mut random), any_corners(&mut random, spread));
            let right = share_by_columns(disc, corners);
            let own = share(disc, corners);
            hidden += i32::from(right.abs() > 1e-3);
            assert!((own - right).abs() < 1e-4, "{own} for {right}: {corners:?} {}", disc.horizon);
            largest = largest.max((own - right).abs());
            largest_in_f32 = largest_in_f32.max((share_in_f32(disc, corners) - own).abs());
        }
    }
    println!("against columns {largest:.1e}, f32 against f64 {largest_in_f32:.1e}; {hidden} hide something");
    assert!(hidden > 300);
    assert!(largest_in_f32 < 1e-5, "{largest_in_f32}");
}

#[test]
fn what_is_above_the_horizon_is_a_segment() {
    for i in -13..=13 {
        let q = f64::from(i) / 10.0;
        // Everything that a huge triangle hides above the horizon.
        let horizon = DVec3::new(0.6, 0.8, q);
        let disc = in_f64::DiscView { horizon, far: 1.0, dips: q.abs() < 1.0, margin: 0.0, lift: 0.0 };
        let all = [DVec3::new(-9.0, -9.0, 0.5), DVec3::new(9.0, -9.0, 0.5), DVec3::new(0.0, 9.0, 0.5)];
        let above = in_f64::share_above(q);
        if disc.dips {
            assert!((share(disc, all) - above).abs() < 1e-12, "{q}");
        }
        assert!((f64::from(in_f32::share_above(q as f32)) - above).abs() < 1e-6, "{q}");
    }
    assert_eq!((in_f64::share_above(2.0), in_f64::share_above(-2.0)), (1.0, 0.0));
}

/// Edges and corners pass the centre in steps down to nothing: neither f64 nor f32 jumps, whatever side they are taken for.
#[test]
fn edges_and_corners_pass_the_centre_without_a_jump() {
    let disc = in_f64::DiscView { horizon: DVec3::ZERO, far: 1.0, dips: false, margin: 0.0, lift: 0.0 };
    let offsets = [-1e-3, -1e-5, -1e-7, -1e-9, -1e-20, 0.0, 1e-20, 1e-9, 1e-7, 1e-5, 1e-3];
    let pairs = offsets.iter().flat_map(|x| offsets.iter().map(move |y| DVec2::new(*x, *y)));
    for (offset, turn) in pairs.flat_map(|offset| (0..12).map(move |turn| (offset, turn))) {
        let turned =
            |p: DVec2| (DVec2::from_angle(f64::from(turn) * 0.55).rotate(p) + offset).extend(1.0) * 0.5;
        // An edge through the centre hides a half, a right-angled corner a quarter.
        for (corners, right) in [
            ([DVec2::new(-5.0, 0.0), DVec2::new(7.0, 0.0), DVec2::new(0.0, 9.0)], 0.5),
            ([DVec2::ZERO, DVec2::new(5.0, 0.0), DVec2::new(0.0, 5.0)], 0.25),
        ] {
            let corners = corners.map(turned);
            let tolerance = offset.length() + 1e-5;
            for own in [share(disc, corners), share_in_f32(disc, corners)] {
                assert!((own - right).abs() < tolerance, "{own} for {right} at {offset}, turned {turn}");
            }
        }
    }
}

/// Edges, and the layers over the centre, say as much as the triangles do: also of what the horizon cuts.
#[test]
fn a_chain_hides_what_its_triangles_hide() {
    let mut random = Random(5);
    let (mut largest, mut dipping) = (0.0_f64, 0);
    for round in 0..3000 {
        let disc = in_f64::DiscView { far: 1e6, ..any_view(&mut random) };
        let spread = [0.1, 0.5, 1.5][round % 3];
        // A fan of triangles round a corner, not all of them ccw, cut open.
        let middle = any_corners(&mut random, spread)[0];
        let rim: Vec<DVec3> = (0..6).map(|_| middle + random.point() * spread).collect();
        let triangles: Vec<[usize; 3]> = (0..5).map(|i| [6, i, i + 1]).collect();
        let point = |i: usize| if i == 6 { middle } else { rim[i] };
        let right: f64 = triangles.iter().map(|t| share(disc, t.map(point))).sum();
        let mut weights = std::collections::BTreeMap::new();
        let mut over_centre = 0.0;
        for t in &triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                *weights.entry((a.min(b), a.max(b))).or_insert(0.0) += if a < b { 1.0 } else { -1.0 };
            }
            let [a, b, c] = t.map(point);
            let lines = [a.cross(b).z, b.cross(c).z, c.cross(a).z];
            let ccw = a.dot(b.cross(c)) > 0.0;
            if lines.iter().all(|z| (*z >= 0.0) == ccw) {
                over_centre += if ccw { 1.0 } else { -1.0 };
            }
        }
        let kept = weights.iter().filter(|(_, weight)| **weight != 0.0);
        let edges: Vec<([DVec3; 2], f64)> =
            kept.map(|((a, b), weight)| ([point(*a), point(*b)], *weight)).collect();
        let own = in_f64::chain_share(disc, over_centre, &edges);
        assert!((own - right).abs() < 1e-9, "round {round}: {own} for {right}, horizon {}", disc.horizon);
        let in_f32 = in_f32::chain_share(
            short(disc),
            over_centre as f32,
            &edges
                .iter()
                .map(|(ends, weight)| (ends.map(|p| p.as_vec3()), *weight as f32))
                .collect::<Vec<_>>(),
        );
        largest = largest.max((f64::from(in_f32) - right).abs());
        dipping += i32::from(disc.dips && right != 0.0);
    }
    println!("f32 {largest:.1e}; the horizon cuts {dipping}");
    assert!(largest < 1e-5 && dipping > 500, "{largest:.1e}, {dipping}");
}
