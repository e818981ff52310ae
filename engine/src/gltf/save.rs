//! Saving scenes as `.glb`, so that they load back the same.
//!
//! Transforms, angles and ranges are written in f64 with all their digits, vertices bit by bit. What glTF has no
//! place for (a light's name where it differs from its node's, ambient light and background) goes to `extras`.
//!
//! Nodes that animations move are saved as they rest, whatever is shown at the moment; the animations bring the rest.

use std::collections::{BTreeMap, HashMap};
use std::io::Write;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::names::shown;
use super::punctual::OWN_NAME;
use super::save_materials::{Materials, gone};
use super::save_meshes::{Binary, WrittenMesh};
use super::{GltfError, SHADOW_NODE, extension, save_animations};
use crate::math::Projection;
use crate::scene::{
    Camera, CameraKey, Content, Light, LightKey, LightKind, MeshKey, MeshNode, Node, NodeKey, Scene,
    ShadowFlags, SkinKey,
};

/// A scene as a `.glb` file in memory.
#[must_use]
#[derive(Clone, Debug, PartialEq)]
pub struct Glb {
    /// The file.
    pub bytes: Vec<u8>,
    /// What was left out, each thing once.
    pub warnings: Vec<String>,
}

/// Saves `scene` as a `.glb` file, whole or not at all: it is written beside `path` and then renamed. Returns what was
/// left out, each thing once.
///
/// # Errors
/// [`GltfError::Save`] when the scene has something glTF cannot hold, [`GltfError::Io`] when writing fails.
pub fn save(scene: &Scene, path: impl AsRef<Path>) -> Result<Vec<String>, GltfError> {
    use std::sync::atomic::{AtomicU64, Ordering};
    static COUNTER: AtomicU64 = AtomicU64::new(0);
    let path = path.as_ref();
    let Glb { bytes, warnings } = to_glb(scene)?;
    let io = |source| GltfError::Io { path: path.display().to_string(), source };
    let Some(file_name) = path.file_name() else {
        return Err(io(std::io::Error::new(std::io::ErrorKind::InvalidInput, "names no file")));
    };
    let mut temporary_name = std::ffi::OsString::from(".");
    temporary_name.push(file_name);
    let unique = COUNTER.fetch_add(1, Ordering::Relaxed);
    temporary_name.push(format!(".{}.{unique}.tmp", std::process::id()));
    let temporary = path.with_file_name(temporary_name);
    let written = std::fs::File::create_new(&temporary)
        .and_then(|mut file| file.write_all(&bytes).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&temporary, path));
    written.map_err(|source| {
        // The first error is the one worth reporting.
        let _ = std::fs::remove_file(&temporary);
        io(source)
    })?;
    Ok(warnings)
}

/// `scene` as a `.glb` file in memory.
///
/// # Errors
/// [`GltfError::Save`] when the scene has something glTF cannot hold: numbers that are not finite, keys of things
/// that were removed, more than 2 GiB.
pub fn to_glb(scene: &Scene) -> Result<Glb, GltfError> {
    let order = scene.depth_first();
    let index_of: BTreeMap<NodeKey, usize> = order.iter().enumerate().map(|(i, key)| (*key, i)).collect();
    let mut writer = Writer::new(scene, &index_of);
    let mut nodes = Vec::with_capacity(order.len());
    for node in order.iter().filter_map(|key| scene.node(*key)) {
        nodes.push(writer.node(node)?);
    }
    let document = writer.document(nodes)?;
    writer.binary.check_size()?;
    let json = serde_json::to_vec(&document)
        .map_err(|error| GltfError::Save { what: "its JSON".into(), problem: error.to_string() })?;
    let bytes = container(&json, &writer.binary.bytes)?;
    Ok(Glb { bytes, warnings: writer.materials.warnings.into_texts() })
}

