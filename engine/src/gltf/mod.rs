//! Scenes in glTF 2.0: loading `.gltf` and `.glb`, and saving `.glb`.
//!
//! Loading takes nothing on trust: whatever the bytes, it ends with a scene or one [`GltfError`] that names the
//! offending thing, without a panic and within bounded memory. The steps, one file each: the container is split
//! (`container`), the JSON parsed (`document`), and the nodes of one scene built (`nodes`) from `meshes` (through
//! `accessors`; influences and morph targets in `deformations`), `materials`, `images`, lights and cameras
//! (`punctual`), shadow nodes (`extension`), `instancing`, and what moves all that (`animations`). Whatever these need
//! is fetched when they do (`buffers`, `uri`, `meshopt`), its fields checked first (`check`, by the tables of
//! `shapes`). What nothing needs is checked at the end, and only noted. `limits` bounds what a file may make us
//! allocate.
//!
//! Besides the core, understood are `KHR_lights_punctual`, `KHR_materials_emissive_strength`, `_transmission`,
//! `_unlit`, `KHR_texture_transform`, `KHR_mesh_quantization`, `KHR_node_visibility`, `EXT_mesh_gpu_instancing`,
//! `EXT_meshopt_compression`, `EXT_texture_webp`, the flags of the proposed `KHR_lights_shadows` or of `extras`, and
//! this project's [`SHADOW_NODE`].

mod accessors;
mod animations;
mod buffers;
mod check;
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
mod meshopt;
mod names;
mod nodes;
mod punctual;
mod save;
mod save_animations;
mod save_materials;
mod save_meshes;
mod shapes;
mod together;
mod transforms;
mod uri;
mod usage;

use std::path::{Path, PathBuf};

pub use error::GltfError;
pub use extension::{SHADOW_NODE, ShadowTypes};
pub use names::{few_digits, shown as shown_name};
pub use save::{Glb, save, to_glb};

use crate::scene::{NodeKey, Scene};
use limits::{Budget, Warnings};
use uri::Files;

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
    /// Whether buffers and images may lie outside the scene's folder: a file from elsewhere may name any of yours.
    pub outside_files: bool,
    /// The most bytes that meshes and images may take in memory, images at most half of it; 2 GiB when left out.
    /// Sizes are computed from headers and counts, before anything is decoded.
    pub memory_budget: Option<u64>,
}

/// A loaded file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene.
    pub scene: Scene,
    /// What was left out, each thing once.
    pub warnings: Vec<String>,
    /// What is not valid glTF, but does no harm, each thing once.
    pub remarks: Vec<String>,
    /// The scene's node for each glTF node; `None` for those outside the loaded scene.
    pub node_keys: Vec<Option<NodeKey>>,
    /// The names of all scenes of the file; empty ones for those without.
    pub scene_names: Vec<String>,
    /// Which of them was loaded; `None` for a file without scenes.
    pub scene_index: Option<usize>,
    /// Every file that was read: the scene's own, its buffers and its images.
    pub files: Vec<PathBuf>,
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
    let mut budget = Budget::new(options.memory_budget);
    let bytes = uri::read_file(path, &mut budget)?;
    let files = Files::new(Some(uri::base_dir(path)), options.outside_files);
    files.note_read(path.to_path_buf());
    build(&bytes, files, options, budget)
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
    let files = Files::new(base_dir.map(Path::to_path_buf), options.outside_files);
    build(bytes, files, options, Budget::new(options.memory_budget))
}

fn build(bytes: &[u8], files: Files, options: &LoadOptions<'_>, budget: Budget) -> Result<Loaded, GltfError> {
    let parts = container::split(bytes)?;
    let document = document::Document::parse(parts.json)?;
    parts.remarks.iter().for_each(|remark| document.note(remark.clone()));
    let buffers = buffers::Buffers::new(&document, parts.bin, &files);
    let accessors = accessors::Accessors { document: &document, buffers };
    let mut builder = nodes::Builder::new(&document, accessors, &files, budget, Warnings::default());
    let node_keys = builder.build(options.scene, options.shadow_types)?;
    let nodes::Builder { scene, scene_index, mut warnings, .. } = builder;
    let remarks = document.finish(&mut warnings).into_texts();
    Ok(Loaded {
        node_keys,
        scene_names: document.scene_names(),
        scene_index,
        scene,
        warnings: warnings.into_texts(),
        remarks,
        files: files.into_read(),
    })
}
