//! The JSON of a glTF file, read section by section and validated.
//!
//! The sections that describe binary data (accessors, buffers, meshes, textures, …) become the gltf crate's types
//! and pass its validation; nodes, scenes, cameras and lights stay JSON values (see [`super::fields`]).

use std::collections::BTreeMap;

use gltf::json;
use gltf::json::extras::RawValue;
use gltf::json::validation::{Checked, Validate};
use serde_json::Value;

use super::GltfError;
use super::limits::{MAX_JSON_OBJECTS, Warnings};

/// The extensions the loader understands; any other that a file requires is an error.
const SUPPORTED_EXTENSIONS: [&str; 11] = [
    super::instancing::GPU_INSTANCING,
    "KHR_lights_punctual",
    "KHR_lights_shadows",
    "KHR_materials_emissive_strength",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_transform",
    "KHR_xmp_json_ld",
    super::extension::SHADOW_NODE,
];

/// The top-level sections, still as text.
type Sections<'a> = BTreeMap<String, &'a RawValue>;

/// Parses a top-level section; an absent one has its type's default value. A macro, since the trait bound it
/// would need as a function belongs to a crate this one does not depend on.
macro_rules! section {
    ($sections:expr, $name:literal) => {
        match $sections.get($name) {
            Some(section) => serde_json::from_str(section.get())
                .map_err(|error| unreadable(concat!("'", $name, "'"), &error))?,
            None => Default::default(),
        }
    };
}

/// The parsed document.
#[derive(Debug, Default)]
pub(super) struct Document {
    /// Accessors, buffers, views, images, materials, meshes, samplers and textures; nothing else.
    pub(super) root: json::Root,
    pub(super) nodes: Vec<Value>,
    pub(super) skins: Vec<Value>,
    pub(super) animations: Vec<Value>,
    pub(super) scenes: Vec<Value>,
    pub(super) default_scene: Option<u64>,
    pub(super) cameras: Vec<Value>,
    pub(super) lights: Vec<Value>,
}

impl Document {
    /// The names of all scenes; empty ones for those without.
    pub(super) fn scene_names(&self) -> Vec<String> {
        let name = |scene: &Value| scene.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
        self.scenes.iter().map(name).collect()
    }

    pub(super) fn parse(bytes: &[u8], warnings: &mut Warnings) -> Result<Self, GltfError> {
        let objects = bytes.iter().filter(|byte| **byte == b'{').count() as u64;
        if objects > MAX_JSON_OBJECTS {
            let what = "objects of the JSON".into();
            return Err(GltfError::TooLarge { what, count: objects, limit: MAX_JSON_OBJECTS });
        }
        let sections: Sections<'_> =
            serde_json::from_slice(bytes).map_err(|error| unreadable("the document", &error))?;

        let asset: Value = section!(sections, "asset");
        let version = asset.get("version").and_then(Value::as_str).unwrap_or("(none)");
        let minimum = asset.get("minVersion").and_then(Value::as_str).unwrap_or("2.0");
        if !version.starts_with("2.") || minimum != "2.0" {
            let found = if version.starts_with("2.") { minimum } else { version };
            return Err(GltfError::Version { found: found.chars().take(20).collect() });
        }
        let required: Vec<String> = section!(sections, "extensionsRequired");
        if let Some(name) = required.iter().find(|name| !SUPPORTED_EXTENSIONS.contains(&name.as_str())) {
            return Err(GltfError::UnsupportedExtension { name: name.clone(), fix: remedy(name) });
        }

        let extensions: Value = section!(sections, "extensions");
        let lights = match extensions.pointer("/KHR_lights_punctual/lights") {
            Some(Value::Array(lights)) => lights.clone(),
            Some(_) => {
                let path = "extensions.KHR_lights_punctual.lights".into();
                return Err(GltfError::Invalid { path, problem: "an array of lights is needed".into() });
            }
            None => Vec::new(),
        };
        let mut root = json::Root {
            accessors: section!(sections, "accessors"),
            buffers: section!(sections, "buffers"),
            buffer_views: section!(sections, "bufferViews"),
            images: section!(sections, "images"),
            materials: materials(&sections)?,
            meshes: section!(sections, "meshes"),
            samplers: section!(sections, "samplers"),
            textures: section!(sections, "textures"),
            ..json::Root::default()
        };
        relax(&mut root, warnings);
        validate(&root, &sections)?;
        Ok(Self {
            root,
            nodes: section!(sections, "nodes"),
            skins: section!(sections, "skins"),
            animations: section!(sections, "animations"),
            scenes: section!(sections, "scenes"),
            default_scene: section!(sections, "scene"),
            cameras: section!(sections, "cameras"),
            lights,
        })
    }
}

