//! What must hold for a plan to make sense. A plan that fails here would fail, or silently err, on the GPU.

use std::collections::{HashMap, HashSet};

use thiserror::Error;

use super::{
    Access, Binding, ColorTarget, Draw, FactorAt, FramePlan, Geometry, LightPlanned, Load, Pass, Slot,
    SlotId, SlotKind, StencilOperation,
};

/// Why a plan is not valid.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum PlanError {
    #[error("pass '{pass}' names slot {slot}, but the plan has {count} slots")]
    NoSuchSlot { pass: String, slot: usize, count: usize },
    #[error("pass '{pass}' reads '{slot}' before anything wrote it")]
    ReadBeforeWrite { pass: String, slot: String },
    #[error("pass '{pass}' keeps the contents of '{slot}', which nothing cleared")]
    MissingClear { pass: String, slot: String },
    #[error("pass '{pass}' uses '{slot}' as {needed}, but it is {found}")]
    WrongKind { pass: String, slot: String, needed: &'static str, found: String },
    #[error(
        "pass '{pass}' attaches '{slot}' of {samples} samples beside '{other}' of {other_samples}; all attachments of a pass have as many"
    )]
    Samples { pass: String, slot: String, samples: u32, other: String, other_samples: u32 },
    #[error(
        "pass '{pass}' resolves '{from}' into '{into}': needed are several samples, one sample, one layer, one format and one size"
    )]
    Resolve { pass: String, from: String, into: String },
    #[error("pass '{pass}' reads '{slot}' while writing it")]
    ReadWhileWritten { pass: String, slot: String },
    #[error(
        "pass '{pass}' writes '{kept}', which is kept between frames, and '{other}', which is not: it would be missing where the pass does not run"
    )]
    KeptBesideOthers { pass: String, kept: String, other: String },
    #[error("'{slot}' is kept between frames, but is {found}: only textures of one sample are kept")]
    NotKeepable { slot: String, found: String },
    #[error("draw '{draw}' of pass '{pass}' states {given} colour targets, the pass has {needed}")]
    TargetCount { pass: String, draw: String, given: usize, needed: usize },
    #[error(
        "draw '{draw}' of pass '{pass}' writes {aspect}, which the pass attaches read-only or not at all"
    )]
    NotWritable { pass: String, draw: String, aspect: &'static str },
    #[error("draw '{draw}' of pass '{pass}' takes indices {first}..{end} of '{slot}', which has {count}")]
    IndexRange { pass: String, draw: String, slot: String, first: u32, end: u64, count: u64 },
    #[error(
        "draw '{draw}' of pass '{pass}' is confined to {scissor:?}, which leaves the {width}x{height} target"
    )]
    ScissorOutside { pass: String, draw: String, scissor: [u32; 4], width: u32, height: u32 },
    #[error(
        "draw '{draw}' of pass '{pass}' is spread over {viewport:?}, which leaves the {width}x{height} target"
    )]
    ViewportOutside { pass: String, draw: String, viewport: [u32; 4], width: u32, height: u32 },
    #[error("pass '{pass}' clears '{slot}' within {rectangle:?}, which leaves the {width}x{height} target")]
    ClearOutside { pass: String, slot: String, rectangle: [u32; 4], width: u32, height: u32 },
    #[error("the factor of light '{light}' is expected in {place}, which no pass writes")]
    FactorNeverWritten { light: String, place: String },
    #[error("nothing writes '{slot}', which the frame is to deliver")]
    NeverWritten { slot: String },
    #[error(
        "light '{light}' is shaded from the stencil, in which pass '{pass}' counts or clears for another"
    )]
    StencilShared { light: String, pass: String },
    #[error("{lights} lights have bits in the light mask, but {resolves} passes resolve counts into it")]
    Unresolved { lights: usize, resolves: usize },
    #[error(
        "counts of pass '{pass}' within {counted:?} are resolved only within {resolved:?}: they would leak into the next light"
    )]
    CountsLeak { pass: String, counted: [u32; 4], resolved: [u32; 4] },
}

