//! Writing materials, textures, samplers and images.

use std::collections::HashMap;
use std::io::Cursor;

use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::{Map, Value, json};

use super::GltfError;
use super::limits::Warnings;
use super::save_meshes::Binary;
use crate::scene::{
    AlphaMode, ImageKey, Material, MaterialKey, Scene, TexCoord, TextureRef, UvTransform, Wrap,
};

/// The materials written so far, and what they wear.
#[derive(Debug, Default)]
pub(super) struct Materials {
    pub(super) materials: Vec<Value>,
    pub(super) textures: Vec<Value>,
    pub(super) samplers: Vec<Value>,
    pub(super) images: Vec<Value>,
    pub(super) extensions: Vec<&'static str>,
    pub(super) warnings: Warnings,
    /// `None` is the engine's default material, which slots without a material wear.
    written: HashMap<Option<MaterialKey>, usize>,
    written_images: HashMap<ImageKey, usize>,
    written_textures: HashMap<(usize, usize), usize>,
    written_samplers: HashMap<([Wrap; 2], bool), usize>,
}

impl Materials {
    /// The index of a material, written on first use.
    pub(super) fn index(
        &mut self,
        scene: &Scene,
        key: Option<MaterialKey>,
        binary: &mut Binary,
    ) -> Result<usize, GltfError> {
        if let Some(index) = self.written.get(&key) {
            return Ok(*index);
        }
        let default = Material::default();
        let material = match key {
            Some(key) => scene.material(key).ok_or_else(|| gone("a material"))?,
            None => &default,
        };
        let value = self.write(scene, material, binary)?;
        self.materials.push(value);
        self.written.insert(key, self.materials.len() - 1);
        Ok(self.materials.len() - 1)
    }

    fn write(&mut self, scene: &Scene, material: &Material, binary: &mut Binary) -> Result<Value, GltfError> {
        check_factors(material)?;
        if let Some(function) = &material.surface {
            self.warnings.add(format!(
                "material '{}': its surface function '{}' is left out; glTF has no place for it",
                material.name,
                function.name()
            ));
        }
        let mut pbr = json!({
            "baseColorFactor": material.base_color.to_array(),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        });
        let mut worn = |texture: &TextureRef| self.texture(scene, texture, binary);
        if let Some(texture) = &material.base_color_texture {
            pbr["baseColorTexture"] = worn(texture)?;
        }
        if let Some(texture) = &material.metallic_roughness_texture {
            pbr["metallicRoughnessTexture"] = worn(texture)?;
        }
        let mut value = json!({
            "name": material.name, "pbrMetallicRoughness": pbr, "doubleSided": material.double_sided,
        });
        if let Some(texture) = &material.emissive_texture {
            value["emissiveTexture"] = worn(texture)?;
        }
        if let Some((texture, scale)) = &material.normal_texture {
            value["normalTexture"] = worn(texture)?;
            value["normalTexture"]["scale"] = (*scale).into();
        }
        if let Some((texture, strength)) = &material.occlusion_texture {
            value["occlusionTexture"] = worn(texture)?;
            value["occlusionTexture"]["strength"] = (*strength).into();
        }
        match material.alpha_mode {
            AlphaMode::Opaque => {}
            AlphaMode::Mask { cutoff } => {
                value["alphaMode"] = "MASK".into();
                value["alphaCutoff"] = cutoff.into();
            }
            AlphaMode::Blend => value["alphaMode"] = "BLEND".into(),
        }
        // A power of two as strength keeps the factors within 1 and their product exact.
        let strength = emissive_strength(material.emissive.max_element());
        value["emissiveFactor"] = json!((material.emissive / strength).to_array());
        let extensions = self.extensions(material, strength);
        if !extensions.is_empty() {
            value["extensions"] = extensions.into();
        }
        Ok(value)
    }

    /// What glTF says of a material in extensions.
    fn extensions(&mut self, material: &Material, emissive_strength: f32) -> Map<String, Value> {
        let mut extensions = Map::new();
        if emissive_strength != 1.0 {
            let object = json!({ "emissiveStrength": emissive_strength });
            extensions.insert(self.using("KHR_materials_emissive_strength"), object);
        }
        if material.unlit {
            extensions.insert(self.using("KHR_materials_unlit"), json!({}));
        }
        if material.transmission != 0.0 {
            let object = json!({ "transmissionFactor": material.transmission });
            extensions.insert(self.using("KHR_materials_transmission"), object);
        }
        extensions
    }

