//! The JSON of a glTF file, section by section, as plain values.
//!
//! Nothing is read before something needs it: files hold accessors, buffers and materials that nothing uses, and faults in
//! those do no harm. What is used is checked first ([`Document::used`], by the tables of `shapes`).

use std::cell::RefCell;
use std::collections::BTreeSet;

use serde_json::{Map, Value};

use super::GltfError;
use super::limits::{MAX_JSON_OBJECTS, MAX_JSON_VALUES, Warnings};
use super::{check, shapes};

/// The extensions the loader understands; any other that a file requires is an error.
pub(super) const SUPPORTED_EXTENSIONS: [&str; 13] = [
    super::instancing::GPU_INSTANCING,
    super::meshopt::MESHOPT,
    "EXT_texture_webp",
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

/// The arrays of a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Section {
    Accessors,
    Animations,
    Buffers,
    BufferViews,
    Cameras,
    Images,
    Lights,
    Materials,
    Meshes,
    Nodes,
    Samplers,
    Scenes,
    Skins,
    Textures,
}

impl Section {
    pub(super) const ALL: [Self; 14] = [
        Self::Accessors,
        Self::Animations,
        Self::Buffers,
        Self::BufferViews,
        Self::Cameras,
        Self::Images,
        Self::Lights,
        Self::Materials,
        Self::Meshes,
        Self::Nodes,
        Self::Samplers,
        Self::Scenes,
        Self::Skins,
        Self::Textures,
    ];

    /// Its key in the document.
    pub(super) fn key(self) -> &'static str {
        match self {
            Self::Accessors => "accessors",
            Self::Animations => "animations",
            Self::Buffers => "buffers",
            Self::BufferViews => "bufferViews",
            Self::Cameras => "cameras",
            Self::Images => "images",
            Self::Lights => "lights",
            Self::Materials => "materials",
            Self::Meshes => "meshes",
            Self::Nodes => "nodes",
            Self::Samplers => "samplers",
            Self::Scenes => "scenes",
            Self::Skins => "skins",
            Self::Textures => "textures",
        }
    }

    /// What messages call several of its things.
    pub(super) fn plural(self) -> &'static str {
        if self == Self::BufferViews { "buffer views" } else { self.key() }
    }
}

/// The parsed document.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub(super) accessors: Vec<Value>,
    pub(super) buffers: Vec<Value>,
    pub(super) buffer_views: Vec<Value>,
    pub(super) images: Vec<Value>,
    pub(super) materials: Vec<Value>,
    pub(super) meshes: Vec<Value>,
    pub(super) samplers: Vec<Value>,
    pub(super) textures: Vec<Value>,
    pub(super) nodes: Vec<Value>,
    pub(super) skins: Vec<Value>,
    pub(super) animations: Vec<Value>,
    pub(super) scenes: Vec<Value>,
    pub(super) default_scene: Option<u64>,
    pub(super) cameras: Vec<Value>,
    pub(super) lights: Vec<Value>,
    /// Sections that are there, but hold nothing; glTF wants those left out.
    pub(super) empty: Vec<Section>,
    /// What remains: `asset`, `extensions`, `extensionsUsed`, …
    pub(super) rest: Map<String, Value>,
    /// What was asked for by [`Document::used`], and what is odd about it.
    used: RefCell<Used>,
}

/// What became known of a document while it was read.
#[derive(Debug, Default)]
struct Used {
    /// The things that something needed.
    things: BTreeSet<(Section, usize)>,
    /// What is odd about them.
    notes: Vec<String>,
}

impl Document {
    /// Parses the JSON of a file.
    ///
    /// # Errors
    /// What is no JSON, too large, of another version, or needs an extension that is not supported.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, GltfError> {
        check_size(bytes)?;
        let mut rest: Map<String, Value> = serde_json::from_slice(bytes).map_err(|error| {
            GltfError::Json { section: "the document".into(), problem: error.to_string() }
        })?;
        rest.values_mut().for_each(whole_numbers);
        check_version(&rest)?;
        check_required(&rest)?;

