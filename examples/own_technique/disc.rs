//! Recognising a disc: the circle behind a mesh, or why there is none.

use glam::{DVec3, Vec2, Vec3};
use shadowgraph::engine::geometry::MeshData;
use shadowgraph::engine::scene::Instance;
use thiserror::Error;

/// How far a vertex may lie off the plane or the circle, as a fraction of the radius.
const ROUNDNESS: f64 = 1e-4;
/// The widest step between neighbouring rim vertices. At 15° the mesh's straight edges leave the circle by 0.9 % of the
/// radius; a half disc leaves a gap of 180°.
const WIDEST_STEP_RAD: f64 = std::f64::consts::TAU / 24.0;
/// How much of the disc the triangles may leave bare or cover twice.
const COVERAGE: f64 = 1e-3;

/// A flat round disc in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Disc {
    pub(crate) center: DVec3,
    /// Of unit length, on either side.
    pub(crate) normal: DVec3,
    pub(crate) radius_m: f64,
}

/// Why a mesh is no disc.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum NoDisc {
    #[error("it is no flat round disc: it has no area")]
    NoArea,
    #[error("it is no flat round disc: vertex {vertex} lies {height_m:.3e} m off the plane of the others")]
    NotFlat { vertex: usize, height_m: f64 },
    #[error(
        "it is no flat round disc: vertex {vertex} is {distance_m:.4} m from the centre, neither 0 nor the radius {radius_m:.4} m"
    )]
    NotRound { vertex: usize, distance_m: f64, radius_m: f64 },
    #[error("it is no flat round disc: its rim leaves out {gap_deg:.1} degrees (at most 15 are accepted)")]
    Gap { gap_deg: f64 },
    #[error("it is no flat round disc: its triangles cover {percent:.1} % of what its rim encloses")]
    Coverage { percent: f64 },
}

impl Disc {
    /// The disc that `instance` is, in the world: a disc under a non-uniform scale is an ellipse, and refused.
    pub(crate) fn of(instance: &Instance) -> Result<Self, NoDisc> {
        let mesh = &instance.mesh;
        let positions: Vec<DVec3> =
            (0..mesh.positions().len() as u32).map(|vertex| instance.world_position(vertex)).collect();
        let disc = Self::through(&positions).ok_or(NoDisc::NoArea)?;
        let mut angles_rad = Vec::new();
        let side = disc.normal.any_orthonormal_vector();
        for (vertex, position) in positions.iter().enumerate() {
            let from_center = *position - disc.center;
            let (height_m, distance_m) = (from_center.dot(disc.normal), from_center.length());
            let tolerance_m = ROUNDNESS * disc.radius_m;
            if height_m.abs() > tolerance_m {
                return Err(NoDisc::NotFlat { vertex, height_m });
            }
            if (distance_m - disc.radius_m).abs() <= tolerance_m {
                let across = from_center.dot(disc.normal.cross(side));
                angles_rad.push(across.atan2(from_center.dot(side)));
            } else if distance_m > tolerance_m {
                return Err(NoDisc::NotRound { vertex, distance_m, radius_m: disc.radius_m });
            }
        }
        angles_rad.sort_unstable_by(f64::total_cmp);
        let around = angles_rad.first().map(|first| first + std::f64::consts::TAU);
        let steps_rad: Vec<f64> =
            angles_rad.iter().zip(angles_rad.iter().skip(1).chain(&around)).map(|(a, b)| b - a).collect();
        let gap_rad = steps_rad.iter().copied().fold(0.0, f64::max);
        if gap_rad > WIDEST_STEP_RAD * (1.0 + ROUNDNESS) {
            return Err(NoDisc::Gap { gap_deg: gap_rad.to_degrees() });
        }
        let enclosed: f64 =
            steps_rad.iter().map(|step| step.sin()).sum::<f64>() * 0.5 * disc.radius_m.powi(2);
        let covered: f64 = (0..mesh.triangle_count())
            .map(|triangle| {
                let [a, b, c] = mesh.triangle(triangle).map(|vertex| positions[vertex as usize]);
                (b - a).cross(c - a).length() * 0.5
            })
            .sum();
        if (covered / enclosed - 1.0).abs() > COVERAGE {
            return Err(NoDisc::Coverage { percent: covered / enclosed * 100.0 });
        }
        Ok(disc)
    }

    /// The circle through three of `positions` that lie far apart: all on the rim, if this is a disc.
    fn through(positions: &[DVec3]) -> Option<Self> {
        let middle = positions.iter().sum::<DVec3>() / positions.len().max(1) as f64;
        let farthest = |measure: &dyn Fn(DVec3) -> f64| {
            positions.iter().copied().max_by(|p, q| measure(*p).total_cmp(&measure(*q)))
        };
        let a = farthest(&|p| p.distance_squared(middle))?;
        let b = farthest(&|p| p.distance_squared(a))?;
        let c = farthest(&|p| (p - a).cross(b - a).length_squared())?;
        let (to_b, to_c) = (b - a, c - a);
        let across = to_b.cross(to_c);
        let normal = across.try_normalize()?;
        let to_center = (to_c * to_b.length_squared() - to_b * to_c.length_squared()).cross(across)
            / (2.0 * across.length_squared());
        Some(Self { center: a + to_center, normal, radius_m: to_center.length() })
    }
}

/// A disc around the origin in the plane y = 0: a fan of `segments` triangles about its centre, facing up.
pub(crate) fn disc_mesh(name: &str, radius_m: f32, segments: u32) -> MeshData {
    let rim = (0..segments).map(|i| {
        let angle = f64::from(i) / f64::from(segments) * std::f64::consts::TAU;
        Vec2::new(angle.cos() as f32, -angle.sin() as f32) * radius_m
    });
    let positions: Vec<Vec3> =
        std::iter::once(Vec3::ZERO).chain(rim.map(|p| Vec3::new(p.x, 0.0, p.y))).collect();
    let indices = (0..segments).flat_map(|i| [0, 1 + i, 1 + (i + 1) % segments]).collect();
    MeshData {
        name: name.into(),
        normals: vec![Vec3::Y; positions.len()],
        positions,
        indices,
        ..MeshData::default()
    }
}
