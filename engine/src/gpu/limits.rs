//! What the adapter takes at once.

use super::{Gpu, GpuError};
use crate::plan::BufferUsage;

/// Checks a buffer of so many bytes, called `what()` in the error, against the adapter's limits for its use.
pub(super) fn check_buffer(
    gpu: &Gpu,
    what: impl FnOnce() -> String,
    usage: BufferUsage,
    bytes: u64,
) -> Result<(), GpuError> {
    let limit = match usage {
        BufferUsage::Storage => gpu.limits.max_storage_buffer_binding_size.min(gpu.limits.max_buffer_size),
        BufferUsage::Index => gpu.limits.max_buffer_size,
    };
    if bytes > limit {
        return Err(GpuError::BufferTooLarge { what: what(), bytes, adapter: gpu.name(), limit });
    }
    Ok(())
}
