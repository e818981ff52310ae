//! Where nothing darkens a light's visibility, it need be neither cleared nor read.
//!
//! A visibility is as large as the frame, in half floats; clearing one takes a software adapter longer than most shadows do
//! that go into it. Techniques confine their draws to where their shadows can fall. Around all these draws lie the pixels
//! that matter: there the first pass makes the visibility 1 by a draw, and shading takes it to be 1 everywhere else.

use super::assembly::{Assembly, engine_shader};
use crate::plan::{
    Binding, BlendState, CompareFunction, Draw, DrawState, Geometry, Load, Pass, SlotId, SurfaceStyle,
};

/// Of a frame that is shadowed in more than this share, all is cleared.
const WORTH_IT: f64 = 0.75;

impl Assembly<'_> {
    /// Confines the visibility to the pixels in which something darkens it (x and y from, x and y to before), and says
    /// which they are: the whole frame where that is no gain, or where anything but shading reads it.
    pub(super) fn confine_visibility(&mut self) -> [u32; 4] {
        let [width, height] = self.b.size_px;
        let whole = [0, 0, width, height];
        let visibility = self.visibility;
        let is_target = |pass: &Pass| pass.colors.iter().any(|color| color.slot == visibility);
        if self
            .b
            .passes
            .iter()
            .flat_map(|pass| &pass.draws)
            .any(|draw| reads_beyond_shading(draw, visibility))
        {
            return whole;
        }
        let draws = self.b.passes.iter().filter(|pass| is_target(pass)).flat_map(|pass| &pass.draws);
        let corners = draws.map(|draw| match draw.scissor_px {
            None => whole,
            Some([x, y, width, height]) => [x, y, x + width, y + height],
        });
        let around =
            |a: [u32; 4], b: [u32; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
        let Some([left, top, right, bottom]) = corners.reduce(around) else { return whole };
        let scissor_px = [left, top, right.saturating_sub(left), bottom.saturating_sub(top)];
        let share =
            f64::from(scissor_px[2]) * f64::from(scissor_px[3]) / f64::from(width) / f64::from(height);
        if share > WORTH_IT || share == 0.0 {
            return whole;
        }
        for pass in self.b.passes.iter_mut().filter(|pass| is_target(pass)) {
            let [color] = &mut pass.colors[..] else { continue };
            if !matches!(color.load, Load::Clear(_)) {
                continue;
            }
            color.load = Load::Anything;
            let lit = Draw {
                name: "lit".into(),
                shader: Some(engine_shader("resolve_mask", &[], "fullscreen_vertex", Some("mark"))),
                state: DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]),
                geometry: Geometry::Procedural { vertices: 3, instances: 1 },
                bindings: vec![],
                scissor_px: Some(scissor_px),
            };
            pass.draws.insert(0, lit);
        }
        [left, top, right, bottom]
    }
}

/// Whether a draw that is not the engine's own shading reads this slot.
fn reads_beyond_shading(draw: &Draw, slot: SlotId) -> bool {
    let shades = matches!(
        draw.geometry,
        Geometry::Surfaces { style: SurfaceStyle::Opaque | SurfaceStyle::Blended | SurfaceStyle::Tint, .. }
    );
    let reads = |binding: &Binding| match binding {
        Binding::Texture(read) | Binding::TextureArray(read) | Binding::TextureLayer(read, _) => {
            *read == slot
        }
        Binding::Storage(_) | Binding::StencilOf(_) => false,
    };
    (!shades || draw.shader.is_some()) && draw.bindings.iter().any(|(_, binding)| reads(binding))
}
