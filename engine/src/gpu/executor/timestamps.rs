//! GPU time by timestamps at the beginning and the end of every render pass.

use crate::gpu::readback::read_buffer;
use crate::gpu::{Gpu, GpuError};

/// Two timestamps for each render pass of a frame.
pub(super) struct Timestamps {
    set: wgpu::QuerySet,
    count: u32,
    /// What the CPU reads.
    resolved: wgpu::Buffer,
}

/// What the timestamps say, in milliseconds.
pub(super) struct Times {
    /// Of each render pass, in order.
    pub(super) passes_ms: Vec<f64>,
    /// From the first one's beginning to the last one's end; `None` without any.
    pub(super) frame_ms: Option<f64>,
}

impl Timestamps {
    /// Timestamps for so many render passes; `None` where the adapter has none, or not as many.
    pub(super) fn new(gpu: &Gpu, passes: u32) -> Option<Self> {
        let count = passes * 2;
        if count > wgpu::QUERY_SET_MAX_QUERIES || !gpu.features.contains(wgpu::Features::TIMESTAMP_QUERY) {
            return None;
        }
        let set = gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("pass times"),
            ty: wgpu::QueryType::Timestamp,
            count,
        });
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ;
        Some(Self { resolved: buffer(gpu, count, usage), set, count })
    }

    /// What the render pass with this number writes.
    pub(super) fn around(&self, pass: u32) -> wgpu::RenderPassTimestampWrites<'_> {
        wgpu::RenderPassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(pass * 2),
            end_of_pass_write_index: Some(pass * 2 + 1),
        }
    }

    /// Records the copy to the CPU, after the last render pass.
    pub(super) fn resolve(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let on_gpu = buffer(gpu, self.count, usage);
        encoder.resolve_query_set(&self.set, 0..self.count, &on_gpu, 0);
        encoder.copy_buffer_to_buffer(&on_gpu, 0, &self.resolved, 0, on_gpu.size());
    }

    /// Waits for the times of what was submitted.
    pub(super) fn read(self, gpu: &Gpu) -> Result<Times, GpuError> {
        let stamps: Vec<u64> = bytemuck::pod_collect_to_vec(&read_buffer(gpu, &self.resolved)?);
        let ms_per_tick = f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        // Clocks of some drivers step back between passes; a negative time is reported as none.
        let elapsed = |from: u64, to: u64| to.saturating_sub(from) as f64 * ms_per_tick;
        Ok(Times {
            passes_ms: stamps.chunks_exact(2).map(|stamps| elapsed(stamps[0], stamps[1])).collect(),
            frame_ms: stamps.first().zip(stamps.last()).map(|(first, last)| elapsed(*first, *last)),
        })
    }
}

fn buffer(gpu: &Gpu, stamps: u32, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("pass times"),
        size: u64::from(stamps) * 8,
        usage,
        mapped_at_creation: false,
    })
}