        let default_scene = rest.get("scene").filter(|scene| !scene.is_null());
        let default_scene = default_scene
            .map(|scene| scene.as_u64().ok_or_else(|| unreadable("scene", "the index of a scene is needed")));
        let mut empty = Vec::new();
        let mut section = |section: Section| match rest.remove(section.key()) {
            None | Some(Value::Null) => Ok(Vec::new()),
            Some(Value::Array(values)) if values.is_empty() => {
                empty.push(section);
                Ok(values)
            }
            Some(Value::Array(values)) => Ok(values),
            Some(_) => Err(unreadable(section.key(), "an array is needed")),
        };
        let mut document = Self {
            accessors: section(Section::Accessors)?,
            buffers: section(Section::Buffers)?,
            buffer_views: section(Section::BufferViews)?,
            images: section(Section::Images)?,
            materials: section(Section::Materials)?,
            meshes: section(Section::Meshes)?,
            samplers: section(Section::Samplers)?,
            textures: section(Section::Textures)?,
            nodes: section(Section::Nodes)?,
            skins: section(Section::Skins)?,
            animations: section(Section::Animations)?,
            scenes: section(Section::Scenes)?,
            cameras: section(Section::Cameras)?,
            default_scene: None,
            ..Self::default()
        };
        document.empty = empty;
        document.rest = rest;
        document.default_scene = default_scene.transpose()?;
        document.take_lights()?;
        Ok(document)
    }

    /// Moves the lights to their section; they lie in an extension.
    fn take_lights(&mut self) -> Result<(), GltfError> {
        let punctual = self.rest.get_mut("extensions").and_then(|all| all.get_mut("KHR_lights_punctual"));
        self.lights = match punctual.and_then(|punctual| punctual.get_mut("lights")).map(Value::take) {
            None | Some(Value::Null) => Vec::new(),
            Some(Value::Array(lights)) => {
                self.empty.extend(lights.is_empty().then_some(Section::Lights));
                lights
            }
            Some(_) => {
                let path = "extensions.KHR_lights_punctual.lights".into();
                return Err(GltfError::Invalid { path, problem: "an array of lights is needed".into() });
            }
        };
        Ok(())
    }

    /// The things of one section.
    pub(super) fn section(&self, section: Section) -> &[Value] {
        match section {
            Section::Accessors => &self.accessors,
            Section::Animations => &self.animations,
            Section::Buffers => &self.buffers,
            Section::BufferViews => &self.buffer_views,
            Section::Cameras => &self.cameras,
            Section::Images => &self.images,
            Section::Lights => &self.lights,
            Section::Materials => &self.materials,
            Section::Meshes => &self.meshes,
            Section::Nodes => &self.nodes,
            Section::Samplers => &self.samplers,
            Section::Scenes => &self.scenes,
            Section::Skins => &self.skins,
            Section::Textures => &self.textures,
        }
    }

    /// The thing at `index`, its fields checked: those there have the types, and name the things, that they should.
    ///
    /// Fields that are wrong but harmless are noted.
    pub(super) fn used(&self, section: Section, index: usize) -> Result<&Map<String, Value>, GltfError> {
        let values = self.section(section);
        let path = || format!("{}[{index}]", section.key());
        let Some(value) = values.get(index) else {
            return Err(GltfError::Invalid {
                path: path(),
                problem: check::out_of_bounds(self, section, index as u64),
            });
        };
        let mut used = self.used.borrow_mut();
        if used.things.insert((section, index)) {
            for finding in check::findings(self, section, index) {
                if finding.harmless {
                    used.notes.push(finding.to_string());
                } else {
                    return Err(finding.into());
                }
            }
        }
        value
            .as_object()
            .ok_or_else(|| GltfError::Invalid { path: path(), problem: "must be a JSON object".into() })
    }

    /// Adds a remark: something is not as it should be, but does no harm.
    pub(super) fn note(&self, text: String) {
        let notes = &mut self.used.borrow_mut().notes;
        if notes.len() < 1000 {
            notes.push(text);
        }
    }

    /// Remarks on all that is wrong in the document, but did no harm; what is left out goes to the warnings.
    pub(super) fn finish(&self, warnings: &mut Warnings) -> Warnings {
        let mut remarks = Warnings::default();
        let Used { things, notes } = &*self.used.borrow();
        notes.iter().for_each(|text| remarks.add(text.clone()));
        for section in Section::ALL {
            for index in 0..self.section(section).len() {
                if remarks.is_full() {
                    break;
                }
                if !things.contains(&(section, index)) {
                    check::findings(self, section, index)
                        .iter()
                        .for_each(|finding| remarks.add(finding.to_string()));
                }
            }
        }
        shapes::check_root(self, warnings, &mut remarks);
        super::usage::check(self, &mut remarks);
        remarks
    }

    /// Whether the file cannot be understood without an extension, as it says itself.
    pub(super) fn requires(&self, extension: &str) -> bool {
        let required = self.rest.get("extensionsRequired").and_then(Value::as_array);
        required.is_some_and(|names| names.iter().any(|name| name == extension))
    }

    /// The names of all scenes; empty ones for those without.
    pub(super) fn scene_names(&self) -> Vec<String> {
        let name = |scene: &Value| scene.get("name").and_then(Value::as_str).unwrap_or_default().to_owned();
        self.scenes.iter().map(name).collect()
    }
}

