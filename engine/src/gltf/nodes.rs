//! Nodes: hierarchy, transforms and what they carry.
//!
//! A glTF node may carry a mesh, a light, a camera and extensions at once; an engine node holds one thing. The
//! first stays on the node, the others become children of it that stand where it stands.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use serde_json::Value;

use super::accessors::Accessors;
use super::document::Document;
use super::extension::{self, SHADOW_NODE, Targets};
use super::fields::{Item, Switches};
use super::hierarchy::Hierarchy;
use super::images::Images;
use super::limits::{Budget, Warnings};
use super::transforms::transform;
use super::uri::Files;
use super::{GltfError, SceneChoice, ShadowTypes, materials, meshes, punctual};
use crate::geometry::Mesh;
use crate::scene::{
    CameraKey, Content, ImageKey, LightKey, MaterialKey, MeshKey, MeshNode, NodeKey, Scene, ShadowFlags,
    ShadowKey, ShadowNode,
};

/// A loaded glTF mesh: its shape, its materials by slot, and the shadow flags it states.
type MeshEntry = (MeshKey, Vec<MaterialKey>, Switches);

/// Builds an engine scene from a document.
pub(super) struct Builder<'a> {
    pub(super) document: &'a Document,
    pub(super) accessors: Accessors<'a>,
    pub(super) files: &'a Files,
    pub(super) budget: Budget,
    pub(super) warnings: Warnings,
    pub(super) scene: Scene,
    pub(super) scene_index: Option<usize>,
    meshes: HashMap<usize, MeshEntry>,
    materials: HashMap<Option<usize>, MaterialKey>,
    images: HashMap<usize, ImageKey>,
    lights: HashMap<(usize, String, bool), LightKey>,
    cameras: HashMap<(usize, String), CameraKey>,
}

impl<'a> Builder<'a> {
    pub(super) fn new(
        document: &'a Document,
        accessors: Accessors<'a>,
        files: &'a Files,
        budget: Budget,
        warnings: Warnings,
    ) -> Self {
        Self {
            document,
            accessors,
            files,
            budget,
            warnings,
            scene: Scene::new(),
            scene_index: None,
            meshes: HashMap::new(),
            materials: HashMap::new(),
            images: HashMap::new(),
            lights: HashMap::new(),
            cameras: HashMap::new(),
        }
    }

    /// Adds the nodes of scene `wanted`, and returns the keys by glTF node index.
    pub(super) fn build(
        &mut self,
        wanted: SceneChoice<'_>,
        types: Option<&dyn ShadowTypes>,
    ) -> Result<Vec<Option<NodeKey>>, GltfError> {
        let document = self.document;
        let nodes = items("node", &document.nodes)?;
        let hierarchy = Hierarchy::read(&nodes)?;
        let roots = self.roots(wanted, &hierarchy, nodes.len())?;

        let order = hierarchy.preorder(roots);
        let mut keys: Vec<Option<NodeKey>> = vec![None; nodes.len()];
        let (mut has_light, mut has_mesh) = (vec![false; nodes.len()], vec![false; nodes.len()]);
        let mut instanced = vec![false; nodes.len()];
        let mut shadows: Vec<(ShadowKey, usize)> = Vec::new();
        for &index in &order {
            let node = &nodes[index];
            let contents = self.contents(node)?;
            // A light whose type is not supported is left out, but a shadow node may name it.
            has_light[index] = node.extension("KHR_lights_punctual").is_some();
            for content in &contents {
                has_mesh[index] |= matches!(content, Content::Mesh(_));
                if let Content::Shadow(key) = content {
                    shadows.push((*key, index));
                }
            }
            let parent = hierarchy.parent(index).and_then(|parent| keys[parent]);
            let key = self.add(node, parent, contents)?;
            keys[index] = Some(key);
            instanced[index] = self.spread(node, key)?;
        }
        self.bend(&nodes, &hierarchy, &order, &keys, &instanced)?;
        for &index in order.iter().rev() {
            if let Some(parent) = hierarchy.parent(index) {
                has_light[parent] |= has_light[index];
                has_mesh[parent] |= has_mesh[index];
            }
        }

        let targets = Targets { keys: &keys, lights: &has_light, meshes: &has_mesh };
        for (key, index) in shadows {
            let node = &nodes[index];
            let value = node.extension(SHADOW_NODE).unwrap_or(&Value::Null);
            let shadow = extension::read(&node.label(), value, &targets)?;
            if let Some(types) = types {
                let bad = |problem| GltfError::ShadowType { node: node.label(), problem };
                types.check(&shadow).map_err(bad)?;
            }
            if let Some(slot) = self.scene.shadow_mut(key) {
                *slot = shadow;
            }
        }
        Ok(keys)
    }

