//! Materials and their textures on the GPU.

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
#[cfg(test)]
use glam::Vec2;

use super::uniforms::layout;
use super::{Gpu, GpuError};
use crate::geometry::Mesh;
use crate::scene::{AlphaMode, Image, ImageKey, Material, TexCoord, TextureRef, Wrap};

/// `struct Material` of common/material.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct MaterialUniform {
    base_color: [f32; 4],
    emissive: [f32; 3],
    metallic: f32,
    roughness: f32,
    normal_scale: f32,
    occlusion_strength: f32,
    alpha_cutoff: f32,
    mask_reading: u32,
    uv_sets: u32,
    transmission: f32,
    blends: u32,
    uv_rows: [[f32; 4]; 10],
}

layout!(MaterialUniform: base_color, emissive, metallic, roughness, normal_scale, occlusion_strength, alpha_cutoff, mask_reading, uv_sets, transmission, blends, uv_rows);

/// The material textures, in the order of their bindings, and whether their colours are sRGB.
fn textures(material: &Material) -> [(Option<TextureRef>, bool); 5] {
    [
        (material.base_color_texture, true),
        (material.metallic_roughness_texture, false),
        (material.emissive_texture, true),
        (material.normal_texture.map(|(texture, _)| texture), false),
        (material.occlusion_texture.map(|(texture, _)| texture), false),
    ]
}

/// What a surface has, as bits: the shader is composed with the flags of [`FEATURE_FLAGS`] whose bits are set.
pub(crate) fn features(material: &Material, mesh: &Mesh, lights: usize) -> u32 {
    let mut bits = u32::from(material.unlit);
    bits |= u32::from(material.cutoff().is_some()) << MASKED;
    for (index, (texture, _)) in textures(material).iter().enumerate() {
        bits |= u32::from(texture.is_some()) << (index + 2);
    }
    bits |= u32::from(!mesh.data().colors.is_empty()) << 7;
    bits |= u32::from(lights > FEW_LIGHTS) << 8;
    bits |= u32::from(lights == 1) << 9;
    bits | u32::from(second_uvs(material) != 0) << 10
}

/// One bit for each texture that lies on the second texture coordinates.
fn second_uvs(material: &Material) -> u32 {
    let on_second = |texture: &Option<TextureRef>| texture.is_some_and(|t| t.tex_coord == TexCoord::Second);
    textures(material).iter().enumerate().map(|(i, (texture, _))| u32::from(on_second(texture)) << i).sum()
}

/// The bit of a material's own function, which only shading adds.
pub(crate) const SURFACE_FUNCTION: u32 = 11;

/// The bit of [`features`] for holes.
pub(crate) const MASKED: u32 = 1;

/// The shader flags of the bits of [`features`].
pub(crate) const FEATURE_FLAGS: [&str; 12] = [
    "UNLIT",
    "MASKED",
    "BASE_COLOR_TEXTURE",
    "METALLIC_ROUGHNESS_TEXTURE",
    "EMISSIVE_TEXTURE",
    "NORMAL_TEXTURE",
    "OCCLUSION_TEXTURE",
    "VERTEX_COLOR",
    "MANY_LIGHTS",
    "ONE_LIGHT",
    "SECOND_UV",
    "SURFACE_FUNCTION",
];

/// Up to so many lights the shorter array of common/lights does.
pub(crate) const FEW_LIGHTS: usize = 16;

/// The most lights a frame may have: the longer array of common/lights.
pub(crate) const MAX_LIGHTS: usize = 1024;

impl MaterialUniform {
    fn new(material: &Material) -> Self {
        let textures = textures(material);
        let mut uv_rows = [[0.0; 4]; 10];
        for (index, (texture, _)) in textures.iter().enumerate() {
            let rows = texture.map(|texture| texture.transform).unwrap_or_default().rows();
            for (row, values) in rows.iter().enumerate() {
                uv_rows[index * 2 + row] = values.extend(0.0).to_array();
            }
        }
        Self {
            base_color: material.base_color.to_array(),
            emissive: material.emissive.to_array(),
            metallic: material.metallic,
            roughness: material.roughness,
            normal_scale: material.normal_texture.map_or(1.0, |(_, scale)| scale),
            occlusion_strength: material.occlusion_texture.map_or(1.0, |(_, strength)| strength),
            alpha_cutoff: material.cutoff().unwrap_or(-1.0),
            mask_reading: material.base_color_texture.map_or(0, |texture| texture.reading_bits()),
            uv_sets: second_uvs(material),
            transmission: material.transmission,
            blends: u32::from(material.alpha_mode == AlphaMode::Blend),
            uv_rows,
        }
    }
}

/// A material ready to be bound; holds the material so that its address stays its own.
#[derive(Debug)]
struct Bound {
    material: Arc<Material>,
    group: wgpu::BindGroup,
    last_used_frame: u64,
}

/// Materials and textures of recent frames.
#[derive(Debug)]
pub(crate) struct Materials {
    pub(crate) layout: wgpu::BindGroupLayout,
    bound: HashMap<usize, Bound>,
    textures: HashMap<(usize, bool), (Arc<Image>, wgpu::Texture)>,
    samplers: HashMap<([Wrap; 2], bool), wgpu::Sampler>,
    white: wgpu::Texture,
    frame: u64,
}