impl FramePlan {
    /// Checks the whole plan.
    ///
    /// # Errors
    /// The first thing found wrong, naming pass and slot.
    pub fn validate(&self) -> Result<(), PlanError> {
        if let Some(slot) = self.slots.iter().find(|slot| slot.kept.is_some() && !is_keepable(slot)) {
            return Err(PlanError::NotKeepable { slot: slot.name.clone(), found: slot.to_string() });
        }
        let mut written: HashSet<(SlotId, u32)> = HashSet::new();
        let mut stencils_cleared: HashSet<SlotId> = HashSet::new();
        for pass in &self.passes {
            for color in &pass.colors {
                self.check_color(pass, color, &written)?;
            }
            if let Some(depth) = &pass.depth {
                let slot = self.slot_of(pass, depth.slot)?;
                let stencil_format = format_of(slot).is_some_and(|f| f.has_stencil_aspect());
                let depth_format = format_of(slot).is_some_and(|f| f.has_depth_aspect());
                let stencil_alone = stencil_format && !depth_format && depth.depth == Access::ReadOnly;
                let layers = if let SlotKind::Texture { layers, .. } = slot.kind { layers } else { 1 };
                let has_aspects =
                    (depth_format || stencil_alone) && depth.stencil.is_some() == stencil_format;
                if !has_aspects || depth.layer >= layers {
                    return Err(wrong_kind(
                        pass,
                        slot,
                        "a depth attachment with the stated stencil and layer",
                    ));
                }
                let clears = matches!(depth.depth, Access::Clear(_)) || stencil_alone;
                if !clears && !written.contains(&(depth.slot, depth.layer)) {
                    return Err(PlanError::MissingClear { pass: pass.name.clone(), slot: slot.name.clone() });
                }
                match depth.stencil {
                    Some(Access::Clear(_)) => {
                        stencils_cleared.insert(depth.slot);
                    }
                    Some(_) if !stencils_cleared.contains(&depth.slot) => {
                        let slot = format!("{} (stencil)", slot.name);
                        return Err(PlanError::MissingClear { pass: pass.name.clone(), slot });
                    }
                    _ => {}
                }
            }
            self.check_samples(pass)?;
            self.check_kept(pass)?;
            self.check_draws(pass, &written)?;
            written.extend(pass.colors.iter().map(|color| (color.slot, color.layer)));
            written.extend(pass.colors.iter().filter_map(|color| Some((color.resolve?, 0))));
            written.extend(pass.depth.iter().map(|depth| (depth.slot, depth.layer)));
        }
        self.check_factors(&written)?;
        self.check_counts_resolved()
    }

    fn slot_of(&self, pass: &Pass, id: SlotId) -> Result<&Slot, PlanError> {
        self.slots.get(id.0).ok_or_else(|| PlanError::NoSuchSlot {
            pass: pass.name.clone(),
            slot: id.0,
            count: self.slots.len(),
        })
    }

    fn check_color(
        &self,
        pass: &Pass,
        color: &ColorTarget,
        written: &HashSet<(SlotId, u32)>,
    ) -> Result<(), PlanError> {
        let slot = self.slot_of(pass, color.slot)?;
        match &slot.kind {
            SlotKind::Texture { format, layers, .. }
                if !format.is_depth_stencil_format() && color.layer < *layers => {}
            _ => return Err(wrong_kind(pass, slot, "a colour attachment with that layer")),
        }
        if let Load::ClearWithin(_, rectangle) = color.load {
            let [width, height] = self.target_size_px(pass);
            if !contains([0, 0, width, height], rectangle) {
                let (pass, slot) = (pass.name.clone(), slot.name.clone());
                return Err(PlanError::ClearOutside { pass, slot, rectangle, width, height });
            }
        }
        if color.load == Load::Keep && !written.contains(&(color.slot, color.layer)) {
            return Err(PlanError::MissingClear { pass: pass.name.clone(), slot: slot.name.clone() });
        }
        Ok(())
    }

