//! What a machine cannot test is said, and counted by `./x test`; it never passes silently.

use std::io::Write;
use std::path::{Path, PathBuf};

/// Says that a part of the tests is passed over, and why. `SKIPPED_FILE` names the file in which `./x test` counts it.
pub fn skip(why: &str) {
    eprintln!("skipped: {why}");
    let Some(path) = std::env::var_os("SKIPPED_FILE") else { return };
    let test = std::thread::current().name().unwrap_or("a test").to_owned();
    let file = std::fs::OpenOptions::new().append(true).create(true).open(path);
    let written = file.and_then(|mut file| writeln!(file, "{test}: {why}"));
    written.unwrap_or_else(|error| panic!("the skipped test cannot be written down: {error}"));
}

/// A file or folder (`""`: all of them) of the models that are no part of the project: shared/models, beside the project or
/// beside its parent. Where it is missing, the test is skipped.
pub fn model(name: &str) -> Option<PathBuf> {
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let places = ["../shared/models", "../../shared/models"].map(|place| project.join(place).join(name));
    let found = places.into_iter().find(|place| place.exists());
    if found.is_none() {
        skip(&format!("../shared/models/{name} is missing"));
    }
    found
}
