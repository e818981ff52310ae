//! Metallic-roughness materials with their extensions, and the textures they wear.

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Map, Value};

use super::GltfError;
use super::document::{Document, Section};
use super::images::Images;
use super::names::shown;
use crate::scene::{AlphaMode, Material, TexCoord, TextureRef, UvTransform, Wrap};

/// The material of a primitive that names none: the default one of the glTF specification.
pub(super) fn gltf_default() -> Material {
    Material {
        name: "glTF default".into(),
        base_color: Vec4::ONE,
        metallic: 1.0,
        roughness: 1.0,
        double_sided: false,
        ..Material::default()
    }
}

/// A checked object of the document; an absent one has no fields.
#[derive(Clone, Copy)]
struct Fields<'v>(Option<&'v Map<String, Value>>);

impl<'v> Fields<'v> {
    fn get(self, field: &str) -> Option<&'v Value> {
        self.0?.get(field).filter(|value| !value.is_null())
    }

    fn object(self, field: &str) -> Self {
        Self(self.get(field).and_then(Value::as_object))
    }

    fn number(self, field: &str, otherwise: f32) -> f32 {
        self.get(field).and_then(Value::as_f64).map_or(otherwise, |number| number as f32)
    }

    fn numbers<const N: usize>(self, field: &str, otherwise: [f32; N]) -> [f32; N] {
        let Some(values) = self.get(field).and_then(Value::as_array) else { return otherwise };
        std::array::from_fn(|i| {
            values.get(i).and_then(Value::as_f64).map_or(otherwise[i], |number| number as f32)
        })
    }

    fn word(self, field: &str) -> Option<&'v str> {
        self.get(field).and_then(Value::as_str)
    }

    fn whole(self, field: &str) -> Option<u64> {
        self.get(field).and_then(Value::as_u64)
    }
}

/// Reads material `index` of the document, loading the images it wears.
pub(super) fn read(
    document: &Document,
    index: usize,
    images: &mut Images<'_, '_>,
) -> Result<Material, GltfError> {
    let material = Fields(Some(document.used(Section::Materials, index)?));
    let pbr = material.object("pbrMetallicRoughness");
    let name = material.word("name").map_or_else(|| format!("material{index}"), str::to_owned);
    let label = format!("material {index} '{}'", shown(&name));
    let extensions = material.object("extensions");
    let strength = extensions.object("KHR_materials_emissive_strength").number("emissiveStrength", 1.0);
    let transmission = extensions.object("KHR_materials_transmission");
    if transmission.get("transmissionTexture").is_some() {
        images.warnings.add(format!("{label}: its transmission texture is ignored"));
    }
    let (normal, occlusion) = (material.object("normalTexture"), material.object("occlusionTexture"));
    let mut worn = |slot: Fields<'_>| match slot.0 {
        Some(_) => texture(document, &label, slot, images),
        None => Ok(None),
    };
    let read = Material {
        base_color: Vec4::from(pbr.numbers("baseColorFactor", [1.0; 4])),
        base_color_texture: worn(pbr.object("baseColorTexture"))?,
        metallic: pbr.number("metallicFactor", 1.0),
        roughness: pbr.number("roughnessFactor", 1.0),
        metallic_roughness_texture: worn(pbr.object("metallicRoughnessTexture"))?,
        emissive: Vec3::from(material.numbers("emissiveFactor", [0.0; 3])) * strength,
        emissive_texture: worn(material.object("emissiveTexture"))?,
        normal_texture: worn(normal)?.map(|texture| (texture, normal.number("scale", 1.0))),
        occlusion_texture: worn(occlusion)?.map(|texture| (texture, occlusion.number("strength", 1.0))),
        alpha_mode: match material.word("alphaMode") {
            Some("MASK") => AlphaMode::Mask { cutoff: material.number("alphaCutoff", 0.5) },
            Some("BLEND") => AlphaMode::Blend,
            _ => AlphaMode::Opaque,
        },
        double_sided: material.get("doubleSided") == Some(&Value::Bool(true)),
        unlit: extensions.get("KHR_materials_unlit").is_some(),
        transmission: transmission.number("transmissionFactor", 0.0),
        surface: None,
        name,
    };
    check_finite(&label, &read)?;
    Ok(read)
}

/// JSON numbers beyond f32 become infinite; shading would spread them over the picture.
fn check_finite(label: &str, material: &Material) -> Result<(), GltfError> {
    if material.is_finite() {
        return Ok(());
    }
    Err(GltfError::Content { item: label.into(), problem: "its factors must be finite 32-bit floats".into() })
}

/// The texture in a slot; none, with a warning, where it wants other texture coordinates than the first two, or where
/// no image that can be read is behind it.
fn texture(
    document: &Document,
    material: &str,
    slot: Fields<'_>,
    images: &mut Images<'_, '_>,
) -> Result<Option<TextureRef>, GltfError> {
    let moved = slot.object("extensions").object("KHR_texture_transform");
    let tex_coord = match moved.whole("texCoord").or(slot.whole("texCoord")).unwrap_or(0) {
        0 => TexCoord::First,
        1 => TexCoord::Second,
        more => {
            images.warnings.add(format!(
                "{material}: a texture on TEXCOORD_{more} is ignored (TEXCOORD_0 and 1 are supported)"
            ));
            return Ok(None);
        }
    };
    let index = slot.whole("index").unwrap_or(0) as usize;
    let texture = Fields(Some(document.used(Section::Textures, index)?));
    // The WebP image first, as its extension says: the other is there for those who cannot read it.
    let webp = texture.object("extensions").object("EXT_texture_webp").whole("source");
    let Some(source) = webp.or(texture.whole("source")) else {
        let other = texture.object("extensions").0.and_then(|extensions| extensions.keys().next());
        let only =
            other.map_or(String::new(), |name| format!(" but by {}, which is not supported", shown(name)));
        images.warnings.add(format!("{material}: texture {index} has no image{only}, and is ignored"));
        return Ok(None);
    };
    let image = images.key(source as usize)?;
    let sampler = match texture.whole("sampler") {
        Some(sampler) => Fields(Some(document.used(Section::Samplers, sampler as usize)?)),
        None => Fields(None),
    };
    let transform = UvTransform {
        offset: Vec2::from(moved.numbers("offset", [0.0; 2])),
        rotation_rad: moved.number("rotation", 0.0),
        scale: Vec2::from(moved.numbers("scale", [1.0; 2])),
    };
    if !(transform.offset.is_finite() && transform.rotation_rad.is_finite() && transform.scale.is_finite()) {
        let problem = "its texture transforms must be finite".into();
        return Err(GltfError::Content { item: material.into(), problem });
    }
    let wrap = [wrap(sampler.whole("wrapS")), wrap(sampler.whole("wrapT"))];
    let smooth = sampler.whole("magFilter") != Some(NEAREST);
    Ok(Some(TextureRef { image, wrap, smooth, tex_coord, transform }))
}

const NEAREST: u64 = 9728;

fn wrap(mode: Option<u64>) -> Wrap {
    match mode {
        Some(33071) => Wrap::Clamp,
        Some(33648) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
