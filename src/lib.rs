//! placeholder
pub mod measure;
