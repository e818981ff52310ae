//! The chapter's scenes are put together with these.

use glam::{DAffine3, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::{Mesh, MeshData, MeshError, shapes};
use shadowgraph_engine::scene::{AlphaMode, Camera, Light, Material, NodeKey, Scene};
use thiserror::Error;

/// Why a model could not be made.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("mesh '{name}': {reason}")]
pub struct ModelError {
    /// The mesh.
    pub name: String,
    /// What is wrong with it.
    #[source]
    pub reason: MeshError,
}

/// Adds a mesh where its vertices are.
pub(super) fn add(scene: &mut Scene, data: MeshData, material: Material) -> Result<NodeKey, ModelError> {
    add_at(scene, data, material, DVec3::ZERO)
}

/// Adds a mesh at a place.
pub(super) fn add_at(
    scene: &mut Scene,
    data: MeshData,
    material: Material,
    place: DVec3,
) -> Result<NodeKey, ModelError> {
    let name = data.name.clone();
    let mesh = Mesh::new(data).map_err(|reason| ModelError { name, reason })?;
    Ok(scene.add_mesh(mesh, material, DAffine3::from_translation(place)))
}

/// A matt material.
pub(super) fn matt(color: Vec3) -> Material {
    Material::matt("matt", color)
}

/// Of a surface (1 − `alpha`)·`color` of the light passes.
pub(super) fn glass(color: Vec3, alpha: f32) -> Material {
    let base_color = color.extend(alpha);
    Material { base_color, alpha_mode: AlphaMode::Blend, roughness: 0.25, ..Material::matt("glass", color) }
}

/// A box.
pub(super) fn block(min: [f32; 3], max: [f32; 3]) -> MeshData {
    shapes::cuboid(Vec3::from(min), Vec3::from(max))
}

/// A box without its upper side.
pub(super) fn open_box(min: [f32; 3], max: [f32; 3]) -> MeshData {
    let data = block(min, max);
    let top = |triangle: usize| {
        let corners = &data.indices[triangle * 3..triangle * 3 + 3];
        corners.iter().all(|corner| data.positions[*corner as usize].y == max[1])
    };
    let gone: Vec<bool> = (0..data.indices.len() / 3).map(top).collect();
    data.without_triangles(|triangle| gone[triangle])
}

/// A floor that reaches `half_m` to each side.
pub(super) fn floor(scene: &mut Scene, half_m: f32) -> Result<NodeKey, ModelError> {
    add(scene, shapes::plane(Vec2::splat(half_m)).named("floor"), matt(Vec3::splat(0.7)))
}

/// A floor, a lamp that lights its middle as brightly wherever it is, and an eye.
pub(super) fn stage(half_m: f32, lamp: DVec3, [eye, target]: [DVec3; 2]) -> Result<Scene, ModelError> {
    let mut scene = Scene::new();
    floor(&mut scene, half_m)?;
    scene.add_lamp(Light::point("lamp", (lamp.length_squared() * 12.0) as f32), lamp);
    scene.add_camera(Camera::perspective("main", 0.75), eye, target);
    Ok(scene)
}
