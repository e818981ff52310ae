//! Executing a frame plan: it does what the plan says, times it, and copies out what is asked for.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use bytemuck::Zeroable;
use wgpu::TextureFormat;

use super::groups::{PassGroup, group_passes};
use super::materials::{FEW_LIGHTS, MAX_LIGHTS, Materials};
use super::meshes::Meshes;
use super::pipelines::Addresses;
use super::readback::Pending;
use super::{FrameUniform, Gpu, GpuError, InstanceUniform, LightUniform, Pixels};
use crate::plan::{
    BufferUsage, FramePlan, Geometry, LightPlanned, Pass, Shader, Slot, SlotId, SlotKind, SurfaceStyle,
};
use crate::scene::{CameraSnapshot, SceneSnapshot, SurfaceFunction};
use crate::shadow::MAX_SMOOTH_LIGHTS;

use kept::{KeptTextures, is_due};
use timestamps::Timestamps;

mod attachments;
pub(super) mod budget;
mod encode;
mod kept;
mod scene;
mod surface;
mod timestamps;

/// What is timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timing {
    /// Nothing; passes are merged.
    #[default]
    Off,
    /// The whole frame; passes are merged.
    Frame,
    /// Every pass; passes stay apart, which by itself costs a little.
    Passes,
}

/// What a plan is executed with.
#[derive(Clone, Copy, Debug)]
pub struct FrameInputs<'a> {
    /// The scene the plan was made for.
    pub snapshot: &'a SceneSnapshot,
    /// The camera the plan was made for.
    pub camera: &'a CameraSnapshot,
    /// What radiance is multiplied by.
    pub exposure: f32,
    /// Whether radiance is mapped to picture brightness.
    pub tone_map: bool,
    /// What is timed.
    pub timing: Timing,
    /// Slots copied to the CPU when the frame is done.
    pub read_back: &'a [SlotId],
}

/// The time of one pass, or of passes that ran as one.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// The names of the passes, joined by " + ".
    pub name: String,
    /// Which of the plan's passes these are.
    pub passes: Range<usize>,
    /// GPU time in milliseconds.
    pub gpu_ms: f64,
}

/// What came of executing a plan.
#[derive(Clone, Debug, Default)]
pub struct Executed {
    /// The slots asked for, in that order.
    pub pixels: Vec<Pixels>,
    /// The names of the passes that did not run, since what they draw was kept from an earlier frame.
    pub kept: Vec<String>,
    /// GPU times, in order; empty when nothing was timed or the adapter has no timestamps.
    pub times: Vec<PassTime>,
    /// GPU time from the first pass's beginning to the last one's end, in milliseconds.
    pub gpu_ms: Option<f64>,
    /// CPU time until the GPU had all its commands, in milliseconds.
    pub encode_ms: f64,
    /// Bytes on the GPU: slots, meshes, textures.
    pub gpu_bytes: u64,
}

/// Keeps meshes, textures and buffers between frames and executes plans; pipelines it shares with others on its device.
#[derive(Debug)]
pub struct Executor {
    gpu: Gpu,
    addresses: Addresses,
    meshes: Meshes,
    materials: Materials,
    frame_layout: wgpu::BindGroupLayout,
    surface_shaders: HashMap<SurfaceShaderKey, Shader>,
    /// For each key as many as slots of one frame had it.
    textures: HashMap<TextureKey, Vec<Kept<wgpu::Texture>>>,
    kept_textures: KeptTextures,
    buffers: HashMap<(u64, BufferUsage), Kept<wgpu::Buffer>>,
    uploads: u64,
    frame: u64,
}

/// What makes two of the engine's own surface shaders different: style, what the draw reads, what the material has, its
/// own function.
type SurfaceShaderKey = (SurfaceStyle, u32, u32, Option<Arc<SurfaceFunction>>);

/// Textures of equal name, format, size, layers and samples serve one another's slots from frame to frame.
type TextureKey = (String, TextureFormat, [u32; 2], u32, u32);

