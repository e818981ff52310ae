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
    memory_limit: u64,
    memory: u64,
    image_memory: u64,
    instances: u64,
}

/// The most objects (counted as opening braces) the JSON may have; the parser spends some hundred bytes on each.
pub(super) const MAX_JSON_OBJECTS: u64 = 1 << 22;
/// The most values (counted as commas and opening brackets) the JSON may have; the parser spends 32 bytes on each.
pub(super) const MAX_JSON_VALUES: u64 = 1 << 25;
/// The most bytes of buffers and encoded images read for one file.
const MAX_BYTES: u64 = 4 << 30;
/// The most bytes that meshes and images take, unless a caller says otherwise; images take half of it at most.
const DEFAULT_MEMORY: u64 = 2 << 30;
/// What an accessor's element (a vertex, an index) takes at most.
const ELEMENT_BYTES: u64 = 16;

impl Budget {
    /// A budget for a load that may take so many bytes for meshes and images.
    pub(super) fn new(memory: Option<u64>) -> Self {
        let memory_limit = memory.unwrap_or(DEFAULT_MEMORY);
        Self {
            bytes: MAX_BYTES,
            memory_limit,
            memory: memory_limit,
            image_memory: memory_limit / 2,
            instances: MAX_INSTANCES,
        }
    }
}

impl Default for Budget {
    fn default() -> Self {
        Self::new(None)
    }
}

fn charge(left: &mut u64, limit: u64, count: u64, what: impl FnOnce() -> String) -> Result<(), GltfError> {
    match left.checked_sub(count) {
        Some(rest) => {
            *left = rest;
            Ok(())
        }
        None => {
            let count = (limit - *left).saturating_add(count);
            Err(GltfError::TooLarge { what: what(), count, limit })
        }
    }
}

impl Budget {
    pub(super) fn charge_bytes(&mut self, count: u64) -> Result<(), GltfError> {
        charge(&mut self.bytes, MAX_BYTES, count, || "bytes of buffers and images".into())
    }

    pub(super) fn charge_elements(&mut self, count: u64) -> Result<(), GltfError> {
        self.charge_memory(count.saturating_mul(ELEMENT_BYTES))
    }

    /// Memory for meshes and what they are made from.
    pub(super) fn charge_memory(&mut self, bytes: u64) -> Result<(), GltfError> {
        take(&mut self.memory, self.memory_limit, bytes, "what the file's meshes and images hold")
    }

    pub(super) fn charge_instances(&mut self, count: u64) -> Result<(), GltfError> {
        charge(&mut self.instances, MAX_INSTANCES, count, || "instances of the whole file".into())
    }

    /// Charges an image that stays as `kept` bytes and takes `passing` more while it is decoded.
    pub(super) fn charge_image(&mut self, image: &str, kept: u64, passing: u64) -> Result<(), GltfError> {
        let limit = self.memory_limit / 2;
        let what = format!("{image}, with the images before it,");
        let mut tried = self.image_memory;
        take(&mut tried, limit, kept.saturating_add(passing), &what)?;
        take(&mut self.image_memory, limit, kept, &what)?;
        self.charge_memory(kept)
    }
}

/// [`charge`] of memory.
fn take(left: &mut u64, limit: u64, bytes: u64, what: &str) -> Result<(), GltfError> {
    match left.checked_sub(bytes) {
        Some(rest) => {
            *left = rest;
            Ok(())
        }
        None => {
            let bytes = (limit - *left).saturating_add(bytes);
            Err(GltfError::Memory { what: what.into(), bytes, limit })
        }
    }
}

/// The most different warnings kept; a last one says that there were more.
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
        if !self.is_full() && self.seen.insert(text.clone()) {
            self.texts.push(text);
            if self.is_full() {
                self.texts.push("further warnings are left out".into());
            }
        }
    }

    pub(super) fn is_full(&self) -> bool {
        self.texts.len() >= MAX_WARNINGS
    }

    pub(super) fn into_texts(self) -> Vec<String> {
        self.texts
    }
}
