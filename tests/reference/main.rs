//! The reference and the hard cases, held against what was worked out by hand or by simpler means; no device.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "rows of measurements are what a reader of the log is after")]

mod area;
mod cases;
mod disc_coverage;
mod exact;
mod glass;
mod metrics;
mod soup;
