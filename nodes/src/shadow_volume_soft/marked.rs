//! Two draws over the picture: one marks the pixels that may see a part of the light only, the other asks these.

use shadowgraph_engine::plan::{
    Access, Binding, CompareFunction, DepthTarget, Draw, DrawState, Geometry, MULTIPLY, Pass, Shader,
    TextureFormat,
};
use shadowgraph_engine::shadow::{Channels, LightPlan};

/// Adds the passes. `mark` is a shader whose fragment entry point marks by writing depth 1, `ask` one that leaves the
/// factor of what is marked; `reason` says what is asked, `asked` what there is to ask.
pub(super) fn mark_and_ask(
    light: &mut LightPlan<'_>,
    bindings: Vec<(u32, Binding)>,
    [mark, ask]: [Shader; 2],
    (reason, asked): (String, String),
) {
    let name = light.light().name.clone();
    light.decides_own_shadow();
    let fullscreen = |name: String, shader: Shader, state: DrawState, bindings| Draw {
        name,
        shader: Some(shader),
        state,
        geometry: Geometry::Procedural { vertices: 3, instances: 1 },
        bindings,
        scissor_px: None,
    };
    let (format, size_px) = (TextureFormat::Depth32Float, light.view.size_px);
    let why = "1 where the light may be seen partly: depth, for adapters skip by it";
    let marks = light.texture(&format!("soft marks of {name}"), format, size_px, 1, why);
    let marking = DrawState { depth_write: true, ..DrawState::new(CompareFunction::Always, vec![]) };
    light.pass(Pass {
        name: format!("mark what {name} may light partly"),
        reason: "the rest is lit, and most of the picture".into(),
        colors: vec![],
        depth: Some(DepthTarget { slot: marks, depth: Access::Clear(0.0), stencil: None }),
        draws: vec![fullscreen("every pixel".into(), mark, marking, bindings.clone())],
    });
    let target = light.multiply_visibility(Channels::One);
    // The draw is at depth 0.
    let asking = DrawState::new(CompareFunction::Less, vec![Some(MULTIPLY)]);
    light.pass(Pass {
        name: format!("soft shadow of {name}"),
        reason,
        colors: vec![target],
        depth: Some(DepthTarget { slot: marks, depth: Access::ReadOnly, stencil: None }),
        draws: vec![fullscreen(asked, ask, asking, bindings)],
    });
}
