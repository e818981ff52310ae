//! Transparent surfaces as they are drawn without layers, or with shadows on the nearest one only.
//!
//! They are blended far to near by the middles of what they belong to, so that surfaces of one object, or that pass through
//! one another, may blend in a wrong order. Where shadows fall on the nearest surface (Kim, Kim & Turk, section 6), its
//! depth is drawn and the lights' techniques plan for it; those behind it are blended first, lit without shadows, and it
//! comes last: so at least that one is in its place at every pixel. Surfaces at one depth are the nearest together: they
//! are in one place, and so in one shadow.

use super::assembly::Assembly;
use super::layers::Layered;
use super::surfaces::Surfaces;
use crate::plan::{
    Access, Binding, BlendState, ColorTarget, CompareFunction, DepthTarget, Draw, DrawState, LightPlanned,
    Load, MULTIPLY, Pass, SlotId, SurfaceStyle,
};

/// How sorted surfaces are drawn.
pub(super) struct Sorted {
    pub(super) compare: CompareFunction,
    /// What all draws read, and what those read that shade.
    pub(super) bindings: Vec<(u32, Binding)>,
    pub(super) factors: Vec<(u32, Binding)>,
}

impl Sorted {
    /// All of them before the opaque surfaces, lit without shadows.
    pub(super) fn all() -> Self {
        Self { compare: CompareFunction::Greater, bindings: vec![], factors: vec![] }
    }
}

impl Assembly<'_> {
    /// Blends what is behind the nearest transparent surface over the picture, and then this one with its shadows.
    pub(super) fn draw_nearest(
        &mut self,
        mut layers: Layered,
        mask: Option<SlotId>,
        lights: &mut [LightPlanned],
    ) {
        self.count_on(&layers);
        let opaque_depth = self.depth;
        let nearest_depth = layers.depths[0];
        let first_pass = self.b.passes.len();
        let shadowed = self.layer(&mut layers, 0, (opaque_depth, None), mask, lights);
        for pass in &mut self.b.passes[first_pass..] {
            pass.name += " on the nearest transparent surface";
        }
        self.depth = opaque_depth;
        let farther = Sorted { bindings: vec![(10, Binding::Texture(nearest_depth))], ..Sorted::all() };
        let reason = "all transparent surfaces but the nearest, lit without shadows, far to near";
        self.blend_sorted("farther surfaces", reason, &farther);
        self.depth = nearest_depth;
        let factors = if shadowed { self.factor_bindings(mask, lights) } else { vec![] };
        let nearest = Sorted { compare: CompareFunction::Equal, bindings: vec![], factors };
        let reason = "the nearest transparent surface at every pixel, with the shadows on it";
        self.blend_sorted("nearest surfaces", reason, &nearest);
        self.depth = opaque_depth;
        self.further_images(layers, mask, lights);
    }

    /// Peels off further layers whose images were asked for.
    fn further_images(&mut self, mut layers: Layered, mask: Option<SlotId>, lights: &mut [LightPlanned]) {
        let opaque_depth = self.depth;
        let mut last = layers.triangles[0].map(|triangles| (layers.depths[0], triangles));
        for layer in 1..layers.segments.len() {
            let first_pass = self.b.passes.len();
            self.layer(&mut layers, layer, (opaque_depth, last), mask, lights);
            last = layers.triangles[layer].map(|triangles| (self.depth, triangles));
            for pass in &mut self.b.passes[first_pass..] {
                pass.name += &format!(" on layer {layer}");
            }
        }
        self.depth = opaque_depth;
    }

    /// The depth of the nearest transparent surface into `self.depth`.
    pub(super) fn nearest_depth(&mut self, opaque_depth: SlotId) {
        let mut state = DrawState::new(CompareFunction::Greater, vec![]);
        state.depth_write = true;
        let stencil = self.depth_read().stencil.map(|_| Access::Clear(0.0));
        let bindings = vec![(0, Binding::Texture(opaque_depth))];
        let style = SurfaceStyle::Nearest;
        self.b.passes.push(Pass {
            name: "depth".into(),
            reason: "shadows need to know where it is".into(),
            colors: vec![],
            depth: Some(DepthTarget { slot: self.depth, depth: Access::Clear(0.0), stencil }),
            draws: vec![self.transparent_draw("transparent surfaces", style, state, bindings)],
        });
    }

    fn blend_sorted(&mut self, name: &str, reason: &str, sorted: &Sorted) {
        let target = ColorTarget { slot: self.drawn, layer: 0, load: Load::Keep, resolve: None };
        self.b.passes.push(Pass {
            name: name.into(),
            reason: reason.into(),
            colors: vec![target],
            depth: Some(self.depth_read()),
            draws: self.sorted_draws(sorted),
        });
    }

    /// Transparent surfaces far to near by their middles.
    pub(super) fn sorted_draws(&self, sorted: &Sorted) -> Vec<Draw> {
        let transmits = |&(instance, part): &(u32, u32)| {
            self.posed.instances[instance as usize].materials[part as usize].transmission > 0.0
        };
        let draw = |name: &str, style, parts: &[(u32, u32)], blend| Draw {
            name: name.into(),
            shader: None,
            state: DrawState::new(sorted.compare, vec![Some(blend)]),
            geometry: Surfaces::geometry(self.posed, style, parts),
            bindings: sorted.bindings.clone(),
            scissor_px: None,
        };
        let mut draws = Vec::new();
        for run in self.surfaces.blended.chunk_by(|a, b| !transmits(a) && !transmits(b)) {
            // What shines through in colour takes that colour on first.
            if run.iter().any(transmits) {
                draws.push(draw("tint", SurfaceStyle::Tint, run, MULTIPLY));
            }
            let blend = BlendState::PREMULTIPLIED_ALPHA_BLENDING;
            let mut blended = draw("blended surfaces", SurfaceStyle::Blended, run, blend);
            blended.bindings.extend(&sorted.factors);
            draws.push(blended);
        }
        draws
    }
}
