//! What outlives a frame on the CPU: results keyed by a hash of what they were computed from.

use std::any::Any;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Frames after which an entry nobody asked for is dropped.
const KEPT_FRAMES: u64 = 8;

/// Results that persist between frames. Keys are hashes of everything a result depends on, so an entry is never
/// stale: what moved has another key, and what nobody asks for any more is dropped.
///
/// A shared reference is enough to use it: what one technique computes may ask for what another has.
#[derive(Debug, Default)]
pub struct Cache {
    store: Mutex<Store>,
}

#[derive(Debug, Default)]
struct Store {
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

    /// The value of `kind` under `key`; computed first if the cache does not hold it.
    pub fn get_or_compute<T: Any + Send + Sync>(
        &self,
        kind: &'static str,
        key: u64,
        compute: impl FnOnce() -> T,
    ) -> Arc<T> {
        if let Some(value) = self.store().get(kind, key).and_then(|value| value.downcast::<T>().ok()) {
            return value;
        }
        // Not under the lock: what is computed may ask for more.
        let value = Arc::new(compute());
        let mut store = self.store();
        store.computed += 1;
        let last_used_frame = store.frame;
        let entry = Entry { value: Arc::clone(&value) as Arc<dyn Any + Send + Sync>, last_used_frame };
        store.entries.insert((kind, key), entry);
        value
    }

    /// How many values were computed since the cache was made: in a frame in which nothing moved, none.
    pub fn computed(&self) -> u64 {
        self.store().computed
    }

    /// Begins a frame: drops what no recent frame asked for.
    pub fn begin_frame(&self) {
        let mut store = self.store();
        store.frame += 1;
        let oldest = store.frame.saturating_sub(KEPT_FRAMES);
        store.entries.retain(|_, entry| entry.last_used_frame >= oldest);
    }

    /// A panic elsewhere leaves whole entries behind.
    fn store(&self) -> MutexGuard<'_, Store> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Store {
    fn get(&mut self, kind: &'static str, key: u64) -> Option<Arc<dyn Any + Send + Sync>> {
        let entry = self.entries.get_mut(&(kind, key))?;
        entry.last_used_frame = self.frame;
        Some(Arc::clone(&entry.value))
    }
}

/// A hash of anything hashable, for keys.
pub fn hash_of(value: impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}
