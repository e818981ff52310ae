//! Geometry, scenes and glTF; no device.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "what kinds of files were held is what a reader of the log is after")]

mod deform;
mod geometry;
mod gltf_animation;
mod gltf_errors;
mod gltf_kinds;
mod gltf_kinds_whole;
mod gltf_loads;
mod gltf_models;
mod gltf_moving_files;
mod gltf_mutations;
mod gltf_roundtrip;
mod kinds;
mod scene;
mod surface_functions;
