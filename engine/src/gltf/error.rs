//! Everything that can be wrong with a glTF file: each error names the thing and what is accepted.

use thiserror::Error;

use crate::geometry::MeshError;

/// Why a glTF file was not loaded, or a scene not saved.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum GltfError {
    #[error("{path}: {source}")]
    Io { path: String, source: std::io::Error },
    #[error("{path}: not a regular file (only regular files are read)")]
    NotAFile { path: String },
    #[error(
        "damaged .glb: {problem} (a 12-byte header of version 2, a JSON chunk and at most one binary chunk are needed)"
    )]
    Glb { problem: String },
    #[error("{section} cannot be read as glTF JSON: {problem}")]
    Json { section: String, problem: String },
    #[error("glTF version '{found}' is not supported (2.0 is)")]
    Version { found: String },
    #[error("the required extension {name} is not supported: {fix}")]
    UnsupportedExtension { name: String, fix: String },
    #[error("{path} is not valid glTF: {problem}")]
    Invalid { path: String, problem: String },
    #[error("{item}: '{field}' {problem}")]
    Field { item: String, field: String, problem: String },
    #[error("{item}: '{field}' names {kind} {index}, but the file has {count} (counted from 0)")]
    IndexOutOfRange { item: String, field: String, kind: &'static str, index: u64, count: usize },
    #[error("{what}: {count} are more than the {limit} that are accepted")]
    TooLarge { what: String, count: u64, limit: u64 },
    #[error(
        "{what} would take {} MiB of memory, of which {} MiB may be taken (--memory, or LoadOptions::memory_budget, allows more)",
        bytes.div_ceil(1 << 20), limit >> 20
    )]
    Memory { what: String, bytes: u64, limit: u64 },
    #[error("{item}: URI '{uri}' {problem} (data URIs and paths relative to the glTF file are accepted)")]
    Uri { item: String, uri: String, problem: String },
    #[error(
        "buffer {buffer} has neither a URI nor a binary chunk (buffer 0 of a .glb takes the binary chunk; every other needs a URI)"
    )]
    MissingBin { buffer: usize },
    #[error("buffer {buffer} holds {found} bytes, but its byteLength says {declared}")]
    BufferLength { buffer: usize, declared: u64, found: u64 },
    #[error("buffer view {view} covers bytes {start}..{end} of buffer {buffer}, which has {available} bytes")]
    ViewRange { view: usize, start: u64, end: u128, buffer: usize, available: usize },
    #[error("accessor {accessor} needs {needed} bytes of buffer view {view}, which has {available}")]
    AccessorRange { accessor: usize, needed: u128, view: usize, available: usize },
    #[error("accessor {accessor} ({purpose}): {problem}")]
    Accessor { accessor: usize, purpose: &'static str, problem: String },
    #[error("mesh {mesh}, primitive {primitive}: {problem}")]
    Primitive { mesh: usize, primitive: usize, problem: String },
    #[error(
        "mesh {mesh}, primitive {primitive}: index {index} at place {place} is out of range ({vertices} vertices)"
    )]
    VertexIndex { mesh: usize, primitive: usize, place: usize, index: u32, vertices: usize },
    #[error("{source}")]
    Mesh { mesh: usize, source: MeshError },
    #[error("buffer view {view} (compressed): {problem}")]
    Compressed { view: usize, problem: String },
    #[error(
        "{item}: '{path}' lies outside the scene's folder (files in or below it are accepted; all are with --outside-files, or LoadOptions::outside_files)"
    )]
    OutsideFile { item: String, path: String },
    #[error("{image}: {problem} (PNG and JPEG are accepted, and WebP)")]
    Image { image: String, problem: String },
    #[error("node {node} is a child of node {first} and of node {second} (at most one parent is accepted)")]
    NodeParents { node: usize, first: usize, second: usize },
    #[error("node {node} lies under itself (the nodes must form trees)")]
    NodeCycle { node: usize },
    #[error("scene {scene} lists node {node}, which {problem} (each node is accepted once)")]
    NotARoot { scene: usize, node: usize, problem: String },
    #[error("{node}: its transform {problem}")]
    Transform { node: String, problem: String },
    #[error("{item}: {problem}")]
    Content { item: String, problem: String },
    #[error("scene {scene} does not exist; the file has {count} (counted from 0)")]
    NoSuchScene { scene: usize, count: usize },
    #[error("no scene is called '{name}'; the file has {known}")]
    NoSuchSceneName { name: String, known: String },
    #[error("shadow node at {node}: {problem}")]
    ShadowNode { node: String, problem: String },
    #[error("shadow node at {node}: '{list}' names node {target}, {problem}")]
    ShadowTarget { node: String, list: &'static str, target: u64, problem: String },
    #[error("shadow node at {node}: {problem}")]
    ShadowType { node: String, problem: String },
    #[error("the scene cannot be saved as glTF: {what} {problem}")]
    Save { what: String, problem: String },
}