/// Frames after which a material nobody drew is dropped.
const KEPT_FRAMES: u64 = 8;

impl Materials {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::FRAGMENT,
            ty,
            count: None,
        };
        let uniform = wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texture = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: true },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
        let mut entries = vec![entry(0, uniform)];
        entries.extend((1..=5).map(|binding| entry(binding, texture)));
        entries.extend((6..=10).map(|binding| entry(binding, sampler)));
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("material"),
            entries: &entries,
        });
        let white = Image { name: "white".into(), width: 1, height: 1, rgba8: vec![255; 4] };
        let white = upload(gpu, &white, false);
        Self {
            layout,
            bound: HashMap::new(),
            textures: HashMap::new(),
            samplers: HashMap::new(),
            white,
            frame: 0,
        }
    }

    pub(crate) fn begin_frame(&mut self) {
        self.frame += 1;
        let oldest = self.frame.saturating_sub(KEPT_FRAMES);
        self.bound.retain(|_, bound| bound.last_used_frame >= oldest);
        self.textures.retain(|_, (image, _)| Arc::strong_count(image) > 1);
    }

    /// Makes sure `material` can be bound.
    pub(crate) fn upload(
        &mut self,
        gpu: &Gpu,
        material: &Arc<Material>,
        images: &HashMap<ImageKey, Arc<Image>>,
    ) {
        let address = Arc::as_ptr(material) as usize;
        if let Some(bound) = self.bound.get_mut(&address) {
            bound.last_used_frame = self.frame;
            return;
        }
        let textures = textures(material);
        let mut views = Vec::new();
        for (texture, srgb) in textures {
            let texture = match texture.and_then(|texture| images.get(&texture.image)) {
                None => self.white.clone(),
                Some(image) => self.texture(gpu, image, srgb),
            };
            views.push(texture.create_view(&wgpu::TextureViewDescriptor::default()));
        }
        let samplers = textures.map(|(texture, _)| self.sampler(gpu, texture));
        let uniform = gpu.buffer(
            &material.name,
            wgpu::BufferUsages::UNIFORM,
            bytemuck::bytes_of(&MaterialUniform::new(material)),
        );
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let mut entries = vec![entry(0, uniform.as_entire_binding())];
        entries.extend(
            views.iter().zip(1..).map(|(view, i)| entry(i, wgpu::BindingResource::TextureView(view))),
        );
        entries.extend(samplers.iter().zip(6..).map(|(s, i)| entry(i, wgpu::BindingResource::Sampler(s))));
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&material.name),
            layout: &self.layout,
            entries: &entries,
        });
        let bound = Bound { material: Arc::clone(material), group, last_used_frame: self.frame };
        self.bound.insert(address, bound);
    }

    /// The bind group of a material that [`Materials::upload`] was called for in this frame.
    pub(crate) fn get(&self, material: &Arc<Material>) -> Option<&wgpu::BindGroup> {
        let bound = self.bound.get(&(Arc::as_ptr(material) as usize))?;
        debug_assert!(Arc::ptr_eq(&bound.material, material));
        Some(&bound.group)
    }

    /// Bytes of all textures.
    pub(crate) fn bytes(&self) -> u64 {
        self.textures.values().map(|(image, _)| image_bytes(image)).sum()
    }

    /// The images of a material, and whether their colours are sRGB.
    pub(crate) fn images(
        material: &Material,
        images: &HashMap<ImageKey, Arc<Image>>,
    ) -> Vec<(Arc<Image>, bool)> {
        let used = textures(material).into_iter();
        used.filter_map(|(texture, srgb)| Some((Arc::clone(images.get(&texture?.image)?), srgb))).collect()
    }

    /// The bytes `image` takes, if it is within the adapter's limits.
    pub(crate) fn check(gpu: &Gpu, image: &Image) -> Result<u64, GpuError> {
        let limit = gpu.limits.max_texture_dimension_2d;
        if image.width > limit || image.height > limit {
            return Err(GpuError::ImageTooLarge {
                image: image.name.clone(),
                width: image.width,
                height: image.height,
                adapter: gpu.name(),
                limit,
            });
        }
        Ok(image_bytes(image))
    }

    /// Drops all materials and images; those of the frame are uploaded again.
    pub(crate) fn clear(&mut self) {
        self.bound.clear();
        self.textures.clear();
    }

    fn texture(&mut self, gpu: &Gpu, image: &Arc<Image>, srgb: bool) -> wgpu::Texture {
        let key = (Arc::as_ptr(image) as usize, srgb);
        let (_, texture) =
            self.textures.entry(key).or_insert_with(|| (Arc::clone(image), upload(gpu, image, srgb)));
        texture.clone()
    }

    /// An image as base colours are bound; white where the scene has lost it, as surfaces show it then.
    pub(crate) fn base_color_image(&mut self, gpu: &Gpu, image: Option<&Arc<Image>>) -> wgpu::Texture {
        match image {
            Some(image) => self.texture(gpu, image, true),
            None => self.white.clone(),
        }
    }

    fn sampler(&mut self, gpu: &Gpu, texture: Option<TextureRef>) -> wgpu::Sampler {
        let (wrap, smooth) = texture.map_or(([Wrap::Repeat; 2], true), |t| (t.wrap, t.smooth));
        let mode = |wrap| match wrap {
            Wrap::Repeat => wgpu::AddressMode::Repeat,
            Wrap::Mirror => wgpu::AddressMode::MirrorRepeat,
            Wrap::Clamp => wgpu::AddressMode::ClampToEdge,
        };
        let filter = if smooth { wgpu::FilterMode::Linear } else { wgpu::FilterMode::Nearest };
        let sampler = self.samplers.entry((wrap, smooth)).or_insert_with(|| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                address_mode_u: mode(wrap[0]),
                address_mode_v: mode(wrap[1]),
                mag_filter: filter,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            })
        });
        sampler.clone()
    }
}

