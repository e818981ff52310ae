//! The one pass that shades what is seen, with the factors of all lights.

use std::sync::Arc;

use super::assembly::Assembly;
use super::sorted::Sorted;
use super::states::CLEAR_STENCIL;
use super::surface_functions;
use crate::gpu::TintUniform;
use crate::plan::{
    ALL_TAKEN, Access, Binding, BlendState, BufferUsage, ColorTarget, CompareFunction, DrawState, FactorAt,
    LightPlanned, Load, Pass, SlotId, SurfaceStyle,
};
use crate::shadow::hash_of;

impl Assembly<'_> {
    /// Shades what is opaque by all lights at once; and what is transparent, unless that is drawn in layers.
    pub(super) fn shading(
        &mut self,
        after_prepass: bool,
        counts: bool,
        mask: Option<SlotId>,
        lights: &[LightPlanned],
        layered: bool,
    ) {
        let background = self.posed.background.as_dvec3();
        let mut bindings = self.factor_bindings(mask, lights);
        if self.multisampled() && !bindings.is_empty() {
            // Which samples show the fragment that is shaded: their factors are averaged.
            bindings.push((3, Binding::Texture(self.depth)));
        }
        let mut state = DrawState::new(CompareFunction::Equal, vec![Some(BlendState::REPLACE)]);
        let mut depth = self.depth_read();
        if !after_prepass {
            state.depth_compare = CompareFunction::Greater;
            state.depth_write = true;
            depth.depth = Access::Clear(0.0);
            depth.stencil = counts.then_some(CLEAR_STENCIL);
        }
        let mut draws = vec![self.surfaces_draw("opaque surfaces", SurfaceStyle::Opaque, None, state)];
        draws[0].bindings = bindings;
        if !layered && !self.surfaces.blended.is_empty() {
            draws.extend(self.sorted_draws(&Sorted::all()));
            self.b.note("blended surfaces are lit without shadows: factors are those of the opaque surface");
        }
        self.b.notes.extend(surface_functions::notes(self.posed, &self.surfaces, lights));
        let by_functions = surface_functions::reason(self.posed, &self.surfaces);
        self.b.passes.push(Pass {
            name: "shading".into(),
            reason: match lights.len() {
                0 => "ambient light only".to_owned(),
                1 => "the only light".into(),
                n => format!("all {n} lights at once"),
            } + &by_functions,
            colors: vec![ColorTarget {
                slot: self.drawn,
                layer: 0,
                load: Load::Clear([background.x, background.y, background.z, 1.0]),
                resolve: None,
            }],
            depth: Some(depth),
            draws,
        });
    }

    /// Where shading finds the factors of all lights on the surface whose depth is `self.depth`, and their weights.
    pub(super) fn factor_bindings(
        &mut self,
        mask: Option<SlotId>,
        lights: &[LightPlanned],
    ) -> Vec<(u32, Binding)> {
        let mut bindings = Vec::new();
        let any = |wanted: &dyn Fn(FactorAt) -> bool| {
            lights.iter().flat_map(LightPlanned::factors).any(|part| wanted(part.at))
        };
        if any(&|at| at == FactorAt::Counts) {
            bindings.push((0, Binding::StencilOf(self.depth)));
        }
        if self.multisampled() {
            bindings.extend(mask.map(|mask| (1, Binding::Texture(mask))));
        } else {
            bindings.extend(mask.map(|mask| (1, Binding::TextureArray(mask))));
        }
        if any(&|at| matches!(at, FactorAt::Visibility(_))) {
            bindings.push((2, Binding::TextureArray(self.visibility)));
        }
        bindings.extend(self.tints(lights).map(|tints| (7, Binding::Storage(tints))));
        bindings
    }

    /// What the picture loses where factors are 0, as `tints` of surface_shade: an entry for each light, and after them
    /// one for each further factor. `None` when shadows take everything, each light's in one factor.
    pub(super) fn tints(&mut self, lights: &[LightPlanned]) -> Option<SlotId> {
        if lights.iter().all(|light| light.taken == ALL_TAKEN && light.more_factors.is_empty()) {
            return None;
        }
        let (mut tints, mut further) = (Vec::new(), Vec::new());
        for light in lights {
            let first = (lights.len() + further.len()) as u32;
            let count = light.more_factors.len() as u32;
            for (part, at) in light.factors().zip(0..) {
                let [kind, index] = part.at.kind_and_index();
                // Each names the next; the last one none.
                let next = if at < count { first + at } else { 0 };
                let tint = TintUniform { taken: part.taken, next, kind, index, pad_0: 0, pad_1: 0 };
                if at == 0 { tints.push(tint) } else { further.push(tint) }
            }
        }
        tints.extend(further);
        let bytes: Vec<u8> = bytemuck::cast_slice(&tints).to_vec();
        let key = hash_of(("tints", &bytes));
        let reason = "weights and colours of shadows: what the picture loses where a factor is 0";
        Some(self.b.buffer("tints", BufferUsage::Storage, key, Arc::new(bytes), reason))
    }
}
