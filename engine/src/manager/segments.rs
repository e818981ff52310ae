//! One light's part of the plan, before it is known how factors are stored: what its techniques left, sorted by what the
//! picture is to make of it.

use std::ops::Range;

use crate::plan::{ALL_TAKEN, Binding, ColorTarget, FactorAt, Load, Pass, SlotId};
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
pub(super) struct VisibilityLayers {
    pub(super) visibility: SlotId,
    pub(super) count: u32,
    /// The one layer of everything that darkens the finished picture, one after the other.
    after: Option<u32>,
    /// For each light, what its factor by itself and each of its parts took: transparent layers draw into the same.
    kept: Vec<Vec<Option<u32>>>,
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

impl VisibilityLayers {
    pub(super) fn new(visibility: SlotId) -> Self {
        Self { visibility, count: 0, after: None, kept: vec![] }
    }

    fn next(&mut self) -> u32 {
        self.count += 1;
        self.count - 1
    }

    /// The layer of part number `part` of a light, 0 the factor by itself; a new one where it has none yet.
    fn of(&mut self, light: usize, part: usize) -> u32 {
        if self.kept.len() <= light {
            self.kept.resize(light + 1, vec![]);
        }
        if self.kept[light].len() <= part {
            self.kept[light].resize(part + 1, None);
        }
        if let Some(layer) = self.kept[light][part] {
            return layer;
        }
        let layer = self.next();
        self.kept[light][part] = Some(layer);
        layer
    }
}

impl Segment {
    /// What leaves the light's factor by itself, or else as it is shaded: then it has one part.
    pub(super) fn factor(&self) -> Option<&Part> {
        self.alone.as_ref().or(self.shaded.first())
    }

    /// Whether anything is drawn that may darken what is shaded.
    pub(super) fn draws(&self) -> bool {
        self.shaded.iter().flat_map(|part| &part.passes).any(|pass| !pass.draws.is_empty())
    }

    /// Sorts what the claims of light number `light` left in `passes`, all of it drawn for the next layer of the
    /// visibility, whatever receives. Claims that neither weigh nor colour their shadow share a factor; each of the others has its own.
    pub(super) fn sort(
        &mut self,
        light: usize,
        (passes, left): (&[Pass], &[Left]),
        layers: &mut VisibilityLayers,
        factors: bool,
    ) {
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
            alone.set_layer(layers, base, |layers| layers.of(light, 0));
            self.alone = Some(alone);
        }
        for (part, number) in parts.iter_mut().zip(1..) {
            let shared = if apart { layers.after } else { None };
            part.set_layer(layers, base, |layers| shared.unwrap_or_else(|| layers.of(light, number)));
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

    /// Has the passes draw into the `chosen` layer, where they draw into one, and begin with 1 there.
    fn set_layer(
        &mut self,
        layers: &mut VisibilityLayers,
        base: u32,
        chosen: impl FnOnce(&mut VisibilityLayers) -> u32,
    ) {
        if self.layer.is_none() {
            return;
        }
        let layer = chosen(layers);
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

    /// What stands for this part on receivers where it left nothing: no passes, in the same place.
    fn nothing(&self) -> Self {
        Self { passes: vec![], counts: false, layer: None, taken: self.taken }
    }

    /// Keeps counts and visibility where `other`, the same part on other receivers, has them.
    fn take_place(&mut self, other: &Self, visibility: SlotId) {
        self.counts |= other.counts;
        if let (None, Some(layer)) = (self.layer, other.layer) {
            self.layer = Some(layer);
            self.passes.insert(0, lit_visibility(visibility, layer));
        }
    }
}

impl Segment {
    /// Its factor by itself, and its parts.
    fn parts_mut(&mut self) -> impl Iterator<Item = &mut Part> {
        self.alone.iter_mut().chain(&mut self.shaded)
    }
}

/// Sets a light's visibility to 1 where its techniques leave it alone and on other surfaces do not.
fn lit_visibility(visibility: SlotId, layer: u32) -> Pass {
    Pass {
        name: "clear visibility".into(),
        reason: "nothing shadows it here, but on other surfaces".into(),
        colors: vec![ColorTarget { slot: visibility, layer, load: Load::Clear([1.0; 4]), resolve: None }],
        depth: None,
        draws: vec![],
    }
}

/// Gives one light's factors the same places on the opaque surfaces and on all `layers` of transparent ones, so that
/// shading finds them where it is told once. False when the light has other parts on some layer.
pub(super) fn join(opaque: &mut Segment, mut layers: Vec<&mut Segment>, visibility: SlotId) -> bool {
    for layer in &mut layers {
        if !layer.after.is_empty() {
            return false;
        }
        if layer.shaded.is_empty() && layer.alone.is_none() && opaque.after.is_empty() {
            layer.shaded = opaque.shaded.iter().map(Part::nothing).collect();
            layer.alone = opaque.alone.as_ref().map(Part::nothing);
        }
        let shaded_apart = opaque.after.is_empty() && layer.alone.is_some() != opaque.alone.is_some();
        if layer.shaded.len() != opaque.shaded.len() || shaded_apart {
            return false;
        }
    }
    if !opaque.after.is_empty() {
        return true;
    }
    // First everything is put together in the opaque surfaces' segment, then handed out.
    for layer in &mut layers {
        for (part, own) in opaque.parts_mut().zip(layer.parts_mut()) {
            part.take_place(own, visibility);
        }
    }
    for layer in &mut layers {
        for (own, part) in layer.parts_mut().zip(opaque.parts_mut()) {
            own.take_place(part, visibility);
        }
    }
    true
}
