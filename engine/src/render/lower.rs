//! The one place where a frame's symbols become textures: once all passes are known, what all of them together need says of
//! which format and how large these are, what they hold when a pass begins, and which pixels of them matter.

use super::factors::Factors;
use super::picture::Picture;
use super::request::{FrameError, check_size};
use super::schedule::{DepthDesc, Group, Inputs, Needs, Schedule, Scope};
use super::states::CLEAR_STENCIL;
use crate::plan::{
    self, Access, DepthId, Geometry, Load, Resource, Slot, SlotId, SlotKind, SurfaceStyle, Symbol,
    TextureFormat,
};
use crate::shadow::{Binding, ColorTarget, DepthTarget, Draw, Pass};

/// A frame's slots and passes.
pub(super) struct Lowered {
    pub(super) slots: Vec<Slot>,
    pub(super) passes: Vec<plan::Pass>,
    /// The array with the lights' visibilities.
    pub(super) visibility: Option<SlotId>,
    /// The pixels (x and y from, x and y to before) outside of which every visibility counts as 1.
    pub(super) shadowed_px: [u32; 4],
    pub(super) notes: Vec<String>,
}

/// Gives symbols their textures. What was asked for keeps its id.
///
/// # Errors
/// What the adapter cannot do with four samples a pixel.
pub(super) fn lower(
    inputs: &Inputs<'_>,
    needs: Needs,
    schedule: &Schedule<'_>,
    factors: &Factors,
    picture: Picture,
) -> Result<Lowered, FrameError> {
    let Needs { slots, depths, notes } = needs;
    let mut slots = slots.into_slots();
    let (size_px, mut depth_slots, mut stencils) = (inputs.view.size_px, Vec::new(), Vec::new());
    for (depth, desc) in depths.iter().enumerate() {
        let stencil = schedule.groups.iter().any(|group| counts_in(group, DepthId(depth)));
        let slot = depth_slot(desc, stencil, size_px);
        if let (true, SlotKind::Texture { format, .. }) = (inputs.is_multisampled(), &slot.kind) {
            inputs.adapter.check_multisampled(&desc.name, *format)?;
        }
        stencils.push(stencil);
        depth_slots.push(SlotId(slots.len()));
        slots.push(slot);
    }
    let mut visibility = None;
    if factors.visibilities > 0 {
        visibility = Some(SlotId(slots.len()));
        slots.push(visibility_slot(inputs, factors)?);
    }
    let (shadowed_px, lit) = shadowed(schedule, size_px);
    let lit = match lit {
        Load::ClearWithin(value, pixels) if inputs.is_multisampled() => {
            Load::ClearWithin(value, texels_of(pixels))
        }
        lit => lit,
    };
    let textures = Textures { depths: depth_slots, stencils, visibility, lit };
    let mut passes: Vec<plan::Pass> =
        schedule.groups.iter().flat_map(|group| textures.group(group)).collect();
    if inputs.is_multisampled() {
        // The last pass that draws into samples resolves them.
        let colors = passes.iter_mut().rev().flat_map(|pass| &mut pass.colors);
        let last = colors.into_iter().find(|color| color.slot == picture.averaged);
        last.into_iter().for_each(|color| color.resolve = Some(picture.finished));
    }
    Ok(Lowered { slots, passes, visibility, shadowed_px, notes })
}

/// The passes of a group with the depth that their receivers have.
fn attached(scope: &Scope, target: &DepthTarget) -> Option<DepthId> {
    depth_of(scope, target.slot)
}

/// The receivers' depth that a resource stands for.
fn depth_of(scope: &Scope, resource: Resource) -> Option<DepthId> {
    match resource.0 {
        Symbol::ReceiverDepth => Some(scope.depth),
        Symbol::DepthOf(depth) => Some(depth),
        _ => None,
    }
}

/// Whether a pass of the group counts in the stencil beside this depth, or reads it.
fn counts_in(group: &Group<'_>, depth: DepthId) -> bool {
    let is_depth = |resource| depth_of(&group.scope, resource) == Some(depth);
    group.passes.iter().any(|pass| {
        let counts = pass.depth.is_some_and(|target| is_depth(target.slot) && target.stencil.is_some());
        let mut bindings = pass.draws.iter().flat_map(|draw| &draw.bindings);
        counts || bindings.any(|(_, read)| matches!(read, Binding::StencilOf(slot) if is_depth(*slot)))
    })
}

