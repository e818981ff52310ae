//! The layers of transparent surfaces of a frame, with what the lights' techniques planned for each.

use super::lights::ReceiverPasses;
use crate::plan::SlotId;

/// The layers of a frame, and what the lights' techniques planned for them.
#[derive(Debug)]
pub(super) struct Layered {
    pub(super) nearest: ReceiverPasses,
    /// Those behind it, the farthest first; empty where no light's shadows fall on them.
    pub(super) farther: Vec<ReceiverPasses>,
    /// Whether there may be any behind it.
    pub(super) only_one: bool,
    /// Those whose factors were asked for as images, or that lie before such: the nearest first.
    pub(super) looked_at: Vec<LookedAt>,
}

impl Layered {
    /// How many layers are drawn with shadows.
    pub(super) fn count(&self) -> u32 {
        self.farther.len() as u32 + 1
    }

    /// What is planned for each layer that is drawn, and for each that is looked at.
    pub(super) fn receivers(&self) -> impl Iterator<Item = &ReceiverPasses> {
        self.drawn().chain(self.looked_at.iter().map(|layer| &layer.receivers))
    }

    pub(super) fn drawn(&self) -> impl Iterator<Item = &ReceiverPasses> + Clone {
        std::iter::once(&self.nearest).chain(&self.farther)
    }
}

/// A layer that is looked at, or lies before one that is.
#[derive(Debug)]
pub(super) struct LookedAt {
    pub(super) receivers: ReceiverPasses,
    /// Its instance and triangle at every pixel.
    pub(super) triangles: SlotId,
    /// Whether these and its factors are kept.
    pub(super) kept: bool,
}