    /// All attachments of a pass have as many samples; what is resolved has several, and goes where there is one.
    fn check_samples(&self, pass: &Pass) -> Result<(), PlanError> {
        let attached = pass.colors.iter().map(|c| c.slot).chain(pass.depth.iter().map(|d| d.slot));
        let slots: Vec<&Slot> = attached.map(|id| self.slot_of(pass, id)).collect::<Result<_, _>>()?;
        for pair in slots.windows(2) {
            let (other_samples, samples) = (pair[0].samples(), pair[1].samples());
            if samples != other_samples {
                let (slot, other) = (pair[1].name.clone(), pair[0].name.clone());
                return Err(PlanError::Samples {
                    pass: pass.name.clone(),
                    slot,
                    samples,
                    other,
                    other_samples,
                });
            }
        }
        for color in &pass.colors {
            let Some(resolve) = color.resolve else { continue };
            let (from, into) = (self.slot_of(pass, color.slot)?, self.slot_of(pass, resolve)?);
            let fits = match (&from.kind, &into.kind) {
                (
                    SlotKind::Texture { format, size_px, samples, .. },
                    SlotKind::Texture { format: f, size_px: s, layers: 1, samples: 1 },
                ) => *samples > 1 && format == f && size_px == s,
                _ => false,
            };
            if !fits {
                let (from, into) = (from.to_string(), into.to_string());
                return Err(PlanError::Resolve { pass: pass.name.clone(), from, into });
            }
        }
        Ok(())
    }

    /// A pass that does not run every frame leaves behind nothing that every frame needs.
    fn check_kept(&self, pass: &Pass) -> Result<(), PlanError> {
        let slots: Vec<&Slot> =
            self.written_by(pass).map(|id| self.slot_of(pass, id)).collect::<Result<_, _>>()?;
        let kept = slots.iter().find(|slot| slot.kept.is_some());
        match (kept, slots.iter().find(|slot| slot.kept.is_none())) {
            (Some(kept), Some(other)) => {
                let (kept, other) = (kept.name.clone(), other.name.clone());
                Err(PlanError::KeptBesideOthers { pass: pass.name.clone(), kept, other })
            }
            _ => Ok(()),
        }
    }

    fn check_draws(&self, pass: &Pass, written: &HashSet<(SlotId, u32)>) -> Result<(), PlanError> {
        let depth_writable = pass.depth.as_ref().is_some_and(|d| d.depth != Access::ReadOnly);
        let stencil_writable =
            pass.depth.as_ref().is_some_and(|d| d.stencil.is_some_and(|stencil| stencil != Access::ReadOnly));
        for draw in &pass.draws {
            let (pass_name, draw_name) = (|| pass.name.clone(), || draw.name.clone());
            if draw.state.targets.len() != pass.colors.len() {
                return Err(PlanError::TargetCount {
                    pass: pass_name(),
                    draw: draw_name(),
                    given: draw.state.targets.len(),
                    needed: pass.colors.len(),
                });
            }
            let not_writable =
                |aspect| PlanError::NotWritable { pass: pass_name(), draw: draw_name(), aspect };
            if draw.state.depth_write && !depth_writable {
                return Err(not_writable("depth"));
            }
            if draw.state.stencil.is_some_and(|s| s.write_mask != 0 && changes(&s)) && !stencil_writable {
                return Err(not_writable("the stencil"));
            }
            for (_, binding) in &draw.bindings {
                self.check_binding(pass, binding, written)?;
            }
            if let Geometry::Indexed { indices, first, count, .. }
            | Geometry::IndexedProcedural { indices, first, count, .. } = draw.geometry
            {
                let slot = self.slot_of(pass, indices)?;
                let SlotKind::Buffer { contents, .. } = &slot.kind else {
                    return Err(wrong_kind(pass, slot, "an index buffer"));
                };
                let (end, held) = (u64::from(first) + u64::from(count), contents.0.len() as u64 / 4);
                if end > held {
                    let slot = slot.name.clone();
                    return Err(PlanError::IndexRange {
                        pass: pass_name(),
                        draw: draw_name(),
                        slot,
                        first,
                        end,
                        count: held,
                    });
                }
            }
            let [width, height] = self.target_size_px(pass);
            let outside = |rectangle: &[u32; 4]| !contains([0, 0, width, height], *rectangle);
            if let Some(scissor) = draw.scissor_px.filter(outside) {
                let (pass, draw) = (pass_name(), draw_name());
                return Err(PlanError::ScissorOutside { pass, draw, scissor, width, height });
            }
            if let Some(viewport) = draw.state.viewport_px.filter(outside) {
                let (pass, draw) = (pass_name(), draw_name());
                return Err(PlanError::ViewportOutside { pass, draw, viewport, width, height });
            }
        }
        Ok(())
    }

