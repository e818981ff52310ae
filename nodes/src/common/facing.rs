//! A caster as it stands in the world, and how its triangles face a light.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use glam::{DVec3, DVec4};
use shadowgraph_engine::geometry::{FacingPlanes, facing_signs};
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{LightContext, hash_of};

use super::volume::{CastShape, Half};

/// A caster's vertices in the world, and the planes of its triangles once they are asked about again: made for one light in one
/// place they would cost more than they spare.
#[derive(Debug)]
struct Pose {
    p_in_world: Arc<Vec<DVec3>>,
    is_known: AtomicBool,
    planes: OnceLock<FacingPlanes>,
}

impl Pose {
    /// Kept until the caster moves, or nothing asks any more.
    fn of(light: &LightContext<'_>, instance: &Instance, shape: &CastShape<'_>) -> Arc<Self> {
        let key = hash_of((instance.pose_key, std::mem::discriminant(shape)));
        light.cache.get_or_compute("pose", key, || {
            let in_world = |p: &glam::Vec3| instance.world_from_local.transform_point3(p.as_dvec3());
            let p_in_world = Arc::new(instance.mesh.positions().iter().map(in_world).collect());
            Self { p_in_world, is_known: AtomicBool::new(false), planes: OnceLock::new() }
        })
    }

    fn signs(&self, triangles: &[[u32; 3]], light: DVec4) -> Vec<i8> {
        if !self.is_known.swap(true, Ordering::Relaxed) {
            return facing_signs(&self.p_in_world, triangles, light);
        }
        let planes = self.planes.get_or_init(|| FacingPlanes::new(&self.p_in_world, triangles));
        planes.signs(&self.p_in_world, triangles, light)
    }
}

/// The facing signs of one caster towards one light, and which triangles cast; kept between frames.
#[derive(Clone, Debug)]
pub struct CasterFacing {
    /// Welded vertices in the world.
    pub p_in_world: Arc<Vec<DVec3>>,
    /// The sign of every triangle that is cast, 0 for the others.
    pub signs: Vec<i8>,
    /// The triangles with a sign other than 0.
    pub cast: Vec<u32>,
    /// The triangles that hold the light in their plane, or have no area.
    pub edge_on: Vec<u32>,
    /// Which triangles were asked to cast.
    pub half: Half,
}

impl CasterFacing {
    /// The facing signs of `instance`, with the triangles of `shape`, towards `light`; of those in `half`. Triangles
    /// that do not block light as a whole (masked, blended, unlit ones) are not cast.
    pub fn new(light: &LightContext<'_>, instance: &Instance, shape: &CastShape<'_>, half: Half) -> Self {
        Self::of_parts(light, instance, shape, half, |part| instance.materials[part].casts_whole())
    }

    /// As [`CasterFacing::new`], of the parts whose number `casts` accepts.
    pub fn of_parts(
        light: &LightContext<'_>,
        instance: &Instance,
        shape: &CastShape<'_>,
        half: Half,
        casts: impl Fn(usize) -> bool,
    ) -> Self {
        let pose = Pose::of(light, instance, shape);
        let signs = pose.signs(shape.topology().triangles(), light.light().position);
        let (mut edge_on, mut cast) = (Vec::new(), Vec::with_capacity(signs.len()));
        for (triangle, sign) in signs.iter().enumerate() {
            if *sign == 0 {
                edge_on.push(triangle as u32);
            }
        }
        let signs = shape.of_parts(instance, shape.signs_of(instance, signs, half), casts);
        for (triangle, sign) in signs.iter().enumerate() {
            if *sign != 0 {
                cast.push(triangle as u32);
            }
        }
        Self { p_in_world: Arc::clone(&pose.p_in_world), signs, cast, edge_on, half }
    }
}
