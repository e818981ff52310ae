//! Metallic-roughness materials with their extensions, and the textures they wear.

use glam::{Vec2, Vec3, Vec4};
use gltf::json;
use json::extensions::texture::TextureTransform;
use json::texture::{MagFilter, WrappingMode};
use json::validation::Checked;
use serde_json::{Map, Value};

use super::GltfError;
use super::images::Images;
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

/// A texture's index and how its coordinates are transformed, whichever kind of slot it is in.
struct Slot<'a> {
    texture: usize,
    tex_coord: u32,
    transform: Option<&'a TextureTransform>,
}

/// Reads material `index` of the document, loading the images it wears.
pub(super) fn read(root: &json::Root, index: usize, images: &mut Images<'_>) -> Result<Material, GltfError> {
    let Some(material) = root.materials.get(index) else { return Ok(gltf_default()) };
    let pbr = &material.pbr_metallic_roughness;
    let name = material.name.clone().unwrap_or_else(|| format!("material{index}"));
    let extensions = material.extensions.as_ref();
    let strength =
        extensions.and_then(|e| e.emissive_strength.as_ref()).map_or(1.0, |e| e.emissive_strength.0);
    let transmission = extensions.and_then(|e| e.transmission.as_ref());
    if transmission.is_some_and(|transmission| transmission.transmission_texture.is_some()) {
        images.warnings.add(format!("material '{name}': its transmission texture is ignored"));
    }
    let Checked::Valid(alpha_mode) = material.alpha_mode else {
        let path = format!("materials[{index}].alphaMode");
        return Err(GltfError::Invalid { path, problem: "OPAQUE, MASK and BLEND are accepted".into() });
    };

    let mut worn = |slot: Option<Slot<'_>>| match slot {
        Some(slot) => texture(root, &name, &slot, images),
        None => Ok(None),
    };
    let base_color_texture = worn(pbr.base_color_texture.as_ref().map(slot_of))?;
    let metallic_roughness_texture = worn(pbr.metallic_roughness_texture.as_ref().map(slot_of))?;
    let emissive_texture = worn(material.emissive_texture.as_ref().map(slot_of))?;
    // The gltf crate knows texture transforms of the three slots above only.
    let normal = material.normal_texture.as_ref();
    let normal_transform = transform_in(normal.and_then(|n| Some(&n.extensions.as_ref()?.others)))?;
    let normal_texture = worn(normal.map(|normal| Slot {
        texture: normal.index.value(),
        tex_coord: normal.tex_coord,
        transform: normal_transform.as_ref(),
    }))?;
    let occlusion = material.occlusion_texture.as_ref();
    let occlusion_transform = transform_in(occlusion.and_then(|o| Some(&o.extensions.as_ref()?.others)))?;
    let occlusion_texture = worn(occlusion.map(|occlusion| Slot {
        texture: occlusion.index.value(),
        tex_coord: occlusion.tex_coord,
        transform: occlusion_transform.as_ref(),
    }))?;

    let read = Material {
        base_color: Vec4::from(pbr.base_color_factor.0),
        base_color_texture,
        metallic: pbr.metallic_factor.0,
        roughness: pbr.roughness_factor.0,
        metallic_roughness_texture,
        emissive: Vec3::from(material.emissive_factor.0) * strength,
        emissive_texture,
        normal_texture: normal_texture.zip(normal.map(|normal| normal.scale)),
        occlusion_texture: occlusion_texture.zip(occlusion.map(|occlusion| occlusion.strength.0)),
        alpha_mode: match alpha_mode {
            json::material::AlphaMode::Opaque => AlphaMode::Opaque,
            json::material::AlphaMode::Mask => {
                AlphaMode::Mask { cutoff: material.alpha_cutoff.unwrap_or_default().0 }
            }
            json::material::AlphaMode::Blend => AlphaMode::Blend,
        },
        double_sided: material.double_sided,
        unlit: extensions.is_some_and(|extensions| extensions.unlit.is_some()),
        transmission: transmission.map_or(0.0, |transmission| transmission.transmission_factor.0),
        surface: None,
        name,
    };
    check_finite(index, &read)?;
    Ok(read)
}

/// JSON numbers beyond f32 become infinite; shading would spread them over the picture.
fn check_finite(index: usize, material: &Material) -> Result<(), GltfError> {
    let cutoff = match material.alpha_mode {
        AlphaMode::Mask { cutoff } => cutoff,
        _ => 0.0,
    };
    let scale = |texture: &Option<(TextureRef, f32)>| texture.map_or(0.0, |(_, scale)| scale);
    let scalars = [
        material.metallic,
        material.roughness,
        material.transmission,
        cutoff,
        scale(&material.normal_texture),
        scale(&material.occlusion_texture),
    ];
    let finite = scalars.iter().all(|x| x.is_finite());
    if finite && material.base_color.is_finite() && material.emissive.is_finite() {
        return Ok(());
    }
    let item = format!("material {index} '{}'", material.name);
    Err(GltfError::Content { item, problem: "its factors must be finite 32-bit floats".into() })
}

fn slot_of(info: &json::texture::Info) -> Slot<'_> {
    let transform = info.extensions.as_ref().and_then(|extensions| extensions.texture_transform.as_ref());
    Slot { texture: info.index.value(), tex_coord: info.tex_coord, transform }
}

/// The texture transform among the extensions of a normal or occlusion texture.
fn transform_in(others: Option<&Map<String, Value>>) -> Result<Option<TextureTransform>, GltfError> {
    let Some(value) = others.and_then(|others| others.get("KHR_texture_transform")) else { return Ok(None) };
    serde_json::from_value(value.clone()).map(Some).map_err(|error| {
        let section = "'KHR_texture_transform' of a material".into();
        GltfError::Json { section, problem: error.to_string() }
    })
}

/// The texture in a slot; none, with a warning, where it wants other texture coordinates than the first two.
fn texture(
    root: &json::Root,
    material: &str,
    slot: &Slot<'_>,
    images: &mut Images<'_>,
) -> Result<Option<TextureRef>, GltfError> {
    let tex_coord = slot.transform.and_then(|transform| transform.tex_coord).unwrap_or(slot.tex_coord);
    let tex_coord = match tex_coord {
        0 => TexCoord::First,
        1 => TexCoord::Second,
        more => {
            images.warnings.add(format!(
                "material '{material}': a texture on TEXCOORD_{more} is ignored (TEXCOORD_0 and 1 are supported)"
            ));
            return Ok(None);
        }
    };
    let Some(texture) = root.textures.get(slot.texture) else { return Ok(None) };
    let image = images.key(texture.source.value())?;
    let sampler = texture.sampler.and_then(|sampler| root.get(sampler));
    let wrap = sampler.map_or([Wrap::Repeat; 2], |sampler| [wrap(&sampler.wrap_s), wrap(&sampler.wrap_t)]);
    let blocky =
        sampler.is_some_and(|sampler| sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)));
    let transform = slot.transform.map_or(UvTransform::default(), |transform| UvTransform {
        offset: Vec2::from(transform.offset.0),
        rotation_rad: transform.rotation.0,
        scale: Vec2::from(transform.scale.0),
    });
    if !(transform.offset.is_finite() && transform.rotation_rad.is_finite() && transform.scale.is_finite()) {
        let item = format!("material '{material}'");
        return Err(GltfError::Content { item, problem: "its texture transforms must be finite".into() });
    }
    Ok(Some(TextureRef { image, wrap, smooth: !blocky, tex_coord, transform }))
}

fn wrap(mode: &Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
