//! How the engine's own passes blend, and what they do with counts in the stencil.

use crate::plan::{
    Access, BlendComponent, BlendFactor, BlendOperation, BlendState, CompareFunction, STENCIL_AT_REST,
    Stencil, StencilFaceState, StencilOperation,
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

/// Draws where counts say that something casts, and sets them back everywhere.
pub(super) const FREE_WHERE_COUNTED: Stencil = where_counted(StencilOperation::Replace, 0xff);

/// Draws where counts say that something casts, and leaves them.
pub(super) const WHERE_COUNTED: Stencil = where_counted(StencilOperation::Keep, 0);

const fn where_counted(op: StencilOperation, write_mask: u8) -> Stencil {
    let face = StencilFaceState {
        // The reference is less than what the stencil holds.
        compare: CompareFunction::Less,
        fail_op: op,
        depth_fail_op: StencilOperation::Keep,
        pass_op: op,
    };
    Stencil { front: face, back: face, read_mask: 0xff, write_mask, reference: STENCIL_AT_REST }
}

/// Nothing is counted.
pub(super) const CLEAR_STENCIL: Access = Access::Clear(STENCIL_AT_REST as f32);
