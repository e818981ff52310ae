//! Meshes on the GPU.

use std::collections::HashMap;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::limits::check_buffer;
use super::{Gpu, GpuError};
use crate::geometry::Mesh;
use crate::plan::BufferUsage;

/// Everything of a vertex but its position; common/attributes.wgsl reads it word by word.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Attributes {
    normal: [f32; 3],
    uv: [f32; 2],
    color: [u8; 4],
    second_uv: [f32; 2],
}

/// The vertex buffers of shaded surfaces: positions, then everything else.
pub(crate) const POSITION_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: 12,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3],
};
pub(crate) const ATTRIBUTE_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Attributes>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![1 => Float32x3, 2 => Float32x2, 3 => Unorm8x4, 4 => Float32x2],
};

/// One mesh in GPU memory.
#[derive(Debug)]
pub(crate) struct GpuMesh {
    pub(crate) positions: wgpu::Buffer,
    pub(crate) attributes: wgpu::Buffer,
    pub(crate) indices: wgpu::Buffer,
    last_used_frame: u64,
}

/// The meshes of recent frames by [`Mesh::id`].
#[derive(Debug, Default)]
pub(crate) struct Meshes {
    meshes: HashMap<u64, GpuMesh>,
    frame: u64,
}

/// Frames after which a mesh nobody drew is dropped.
const KEPT_FRAMES: u64 = 8;

impl Meshes {
    pub(crate) fn begin_frame(&mut self) {
        self.frame += 1;
        let oldest = self.frame.saturating_sub(KEPT_FRAMES);
        self.meshes.retain(|_, mesh| mesh.last_used_frame >= oldest);
    }

    /// Makes sure `mesh` is on the GPU.
    pub(crate) fn upload(&mut self, gpu: &Gpu, mesh: &Mesh) {
        if let Some(uploaded) = self.meshes.get_mut(&mesh.id()) {
            uploaded.last_used_frame = self.frame;
            return;
        }
        let data = mesh.data();
        let positions = mesh.shader_positions();
        let attributes: Vec<Attributes> = (0..data.positions.len())
            .map(|i| Attributes {
                normal: data.normals.get(i).copied().unwrap_or(Vec3::Y).to_array(),
                uv: data.uvs.get(i).copied().unwrap_or_default().to_array(),
                color: mesh.color8(i as u32),
                second_uv: data.second_uvs.get(i).copied().unwrap_or_default().to_array(),
            })
            .collect();
        use wgpu::BufferUsages as Usage;
        let name = mesh.name();
        let uploaded = GpuMesh {
            positions: gpu.buffer(name, Usage::VERTEX | Usage::STORAGE, bytemuck::cast_slice(&positions)),
            attributes: gpu.buffer(name, Usage::VERTEX | Usage::STORAGE, bytemuck::cast_slice(&attributes)),
            indices: gpu.buffer(name, Usage::INDEX | Usage::STORAGE, bytemuck::cast_slice(&data.indices)),
            last_used_frame: self.frame,
        };
        self.meshes.insert(mesh.id(), uploaded);
    }

    /// The bytes `mesh` takes, if each of its buffers is within the adapter's limits. Positions and indices are read as
    /// storage by some draws.
    pub(crate) fn check(gpu: &Gpu, mesh: &Mesh) -> Result<u64, GpuError> {
        let data = mesh.data();
        let vertices = data.positions.len() as u64;
        let parts = [
            ("positions", vertices * 12, BufferUsage::Storage),
            ("indices", data.indices.len() as u64 * 4, BufferUsage::Storage),
            ("attributes", vertices * size_of::<Attributes>() as u64, BufferUsage::Index),
        ];
        for (part, bytes, usage) in parts {
            check_buffer(gpu, || format!("mesh '{}', {part},", mesh.name()), usage, bytes)?;
        }
        Ok(parts.iter().map(|(_, bytes, _)| bytes).sum())
    }

    /// Drops all meshes but these.
    pub(crate) fn keep_only(&mut self, ids: &HashMap<u64, &Mesh>) {
        self.meshes.retain(|id, _| ids.contains_key(id));
    }

    /// A mesh that [`Meshes::upload`] was called for in this frame.
    pub(crate) fn get(&self, mesh: &Mesh) -> Option<&GpuMesh> {
        self.meshes.get(&mesh.id())
    }

    /// Bytes of all meshes.
    pub(crate) fn bytes(&self) -> u64 {
        self.meshes.values().map(|m| m.positions.size() + m.attributes.size() + m.indices.size()).sum()
    }
}
