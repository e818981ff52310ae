//! The commands, one file each, and what they share.

mod args;
mod assets;
mod demo;
mod files;
mod fuzz;
mod inspect;
mod output;
mod papers;
mod render;
mod report;
mod scenes;
mod tree;
mod view;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{Parser, Subcommand};
use shadowgraph::engine::gltf::GltfError;
use shadowgraph::engine::render::FrameError;
use shadowgraph::measure::EvaluateError;
use shadowgraph::prelude::*;
use thiserror::Error;

use output::{note, one_line, out};

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
    /// Says what a scene is: what casts and receives, which technique serves which light, and what is wrong.
    Inspect(Box<inspect::InspectArgs>),
    /// Measures every technique on a list of scenes: speed against error as pages, plots and tables.
    ///
    /// A technique that refuses a scene is shown as refused. What fails is listed in the report and does not stop the
    /// rest; the exit code is then 1. With --papers the tables and figures of the implemented papers are made again instead, ours
    /// beside theirs.
    Report(Box<report::ReportArgs>),
    /// Renders the demo scenes and prints their speed and error.
    Demo(demo::DemoArgs),
    /// Writes the demo scenes as .glb files with shadow nodes.
    Assets(assets::AssetsArgs),
    /// Searches random scenes for shadows that are wrong, and writes those it finds as small as they fail.
    ///
    /// Prints what kinds of scene were held against the reference, how many are wrong and how many were refused, by which
    /// error. The exit code is 1 when a scene is wrong.
    Fuzz(fuzz::FuzzArgs),
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

impl Failure {
    /// 2 for what can be mended on the command line, 1 for everything else.
    fn exit_code(&self) -> u8 {
        match self {
            Self::Usage(_)
            | Self::Render(RenderError::Frame(
                FrameError::Size { .. } | FrameError::AntialiasedSize { .. },
            )) => 2,
            _ => 1,
        }
    }
}

/// Parses the arguments and runs the command.
pub(crate) fn run() -> ExitCode {
    let result = match Cli::try_parse() {
        Ok(cli) if cli.list_adapters => list_adapters(),
        Ok(cli) => match &cli.command {
            Some(Command::Render(args)) => render::run(args),
            Some(Command::Inspect(args)) => inspect::run(args),
            Some(Command::Report(args)) => report::run(args),
            Some(Command::Demo(args)) => demo::run(args),
            Some(Command::Assets(args)) => assets::run(args),
            Some(Command::Fuzz(args)) => fuzz::run(args),
            None => Err(Failure::Usage(
                "a command is needed: render, inspect, report, demo, assets or fuzz (see --help)".into(),
            )),
        },
        Err(asked) if matches!(asked.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            // A reader of help that stops reading has read enough.
            let _ = asked.print();
            Ok(())
        }
        // The list needs neither a scene nor anything else that a command may ask for.
        Err(error)
            if error.kind() == ErrorKind::MissingRequiredArgument
                && std::env::args_os().any(|argument| argument == "--list-adapters") =>
        {
            list_adapters()
        }
        Err(error) => Err(Failure::Usage(short(&error.to_string()))),
    };
    match result.and_then(|()| output::finish()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            note!("error: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

fn list_adapters() -> Result<(), Failure> {
    let adapters = Gpu::list();
    adapters.iter().for_each(|adapter| out!("{adapter}"));
    if adapters.is_empty() {
        // Opening fails as well, and says what to install.
        Gpu::open(&AdapterChoice::Auto).map_err(RenderError::from)?;
    }
    Ok(())
}

/// What clap says in its first paragraph and its hint, as one line: the usage that follows is what `--help` is for.
fn short(message: &str) -> String {
    let mut paragraphs = message.split("\n\n").map(str::trim);
    let problem = one_line(paragraphs.next().unwrap_or_default());
    let problem = problem.strip_prefix("error: ").unwrap_or(&problem);
    let similar = paragraphs.find_map(|tip| tip.strip_prefix("tip: ").filter(|tip| tip.contains("similar")));
    let similar = similar.map_or(String::new(), |tip| format!("; {}", one_line(tip)));
    format!("{problem}{similar} (see --help)")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usage_errors_are_one_line() {
        let said = |arguments: &[&str]| short(&Cli::try_parse_from(arguments).unwrap_err().to_string());
        let missing = said(&["shadowgraph", "render"]);
        assert!(missing.contains("--output") && missing.contains("<SCENE>"), "{missing}");
        let unknown = said(&["shadowgraph", "render", "x", "-o", "y", "--sise", "3x3"]);
        assert!(unknown.contains("'--sise'") && unknown.contains("'--size'"), "{unknown}");
        for line in [missing, unknown] {
            assert!(
                !line.contains('\n') && !line.starts_with("error") && line.ends_with("(see --help)"),
                "{line}"
            );
        }
    }
}
