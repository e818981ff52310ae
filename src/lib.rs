//! placeholder

pub mod cases;
pub mod demo;