/// Puts JSON and binary chunk into one file, each padded to 4 bytes.
fn container(json: &[u8], bin: &[u8]) -> Result<Vec<u8>, GltfError> {
    let [json_size, bin_size] = [json.len(), bin.len()].map(|size| size.next_multiple_of(4));
    let total = 12 + 8 + json_size + if bin.is_empty() { 0 } else { 8 + bin_size };
    let length = u32::try_from(total).map_err(|_| GltfError::Save {
        what: "it".into(),
        problem: format!("takes {total} bytes; a .glb has at most {}", u32::MAX),
    })?;
    let mut bytes = Vec::with_capacity(total);
    bytes.extend(b"glTF");
    bytes.extend(2_u32.to_le_bytes());
    bytes.extend(length.to_le_bytes());
    bytes.extend((json_size as u32).to_le_bytes());
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.resize(20 + json_size, b' ');
    if !bin.is_empty() {
        bytes.extend((bin_size as u32).to_le_bytes());
        bytes.extend(b"BIN\0");
        bytes.extend(bin);
        bytes.resize(total, 0);
    }
    Ok(bytes)
}

/// The document while it is written.
struct Writer<'a> {
    scene: &'a Scene,
    index_of: &'a BTreeMap<NodeKey, usize>,
    binary: Binary,
    materials: Materials,
    meshes: Vec<Value>,
    lights: Vec<Value>,
    cameras: Vec<Value>,
    skins: Vec<Value>,
    written_skins: HashMap<SkinKey, usize>,
    written_shapes: HashMap<MeshKey, WrittenMesh>,
    written_meshes: HashMap<(MeshKey, Vec<usize>), usize>,
    written_lights: HashMap<(LightKey, String), usize>,
    written_cameras: HashMap<(CameraKey, String), usize>,
    uses_shadow_nodes: bool,
    uses_visibility: bool,
}

impl<'a> Writer<'a> {
    fn new(scene: &'a Scene, index_of: &'a BTreeMap<NodeKey, usize>) -> Self {
        Self {
            scene,
            index_of,
            binary: Binary::default(),
            materials: Materials::default(),
            meshes: Vec::new(),
            lights: Vec::new(),
            cameras: Vec::new(),
            skins: Vec::new(),
            written_skins: HashMap::new(),
            written_shapes: HashMap::new(),
            written_meshes: HashMap::new(),
            written_lights: HashMap::new(),
            written_cameras: HashMap::new(),
            uses_shadow_nodes: false,
            uses_visibility: false,
        }
    }

    fn node(&mut self, node: &Node) -> Result<Value, GltfError> {
        let mut value = json!({ "name": node.name });
        let parts = node.rest();
        let matrix = parts.map_or(node.parent_from_local, |parts| parts.matrix());
        if !matrix.is_finite() {
            let what = format!("node '{}'", shown(&node.label()));
            return Err(GltfError::Save { what, problem: "has a transform that is not finite".into() });
        }
        if let Some(parts) = parts {
            value["translation"] = json!(parts.translation.to_array());
            value["rotation"] = json!(parts.rotation.to_array());
            value["scale"] = json!(parts.scale.to_array());
        } else if matrix != glam::DAffine3::IDENTITY {
            value["matrix"] = glam::DMat4::from(matrix).to_cols_array().to_vec().into();
        }
        if !node.children().is_empty() {
            let children = node.children().iter().filter_map(|child| self.index_of.get(child).copied());
            value["children"] = children.collect::<Vec<usize>>().into();
        }
        let mut extensions = Map::new();
        match &node.content {
            Content::Group => {}
            Content::Mesh(content) => {
                value["mesh"] = self.mesh(content)?.into();
                if let Some(skin) = content.skin {
                    value["skin"] = self.skin(skin)?.into();
                }
                let weights = node.rest_weights().unwrap_or(&content.weights);
                if !weights.iter().all(|weight| weight.is_finite()) {
                    let what = format!("node '{}'", shown(&node.label()));
                    return Err(GltfError::Save { what, problem: "has weights that are not finite".into() });
                }
                if !weights.is_empty() {
                    value["weights"] = json!(weights);
                }
                if content.shadow != ShadowFlags::default() {
                    let ShadowFlags { casts, receives } = content.shadow;
                    value["extras"] = json!({ "castShadow": casts, "receiveShadow": receives });
                }
            }
            Content::Light(key) => {
                let light = self.light(*key, &node.name)?;
                extensions.insert("KHR_lights_punctual".into(), json!({ "light": light }));
            }
            Content::Camera(key) => value["camera"] = self.camera(*key, &node.name)?.into(),
            Content::Shadow(key) => {
                let shadow = self.scene.shadow(*key).ok_or_else(|| gone("a shadow node"))?;
                self.uses_shadow_nodes = true;
                extensions.insert(SHADOW_NODE.into(), extension::write(&node.name, shadow, self.index_of)?);
            }
        }
        if !node.visible {
            self.uses_visibility = true;
            extensions.insert("KHR_node_visibility".into(), json!({ "visible": false }));
        }
        if !extensions.is_empty() {
            value["extensions"] = extensions.into();
        }
        Ok(value)
    }

