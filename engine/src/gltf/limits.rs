//! How much a file may make the loader allocate, and how many warnings it may write.
//!
//! A few bytes of JSON can ask for any amount of memory: counts without data behind them, one accessor named by a
//! thousand primitives, a small picture that unpacks to gigabytes. Everything allocated for a file is charged to
//! one budget first.

use std::collections::HashSet;

use super::GltfError;

/// The most instances of `EXT_mesh_gpu_instancing` in one file: each becomes a node.
const MAX_INSTANCES: u64 = 1 << 18;

/// What one load may still allocate.
#[derive(Clone, Debug)]
pub(super) struct Budget {
    bytes: u64,
    elements: u64,
    texels: u64,
    instances: u64,
}

/// The most objects (counted as opening braces) the JSON may have; the parser spends some hundred bytes on each.
pub(super) const MAX_JSON_OBJECTS: u64 = 1 << 22;
/// The most bytes of buffers and encoded images read for one file.
const MAX_BYTES: u64 = 4 << 30;
/// The most accessor elements (vertices, indices) read for one file; each takes at most 16 bytes.
const MAX_ELEMENTS: u64 = 1 << 28;
/// The most texels of all decoded images; each takes 4 bytes.
const MAX_TEXELS: u64 = 1 << 28;

impl Default for Budget {
    fn default() -> Self {
        Self { bytes: MAX_BYTES, elements: MAX_ELEMENTS, texels: MAX_TEXELS, instances: MAX_INSTANCES }
    }
}

fn charge(left: &mut u64, limit: u64, count: u64, what: &str) -> Result<(), GltfError> {
    match left.checked_sub(count) {
        Some(rest) => {
            *left = rest;
            Ok(())
        }
        None => {
            let count = (limit - *left).saturating_add(count);
            Err(GltfError::TooLarge { what: what.into(), count, limit })
        }
    }
}

impl Budget {
    pub(super) fn charge_bytes(&mut self, count: u64) -> Result<(), GltfError> {
        charge(&mut self.bytes, MAX_BYTES, count, "bytes of buffers and images")
    }

    pub(super) fn charge_elements(&mut self, count: u64) -> Result<(), GltfError> {
        charge(&mut self.elements, MAX_ELEMENTS, count, "vertices and indices of the whole file")
    }

    pub(super) fn charge_instances(&mut self, count: u64) -> Result<(), GltfError> {
        charge(&mut self.instances, MAX_INSTANCES, count, "instances of the whole file")
    }

    pub(super) fn charge_texels(&mut self, count: u64) -> Result<(), GltfError> {
        charge(&mut self.texels, MAX_TEXELS, count, "texels of all images")
    }
}

/// The most different warnings kept; a file with more is told so once.
const MAX_WARNINGS: usize = 100;

/// What was left out while loading, each thing once.
#[derive(Clone, Debug, Default)]
pub(super) struct Warnings {
    seen: HashSet<String>,
    texts: Vec<String>,
}

impl Warnings {
    pub(super) fn add(&mut self, text: impl Into<String>) {
        let text = text.into();
        if self.texts.len() < MAX_WARNINGS && self.seen.insert(text.clone()) {
            self.texts.push(text);
            if self.texts.len() == MAX_WARNINGS {
                self.texts.push("further warnings are left out".into());
            }
        }
    }

    pub(super) fn into_texts(self) -> Vec<String> {
        self.texts
    }
}
