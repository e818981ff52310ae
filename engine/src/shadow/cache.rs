//! What outlives a frame on the CPU: results keyed by a hash of what they were computed from.

use std::any::Any;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

/// Frames after which an entry nobody asked for is dropped.
const KEPT_FRAMES: u64 = 8;

/// Results that persist between frames. Keys are hashes of everything a result depends on, so an entry is never
/// stale: what moved has another key, and what nobody asks for any more is dropped.
#[derive(Debug, Default)]
pub struct Cache {
    entries: HashMap<(&'static str, u64), Entry>,
    frame: u64,
    computed: u64,
}

#[derive(Debug)]
struct Entry {
    value: Arc<dyn Any + Send + Sync>,
    last_used_frame: u64,
}

impl Cache {
    /// An empty cache.
    pub fn new() -> Self {
        Self::default()
    }

    /// The value of `kind` for `key`, computed now if it is not there.
    pub fn get_or_compute<T: Any + Send + Sync>(
        &mut self,
        kind: &'static str,
        key: u64,
        compute: impl FnOnce() -> T,
    ) -> Arc<T> {
        let frame = self.frame;
        if let Some(entry) = self.entries.get_mut(&(kind, key)) {
            entry.last_used_frame = frame;
            if let Ok(value) = Arc::clone(&entry.value).downcast::<T>() {
                return value;
            }
        }
        let value = Arc::new(compute());
        self.computed += 1;
        let entry = Entry { value: Arc::clone(&value) as Arc<dyn Any + Send + Sync>, last_used_frame: frame };
        self.entries.insert((kind, key), entry);
        value
    }

    /// How many values were computed since the cache was made: in a frame in which nothing moved, none.
    pub fn computed(&self) -> u64 {
        self.computed
    }

    /// Marks the beginning of a frame and drops what has not been asked for lately.
    pub fn begin_frame(&mut self) {
        self.frame += 1;
        let oldest = self.frame.saturating_sub(KEPT_FRAMES);
        self.entries.retain(|_, entry| entry.last_used_frame >= oldest);
    }
}

/// A hash of anything hashable, for keys.
pub fn hash_of(value: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}
