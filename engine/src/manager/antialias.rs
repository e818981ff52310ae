//! The finished picture, of what was drawn in several samples or at twice the size.

use super::assembly::{Assembly, engine_shader};
use crate::plan::{Antialias, Binding, BlendState, ColorTarget, CompareFunction, DrawState, Load, Pass};

impl Assembly<'_> {
    /// Averages what was drawn into the picture, where they are not the same.
    pub(super) fn finish_picture(&mut self) {
        let (drawn, picture) = (self.drawn, self.picture);
        match self.request.antialias {
            Antialias::None => {}
            Antialias::Multisample4 => {
                // The last pass that draws into it resolves it.
                let passes = self.b.passes.iter_mut().rev();
                let last = passes.flat_map(|pass| &mut pass.colors).find(|color| color.slot == drawn);
                last.into_iter().for_each(|color| color.resolve = Some(picture));
            }
            Antialias::Supersample4 => {
                let load = Load::Clear([0.0; 4]);
                let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
                let mut draw = self.resolve_draw("average", state);
                draw.shader =
                    Some(engine_shader("average_pixels", &[], "fullscreen_vertex", Some("average")));
                draw.bindings = vec![(0, Binding::Texture(drawn))];
                self.b.passes.push(Pass {
                    name: "average".into(),
                    reason: "ssaa4: the mean of four pixels, in tone-mapped linear light".into(),
                    colors: vec![ColorTarget { slot: picture, layer: 0, load, resolve: None }],
                    depth: None,
                    draws: vec![draw],
                });
            }
        }
    }
}
