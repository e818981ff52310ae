//! Merging adjacent passes into one render pass on the GPU.
//!
//! A plan keeps every pass apart, so that each can be timed and explained. On the GPU, passes over the same depth
//! buffer run as one render pass unless somebody wants their times: attachments are then loaded and stored once.

use std::collections::HashSet;
use std::ops::Range;

use crate::plan::{Access, ColorTarget, DepthTarget, FramePlan, Load, Pass, SlotId, SlotKind};

/// Passes that run as one render pass.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PassGroup {
    /// Indices into [`FramePlan::passes`].
    pub(crate) passes: Range<usize>,
    /// All their colour attachments.
    pub(crate) colors: Vec<ColorTarget>,
    /// Their depth attachment, written if any of them writes it.
    pub(crate) depth: Option<DepthTarget>,
}

/// The passes of the plan that `runs` says run, in groups; one group for each pass unless `merge`.
pub(crate) fn group_passes(plan: &FramePlan, merge: bool, runs: impl Fn(&Pass) -> bool) -> Vec<PassGroup> {
    let mut groups: Vec<PassGroup> = Vec::new();
    for (index, pass) in plan.passes.iter().enumerate().filter(|(_, pass)| runs(pass)) {
        match groups.last_mut() {
            Some(group) if merge && group.passes.end == index && can_join(plan, group, pass) => {
                for color in &pass.colors {
                    match place_of(&group.colors, color) {
                        Some(place) => {
                            let kept = &mut group.colors[place];
                            kept.resolve = color.resolve.or(kept.resolve);
                        }
                        None => group.colors.push(*color),
                    }
                }
                if let (Some(depth), Some(more)) = (&mut group.depth, &pass.depth) {
                    depth.depth = union(depth.depth, more.depth);
                    depth.stencil = depth.stencil.zip(more.stencil).map(|(a, b)| union(a, b));
                }
                group.passes.end = index + 1;
            }
            _ => groups.push(PassGroup {
                passes: index..index + 1,
                colors: pass.colors.clone(),
                depth: pass.depth,
            }),
        }
    }
    groups
}

/// Where `color` is among `colors`.
pub(crate) fn place_of(colors: &[ColorTarget], color: &ColorTarget) -> Option<usize> {
    colors.iter().position(|other| other.slot == color.slot && other.layer == color.layer)
}

fn union(first: Access, second: Access) -> Access {
    match (first, second) {
        (Access::ReadOnly, second) => second,
        (first, _) => first,
    }
}

fn can_join(plan: &FramePlan, group: &PassGroup, pass: &Pass) -> bool {
    let (Some(depth), Some(more)) = (&group.depth, &pass.depth) else { return false };
    let keeps = |access: Option<Access>| !matches!(access, Some(Access::Clear(_)));
    if depth.slot != more.slot
        || depth.layer != more.layer
        || !keeps(Some(more.depth))
        || !keeps(more.stencil)
    {
        return false;
    }
    // A pass's shaders write its first colour at location 0, its second at 1: each must keep that place in the group.
    let colors_fit =
        pass.colors.iter().enumerate().all(|(place, color)| match place_of(&group.colors, color) {
            Some(found) => found == place && color.load == Load::Keep,
            None => group.colors.len() <= place && is_picture_sized(plan, color.slot),
        });
    if !colors_fit {
        return false;
    }
    // Nothing may be sampled that the merged pass writes.
    let reads = |passes: &[Pass]| -> HashSet<SlotId> {
        let bindings = passes.iter().flat_map(|p| &p.draws).flat_map(|d| &d.bindings);
        bindings.filter_map(|(_, binding)| binding.resource()).collect()
    };
    let attachments = |colors: &[ColorTarget], depth: &DepthTarget| -> HashSet<SlotId> {
        let written = depth.depth != Access::ReadOnly || depth.stencil.is_some_and(|s| s != Access::ReadOnly);
        let resolved = colors.iter().filter_map(|c| c.resolve);
        colors.iter().map(|c| c.slot).chain(resolved).chain(written.then_some(depth.slot)).collect()
    };
    let before = reads(&plan.passes[group.passes.clone()]);
    let here = reads(std::slice::from_ref(pass));
    let mut written = attachments(&group.colors, depth);
    written.extend(attachments(&pass.colors, more));
    before.is_disjoint(&written) && here.is_disjoint(&written)
}

fn is_picture_sized(plan: &FramePlan, slot: SlotId) -> bool {
    matches!(plan.slot(slot).kind, SlotKind::Texture { size_px, .. } if size_px == plan.size_px)
}
