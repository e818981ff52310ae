//! The scene at one moment, flattened: what the frame plan, the executor and the reference all work from.

use std::collections::HashMap;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{DAffine3, DMat4, DVec3, DVec4, Vec3};

use super::{
    Camera, CameraKey, Image, ImageKey, Light, LightKey, LightKind, Material, NodeKey, ShadowFlags,
    ShadowKey, ShadowNode,
};
use crate::geometry::Mesh;
use crate::math::{Aabb, Projection, ViewFrustum};

mod flatten;

/// A mesh at its place in the world.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The node it comes from.
    pub node: NodeKey,
    /// The node's name.
    pub name: String,
    /// The shape.
    pub mesh: Arc<Mesh>,
    /// One material for each of the mesh's parts, in order.
    pub materials: Vec<Arc<Material>>,
    /// Where it stands.
    pub world_from_local: DAffine3,
    /// The box around it in the world.
    pub world_bounds: Aabb,
    /// Whether it casts and receives (materials taken into account: unlit parts do neither).
    pub shadow: ShadowFlags,
    /// A hash of the shape and the transform: equal keys, equal world geometry.
    pub pose_key: u64,
}

impl Instance {
    /// Vertex `vertex` in the world, in f64: the f32 input under the f64 transform.
    pub fn world_position(&self, vertex: u32) -> DVec3 {
        self.world_from_local.transform_point3(self.mesh.positions()[vertex as usize].as_dvec3())
    }

    /// The transform to the world from the space in which shaders see the vertex positions.
    pub fn world_from_shader(&self) -> DAffine3 {
        self.world_from_local * DAffine3::from_translation(self.mesh.shader_origin())
    }

    /// The corners of `triangle` in the world.
    pub fn world_triangle(&self, triangle: usize) -> [DVec3; 3] {
        self.mesh.triangle(triangle).map(|vertex| self.world_position(vertex))
    }

    /// The material of `triangle`.
    pub fn material_of(&self, triangle: usize) -> &Arc<Material> {
        let part = self.mesh.data().parts.partition_point(|part| part.triangles.end as usize <= triangle);
        &self.materials[part]
    }

    /// Whether every part of it is opaque (hidden surfaces, depth, black shadows).
    pub fn is_opaque(&self) -> bool {
        self.materials.iter().all(|material| material.is_opaque())
    }

    /// Whether some part of it takes all light away where it is: as a whole, or texel by texel.
    pub fn blocks_light(&self) -> bool {
        self.materials.iter().any(|material| material.casts_whole() || material.casts_by_texel())
    }

    /// Whether any part of it is alpha-masked.
    pub fn is_masked(&self) -> bool {
        self.materials.iter().any(|material| material.cutoff().is_some())
    }
}

/// A light at its place in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct LightSnapshot {
    /// The node it comes from.
    pub node: NodeKey,
    /// Its key.
    pub key: LightKey,
    /// A name that no other light of this frame has and that is a plain file name.
    pub name: String,
    /// Colour, intensity, kind, range.
    pub light: Light,
    /// Homogeneous: (position, 1), or (unit direction *towards* the light, 0).
    pub position: DVec4,
    /// The unit direction in which it shines (for a point light, its node's −z).
    pub direction: DVec3,
}

impl LightSnapshot {
    /// Whether `point` lies within the light's range and cone; beyond them the factor is 1 and not compared.
    pub fn reaches(&self, point: DVec3) -> bool {
        if self.position.w == 0.0 {
            return true;
        }
        let from_light = point - self.position.truncate();
        let distance_m = from_light.length();
        if self.light.range_m.is_some_and(|range_m| distance_m > range_m) {
            return false;
        }
        match self.light.kind {
            LightKind::Spot { outer_rad, .. } => {
                from_light.dot(self.direction) >= distance_m * outer_rad.min(FRAC_PI_2).cos()
            }
            _ => true,
        }
    }

    /// Whether some point of `bounds` may lie within range and cone; false only when certainly none does.
    pub fn may_reach(&self, bounds: &Aabb) -> bool {
        if bounds.is_empty() {
            return false;
        }
        if self.position.w == 0.0 {
            return true;
        }
        let origin = self.position.truncate();
        if self.light.range_m.is_some_and(|range_m| bounds.distance(origin) > range_m) {
            return false;
        }
        let LightKind::Spot { outer_rad, .. } = self.light.kind else { return true };
        // A sphere misses the cone when the angle to its centre exceeds the cone's by more than its own.
        let (to_center, radius_m) = (bounds.center() - origin, bounds.radius());
        let distance_m = to_center.length();
        if distance_m <= radius_m {
            return true;
        }
        let off_axis_rad = (to_center.dot(self.direction) / distance_m).clamp(-1.0, 1.0).acos();
        off_axis_rad - (radius_m / distance_m).asin() <= outer_rad
    }
}

