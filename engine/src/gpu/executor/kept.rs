//! Textures whose contents outlive a frame: drawn once for a key, and again only for another.

use std::collections::{HashMap, HashSet};

use super::super::Gpu;
use super::{TextureKey, create_texture};
use crate::plan::{FramePlan, Pass, Slot, SlotId, SlotKind};

/// The kept textures of an executor, by name and shape. Several slots may share both, so that for each there is a list.
#[derive(Debug, Default)]
pub(super) struct KeptTextures {
    textures: HashMap<TextureKey, Vec<KeptTexture>>,
    frame: u64,
}

#[derive(Debug)]
struct KeptTexture {
    texture: wgpu::Texture,
    /// The key of what it holds; `None` while nothing complete is in it.
    holds: Option<u64>,
    /// What it holds when this frame is done; `None` when no pass of the plan writes it.
    will_hold: Option<u64>,
    last_used_frame: u64,
}

impl KeptTextures {
    pub(super) fn begin_frame(&mut self, frame: u64, oldest: u64) {
        self.frame = frame;
        for textures in self.textures.values_mut() {
            textures.retain(|kept| kept.last_used_frame >= oldest);
        }
        self.textures.retain(|_, textures| !textures.is_empty());
    }

    pub(super) fn clear(&mut self) {
        self.textures.clear();
    }

    pub(super) fn bytes(&self) -> u64 {
        let bytes = |((_, format, size_px, layers, samples), textures): (&TextureKey, &Vec<KeptTexture>)| {
            let kind =
                SlotKind::Texture { format: *format, size_px: *size_px, layers: *layers, samples: *samples };
            let slot = Slot { name: String::new(), kind, reason: String::new(), kept: None };
            slot.bytes() * textures.len() as u64
        };
        self.textures.iter().map(bytes).sum()
    }

    /// A texture for each of the plan's slots that is kept: the one that holds its key, else one that this frame has no
    /// other use for, else a new one.
    pub(super) fn textures(&mut self, gpu: &Gpu, plan: &FramePlan) -> Vec<Option<wgpu::Texture>> {
        let mut found: Vec<Option<wgpu::Texture>> = vec![None; plan.slots.len()];
        let written: HashSet<SlotId> = plan.passes.iter().flat_map(|pass| plan.written_by(pass)).collect();
        // Those that are up to date first: none of them is drawn over for another slot.
        for up_to_date in [true, false] {
            for (index, (slot, found)) in plan.slots.iter().zip(&mut found).enumerate() {
                let (None, Some((key, wanted))) = (&found, key_of(slot)) else { continue };
                let (_, format, size_px, layers, samples) = key;
                let textures = self.textures.entry(key).or_default();
                let free = |kept: &&mut KeptTexture| {
                    kept.last_used_frame < self.frame && (!up_to_date || kept.holds == Some(wanted))
                };
                let kept = match textures.iter_mut().find(free) {
                    Some(kept) => kept,
                    None if up_to_date => continue,
                    None => {
                        let texture = create_texture(gpu, slot, (format, size_px, layers, samples));
                        textures.push(KeptTexture {
                            texture,
                            holds: None,
                            will_hold: None,
                            last_used_frame: 0,
                        });
                        let last = textures.len() - 1;
                        &mut textures[last]
                    }
                };
                kept.last_used_frame = self.frame;
                kept.will_hold = written.contains(&SlotId(index)).then_some(wanted);
                *found = Some(kept.texture.clone());
            }
        }
        found
    }

    /// The kept slots of `plan` that are to be drawn, after [`KeptTextures::textures`]. Of slots that a pass writes
    /// together, all are when one is.
    pub(super) fn stale(&self, plan: &FramePlan) -> HashSet<SlotId> {
        let is_stale = |slot: &Slot| {
            key_of(slot).is_some_and(|(key, wanted)| {
                let mut textures = self.textures.get(&key).into_iter().flatten();
                !textures.any(|kept| kept.last_used_frame == self.frame && kept.holds == Some(wanted))
            })
        };
        let slots = plan.slots.iter().enumerate().filter(|(_, slot)| is_stale(slot));
        let mut stale: HashSet<SlotId> = slots.map(|(index, _)| SlotId(index)).collect();
        loop {
            let before = stale.len();
            for pass in &plan.passes {
                if plan.written_by(pass).any(|slot| stale.contains(&slot)) {
                    stale.extend(plan.written_by(pass));
                }
            }
            if stale.len() == before {
                return stale;
            }
        }
    }

    /// After a frame that succeeded: every texture it used holds what was wanted.
    pub(super) fn renewed(&mut self) {
        let textures = self.textures.values_mut().flatten();
        for kept in textures.filter(|kept| kept.last_used_frame == self.frame) {
            kept.holds = kept.will_hold;
        }
    }
}

/// Whether a pass has to run: it writes something that is not kept, or is out of date.
pub(super) fn is_due(plan: &FramePlan, pass: &Pass, stale: &HashSet<SlotId>) -> bool {
    let mut written = plan.written_by(pass).peekable();
    written.peek().is_none() || written.any(|slot| plan.slot(slot).kept.is_none() || stale.contains(&slot))
}

fn key_of(slot: &Slot) -> Option<(TextureKey, u64)> {
    match (&slot.kind, slot.kept) {
        (SlotKind::Texture { format, size_px, layers, samples }, Some(wanted)) => {
            Some(((slot.name.clone(), *format, *size_px, *layers, *samples), wanted))
        }
        _ => None,
    }
}
