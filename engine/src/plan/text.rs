//! The plan as text: what `inspect` prints and plan tests read.

use std::fmt;

use super::{
    Access, Binding, BufferUsage, Draw, FULL_DARKENING, FactorPart, FramePlan, Geometry, Load, Pass, Slot,
    SlotId, SlotKind,
};

/// Draws listed one by one in a pass's text; the rest are summed up.
const DRAWS_SHOWN: usize = 8;

impl fmt::Display for FramePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size_px;
        let draws: usize = self.passes.iter().map(|pass| pass.draws.len()).sum();
        writeln!(
            f,
            "frame {width}x{height}: {} passes, {draws} draws, {} bytes",
            self.passes.len(),
            self.bytes()
        )?;
        for (index, slot) in self.slots.iter().enumerate() {
            writeln!(f, "  slot {index} {slot}")?;
        }
        for light in &self.lights {
            let techniques =
                if light.techniques.is_empty() { "no shadow".into() } else { light.techniques.join(", ") };
            write!(f, "  light {}: {techniques} -> ", light.name)?;
            for (index, FactorPart { at, max_darkening }) in light.factors().enumerate() {
                write!(f, "{}{at:?}", if index == 0 { "" } else { " and " })?;
                if max_darkening != FULL_DARKENING {
                    write!(f, " taking {max_darkening:?}")?;
                }
            }
            if !light.smooth_terminators.is_empty() {
                write!(f, ", smooth terminators: {}", light.smooth_terminators.len())?;
            }
            writeln!(f, "{}", if light.own_shadow { ", own shadows in its factor" } else { "" })?;
        }
        if self.layers > 0 {
            writeln!(f, "  layers of transparent surfaces: {}", self.layers)?;
        }
        for pass in &self.passes {
            self.write_pass(f, pass)?;
        }
        for note in &self.notes {
            writeln!(f, "  left out: {note}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Slot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "'{}' ", self.name)?;
        match &self.kind {
            SlotKind::Texture { format, size_px: [width, height], layers, samples } => {
                write!(f, "{format:?} {width}x{height}")?;
                if *layers > 1 {
                    write!(f, "x{layers}")?;
                }
                if *samples > 1 {
                    write!(f, " of {samples} samples")?;
                }
            }
            SlotKind::Buffer { usage: BufferUsage::Storage, .. } => write!(f, "storage buffer")?,
            SlotKind::Buffer { usage: BufferUsage::Index, .. } => write!(f, "index buffer")?,
            SlotKind::Image { .. } => write!(f, "image of the scene")?,
        }
        if let Some(key) = self.kept {
            write!(f, ", kept under {key:016x}")?;
        }
        write!(f, ", {} bytes: {}", self.bytes(), self.reason)
    }
}

impl FramePlan {
    fn name_of(&self, slot: SlotId) -> &str {
        &self.slots[slot.0].name
    }

    fn write_pass(&self, f: &mut fmt::Formatter<'_>, pass: &Pass) -> fmt::Result {
        writeln!(f, "  pass '{}': {}", pass.name, pass.reason)?;
        if let Some(slot) = self.written_by(pass).find(|slot| self.slots[slot.0].kept.is_some()) {
            writeln!(f, "    kept: runs only when '{}' does not hold this key yet", self.name_of(slot))?;
        }
        for color in &pass.colors {
            let load = match color.load {
                Load::Clear(_) => "clear".to_owned(),
                Load::ClearWithin(_, [x, y, width, height]) => {
                    format!("clear within {width}x{height}+{x}+{y}")
                }
                Load::Keep => "keep".into(),
            };
            write!(f, "    color '{}' layer {} {load}", self.name_of(color.slot), color.layer)?;
            if let Some(resolve) = color.resolve {
                write!(f, ", resolved into '{}'", self.name_of(resolve))?;
            }
            writeln!(f)?;
        }
        if let Some(depth) = &pass.depth {
            let access = |access: Access| match access {
                Access::ReadOnly => "read".to_owned(),
                Access::Keep => "write".to_owned(),
                Access::Clear(value) => format!("clear {value}"),
            };
            let layer = if depth.layer > 0 { format!(" layer {}", depth.layer) } else { String::new() };
            write!(f, "    depth '{}'{layer} {}", self.name_of(depth.slot), access(depth.depth))?;
            match depth.stencil {
                Some(stencil) => writeln!(f, ", stencil {}", access(stencil))?,
                None => writeln!(f)?,
            }
        }
        for draw in pass.draws.iter().take(DRAWS_SHOWN) {
            self.write_draw(f, draw)?;
        }
        if pass.draws.len() > DRAWS_SHOWN {
            let rest = &pass.draws[DRAWS_SHOWN..];
            let vertices: u64 = rest.iter().map(Draw::vertices).sum();
            writeln!(f, "    ... and {} draws more, {vertices} vertices", rest.len())?;
        }
        Ok(())
    }

    fn write_draw(&self, f: &mut fmt::Formatter<'_>, draw: &Draw) -> fmt::Result {
        write!(f, "    draw '{}' ", draw.name)?;
        match &draw.geometry {
            Geometry::Surfaces { style, parts, .. } => {
                write!(f, "{style:?} surfaces, {} parts, ", parts.len())?;
            }
            Geometry::PulledSurfaces { style, parts, .. } => {
                write!(f, "{style:?} surfaces, {} parts, ", parts.len())?;
            }
            Geometry::Indexed { .. } | Geometry::IndexedProcedural { .. } => write!(f, "indexed, ")?,
            Geometry::Numbered { .. } => write!(f, "numbered, ")?,
            Geometry::Procedural { .. } => write!(f, "procedural, ")?,
        }
        write!(f, "{} vertices", draw.vertices())?;
        if let Some(shader) = draw.geometry.shader() {
            write!(f, " by {}", shader.name)?;
        }
        for (_, binding) in &draw.bindings {
            let aspect = if matches!(binding, Binding::StencilOf(_)) { "stencil of " } else { "" };
            match binding.resource() {
                Some(slot) => write!(f, ", reads {aspect}'{}'", self.name_of(slot))?,
                None => write!(f, ", compares")?,
            }
        }
        if let Some([x, y, width, height]) = draw.state.viewport_px {
            write!(f, ", onto {width}x{height}+{x}+{y}")?;
        }
        if let Some([x, y, width, height]) = draw.scissor_px {
            write!(f, ", within {width}x{height}+{x}+{y}")?;
        }
        writeln!(f)
    }
}