    /// The root nodes of the scene to load; also takes over its surroundings.
    fn roots(
        &mut self,
        wanted: SceneChoice<'_>,
        hierarchy: &Hierarchy,
        nodes: usize,
    ) -> Result<Vec<usize>, GltfError> {
        let count = self.document.scenes.len();
        let default = self.document.default_scene.map(|scene| usize::try_from(scene).unwrap_or(usize::MAX));
        let index = match wanted {
            SceneChoice::Index(scene) => scene,
            SceneChoice::Name(name) => self.scene_called(name)?,
            SceneChoice::Default => default.unwrap_or(0),
        };
        if index >= count && (wanted, default) != (SceneChoice::Default, None) {
            return Err(GltfError::NoSuchScene { scene: index, count });
        }
        let Some(value) = self.document.scenes.get(index) else {
            self.warnings.add("the file has no scene; nothing is shown");
            return Ok(Vec::new());
        };
        self.scene_index = Some(index);
        let item = Item::new("scene", index, value)?;
        let roots = item.indices("nodes", "node", nodes)?;
        hierarchy.check_roots(index, &roots, &mut self.warnings)?;
        if let Some(extras) = item.inner("extras").ok().flatten() {
            let color =
                |field| extras.numbers::<3>(field).ok().flatten().map(|rgb| DVec3::from(rgb).as_vec3());
            if let Some(ambient) = color("shadowgraphAmbient").filter(|color| color.is_finite()) {
                self.scene.set_ambient(ambient);
            }
            if let Some(background) = color("shadowgraphBackground").filter(|color| color.is_finite()) {
                self.scene.set_background(background);
            }
        }
        Ok(roots)
    }

