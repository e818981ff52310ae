//! Which parts of the scene's meshes a frame shows.

use glam::DVec3;

use crate::math::Aabb;
use crate::plan::{Geometry, SurfaceStyle};
use crate::scene::Posed;
use crate::shadow::View;

/// The visible parts of a posed scene, opaque and blended apart.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surfaces {
    /// (instance, part), in drawing order.
    pub(crate) opaque: Vec<(u32, u32)>,
    /// Transparent: (instance, part), far to near.
    pub(crate) blended: Vec<(u32, u32)>,
    /// The same in drawing order.
    pub(crate) transparent: Vec<(u32, u32)>,
    /// Instances with an opaque part, in drawing order.
    pub(crate) opaque_instances: Vec<u32>,
    /// Instances outside the frustum.
    pub(crate) outside: usize,
}

impl Surfaces {
    /// The parts of `posed` that the camera may see.
    pub(crate) fn of(posed: &Posed, view: &View) -> Self {
        let mut surfaces = Self::default();
        let mut blended: Vec<(f64, (u32, u32))> = Vec::new();
        let eye = view.camera.world_from_view.translation;
        let forward = view.camera.world_from_view.transform_vector3(DVec3::NEG_Z);
        for (index, instance) in posed.instances.iter().enumerate() {
            if !view.frustum.may_see(&instance.world_bounds) {
                surfaces.outside += 1;
                continue;
            }
            let parts = instance.materials.iter().enumerate();
            for (part, material) in
                parts.filter(|(part, _)| !instance.mesh.data().parts[*part].triangles.is_empty())
            {
                let key = (index as u32, part as u32);
                if material.is_opaque() {
                    surfaces.opaque.push(key);
                    if surfaces.opaque_instances.last() != Some(&key.0) {
                        surfaces.opaque_instances.push(key.0);
                    }
                } else {
                    blended.push(((instance.world_bounds.center() - eye).dot(forward), key));
                }
            }
        }
        surfaces.transparent = blended.iter().map(|(_, key)| *key).collect();
        // Of those as far away, the first drawn is the nearer.
        blended.sort_by(|a, b| b.0.total_cmp(&a.0).then(b.1.cmp(&a.1)));
        surfaces.blended = blended.into_iter().map(|(_, key)| key).collect();
        surfaces
    }

    /// The geometry of `parts` in `style`.
    pub(crate) fn geometry(posed: &Posed, style: SurfaceStyle, parts: &[(u32, u32)]) -> Geometry {
        let triangles = |&(instance, part): &(u32, u32)| {
            posed.instances[instance as usize].mesh.data().parts[part as usize].triangles.len() as u64
        };
        let vertices = parts.iter().map(triangles).sum::<u64>() * 3;
        Geometry::Surfaces { style, parts: parts.to_vec(), vertices }
    }
}

/// The box around everything in view that may receive a shadow.
pub(crate) fn receiver_bounds(posed: &Posed, frustum: &crate::math::ViewFrustum) -> Aabb {
    let receiving = posed.instances.iter().filter(|i| i.shadow.receives && frustum.may_see(&i.world_bounds));
    receiving.fold(Aabb::EMPTY, |bounds, instance| bounds.union(&instance.world_bounds))
}
