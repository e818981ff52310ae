//! The fields of glTF 2.0's objects, as tables for `check`; what fields must fit together is in `together`.
//!
//! Only what this loader looks at refuses a file; the rest is here so that a note can say what is wrong with it.

use std::collections::BTreeSet;

use serde_json::Value;

use super::check::Kind::{
    Anything, Attributes, Bool, Code, Hint, Index, Indices, Number, Numbers, Object, Objects, SomeNumbers,
    Targets, Text, Whole, Word,
};
use super::check::{Field, Shape, may, must};
use super::document::{Document, SUPPORTED_EXTENSIONS, Section};
use super::limits::Warnings;
use super::names::shown;

const ANY: f64 = f64::MAX;
const MANY: u64 = u64::MAX;
/// Exporters write a right angle as an f32, which is a little more.
const ANGLE: super::check::Kind = Number(0.0, std::f64::consts::FRAC_PI_2 + 1e-6);

pub(super) const COMPONENT_TYPES: &[u64] = &[5120, 5121, 5122, 5123, 5125, 5126];
const INDEX_TYPES: &[u64] = &[5121, 5123, 5125];

const ACCESSOR: Shape = &[
    may("bufferView", Index(Section::BufferViews)),
    may("byteOffset", Whole(0, MANY)),
    must("componentType", Code(COMPONENT_TYPES)),
    may("normalized", Bool),
    must("count", Whole(1, MANY)),
    must("type", Word(&["SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"])),
    may("min", SomeNumbers),
    may("max", SomeNumbers),
    may("sparse", Object(SPARSE)),
    NAME,
];
const SPARSE: Shape = &[
    must("count", Whole(1, MANY)),
    must(
        "indices",
        Object(&[
            must("bufferView", Index(Section::BufferViews)),
            may("byteOffset", Whole(0, MANY)),
            must("componentType", Code(INDEX_TYPES)),
        ]),
    ),
    must(
        "values",
        Object(&[must("bufferView", Index(Section::BufferViews)), may("byteOffset", Whole(0, MANY))]),
    ),
];
const NAME: Field = may("name", Text);
const BUFFER: Shape = &[may("uri", Text), must("byteLength", Whole(1, MANY)), NAME];
const BUFFER_VIEW: Shape = &[
    must("buffer", Index(Section::Buffers)),
    may("byteOffset", Whole(0, MANY)),
    must("byteLength", Whole(1, MANY)),
    may("byteStride", Whole(4, 252)),
    may("target", Whole(34962, 34963)),
    NAME,
];
const IMAGE: Shape = &[
    may("uri", Text),
    may("mimeType", Hint(&["image/png", "image/jpeg", "image/webp"])),
    may("bufferView", Index(Section::BufferViews)),
    NAME,
];
const WRAPS: &[u64] = &[33071, 33648, 10497];
const SAMPLER: Shape = &[
    may("magFilter", Code(&[9728, 9729])),
    may("minFilter", Code(&[9728, 9729, 9984, 9985, 9986, 9987])),
    may("wrapS", Code(WRAPS)),
    may("wrapT", Code(WRAPS)),
    NAME,
];
const TEXTURE: Shape = &[
    may("source", Index(Section::Images)),
    may("sampler", Index(Section::Samplers)),
    may("extensions", Object(&[may("EXT_texture_webp", Object(&[may("source", Index(Section::Images))]))])),
    NAME,
];
const TEXTURE_TRANSFORM: Shape = &[
    may("offset", Numbers(2, -ANY, ANY)),
    may("rotation", Number(-ANY, ANY)),
    may("scale", Numbers(2, -ANY, ANY)),
    may("texCoord", Whole(0, MANY)),
];
const IN_SLOT: Field = may("extensions", Object(&[may("KHR_texture_transform", Object(TEXTURE_TRANSFORM))]));
const TEXTURE_INDEX: Field = must("index", Index(Section::Textures));
const TEX_COORD: Field = may("texCoord", Whole(0, MANY));
const SLOT: Shape = &[TEXTURE_INDEX, TEX_COORD, IN_SLOT];
const MATERIAL: Shape = &[
    NAME,
    may(
        "pbrMetallicRoughness",
        Object(&[
            may("baseColorFactor", Numbers(4, 0.0, 1.0)),
            may("baseColorTexture", Object(SLOT)),
            may("metallicFactor", Number(0.0, 1.0)),
            may("roughnessFactor", Number(0.0, 1.0)),
            may("metallicRoughnessTexture", Object(SLOT)),
        ]),
    ),
    may("normalTexture", Object(&[TEXTURE_INDEX, TEX_COORD, IN_SLOT, may("scale", Number(-ANY, ANY))])),
    may("occlusionTexture", Object(&[TEXTURE_INDEX, TEX_COORD, IN_SLOT, may("strength", Number(0.0, 1.0))])),
    may("emissiveTexture", Object(SLOT)),
    may("emissiveFactor", Numbers(3, 0.0, 1.0)),
    may("alphaMode", Word(&["OPAQUE", "MASK", "BLEND"])),
    may("alphaCutoff", Number(0.0, ANY)),
    may("doubleSided", Bool),
    may(
        "extensions",
        Object(&[
            may("KHR_materials_emissive_strength", Object(&[may("emissiveStrength", Number(0.0, ANY))])),
            may(
                "KHR_materials_transmission",
                Object(&[
                    may("transmissionFactor", Number(0.0, 1.0)),
                    may("transmissionTexture", Object(SLOT)),
                ]),
            ),
        ]),
    ),
];
const MESH: Shape = &[
    NAME,
    must(
        "primitives",
        Objects(&[
            must("attributes", Attributes),
            may("indices", Index(Section::Accessors)),
            may("material", Index(Section::Materials)),
            may("mode", Code(&[0, 1, 2, 3, 4, 5, 6])),
            may("targets", Targets),
        ]),
    ),
    may("weights", SomeNumbers),
];
const NODE: Shape = &[
    NAME,
    may("camera", Index(Section::Cameras)),
    may("children", Indices(Section::Nodes)),
    may("skin", Index(Section::Skins)),
    may("matrix", Numbers(16, -ANY, ANY)),
    may("mesh", Index(Section::Meshes)),
    may("rotation", Numbers(4, -1.0, 1.0)),
    may("scale", Numbers(3, -ANY, ANY)),
    may("translation", Numbers(3, -ANY, ANY)),
    may("weights", SomeNumbers),
    may(
        "extensions",
        Object(&[
            may("KHR_lights_punctual", Object(&[must("light", Index(Section::Lights))])),
            may("EXT_mesh_gpu_instancing", Object(&[must("attributes", Attributes)])),
            may("KHR_node_visibility", Object(&[may("visible", Bool)])),
        ]),
    ),
];
const CAMERA: Shape = &[
    NAME,
    must("type", Word(&["perspective", "orthographic"])),
    may(
        "perspective",
        Object(&[
            may("aspectRatio", Number(0.0, ANY)),
            must("yfov", Number(0.0, ANY)),
            must("znear", Number(0.0, ANY)),
            may("zfar", Number(0.0, ANY)),
        ]),
    ),
    may(
        "orthographic",
        Object(&[
            must("xmag", Number(-ANY, ANY)),
            must("ymag", Number(-ANY, ANY)),
            must("znear", Number(0.0, ANY)),
            must("zfar", Number(0.0, ANY)),
        ]),
    ),
];
const LIGHT: Shape = &[
    NAME,
    must("type", Hint(&["directional", "point", "spot"])),
    may("color", Numbers(3, 0.0, 1.0)),
    may("intensity", Number(0.0, ANY)),
    may("range", Number(f64::MIN_POSITIVE, ANY)),
    may("spot", Object(&[may("innerConeAngle", ANGLE), may("outerConeAngle", ANGLE)])),
];
const SKIN: Shape = &[
    NAME,
    may("inverseBindMatrices", Index(Section::Accessors)),
    may("skeleton", Index(Section::Nodes)),
    must("joints", Indices(Section::Nodes)),
];
const ANIMATION: Shape = &[
    NAME,
    must(
        "channels",
        Objects(&[
            must("sampler", Whole(0, MANY)),
            must("target", Object(&[may("node", Index(Section::Nodes)), must("path", Text)])),
        ]),
    ),
    must(
        "samplers",
        Objects(&[
            must("input", Index(Section::Accessors)),
            may("interpolation", Word(&["LINEAR", "STEP", "CUBICSPLINE"])),
            must("output", Index(Section::Accessors)),
        ]),
    ),
];
const SCENE: Shape = &[NAME, may("nodes", Indices(Section::Nodes)), may("extras", Anything)];

