//! What integration tests share.

#![allow(dead_code, unused_imports, reason = "each test crate uses its own part of this")]

mod gpu;
mod plans;

pub(crate) use gpu::renderer;
pub(crate) use plans::*;