/// A camera at its place in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSnapshot {
    /// Its key; `None` for a camera that is not in the scene.
    pub key: Option<CameraKey>,
    /// Its name.
    pub name: String,
    /// Where it stands: a rigid transform, scale removed.
    pub world_from_view: DAffine3,
    /// How it projects.
    pub projection: Projection,
}

impl CameraSnapshot {
    /// A camera outside any scene, at `eye` looking at `target`.
    pub fn looking(camera: Camera, eye: DVec3, target: DVec3) -> Self {
        let world_from_view = super::content::look_at(eye, target);
        Self { key: None, name: camera.name, world_from_view, projection: camera.projection }
    }

    /// The same camera, seeing no farther than a scene with these bounds goes, and standing where that begins. An orthographic
    /// depth is equally coarse over its whole range, files often guess `zfar`, and positions from an eye far away
    /// have lost digits; where such an eye stands changes nothing else. A perspective depth gains nothing from this.
    pub fn fitted_to(&self, world_bounds: &Aabb) -> Self {
        let mut fitted = self.clone();
        if let Projection::Orthographic { near_m, far_m, .. } = &mut fitted.projection
            && !world_bounds.is_empty()
        {
            let view_from_world = self.world_from_view.inverse();
            let in_view = world_bounds.transformed(&view_from_world);
            let (nearest_m, farthest_m) = (-in_view.max.z, -in_view.min.z);
            // What is nearest is not to be cut off by a rounding, and what is farthest not to have the depth of where nothing is.
            let margin_m = (farthest_m - nearest_m) / 64.0;
            let (start_m, end_m) = (near_m.max(nearest_m - margin_m), far_m.min(farthest_m + margin_m));
            if end_m > start_m {
                // From the eye to the near plane as far as before, but no farther than the scene is deep.
                *near_m = near_m.min(end_m - start_m);
                *far_m = *near_m + (end_m - start_m);
                let forward = self.world_from_view.transform_vector3(DVec3::NEG_Z).normalize();
                fitted.world_from_view.translation += forward * (start_m - *near_m);
            }
        }
        fitted
    }

    /// The frustum for a target of this size in pixels.
    pub fn frustum(&self, size_px: [u32; 2]) -> ViewFrustum {
        let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
        ViewFrustum::new(&self.world_from_view, &self.projection, aspect)
    }

    /// From the world to the clip space of a target of this size in pixels.
    pub fn clip_from_world(&self, size_px: [u32; 2]) -> DMat4 {
        let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
        self.projection.clip_from_view(aspect) * DMat4::from(self.world_from_view.inverse())
    }
}

/// A shadow node with its scopes resolved to lights and instances of the scene's snapshot.
#[derive(Clone, Debug, PartialEq)]
pub struct ShadowNodeSnapshot {
    /// Its key.
    pub key: ShadowKey,
    /// The node's name.
    pub name: String,
    /// Technique and options.
    pub shadow: ShadowNode,
    /// Indices into [`SceneSnapshot::lights`], ascending.
    pub lights: Vec<usize>,
    /// Indices into [`SceneSnapshot::instances`], ascending; only instances that may cast.
    pub casters: Vec<usize>,
    /// Indices into [`SceneSnapshot::instances`], ascending; only instances that may receive.
    pub receivers: Vec<usize>,
}

/// The scene at one moment.
#[derive(Clone, Debug)]
pub struct SceneSnapshot {
    /// Every visible mesh, parents first: also the order of drawing.
    pub instances: Vec<Instance>,
    /// Every visible light.
    pub lights: Vec<LightSnapshot>,
    /// Every camera.
    pub cameras: Vec<CameraSnapshot>,
    /// Every visible shadow node.
    pub shadow_nodes: Vec<ShadowNodeSnapshot>,
    /// The box around all instances, in the world.
    pub world_bounds: Aabb,
    /// The images materials refer to.
    pub images: HashMap<ImageKey, Arc<Image>>,
    /// Ambient light, as in [`Scene::ambient`](super::Scene::ambient).
    pub ambient: Vec3,
    /// Background, as in [`Scene::background`](super::Scene::background).
    pub background: Vec3,
}
