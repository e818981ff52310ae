//! Running the command line as its users do, in folders of its own.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};

use serde_json::Value;
use shadowgraph_engine::gltf;
use shadowgraph_engine::scene::Scene;

/// The yard as JSON and the bytes of its buffer.
pub(crate) fn yard_parts() -> (Value, Vec<u8>) {
    let glb = gltf::to_glb(&shadowgraph_testing::shadowed_yard(&[])).expect("it can be saved").bytes;
    let word = |at: usize| u32::from_le_bytes(glb[at..at + 4].try_into().expect("four bytes")) as usize;
    let json_end = 20 + word(12);
    let json = serde_json::from_slice(&glb[20..json_end]).expect("it is JSON");
    (json, glb[json_end + 8..json_end + 8 + word(json_end)].to_vec())
}

/// A folder of one test, removed at its end.
pub(crate) struct Folder(PathBuf);

impl Folder {
    pub(crate) fn new() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let name =
            format!("shadowgraph-cli-{}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("temporary folders can be made");
        Self(path.canonicalize().expect("it is there"))
    }

    pub(crate) fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.join(name)
    }

    pub(crate) fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).expect("it can be written");
    }

    pub(crate) fn save(&self, name: &str, scene: &Scene) {
        gltf::save(scene, self.path(name)).expect("the scene can be saved");
    }

    /// Every file and folder in it, hidden ones too, with the contents of files.
    pub(crate) fn contents(&self) -> Vec<(PathBuf, Vec<u8>)> {
        let mut found = Vec::new();
        let mut folders = vec![self.0.clone()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).expect("it is a folder") {
                let path = entry.expect("it can be listed").path();
                found.push((path.clone(), fs::read(&path).unwrap_or_default()));
                if path.is_dir() {
                    folders.push(path);
                }
            }
        }
        found.sort();
        found
    }

    /// The names of the files in a folder of it.
    pub(crate) fn names(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).expect("it is a folder");
        let mut names: Vec<String> = entries
            .map(|entry| entry.expect("it can be listed").file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    /// Runs `shadowgraph` here, with arguments that are separated by blanks.
    pub(crate) fn run(&self, arguments: &str) -> Ran {
        self.run_with(arguments.split_whitespace(), &[])
    }

    /// Runs `shadowgraph` here.
    pub(crate) fn run_with<A: AsRef<OsStr>>(
        &self,
        arguments: impl IntoIterator<Item = A>,
        environment: &[(&str, &str)],
    ) -> Ran {
        let output = self.command(arguments, environment).output().expect("the binary can be run");
        Ran {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).expect("stdout is UTF-8"),
            stderr: String::from_utf8(output.stderr).expect("stderr is UTF-8"),
        }
    }

    pub(crate) fn command<A: AsRef<OsStr>>(
        &self,
        arguments: impl IntoIterator<Item = A>,
        environment: &[(&str, &str)],
    ) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_shadowgraph"));
        command
            .args(arguments)
            .envs(environment.iter().copied())
            .current_dir(&self.0)
            // Without it some drivers complain on stderr in words of their own.
            .env("XDG_RUNTIME_DIR", &self.0)
            .stdin(Stdio::null());
        command
    }

    /// Runs a command that must fail with `code` and leave everything as it was; returns its error line.
    #[track_caller]
    pub(crate) fn refuses(&self, code: i32, arguments: &str) -> String {
        let before = self.contents();
        let error = self.run(arguments).error(code);
        assert!(before == self.contents(), "{arguments}: something was left behind: {:?}", self.names("."));
        error
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // A folder that stays is a nuisance, not a failure.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// What a run of the command line came to.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ran {
    #[track_caller]
    pub(crate) fn ok(self) -> Self {
        assert_eq!(self.code, Some(0), "{}", self.stderr);
        assert!(!self.stderr.contains("error:"), "{}", self.stderr);
        self
    }

    /// The one line that says what is wrong.
    #[track_caller]
    pub(crate) fn error(self, code: i32) -> String {
        let Self { stderr, .. } = &self;
        assert_eq!(self.code, Some(code), "{stderr}");
        assert!(!stderr.contains("panicked"), "{stderr}");
        let errors = stderr.lines().filter(|line| line.starts_with("error:")).count();
        assert_eq!(errors, 1, "{stderr}");
        let last = stderr.lines().last().unwrap_or_default();
        let said =
            last.strip_prefix("error: ").unwrap_or_else(|| panic!("the last line is no error: {stderr}"));
        assert!(said.len() > 10, "{said}");
        said.to_owned()
    }

    /// The lines on stderr that begin with "note:".
    pub(crate) fn notes(&self) -> Vec<&str> {
        self.stderr.lines().filter_map(|line| line.strip_prefix("note: ")).collect()
    }
}

/// Asserts that `text` contains each of `words`.
#[track_caller]
pub(crate) fn names_all(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "'{word}' is missing: {text}");
    }
}