/// Refuses versions other than 2.
fn check_version(rest: &Map<String, Value>) -> Result<(), GltfError> {
    let asset = rest.get("asset").unwrap_or(&Value::Null);
    let version = asset.get("version").and_then(Value::as_str).unwrap_or("(none)");
    let minimum = asset.get("minVersion").and_then(Value::as_str).unwrap_or("2.0");
    if !version.starts_with("2.") || minimum != "2.0" {
        let found = if version.starts_with("2.") { minimum } else { version };
        return Err(GltfError::Version { found: found.chars().take(20).collect() });
    }
    Ok(())
}

/// Refuses files that cannot be understood without an extension which the loader does not know.
fn check_required(rest: &Map<String, Value>) -> Result<(), GltfError> {
    let required = rest.get("extensionsRequired").map_or(Ok(&[][..]), |value| {
        let names = value.as_array().filter(|names| names.iter().all(Value::is_string));
        names
            .map(Vec::as_slice)
            .ok_or_else(|| unreadable("extensionsRequired", "an array of names is needed"))
    })?;
    let unknown = |name: &&str| !SUPPORTED_EXTENSIONS.contains(name);
    if let Some(name) = required.iter().filter_map(Value::as_str).find(unknown) {
        return Err(GltfError::UnsupportedExtension { name: name.into(), fix: remedy(name) });
    }
    Ok(())
}

/// Refuses JSON whose parsed form would take many times the memory of its text.
fn check_size(bytes: &[u8]) -> Result<(), GltfError> {
    let (mut objects, mut values) = (0, 0);
    for byte in bytes {
        objects += u64::from(*byte == b'{');
        values += u64::from(matches!(byte, b'{' | b'[' | b','));
    }
    for (what, count, limit) in
        [("objects of the JSON", objects, MAX_JSON_OBJECTS), ("values of the JSON", values, MAX_JSON_VALUES)]
    {
        if count > limit {
            return Err(GltfError::TooLarge { what: what.into(), count, limit });
        }
    }
    Ok(())
}

/// The largest whole number that every reader of JSON keeps exactly.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// Numbers without a fraction become integers: `1.0` and `1e0` are whole numbers in glTF (2.0, 2.7), and what is a
/// number of any kind reads them alike.
fn whole_numbers(value: &mut Value) {
    match value {
        Value::Number(number) if number.is_f64() => {
            if let Some(float) = number.as_f64()
                && float.fract() == 0.0
                && float.abs() <= MAX_EXACT
                && !(float == 0.0 && float.is_sign_negative())
            {
                *number = if float < 0.0 { (float as i64).into() } else { (float as u64).into() };
            }
        }
        // The parser has a limit to how deep values lie within one another.
        Value::Array(values) => values.iter_mut().for_each(whole_numbers),
        Value::Object(object) => object.values_mut().for_each(whole_numbers),
        _ => {}
    }
}

fn unreadable(section: &str, problem: &str) -> GltfError {
    GltfError::Json { section: format!("'{section}'"), problem: problem.into() }
}

/// What to do about a required extension that is not supported.
pub(super) fn remedy(extension: &str) -> String {
    match extension {
        "KHR_draco_mesh_compression" => {
            "re-export without Draco compression (gltf-transform and Blender decode it)".into()
        }
        "KHR_meshopt_compression" => "re-export with EXT_meshopt_compression, or without either".into(),
        "KHR_texture_basisu" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "re-export with PNG, JPEG or WebP textures".into()
        }
        "KHR_materials_pbrSpecularGlossiness" => "convert its materials to metallic-roughness".into(),
        _ => format!("re-export without it (supported are {})", SUPPORTED_EXTENSIONS.join(", ")),
    }
}
