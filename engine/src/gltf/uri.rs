//! Where the bytes of buffers and images come from: data URIs and files next to the glTF file.

use std::borrow::Cow;
use std::cell::RefCell;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use super::GltfError;
use super::limits::Budget;
use super::names::shown;

/// The files a scene may name, and those it did.
#[derive(Debug, Default)]
pub(super) struct Files {
    /// The folder that relative paths start from; without it no file may be named.
    base_dir: Option<PathBuf>,
    /// Whether files outside that folder may be read.
    outside: bool,
    read: RefCell<Vec<PathBuf>>,
}

impl Files {
    pub(super) fn new(base_dir: Option<PathBuf>, outside: bool) -> Self {
        Self { base_dir, outside, read: RefCell::default() }
    }

    /// Adds a file to those that were read.
    pub(super) fn note_read(&self, path: PathBuf) {
        self.read.borrow_mut().push(path);
    }

    /// Every file that was read.
    pub(super) fn into_read(self) -> Vec<PathBuf> {
        self.read.into_inner()
    }

    /// Whether a file lies in the scene's folder or below it, wherever links lead.
    fn is_inside(&self, path: &Path) -> std::io::Result<bool> {
        let folder = self.base_dir.as_deref().filter(|folder| !folder.as_os_str().is_empty());
        Ok(path.canonicalize()?.starts_with(folder.unwrap_or(Path::new(".")).canonicalize()?))
    }
}

/// Whether a URI holds its data itself.
fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// What should not be in a URI, though it may be read all the same, or never is.
pub(super) fn problem(uri: &str, is_image: bool) -> Option<String> {
    if is_data(uri) {
        let Some((header, data)) = uri[5..].split_once(',') else {
            return Some("its data URI has no comma before its data".into());
        };
        let header = header.to_ascii_lowercase();
        // Only its characters are checked here: what is used is decoded elsewhere, and may be large.
        let letter = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'+' | b'/' | b'=' | b'%');
        if header.ends_with(";base64") && !data.bytes().all(letter) {
            return Some("its data URI is not valid base64".into());
        }
        let accepted: &[&str] = match is_image {
            true => &["image/png", "image/jpeg", "image/webp"],
            false => &["application/octet-stream", "application/gltf-buffer"],
        };
        let mime = header.split(';').next().unwrap_or_default();
        let problem =
            || format!("its data URI's type is '{}'; {} are usual", shown(mime), accepted.join(", "));
        return (!accepted.contains(&mime)).then(problem);
    }
    relative_path(uri).err().map(|problem| format!("its URI '{}' {problem}", shown(uri)))
}

/// The path that a URI names.
fn relative_path(uri: &str) -> Result<String, &'static str> {
    let first_segment = uri.split(['/', '?', '#']).next().unwrap_or_default();
    if first_segment.contains(':') || uri.starts_with(['/', '\\']) {
        return Err("is absolute");
    }
    let path = decode_percent(uri).and_then(|bytes| String::from_utf8(bytes).ok());
    let path = path.ok_or("is no percent-encoded UTF-8")?;
    let absolute = |part| matches!(part, Component::Prefix(_) | Component::RootDir);
    if path.is_empty() || path.contains('\0') || Path::new(&path).components().any(absolute) {
        return Err("is no relative path");
    }
    Ok(path)
}

