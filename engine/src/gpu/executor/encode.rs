//! Recording one group of passes.

use std::collections::HashMap;
use std::sync::Arc;

use wgpu::TextureFormat;

use super::super::GpuError;
use super::super::groups::{PassGroup, place_of};
use super::super::materials::{FEATURE_FLAGS, MASKED, SURFACE_FUNCTION, features};
use super::super::meshes::GpuMesh;
use super::super::pipelines::{Culling, Wanted};
use super::attachments::{
    binding_view, color_attachment, color_views, depth_attachment, layer_view, partial_clears,
};
use super::scene::Scene;
use super::surface::{Surface, draw_kinds};
use super::{Executor, GpuSlot};
use crate::plan::{
    Antialias, Binding, BlendState, CompareFunction, Draw, FactorAt, Geometry, Pass, PulledStyle, Shader,
    SlotId, SurfaceStyle,
};
use crate::scene::{Instance, Material};

/// The flags of surface_shade for what a draw reads, by binding number (the depth of samples is number 3, weights of
/// shadows number 7), and at numbers that no binding has: whether a visibility has one channel, whether any light has
/// smooth terminators, whether any factor holds own shadows, whether there is one factor only. What is drawn only behind
/// the nearest transparent surface reads its depth at number 9.
const READ_FLAGS: [&str; 11] = [
    "COUNTS",
    "MASK",
    "VISIBILITY",
    "MULTISAMPLED",
    "ONE_CHANNEL",
    "SMOOTH_TERMINATOR",
    "OWN_SHADOW",
    "TINTED",
    "ONE_FACTOR",
    "FARTHER",
    "LIGHT_TILES",
];

/// The one of [`READ_FLAGS`] that leaves out lights which reach nothing of a pixel's tile.
const LIGHT_TILES: u32 = 1 << 10;

/// Those of [`READ_FLAGS`] that say where factors are.
const FACTOR_FLAGS: u32 = 0b111;

/// The one of [`FACTOR_FLAGS`] for a factor that is there, none for a light that is always lit.
fn factor_flag(factor: FactorAt) -> u32 {
    match factor {
        FactorAt::Lit | FactorAt::Darkening => 0,
        FactorAt::Counts => 1,
        FactorAt::MaskBit(_) => 1 << 1,
        FactorAt::Visibility(_) => 1 << 2,
    }
}

/// What one draw is recorded with.
struct Recording<'a> {
    scene: &'a Scene<'a>,
    group: &'a PassGroup,
    /// The render pass's colour formats.
    formats: &'a [TextureFormat],
    depth_format: Option<TextureFormat>,
    /// Samples of a pixel in all attachments.
    samples: u32,
    pass: &'a Pass,
    draw: &'a Draw,
}

/// Bind groups made for this group of passes, by what they hold.
type DrawGroups = HashMap<(Vec<(u32, Binding)>, Option<(u64, u32)>), wgpu::BindGroup>;

