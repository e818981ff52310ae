//! The commands, one file each, and what they share.

mod args;
mod assets;
mod demo;
mod files;
mod inspect;
mod render;
mod scenes;
mod timing;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use shadowgraph::engine::gltf::GltfError;
use shadowgraph::measure::EvaluateError;
use shadowgraph::prelude::*;
use thiserror::Error;

/// Shadows as nodes that tell how fast and how wrong they are.
#[derive(Debug, Parser)]
#[command(name = "shadowgraph", version, about)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// Lists the graphics adapters, best first, and ends.
    #[arg(long, global = true)]
    list_adapters: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Renders a scene, times it, and compares its shadows with the exact reference.
    Render(Box<render::RenderArgs>),
    /// Prints a scene's nodes, its casters' closedness and the frame plan with its reasons.
    Inspect(Box<inspect::InspectArgs>),
    /// Renders the demo scenes and prints their speed and error.
    Demo(demo::DemoArgs),
    /// Writes the demo scenes as .glb files with shadow nodes.
    Assets(assets::AssetsArgs),
}

/// Why a command failed.
#[derive(Debug, Error)]
pub(crate) enum Failure {
    #[error("{0}")]
    Usage(String),
    #[error(transparent)]
    Gltf(#[from] GltfError),
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
    #[error("{0}")]
    Other(String),
}

/// Failures from elsewhere that need no kind of their own.
pub(crate) fn other(error: impl std::fmt::Display) -> Failure {
    Failure::Other(error.to_string())
}

/// Parses the arguments and runs the command.
pub(crate) fn run() -> ExitCode {
    let cli = Cli::parse();
    if cli.list_adapters {
        let adapters = Gpu::list();
        adapters.iter().for_each(|adapter| println!("{adapter}"));
        if adapters.is_empty() {
            eprintln!("no graphics adapter");
        }
        return ExitCode::from(u8::from(adapters.is_empty()));
    }
    let result = match &cli.command {
        Some(Command::Render(args)) => render::run(args),
        Some(Command::Inspect(args)) => inspect::run(args),
        Some(Command::Demo(args)) => demo::run(args),
        Some(Command::Assets(args)) => assets::run(args),
        None => {
            Err(Failure::Usage("a command is needed: render, inspect, demo or assets (see --help)".into()))
        }
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // One line, whatever the message was made of.
            eprintln!("error: {}", failure.to_string().split_whitespace().collect::<Vec<_>>().join(" "));
            ExitCode::from(if matches!(failure, Failure::Usage(_)) { 2 } else { 1 })
        }
    }
}