/// The materials, by way of plain values.
fn materials(sections: &Sections<'_>) -> Result<Vec<json::Material>, GltfError> {
    let mut materials: Vec<Value> = section!(sections, "materials");
    materials.iter_mut().for_each(strip_extras);
    serde_json::from_value(materials.into()).map_err(|error| unreadable("'materials'", &error))
}

fn unreadable(section: &str, error: &serde_json::Error) -> GltfError {
    GltfError::Json { section: section.into(), problem: error.to_string() }
}

/// Removes every `extras`, which the gltf crate cannot read within extensions of materials.
fn strip_extras(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.remove("extras");
            object.values_mut().for_each(strip_extras);
        }
        Value::Array(values) => values.iter_mut().for_each(strip_extras),
        _ => {}
    }
}

/// Takes out of the document what the gltf crate's validation is stricter or slower about than need be.
fn relax(root: &mut json::Root, warnings: &mut Warnings) {
    // Bounds are not used, only checked for presence, by copying them for each primitive.
    for accessor in &mut root.accessors {
        let bounds = Value::from(vec![0.0; 3]);
        (accessor.min, accessor.max) = (Some(bounds.clone()), Some(bounds));
    }
    for (mesh, declaration) in root.meshes.iter_mut().enumerate() {
        for primitive in &mut declaration.primitives {
            if primitive.attributes.remove(&Checked::Invalid).is_some() {
                warnings.add(format!("mesh {mesh}: an attribute of unknown name is ignored"));
            }
        }
    }
}

/// The gltf crate's validation: every index in range, every enumeration known, what is required there.
fn validate(root: &json::Root, sections: &Sections<'_>) -> Result<(), GltfError> {
    // Its check of primitives takes the position accessor for granted, so that index is checked first.
    for (mesh, declaration) in root.meshes.iter().enumerate() {
        for primitive in &declaration.primitives {
            let position = primitive.attributes.get(&Checked::Valid(json::mesh::Semantic::Positions));
            if let Some(index) = position.map(json::Index::value)
                && index >= root.accessors.len()
            {
                return Err(GltfError::IndexOutOfRange {
                    item: format!("mesh {mesh}"),
                    field: "POSITION".into(),
                    kind: "accessor",
                    index: index as u64,
                    count: root.accessors.len(),
                });
            }
        }
    }
    let mut first = None;
    root.validate(root, json::Path::new, &mut |path, error| {
        if first.is_none() {
            let path = path().0;
            let out_of_range = matches!(error, json::validation::Error::IndexOutOfBounds);
            let said = out_of_range.then(|| out_of_range_at(&path, root, sections)).flatten();
            let problem = said.unwrap_or_else(|| error.to_string().to_lowercase());
            first = Some(GltfError::Invalid { path, problem });
        }
    });
    first.map_or(Ok(()), Err)
}

/// What is wrong with the index at `path` (as in `meshes[0].primitives[2].indices`): which it is, and how many things
/// of its kind there are.
fn out_of_range_at(path: &str, root: &json::Root, sections: &Sections<'_>) -> Option<String> {
    let steps: Vec<&str> = path.split(['.', '[', ']', '"']).filter(|step| !step.is_empty()).collect();
    let (section, rest) = steps.split_first()?;
    let value: Value = serde_json::from_str(sections.get(*section)?.get()).ok()?;
    let index = value.pointer(&format!("/{}", rest.join("/")))?.as_u64()?;
    let inside_primitive = steps.contains(&"primitives");
    let (kind, count) = match *rest.last()? {
        "bufferView" => ("buffer views", root.buffer_views.len()),
        "buffer" => ("buffers", root.buffers.len()),
        "material" => ("materials", root.materials.len()),
        "sampler" => ("samplers", root.samplers.len()),
        "source" => ("images", root.images.len()),
        "index" => ("textures", root.textures.len()),
        _ if inside_primitive => ("accessors", root.accessors.len()),
        _ => return None,
    };
    Some(format!("index {index} is out of bounds: the file has {count} {kind} (counted from 0)"))
}

/// What to do about a required extension that is not supported.
fn remedy(extension: &str) -> String {
    match extension {
        "KHR_draco_mesh_compression" => "re-export without Draco compression".into(),
        "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "re-export without meshopt compression".into()
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "re-export with PNG or JPEG textures".into()
        }
        "KHR_materials_pbrSpecularGlossiness" => "convert its materials to metallic-roughness".into(),
        _ => format!("re-export without it (supported are {})", SUPPORTED_EXTENSIONS.join(", ")),
    }
}
