//! The measures of Shadowgraph: an exact reference for hard shadows and for lights with a size, and what a technique's picture
//! is worth beside it.
//!
//! [`Reference`] shoots its own rays at the scene's snapshot in f64 and says for every pixel which triangle is seen and
//! whether each light reaches it. [`compare()`] puts a technique's factors beside it and counts what is wrong,
//! [`expect_shadow`] refuses a comparison in which there was nothing to get wrong, and [`pictures`] writes both down.
//! [`cases`] are the scenes on which techniques have always broken, [`report`] what all of it comes to.
//!
//! This crate sees the engine and nothing else: what judges the techniques cannot know them.

pub mod cases;
mod compare;
mod reference;
pub mod report;

pub use compare::*;
pub use reference::*;
pub use shadowgraph_engine::shadow::{LightSize, disc_samples, light_samples};
