//! The short ways to put things into a scene, all at the root.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::{Camera, Content, Light, Material, MeshNode, NodeKey, Scene, ShadowNode, look_at};
use crate::geometry::Mesh;

impl Scene {
    /// Adds an empty group at the root.
    pub fn add_group(&mut self, name: &str) -> NodeKey {
        self.add(None, name, DAffine3::IDENTITY, Content::Group)
    }

    /// Adds `mesh` in one `material` at the root, placed by `world_from_local`.
    pub fn add_mesh(&mut self, mesh: Mesh, material: Material, world_from_local: DAffine3) -> NodeKey {
        let name = mesh.name().to_owned();
        let mesh = self.add_mesh_data(Arc::new(mesh));
        let material = self.add_material(material);
        self.add(None, &name, world_from_local, Content::Mesh(MeshNode::new(mesh, material)))
    }

    /// Adds a light at the root, at `position` and shining towards `target`.
    pub fn add_light(&mut self, light: Light, position: DVec3, target: DVec3) -> NodeKey {
        let name = light.name.clone();
        let key = self.add_light_data(light);
        self.add(None, &name, look_at(position, target), Content::Light(key))
    }

    /// Adds a light at the root that shines in all directions and so needs no target. A light that has a direction
    /// shines along −z; [`Scene::add_light`] aims it.
    pub fn add_lamp(&mut self, light: Light, position: DVec3) -> NodeKey {
        self.add_light(light, position, position - DVec3::Z)
    }

    /// Adds a camera at the root, at `eye` and looking at `target`.
    pub fn add_camera(&mut self, camera: Camera, eye: DVec3, target: DVec3) -> NodeKey {
        let name = camera.name.clone();
        let key = self.add_camera_data(camera);
        self.add(None, &name, look_at(eye, target), Content::Camera(key))
    }

    /// Adds a shadow node at the root.
    pub fn add_shadow(&mut self, name: &str, shadow: impl Into<ShadowNode>) -> NodeKey {
        let key = self.add_shadow_data(shadow.into());
        self.add(None, name, DAffine3::IDENTITY, Content::Shadow(key))
    }
}
