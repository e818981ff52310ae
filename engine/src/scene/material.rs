//! Metallic-roughness materials and the images they wear.

use glam::{Vec2, Vec3, Vec4};

use super::ImageKey;

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
    /// Its edge goes on.
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

impl Default for UvTransform {
    fn default() -> Self {
        Self { offset: Vec2::ZERO, rotation_rad: 0.0, scale: Vec2::ONE }
    }
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
    /// How texture coordinates are transformed.
    pub transform: UvTransform,
}

impl TextureRef {
    /// The image, repeated and smooth.
    pub fn new(image: ImageKey) -> Self {
        Self { image, wrap: [Wrap::Repeat; 2], smooth: true, transform: UvTransform::default() }
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
        }
    }
}

impl Material {
    /// A matt material of one linear colour.
    pub fn matt(name: &str, color: Vec3) -> Self {
        Self { name: name.into(), base_color: color.extend(1.0), ..Self::default() }
    }

    /// Whether surfaces of it hide what is behind and enter the depth buffer.
    pub fn is_opaque(&self) -> bool {
        !matches!(self.alpha_mode, AlphaMode::Blend) && self.transmission == 0.0
    }
}
