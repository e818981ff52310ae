//! Metallic-roughness materials and the images they wear.

use std::sync::Arc;

use glam::{DVec3, DVec4, Vec2, Vec3, Vec4};

use super::{ImageKey, SurfaceFunction};

/// How a material treats alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// Texels below `cutoff` are holes.
    Mask {
        /// The smallest alpha that is there.
        cutoff: f32,
    },
    /// Alpha blends over what is behind.
    Blend,
}

/// What happens beyond the edge of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// It repeats.
    #[default]
    Repeat,
    /// It repeats mirrored.
    Mirror,
    /// The texels at its edge continue.
    Clamp,
}

/// `KHR_texture_transform`: uv' = offset + rotate(scale · uv).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// Added last.
    pub offset: Vec2,
    /// Counter-clockwise rotation as the extension defines it, in radians.
    pub rotation_rad: f32,
    /// Applied first.
    pub scale: Vec2,
}

impl UvTransform {
    /// The rows (x, y, z) of the map: u' = x₀·u + y₀·v + z₀, v' = x₁·u + y₁·v + z₁.
    pub fn rows(&self) -> [Vec3; 2] {
        // The extension's matrix: translation · rotation · scale, with v pointing down.
        let (sin, cos) = self.rotation_rad.sin_cos();
        let (scale, offset) = (self.scale, self.offset);
        [
            Vec3::new(cos * scale.x, sin * scale.y, offset.x),
            Vec3::new(-sin * scale.x, cos * scale.y, offset.y),
        ]
    }
}

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation_rad: 0.0, scale: Vec2::ONE }
    }
}

/// Which of a mesh's texture coordinates a texture lies on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TexCoord {
    /// [`crate::geometry::MeshData::uvs`].
    #[default]
    First,
    /// [`crate::geometry::MeshData::second_uvs`].
    Second,
}

/// A texture of a material: an image and how it is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// The image.
    pub image: ImageKey,
    /// What happens beyond the edges, in u and v.
    pub wrap: [Wrap; 2],
    /// Whether texels blend (true) or stay blocks (false) under magnification.
    pub smooth: bool,
    /// Which texture coordinates it lies on.
    pub tex_coord: TexCoord,
    /// How the texture coordinates are transformed.
    pub transform: UvTransform,
}

impl TextureRef {
    /// The image, repeated and smooth.
    pub fn new(image: ImageKey) -> Self {
        let (tex_coord, transform) = (TexCoord::First, UvTransform::default());
        Self { image, wrap: [Wrap::Repeat; 2], smooth: true, tex_coord, transform }
    }

    /// How its texels are read, as shaders have it (common/alpha_mask.wgsl): two bits of wrapping for u, two for v,
    /// one for blending.
    pub fn reading_bits(&self) -> u32 {
        let mode = |wrap| match wrap {
            Wrap::Repeat => 0,
            Wrap::Mirror => 1,
            Wrap::Clamp => 2,
        };
        mode(self.wrap[0]) | mode(self.wrap[1]) << 2 | u32::from(self.smooth) << 4
    }
}

/// A picture of 8-bit RGBA texels, top row first. Whether it is sRGB is decided by its use.
#[derive(Clone, PartialEq)]
pub struct Image {
    /// Its name in errors.
    pub name: String,
    /// Width in texels, at least 1.
    pub width: u32,
    /// Height in texels, at least 1.
    pub height: u32,
    /// 4·width·height bytes.
    pub rgba8: Vec<u8>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({:?}, {}x{})", self.name, self.width, self.height)
    }
}

/// A metallic-roughness material as glTF defines it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Linear base colour and alpha, multiplied with the texture (sRGB) and the vertex colour.
    pub base_color: Vec4,
    /// Base colour texture.
    pub base_color_texture: Option<TextureRef>,
    /// 0 dielectric, 1 metal; multiplied with the texture's blue channel.
    pub metallic: f32,
    /// 0 smooth, 1 rough; multiplied with the texture's green channel.
    pub roughness: f32,
    /// Metallic (b) and roughness (g) texture.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Linear emitted radiance, strength included.
    pub emissive: Vec3,
    /// Emissive texture (sRGB).
    pub emissive_texture: Option<TextureRef>,
    /// Tangent-space normals, with the scale of their x and y.
    pub normal_texture: Option<(TextureRef, f32)>,
    /// Ambient occlusion in the red channel, with its strength.
    pub occlusion_texture: Option<(TextureRef, f32)>,
    /// How alpha is used.
    pub alpha_mode: AlphaMode,
    /// Whether back faces are drawn.
    pub double_sided: bool,
    /// Drawn in its base colour whatever the light; casts and receives nothing.
    pub unlit: bool,
    /// `KHR_materials_transmission`: the fraction of light that passes, tinted by the base colour.
    pub transmission: f32,
    /// How it reflects light instead, in WGSL of its own.
    pub surface: Option<Arc<SurfaceFunction>>,
}

impl Default for Material {
    /// A matt, double-sided, light grey.
    fn default() -> Self {
        Self {
            name: "default".into(),
            base_color: Vec4::new(0.8, 0.8, 0.8, 1.0),
            base_color_texture: None,
            metallic: 0.0,
            roughness: 0.9,
            metallic_roughness_texture: None,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            normal_texture: None,
            occlusion_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: true,
            unlit: false,
            transmission: 0.0,
            surface: None,
        }
    }
}