/// The fields of the things of a section.
pub(super) fn of(section: Section) -> Shape {
    match section {
        Section::Accessors => ACCESSOR,
        Section::Animations => ANIMATION,
        Section::Buffers => BUFFER,
        Section::BufferViews => BUFFER_VIEW,
        Section::Cameras => CAMERA,
        Section::Images => IMAGE,
        Section::Lights => LIGHT,
        Section::Materials => MATERIAL,
        Section::Meshes => MESH,
        Section::Nodes => NODE,
        Section::Samplers => SAMPLER,
        Section::Scenes => SCENE,
        Section::Skins => SKIN,
        Section::Textures => TEXTURE,
    }
}

/// Where extensions that are understood have an effect.
const PLACES: [(&str, &[&str]); 8] = [
    (super::instancing::GPU_INSTANCING, &["nodes"]),
    ("EXT_texture_webp", &["textures"]),
    ("KHR_lights_punctual", &["nodes", "extensions"]),
    ("KHR_materials_emissive_strength", &["materials"]),
    ("KHR_materials_transmission", &["materials"]),
    ("KHR_materials_unlit", &["materials"]),
    ("KHR_node_visibility", &["nodes"]),
    (super::extension::SHADOW_NODE, &["nodes"]),
];

/// Notes on the document as a whole: empty arrays, extensions that are ignored, undeclared, or in the wrong place.
pub(super) fn check_root(document: &Document, warnings: &mut Warnings, remarks: &mut Warnings) {
    let names = |key: &str| -> Option<Vec<&str>> {
        let value = document.rest.get(key)?.as_array()?;
        Some(value.iter().filter_map(Value::as_str).collect())
    };
    let used = names("extensionsUsed").unwrap_or_default();
    let required = names("extensionsRequired").unwrap_or_default();
    for key in ["extensionsUsed", "extensionsRequired"] {
        if document.rest.get(key).is_some_and(|value| {
            names(key).is_none_or(|all| Some(all.len()) != value.as_array().map(Vec::len))
        }) {
            remarks.add(format!("'{key}' should be an array of names"));
        }
        let all = names(key).unwrap_or_default();
        if all.iter().collect::<BTreeSet<_>>().len() < all.len() {
            remarks.add(format!("'{key}' names an extension twice"));
        }
    }
    for name in used.iter().filter(|name| !SUPPORTED_EXTENSIONS.contains(name)) {
        warnings.add(format!("the extension {} is not supported, and ignored", shown(name)));
    }
    for name in required.iter().filter(|name| !used.contains(name)) {
        remarks.add(format!("the extension {} is required, but not in 'extensionsUsed'", shown(name)));
    }
    let mut found = BTreeSet::new();
    for section in Section::ALL {
        let place = if section == Section::Lights { "lights" } else { section.key() };
        document.section(section).iter().for_each(|value| extensions(place, value, &mut found));
    }
    for (place, value) in &document.rest {
        extensions(place, value, &mut found);
    }
    if let Some(value) = document.rest.get("extensions") {
        match value.as_object() {
            Some(object) => found.extend(object.keys().map(|name| ("extensions".to_owned(), name.clone()))),
            None => remarks.add("'extensions' should be a JSON object"),
        }
    }
    let undeclared: BTreeSet<&str> =
        found.iter().map(|(_, name)| name.as_str()).filter(|name| !used.contains(name)).collect();
    for name in undeclared {
        remarks.add(format!("the extension {} is used, but not in 'extensionsUsed'", shown(name)));
    }
    for (place, name) in &found {
        let places = PLACES.iter().find(|(known, _)| known == name).map(|(_, places)| *places);
        if places.is_some_and(|places| !places.contains(&place.as_str())) {
            remarks.add(format!("the extension {} has no effect in '{place}'", shown(name)));
        }
    }
    let meant_empty = |key: &String, value: &Value| {
        value.as_array().is_some_and(Vec::is_empty) && key.starts_with("extensions")
    };
    for (key, _) in document.rest.iter().filter(|(key, value)| meant_empty(key, value)) {
        remarks.add(format!("'{key}' is empty"));
    }
    document.empty.iter().for_each(|section| remarks.add(format!("'{}' is empty", section.key())));
}

/// The names of all extensions within a value, with `place`; extras are their writer's own.
fn extensions(place: &str, value: &Value, found: &mut BTreeSet<(String, String)>) {
    match value {
        Value::Array(values) => values.iter().for_each(|value| extensions(place, value, found)),
        Value::Object(object) => {
            for (key, value) in object.iter().filter(|(key, _)| *key != "extras") {
                if key == "extensions"
                    && let Some(object) = value.as_object()
                {
                    found.extend(object.keys().map(|name| (place.to_owned(), name.clone())));
                }
                extensions(place, value, found);
            }
        }
        _ => {}
    }
}
