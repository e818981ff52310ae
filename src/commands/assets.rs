//! `shadowgraph assets`: the demo scenes as files.

use std::path::PathBuf;

use clap::Args;
use shadowgraph::demo;
use shadowgraph::engine::gltf;

use super::output::{note, out};
use super::{Failure, files};

/// The arguments of `assets`.
#[derive(Debug, Args)]
pub(crate) struct AssetsArgs {
    /// Where the .glb files go.
    folder: PathBuf,
}

pub(crate) fn run(args: &AssetsArgs) -> Result<(), Failure> {
    files::make_folder(&args.folder)?;
    for (name, shows, scene) in demo::all().into_iter().chain(demo::mixed()) {
        let path = args.folder.join(format!("{name}.glb"));
        for warning in gltf::save(&scene, &path)? {
            note!("{}: {warning}", path.display());
        }
        out!("{}: {shows}", path.display());
    }
    Ok(())
}
