//! The graph itself: nodes, keys, what nodes refer to, and revisions.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::sync::Arc;

use glam::{DAffine3, Vec3};
use slotmap::{SlotMap, new_key_type};
use thiserror::Error;

use super::deform::DeformCache;
use super::playback::Rest;
use super::{Animation, Camera, Content, Image, Light, Material, ShadowNode, Skin, Transform};
use crate::geometry::Mesh;

mod hierarchy;

new_key_type! {
    /// A node of the graph.
    pub struct NodeKey;
    /// A mesh, shared by any number of nodes.
    pub struct MeshKey;
    /// A material.
    pub struct MaterialKey;
    /// An image.
    pub struct ImageKey;
    /// A light.
    pub struct LightKey;
    /// A camera.
    pub struct CameraKey;
    /// A shadow node.
    pub struct ShadowKey;
    /// A skin.
    pub struct SkinKey;
    /// An animation.
    pub struct AnimationKey;
}

/// A node: a transform, one content, a parent and children.
#[derive(Clone, Debug)]
pub struct Node {
    /// Its name; need not be unique.
    pub name: String,
    /// Its transform relative to the parent; any affine map, mirrored and singular ones included.
    pub parent_from_local: DAffine3,
    /// What it holds.
    pub content: Content,
    /// Whether it and everything under it is drawn, shines and casts.
    pub visible: bool,
    /// Its index in the file it was loaded from: what messages call it when it has no name.
    pub file_index: Option<usize>,
    pub(super) rest: Option<Rest>,
    parent: Option<NodeKey>,
    children: Vec<NodeKey>,
}

impl Node {
    /// What messages call it: its name, or its place in its file.
    pub fn label(&self) -> String {
        match self.file_index {
            Some(index) if self.name.is_empty() => format!("node {index}"),
            _ => self.name.clone(),
        }
    }

    /// The parent; `None` for a root.
    pub fn parent(&self) -> Option<NodeKey> {
        self.parent
    }

    /// Its transform while nothing is animated, for nodes that animations move or that have translation, rotation and
    /// scale.
    pub fn rest(&self) -> Option<&Transform> {
        self.rest.as_ref().map(|rest| &rest.transform)
    }

    /// The weights of its mesh's morph targets while nothing is animated, for such nodes.
    pub fn rest_weights(&self) -> Option<&[f64]> {
        self.rest.as_ref().map(|rest| &rest.weights[..])
    }

    /// The children, in the order they were added.
    pub fn children(&self) -> &[NodeKey] {
        &self.children
    }
}

