//! Render pipelines by everything that makes them different.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use wgpu::TextureFormat;

use super::Gpu;
use super::bindings::{BindKind, Layouts};
use super::meshes::{ATTRIBUTE_LAYOUT, POSITION_LAYOUT};
use crate::plan::{BlendState, CompareFunction, DrawState, Shader, Stencil};

/// Which vertex buffers a pipeline reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum VertexInput {
    None,
    Positions,
    All,
}

/// Which faces a pipeline drops: those turned away, as the instance's transform leaves them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Culling {
    None,
    Back,
    /// Back faces of an instance whose transform mirrors.
    BackMirrored,
}

/// Everything that makes two pipelines different.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    shader: Arc<str>,
    vertex: Cow<'static, str>,
    fragment: Option<Cow<'static, str>>,
    kinds: Vec<(u32, BindKind)>,
    with_material: bool,
    input: VertexInput,
    culling: Culling,
    depth_compare: CompareFunction,
    depth_write: bool,
    depth_clamp: bool,
    stencil: Option<Stencil>,
    targets: Vec<(TextureFormat, Option<BlendState>)>,
    depth_format: Option<TextureFormat>,
}

/// What a pipeline is asked for.
pub(crate) struct Wanted<'a> {
    pub(crate) shader: &'a Shader,
    pub(crate) state: &'a DrawState,
    /// What group 1 holds.
    pub(crate) kinds: &'a [(u32, BindKind)],
    /// Whether group 2 is a material.
    pub(crate) with_material: bool,
    pub(crate) input: VertexInput,
    pub(crate) culling: Culling,
    /// The render pass's colour formats, and how this draw blends into each; `None` leaves a target alone.
    pub(crate) targets: Vec<(TextureFormat, Option<BlendState>)>,
    pub(crate) depth_format: Option<TextureFormat>,
}

/// Pipelines and shader modules made so far.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    pipelines: HashMap<Key, wgpu::RenderPipeline>,
    modules: HashMap<String, wgpu::ShaderModule>,
}

impl Pipelines {
    pub(crate) fn get(
        &mut self,
        gpu: &Gpu,
        layouts: &mut Layouts,
        frame_layout: &wgpu::BindGroupLayout,
        material_layout: &wgpu::BindGroupLayout,
        wanted: &Wanted<'_>,
    ) -> wgpu::RenderPipeline {
        let Wanted { shader, state, .. } = wanted;
        // Blending is not part of targets that cannot blend, and the stencil reference is set while drawing.
        let stencil = state.stencil.map(|stencil| Stencil { reference: 0, ..stencil });
        let key = Key {
            shader: Arc::clone(&shader.name),
            vertex: shader.vertex.clone(),
            fragment: shader.fragment.clone(),
            kinds: wanted.kinds.to_vec(),
            with_material: wanted.with_material,
            input: wanted.input,
            culling: wanted.culling,
            depth_compare: state.depth_compare,
            depth_write: state.depth_write,
            depth_clamp: state.depth_clamp,
            stencil,
            targets: wanted.targets.clone(),
            depth_format: wanted.depth_format,
        };
        if let Some(pipeline) = self.pipelines.get(&key) {
            return pipeline.clone();
        }
        let draw_layout = layouts.get(gpu, wanted.kinds);
        let mut groups = vec![Some(frame_layout), Some(&draw_layout)];
        groups.extend(wanted.with_material.then_some(Some(material_layout)));
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&shader.name),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let module = self.module(gpu, &shader.name, &shader.source);
        // A pass with colour targets wants a fragment stage of every pipeline, even one that writes none of them.
        let fragment = match &shader.fragment {
            Some(entry) => Some((module.clone(), entry.to_string())),
            None if wanted.targets.is_empty() => None,
            None => {
                let source = shadowgraph_shaders::source("nothing").unwrap_or_default();
                Some((self.module(gpu, "nothing", source), "nothing".to_owned()))
            }
        };
        let pipeline = create(gpu, &layout, &module, fragment.as_ref(), wanted);
        self.pipelines.insert(key, pipeline.clone());
        pipeline
    }

    fn module(&mut self, gpu: &Gpu, name: &str, source: &str) -> wgpu::ShaderModule {
        let module = self.modules.entry(name.to_owned()).or_insert_with(|| {
            gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(name),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            })
        });
        module.clone()
    }
}

fn create(
    gpu: &Gpu,
    layout: &wgpu::PipelineLayout,
    module: &wgpu::ShaderModule,
    fragment: Option<&(wgpu::ShaderModule, String)>,
    wanted: &Wanted<'_>,
) -> wgpu::RenderPipeline {
    let Wanted { shader, state, .. } = wanted;
    let targets: Vec<_> = wanted
        .targets
        .iter()
        .map(|(format, blend)| {
            Some(wgpu::ColorTargetState {
                format: *format,
                blend: blend.filter(|blend| *blend != BlendState::REPLACE),
                write_mask: if blend.is_some() { wgpu::ColorWrites::ALL } else { wgpu::ColorWrites::empty() },
            })
        })
        .collect();
    let buffers: &[Option<wgpu::VertexBufferLayout<'_>>] = match wanted.input {
        VertexInput::None => &[],
        VertexInput::Positions => &[Some(POSITION_LAYOUT)],
        VertexInput::All => &[Some(POSITION_LAYOUT), Some(ATTRIBUTE_LAYOUT)],
    };
    let stencil = state.stencil.map_or_else(wgpu::StencilState::default, |stencil| wgpu::StencilState {
        front: stencil.front,
        back: stencil.back,
        read_mask: stencil.read_mask.into(),
        write_mask: stencil.write_mask.into(),
    });
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(&shader.name),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(&shader.vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: wgpu::PrimitiveTopology::TriangleList,
            front_face: match wanted.culling {
                Culling::BackMirrored => wgpu::FrontFace::Cw,
                Culling::None | Culling::Back => wgpu::FrontFace::Ccw,
            },
            cull_mode: (wanted.culling != Culling::None).then_some(wgpu::Face::Back),
            unclipped_depth: state.depth_clamp,
            ..Default::default()
        },
        depth_stencil: wanted.depth_format.map(|format| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(state.depth_write),
            depth_compare: Some(state.depth_compare),
            stencil,
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: fragment.map(|(module, entry)| wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}
