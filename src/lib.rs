//! placeholder

pub mod cases;