    fn check_binding(
        &self,
        pass: &Pass,
        binding: &Binding,
        written: &HashSet<(SlotId, u32)>,
    ) -> Result<(), PlanError> {
        let Some(id) = binding.resource() else { return Ok(()) };
        let slot = self.slot_of(pass, id)?;
        match (&slot.kind, binding) {
            (SlotKind::Buffer { .. }, Binding::Storage(_))
            | (SlotKind::Image { .. }, Binding::Texture(_)) => {
                return Ok(());
            }
            (SlotKind::Texture { .. }, Binding::Texture(_)) => {}
            // Multisampled textures have no array views.
            (SlotKind::Texture { samples: 1, .. }, Binding::TextureArray(_)) => {}
            (SlotKind::Texture { layers, samples: 1, .. }, Binding::TextureLayer(_, layer))
                if layer < layers => {}
            (SlotKind::Texture { format, .. }, Binding::StencilOf(_)) if format.has_stencil_aspect() => {}
            _ => return Err(wrong_kind(pass, slot, "what its binding says")),
        }
        if !written.iter().any(|(written, _)| *written == id) {
            return Err(PlanError::ReadBeforeWrite { pass: pass.name.clone(), slot: slot.name.clone() });
        }
        let written_here = pass.colors.iter().any(|color| color.slot == id || color.resolve == Some(id))
            || pass.depth.as_ref().is_some_and(|depth| {
                depth.slot == id
                    && (depth.depth != Access::ReadOnly
                        || depth.stencil.is_some_and(|s| s != Access::ReadOnly))
            });
        if written_here {
            return Err(PlanError::ReadWhileWritten { pass: pass.name.clone(), slot: slot.name.clone() });
        }
        Ok(())
    }

    /// The size of what a pass draws into.
    fn target_size_px(&self, pass: &Pass) -> [u32; 2] {
        let attached =
            pass.colors.first().map(|color| color.slot).or(pass.depth.as_ref().map(|depth| depth.slot));
        match attached.and_then(|slot| self.slots.get(slot.0)).map(|slot| &slot.kind) {
            Some(SlotKind::Texture { size_px, .. }) => *size_px,
            _ => self.size_px,
        }
    }

