//! The passes and draws of one receiver.

use shadowgraph_engine::plan::{
    Access, Binding, BlendComponent, BlendFactor, BlendOperation, BlendState, ColorTarget, CompareFunction,
    DepthTarget, Draw, DrawState, Geometry, Load, MULTIPLY, Pass, Shader, SlotId, Stencil, StencilFaceState,
    StencilOperation, SurfaceStyle, TextureFormat,
};
use shadowgraph_engine::shadow::{Channels, LightPlan, hash_of};

use super::canvas::Canvas;
use super::casters::{Batch, Casters};
use super::receivers::Receiver;
use super::{Lit, POINTS_OF_A_LAYER};

/// Where the shader finds which triangle is seen.
const VISIBLE_TRIANGLES: u32 = 8;
/// What marks a receiver's pixels before any point does. Points count down from here.
const RECEIVER: u8 = 255;

/// Marks one bit for each point of the light where the casters' shadows fall on `canvas`; returns the bits.
pub(super) fn mark(
    light: &mut LightPlan<'_>,
    canvas: &Canvas,
    (receiver, lit, casters): (&Receiver, &Lit, &Casters),
) -> SlotId {
    let heights = &lit.heights;
    let matrices = canvas.matrices(light, receiver, lit, casters);
    let (bits, stencil) = canvas.targets(light, heights.len());
    let shaders: Vec<Shader> = casters.batches.iter().map(caster_shader).collect();
    let name = light.light().name.clone();
    for (layer, heights) in heights.chunks(POINTS_OF_A_LAYER).enumerate() {
        // All of a texture lies on the receiver's plane; of the picture, what shows it.
        let (mut draws, cleared) = if canvas.key.is_some() {
            (vec![], RECEIVER)
        } else {
            let depth = [(3, Binding::Texture(light.receiver_depth()))];
            (receiver_draws(light, receiver, "mark_receiver", &depth, &mark_state()), 0)
        };
        for (place, _) in heights.iter().enumerate().filter(|(_, height)| **height > 0.0) {
            let number = layer * POINTS_OF_A_LAYER + place;
            let first_caster = (number * casters.centers.len()) as u32;
            let batches = casters.batches.iter().zip(&shaders).filter(|(batch, _)| batch.runs[number].1 > 0);
            draws.extend(
                batches.map(|(batch, shader)| caster_draw(batch, shader, matrices, (number, first_caster))),
            );
        }
        let (count, on) = (casters.centers.len(), if canvas.key.is_some() { "a texture of" } else { "" });
        light.pass(Pass {
            name: format!("shadows on {} from {name}", receiver.name),
            reason: format!(
                "casters flattened onto {on} the plane: {count}, points of the light: {}",
                heights.len()
            )
            .replace("  ", " "),
            colors: vec![ColorTarget {
                slot: bits,
                layer: layer as u32,
                load: Load::Clear([0.0; 4]),
                resolve: None,
            }],
            depth: Some(DepthTarget {
                slot: stencil,
                depth: Access::ReadOnly,
                stencil: Some(Access::Clear(f32::from(cleared))),
            }),
            draws,
        });
    }
    bits
}

/// Weighs the bits of the picture into the light's visibility.
pub(super) fn weigh(
    light: &mut LightPlan<'_>,
    canvas: &Canvas,
    receiver: &Receiver,
    lit: &Lit,
    bits: SlotId,
) {
    let points = canvas.points(light, receiver, lit);
    let bindings = [(4, Binding::TextureArray(bits)), (5, Binding::Storage(points))];
    shade(light, receiver, "share", &bindings, "the share of the light's points that see the receiver");
}

