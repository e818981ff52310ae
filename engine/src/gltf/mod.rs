//! Scenes in glTF 2.0: loading `.gltf` and `.glb`, and saving `.glb`.
//!
//! Loading takes nothing on trust: whatever the bytes, it ends with a scene or one [`GltfError`] that names the
//! offending thing, without a panic and within bounded memory. The steps, one file each: the container is split
//! (`container`), the JSON parsed and validated (`document`), buffers fetched (`buffers`, `uri`), and the nodes of
//! one scene built (`nodes`) from `meshes` (through `accessors`; influences and morph targets in `deformations`),
//! `materials`, `images`, lights and cameras (`punctual`), shadow nodes (`extension`), `instancing`, and what moves all
//! that (`animations`). `limits` bounds what a file may make us allocate.
//!
//! Besides the core, understood are `KHR_lights_punctual`, `KHR_materials_emissive_strength`, `_transmission`,
//! `_unlit`, `KHR_texture_transform`, `KHR_mesh_quantization`, `KHR_node_visibility`, `EXT_mesh_gpu_instancing`, the
//! flags of the proposed `KHR_lights_shadows` or of `extras`, and this project's [`SHADOW_NODE`].

mod accessors;
mod animations;
mod buffers;
mod container;
mod deformations;
mod document;
mod error;
mod extension;
mod fields;
mod hierarchy;
mod images;
mod instancing;
mod limits;
mod materials;
mod meshes;
mod nodes;
mod punctual;
mod save;
mod save_animations;
mod save_materials;
mod save_meshes;
mod transforms;
mod uri;

use std::path::Path;

pub use error::GltfError;
pub use extension::{SHADOW_NODE, ShadowTypes};
pub use save::{Glb, save, to_glb};

use crate::scene::{NodeKey, Scene};
use limits::{Budget, Warnings};

/// Which scene of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SceneChoice<'a> {
    /// The document's default scene, else the first.
    #[default]
    Default,
    /// By index.
    Index(usize),
    /// The first of this name.
    Name(&'a str),
}

/// What to load of a file, and how strictly.
#[derive(Clone, Copy, Default)]
pub struct LoadOptions<'a> {
    /// Which of the file's scenes.
    pub scene: SceneChoice<'a>,
    /// Checks types and parameters of shadow nodes; left out, they are taken as they are.
    pub shadow_types: Option<&'a dyn ShadowTypes>,
}

/// A loaded file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// What was left out, each thing once.
    pub warnings: Vec<String>,
    /// The scene's node for each glTF node; `None` for those outside the loaded scene.
    pub node_keys: Vec<Option<NodeKey>>,
    /// The names of all scenes of the file; empty ones for those without.
    pub scene_names: Vec<String>,
    /// Which of them was loaded; `None` for a file without scenes.
    pub scene_index: Option<usize>,
}

/// Loads the default scene of a `.gltf` or `.glb` file.
///
/// # Errors
/// [`GltfError`], one variant for each kind of fault.
pub fn load(path: impl AsRef<Path>) -> Result<Loaded, GltfError> {
    load_with(path, &LoadOptions::default())
}

/// Loads a `.gltf` or `.glb` file.
///
/// # Errors
/// [`GltfError`], one variant for each kind of fault.
pub fn load_with(path: impl AsRef<Path>, options: &LoadOptions<'_>) -> Result<Loaded, GltfError> {
    let path = path.as_ref();
    let mut budget = Budget::default();
    let bytes = uri::read_file(path, &mut budget)?;
    build(&bytes, Some(&uri::base_dir(path)), options, budget)
}

/// Loads the default scene of a `.gltf` or `.glb` file in memory. Without `base_dir`, buffers and images must be
/// within the file.
///
/// # Errors
/// [`GltfError`], one variant for each kind of fault.
pub fn load_slice(bytes: &[u8], base_dir: Option<&Path>) -> Result<Loaded, GltfError> {
    load_slice_with(bytes, base_dir, &LoadOptions::default())
}

/// Loads a `.gltf` or `.glb` file in memory.
///
/// # Errors
/// [`GltfError`], one variant for each kind of fault.
pub fn load_slice_with(
    bytes: &[u8],
    base_dir: Option<&Path>,
    options: &LoadOptions<'_>,
) -> Result<Loaded, GltfError> {
    build(bytes, base_dir, options, Budget::default())
}

fn build(
    bytes: &[u8],
    base_dir: Option<&Path>,
    options: &LoadOptions<'_>,
    mut budget: Budget,
) -> Result<Loaded, GltfError> {
    let mut warnings = Warnings::default();
    let parts = container::split(bytes)?;
    let document = document::Document::parse(parts.json, &mut warnings)?;
    let buffers = buffers::Buffers::load(&document.root, parts.bin, base_dir, &mut budget)?;
    let accessors = accessors::Accessors { root: &document.root, buffers: &buffers };
    let mut builder = nodes::Builder::new(&document, accessors, base_dir, budget, warnings);
    let node_keys = builder.build(options.scene, options.shadow_types)?;
    Ok(Loaded {
        node_keys,
        scene_names: document.scene_names(),
        scene_index: builder.scene_index,
        scene: builder.scene,
        warnings: builder.warnings.into_texts(),
    })
}
