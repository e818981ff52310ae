//! What frames are planned to be, and what is written down of options, shaders and assets; no device.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "rows of measurements are what a reader of the log is after")]

mod assets;
mod caching;
mod claims;
mod errors;
mod frugality;
mod hard_options;
mod layouts;
mod lights;
mod maps;
mod option_docs;
mod options_act;
mod planar;
mod regressions;
mod shaders;
mod silhouettes;
mod soft;
mod text;
mod validation;