impl Executor {
    /// Records one group as one render pass.
    ///
    /// # Errors
    /// What is wrong with a shader or its pipeline.
    pub(super) fn encode_group(
        &mut self,
        scene: &Scene<'_>,
        group: &PassGroup,
        timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<(), GpuError> {
        let passes = &scene.plan.passes[group.passes.clone()];
        let views: Vec<_> = group.colors.iter().filter_map(|color| color_views(scene, color)).collect();
        let color_attachments: Vec<_> = group
            .colors
            .iter()
            .zip(&views)
            .map(|(color, views)| Some(color_attachment(color, views)))
            .collect();
        let depth_view = group.depth.as_ref().and_then(|depth| layer_view(scene, depth.slot, depth.layer));
        let depth_stencil_attachment =
            group.depth.as_ref().zip(depth_view.as_ref()).map(|(depth, view)| depth_attachment(depth, view));
        let label = passes.first().map(|pass| pass.name.as_str());
        let mut render = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label,
            color_attachments: &color_attachments,
            depth_stencil_attachment,
            timestamp_writes,
            occlusion_query_set: None,
            multiview_mask: None,
        });
        render.set_bind_group(0, scene.frame_group, &[]);
        let formats: Vec<_> = group.colors.iter().map(|color| scene.format(color.slot)).collect();
        let mut draw_groups = DrawGroups::new();
        let clears = partial_clears(&group.colors)?;
        for pass in clears.iter().chain(passes) {
            let first = pass.colors.first().map(|c| c.slot).or(pass.depth.as_ref().map(|d| d.slot));
            let size = first.and_then(|slot| scene.texture(slot)).map(|t| [t.width(), t.height()]);
            let whole = size.map(|[w, h]| [0, 0, w, h]).unwrap_or_default();
            for draw in &pass.draws {
                let [x, y, width, height] = draw.scissor_px.unwrap_or(whole);
                if width == 0 || height == 0 {
                    continue;
                }
                render.set_scissor_rect(x, y, width, height);
                let [x, y, width, height] = draw.state.viewport_px.unwrap_or(whole).map(|px| px as f32);
                render.set_viewport(x, y, width, height, 0.0, 1.0);
                if let Some(stencil) = draw.state.stencil {
                    render.set_stencil_reference(stencil.reference.into());
                }
                let [r, g, b, a] = draw.state.blend_constant;
                render.set_blend_constant(wgpu::Color { r, g, b, a });
                let recording = Recording {
                    scene,
                    group,
                    formats: &formats,
                    depth_format: group.depth.as_ref().map(|depth| scene.format(depth.slot)),
                    samples: first.map_or(1, |slot| scene.plan.slot(slot).samples()),
                    pass,
                    draw,
                };
                self.encode_draw(&recording, &mut draw_groups, &mut render)?;
            }
        }
        Ok(())
    }

    fn encode_draw(
        &mut self,
        recording: &Recording<'_>,
        groups: &mut DrawGroups,
        render: &mut wgpu::RenderPass<'_>,
    ) -> Result<(), GpuError> {
        let Recording { scene, draw, .. } = *recording;
        match &draw.geometry {
            Geometry::Surfaces { style, parts, .. } => {
                for (index, part) in parts {
                    self.encode_surface(recording, (*style, *index, *part), groups, render)?;
                }
            }
            Geometry::PulledSurfaces { shader, style, parts, .. } => {
                for (index, part) in parts {
                    self.encode_pulled(recording, shader, (*style, *index, *part), groups, render)?;
                }
            }
            Geometry::Indexed { shader, instance, indices, first, count, record } => {
                let mesh = &scene.snapshot.instances[*instance as usize];
                self.set_pipeline(recording, shader, Surface::Technique { indexed: true }, render)?;
                let group = self.draw_group(scene, draw, Some(mesh), None, groups);
                render.set_bind_group(1, &group, &[]);
                draw_indices(scene, (*indices, *first, *count, *record), render);
            }
            Geometry::Numbered { shader, instance, first, count, record } => {
                let mesh = &scene.snapshot.instances[*instance as usize];
                self.set_pipeline(recording, shader, Surface::Technique { indexed: true }, render)?;
                let group = self.draw_group(scene, draw, Some(mesh), None, groups);
                render.set_bind_group(1, &group, &[]);
                render.draw(*first..first + count, *record..record + 1);
            }
            Geometry::IndexedProcedural { shader, indices, first, count, record } => {
                self.set_pipeline(recording, shader, Surface::Technique { indexed: false }, render)?;
                let group = self.draw_group(scene, draw, None, None, groups);
                render.set_bind_group(1, &group, &[]);
                draw_indices(scene, (*indices, *first, *count, *record), render);
            }
            Geometry::Procedural { shader, vertices, instances } => {
                self.set_pipeline(recording, shader, Surface::Technique { indexed: false }, render)?;
                let group = self.draw_group(scene, draw, None, None, groups);
                render.set_bind_group(1, &group, &[]);
                render.draw(0..*vertices, 0..*instances);
            }
        }
        Ok(())
    }

    fn encode_surface(
        &mut self,
        recording: &Recording<'_>,
        (style, index, part): (SurfaceStyle, u32, u32),
        groups: &mut DrawGroups,
        render: &mut wgpu::RenderPass<'_>,
    ) -> Result<(), GpuError> {
        let Recording { scene, draw, .. } = *recording;
        let instance = &scene.snapshot.instances[index as usize];
        let material = &instance.materials[part as usize];
        let triangles = &instance.mesh.data().parts[part as usize].triangles;
        let run = triangles.start * 3..triangles.end * 3;
        let shader = self.surface_shader(scene, (style, draw), instance, material)?;
        let culling = culling_of(instance, material);
        let surface = Surface::Mesh { style, masked: material.cutoff().is_some(), culling };
        self.set_pipeline(recording, &shader, surface, render).map_err(|error| {
            let is_depth = matches!(style, SurfaceStyle::Depth | SurfaceStyle::Before);
            let function = material.surface.as_ref().filter(|_| !is_depth);
            function.map_or(error.clone(), |function| error.of(material, function, &self.gpu))
        })?;
        let group = self.draw_group(scene, draw, Some(instance), None, groups);
        render.set_bind_group(1, &group, &[]);
        let Some(mesh) = self.meshes.get(&instance.mesh) else { return Ok(()) };
        self.set_material(surface, material, render);
        render.set_vertex_buffer(0, mesh.positions.slice(..));
        render.set_vertex_buffer(1, mesh.attributes.slice(..));
        render.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
        render.draw_indexed(run, 0, index..index + 1);
        Ok(())
    }

    fn encode_pulled(
        &mut self,
        recording: &Recording<'_>,
        shader: &Shader,
        (style, index, part): (PulledStyle, u32, u32),
        groups: &mut DrawGroups,
        render: &mut wgpu::RenderPass<'_>,
    ) -> Result<(), GpuError> {
        let Recording { scene, draw, .. } = *recording;
        let instance = &scene.snapshot.instances[index as usize];
        let material = &instance.materials[part as usize];
        let triangles = &instance.mesh.data().parts[part as usize].triangles;
        let surface = Surface::Pulled { style, culling: culling_of(instance, material) };
        self.set_pipeline(recording, shader, surface, render)?;
        let group = self.draw_group(scene, draw, Some(instance), Some(surface), groups);
        render.set_bind_group(1, &group, &[]);
        self.set_material(surface, material, render);
        render.draw(triangles.start * 3..triangles.end * 3, index..index + 1);
        Ok(())
    }

    fn set_material(&self, surface: Surface, material: &Arc<Material>, render: &mut wgpu::RenderPass<'_>) {
        if surface.has_material()
            && let Some(group) = self.materials.get(material)
        {
            render.set_bind_group(2, group, &[]);
        }
    }

    fn set_pipeline(
        &mut self,
        recording: &Recording<'_>,
        shader: &Shader,
        surface: Surface,
        render: &mut wgpu::RenderPass<'_>,
    ) -> Result<(), GpuError> {
        let Recording { scene, group, pass, draw, .. } = *recording;
        // Targets of other passes in the group are left alone.
        let mut targets: Vec<(TextureFormat, Option<BlendState>)> =
            recording.formats.iter().map(|f| (*f, None)).collect();
        for (color, blend) in pass.colors.iter().zip(&draw.state.targets) {
            if let Some(place) = place_of(&group.colors, color) {
                targets[place].1 = *blend;
            }
        }
        let kinds = draw_kinds(scene, draw, surface);
        let wanted = Wanted {
            shader,
            state: &draw.state,
            kinds: &kinds,
            with_material: surface.has_material(),
            input: surface.input(),
            culling: surface.culling(),
            targets,
            depth_format: recording.depth_format,
            samples: recording.samples,
        };
        let Self { gpu, addresses, frame_layout, materials, .. } = self;
        let pipeline = gpu.pipelines().get(gpu, addresses, frame_layout, &materials.layout, &wanted)?;
        render.set_pipeline(&pipeline);
        Ok(())
    }

    /// The engine's own shader for a surface, composed with what the draw reads and the material has.
    fn surface_shader(
        &mut self,
        scene: &Scene<'_>,
        (style, draw): (SurfaceStyle, &Draw),
        instance: &Instance,
        material: &Material,
    ) -> Result<Shader, GpuError> {
        let mut features = features(material, &instance.mesh, scene.snapshot.lights.len());
        if scene.plan.antialias == Antialias::Multisample4
            && draw.state.depth_compare == CompareFunction::Equal
        {
            // The prepass has cut the holes; a fragment whose middle is in one may still have samples beside it.
            features &= !(1 << MASKED);
        }
        let (name, fragment): (&'static str, Option<&'static str>) = match style {
            SurfaceStyle::Depth if material.cutoff().is_some() => ("surface_shade", Some("masked_depth")),
            SurfaceStyle::Depth => ("surface_depth", None),
            SurfaceStyle::Opaque => ("surface_shade", Some("opaque")),
            SurfaceStyle::Blended => ("surface_shade", Some("blended")),
            SurfaceStyle::Tint => ("surface_shade", Some("shine_through")),
            SurfaceStyle::Before => ("surface_before", Some("before")),
        };
        // Depth has nothing to reflect.
        let is_depth = matches!(style, SurfaceStyle::Depth | SurfaceStyle::Before);
        let function = material.surface.as_ref().filter(|_| !is_depth);
        features |= u32::from(function.is_some()) << SURFACE_FUNCTION;
        let mut read: u32 = draw.bindings.iter().map(|(number, _)| 1 << number).sum();
        if function.is_some() {
            // It is asked about every light, whatever arrives.
            read &= !LIGHT_TILES;
        }
        if let [light] = &scene.plan.lights[..] {
            // Where one light's factor is, is known now: the shader need not ask.
            let flags = light.factors().fold(0, |flags, part| flags | factor_flag(part.at));
            read &= !FACTOR_FLAGS | flags;
            read |= u32::from(light.more_factors.is_empty()) << 8;
        }
        // A texture of one channel reads as (r, 0, 0, 1): its one factor is that of all colours.
        let one_channel = |(_, binding): &(u32, Binding)| {
            binding.resource().is_some_and(|slot| scene.format(slot) == TextureFormat::R16Float)
        };
        read |= u32::from(draw.bindings.iter().any(one_channel)) << 4;
        read |= u32::from(scene.plan.lights.iter().any(|light| !light.smooth_terminators.is_empty())) << 5;
        // Where no factor is read, none holds the surface's own shadow.
        let own_shadow = scene.plan.lights.iter().any(|light| light.own_shadow) && read & FACTOR_FLAGS != 0;
        read |= u32::from(own_shadow) << 6;
        let key = (style, read, features, function.cloned());
        if let Some(shader) = self.surface_shaders.get(&key) {
            return Ok(shader.clone());
        }
        let read_flags = READ_FLAGS.iter().enumerate().filter(|(bit, _)| read >> bit & 1 == 1);
        let has_flags = FEATURE_FLAGS.iter().enumerate().filter(|(bit, _)| features >> bit & 1 == 1);
        let flags: Vec<&str> = read_flags.chain(has_flags).map(|(_, flag)| *flag).collect();
        let mut shader = Shader::composed(name, &flags, "vertex", fragment)?;
        if let Some(function) = function {
            shader.name = format!("{name} by '{}' {}", function.name(), flags.join(" ")).into();
            shader.source = function.appended_to(shader.source.to_string()).into();
        }
        self.surface_shaders.insert(key, shader.clone());
        Ok(shader)
    }

    /// Group 1: the mesh's own buffers where the geometry brings them, then the draw's bindings.
    fn draw_group(
        &mut self,
        scene: &Scene<'_>,
        draw: &Draw,
        instance: Option<&Instance>,
        pulled: Option<Surface>,
        groups: &mut DrawGroups,
    ) -> wgpu::BindGroup {
        let brings_positions = pulled.is_some() || draw.geometry.brings_positions();
        let instance = instance.filter(|_| brings_positions);
        let surface = pulled.unwrap_or(Surface::Technique { indexed: instance.is_some() });
        let mesh_id = instance.map(|instance| (instance.mesh.id(), surface.own_bindings()));
        let key = (draw.bindings.clone(), mesh_id);
        if let Some(group) = groups.get(&key) {
            return group.clone();
        }
        let layout = self.gpu.pipelines().layouts.get(&self.gpu, &draw_kinds(scene, draw, surface));
        let mesh: Option<&GpuMesh> = instance.and_then(|instance| self.meshes.get(&instance.mesh));
        let mut entries = Vec::new();
        if let Some(mesh) = mesh {
            entries.push(wgpu::BindGroupEntry { binding: 0, resource: mesh.positions.as_entire_binding() });
            let more = [&mesh.indices, &mesh.attributes].into_iter().zip(1..surface.own_bindings());
            entries.extend(more.map(|(buffer, binding)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            }));
        }
        let samplers: HashMap<CompareFunction, wgpu::Sampler> = draw
            .bindings
            .iter()
            .filter_map(|(_, binding)| match binding {
                Binding::Comparison(compare) => {
                    Some((*compare, self.gpu.pipelines().layouts.comparison(&self.gpu, *compare)))
                }
                _ => None,
            })
            .collect();
        let views: Vec<_> = draw.bindings.iter().map(|(_, binding)| binding_view(scene, binding)).collect();
        for ((number, binding), view) in draw.bindings.iter().zip(&views) {
            let resource = match (binding, binding.resource().map(|slot| &scene.slots[slot.0]), view) {
                (Binding::Comparison(compare), ..) => wgpu::BindingResource::Sampler(&samplers[compare]),
                (_, Some(GpuSlot::Buffer(buffer)), _) => buffer.as_entire_binding(),
                (_, Some(GpuSlot::Texture(_)), Some(view)) => wgpu::BindingResource::TextureView(view),
                _ => continue,
            };
            entries.push(wgpu::BindGroupEntry { binding: *number, resource });
        }
        let group = self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&draw.name),
            layout: &layout,
            entries: &entries,
        });
        groups.insert(key, group.clone());
        group
    }
}

fn culling_of(instance: &Instance, material: &Material) -> Culling {
    match (material.double_sided, instance.world_from_local.matrix3.determinant() < 0.0) {
        (true, _) => Culling::None,
        (false, false) => Culling::Back,
        (false, true) => Culling::BackMirrored,
    }
}

fn draw_indices(
    scene: &Scene<'_>,
    (indices, first, count, record): (SlotId, u32, u32, u32),
    render: &mut wgpu::RenderPass<'_>,
) {
    if let GpuSlot::Buffer(buffer) = &scene.slots[indices.0] {
        render.set_index_buffer(buffer.slice(..), wgpu::IndexFormat::Uint32);
        render.draw_indexed(first..first + count, 0, record..record + 1);
    }
}