    fn check_factors(&self, written: &HashSet<(SlotId, u32)>) -> Result<(), PlanError> {
        let delivered = [Some(self.picture), self.visible_triangles].into_iter().flatten();
        for slot in delivered.chain(self.layer_triangles.iter().copied()) {
            if !written.contains(&(slot, 0)) {
                return Err(PlanError::NeverWritten { slot: self.slots[slot.0].name.clone() });
            }
        }
        let is_written =
            |slot: Option<SlotId>, layer: u32| slot.is_some_and(|slot| written.contains(&(slot, layer)));
        for light in &self.lights {
            let never = |place: String| PlanError::FactorNeverWritten { light: light.name.clone(), place };
            let images = light.factor_image.iter().chain(&light.layer_factor_images);
            if images.into_iter().any(|slot| !written.contains(&(*slot, 0))) {
                return Err(never("its factor image".into()));
            }
            let counted = self.passes.iter().any(|pass| self.counts(pass));
            for part in light.factors() {
                match part.at {
                    FactorAt::Counts if !counted => return Err(never("the stencil".into())),
                    FactorAt::Darkening
                        if !counted && !written.iter().any(|(slot, _)| Some(*slot) == self.visibility) =>
                    {
                        return Err(never("the stencil or the visibility array".into()));
                    }
                    FactorAt::MaskBit(bit) if !is_written(self.light_mask, bit / 32) => {
                        return Err(never(format!("bit {bit} of the light mask")));
                    }
                    FactorAt::Visibility(layer) if !is_written(self.visibility, layer) => {
                        return Err(never(format!("layer {layer} of the visibility array")));
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Whether a pass counts beside the depth of what is seen: a stencil by itself is a technique's own.
    fn counts(&self, pass: &Pass) -> bool {
        let beside_depth = pass.depth.as_ref().and_then(|depth| format_of(self.slots.get(depth.slot.0)?));
        beside_depth.is_some_and(|format| format.has_depth_aspect()) && writes_stencil(pass)
    }

    /// A draw that sets counts back must cover every draw that counted since the last one.
    fn check_counts_resolved(&self) -> Result<(), PlanError> {
        let resolves = self.passes.iter().filter(|pass| pass.draws.iter().any(frees_stencil)).count();
        let factors = self.lights.iter().flat_map(LightPlanned::factors);
        let in_mask = factors.filter(|part| matches!(part.at, FactorAt::MaskBit(_))).count();
        let is_shared = |light: &&LightPlanned| light.factors().any(|part| part.at == FactorAt::Counts);
        let shared = self.lights.iter().find(is_shared);
        if let (Some(light), Some(pass)) =
            (shared, self.passes.iter().find(|p| p.draws.iter().any(frees_stencil)))
        {
            return Err(PlanError::StencilShared { light: light.name.clone(), pass: pass.name.clone() });
        }
        if resolves < in_mask {
            return Err(PlanError::Unresolved { lights: in_mask, resolves });
        }
        let mut counted_in: HashMap<SlotId, Vec<(&str, [u32; 4])>> = HashMap::new();
        for pass in &self.passes {
            let Some(depth) = &pass.depth else { continue };
            let counted = counted_in.entry(depth.slot).or_default();
            if matches!(depth.stencil, Some(Access::Clear(_))) {
                counted.clear();
            }
            let [width, height] = self.target_size_px(pass);
            let whole = [0, 0, width, height];
            for draw in &pass.draws {
                let Some(stencil) = draw.state.stencil else { continue };
                let scissor = draw.scissor_px.unwrap_or(whole);
                if stencil.frees() {
                    if let Some((pass, counted)) =
                        counted.iter().find(|(_, inner)| !contains(scissor, *inner))
                    {
                        let pass = (*pass).to_owned();
                        return Err(PlanError::CountsLeak { pass, counted: *counted, resolved: scissor });
                    }
                    counted.clear();
                } else if changes(&stencil) {
                    counted.push((&pass.name, scissor));
                }
            }
        }
        Ok(())
    }
}

fn is_keepable(slot: &Slot) -> bool {
    matches!(slot.kind, SlotKind::Texture { samples: 1, .. })
}

fn contains(outer: [u32; 4], inner: [u32; 4]) -> bool {
    let end = |rectangle: [u32; 4], i: usize| u64::from(rectangle[i]) + u64::from(rectangle[i + 2]);
    (0..2).all(|i| outer[i] <= inner[i] && end(outer, i) >= end(inner, i))
}

fn changes(stencil: &super::Stencil) -> bool {
    [stencil.front, stencil.back].iter().any(|face| {
        [face.fail_op, face.depth_fail_op, face.pass_op].iter().any(|op| *op != StencilOperation::Keep)
    })
}

fn frees_stencil(draw: &Draw) -> bool {
    draw.state.stencil.is_some_and(|stencil| stencil.frees())
}

fn writes_stencil(pass: &Pass) -> bool {
    pass.draws.iter().any(|draw| draw.state.stencil.is_some_and(|stencil| changes(&stencil)))
}

fn format_of(slot: &Slot) -> Option<wgpu::TextureFormat> {
    match slot.kind {
        SlotKind::Texture { format, .. } => Some(format),
        SlotKind::Buffer { .. } | SlotKind::Image { .. } => None,
    }
}

fn wrong_kind(pass: &Pass, slot: &Slot, needed: &'static str) -> PlanError {
    PlanError::WrongKind { pass: pass.name.clone(), slot: slot.name.clone(), needed, found: slot.to_string() }
}
