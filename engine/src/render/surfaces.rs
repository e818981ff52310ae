//! Which parts of the scene's meshes a frame shows.

use glam::DVec3;

use super::schedule::Inputs;
use crate::math::Aabb;
use crate::plan::{DrawState, PulledStyle, Shader, ShaderError, SurfaceStyle};
use crate::scene::SceneSnapshot;
use crate::shadow::{Binding, Draw, Geometry, View};

/// The visible parts of a scene's snapshot, opaque and blended apart.
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
    /// The parts of `snapshot` that the camera may see.
    pub(crate) fn of(snapshot: &SceneSnapshot, view: &View) -> Self {
        let mut surfaces = Self::default();
        let mut blended: Vec<(f64, (u32, u32))> = Vec::new();
        let eye = view.camera.world_from_view.translation;
        let forward = view.camera.world_from_view.transform_vector3(DVec3::NEG_Z);
        for (index, instance) in snapshot.instances.iter().enumerate() {
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

    /// Whether an opaque surface in view has alpha-masked parts.
    pub(super) fn have_holes(&self, snapshot: &SceneSnapshot) -> bool {
        self.opaque_instances.iter().any(|instance| snapshot.instances[*instance as usize].is_masked())
    }
}

/// The vertices of `parts`.
fn vertices(snapshot: &SceneSnapshot, parts: &[(u32, u32)]) -> u64 {
    let triangles = |&(instance, part): &(u32, u32)| {
        snapshot.instances[instance as usize].mesh.data().parts[part as usize].triangles.len() as u64
    };
    parts.iter().map(triangles).sum::<u64>() * 3
}

impl Inputs<'_> {
    /// `parts` in `style`.
    pub(super) fn shown(&self, style: SurfaceStyle, parts: &[(u32, u32)]) -> Geometry {
        Geometry::Surfaces { style, parts: parts.to_vec(), vertices: vertices(self.snapshot, parts) }
    }

    /// All opaque surfaces in `style`.
    pub(super) fn opaque(&self, style: SurfaceStyle) -> Geometry {
        self.shown(style, &self.surfaces.opaque)
    }

    /// All transparent surfaces, in the order of the scene, in `style`.
    pub(super) fn transparent(&self, style: SurfaceStyle) -> Geometry {
        self.shown(style, &self.surfaces.transparent)
    }

    /// `parts` as a shader pulls them.
    pub(super) fn pulled(&self, shader: Shader, style: PulledStyle, parts: &[(u32, u32)]) -> Geometry {
        Geometry::PulledSurfaces {
            shader,
            style,
            parts: parts.to_vec(),
            vertices: vertices(self.snapshot, parts),
        }
    }

    /// Opaque `parts` as (module, flags, fragment entry point) pulls them: runs with and without holes, in the order of
    /// drawing.
    pub(super) fn pulled_runs(
        &self,
        parts: &[(u32, u32)],
        (shader, flags, fragment): (&'static str, &[&str], &'static str),
        state: &DrawState,
        bindings: &[(u32, Binding)],
    ) -> Result<Vec<Draw>, ShaderError> {
        let is_masked = |&(instance, part): &(u32, u32)| {
            self.snapshot.instances[instance as usize].materials[part as usize].cutoff().is_some()
        };
        let draw = |parts: &[(u32, u32)]| {
            // A mask without a texture reads a white one: no variant of its own.
            let masked: &[&str] = &["MASKED", "BASE_COLOR_TEXTURE", "SECOND_UV"];
            let (name, style, more) = if parts.first().is_some_and(is_masked) {
                ("masked surfaces", PulledStyle::PulledMasked, masked)
            } else {
                ("opaque surfaces", PulledStyle::Pulled, &[] as &[&str])
            };
            let shader = Shader::composed(shader, &[flags, more].concat(), "vertex", Some(fragment))?;
            let geometry = self.pulled(shader, style, parts);
            Ok(Draw::new(name, geometry, state.clone()).reading(bindings.to_vec()))
        };
        parts.chunk_by(|a, b| is_masked(a) == is_masked(b)).map(draw).collect()
    }
}

/// The box around everything in view that may receive a shadow.
pub(crate) fn receiver_bounds(snapshot: &SceneSnapshot, frustum: &crate::math::ViewFrustum) -> Aabb {
    let receiving =
        snapshot.instances.iter().filter(|i| i.shadow.receives && frustum.may_see(&i.world_bounds));
    receiving.fold(Aabb::EMPTY, |bounds, instance| bounds.union(&instance.world_bounds))
}
