//! Two draws over the picture: one marks the pixels that may see a part of the light only, the other asks these.

use shadowgraph_engine::plan::{
    Access, CompareFunction, DrawState, MULTIPLY, Shader, TextureDesc, TextureFormat,
};
use shadowgraph_engine::shadow::{
    Binding, Channels, ColorTarget, Contribution, DepthTarget, Draw, Geometry, LightContext, Pass, PassList,
};

/// Adds the passes. `mark` is a shader whose fragment entry point marks by writing depth 1, `ask` one that leaves the
/// factor of what is marked; `reason` says what is asked, `asked` what there is to ask.
pub(super) fn mark_and_ask(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    bindings: Vec<(u32, Binding)>,
    [mark, ask]: [Shader; 2],
    (reason, asked): (String, String),
) -> Contribution {
    let name = &light.light().name;
    let marks = out.texture(TextureDesc::new(
        &format!("soft marks of {name}"),
        TextureFormat::Depth32Float,
        light.view.size_px,
        "1 where the light may be seen partly: depth, for adapters skip by it",
    ));
    let marking = DrawState { depth_write: true, ..DrawState::new(CompareFunction::Always, vec![]) };
    let every_pixel = Draw::new("every pixel", Geometry::fullscreen(mark), marking);
    out.pass(Pass {
        name: format!("mark what {name} may light partly"),
        reason: "the rest is lit, and most of the picture".into(),
        colors: vec![],
        depth: Some(DepthTarget::new(marks, Access::Clear(0.0))),
        draws: vec![every_pixel.reading(bindings.clone())],
    });
    // The draw is at depth 0.
    let asking = DrawState::new(CompareFunction::Less, vec![Some(MULTIPLY)]);
    out.pass(Pass {
        name: format!("soft shadow of {name}"),
        reason,
        colors: vec![ColorTarget::VISIBILITY],
        depth: Some(DepthTarget::new(marks, Access::ReadOnly)),
        draws: vec![Draw::new(asked, Geometry::fullscreen(ask), asking).reading(bindings)],
    });
    Contribution { own_shadow: true, ..Contribution::visibility(Channels::One) }
}
