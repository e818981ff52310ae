//! What a frame takes on the GPU, computed before anything is allocated: no buffer or texture beyond the adapter's
//! limits, not more in all than the budget.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use super::super::limits::check_buffer;
use super::super::materials::Materials;
use super::super::meshes::Meshes;
use super::super::readback::padded_bytes;
use super::super::{Gpu, GpuError, InstanceUniform};
use super::{Executor, FrameInputs};
use crate::geometry::Mesh;
use crate::plan::{BufferUsage, FramePlan, Geometry, Slot, SlotKind};
use crate::scene::Material;

/// The sum of what a frame needs, and its largest part.
#[derive(Default)]
struct Need {
    bytes: u64,
    largest: String,
    largest_bytes: u64,
}

impl Need {
    fn add(&mut self, what: String, bytes: u64) {
        self.bytes = self.bytes.saturating_add(bytes);
        if bytes > self.largest_bytes {
            (self.largest, self.largest_bytes) = (what, bytes);
        }
    }
}

impl Executor {
    /// Checks what `plan` needs against limits and budget, and drops what other frames left where both together
    /// would exceed the budget.
    pub(super) fn make_room(&mut self, plan: &FramePlan, inputs: &FrameInputs<'_>) -> Result<(), GpuError> {
        let gpu = &self.gpu;
        let mut need = Need::default();
        for slot in &plan.slots {
            check_slot(gpu, slot)?;
            let bytes = match &slot.kind {
                SlotKind::Image { image } => match inputs.snapshot.images.get(image) {
                    Some(image) => Materials::check(gpu, image)?,
                    None => 0,
                },
                _ => slot.bytes(),
            };
            need.add(format!("'{}'", slot.name), bytes);
        }
        let (meshes, materials) = drawn(plan, inputs);
        for mesh in meshes.values() {
            need.add(format!("mesh '{}'", mesh.name()), Meshes::check(gpu, mesh)?);
        }
        let mut images = HashSet::new();
        for material in materials.values() {
            for (image, srgb) in Materials::images(material, &inputs.snapshot.images) {
                if images.insert((Arc::as_ptr(&image) as usize, srgb)) {
                    need.add(format!("image '{}'", image.name), Materials::check(gpu, &image)?);
                }
            }
        }
        let instances = (inputs.snapshot.instances.len() * size_of::<InstanceUniform>()) as u64;
        check_buffer(gpu, || "the list of instances".into(), BufferUsage::Storage, instances)?;
        need.add("the list of instances".into(), instances);
        for id in inputs.read_back {
            let slot = plan.slot(*id);
            if let SlotKind::Texture { format, size_px, .. } = slot.kind {
                let bytes = padded_bytes(format, size_px).unwrap_or_default();
                let what = || format!("reading back '{}'", slot.name);
                check_buffer(gpu, what, BufferUsage::Index, bytes)?;
                need.add(what(), bytes);
            }
        }
        let budget = gpu.budget_bytes;
        if need.bytes > budget {
            let Need { bytes, largest, largest_bytes } = need;
            return Err(GpuError::Budget { bytes, largest, largest_bytes, budget });
        }
        let kept = self.kept_bytes();
        if need.bytes.saturating_add(kept) > budget {
            // Some of it would serve this frame again; but this frame certainly fits alone.
            self.textures.clear();
            self.kept_textures.clear();
            self.buffers.clear();
            self.meshes.keep_only(&meshes);
            self.materials.clear();
        }
        Ok(())
    }

    /// The bytes of everything that is on the GPU now.
    fn kept_bytes(&self) -> u64 {
        let textures = self.textures.iter().map(|((_, format, size_px, layers, samples), textures)| {
            let (format, size_px, layers, samples) = (*format, *size_px, *layers, *samples);
            let kind = SlotKind::Texture { format, size_px, layers, samples };
            let slot = Slot { name: String::new(), kind, reason: String::new(), kept: None };
            slot.bytes() * textures.len() as u64
        });
        let buffers = self.buffers.values().map(|kept| kept.value.size());
        textures.sum::<u64>()
            + self.kept_textures.bytes()
            + buffers.sum::<u64>()
            + self.meshes.bytes()
            + self.materials.bytes()
    }
}

/// The meshes and materials that the plan's draws name: meshes by id, materials by address.
fn drawn<'a>(
    plan: &FramePlan,
    inputs: &FrameInputs<'a>,
) -> (HashMap<u64, &'a Mesh>, HashMap<usize, &'a Arc<Material>>) {
    let (mut meshes, mut materials) = (HashMap::new(), HashMap::new());
    for draw in plan.passes.iter().flat_map(|pass| &pass.draws) {
        match &draw.geometry {
            Geometry::Surfaces { parts, .. } | Geometry::PulledSurfaces { parts, .. } => {
                for (instance, part) in parts {
                    let instance = &inputs.snapshot.instances[*instance as usize];
                    meshes.insert(instance.mesh.id(), &*instance.mesh);
                    let material = &instance.materials[*part as usize];
                    materials.insert(Arc::as_ptr(material) as usize, material);
                }
            }
            Geometry::Indexed { instance, .. } | Geometry::Numbered { instance, .. } => {
                let mesh = &inputs.snapshot.instances[*instance as usize].mesh;
                meshes.insert(mesh.id(), mesh);
            }
            Geometry::IndexedProcedural { .. } | Geometry::Procedural { .. } => {}
        }
    }
    (meshes, materials)
}

fn check_slot(gpu: &Gpu, slot: &Slot) -> Result<(), GpuError> {
    match &slot.kind {
        SlotKind::Texture { size_px: [width, height], layers, .. } => {
            let (limit, limit_layers) =
                (gpu.limits.max_texture_dimension_2d, gpu.limits.max_texture_array_layers);
            if *width > limit || *height > limit || *layers > limit_layers {
                return Err(GpuError::TextureTooLarge {
                    what: format!("'{}'", slot.name),
                    width: *width,
                    height: *height,
                    layers: *layers,
                    adapter: gpu.name(),
                    limit,
                    limit_layers,
                });
            }
            Ok(())
        }
        SlotKind::Buffer { usage, contents, .. } => {
            check_buffer(gpu, || format!("'{}'", slot.name), *usage, contents.0.len() as u64)
        }
        SlotKind::Image { .. } => Ok(()),
    }
}