    fn scene_called(&self, name: &str) -> Result<usize, GltfError> {
        let names = self.document.scene_names();
        names.iter().position(|other| other == name).ok_or_else(|| {
            let known = match names.len() {
                0 => "none".into(),
                _ => names.iter().map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", "),
            };
            GltfError::NoSuchSceneName { name: name.into(), known }
        })
    }

    /// Adds one glTF node.
    fn add(
        &mut self,
        node: &Item<'_>,
        parent: Option<NodeKey>,
        contents: Vec<Content>,
    ) -> Result<NodeKey, GltfError> {
        let name = node.name().unwrap_or_default();
        let mut contents = contents.into_iter();
        let first = contents.next().unwrap_or_default();
        let key = self.scene.add(parent, name, transform(node)?, first);
        let others = contents.map(|content| self.scene.add(Some(key), name, DAffine3::IDENTITY, content));
        for key in others.collect::<Vec<_>>().into_iter().chain([key]) {
            if let Some(added) = self.scene.node_mut(key) {
                added.file_index = Some(node.index);
            }
        }
        let visibility = node.extension("KHR_node_visibility").and_then(|value| value.get("visible"));
        if visibility.and_then(Value::as_bool) == Some(false)
            && let Some(added) = self.scene.node_mut(key)
        {
            added.visible = false;
        }
        Ok(key)
    }

    /// All that a glTF node carries.
    fn contents(&mut self, node: &Item<'_>) -> Result<Vec<Content>, GltfError> {
        let document = self.document;
        let name = node.name().unwrap_or_default();
        let switches = node.shadow_switches();
        let mut contents = Vec::new();
        if let Some(index) = node.index("mesh", "mesh", document.meshes.len())? {
            let (mesh, materials, stated) = self.mesh(index)?;
            let flags = switches.or(stated);
            let shadow =
                ShadowFlags { casts: flags.casts.unwrap_or(true), receives: flags.receives.unwrap_or(true) };
            let weights = self.weights(node, mesh)?;
            contents.push(Content::Mesh(MeshNode {
                shadow,
                weights,
                ..MeshNode::in_materials(mesh, materials)
            }));
        }
        if let Some(punctual) = node.extension("KHR_lights_punctual") {
            let reference = Item::new("light reference of node", node.index, punctual)?;
            let index = reference.index("light", "light", document.lights.len())?;
            let index = index.ok_or_else(|| reference.wrong("light", "is missing"))?;
            let item = Item::new("light", index, &document.lights[index])?;
            match punctual::light(&item, name)? {
                Some(mut light) => {
                    light.casts_shadows &= switches.casts.unwrap_or(true);
                    let scene = &mut self.scene;
                    let entry = self.lights.entry((index, light.name.clone(), light.casts_shadows));
                    contents.push(Content::Light(*entry.or_insert_with(|| scene.add_light_data(light))));
                }
                None => self
                    .warnings
                    .add(format!("{}: its type is not supported, and it is ignored", item.label())),
            }
        }
        if let Some(index) = node.index("camera", "camera", document.cameras.len())? {
            let camera = punctual::camera(&Item::new("camera", index, &document.cameras[index])?, name)?;
            let scene = &mut self.scene;
            let entry = self.cameras.entry((index, camera.name.clone()));
            contents.push(Content::Camera(*entry.or_insert_with(|| scene.add_camera_data(camera))));
        }
        if node.extension(SHADOW_NODE).is_some() {
            // Read once every node has its key.
            contents.push(Content::Shadow(self.scene.add_shadow_data(ShadowNode::default())));
        }
        Ok(contents)
    }

    /// A node's own weights of its mesh's morph targets.
    fn weights(&self, node: &Item<'_>, mesh: MeshKey) -> Result<Vec<f64>, GltfError> {
        let Some(weights) = node.get("weights") else { return Ok(Vec::new()) };
        let targets = self.scene.mesh(mesh).map_or(0, |mesh| mesh.data().morphs.len());
        let numbers = weights.as_array().map(|all| all.iter().filter_map(Value::as_f64).collect::<Vec<_>>());
        // Some exporters write an empty array for none.
        numbers.filter(|weights| weights.len() == targets || weights.is_empty()).ok_or_else(|| {
            node.wrong("weights", format!("must be {targets} numbers, one for each morph target"))
        })
    }

    fn mesh(&mut self, index: usize) -> Result<MeshEntry, GltfError> {
        if let Some(entry) = self.meshes.get(&index) {
            return Ok(entry.clone());
        }
        let read = meshes::read(&self.accessors, index, &mut self.budget, &mut self.warnings)?;
        let mesh = Mesh::new(read.data).map_err(|source| GltfError::Mesh { mesh: index, source })?;
        let key = self.scene.add_mesh_data(Arc::new(mesh));
        let materials: Result<_, _> =
            read.materials.iter().map(|material| self.material(*material)).collect();
        let entry = (key, materials?, stated_switches(&self.document.meshes[index]));
        self.meshes.insert(index, entry.clone());
        Ok(entry)
    }

    fn material(&mut self, index: Option<usize>) -> Result<MaterialKey, GltfError> {
        if let Some(key) = self.materials.get(&index) {
            return Ok(*key);
        }
        let document = self.document;
        let mut images = Images {
            document,
            buffers: &self.accessors.buffers,
            files: self.files,
            scene: &mut self.scene,
            budget: &mut self.budget,
            warnings: &mut self.warnings,
            loaded: std::mem::take(&mut self.images),
        };
        let material = match index {
            Some(index) => materials::read(document, index, &mut images)?,
            None => materials::gltf_default(),
        };
        self.images = images.loaded;
        let key = self.scene.add_material(material);
        self.materials.insert(index, key);
        Ok(key)
    }
}

/// The shadow flags in a mesh's `extras`, or those that any of its primitives states by extension.
fn stated_switches(mesh: &Value) -> Switches {
    let of = |value: Option<&Value>| value.and_then(Value::as_object).map(Switches::of).unwrap_or_default();
    let primitives = mesh.get("primitives").and_then(Value::as_array);
    let primitives = primitives.into_iter().flatten().map(|primitive| {
        of(primitive.get("extensions").and_then(|extensions| extensions.get(super::fields::LIGHTS_SHADOWS)))
    });
    primitives.fold(of(mesh.get("extras")), Switches::or)
}

fn items<'v>(kind: &'static str, values: &'v [Value]) -> Result<Vec<Item<'v>>, GltfError> {
    values.iter().enumerate().map(|(index, value)| Item::new(kind, index, value)).collect()
}