fn depth_slot(desc: &DepthDesc, stencil: bool, size_px: [u32; 2]) -> Slot {
    let (format, more) = match stencil {
        true => (TextureFormat::Depth32FloatStencil8, ", and the counts of shadow volumes"),
        false => (TextureFormat::Depth32Float, ""),
    };
    let kind = SlotKind::Texture { format, size_px, layers: 1, samples: desc.samples };
    Slot { name: desc.name.clone(), kind, reason: format!("{}{more}", desc.reason), kept: None }
}

/// With several samples a pixel there is a texel for each.
fn visibility_slot(inputs: &Inputs<'_>, factors: &Factors) -> Result<Slot, FrameError> {
    let (format, layers) = (factors.channels.format(), factors.visibilities);
    let size_px = inputs.request.antialias.factor_size_px(inputs.request.size_px);
    check_size(inputs.request, inputs.adapter, size_px)?;
    Ok(Slot {
        name: "visibility".into(),
        kind: SlotKind::Texture { format, size_px, layers, samples: 1 },
        reason: "factors of lights that are not hard".into(),
        kept: None,
    })
}

/// A rectangle of pixels in texels of which each pixel has four.
fn texels_of(pixels: [u32; 4]) -> [u32; 4] {
    pixels.map(|n| 2 * n)
}

/// Of a frame that is shadowed in more than this share, all is cleared.
const WORTH_IT: f64 = 0.75;

