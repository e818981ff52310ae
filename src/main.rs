//! The command line of Shadowgraph.
//!
//! Exit codes: 0 success, 2 bad usage, 1 anything else; always with one clear line on stderr, and never with a
//! half-written file.

mod commands;

use std::process::ExitCode;

fn main() -> ExitCode {
    commands::run()
}
