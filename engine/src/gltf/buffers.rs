//! Buffers and the byte ranges of their views.

use std::borrow::Cow;
use std::path::Path;

use gltf::json;

use super::GltfError;
use super::limits::Budget;
use super::uri;

/// The bytes of every buffer, each exactly as long as its `byteLength`.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    data: Vec<Cow<'a, [u8]>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn load(
        root: &json::Root,
        bin: Option<&'a [u8]>,
        base_dir: Option<&Path>,
        budget: &mut Budget,
    ) -> Result<Self, GltfError> {
        let mut data = Vec::new();
        for (buffer, declaration) in root.buffers.iter().enumerate() {
            let mut bytes: Cow<'a, [u8]> = match (&declaration.uri, bin) {
                (Some(text), _) => uri::read(&format!("buffer {buffer}"), text, base_dir, budget)?.into(),
                (None, Some(bin)) if buffer == 0 => bin.into(),
                _ => return Err(GltfError::MissingBin { buffer }),
            };
            let (declared, found) = (declaration.byte_length.0, bytes.len() as u64);
            if found < declared {
                return Err(GltfError::BufferLength { buffer, declared, found });
            }
            match &mut bytes {
                Cow::Borrowed(bytes) => *bytes = &bytes[..declared as usize],
                Cow::Owned(bytes) => bytes.truncate(declared as usize),
            }
            data.push(bytes);
        }
        Ok(Self { data })
    }

    /// The bytes of a buffer view.
    pub(super) fn view(
        &self,
        root: &json::Root,
        view: json::Index<json::buffer::View>,
    ) -> Result<&[u8], GltfError> {
        let missing = |field: &str, kind, index: usize, count| GltfError::IndexOutOfRange {
            item: format!("buffer view {}", view.value()),
            field: field.into(),
            kind,
            index: index as u64,
            count,
        };
        let declaration = root
            .get(view)
            .ok_or_else(|| missing("bufferView", "buffer view", view.value(), root.buffer_views.len()))?;
        let buffer = declaration.buffer.value();
        let bytes =
            self.data.get(buffer).ok_or_else(|| missing("buffer", "buffer", buffer, self.data.len()))?;
        let start = declaration.byte_offset.unwrap_or_default().0;
        let end = u128::from(start) + u128::from(declaration.byte_length.0);
        if end > bytes.len() as u128 {
            let available = bytes.len();
            return Err(GltfError::ViewRange { view: view.value(), start, end, buffer, available });
        }
        Ok(&bytes[start as usize..end as usize])
    }
}
