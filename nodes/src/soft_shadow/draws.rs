//! The passes and draws of one receiver.

use shadowgraph_engine::plan::{
    Access, BlendComponent, BlendFactor, BlendOperation, BlendState, CompareFunction, DrawState, Lifetime,
    Load, MULTIPLY, PulledStyle, Resource, Shader, ShaderError, Stencil, StencilFaceState, StencilOperation,
    TextureDesc, TextureFormat,
};
use shadowgraph_engine::shadow::{
    Binding, ColorTarget, DepthTarget, Draw, Geometry, LightContext, Pass, PassList, hash_of,
};

use super::batches::{Batch, Kind};
use super::canvas::{Canvas, Targets};
use super::casters::Casters;
use super::receivers::Receiver;
use super::{Lit, POINTS_OF_A_LAYER};

/// Where the shader finds which triangle is seen.
const VISIBLE_TRIANGLES: u32 = 8;
/// What marks a receiver's pixels before any point does. Points count down from here.
const RECEIVER: u8 = 255;

/// Marks one bit for each point of the light where the casters' shadows fall on `canvas`.
pub(super) fn mark(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    (canvas, Targets { bits, stencil }): (&Canvas, Targets),
    (receiver, lit, casters): (&Receiver, &Lit, &Casters),
) -> Result<(), ShaderError> {
    let heights = &lit.heights;
    let matrices = canvas.matrices(light, out, (receiver, lit, casters));
    let shaders = casters.opaque().map(caster_shader).collect::<Result<Vec<_>, _>>()?;
    let name = light.light().name.clone();
    for (layer, heights) in heights.chunks(POINTS_OF_A_LAYER).enumerate() {
        // All of a texture lies on the receiver's plane; of the picture, what shows it.
        let (mut draws, cleared) = if canvas.key.is_some() {
            (vec![], RECEIVER)
        } else {
            let depth = [(3, Binding::Texture(out.receiver_depth()))];
            (receiver_draws(light, receiver, "mark_receiver", &depth, &mark_state())?, 0)
        };
        for (place, _) in heights.iter().enumerate().filter(|(_, height)| **height > 0.0) {
            let number = layer * POINTS_OF_A_LAYER + place;
            let first_caster = (number * casters.centers.len()) as u32;
            let batches = casters.opaque().zip(&shaders).filter(|(batch, _)| batch.runs[number].1 > 0);
            draws.extend(
                batches.map(|(batch, shader)| caster_draw(batch, shader, matrices, (number, first_caster))),
            );
        }
        let (count, on) = (casters.centers.len(), if canvas.key.is_some() { "a texture of" } else { "" });
        out.pass(Pass {
            name: format!("shadows on {} from {name}", receiver.name),
            reason: format!(
                "casters flattened onto {on} the plane: {count}, points of the light: {}",
                heights.len()
            )
            .replace("  ", " "),
            colors: vec![ColorTarget {
                layer: layer as u32,
                ..ColorTarget::new(bits, Load::Clear([0.0; 4]))
            }],
            depth: Some(DepthTarget {
                stencil: Some(Access::Clear(f32::from(cleared))),
                ..DepthTarget::new(stencil, Access::ReadOnly)
            }),
            draws,
        });
    }
    Ok(())
}

/// Weighs the bits of the picture into the light's visibility.
pub(super) fn weigh(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    canvas: &Canvas,
    (receiver, lit): (&Receiver, &Lit),
    bits: Resource,
) -> Result<(), ShaderError> {
    let points = canvas.points(light, out, (receiver, lit));
    let bindings = [(4, Binding::TextureArray(bits)), (5, Binding::Storage(points))];
    let reason = "the share of the light's points that see the receiver";
    shade(light, out, receiver, ("share", reason), &bindings)
}

/// Weighs the bits of a texture into a texture, and puts it on the receiver.
pub(super) fn weigh_texture(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    canvas: &Canvas,
    (receiver, lit): (&Receiver, &Lit),
    bits: Resource,
) -> Result<(), ShaderError> {
    let (name, on) = (&light.light().name, &receiver.name);
    let points = canvas.points(light, out, (receiver, lit));
    let bindings = vec![(4, Binding::TextureArray(bits)), (5, Binding::Storage(points))];
    let names = ("shadow texture", format!("texture of {on} from {name}"));
    let reasons = (
        "the share of the light's points that see the receiver, until something moves",
        "the share of the light's points that see each texel",
    );
    let shares =
        texels(out, canvas, TextureFormat::R16Float, (names, reasons), ("share_of_texel", bindings))?;
    let bindings = vec![(6, Binding::Texture(shares))];
    let names = ("texels in fours", format!("texels of {on} from {name}"));
    let reasons = (
        "each texel with its neighbours, so that a pixel reads one texel and not four",
        "each beside its neighbours",
    );
    let quads = texels(out, canvas, TextureFormat::Rgba16Float, (names, reasons), ("four_texels", bindings))?;
    let place = canvas.place(light, out, receiver);
    let bindings = [(6, Binding::Texture(quads)), (7, Binding::Storage(place))];
    shade(light, out, receiver, ("share_from_texture", "the receiver wears its texture"), &bindings)
}

