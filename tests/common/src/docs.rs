//! Documents that are partly generated: what they should hold, compared with what they do.

use std::path::{Path, PathBuf};

/// A file of the repository, by its path from the root.
pub fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(name)
}

/// The text of a file of the repository.
pub fn text(name: &str) -> String {
    std::fs::read_to_string(file(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Compares a file with what it should be; with `WRITE_DOCS=1` writes it anew, and fails all the same that once.
pub fn holds(name: &str, wanted: &str) {
    let found = text(name);
    if found == wanted {
        return;
    }
    if std::env::var_os("WRITE_DOCS").is_some() {
        std::fs::write(file(name), wanted).unwrap();
        panic!("{name} was written anew: run again");
    }
    let differs = found.lines().zip(wanted.lines()).position(|(found, wanted)| found != wanted);
    panic!(
        "{name} differs from what the code declares, first in line {:?} (WRITE_DOCS=1 writes it)",
        differs.map(|line| line + 1)
    );
}

/// `document` with this between `<!-- name -->` and `<!-- end -->`.
#[must_use]
pub fn with_block(mut document: String, name: &str, block: &str) -> String {
    let begin = format!("<!-- {name} -->\n");
    let start = document.find(&begin).unwrap_or_else(|| panic!("no '{}' there", begin.trim())) + begin.len();
    let end = start + document[start..].find("<!-- end -->").expect("an end");
    document.replace_range(start..end, block);
    document
}
