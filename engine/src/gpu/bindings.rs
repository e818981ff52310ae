//! Bind groups of technique draws, and their layouts.

use std::collections::HashMap;

use wgpu::TextureFormat;

use super::Gpu;

/// What kind of thing is bound where: the key of a layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BindKind {
    Storage,
    Texture { sample: SampleKind, array: bool, multisampled: bool },
    Comparison,
}

/// How a texture's texels are seen by a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum SampleKind {
    Float,
    Depth,
    Uint,
}

impl SampleKind {
    /// What shaders see of `format`'s colour or depth aspect.
    pub(crate) fn of(format: TextureFormat) -> Self {
        match format.sample_type(None, None) {
            _ if format.is_depth_stencil_format() => Self::Depth,
            Some(wgpu::TextureSampleType::Uint) => Self::Uint,
            _ => Self::Float,
        }
    }
}

/// Layouts by what they hold, and samplers.
#[derive(Debug, Default)]
pub(crate) struct Layouts {
    layouts: HashMap<Vec<(u32, BindKind)>, wgpu::BindGroupLayout>,
    comparisons: HashMap<wgpu::CompareFunction, wgpu::Sampler>,
}

impl Layouts {
    /// The sampler that compares so, and blends linearly between four texels.
    pub(crate) fn comparison(&mut self, gpu: &Gpu, compare: wgpu::CompareFunction) -> wgpu::Sampler {
        let made = self.comparisons.entry(compare).or_insert_with(|| {
            gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("comparison"),
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                compare: Some(compare),
                ..Default::default()
            })
        });
        made.clone()
    }

    pub(crate) fn get(&mut self, gpu: &Gpu, kinds: &[(u32, BindKind)]) -> wgpu::BindGroupLayout {
        if let Some(layout) = self.layouts.get(kinds) {
            return layout.clone();
        }
        let entries: Vec<_> = kinds
            .iter()
            .map(|(binding, kind)| wgpu::BindGroupLayoutEntry {
                binding: *binding,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty: match kind {
                    BindKind::Storage => wgpu::BindingType::Buffer {
                        ty: wgpu::BufferBindingType::Storage { read_only: true },
                        has_dynamic_offset: false,
                        min_binding_size: None,
                    },
                    BindKind::Texture { sample, array, multisampled } => wgpu::BindingType::Texture {
                        sample_type: match sample {
                            SampleKind::Float => wgpu::TextureSampleType::Float { filterable: false },
                            SampleKind::Depth => wgpu::TextureSampleType::Depth,
                            SampleKind::Uint => wgpu::TextureSampleType::Uint,
                        },
                        view_dimension: if *array {
                            wgpu::TextureViewDimension::D2Array
                        } else {
                            wgpu::TextureViewDimension::D2
                        },
                        multisampled: *multisampled,
                    },
                    BindKind::Comparison => wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Comparison),
                },
                count: None,
            })
            .collect();
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("draw"),
            entries: &entries,
        });
        self.layouts.insert(kinds.to_vec(), layout.clone());
        layout
    }
}