/// Weighs the bits of a texture into a texture, and puts it on the receiver.
pub(super) fn weigh_texture(
    light: &mut LightPlan<'_>,
    canvas: &Canvas,
    receiver: &Receiver,
    lit: &Lit,
    bits: SlotId,
) {
    let Some(key) = canvas.key else { return };
    let name = light.light().name.clone();
    let points = canvas.points(light, receiver, lit);
    let reason = "the share of the light's points that see the receiver, until something moves";
    let shares =
        light.kept_texture("shadow texture", TextureFormat::R16Float, canvas.size_px, 1, key, reason);
    light.pass(Pass {
        name: format!("texture of {} from {name}", receiver.name),
        reason: "the share of the light's points that see each texel".into(),
        colors: vec![ColorTarget { slot: shares, layer: 0, load: Load::Clear([1.0; 4]), resolve: None }],
        depth: None,
        draws: vec![Draw {
            name: "texels".into(),
            shader: Some(shader(&["RECEIVER"], "fullscreen_vertex", "share_of_texel")),
            state: DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]),
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings: vec![(4, Binding::TextureArray(bits)), (5, Binding::Storage(points))],
            scissor_px: None,
        }],
    });
    let reason = "each texel with its neighbours, so that a pixel reads one texel and not four";
    let quads =
        light.kept_texture("texels in fours", TextureFormat::Rgba16Float, canvas.size_px, 1, key, reason);
    light.pass(Pass {
        name: format!("texels of {} from {name}", receiver.name),
        reason: "each beside its neighbours".into(),
        colors: vec![ColorTarget { slot: quads, layer: 0, load: Load::Clear([1.0; 4]), resolve: None }],
        depth: None,
        draws: vec![Draw {
            name: "texels".into(),
            shader: Some(shader(&["RECEIVER"], "fullscreen_vertex", "four_texels")),
            state: DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]),
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings: vec![(6, Binding::Texture(shares))],
            scissor_px: None,
        }],
    });
    let place = canvas.place(light, receiver);
    let bindings = [(6, Binding::Texture(quads)), (7, Binding::Storage(place))];
    shade(light, receiver, "share_from_texture", &bindings, "the receiver wears its texture");
}

/// Darkens the light's visibility where the receiver is the visible surface.
fn shade(
    light: &mut LightPlan<'_>,
    receiver: &Receiver,
    fragment: &'static str,
    bindings: &[(u32, Binding)],
    reason: &str,
) {
    let state = DrawState::new(CompareFunction::Equal, vec![Some(MULTIPLY)]);
    let poses = receiver.instances.iter().map(|index| light.posed.instances[*index].pose_key);
    let key = hash_of(("overlaps", poses.collect::<Vec<_>>()));
    let posed = light.posed;
    let overlaps = *light.cache.get_or_compute("overlaps", key, || receiver.overlaps_itself(posed));
    let mut bindings = bindings.to_vec();
    if overlaps {
        bindings.push((VISIBLE_TRIANGLES, Binding::Texture(light.visible_triangles())));
    }
    let draws = receiver_draws(light, receiver, fragment, &bindings, &state);
    let target = light.multiply_visibility(Channels::One);
    light.pass(Pass {
        name: format!("share of {} on {}", light.light().name, receiver.name),
        reason: reason.into(),
        colors: vec![target],
        depth: Some(light.test_depth()),
        draws,
    });
}

/// Marks the receiver's pixels, and clears what other receivers have left.
fn mark_state() -> DrawState {
    let face = StencilFaceState {
        compare: CompareFunction::Always,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op: StencilOperation::Replace,
    };
    let mut state = DrawState::new(CompareFunction::Always, vec![None]);
    state.stencil =
        Some(Stencil { front: face, back: face, read_mask: 0xff, write_mask: 0xff, reference: RECEIVER });
    state
}

