//! Buffers as textures: what is looked up at many places at every pixel is read four words at once, and by software adapters
//! for all pixels of a group together.

use shadowgraph_engine::plan::{
    Binding, BlendState, ColorTarget, CompareFunction, Draw, DrawState, Geometry, Load, Pass, Shader, SlotId,
    TextureFormat,
};
use shadowgraph_engine::shadow::{LightPlan, ShadowError};

/// Texels along a row of packed words: see pack_words.wgsl.
const PACKED_WIDTH: usize = 2048;
/// The most rows of it, which every adapter has.
const PACKED_ROWS: usize = 8192;

/// A texture of the words in `buffer`, which has `bytes` bytes; kept between frames under `key`.
pub(super) fn packed(
    light: &mut LightPlan<'_>,
    name: &str,
    buffer: SlotId,
    bytes: usize,
    key: Option<u64>,
) -> Result<SlotId, ShadowError> {
    let texels = bytes.div_ceil(16).max(1);
    let size_px = [texels.min(PACKED_WIDTH), texels.div_ceil(PACKED_WIDTH)];
    if size_px[1] > PACKED_ROWS {
        let most = PACKED_WIDTH * PACKED_ROWS * 16;
        return Err(light.unsupported(format!("'{name}' takes {bytes} bytes (accepted: up to {most})")));
    }
    let size_px = size_px.map(|size| size as u32);
    let (format, reason) = (TextureFormat::Rgba32Uint, "looked up at every pixel, four words at once");
    let slot = match key {
        Some(key) => light.kept_texture(name, format, size_px, 1, key, reason),
        None => light.texture(name, format, size_px, 1, reason),
    };
    let source = shadowgraph_shaders::compose_named("pack_words", &[]).unwrap_or_default();
    light.pass(Pass {
        name: format!("pack {name}"),
        reason: "words to texels".into(),
        colors: vec![ColorTarget { slot, layer: 0, load: Load::Clear([0.0; 4]), resolve: None }],
        depth: None,
        draws: vec![Draw {
            name: format!("{texels} texels"),
            shader: Some(Shader {
                name: "pack_words".into(),
                source: source.into(),
                vertex: "fullscreen_vertex".into(),
                fragment: Some("pack".into()),
            }),
            state: DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]),
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings: vec![(0, Binding::Storage(buffer))],
            scissor_px: None,
        }],
    });
    Ok(slot)
}