#[derive(Debug)]
struct Kept<T> {
    value: T,
    last_used_frame: u64,
}

/// Frames after which a buffer or texture no plan named is dropped.
const KEPT_FRAMES: u64 = 4;

/// What a slot is on the GPU during a frame.
enum GpuSlot {
    Texture(wgpu::Texture),
    Buffer(wgpu::Buffer),
}

impl Executor {
    /// An executor on `gpu`.
    pub fn new(gpu: Gpu) -> Self {
        let entry = |binding, ty| wgpu::BindGroupLayoutEntry {
            binding,
            visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
            count: None,
        };
        let storage = wgpu::BufferBindingType::Storage { read_only: true };
        let frame_layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("frame"),
            entries: &[
                entry(0, wgpu::BufferBindingType::Uniform),
                entry(1, storage),
                entry(2, wgpu::BufferBindingType::Uniform),
            ],
        });
        Self {
            addresses: Addresses::default(),
            meshes: Meshes::default(),
            materials: Materials::new(&gpu),
            frame_layout,
            surface_shaders: HashMap::new(),
            textures: HashMap::new(),
            kept_textures: KeptTextures::default(),
            buffers: HashMap::new(),
            uploads: 0,
            frame: 0,
            gpu,
        }
    }

    /// The device it runs on.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// How many buffer slots were uploaded since the executor was made: in a frame in which nothing moved, none.
    pub fn uploads(&self) -> u64 {
        self.uploads
    }

    /// Executes `plan` and waits for it.
    ///
    /// # Errors
    /// What exceeds a limit or the budget, before anything is allocated; what is wrong with a shader; what the device
    /// reports, with the adapter's name. An executor whose device was lost is of no use any more.
    pub fn execute(&mut self, plan: &FramePlan, inputs: &FrameInputs<'_>) -> Result<Executed, GpuError> {
        let start = Instant::now();
        let (count, limit) = (inputs.snapshot.lights.len(), MAX_LIGHTS);
        if count > limit {
            return Err(GpuError::TooManyLights { count, limit });
        }
        self.gpu.check()?;
        self.begin_frame();
        self.make_room(plan, inputs)?;
        let gpu = self.gpu.clone();
        let executed = gpu.checked(|| self.execute_within_budget(plan, inputs, start));
        if executed.is_ok() {
            self.kept_textures.renewed();
        } else {
            // What was allocated for a frame that failed may be invalid, and half drawn.
            self.textures.clear();
            self.kept_textures.clear();
            self.buffers.clear();
        }
        executed
    }

    fn execute_within_budget(
        &mut self,
        plan: &FramePlan,
        inputs: &FrameInputs<'_>,
        start: Instant,
    ) -> Result<Executed, GpuError> {
        self.upload_scene(plan, inputs);
        let slots = self.slots(plan, inputs.snapshot);
        let frame_group = self.frame_group(plan, inputs);
        let stale = self.kept_textures.stale(plan);
        let runs = |pass: &Pass| is_due(plan, pass, &stale);
        let groups = group_passes(plan, inputs.timing != Timing::Passes, runs);
        let stamps = match inputs.timing {
            Timing::Off => None,
            _ => Timestamps::new(&self.gpu, groups.len() as u32),
        };

        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let scene =
            scene::Scene { plan, snapshot: inputs.snapshot, slots: &slots, frame_group: &frame_group };
        for (index, group) in groups.iter().enumerate() {
            let writes = stamps.as_ref().map(|stamps| stamps.around(index as u32));
            self.encode_group(&scene, group, writes, &mut encoder)?;
        }
        if let Some(stamps) = &stamps {
            stamps.resolve(&self.gpu, &mut encoder);
        }
        let mut copies = Vec::new();
        for slot in inputs.read_back {
            if let GpuSlot::Texture(texture) = &slots[slot.0] {
                copies.push(Pending::record(&self.gpu, &mut encoder, texture)?);
            }
        }
        self.gpu.queue.submit([encoder.finish()]);
        let encode_ms = start.elapsed().as_secs_f64() * 1e3;
        self.gpu.wait()?;

        let mut executed = Executed {
            gpu_bytes: plan.bytes() + self.meshes.bytes() + self.materials.bytes(),
            encode_ms,
            kept: plan.passes.iter().filter(|pass| !runs(pass)).map(|pass| pass.name.clone()).collect(),
            ..Executed::default()
        };
        for copy in copies {
            executed.pixels.push(copy.finish(&self.gpu)?);
        }
        if let Some(stamps) = stamps {
            let times = stamps.read(&self.gpu)?;
            executed.gpu_ms = times.frame_ms;
            let timed = groups.iter().zip(times.passes_ms);
            executed.times = timed.map(|(group, gpu_ms)| pass_time(plan, group, gpu_ms)).collect();
        }
        Ok(executed)
    }

    fn begin_frame(&mut self) {
        self.frame += 1;
        self.meshes.begin_frame();
        self.materials.begin_frame();
        self.addresses.clear();
        let oldest = self.frame.saturating_sub(KEPT_FRAMES);
        for textures in self.textures.values_mut() {
            textures.retain(|kept| kept.last_used_frame >= oldest);
        }
        self.textures.retain(|_, textures| !textures.is_empty());
        self.kept_textures.begin_frame(self.frame, oldest);
        self.buffers.retain(|_, kept| kept.last_used_frame >= oldest);
    }

    /// Uploads the meshes and materials that the plan's draws name.
    fn upload_scene(&mut self, plan: &FramePlan, inputs: &FrameInputs<'_>) {
        for draw in plan.passes.iter().flat_map(|pass| &pass.draws) {
            match &draw.geometry {
                Geometry::Surfaces { parts, .. } | Geometry::PulledSurfaces { parts, .. } => {
                    for (instance, part) in parts {
                        let instance = &inputs.snapshot.instances[*instance as usize];
                        self.meshes.upload(&self.gpu, &instance.mesh);
                        let material = &instance.materials[*part as usize];
                        self.materials.upload(&self.gpu, material, &inputs.snapshot.images);
                    }
                }
                Geometry::Indexed { instance, .. } | Geometry::Numbered { instance, .. } => {
                    self.meshes.upload(&self.gpu, &inputs.snapshot.instances[*instance as usize].mesh);
                }
                Geometry::IndexedProcedural { .. } | Geometry::Procedural { .. } => {}
            }
        }
    }

    /// Textures and buffers of the plan: last frame's where they are the same.
    fn slots(&mut self, plan: &FramePlan, snapshot: &SceneSnapshot) -> Vec<GpuSlot> {
        let frame = self.frame;
        let mut slots = Vec::with_capacity(plan.slots.len());
        let kept_textures = self.kept_textures.textures(&self.gpu, plan);
        for (slot, kept_texture) in plan.slots.iter().zip(kept_textures) {
            if let Some(texture) = kept_texture {
                slots.push(GpuSlot::Texture(texture));
                continue;
            }
            slots.push(match &slot.kind {
                SlotKind::Texture { format, size_px, layers, samples } => {
                    let key = (slot.name.clone(), *format, *size_px, *layers, *samples);
                    let textures = self.textures.entry(key).or_default();
                    // Every slot has a texture of its own, whatever others are called.
                    let free = textures.iter_mut().find(|kept| kept.last_used_frame < frame);
                    GpuSlot::Texture(match free {
                        Some(kept) => {
                            kept.last_used_frame = frame;
                            kept.value.clone()
                        }
                        None => {
                            let shape = (*format, *size_px, *layers, *samples);
                            let value = create_texture(&self.gpu, slot, shape);
                            textures.push(Kept { value: value.clone(), last_used_frame: frame });
                            value
                        }
                    })
                }
                SlotKind::Buffer { usage, revision_key, contents } => {
                    let kept = self.buffers.entry((*revision_key, *usage)).or_insert_with(|| {
                        self.uploads += 1;
                        let flag = match usage {
                            BufferUsage::Storage => wgpu::BufferUsages::STORAGE,
                            BufferUsage::Index => wgpu::BufferUsages::INDEX,
                        };
                        Kept { value: self.gpu.buffer(&slot.name, flag, &contents.0), last_used_frame: frame }
                    });
                    kept.last_used_frame = frame;
                    GpuSlot::Buffer(kept.value.clone())
                }
                SlotKind::Image { image } => {
                    GpuSlot::Texture(self.materials.base_color_image(&self.gpu, snapshot.images.get(image)))
                }
            });
        }
        slots
    }

    /// Group 0: the frame, the instances and the lights as this camera sees them.
    fn frame_group(&self, plan: &FramePlan, inputs: &FrameInputs<'_>) -> wgpu::BindGroup {
        let FrameInputs { snapshot, camera, exposure, tone_map, .. } = *inputs;
        let view_from_world = camera.world_from_view.inverse();
        let mut first_triangle = 0;
        let mut instances = Vec::with_capacity(snapshot.instances.len());
        for (index, instance) in snapshot.instances.iter().enumerate() {
            let ends_smooth = |light: &LightPlanned| light.smooth_terminators.contains(&(index as u32));
            let smooth = plan.lights.iter().zip(0..MAX_SMOOTH_LIGHTS).filter(|(light, _)| ends_smooth(light));
            let smooth = smooth.fold(0, |bits, (_, light)| bits | 1 << light);
            instances.push(InstanceUniform::new(instance, &view_from_world, first_triangle, smooth));
            first_triangle += instance.mesh.triangle_count() as u32;
        }
        let mut lights: Vec<_> = snapshot
            .lights
            .iter()
            .zip(&plan.lights)
            .map(|(light, planned)| LightUniform::new(light, planned, &view_from_world, exposure))
            .collect();
        let capacity = if lights.len() <= FEW_LIGHTS { FEW_LIGHTS } else { MAX_LIGHTS };
        lights.resize(capacity, LightUniform::zeroed());
        let frame = FrameUniform {
            shadowed_px: plan.shadowed_px,
            ..FrameUniform::new(snapshot, camera, plan.size_px, exposure, tone_map)
        };
        let gpu = &self.gpu;
        let buffers = [
            gpu.buffer("frame", wgpu::BufferUsages::UNIFORM, bytemuck::bytes_of(&frame)),
            gpu.buffer(
                "instances",
                wgpu::BufferUsages::STORAGE,
                &at_least(bytemuck::cast_slice(&instances), 112),
            ),
            gpu.buffer("lights", wgpu::BufferUsages::UNIFORM, bytemuck::cast_slice(&lights)),
        ];
        let entries: Vec<_> = buffers
            .iter()
            .zip(0..)
            .map(|(buffer, binding)| wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() })
            .collect();
        gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &self.frame_layout,
            entries: &entries,
        })
    }
}

/// The time of passes that ran as one.
fn pass_time(plan: &FramePlan, group: &PassGroup, gpu_ms: f64) -> PassTime {
    let names: Vec<&str> = plan.passes[group.passes.clone()].iter().map(|pass| pass.name.as_str()).collect();
    PassTime { name: names.join(" + "), passes: group.passes.clone(), gpu_ms }
}

/// A texture of (format, width and height in pixels, layers, samples).
fn create_texture(
    gpu: &Gpu,
    slot: &Slot,
    (format, [width, height], layers, samples): (TextureFormat, [u32; 2], u32, u32),
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(&slot.name),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
        mip_level_count: 1,
        sample_count: samples,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT
            | wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    })
}

/// `bytes`, or `size` zeros when there are none: an empty array cannot be bound.
fn at_least(bytes: &[u8], size: usize) -> std::borrow::Cow<'_, [u8]> {
    if bytes.is_empty() { vec![0; size].into() } else { bytes.into() }
}
