//! Render pipelines by everything that makes them different, shared by all that draw on one device: compiling one takes as long as
//! many frames.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use wgpu::TextureFormat;

use super::bindings::{BindKind, Layouts};
use super::meshes::{ATTRIBUTE_LAYOUT, POSITION_LAYOUT};
use super::{Gpu, GpuError};
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

/// See [`DrawState::depth_bias`].
const SLOPE_OF_ROUNDING_PX: f32 = 1.0 / (1 << 19) as f32;

/// Everything that makes two pipelines different.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Key {
    text: usize,
    vertex: Cow<'static, str>,
    fragment: Option<Cow<'static, str>>,
    kinds: Vec<(u32, BindKind)>,
    with_material: bool,
    input: VertexInput,
    culling: Culling,
    depth_compare: CompareFunction,
    depth_write: bool,
    depth_clamp: bool,
    depth_bias: i32,
    stencil: Option<Stencil>,
    targets: Vec<(TextureFormat, Option<BlendState>)>,
    depth_format: Option<TextureFormat>,
    samples: u32,
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
    /// Samples of a pixel in all attachments.
    pub(crate) samples: u32,
}

/// Pipelines, layouts and shader modules made so far on a device.
#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    pub(crate) layouts: Layouts,
    pipelines: HashMap<Key, wgpu::RenderPipeline>,
    /// Every text met, by itself: two shaders of one name and different texts are two shaders.
    texts: HashMap<Arc<str>, usize>,
    /// The modules of `texts`.
    modules: Vec<wgpu::ShaderModule>,
}

/// The numbers of one frame's texts by address, which spares hashing them for every draw. Addresses are those of one plan's
/// shaders, and mean nothing in the next frame.
pub(crate) type Addresses = HashMap<usize, usize>;

impl Pipelines {
    /// The pipeline for what is `wanted`.
    ///
    /// # Errors
    /// [`GpuError::Shader`] and [`GpuError::Pipeline`] name the shader and say what is wrong with it.
    pub(crate) fn get(
        &mut self,
        gpu: &Gpu,
        addresses: &mut Addresses,
        frame_layout: &wgpu::BindGroupLayout,
        material_layout: &wgpu::BindGroupLayout,
        wanted: &Wanted<'_>,
    ) -> Result<wgpu::RenderPipeline, GpuError> {
        let Wanted { shader, state, .. } = wanted;
        let text = self.text(gpu, addresses, &shader.name, &shader.source)?;
        // Blending is not part of targets that cannot blend, and the stencil reference is set while drawing.
        let stencil = state.stencil.map(|stencil| Stencil { reference: 0, ..stencil });
        let key = Key {
            text,
            vertex: shader.vertex.clone(),
            fragment: shader.fragment.clone(),
            kinds: wanted.kinds.to_vec(),
            with_material: wanted.with_material,
            input: wanted.input,
            culling: wanted.culling,
            depth_compare: state.depth_compare,
            depth_write: state.depth_write,
            depth_clamp: state.depth_clamp,
            depth_bias: state.depth_bias,
            stencil,
            targets: wanted.targets.clone(),
            depth_format: wanted.depth_format,
            samples: wanted.samples,
        };
        if let Some(pipeline) = self.pipelines.get(&key) {
            return Ok(pipeline.clone());
        }
        let draw_layout = self.layouts.get(gpu, wanted.kinds);
        let mut groups = vec![Some(frame_layout), Some(&draw_layout)];
        groups.extend(wanted.with_material.then_some(Some(material_layout)));
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&shader.name),
            bind_group_layouts: &groups,
            immediate_size: 0,
        });
        let module = self.modules[text].clone();
        // A pass with colour targets wants a fragment stage of every pipeline, even one that writes none of them.
        let fragment = match &shader.fragment {
            Some(entry) => Some((module.clone(), entry.to_string())),
            None if wanted.targets.is_empty() => None,
            None => {
                let source = shadowgraph_shaders::compose_named("nothing", &[])?;
                let text = self.text(gpu, addresses, "nothing", &source.into())?;
                Some((self.modules[text].clone(), "nothing".to_owned()))
            }
        };
        let (pipeline, error) = gpu.scoped(|| create(gpu, &layout, &module, fragment.as_ref(), wanted));
        if let Some(error) = error {
            let (shader, message) = (shader.name.to_string(), error.to_string());
            return Err(GpuError::Pipeline { shader, adapter: gpu.name(), message });
        }
        self.pipelines.insert(key, pipeline.clone());
        Ok(pipeline)
    }

    /// The number of a text, compiled if it is new.
    fn text(
        &mut self,
        gpu: &Gpu,
        addresses: &mut Addresses,
        name: &str,
        source: &Arc<str>,
    ) -> Result<usize, GpuError> {
        let address = source.as_ptr() as usize;
        if let Some(number) = addresses.get(&address) {
            return Ok(*number);
        }
        let number = match self.texts.get(source) {
            Some(number) => *number,
            None => {
                let (module, error) = gpu.scoped(|| {
                    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
                        label: Some(name),
                        source: wgpu::ShaderSource::Wgsl(Cow::Borrowed(source)),
                    })
                });
                if let Some(error) = error {
                    return Err(GpuError::Shader { shader: name.into(), message: error.to_string() });
                }
                self.modules.push(module);
                self.texts.insert(Arc::clone(source), self.modules.len() - 1);
                self.modules.len() - 1
            }
        };
        addresses.insert(address, number);
        Ok(number)
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
        depth_stencil: wanted.depth_format.map(|format| depth_stencil(format, state)),
        multisample: wgpu::MultisampleState { count: wanted.samples, ..Default::default() },
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

fn depth_stencil(format: TextureFormat, state: &DrawState) -> wgpu::DepthStencilState {
    let stencil = state.stencil.map_or_else(wgpu::StencilState::default, |stencil| wgpu::StencilState {
        front: stencil.front,
        back: stencil.back,
        read_mask: stencil.read_mask.into(),
        write_mask: stencil.write_mask.into(),
    });
    wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(state.depth_write),
        depth_compare: Some(state.depth_compare),
        stencil,
        bias: wgpu::DepthBiasState {
            constant: state.depth_bias,
            slope_scale: state.depth_bias as f32 * SLOPE_OF_ROUNDING_PX,
            clamp: 0.0,
        },
    }
}