/// Where something darkens a visibility (x and y from, x and y to before), and what one holds before anything does: 1,
/// everywhere or there.
///
/// A visibility is as large as the frame, in half floats; clearing one takes a software adapter longer than most shadows do
/// that go into it. Techniques confine their draws to where their shadows can fall. Around all these draws lie the pixels
/// that matter: elsewhere shading takes the visibility to be 1. The whole frame where that is no gain, or where anything
/// but shading reads it.
fn shadowed(schedule: &Schedule<'_>, size_px: [u32; 2]) -> ([u32; 4], Load) {
    let [width, height] = size_px;
    let everywhere = ([0, 0, width, height], Load::Clear([1.0; 4]));
    let passes = || schedule.groups.iter().flat_map(|group| &group.passes);
    if passes().flat_map(|pass| &pass.draws).any(reads_beyond_shading) {
        return everywhere;
    }
    let draws = passes().filter(|pass| pass.draws_into(Resource::VISIBILITY)).flat_map(|pass| &pass.draws);
    let corners = draws.map(|draw| match draw.scissor_px {
        None => [0, 0, width, height],
        Some([x, y, width, height]) => [x, y, x + width, y + height],
    });
    let around = |a: [u32; 4], b: [u32; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
    let Some([left, top, right, bottom]) = corners.reduce(around) else { return everywhere };
    let within = [left, top, right.saturating_sub(left), bottom.saturating_sub(top)];
    let share = f64::from(within[2]) * f64::from(within[3]) / f64::from(width) / f64::from(height);
    if share > WORTH_IT || share == 0.0 {
        return everywhere;
    }
    ([left, top, right, bottom], Load::ClearWithin([1.0; 4], within))
}

/// Whether a draw that is not the engine's own shading reads a visibility.
fn reads_beyond_shading(draw: &Draw) -> bool {
    let shades = matches!(
        draw.geometry,
        Geometry::Surfaces { style: SurfaceStyle::Opaque | SurfaceStyle::Blended | SurfaceStyle::Tint, .. }
    );
    let is_visibility =
        |resource: Resource| matches!(resource.0, Symbol::Visibility | Symbol::AllVisibilities);
    let mut read = draw.bindings.iter().filter_map(|(_, binding)| binding.resource());
    !shades && read.any(is_visibility)
}

/// What symbols stand for.
struct Textures {
    /// For each [`DepthId`].
    depths: Vec<SlotId>,
    /// Which of these have a stencil.
    stencils: Vec<bool>,
    visibility: Option<SlotId>,
    /// What a visibility holds before anything darkens it.
    lit: Load,
}

impl Textures {
    fn group(&self, group: &Group<'_>) -> Vec<plan::Pass> {
        let mut visibility_is_touched = false;
        let lower = |pass: &Pass| {
            let lit = (!visibility_is_touched).then_some(self.lit);
            visibility_is_touched |= pass.draws_into(Resource::VISIBILITY);
            self.pass(&group.scope, pass, lit)
        };
        group.passes.iter().map(|pass| &**pass).map(lower).collect()
    }

    /// A pass as it is executed; `lit` is what the visibility holds at first, where nothing has drawn into it yet.
    fn pass(&self, scope: &Scope, pass: &Pass, lit: Option<Load>) -> plan::Pass {
        plan::Pass {
            name: format!("{}{}", pass.name, scope.place),
            reason: format!("{}{}", pass.reason, scope.purpose),
            colors: pass.colors.iter().map(|color| self.color(scope, color, lit)).collect(),
            depth: pass.depth.as_ref().map(|target| self.depth(scope, target)),
            draws: pass
                .draws
                .iter()
                .map(|draw| {
                    self.draw(scope, draw, scope.each_sample && pass.draws_into(Resource::VISIBILITY))
                })
                .collect(),
        }
    }

    /// A draw, into a texel for `each_sample` or into pixels.
    fn draw(&self, scope: &Scope, draw: &Draw, each_sample: bool) -> plan::Draw {
        let mut draw = draw.lowered(|read| self.binding(scope, read), |slot| self.slot(scope, slot));
        if each_sample {
            draw.scissor_px = draw.scissor_px.map(texels_of);
        }
        draw
    }

    fn color(&self, scope: &Scope, color: &ColorTarget, lit: Option<Load>) -> plan::ColorTarget {
        let slot = self.slot(scope, color.slot);
        if color.slot == Resource::VISIBILITY {
            let (layer, load) = (scope.visibility.unwrap_or_default(), lit.unwrap_or(Load::Keep));
            return plan::ColorTarget { slot, layer, load, resolve: None };
        }
        plan::ColorTarget { slot, layer: color.layer, load: color.load, resolve: None }
    }

    fn depth(&self, scope: &Scope, target: &DepthTarget) -> plan::DepthTarget {
        let DepthTarget { slot, layer, depth, stencil } = *target;
        let stencil = match attached(scope, target) {
            None => stencil,
            Some(depth) if !self.stencils[depth.0] => None,
            Some(_) if stencil.is_some() => stencil,
            // Who draws or tests depth need not know whether anything counts beside it.
            Some(_) if matches!(depth, Access::Clear(_)) => Some(CLEAR_STENCIL),
            Some(_) => Some(Access::ReadOnly),
        };
        plan::DepthTarget { slot: self.slot(scope, slot), layer, depth, stencil }
    }

    fn binding(&self, scope: &Scope, binding: Binding) -> plan::Binding {
        let slot = |resource| self.slot(scope, resource);
        match binding {
            Binding::Texture(read) if read == Resource::VISIBILITY => {
                plan::Binding::TextureLayer(slot(read), scope.visibility.unwrap_or_default())
            }
            Binding::Texture(read) if read == Resource::RECEIVER_DEPTH => {
                plan::Binding::Texture(scope.seen.depth.unwrap_or_else(|| slot(read)))
            }
            Binding::Storage(read) => plan::Binding::Storage(slot(read)),
            Binding::Texture(read) => plan::Binding::Texture(slot(read)),
            Binding::TextureArray(read) => plan::Binding::TextureArray(slot(read)),
            Binding::TextureLayer(read, layer) => plan::Binding::TextureLayer(slot(read), layer),
            Binding::StencilOf(read) => plan::Binding::StencilOf(slot(read)),
            Binding::Comparison(compare) => plan::Binding::Comparison(compare),
        }
    }

    /// The slot that a resource stands for. What is nowhere is a slot that no plan has, which validation names.
    fn slot(&self, scope: &Scope, resource: Resource) -> SlotId {
        const NOWHERE: SlotId = SlotId(usize::MAX);
        match resource.0 {
            Symbol::Slot(slot) => slot,
            Symbol::ReceiverDepth => self.depths[scope.depth.0],
            Symbol::DepthOf(depth) => self.depths[depth.0],
            Symbol::VisibleTriangles => scope.seen.triangles.unwrap_or(NOWHERE),
            Symbol::ReceiverPlanes => scope.seen.planes.unwrap_or(NOWHERE),
            Symbol::Visibility | Symbol::AllVisibilities => self.visibility.unwrap_or(NOWHERE),
        }
    }
}