/// The surfaces of a receiver, by an entry point of the receivers' half of the shader.
fn receiver_draws(
    light: &LightPlan<'_>,
    receiver: &Receiver,
    fragment: &'static str,
    bindings: &[(u32, Binding)],
    state: &DrawState,
) -> Vec<Draw> {
    // With holes or without, (instance, part), vertices.
    type Run = (bool, Vec<(u32, u32)>, u64);
    let mut runs: Vec<Run> = Vec::new();
    for index in &receiver.instances {
        let instance = &light.posed.instances[*index];
        for (part, material) in instance.materials.iter().enumerate().filter(|(_, m)| m.is_opaque()) {
            let masked = material.cutoff().is_some();
            let vertices = instance.mesh.data().parts[part].triangles.len() as u64 * 3;
            let part = (*index as u32, part as u32);
            match runs.last_mut() {
                Some((m, parts, sum)) if *m == masked => {
                    parts.push(part);
                    *sum += vertices;
                }
                _ => runs.push((masked, vec![part], vertices)),
            }
        }
    }
    let asks_triangle = bindings.iter().any(|(number, _)| *number == VISIBLE_TRIANGLES);
    let draw = |(masked, parts, vertices): Run| {
        let (style, flags): (_, &[&str]) = if masked {
            // A mask without a texture reads a white one: no variant of its own.
            (SurfaceStyle::PulledMasked, &["RECEIVER", "MASKED", "BASE_COLOR_TEXTURE", "SECOND_UV"])
        } else {
            (SurfaceStyle::Pulled, &["RECEIVER"])
        };
        let once: &[&str] = if asks_triangle { &["OVERLAPS"] } else { &[] };
        let flags = &[flags, once].concat();
        Draw {
            name: receiver.name.clone(),
            shader: Some(shader(flags, "receiver", fragment)),
            state: state.clone(),
            geometry: Geometry::Surfaces { style, parts, vertices },
            bindings: bindings.to_vec(),
            scissor_px: None,
        }
    };
    runs.into_iter().map(draw).collect()
}

fn caster_shader(batch: &Batch) -> Shader {
    let flags: &[&str] = match (batch.masked, batch.image) {
        (false, _) => &[],
        (true, None) => &["MASKED"],
        (true, Some(_)) => &["MASKED", "BASE_COLOR_TEXTURE"],
    };
    shader(flags, "flatten", "mark_shadow")
}

/// The triangles of a batch as point number `number` of the light flattens them.
fn caster_draw(
    batch: &Batch,
    shader: &Shader,
    matrices: SlotId,
    (number, first_caster): (usize, u32),
) -> Draw {
    let place = number % POINTS_OF_A_LAYER;
    let (first, count) = batch.runs[number];
    // Passes where the reference is below what is stored: on the receiver, where this point has not marked yet.
    let face = StencilFaceState {
        compare: CompareFunction::Less,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op: StencilOperation::Replace,
    };
    let reference = RECEIVER - 1 - place as u8;
    let mut state = DrawState::new(CompareFunction::Always, vec![Some(ADD_CONSTANT)]);
    state.stencil = Some(Stencil { front: face, back: face, read_mask: 0xff, write_mask: 0xff, reference });
    state.blend_constant[place / 8] = f64::from(1_u32 << (place % 8)) / 255.0;
    let mut bindings = vec![(0, Binding::Storage(batch.corners)), (1, Binding::Storage(matrices))];
    bindings.extend(batch.image.map(|image| (2, Binding::Texture(image))));
    Draw {
        name: format!("point {number}"),
        shader: Some(shader.clone()),
        state,
        geometry: Geometry::Listed { indices: batch.indices, first, count, record: first_caster },
        bindings,
        scissor_px: None,
    }
}

/// Adds the blend constant: one bit of one channel.
const ADD_CONSTANT: BlendState = {
    let add = BlendComponent {
        src_factor: BlendFactor::Constant,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    };
    BlendState { color: add, alpha: add }
};

/// A shader of this technique's own; its text is checked by a test, so composing it cannot fail.
fn shader(flags: &[&str], vertex: &'static str, fragment: &'static str) -> Shader {
    let source = shadowgraph_shaders::compose_named("soft_shadow", flags).unwrap_or_default();
    let name = [&["soft_shadow"], flags].concat().join(" ");
    Shader {
        name: name.into(),
        source: source.into(),
        vertex: vertex.into(),
        fragment: Some(fragment.into()),
    }
}
