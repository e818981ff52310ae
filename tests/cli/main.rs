//! The command line and the report, as a user meets them.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "rows of measurements are what a reader of the log is after")]

#[path = "../../examples/own_technique/mod.rs"]
mod own_technique;

mod animation;
mod antialias;
mod bad_input;
mod bad_scenes;
mod command_line;
mod files;
mod papers;
mod program;
mod report;
mod surroundings;