/// What can be wrong with an operation on the graph.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SceneError {
    #[error("{what} {key} is not in the scene (removed, or from another scene)")]
    Missing { what: &'static str, key: String },
    #[error("node '{node}' cannot become a child of '{parent}', which is itself or lies under it")]
    Cycle { node: String, parent: String },
    #[error("node '{node}': its transform is not finite, or places it beyond 1e18 m")]
    BadTransform { node: String },
    #[error("{what} '{name}': {problem}")]
    BadContent { what: &'static str, name: String, problem: String },
    #[error("animations cannot be shown at {seconds} s (finite times are accepted)")]
    BadTime { seconds: f64 },
}

/// A scene: a forest of nodes and what they hold.
///
/// Every change of the scene gives it a new [`Scene::revision`]; two scenes with the same revision are the same.
#[derive(Clone, Debug)]
pub struct Scene {
    pub(super) nodes: SlotMap<NodeKey, Node>,
    meshes: SlotMap<MeshKey, Arc<Mesh>>,
    materials: SlotMap<MaterialKey, Arc<Material>>,
    default_material: Arc<Material>,
    images: SlotMap<ImageKey, Arc<Image>>,
    lights: SlotMap<LightKey, Light>,
    cameras: SlotMap<CameraKey, Camera>,
    shadows: SlotMap<ShadowKey, ShadowNode>,
    pub(super) skins: SlotMap<SkinKey, Skin>,
    pub(super) animations: SlotMap<AnimationKey, Animation>,
    /// Bent meshes of recent poses; shared by clones, since equal poses are equal whoever asks.
    pub(super) deformed: Arc<DeformCache>,
    roots: Vec<NodeKey>,
    ambient: Vec3,
    background: Vec3,
    revision: u64,
}

impl Default for Scene {
    fn default() -> Self {
        Self::new()
    }
}

fn next_revision() -> u64 {
    use std::sync::atomic::{AtomicU64, Ordering};
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

macro_rules! stores {
    ($($what:literal $field:ident: $key:ty => $value:ty, $add:ident, $get:ident, $get_mut:ident, $all:ident;)*) => {
        /// What the nodes refer to, by key.
        impl Scene {
            $(
                #[doc = concat!("Stores a ", $what, " and returns its key.")]
                pub fn $add(&mut self, value: $value) -> $key {
                    self.touch();
                    self.$field.insert(value)
                }

                #[doc = concat!("The ", $what, " behind `key`, if it is still there.")]
                pub fn $get(&self, key: $key) -> Option<&$value> {
                    self.$field.get(key)
                }

                #[doc = concat!("The ", $what, " behind `key` for changing; counts as a change of the scene.")]
                pub fn $get_mut(&mut self, key: $key) -> Option<&mut $value> {
                    self.touch();
                    self.$field.get_mut(key)
                }

                #[doc = concat!("Every ", $what, " with its key.")]
                pub fn $all(&self) -> impl Iterator<Item = ($key, &$value)> {
                    self.$field.iter()
                }
            )*
        }
    };
}

stores! {
    "mesh" meshes: MeshKey => Arc<Mesh>, add_mesh_data, mesh, mesh_mut, meshes;
    "image" images: ImageKey => Arc<Image>, add_image, image, image_mut, images;
    "light" lights: LightKey => Light, add_light_data, light, light_mut, lights;
    "camera" cameras: CameraKey => Camera, add_camera_data, camera, camera_mut, cameras;
    "shadow node" shadows: ShadowKey => ShadowNode, add_shadow_data, shadow, shadow_mut, shadows;
}

impl Scene {
    /// An empty scene with a faint ambient light and a dark background.
    pub fn new() -> Self {
        Self {
            nodes: SlotMap::with_key(),
            meshes: SlotMap::with_key(),
            materials: SlotMap::with_key(),
            default_material: Arc::new(Material::default()),
            images: SlotMap::with_key(),
            lights: SlotMap::with_key(),
            cameras: SlotMap::with_key(),
            shadows: SlotMap::with_key(),
            skins: SlotMap::with_key(),
            animations: SlotMap::with_key(),
            deformed: Arc::default(),
            roots: Vec::new(),
            ambient: Vec3::splat(0.06),
            background: Vec3::new(0.02, 0.024, 0.03),
            revision: next_revision(),
        }
    }

    /// Stores a material and returns its key.
    pub fn add_material(&mut self, material: Material) -> MaterialKey {
        self.touch();
        self.materials.insert(Arc::new(material))
    }

    /// The material behind `key`, if it is still there.
    pub fn material(&self, key: MaterialKey) -> Option<&Material> {
        self.materials.get(key).map(Arc::as_ref)
    }

    /// Every material with its key.
    pub fn materials(&self) -> impl Iterator<Item = (MaterialKey, &Material)> {
        self.materials.iter().map(|(key, material)| (key, material.as_ref()))
    }

    /// The material behind `key`, shared: the same allocation for as long as it does not change.
    pub(super) fn shared_material(&self, key: MaterialKey) -> Option<&Arc<Material>> {
        self.materials.get(key)
    }

    /// What parts without a material wear.
    pub(super) fn default_material(&self) -> &Arc<Material> {
        &self.default_material
    }

    pub(super) fn touch(&mut self) {
        self.revision = next_revision();
    }

    /// A number that changes with every change of the scene and that no two different scenes share.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Light that reaches every surface unshadowed: linear, relative to the exposure (1 is white).
    pub fn ambient(&self) -> Vec3 {
        self.ambient
    }

    /// Sets the ambient light.
    pub fn set_ambient(&mut self, ambient: Vec3) {
        self.touch();
        self.ambient = ambient;
    }

    /// The linear colour where nothing is.
    pub fn background(&self) -> Vec3 {
        self.background
    }

    /// Sets the background.
    pub fn set_background(&mut self, background: Vec3) {
        self.touch();
        self.background = background;
    }

    /// Adds a node under `parent` (a root for `None`, or when the parent is gone).
    pub fn add(
        &mut self,
        parent: Option<NodeKey>,
        name: &str,
        parent_from_local: DAffine3,
        content: Content,
    ) -> NodeKey {
        self.touch();
        let parent = parent.filter(|key| self.nodes.contains_key(*key));
        let node = Node {
            name: name.into(),
            parent_from_local,
            content,
            visible: true,
            file_index: None,
            rest: None,
            parent,
            children: Vec::new(),
        };
        let key = self.nodes.insert(node);
        match parent {
            Some(parent) => self.nodes[parent].children.push(key),
            None => self.roots.push(key),
        }
        key
    }

    /// What messages call a node: as [`Node::label`], or by its place among all, which is its index once the scene is
    /// saved. The places are found when the first is asked for.
    pub(super) fn label(
        &self,
        key: NodeKey,
        node: &Node,
        places: &OnceCell<HashMap<NodeKey, usize>>,
    ) -> String {
        let label = node.label();
        if !label.is_empty() {
            return label;
        }
        let places = places.get_or_init(|| {
            self.depth_first().into_iter().enumerate().map(|(place, key)| (key, place)).collect()
        });
        places.get(&key).map_or_else(String::new, |place| format!("node {place}"))
    }

    /// The node behind `key`, if it is still there.
    pub fn node(&self, key: NodeKey) -> Option<&Node> {
        self.nodes.get(key)
    }

    /// The node behind `key` for changing its name, transform, content or visibility.
    pub fn node_mut(&mut self, key: NodeKey) -> Option<&mut Node> {
        self.touch();
        self.nodes.get_mut(key)
    }

    /// Every node with its key, in no particular order.
    pub fn nodes(&self) -> impl Iterator<Item = (NodeKey, &Node)> {
        self.nodes.iter()
    }

    /// The scene with an empty group in place of every content that is one of `which`: transforms and children stay.
    pub fn emptied_of(&self, which: impl Fn(&Content) -> bool) -> Self {
        let mut scene = self.clone();
        scene.touch();
        for node in scene.nodes.values_mut().filter(|node| which(&node.content)) {
            node.content = Content::Group;
        }
        scene
    }

    /// The scene without its shadow nodes; what they were in stays.
    pub fn without_shadows(&self) -> Self {
        self.emptied_of(|content| matches!(content, Content::Shadow(_)))
    }

    /// The nodes without a parent, in the order they were added.
    pub fn roots(&self) -> &[NodeKey] {
        &self.roots
    }

    /// Removes every mesh, skin, light, camera and shadow node that no node holds.
    pub fn remove_unused(&mut self) {
        self.touch();
        let contents: Vec<Content> = self.nodes.values().map(|node| node.content.clone()).collect();
        self.meshes.retain(|key, _| contents.iter().any(|c| matches!(c, Content::Mesh(m) if m.mesh == key)));
        self.skins
            .retain(|key, _| contents.iter().any(|c| matches!(c, Content::Mesh(m) if m.skin == Some(key))));
        self.lights.retain(|key, _| contents.contains(&Content::Light(key)));
        self.cameras.retain(|key, _| contents.contains(&Content::Camera(key)));
        self.shadows.retain(|key, _| contents.contains(&Content::Shadow(key)));
    }
}
