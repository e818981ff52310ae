//! The factors of lights on layers of transparent surfaces as images, where they were asked for: for measuring.
//!
//! Pictures need their layers from behind, and it matters to none which triangle a pixel of a layer belongs to. Who
//! compares factors wants both: here a *layer* is the n-th surface from the eye at every pixel, nearest first, each the
//! nearest behind the last one, with its instance and triangle. Of two surfaces at one depth each is a layer.

use std::ops::Range;

use wgpu::TextureFormat;

use super::assembly::{Assembly, engine_shader};
use super::frame::{Planner, Seen};
use super::layers::Receiving;
use super::request::FrameError;
use super::segments::{Part, Segment};
use super::states::CLEAR_STENCIL;
use crate::plan::{
    Access, Binding, BlendState, ColorTarget, CompareFunction, DepthTarget, Draw, DrawState, FactorAt,
    LightPlanned, Load, Pass, PlanBuilder, SlotId, SlotKind, SurfaceStyle,
};
use crate::shadow::Layer;

/// A layer that is looked at, or lies before one that is.
pub(super) struct LookedAt {
    pub(super) receiving: Receiving,
    /// Its instance and triangle at every pixel.
    pub(super) triangles: SlotId,
    /// Whether these and its factors are kept.
    pub(super) kept: bool,
    normals: Option<SlotId>,
}

impl Planner<'_> {
    /// Plans all lights for those of the layers `wanted` that are `in_view`, and for those before them.
    ///
    /// # Errors
    /// What the techniques refuse.
    pub(super) fn looked_at(
        &mut self,
        b: &mut PlanBuilder,
        wanted: Range<u32>,
        in_view: u32,
    ) -> Result<Vec<LookedAt>, FrameError> {
        let reason = "factors on layers were asked for";
        let count = if wanted.is_empty() { 0 } else { wanted.end.min(in_view) };
        let mut looked_at: Vec<LookedAt> = Vec::new();
        for layer in 0..count {
            // Even and odd ones take turns, unless they are kept.
            let before = layer.checked_sub(2).map(|before| &looked_at[before as usize]);
            let depth = match before {
                Some(before) => before.receiving.depth,
                None => {
                    let name = format!("depth looked at, layer {layer}");
                    b.texture(&name, TextureFormat::Depth32Float, 1, reason)
                }
            };
            let kept = wanted.contains(&layer);
            let triangles = match before.filter(|before| !kept && !before.kept) {
                Some(before) => before.triangles,
                None => b.texture(&format!("triangles of layer {layer}"), TextureFormat::Rg32Uint, 1, reason),
            };
            let mut seen =
                Seen { triangles: Some(triangles), normals: looked_at.first().and_then(|l| l.normals) };
            let receiving = self.receiving(b, depth, Layer::FromEye(layer), &mut seen)?;
            looked_at.push(LookedAt { receiving, triangles, kept, normals: seen.normals });
        }
        Ok(looked_at)
    }
}

