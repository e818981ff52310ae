//! How the engine's own passes blend, and what they do with counts in the stencil.

use crate::plan::{
    BlendComponent, BlendFactor, BlendOperation, BlendState, CompareFunction, Stencil, StencilFaceState,
    StencilOperation,
};

/// dst + constant.
pub(super) const ADD_CONSTANT: BlendState = {
    let add = BlendComponent {
        src_factor: BlendFactor::Constant,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    BlendState { color: add, alpha: add }
};

/// dst · (1 − constant); alpha stays.
pub(super) const TIMES_ONE_MINUS_CONSTANT: BlendState = {
    let scale = BlendComponent {
        src_factor: BlendFactor::Zero,
        dst_factor: BlendFactor::OneMinusConstant,
        operation: BlendOperation::Add,
    };
    let keep = BlendComponent { dst_factor: BlendFactor::One, ..scale };
    BlendState { color: scale, alpha: keep }
};

/// Draws where the stencil is not zero, and leaves zero there.
pub(super) const ZERO_WHERE_COUNTED: Stencil = where_counted(StencilOperation::Zero, 0xff);

/// Draws where the stencil is not zero, and leaves it.
pub(super) const WHERE_COUNTED: Stencil = where_counted(StencilOperation::Keep, 0);

const fn where_counted(pass_op: StencilOperation, write_mask: u8) -> Stencil {
    let face = StencilFaceState {
        compare: CompareFunction::NotEqual,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op,
    };
    Stencil { front: face, back: face, read_mask: 0xff, write_mask, reference: 0 }
}
