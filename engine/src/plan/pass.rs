//! Passes and what they draw into.

use super::{Draw, SlotId};

/// What a colour attachment holds when its pass begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// One value everywhere.
    Clear([f64; 4]),
    /// One value in the pixels of a rectangle (x, y, width, height), and whatever there was elsewhere.
    ClearWithin([f64; 4], [u32; 4]),
    /// What earlier passes left.
    Keep,
}

/// How a pass uses one aspect of the depth-stencil attachment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Access {
    /// Tested or sampled, never written.
    ReadOnly,
    /// Written over what earlier passes left.
    Keep,
    /// Written over this value.
    Clear(f32),
}

/// A colour attachment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColorTarget<R = SlotId> {
    /// The texture.
    pub slot: R,
    /// The array layer.
    pub layer: u32,
    /// What it holds at first.
    pub load: Load,
    /// The single-sample texture that gets the mean of each pixel's samples when the pass is done.
    pub resolve: Option<R>,
}

/// The depth-stencil attachment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthTarget<R = SlotId> {
    /// The texture.
    pub slot: R,
    /// The array layer.
    pub layer: u32,
    /// How depth is used: read-only where the format has none.
    pub depth: Access,
    /// How the stencil is used; `None` when the format has none.
    pub stencil: Option<Access>,
}

/// One render pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Pass<R = SlotId> {
    /// What it is called in the plan's text and in timings.
    pub name: String,
    /// Why the frame needs it.
    pub reason: String,
    /// Colour attachments.
    pub colors: Vec<ColorTarget<R>>,
    /// Depth-stencil attachment.
    pub depth: Option<DepthTarget<R>>,
    /// What is drawn, in order.
    pub draws: Vec<Draw<R>>,
}