    fn mesh(&mut self, content: &MeshNode) -> Result<usize, GltfError> {
        let mesh = self.scene.mesh(content.mesh).ok_or_else(|| gone("a mesh"))?;
        let mut worn = Vec::new();
        for part in &mesh.data().parts {
            let material = content.materials.get(part.material_slot).copied();
            worn.push(self.materials.index(self.scene, material, &mut self.binary)?);
        }
        if let Some(index) = self.written_meshes.get(&(content.mesh, worn.clone())) {
            return Ok(*index);
        }
        let binary = &mut self.binary;
        let shape = self.written_shapes.entry(content.mesh).or_insert_with(|| binary.add_mesh(mesh));
        self.meshes.push(shape.in_materials(mesh.name(), &worn));
        self.written_meshes.insert((content.mesh, worn), self.meshes.len() - 1);
        Ok(self.meshes.len() - 1)
    }

    fn skin(&mut self, key: SkinKey) -> Result<usize, GltfError> {
        if let Some(index) = self.written_skins.get(&key) {
            return Ok(*index);
        }
        let skin = self.scene.skin(key).ok_or_else(|| gone("a skin"))?;
        self.skins.push(save_animations::skin(skin, self.index_of, &mut self.binary)?);
        self.written_skins.insert(key, self.skins.len() - 1);
        Ok(self.skins.len() - 1)
    }

    fn light(&mut self, key: LightKey, node: &str) -> Result<usize, GltfError> {
        let light = self.scene.light(key).ok_or_else(|| gone("a light"))?;
        if let Some(index) = self.written_lights.get(&(key, node.into())) {
            return Ok(*index);
        }
        self.lights.push(light_value(light, node)?);
        self.written_lights.insert((key, node.into()), self.lights.len() - 1);
        Ok(self.lights.len() - 1)
    }

    fn camera(&mut self, key: CameraKey, node: &str) -> Result<usize, GltfError> {
        let camera = self.scene.camera(key).ok_or_else(|| gone("a camera"))?;
        if let Some(index) = self.written_cameras.get(&(key, node.into())) {
            return Ok(*index);
        }
        self.cameras.push(camera_value(camera, node)?);
        self.written_cameras.insert((key, node.into()), self.cameras.len() - 1);
        Ok(self.cameras.len() - 1)
    }