impl Assembly<'_> {
    /// Peels these layers off, one after the other, and draws the images of those that are kept.
    pub(super) fn look_at(&mut self, layers: Vec<LookedAt>, lights: &mut [LightPlanned]) {
        let opaque_depth = self.depth;
        let mut last = None;
        for (number, layer) in layers.into_iter().enumerate() {
            let LookedAt { receiving, triangles, kept, normals } = layer;
            let first_pass = self.b.passes.len();
            self.depth = receiving.depth;
            self.peel(opaque_depth, last, triangles);
            let shadowed = receiving.segments.iter().any(Segment::draws);
            if shadowed && kept {
                self.seen_on_layer(&Seen { triangles: None, normals });
            }
            if kept {
                self.images_of(number, triangles, (receiving.segments, shadowed), lights);
            }
            for pass in &mut self.b.passes[first_pass..] {
                pass.name += &format!(" on layer {number}");
            }
            last = Some((self.depth, triangles));
        }
        self.depth = opaque_depth;
    }

    /// The factor of every light that has one on layer number `layer`.
    fn images_of(
        &mut self,
        layer: usize,
        triangles: SlotId,
        (segments, shadowed): (Vec<Segment>, bool),
        lights: &mut [LightPlanned],
    ) {
        // A later light may count as well, whatever else it has.
        let counts = |segment: &Segment| segment.claimed && segment.factor().is_some_and(|part| part.counts);
        let last = segments.iter().rposition(counts);
        let claimed = segments.iter().zip(lights).enumerate().filter(|(_, (s, _))| s.claimed);
        for (index, (segment, light)) in claimed {
            let part = segment.factor().filter(|_| shadowed);
            let place = part.map_or(FactorAt::Lit, |part| {
                self.passes_of(part, &light.name);
                part.place()
            });
            let image = self.layer_factor_image((layer, triangles), &light.name, place);
            light.layer_factor_images.push(image);
            if last.is_some_and(|last| last > index) && part.is_some_and(Part::is_counted) {
                let forget = self.forget_counts(&light.name);
                self.b.passes.push(forget);
            }
        }
    }

    /// Finds the next layer: its depth into `self.depth`, instance and triangle into `triangles`.
    fn peel(&mut self, opaque_depth: SlotId, last: Option<(SlotId, SlotId)>, triangles: SlotId) {
        let mut flags = vec!["BASE_COLOR_TEXTURE", "SECOND_UV"];
        let mut bindings = vec![(3, Binding::Texture(opaque_depth))];
        if let Some((last_depth, last_triangles)) = last {
            flags.push("BEHIND");
            bindings.extend([(4, Binding::Texture(last_depth)), (5, Binding::Texture(last_triangles))]);
        }
        let mut state = DrawState::new(CompareFunction::Greater, vec![Some(BlendState::REPLACE)]);
        state.depth_write = true;
        let shader = engine_shader("surface_peel", &flags, "vertex", Some("peel"));
        let stencil = self.depth_read().stencil.map(|_| CLEAR_STENCIL);
        let nothing = f64::from(u32::MAX);
        self.b.passes.push(Pass {
            name: "peel".into(),
            reason: "the nearest transparent surface behind the last layer".into(),
            colors: vec![ColorTarget {
                slot: triangles,
                layer: 0,
                load: Load::Clear([nothing, nothing, 0.0, 0.0]),
                resolve: None,
            }],
            depth: Some(DepthTarget { slot: self.depth, depth: Access::Clear(0.0), stencil }),
            draws: vec![Draw {
                shader: Some(shader),
                ..self.transparent_draw("transparent surfaces", SurfaceStyle::PulledMasked, state, bindings)
            }],
        });
    }

    /// The factor of one light on a layer as a linear image.
    fn layer_factor_image(
        &mut self,
        (layer, triangles): (usize, SlotId),
        light: &str,
        factor: FactorAt,
    ) -> SlotId {
        let mut bindings = vec![(0, Binding::Texture(triangles))];
        let (mut flags, mut format): (&[&str], _) = (&[], TextureFormat::R32Float);
        match factor {
            FactorAt::Counts | FactorAt::MaskBit(_) => {
                bindings.push((1, Binding::StencilOf(self.depth)));
                flags = &["COUNTS"];
            }
            FactorAt::Visibility(layer) => {
                bindings.push((1, Binding::TextureLayer(self.visibility, layer)));
                flags = &["VISIBILITY"];
                if matches!(
                    self.b.slots[self.visibility.0].kind,
                    SlotKind::Texture { format: TextureFormat::Rgba16Float, .. }
                ) {
                    format = TextureFormat::Rgba32Float;
                }
            }
            FactorAt::Lit | FactorAt::Darkening => {}
        }
        let name = format!("factor of {light}");
        let slot = self.b.texture(&format!("{name} on layer {layer}"), format, 1, "asked for");
        let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
        let mut draw = self.resolve_draw("factor", state);
        draw.shader = Some(engine_shader("layer_images", flags, "fullscreen_vertex", Some("factor")));
        draw.bindings = bindings;
        self.b.passes.push(Pass {
            name,
            reason: "the factor on this layer was asked for as an image".into(),
            colors: vec![ColorTarget { slot, layer: 0, load: Load::Clear([1.0; 4]), resolve: None }],
            depth: None,
            draws: vec![draw],
        });
        slot
    }
}
