//! What kind of geometry a pipeline is for, and the bindings it brings.

use super::super::bindings::{BindKind, SampleKind};
use super::super::pipelines::{Culling, VertexInput};
use super::scene::Scene;
use crate::plan::{Binding, Draw, PulledStyle, SurfaceStyle};

/// The geometry of one draw.
#[derive(Clone, Copy)]
pub(super) enum Surface {
    Mesh { style: SurfaceStyle, masked: bool, culling: Culling },
    Pulled { style: PulledStyle, culling: Culling },
    Technique { indexed: bool },
}

impl Surface {
    /// Whether its shader reads a material.
    pub(super) fn has_material(self) -> bool {
        match self {
            Self::Mesh { style: SurfaceStyle::Depth, masked, .. } => masked,
            Self::Pulled { style, .. } => style == PulledStyle::PulledMasked,
            Self::Technique { .. } => false,
            Self::Mesh { .. } => true,
        }
    }

    /// How many bindings of group 1 its geometry brings: positions, indices, attributes.
    pub(super) fn own_bindings(self) -> u32 {
        match self {
            Self::Pulled { style: PulledStyle::Pulled, .. } => 2,
            Self::Pulled { style: PulledStyle::PulledMasked, .. } => 3,
            Self::Technique { indexed: true } => 1,
            Self::Technique { indexed: false } | Self::Mesh { .. } => 0,
        }
    }

    /// Which of its faces are dropped.
    pub(super) fn culling(self) -> Culling {
        match self {
            Self::Mesh { culling, .. } | Self::Pulled { culling, .. } => culling,
            Self::Technique { .. } => Culling::None,
        }
    }

    /// The vertex buffers its pipeline reads.
    pub(super) fn input(self) -> VertexInput {
        match self {
            Self::Technique { .. } | Self::Pulled { .. } => VertexInput::None,
            Self::Mesh { style: SurfaceStyle::Depth, masked: false, .. } => VertexInput::Positions,
            Self::Mesh { .. } => VertexInput::All,
        }
    }
}

/// The layout of group 1.
pub(super) fn draw_kinds(scene: &Scene<'_>, draw: &Draw, surface: Surface) -> Vec<(u32, BindKind)> {
    let mut kinds: Vec<_> = (0..surface.own_bindings()).map(|binding| (binding, BindKind::Storage)).collect();
    for (number, binding) in &draw.bindings {
        let Some(slot) = binding.resource() else {
            kinds.push((*number, BindKind::Comparison));
            continue;
        };
        let sample = SampleKind::of(scene.format(slot));
        let multisampled = scene.plan.slot(slot).samples() > 1;
        let kind = match binding {
            Binding::Comparison(_) => BindKind::Comparison,
            Binding::Storage(_) => BindKind::Storage,
            Binding::Texture(_) => BindKind::Texture { sample, array: false, multisampled },
            Binding::TextureArray(_) | Binding::TextureLayer(..) => {
                BindKind::Texture { sample, array: true, multisampled }
            }
            Binding::StencilOf(_) => {
                BindKind::Texture { sample: SampleKind::Uint, array: false, multisampled }
            }
        };
        kinds.push((*number, kind));
    }
    kinds
}