    /// The whole document around its nodes.
    fn document(&mut self, nodes: Vec<Value>) -> Result<Value, GltfError> {
        let (ambient, background) = (self.scene.ambient(), self.scene.background());
        if !(ambient.is_finite() && background.is_finite()) {
            let what = "its ambient light or background".into();
            return Err(GltfError::Save { what, problem: "is not finite".into() });
        }
        let roots: Vec<usize> =
            self.scene.roots().iter().filter_map(|root| self.index_of.get(root).copied()).collect();
        let mut scene = json!({ "extras": {
            "shadowgraphAmbient": ambient.to_array(), "shadowgraphBackground": background.to_array(),
        } });
        if !roots.is_empty() {
            scene["nodes"] = roots.into();
        }
        let binary = &mut self.binary;
        let animations = self.scene.animations();
        let animations: Vec<Value> = animations
            .filter_map(|(_, animation)| save_animations::animation(animation, self.index_of, binary))
            .collect();
        let mut used: Vec<&str> = std::mem::take(&mut self.materials.extensions);
        let mut root_extensions = Map::new();
        if !self.lights.is_empty() {
            used.push("KHR_lights_punctual");
            let lights = std::mem::take(&mut self.lights);
            root_extensions.insert("KHR_lights_punctual".into(), json!({ "lights": lights }));
        }
        if self.uses_visibility {
            used.push("KHR_node_visibility");
        }
        if self.uses_shadow_nodes {
            used.push(SHADOW_NODE);
        }
        let buffers = match self.binary.bytes.len() {
            0 => Vec::new(),
            length => vec![json!({ "byteLength": length })],
        };
        let arrays = [
            ("nodes", nodes),
            ("meshes", std::mem::take(&mut self.meshes)),
            ("cameras", std::mem::take(&mut self.cameras)),
            ("skins", std::mem::take(&mut self.skins)),
            ("animations", animations),
            ("materials", std::mem::take(&mut self.materials.materials)),
            ("textures", std::mem::take(&mut self.materials.textures)),
            ("samplers", std::mem::take(&mut self.materials.samplers)),
            ("images", std::mem::take(&mut self.materials.images)),
            ("accessors", std::mem::take(&mut self.binary.accessors)),
            ("bufferViews", std::mem::take(&mut self.binary.views)),
            ("buffers", buffers),
            ("extensionsUsed", used.into_iter().map(Value::from).collect()),
        ];
        let mut document = json!({
            "asset": { "version": "2.0", "generator": concat!("Shadowgraph ", env!("CARGO_PKG_VERSION")) },
            "scene": 0,
            "scenes": [scene],
        });
        // glTF allows no empty arrays.
        for (name, values) in arrays.into_iter().filter(|(_, values)| !values.is_empty()) {
            document[name] = values.into();
        }
        if !root_extensions.is_empty() {
            document["extensions"] = root_extensions.into();
        }
        Ok(document)
    }
}

fn light_value(light: &Light, node: &str) -> Result<Value, GltfError> {
    let angles = match light.kind {
        LightKind::Spot { inner_rad, outer_rad } => [inner_rad, outer_rad],
        _ => [0.0; 2],
    };
    let numbers = [f64::from(light.intensity), light.range_m.unwrap_or(1.0), angles[0], angles[1]];
    if !(light.color.is_finite() && numbers.iter().all(|x| x.is_finite())) {
        let what = format!("light '{}'", shown(&light.name));
        return Err(GltfError::Save { what, problem: "has values that are not finite".into() });
    }
    let mut value = json!({
        "name": light.name, "color": light.color.to_array(), "intensity": light.intensity,
        "type": match light.kind {
            LightKind::Directional => "directional",
            LightKind::Point => "point",
            LightKind::Spot { .. } => "spot",
        },
    });
    if let LightKind::Spot { inner_rad, outer_rad } = light.kind {
        value["spot"] = json!({ "innerConeAngle": inner_rad, "outerConeAngle": outer_rad });
    }
    if let Some(range_m) = light.range_m {
        value["range"] = range_m.into();
    }
    if !light.casts_shadows {
        value["extras"]["castShadow"] = false.into();
    }
    if light.name != node {
        value["extras"][OWN_NAME] = light.name.as_str().into();
    }
    Ok(value)
}

fn camera_value(camera: &Camera, node: &str) -> Result<Value, GltfError> {
    if !camera.projection.is_valid() {
        let what = format!("camera '{}'", shown(&camera.name));
        return Err(GltfError::Save { what, problem: "has an invalid projection".into() });
    }
    let mut value = match camera.projection {
        Projection::Perspective { fov_y_rad, near_m } => {
            json!({ "type": "perspective", "perspective": { "yfov": fov_y_rad, "znear": near_m } })
        }
        Projection::Orthographic { half_height_m, near_m, far_m } => json!({
            "type": "orthographic",
            "orthographic": { "xmag": half_height_m, "ymag": half_height_m, "znear": near_m, "zfar": far_m },
        }),
    };
    value["name"] = camera.name.as_str().into();
    if camera.name != node {
        value["extras"] = json!({ OWN_NAME: camera.name });
    }
    Ok(value)
}
