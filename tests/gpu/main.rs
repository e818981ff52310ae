//! What is drawn: every technique on every hard case, pictures and factors, robustness.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "rows of measurements are what a reader of the log is after")]

#[path = "../../examples/ball_shadow/mod.rs"]
mod ball_shadow;
#[path = "../../examples/own_surface/mod.rs"]
mod own_surface;
#[path = "../../examples/own_technique/mod.rs"]
mod own_technique;

mod animation;
mod antialias;
mod ball_technique;
mod broken;
mod confined;
mod conformance;
mod darkened;
mod equivalence;
mod first_picture;
mod hard_options;
mod kept_textures;
mod known;
mod known_docs;
mod lamp_near;
mod layers;
mod many_lights;
mod maps;
mod materials;
mod mixed;
mod models;
mod outside_technique;
mod plan_execution;
mod planar;
mod planar_glass;
mod robustness;
mod sabotage;
mod sabotage_glass;
mod sabotage_planar;
mod sabotage_soft;
mod search;
mod shading;
mod shared_light;
mod silhouettes;
mod slips;
mod soft_areas;
mod soft_inputs;
mod soft_motion;
mod soft_shadows;
mod stability;
mod surface_functions;
mod technique_inputs;
mod textured;
mod tints;
mod tolerances;
mod tolerances_found;
mod tolerances_maps;
mod transparent;
mod trials;
mod wide_floor;
