//! The options of `ShadowVolumeHard`: where each is exact, and where it is not.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "rows of measurements are what a reader of the log is after")]

#[path = "../common/mod.rs"]
mod common;

mod closure;
mod extrusion;
mod float;
mod single;
mod single_sided;
mod stage;
mod terminator;
