//! The set a demo scene is built on: named shapes in shared materials, under groups.

use std::sync::Arc;

use glam::{DAffine3, DVec3, Vec3};
use shadowgraph_engine::geometry::shapes::cuboid;
use shadowgraph_engine::geometry::{Mesh, MeshData};
use shadowgraph_engine::scene::{
    AlphaMode, Content, Image, Material, MaterialKey, MeshKey, MeshNode, NodeKey, Scene, TextureRef, placed,
};

/// A scene under construction.
pub(super) struct Set {
    pub(super) scene: Scene,
}

impl Set {
    pub(super) fn new() -> Self {
        Self { scene: Scene::new() }
    }

    /// A material of one linear colour.
    pub(super) fn paint(&mut self, name: &str, color: [f32; 3], roughness: f32) -> MaterialKey {
        self.scene.add_material(Material { roughness, ..Material::matt(name, color.into()) })
    }

    /// A metal.
    pub(super) fn metal(&mut self, name: &str, color: [f32; 3], roughness: f32) -> MaterialKey {
        self.scene.add_material(Material { roughness, metallic: 1.0, ..Material::matt(name, color.into()) })
    }

    /// A material from a generated sRGB picture, by a function of the texel.
    pub(super) fn picture(
        &mut self,
        name: &str,
        [width, height]: [u32; 2],
        roughness: f32,
        texel: impl Fn(u32, u32) -> [u8; 3],
    ) -> MaterialKey {
        let opaque = |x, y| {
            let [r, g, b] = texel(x, y);
            [r, g, b, 255]
        };
        let base_color_texture = self.texture(name, [width, height], opaque);
        self.scene.add_material(Material { roughness, base_color_texture, ..Material::matt(name, Vec3::ONE) })
    }

    /// A material from a generated sRGB picture with holes where alpha is below one half.
    pub(super) fn cutout(
        &mut self,
        name: &str,
        size: [u32; 2],
        roughness: f32,
        texel: impl Fn(u32, u32) -> [u8; 4],
    ) -> MaterialKey {
        let base_color_texture = self.texture(name, size, texel);
        let alpha_mode = AlphaMode::Mask { cutoff: 0.5 };
        self.scene.add_material(Material {
            roughness,
            base_color_texture,
            alpha_mode,
            ..Material::matt(name, Vec3::ONE)
        })
    }

    fn texture(
        &mut self,
        name: &str,
        [width, height]: [u32; 2],
        texel: impl Fn(u32, u32) -> [u8; 4],
    ) -> Option<TextureRef> {
        let rgba8 = (0..width * height).flat_map(|i| texel(i % width, i / width)).collect();
        let image = self.scene.add_image(Arc::new(Image { name: name.into(), width, height, rgba8 }));
        Some(TextureRef::new(image))
    }

    /// Stores a shape that several nodes will share. Invalid data here is a mistake in a demo's own code, so it ends
    /// the program with the reason.
    pub(super) fn shape(&mut self, data: MeshData) -> MeshKey {
        let mesh =
            Mesh::new(data).unwrap_or_else(|error| panic!("a demo generates an invalid mesh: {error}"));
        self.scene.add_mesh_data(Arc::new(mesh))
    }

    /// A stored shape at a place under `group`.
    pub(super) fn place(
        &mut self,
        group: NodeKey,
        name: &str,
        shape: MeshKey,
        material: MaterialKey,
        place: DAffine3,
    ) -> NodeKey {
        self.scene.add(Some(group), name, place, Content::Mesh(MeshNode::new(shape, material)))
    }

    /// A shape of its own under `group`.
    pub(super) fn put(
        &mut self,
        group: NodeKey,
        name: &str,
        data: MeshData,
        material: MaterialKey,
        place: DAffine3,
    ) -> NodeKey {
        let shape = self.shape(data.named(name));
        self.place(group, name, shape, material, place)
    }
}

/// Standing at a place, turned about the vertical by `turn_deg`.
pub(super) fn stand(x: f64, y: f64, z: f64, turn_deg: f64) -> DAffine3 {
    placed(DVec3::new(x, y, z), glam::DQuat::from_rotation_y(turn_deg.to_radians()), DVec3::ONE)
}

/// The box between two corners.
pub(super) fn slab(min: [f32; 3], max: [f32; 3]) -> MeshData {
    cuboid(min.into(), max.into())
}

/// Several boxes as one mesh.
pub(super) fn slabs(name: &str, corners: &[([f32; 3], [f32; 3])]) -> MeshData {
    MeshData::merged(name, corners.iter().map(|(min, max)| slab(*min, *max)))
}