/// A texture that is drawn texel by texel and kept with the canvas. Names and reasons are those of the texture, then of the
/// pass.
fn texels(
    out: &mut PassList<'_>,
    canvas: &Canvas,
    format: TextureFormat,
    ((name, pass), (reason, why)): ((&str, String), (&str, &str)),
    (fragment, bindings): (&'static str, Vec<(u32, Binding)>),
) -> Result<Resource, ShaderError> {
    let lifetime = canvas.key.map_or(Lifetime::Frame, Lifetime::Kept);
    let texture =
        out.texture(TextureDesc { lifetime, ..TextureDesc::new(name, format, canvas.size_px, reason) });
    let geometry = Geometry::fullscreen(shader(&["RECEIVER"], "fullscreen_vertex", fragment)?);
    let state = DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]);
    out.pass(Pass {
        name: pass,
        reason: why.into(),
        colors: vec![ColorTarget::new(texture, Load::Clear([1.0; 4]))],
        depth: None,
        draws: vec![Draw::new("texels", geometry, state).reading(bindings)],
    });
    Ok(texture)
}

/// Darkens the light's visibility where the receiver is the visible surface.
pub(super) fn shade(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    receiver: &Receiver,
    (fragment, reason): (&'static str, &str),
    bindings: &[(u32, Binding)],
) -> Result<(), ShaderError> {
    let draws = visible_draws(light, out, receiver, (fragment, MULTIPLY), bindings)?;
    out.pass(Pass {
        name: format!("share of {} on {}", light.light().name, receiver.name),
        reason: reason.into(),
        colors: vec![ColorTarget::VISIBILITY],
        depth: Some(DepthTarget::TEST),
        draws,
    });
    Ok(())
}

/// The surfaces of a receiver where they are what is seen, each pixel once.
pub(super) fn visible_draws(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    receiver: &Receiver,
    (fragment, blend): (&'static str, BlendState),
    bindings: &[(u32, Binding)],
) -> Result<Vec<Draw>, ShaderError> {
    let state = DrawState::new(CompareFunction::Equal, vec![Some(blend)]);
    let poses = receiver.instances.iter().map(|index| light.snapshot.instances[*index].pose_key);
    let key = hash_of(("overlaps", poses.collect::<Vec<_>>()));
    let overlaps = *light.cache.get_or_compute("overlaps", key, || receiver.overlaps_itself(light.snapshot));
    let mut bindings = bindings.to_vec();
    if overlaps {
        bindings.push((VISIBLE_TRIANGLES, Binding::Texture(out.visible_triangles())));
    }
    receiver_draws(light, receiver, fragment, &bindings, &state)
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
    light: &LightContext<'_>,
    receiver: &Receiver,
    fragment: &'static str,
    bindings: &[(u32, Binding)],
    state: &DrawState,
) -> Result<Vec<Draw>, ShaderError> {
    // With holes or without, (instance, part), vertices.
    type Run = (bool, Vec<(u32, u32)>, u64);
    let mut runs: Vec<Run> = Vec::new();
    for index in &receiver.instances {
        let instance = &light.snapshot.instances[*index];
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
            (PulledStyle::PulledMasked, &["RECEIVER", "MASKED", "BASE_COLOR_TEXTURE", "SECOND_UV"])
        } else {
            (PulledStyle::Pulled, &["RECEIVER"])
        };
        let once: &[&str] = if asks_triangle { &["OVERLAPS"] } else { &[] };
        let flags = &[flags, once].concat();
        let shader = shader(flags, "receiver", fragment)?;
        let geometry = Geometry::PulledSurfaces { shader, style, parts, vertices };
        Ok(Draw::new(&receiver.name, geometry, state.clone()).reading(bindings.to_vec()))
    };
    runs.into_iter().map(draw).collect()
}

/// The shader that marks the shadow of a batch, or tints by its glass.
pub(super) fn caster_shader(batch: &Batch) -> Result<Shader, ShaderError> {
    let (kind, fragment) = match batch.kind {
        Kind::Whole => (None, "mark_shadow"),
        Kind::Masked => (Some("MASKED"), "mark_shadow"),
        Kind::Glass => (Some("GLASS"), "tint"),
    };
    let texture = batch.image.map(|_| "BASE_COLOR_TEXTURE");
    let flags: Vec<&str> = kind.into_iter().chain(texture).collect();
    shader(&flags, "flatten", fragment)
}

/// The triangles of a batch as point number `number` of the light flattens them.
fn caster_draw(
    batch: &Batch,
    shader: &Shader,
    matrices: Resource,
    (number, first_caster): (usize, u32),
) -> Draw {
    let place = number % POINTS_OF_A_LAYER;
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
    flattened((batch, shader), matrices, (number, first_caster), state)
}

/// The triangles of a batch, flattened from point number `number` of the light.
pub(super) fn flattened(
    (batch, shader): (&Batch, &Shader),
    matrices: Resource,
    (number, first_caster): (usize, u32),
    state: DrawState,
) -> Draw {
    let (first, count) = batch.runs[number];
    let mut bindings = vec![(0, Binding::Storage(batch.corners)), (1, Binding::Storage(matrices))];
    bindings.extend(batch.image.map(|image| (2, Binding::Texture(image))));
    let (shader, indices) = (shader.clone(), batch.indices);
    let geometry = Geometry::IndexedProcedural { shader, indices, first, count, record: first_caster };
    Draw::new(format!("point {number}"), geometry, state).reading(bindings)
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

/// A shader of this technique's own.
pub(super) fn shader(
    flags: &[&str],
    vertex: &'static str,
    fragment: &'static str,
) -> Result<Shader, ShaderError> {
    Shader::composed("soft_shadow", flags, vertex, Some(fragment))
}
