//! Where the vertices of a part with holes or of glass are in its texture, and what their own colour is.

use glam::{DVec2, DVec3, DVec4, Vec2};
use shadowgraph_engine::scene::{AlphaMode, Instance, Material, TexCoord, TextureRef};

/// How alpha counts, as `passing_surface` of common/transmission.wgsl knows it, and the cutoff of masks.
pub fn alpha_mode_of(material: &Material) -> (u32, f32) {
    match material.alpha_mode {
        AlphaMode::Opaque => (0, 0.0),
        AlphaMode::Mask { cutoff } => (1, cutoff),
        AlphaMode::Blend => (2, 0.0),
    }
}

/// The vertices of an instance, as a texture of one of its materials is laid over them.
pub struct MaskVertices<'a> {
    instance: &'a Instance,
    uvs: &'a [Vec2],
    rows: [DVec3; 2],
}

impl<'a> MaskVertices<'a> {
    /// Under `texture`; without one, coordinates are the mesh's own.
    pub fn new(instance: &'a Instance, texture: Option<&TextureRef>) -> Self {
        let mesh = instance.mesh.data();
        let uvs = match texture.map(|texture| texture.tex_coord) {
            Some(TexCoord::Second) => &mesh.second_uvs,
            _ => &mesh.uvs,
        };
        let rows = texture.map(|texture| texture.transform).unwrap_or_default().rows();
        Self { instance, uvs, rows: rows.map(|row| row.as_dvec3()) }
    }

    /// Its texture coordinates, transformed.
    pub fn uv(&self, vertex: u32) -> DVec2 {
        let uv = self.uvs.get(vertex as usize).copied().unwrap_or_default().as_dvec2().extend(1.0);
        DVec2::new(self.rows[0].dot(uv), self.rows[1].dot(uv))
    }

    /// Its colour: linear red, green and blue, and alpha, 0 to 1.
    pub fn color(&self, vertex: u32) -> DVec4 {
        DVec4::from_array(self.instance.mesh.color8(vertex).map(|byte| f64::from(byte) / 255.0))
    }

    /// The alpha of its colour, 0 to 1.
    pub fn alpha(&self, vertex: u32) -> f64 {
        self.color(vertex).w
    }
}