/// The bytes behind `uri`, which `item` ("buffer 2") asks for.
pub(super) fn read(item: &str, uri: &str, files: &Files, budget: &mut Budget) -> Result<Vec<u8>, GltfError> {
    let wrong = |problem: &str| GltfError::Uri {
        item: item.into(),
        uri: shown(uri).into_owned(),
        problem: problem.into(),
    };
    if is_data(uri) {
        let (header, data) = uri[5..].split_once(',').ok_or_else(|| wrong("has no comma before its data"))?;
        budget.charge_bytes(data.len() as u64)?;
        // Base64 may have its '+', '/' and '=' escaped as well.
        let bytes: Cow<'_, [u8]> = match data.contains('%') {
            true => {
                decode_percent(data).ok_or_else(|| wrong("has a '%' without two hexadecimal digits"))?.into()
            }
            false => data.as_bytes().into(),
        };
        return if header.to_ascii_lowercase().ends_with(";base64") {
            BASE64.decode(&bytes).map_err(|_| wrong("is not valid base64"))
        } else {
            Ok(bytes.into_owned())
        };
    }
    let path = relative_path(uri).map_err(wrong)?;
    let folder =
        files.base_dir.as_ref().ok_or_else(|| wrong("names a file, but no base directory was given"))?;
    let path = folder.join(path);
    let io = |source| GltfError::Io { path: path.display().to_string(), source };
    // What is no file is reported as such, wherever it is.
    if !std::fs::metadata(&path).map_err(io)?.is_file() {
        return Err(GltfError::NotAFile { path: path.display().to_string() });
    }
    if !files.outside && !files.is_inside(&path).map_err(io)? {
        return Err(GltfError::OutsideFile {
            item: item.into(),
            path: shown(&path.display().to_string()).into_owned(),
        });
    }
    let bytes = read_file(&path, budget)?;
    files.note_read(path);
    Ok(bytes)
}

/// Reads a regular file, and no more of it than the budget allows.
///
/// Devices and pipes are refused before they are opened: a path in a file from elsewhere may name them, and
/// reading them may never end.
pub(super) fn read_file(path: &Path, budget: &mut Budget) -> Result<Vec<u8>, GltfError> {
    let shown = || path.display().to_string();
    let io = |source| GltfError::Io { path: shown(), source };
    let metadata = std::fs::metadata(path).map_err(io)?;
    if !metadata.is_file() {
        return Err(GltfError::NotAFile { path: shown() });
    }
    budget.charge_bytes(metadata.len())?;
    let mut bytes = Vec::new();
    File::open(path).and_then(|file| file.take(metadata.len()).read_to_end(&mut bytes)).map_err(io)?;
    Ok(bytes)
}

/// The directory that a file's relative paths start from.
pub(super) fn base_dir(path: &Path) -> PathBuf {
    path.parent().map_or_else(PathBuf::new, Path::to_path_buf)
}

fn decode_percent(text: &str) -> Option<Vec<u8>> {
    let digit = |byte: u8| char::from(byte).to_digit(16).map(|digit| digit as u8);
    let mut bytes = text.bytes();
    let mut decoded = Vec::with_capacity(text.len());
    while let Some(byte) = bytes.next() {
        decoded.push(match byte {
            b'%' => digit(bytes.next()?)? << 4 | digit(bytes.next()?)?,
            byte => byte,
        });
    }
    Some(decoded)
}

/// Standard base64, strict but for the padding, which may be missing, and bits after the last byte.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_strict() {
        assert_eq!(BASE64.decode(b"aGVsbG8=").unwrap(), b"hello");
        assert_eq!(BASE64.decode(b"aGVsbG8").unwrap(), b"hello");
        assert_eq!(BASE64.decode(b"").unwrap(), b"");
        for bad in ["a", "aGVsbG8 ", "aGVs=bG8", "aGVsb===", "=", "a=="] {
            assert!(BASE64.decode(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn percent_escapes_decode() {
        assert_eq!(decode_percent("a%20b%C3%A9").unwrap(), "a bé".as_bytes());
        assert_eq!(decode_percent("%2"), None);
        assert_eq!(decode_percent("%zz"), None);
    }

    #[test]
    fn urls_and_absolute_paths_are_refused() {
        for bad in
            ["http://x/y.bin", "file:///etc/passwd", "/etc/passwd", "\\\\host\\x", "C:\\x.bin", "", "%2Fx"]
        {
            let files = Files::new(Some(PathBuf::from(".")), false);
            let error = read("buffer 0", bad, &files, &mut Budget::default()).unwrap_err();
            assert!(matches!(error, GltfError::Uri { .. }), "{bad}: {error}");
        }
    }
}
