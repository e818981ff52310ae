//! Buffers and the byte ranges of their views, read when something needs them.

use std::borrow::Cow;
use std::cell::OnceCell;

use serde_json::{Map, Value};

use super::GltfError;
use super::document::{Document, Section};
use super::limits::Budget;
use super::meshopt::{self, Compressed};
use super::uri::{self, Files};

/// The bytes of every buffer that was needed, each exactly as long as its `byteLength`.
#[derive(Debug)]
pub(super) struct Buffers<'a> {
    document: &'a Document,
    bin: Option<&'a [u8]>,
    files: &'a Files,
    data: Vec<OnceCell<Cow<'a, [u8]>>>,
    /// What compressed views decode to.
    decoded: Vec<OnceCell<Vec<u8>>>,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(document: &'a Document, bin: Option<&'a [u8]>, files: &'a Files) -> Self {
        let data = (0..document.buffers.len()).map(|_| OnceCell::new()).collect();
        let decoded = (0..document.buffer_views.len()).map(|_| OnceCell::new()).collect();
        Self { document, bin, files, data, decoded }
    }

    /// The bytes of a buffer.
    fn buffer(&self, buffer: usize, budget: &mut Budget) -> Result<&[u8], GltfError> {
        let declaration = self.document.used(Section::Buffers, buffer)?;
        let Some(cell) = self.data.get(buffer) else { return Err(GltfError::MissingBin { buffer }) };
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let mut bytes: Cow<'a, [u8]> = match (declaration.get("uri").and_then(Value::as_str), self.bin) {
            (Some(text), _) => uri::read(&format!("buffer {buffer}"), text, self.files, budget)?.into(),
            (None, Some(bin)) if buffer == 0 => bin.into(),
            _ => return Err(GltfError::MissingBin { buffer }),
        };
        let (declared, found) = (whole(declaration, "byteLength"), bytes.len() as u64);
        if found < declared {
            return Err(GltfError::BufferLength { buffer, declared, found });
        }
        match &mut bytes {
            Cow::Borrowed(bytes) => *bytes = &bytes[..declared as usize],
            Cow::Owned(bytes) => bytes.truncate(declared as usize),
        }
        Ok(cell.get_or_init(|| bytes))
    }

    /// The bytes of a buffer view, decompressed where need be.
    pub(super) fn view(&self, view: usize, budget: &mut Budget) -> Result<&[u8], GltfError> {
        let declaration = self.document.used(Section::BufferViews, view)?;
        let compressed = Compressed::of(declaration, view)?;
        let Some(compressed) = compressed else {
            let length = whole(declaration, "byteLength");
            return self.part(
                view,
                whole(declaration, "buffer"),
                whole(declaration, "byteOffset"),
                length,
                budget,
            );
        };
        let Some(cell) = self.decoded.get(view) else { return Ok(&[]) };
        if let Some(bytes) = cell.get() {
            return Ok(bytes);
        }
        let Compressed { buffer, offset, length, .. } = compressed;
        if buffer >= self.document.buffers.len() as u64 {
            let problem = super::check::out_of_bounds(self.document, Section::Buffers, buffer);
            return Err(GltfError::Invalid {
                path: format!("bufferViews[{view}].extensions.buffer"),
                problem,
            });
        }
        let bytes = self.part(view, buffer, offset, length, budget)?;
        budget.charge_memory(compressed.decoded_bytes())?;
        let decoded = meshopt::decode(bytes, &compressed)
            .map_err(|problem| GltfError::Compressed { view, problem: problem.into() })?;
        let (declared, found) = (whole(declaration, "byteLength"), decoded.len() as u64);
        if declared != found {
            let problem = format!("it decodes to {found} bytes, but its byteLength says {declared}");
            return Err(GltfError::Compressed { view, problem });
        }
        Ok(cell.get_or_init(|| decoded))
    }

    /// Bytes of a buffer that view `view` names.
    fn part(
        &self,
        view: usize,
        buffer: u64,
        start: u64,
        length: u64,
        budget: &mut Budget,
    ) -> Result<&[u8], GltfError> {
        let buffer = buffer as usize;
        let bytes = self.buffer(buffer, budget)?;
        let end = u128::from(start) + u128::from(length);
        if end > bytes.len() as u128 {
            let available = bytes.len();
            return Err(GltfError::ViewRange { view, start, end, buffer, available });
        }
        Ok(&bytes[start as usize..end as usize])
    }
}

/// A whole number of a checked object; 0 for one that is not there.
pub(super) fn whole(object: &Map<String, Value>, field: &str) -> u64 {
    object.get(field).and_then(Value::as_u64).unwrap_or(0)
}
