//! What integration tests share.

#![allow(dead_code, unused_imports, reason = "each test crate uses its own part of this")]

pub(crate) mod conformance;
mod gpu;
pub(crate) mod known;
mod plans;
pub(crate) mod tolerances;
pub(crate) mod tolerances_found;

pub(crate) use gpu::{measure, mesh, renderer};
pub(crate) use plans::*;
