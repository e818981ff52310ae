//! What the test binaries share: small scenes and questions about their plans, techniques made of a
//! closure, one renderer, and a shader's twin on the CPU.
//!
//! It is a crate, so that each binary takes what it needs and nothing is dead code in the others.

#![allow(missing_docs, reason = "tests read the fields of what they made")]
#![allow(clippy::unwrap_used, clippy::missing_panics_doc, reason = "a test fails by panicking")]

pub mod docs;
mod gpu;
mod plans;
mod skipped;
mod technique;
pub mod twin;

pub use gpu::{measure, mesh, renderer, renderer_with};
pub use plans::*;
pub use skipped::{model, skip};
pub use technique::*;
