//! Every generated solid is closed and wound outwards, and normals agree with the winding.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::{DVec3, Vec2, Vec3};

use super::*;

/// Welded directed edges without a partner, and the volume enclosed.
fn leaks_and_volume(data: &MeshData) -> (usize, f64) {
    let key = |p: Vec3| (p + 0.0).to_array().map(f32::to_bits);
    let mut balance: HashMap<_, i32> = HashMap::new();
    let mut volume = 0.0;
    for corners in data.indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| data.positions[corners[i] as usize]);
        for (p, q) in [(a, b), (b, c), (c, a)].map(|(p, q)| (key(p), key(q))) {
            *balance.entry((p.min(q), p.max(q))).or_default() += if p < q { 1 } else { -1 };
        }
        volume += a.as_dvec3().dot(b.as_dvec3().cross(c.as_dvec3())) / 6.0;
    }
    (balance.values().filter(|sum| **sum != 0).count(), volume)
}

#[test]
fn solids_are_closed_and_wound_outwards() {
    let l_shape = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let pi = TAU * 0.5;
    for (data, volume) in [
        (cuboid(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)), 6.0),
        (uv_sphere(1.0, 96, 48), pi * 4.0 / 3.0),
        (icosphere(1.0, 4), pi * 4.0 / 3.0),
        (cylinder(1.0, 2.0, 128, Ends::Closed), pi * 2.0),
        (cone(1.0, 3.0, 128, Ends::Closed), pi),
        (torus(2.0, 0.5, 96, 48), pi * pi),
        (torus_knot([2, 3], 1.0, 0.1, [256, 24]), 0.0),
        (extruded(&l_shape.map(Vec2::from), -0.5, 0.5), 3.0),
    ] {
        let (leaks, found) = leaks_and_volume(&data);
        assert_eq!(leaks, 0, "{}", data.name);
        assert!(
            found > 0.1 && (volume == 0.0 || (found - volume).abs() < 0.01 * volume),
            "{}: {found}",
            data.name
        );
    }
    assert!(leaks_and_volume(&cylinder(1.0, 2.0, 8, Ends::Top)).0 == 8);
}

#[test]
fn normals_agree_with_the_winding() {
    for data in [
        cuboid(Vec3::ZERO, Vec3::ONE),
        uv_sphere(1.0, 24, 12),
        icosphere(1.0, 2),
        cone(1.0, 1.0, 24, Ends::Bottom),
        torus_knot([2, 3], 1.0, 0.2, [96, 12]),
        sheet(8, 8, |u, v| Vec3::new(u, 0.1 * (u * 6.0).sin(), -v)),
        plane(Vec2::ONE).transformed(&glam::DAffine3::from_scale(DVec3::new(-1.0, 2.0, 1.0))),
    ] {
        assert_eq!(data.normals.len(), data.positions.len());
        for corners in data.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| data.positions[corners[i] as usize]);
            let face = (b - a).cross(c - a).normalize();
            assert!(corners.iter().all(|i| data.normals[*i as usize].dot(face) > 0.3), "{}", data.name);
        }
    }
}