/// The bytes of an image with its mip levels.
fn image_bytes(image: &Image) -> u64 {
    u64::from(image.width) * u64::from(image.height) * 16 / 3
}

/// Uploads `image` with a full mip chain, each level a box filter of the one above in linear light.
fn upload(gpu: &Gpu, image: &Image, srgb: bool) -> wgpu::Texture {
    let levels = 32 - image.width.max(image.height).max(1).leading_zeros();
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&image.name),
        size: wgpu::Extent3d { width: image.width, height: image.height, depth_or_array_layers: 1 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: if srgb { wgpu::TextureFormat::Rgba8UnormSrgb } else { wgpu::TextureFormat::Rgba8Unorm },
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let (mut width, mut height, mut texels) = (image.width, image.height, image.rgba8.clone());
    for level in 0..levels {
        gpu.queue.write_texture(
            wgpu::TexelCopyTextureInfo { mip_level: level, ..texture.as_image_copy() },
            &texels,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 4), rows_per_image: None },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        (width, height, texels) = halved(width, height, &texels, srgb);
    }
    texture
}

/// The next smaller mip level. Odd sizes drop their last row or column, as the specification's sizes do.
fn halved(width: u32, height: u32, texels: &[u8], srgb: bool) -> (u32, u32, Vec<u8>) {
    let (half_width, half_height) = ((width / 2).max(1), (height / 2).max(1));
    let linear = |value: u8| {
        let v = f32::from(value) / 255.0;
        if !srgb {
            v
        } else if v <= 0.04045 {
            v / 12.92
        } else {
            ((v + 0.055) / 1.055).powf(2.4)
        }
    };
    let linear: [f32; 256] = std::array::from_fn(|value| linear(value as u8));
    let encoded = |v: f32| {
        let v = if !srgb {
            v
        } else if v <= 0.003_130_8 {
            v * 12.92
        } else {
            1.055 * v.powf(1.0 / 2.4) - 0.055
        };
        (v * 255.0 + 0.5) as u8
    };
    let mut result = Vec::with_capacity((half_width * half_height * 4) as usize);
    for y in 0..half_height {
        for x in 0..half_width {
            for channel in 0..4 {
                let texel = |dx: u32, dy: u32| {
                    let (x, y) = ((x * 2 + dx).min(width - 1), (y * 2 + dy).min(height - 1));
                    texels[((y * width + x) * 4 + channel) as usize]
                };
                let four = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
                result.push(if channel == 3 {
                    (four.iter().map(|t| u32::from(*t)).sum::<u32>() / 4) as u8
                } else {
                    encoded(four.iter().map(|t| linear[*t as usize]).sum::<f32>() * 0.25)
                });
            }
        }
    }
    (half_width, half_height, result)
}

/// Identity when nothing is set; keeps `Vec2` in the signature of what a test may call.
#[cfg(test)]
fn transformed(uniform: &MaterialUniform, texture: usize, uv: Vec2) -> Vec2 {
    let row = |r: [f32; 4]| r[0] * uv.x + r[1] * uv.y + r[2];
    Vec2::new(row(uniform.uv_rows[texture * 2]), row(uniform.uv_rows[texture * 2 + 1]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::UvTransform;
    use slotmap::Key;

    #[test]
    fn uv_transform_is_the_extensions() {
        let mut texture = TextureRef::new(ImageKey::null());
        let rotation_rad = std::f32::consts::FRAC_PI_2;
        texture.transform =
            UvTransform { offset: Vec2::new(0.0, 1.0), rotation_rad, scale: Vec2::splat(0.5) };
        let material = Material { base_color_texture: Some(texture), ..Material::default() };
        // The extension's own example: (u, v) → (0.5 v, 1 − 0.5 u).
        let uv = transformed(&MaterialUniform::new(&material), 0, Vec2::new(0.2, 0.6));
        assert!((uv - Vec2::new(0.3, 0.9)).length() < 1e-6, "{uv}");
    }

    #[test]
    fn mips_average_in_linear_light() {
        let (_, _, texels) = halved(2, 1, &[0, 0, 0, 255, 255, 255, 255, 255], true);
        assert_eq!(texels, [188, 188, 188, 255]);
    }
}
