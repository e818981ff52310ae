//! One light's part of the plan, before it is known how factors are stored: what its techniques left, sorted by what the
//! picture is to make of it.

use std::ops::Range;

use crate::plan::{ALL_TAKEN, Binding, FactorAt, Load, Pass, SlotId};
use crate::shadow::Channels;

/// Passes that together leave one factor: counts in a stencil that was zero, a layer of the visibility, or both.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub(super) passes: Vec<Pass>,
    pub(super) counts: bool,
    /// The layer of the visibility array that they write.
    pub(super) layer: Option<u32>,
    /// What the picture loses where the factor is 0.
    pub(super) taken: [f32; 3],
}

/// What one light brings.
#[derive(Clone, Debug, Default)]
pub(super) struct Segment {
    /// The factors that the light is shaded with, multiplied; none where it is lit everywhere.
    pub(super) shaded: Vec<Part>,
    /// The light's factor by itself, where an image of it was asked for and `shaded` is not it.
    pub(super) alone: Option<Part>,
    /// What darkens the finished picture instead.
    pub(super) after: Vec<Part>,
    /// Whether `after` goes into the one darkening of the frame.
    pub(super) once: bool,
    pub(super) visibility: Option<Channels>,
    pub(super) techniques: Vec<String>,
    pub(super) claimed: bool,
    pub(super) smooth_terminators: Vec<u32>,
    /// Whether a technique decides what of the light is beyond the receiver's own horizon.
    pub(super) own_shadow: bool,
}

/// What one claim left: its place among the light's passes, and what it wants made of them.
#[derive(Clone, Debug)]
pub(super) struct Left {
    pub(super) passes: Range<usize>,
    pub(super) counts: bool,
    pub(super) visibility: bool,
    pub(super) taken: [f32; 3],
    pub(super) once: bool,
    pub(super) apart: bool,
}

/// Hands out layers of the visibility array.
#[derive(Debug)]
pub(super) struct Layers {
    pub(super) visibility: SlotId,
    pub(super) count: u32,
    /// The one layer of everything that darkens the finished picture, one after the other.
    after: Option<u32>,
}

impl Part {
    /// Where the factor is; in the stencil where nothing else is said of counts.
    pub(super) fn place(&self) -> FactorAt {
        match (self.counts, self.layer) {
            (_, Some(layer)) => FactorAt::Visibility(layer),
            (true, None) => FactorAt::Counts,
            (false, None) => FactorAt::Lit,
        }
    }

    /// Whether its counts stay counts.
    pub(super) fn is_counted(&self) -> bool {
        self.place() == FactorAt::Counts
    }
}

impl Layers {
    pub(super) fn new(visibility: SlotId) -> Self {
        Self { visibility, count: 0, after: None }
    }

    fn next(&mut self) -> u32 {
        self.count += 1;
        self.count - 1
    }
}

impl Segment {
    /// Sorts what the claims of one light left in `passes`, all of it drawn for layer `base` of the visibility. Claims
    /// that neither weigh nor colour their shadow share a factor; each of the others has its own.
    pub(super) fn sort(&mut self, passes: &[Pass], left: &[Left], layers: &mut Layers, factors: bool) {
        let base = layers.count;
        let whole = Part::of(passes, left.iter(), ALL_TAKEN);
        self.once = left.iter().any(|left| left.once);
        let apart = left.iter().any(|left| left.apart);
        if self.once {
            self.alone = factors.then(|| whole.clone());
            self.after = vec![whole];
            return;
        }
        let is_plain = |left: &&Left| left.taken == ALL_TAKEN && !apart;
        let mut parts: Vec<Part> = Vec::new();
        if left.iter().any(|left| is_plain(&left)) {
            parts.push(Part::of(passes, left.iter().filter(is_plain), ALL_TAKEN));
        }
        let others = left.iter().filter(|left| !is_plain(left));
        parts.extend(others.map(|left| Part::of(passes, std::iter::once(left), left.taken)));
        if factors && (parts.len() > 1 || apart) {
            let mut alone = whole;
            for pass in &mut alone.passes {
                pass.reason += "; here for the factor by itself, which no weight changes";
            }
            alone.set_layer(layers, base, None);
            self.alone = Some(alone);
        }
        for part in &mut parts {
            let shared = if apart { layers.after } else { None };
            part.set_layer(layers, base, shared);
            if apart {
                layers.after = part.layer.or(layers.after);
            }
        }
        if apart { self.after = parts } else { self.shaded = parts }
    }
}

impl Part {
    /// The passes of these claims. A layer, if any, is set later.
    fn of<'a>(passes: &[Pass], left: impl Iterator<Item = &'a Left>, taken: [f32; 3]) -> Self {
        let mut part = Self { passes: vec![], counts: false, layer: None, taken };
        for left in left {
            part.passes.extend(passes.get(left.passes.clone()).unwrap_or_default().iter().cloned());
            part.counts |= left.counts;
            part.layer = part.layer.or(left.visibility.then_some(0));
        }
        part
    }

    /// Has the passes draw into a layer of their own, or into `shared`, and begin with 1 there.
    fn set_layer(&mut self, layers: &mut Layers, base: u32, shared: Option<u32>) {
        if self.layer.is_none() {
            return;
        }
        let layer = shared.unwrap_or_else(|| layers.next());
        self.layer = Some(layer);
        let mut first = true;
        for pass in &mut self.passes {
            for color in pass.colors.iter_mut().filter(|color| color.slot == layers.visibility) {
                color.layer = layer;
                if first && color.load == Load::Keep {
                    color.load = Load::Clear([1.0; 4]);
                }
                first = false;
            }
            for (_, binding) in pass.draws.iter_mut().flat_map(|draw| &mut draw.bindings) {
                match binding {
                    Binding::TextureLayer(slot, read) if *slot == layers.visibility && *read == base => {
                        *read = layer;
                    }
                    _ => {}
                }
            }
        }
    }
}