    /// Notes that an extension is used.
    fn using(&mut self, extension: &'static str) -> String {
        if !self.extensions.contains(&extension) {
            self.extensions.push(extension);
        }
        extension.into()
    }

    /// A texture reference; textures, samplers and images are shared between uses.
    fn texture(
        &mut self,
        scene: &Scene,
        texture: &TextureRef,
        binary: &mut Binary,
    ) -> Result<Value, GltfError> {
        let source = self.image(scene, texture.image, binary)?;
        let next = self.samplers.len();
        let sampler = *self.written_samplers.entry((texture.wrap, texture.smooth)).or_insert(next);
        if sampler == next {
            let [wrap_s, wrap_t] = texture.wrap.map(wrap_number);
            // 9729 and 9987 are linear without and with mip maps, 9728 and 9986 nearest.
            let (mag, min) = if texture.smooth { (9729, 9987) } else { (9728, 9986) };
            self.samplers
                .push(json!({ "wrapS": wrap_s, "wrapT": wrap_t, "magFilter": mag, "minFilter": min }));
        }
        let next = self.textures.len();
        let index = *self.written_textures.entry((source, sampler)).or_insert(next);
        if index == next {
            self.textures.push(json!({ "source": source, "sampler": sampler }));
        }
        let mut info = json!({ "index": index });
        if texture.tex_coord == TexCoord::Second {
            info["texCoord"] = 1.into();
        }
        let transform = texture.transform;
        if !(transform.offset.is_finite()
            && transform.rotation_rad.is_finite()
            && transform.scale.is_finite())
        {
            let what = "a texture transform".into();
            return Err(GltfError::Save { what, problem: "is not finite".into() });
        }
        if transform != UvTransform::default() {
            let extension = self.using("KHR_texture_transform");
            info["extensions"] = json!({ extension: {
                "offset": transform.offset.to_array(),
                "rotation": transform.rotation_rad,
                "scale": transform.scale.to_array(),
            } });
        }
        Ok(info)
    }

    /// An image, written as PNG on first use.
    fn image(&mut self, scene: &Scene, key: ImageKey, binary: &mut Binary) -> Result<usize, GltfError> {
        if let Some(index) = self.written_images.get(&key) {
            return Ok(*index);
        }
        let image = scene.image(key).ok_or_else(|| gone("an image"))?;
        let bad = |problem: String| GltfError::Save { what: format!("image '{}'", image.name), problem };
        let expected = 4 * u64::from(image.width) * u64::from(image.height);
        if expected == 0 || image.rgba8.len() as u64 != expected {
            return Err(bad(format!("has {} bytes, {expected} are needed", image.rgba8.len())));
        }
        let mut png = Vec::new();
        PngEncoder::new(Cursor::new(&mut png))
            .write_image(&image.rgba8, image.width, image.height, ExtendedColorType::Rgba8)
            .map_err(|error| bad(format!("cannot be encoded: {error}")))?;
        let view = binary.add_view(png, None);
        self.images.push(json!({ "name": image.name, "mimeType": "image/png", "bufferView": view }));
        self.written_images.insert(key, self.images.len() - 1);
        Ok(self.images.len() - 1)
    }
}

/// Refuses a material that has factors which are not finite.
fn check_factors(material: &Material) -> Result<(), GltfError> {
    if material.is_finite() {
        return Ok(());
    }
    let what = format!("material '{}'", material.name);
    Err(GltfError::Save { what, problem: "has factors that are not finite".into() })
}

/// The error of something that a node refers to and that the scene no longer has.
pub(super) fn gone(what: &str) -> GltfError {
    GltfError::Save { what: what.into(), problem: "is referred to but no longer in the scene".into() }
}

/// The smallest power of two, at least 1, that is not below `largest`.
fn emissive_strength(largest: f32) -> f32 {
    let mut strength = 1.0_f32;
    while strength < largest && strength < 2.0_f32.powi(127) {
        strength *= 2.0;
    }
    strength
}

fn wrap_number(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 10497,
        Wrap::Mirror => 33648,
        Wrap::Clamp => 33071,
    }
}
