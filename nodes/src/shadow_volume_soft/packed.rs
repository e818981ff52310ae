//! Buffers as textures: what is looked up at many places at every pixel is read four words at once, and by software adapters
//! for all pixels of a group together.

use shadowgraph_engine::plan::{
    BlendState, CompareFunction, DrawState, Lifetime, Load, Resource, Shader, TextureDesc, TextureFormat,
};
use shadowgraph_engine::shadow::{
    Binding, ColorTarget, Draw, Geometry, LightContext, Pass, PassList, ShadowError,
};

/// Texels along a row of packed words: see pack_words.wgsl.
const PACKED_WIDTH: usize = 2048;
/// The most rows of it, which every adapter has.
const PACKED_ROWS: usize = 8192;

/// A texture of the words in `buffer`, which has `bytes` bytes; kept between frames under `key`.
pub(super) fn packed(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    name: &str,
    (buffer, bytes): (Resource, usize),
    key: Option<u64>,
) -> Result<Resource, ShadowError> {
    let texels = bytes.div_ceil(16).max(1);
    let size_px = [texels.min(PACKED_WIDTH), texels.div_ceil(PACKED_WIDTH)];
    if size_px[1] > PACKED_ROWS {
        let most = PACKED_WIDTH * PACKED_ROWS * 16;
        return Err(light.unsupported(format!("'{name}' takes {bytes} bytes (accepted: up to {most})")));
    }
    let (format, reason) = (TextureFormat::Rgba32Uint, "looked up at every pixel, four words at once");
    let words = out.texture(TextureDesc {
        lifetime: key.map_or(Lifetime::Frame, Lifetime::Kept),
        ..TextureDesc::new(name, format, size_px.map(|size| size as u32), reason)
    });
    let shader = Shader::composed("pack_words", &[], "fullscreen_vertex", Some("pack"))?;
    let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
    let draw = Draw::new(format!("{texels} texels"), Geometry::fullscreen(shader), state);
    out.pass(Pass {
        name: format!("pack {name}"),
        reason: "words to texels".into(),
        colors: vec![ColorTarget::new(words, Load::Clear([0.0; 4]))],
        depth: None,
        draws: vec![draw.reading(vec![(0, Binding::Storage(buffer))])],
    });
    Ok(words)
}