impl Material {
    /// A matt material of one linear colour.
    pub fn matt(name: &str, color: Vec3) -> Self {
        Self { name: name.into(), base_color: color.extend(1.0), ..Self::default() }
    }

    /// The alpha below which it has holes; `None` without a mask.
    pub fn cutoff(&self) -> Option<f32> {
        match self.alpha_mode {
            AlphaMode::Mask { cutoff } => Some(cutoff),
            _ => None,
        }
    }

    /// Whether whole triangles of it block light.
    pub fn casts_whole(&self) -> bool {
        self.is_opaque() && !self.unlit && self.cutoff().is_none()
    }

    /// Whether all of its factors are finite.
    pub fn is_finite(&self) -> bool {
        let cutoff = match self.alpha_mode {
            AlphaMode::Mask { cutoff } => cutoff,
            _ => 0.0,
        };
        let scale = |texture: &Option<(TextureRef, f32)>| texture.map_or(0.0, |(_, scale)| scale);
        let scales = [scale(&self.normal_texture), scale(&self.occlusion_texture)];
        let scalars = [self.metallic, self.roughness, self.transmission, cutoff];
        let finite = scalars.iter().chain(&scales).all(|x| x.is_finite());
        finite && self.base_color.is_finite() && self.emissive.is_finite()
    }

    /// Whether triangles of it block light where their alpha mask has no hole.
    pub fn casts_by_texel(&self) -> bool {
        self.is_opaque() && !self.unlit && self.cutoff().is_some()
    }

    /// Whether surfaces of it hide what is behind and enter the depth buffer.
    pub fn is_opaque(&self) -> bool {
        !matches!(self.alpha_mode, AlphaMode::Blend) && self.transmission == 0.0
    }

    /// Whether light passes its surfaces and takes their colour on, so that they cast coloured shadows.
    pub fn is_transparent(&self) -> bool {
        !self.is_opaque() && !self.unlit
    }

    /// How much of its surface is there where the base colour has this `alpha`: 0 in a mask's holes, and where a blended
    /// surface's alpha is 0; 1 where alpha is ignored.
    pub fn coverage(&self, alpha: f64) -> f64 {
        match self.alpha_mode {
            AlphaMode::Opaque => 1.0,
            // Cutoffs are f32, and so are the products that shaders compare with them.
            AlphaMode::Mask { cutoff } => f64::from(u8::from(alpha as f32 >= cutoff)),
            AlphaMode::Blend => alpha.clamp(0.0, 1.0),
        }
    }

    /// What passes one crossing of its surface, red, green and blue, each from 0 to 1, where the base colour (linear;
    /// texture and vertex colour included) is `base_color`.
    ///
    /// A blended surface of alpha α lets (1 − α)·rgb pass (Kim, Kim & Turk, eq. 1), one of `KHR_materials_transmission`
    /// t·rgb, one of both (1 − α·(1 − t))·rgb. Where nothing is covered there is no surface, and everything passes: a
    /// step, since (1 − α)·rgb tends to rgb as α tends to 0. Opaque surfaces let nothing pass.
    pub fn transmission_at(&self, base_color: DVec4) -> DVec3 {
        let coverage = self.coverage(base_color.w);
        if coverage == 0.0 {
            return DVec3::ONE;
        }
        let share = 1.0 - coverage * (1.0 - f64::from(self.transmission));
        (base_color.truncate() * share).clamp(DVec3::ZERO, DVec3::ONE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_passes_is_what_mode_and_transmission_say() {
        let passes = |alpha_mode, transmission, base_color: [f64; 4]| {
            let material = Material { alpha_mode, transmission, ..Material::default() };
            material.transmission_at(base_color.into()).to_array()
        };
        let red = |alpha| [0.5, 0.25, 0.0, alpha];
        assert_eq!(passes(AlphaMode::Blend, 0.0, red(0.5)), [0.25, 0.125, 0.0]);
        assert_eq!(passes(AlphaMode::Blend, 0.0, red(1.0)), [0.0; 3]);
        assert_eq!(passes(AlphaMode::Blend, 0.0, red(0.0)), [1.0; 3]);
        assert_eq!(passes(AlphaMode::Opaque, 0.5, red(0.0)), [0.25, 0.125, 0.0]);
        assert_eq!(passes(AlphaMode::Opaque, 0.0, red(0.5)), [0.0; 3]);
        assert_eq!(passes(AlphaMode::Blend, 0.5, red(0.5)), [0.375, 0.1875, 0.0]);
        let mask = AlphaMode::Mask { cutoff: 0.5 };
        assert_eq!(passes(mask, 0.5, red(0.5)), [0.25, 0.125, 0.0]);
        assert_eq!(passes(mask, 0.5, red(0.4)), [1.0; 3]);
        // No more light than arrives.
        assert_eq!(passes(AlphaMode::Blend, 0.0, [3.0, -1.0, 0.5, 0.5]), [1.0, 0.0, 0.25]);
    }
}
