//! Writing files whole or not at all, and those of one command together.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};

use shadowgraph::engine::gpu::Pixels;

use super::{Failure, other};

/// The files a command writes. Each is written beside its place first; they are moved there when all are complete.
/// Dropped before that, nothing is left behind.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    /// Files that must not be written over.
    inputs: Vec<Identity>,
    /// The places spoken for.
    reserved: Vec<PathBuf>,
    staged: Vec<Staged>,
    /// Folders that were not there before, outermost first.
    made_folders: Vec<PathBuf>,
    count: usize,
}

#[derive(Debug)]
struct Staged {
    path: PathBuf,
    temporary: PathBuf,
}

impl Outputs {
    /// Outputs that may not replace any of `inputs`.
    pub(crate) fn beside(inputs: &[PathBuf]) -> Self {
        let mut outputs = Self::default();
        inputs.iter().for_each(|input| outputs.protect(input));
        outputs
    }

    /// Neither may they replace this.
    pub(crate) fn protect(&mut self, input: &Path) {
        // What cannot be found is not read either.
        self.inputs.extend(Identity::of(input));
    }

    /// Refuses what is read, by whatever path it is named.
    fn check_unread(&self, place: &Path, named: &Path) -> Result<(), Failure> {
        match Identity::of(place) {
            Some(identity) if self.inputs.contains(&identity) => {
                let shown = named.display();
                Err(Failure::Usage(format!("'{shown}' is read; it cannot be written as well")))
            }
            _ => Ok(()),
        }
    }

    /// Checks that `path` can be written, before any time is spent on what goes there.
    pub(crate) fn reserve(&mut self, path: &Path) -> Result<(), Failure> {
        let shown = path.display();
        let name = path.file_name().ok_or_else(|| Failure::Usage(format!("'{shown}' is no file name")))?;
        if path.is_dir() {
            return Err(Failure::Other(format!("cannot write '{shown}': it is a folder")));
        }
        let folder = folder_of(path);
        let inside = folder
            .canonicalize()
            .map_err(|error| Failure::Other(format!("cannot write '{shown}': its folder: {error}")))?;
        let place = inside.join(name);
        self.check_unread(&place, path)?;
        let identity = Identity::of(&place);
        let same = |other: &PathBuf| *other == place || identity.is_some() && Identity::of(other) == identity;
        if self.reserved.iter().any(same) {
            return Err(Failure::Usage(format!("'{shown}' is named for two outputs")));
        }
        let temporary = self.temporary(path);
        let tried = OpenOptions::new().write(true).create_new(true).open(&temporary);
        tried.and_then(|_| fs::remove_file(&temporary)).map_err(|error| cannot_write(path, &error))?;
        self.reserved.push(place);
        Ok(())
    }

    /// Makes a folder and those above it, to be removed again should the outputs not come to be.
    pub(crate) fn make_folder(&mut self, path: &Path) -> Result<(), Failure> {
        let missing = path.ancestors().filter(|p| !p.as_os_str().is_empty()).take_while(|p| !p.exists());
        let mut missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
        missing.reverse();
        self.made_folders.extend(missing);
        make_folder(path)
    }

    /// Writes a reserved file's contents beside its place, with `write`.
    pub(crate) fn stage(
        &mut self,
        path: &Path,
        write: impl FnOnce(&Path) -> io::Result<()>,
    ) -> Result<(), Failure> {
        // Some inputs are known only after places were reserved.
        self.check_unread(path, path)?;
        let temporary = self.temporary(path);
        self.staged.push(Staged { path: path.into(), temporary: temporary.clone() });
        write(&temporary).map_err(|error| cannot_write(path, &error))
    }

    /// [`Outputs::stage`] of bytes.
    pub(crate) fn stage_bytes(&mut self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        self.stage(path, |temporary| File::create_new(temporary)?.write_all(bytes))
    }

    /// Moves everything to its place.
    pub(crate) fn commit(mut self) -> Result<(), Failure> {
        for Staged { path, temporary } in &self.staged {
            let moved = if is_device(path) {
                File::open(temporary)
                    .and_then(|mut from| io::copy(&mut from, &mut OpenOptions::new().write(true).open(path)?))
                    .and_then(|_| fs::remove_file(temporary))
            } else {
                fs::rename(temporary, path)
            };
            moved.map_err(|error| cannot_write(path, &error))?;
        }
        self.staged.clear();
        self.made_folders.clear();
        Ok(())
    }

    /// A name beside `path` that nobody else uses, short however long the path's own is. Nothing is made beside
    /// devices and pipes: those are written to, not replaced.
    fn temporary(&mut self, path: &Path) -> PathBuf {
        self.count += 1;
        let name = format!(".shadowgraph-{}-{}.tmp", std::process::id(), self.count);
        if is_device(path) { std::env::temp_dir().join(name) } else { folder_of(path).join(name) }
    }
}

impl Drop for Outputs {
    fn drop(&mut self) {
        // The error worth telling is the one that led here; what cannot be removed stays.
        for staged in &self.staged {
            let _ = fs::remove_file(&staged.temporary);
        }
        for folder in self.made_folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// Which file a path leads to, whether by links, by `..`, in other letters or under another name.
#[derive(Debug, PartialEq, Eq)]
struct Identity {
    /// Device and number: the same for all names of one file.
    #[cfg(unix)]
    inode: (u64, u64),
    #[cfg(not(unix))]
    path: PathBuf,
}

impl Identity {
    /// `None` where nothing is.
    #[cfg(unix)]
    fn of(path: &Path) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        let metadata = fs::metadata(path).ok()?;
        Some(Self { inode: (metadata.dev(), metadata.ino()) })
    }

    #[cfg(not(unix))]
    fn of(path: &Path) -> Option<Self> {
        // It has the letters that the file system knows the file by.
        path.canonicalize().ok().map(|path| Self { path })
    }
}

fn cannot_write(path: &Path, error: &io::Error) -> Failure {
    Failure::Other(format!("cannot write '{}': {error}", path.display()))
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn is_device(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Makes a folder and those above it.
pub(crate) fn make_folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path)
        .map_err(|error| Failure::Other(format!("cannot make folder '{}': {error}", path.display())))
}

/// An 8-bit RGBA picture as PNG.
pub(crate) fn png(pixels: &Pixels) -> Result<Vec<u8>, Failure> {
    let [width, height] = pixels.size_px;
    let mut png = Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut png,
        &pixels.bytes,
        width,
        height,
        image::ExtendedColorType::Rgba8,
        image::ImageFormat::Png,
    )
    .map_err(other)?;
    Ok(png.into_inner())
}

/// Writes one picture as PNG.
pub(crate) fn write_png(path: &Path, pixels: &Pixels) -> Result<(), Failure> {
    let mut outputs = Outputs::default();
    outputs.reserve(path)?;
    outputs.stage_bytes(path, &png(pixels)?)?;
    outputs.commit()
}
