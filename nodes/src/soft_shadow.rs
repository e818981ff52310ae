//! `SoftShadow`: soft shadows on planes, by flattening the casters from each point of the light.
//!
//! *The idea.* What a light's point leaves dark on a plane is the casters' triangles projected onto it. They are drawn
//! there, once for each of `samples` points of the light, and a pixel of the receiver gets the share of points that none
//! of them hides. Any plane receives; any triangles cast.
//!
//! *Sources.* Blinn 1988; Lindrud & Löfgren 2004 §5.2, whose node had this name and its faults: here are their cures.
//!
//! - *Shadows past the receiver's edge.* Only pixels in which the receiver is the visible surface are shaded.
//! - *Double darkening.* A point of the light marks a pixel once: the stencil holds the number of the point that marked it
//!   last, and a point's own number does not mark again. What is marked is one bit, so each point's shadow is known by
//!   itself.
//! - *Shadows of what is behind the light.* Their w is negative, and clipped: see [`casters::clip_from_caster`].
//! - *Shadows of what is under the plane.* Cut off on the CPU, in f64, with all that lies in the plane itself.
//! - *Fixed points are not the light.* The light is a disc that each receiver sees at another angle. The points are spread
//!   in a ball so that they look like that disc from everywhere, weighed for nearness: see [`points`]. With their number
//!   the factor converges to the exact one.
//!
//! Which side of the plane is lit is decided by the eye: what is seen is the side it is on. Points of the light on the
//! other side are dark there.
//!
//! This file says what is drawn; `options` how it is asked for, `receivers` where, `casters` what, `points` from where.
//!
//! *Limits.* `samples` points give steps in penumbrae, and an error that falls about as samples^-0.8. Rasterisation snaps
//! vertices to 1/256 pixel. Receivers that are not planar are refused.

mod casters;
mod options;
mod points;
mod receivers;

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use shadowgraph_engine::plan::{
    Access, Binding, BlendComponent, BlendFactor, BlendOperation, BlendState, BufferUsage, ColorTarget,
    CompareFunction, DepthTarget, Draw, DrawState, Geometry, Load, MULTIPLY, Pass, Shader, SlotId, Stencil,
    StencilFaceState, StencilOperation, SurfaceStyle, TextureFormat,
};
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{Channels, LightPlan, LightSize, ShadowError, ShadowTechnique, hash_of};

pub use casters::MaskedCorner;
use casters::{Batch, Casters, clip_from_caster};
use options::TYPE_NAME;
pub use options::{MAX_RESOLUTION, MAX_SAMPLES, PlanarMode, SoftShadow};
use points::LightPoints;
pub use receivers::{Flat, NotPlanar};
use receivers::{Receiver, height_of};

/// The head of `struct PlanarLight` of soft_shadow.wgsl, which its points follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct PlanarLight {
    pub center: [f32; 3],
    pub radius_m: f32,
    pub count: u32,
    pub center_point: u32,
    pub pad_0: u32,
    pub pad_1: u32,
}

/// Points whose bits one layer holds.
const POINTS_OF_A_LAYER: usize = 32;
/// What marks a receiver's pixels before any point does. Points count down from here.
const RECEIVER: u8 = 255;

impl ShadowTechnique for SoftShadow {
    fn type_name(&self) -> &'static str {
        TYPE_NAME
    }

    fn params(&self) -> Params {
        self.to_params()
    }

    fn known_error(&self) -> &'static str {
        "a light is as many points as there are samples: steps in penumbrae, by an error of about 0.4 samples^-0.8; and \
         rasterisation: pixels whose centre is within 1/256 pixel of a point's shadow edge"
    }

    fn light_size(&self) -> LightSize {
        LightSize { radius_m: self.radius_m, half_angle_rad: self.angle_deg.to_radians() }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.materials.iter().any(|material| material.casts_whole() || material.casts_by_texel()))
    }

    fn shades_receivers_only(&self) -> bool {
        true
    }

    fn receives(&self, instance: &Instance) -> Result<(), String> {
        Flat::of(instance).map(|_| ()).map_err(|reason| reason.to_string())
    }

    fn plan(&self, light: &mut LightPlan<'_>) -> Result<(), ShadowError> {
        let receivers = Receiver::all(light)?;
        let lit: Vec<Lit> = receivers.iter().map(|receiver| Lit::new(self, light, receiver)).collect();
        // Turned to the light or away from it as a whole, a receiver's own shadow is the engine's to know.
        let cut = lit.iter().any(|lit| lit.is_cut());
        if cut {
            light.decides_own_shadow();
        }
        for (receiver, lit) in receivers.iter().zip(&lit) {
            if cut || lit.heights.iter().any(|height| *height > 0.0) {
                shade(light, receiver, lit);
            }
        }
        Ok(())
    }
}

/// A light's points, and how high they stand over a receiver.
struct Lit {
    points: LightPoints,
    heights: Vec<f64>,
}

impl Lit {
    fn new(options: &SoftShadow, light: &mut LightPlan<'_>, receiver: &Receiver) -> Self {
        let posed = light.light();
        let plane = &receiver.flat.plane;
        let height_m = height_of(plane, posed.position).abs();
        let nearest_m = receiver.bounds.distance(posed.position.truncate()).max(height_m);
        let size = options.light_size();
        let points = LightPoints::new(light.cache, posed, size, options.samples, (plane.normal, nearest_m));
        let heights = points.positions.iter().map(|point| height_of(plane, *point)).collect();
        Self { points, heights }
    }

    /// Whether the plane cuts the light.
    fn is_cut(&self) -> bool {
        let above = self.heights.iter().filter(|height| **height > 0.0).count();
        above > 0 && above < self.heights.len()
    }
}

/// The shadow on one plane.
fn shade(light: &mut LightPlan<'_>, receiver: &Receiver, Lit { points, heights }: &Lit) {
    let casters = Casters::of(light, receiver, points);
    let all_above = heights.iter().all(|height| *height > 0.0);
    if casters.batches.is_empty() && all_above {
        return;
    }
    let matrices = matrices(light, receiver, points, &casters);
    let record = record(light, receiver, points, heights);
    let (name, count) = (light.light().name.clone(), points.positions.len());
    let format = match count {
        ..=8 => TextureFormat::R8Unorm,
        9..=16 => TextureFormat::Rg8Unorm,
        _ => TextureFormat::Rgba8Unorm,
    };
    let layers = count.div_ceil(POINTS_OF_A_LAYER) as u32;
    let size_px = light.view.size_px;
    let reason = format!("one bit for each of {count} points of a light");
    let bits = light.scratch_texture("shadowed bits", format, size_px, layers, &reason);
    let reason = "which pixels show the receiver, and which point of the light marked them last";
    let stencil = light.scratch_texture("receiver stencil", TextureFormat::Stencil8, size_px, 1, reason);
    let shaders: Vec<Shader> = casters.batches.iter().map(caster_shader).collect();
    let batches = || casters.batches.iter().zip(&shaders);
    for (layer, heights) in heights.chunks(POINTS_OF_A_LAYER).enumerate() {
        let mut draws = receiver_draws(
            light,
            receiver,
            "mark_receiver",
            &[(3, Binding::Texture(light.receiver_depth()))],
            &mark_state(),
        );
        for (place, _) in heights.iter().enumerate().filter(|(_, height)| **height > 0.0) {
            let number = layer * POINTS_OF_A_LAYER + place;
            let first_caster = (number * casters.centers.len()) as u32;
            draws.extend(
                batches().map(|(batch, shader)| caster_draw(batch, shader, matrices, (number, first_caster))),
            );
        }
        light.pass(Pass {
            name: format!("shadows on {} from {name}", receiver.name),
            reason: format!(
                "{} casters flattened onto the plane, from each of {} points of the light",
                casters.centers.len(),
                heights.len()
            ),
            colors: vec![ColorTarget {
                slot: bits,
                layer: layer as u32,
                load: Load::Clear([0.0; 4]),
                resolve: None,
            }],
            depth: Some(DepthTarget {
                slot: stencil,
                depth: Access::ReadOnly,
                stencil: Some(Access::Clear(0.0)),
            }),
            draws,
        });
    }
    let state = DrawState::new(CompareFunction::Equal, vec![Some(MULTIPLY)]);
    let bindings = [(4, Binding::TextureArray(bits)), (5, Binding::Storage(record))];
    let draws = receiver_draws(light, receiver, "share", &bindings, &state);
    let target = light.multiply_visibility(Channels::One);
    light.pass(Pass {
        name: format!("share of {name} on {}", receiver.name),
        reason: "the share of the light's points that see the receiver".into(),
        colors: vec![target],
        depth: Some(light.test_depth()),
        draws,
    });
}
/// For each point of the light and each caster: from the caster to clip space, flattened.
fn matrices(
    light: &mut LightPlan<'_>,
    receiver: &Receiver,
    points: &LightPoints,
    casters: &Casters,
) -> SlotId {
    let [width, height] = light.view.size_px.map(f64::from);
    let clip_from_view = light.view.camera.projection.clip_from_view(width / height);
    let view_from_world = light.view.camera.world_from_view.inverse();
    let mut matrices: Vec<[f32; 16]> = Vec::with_capacity(points.positions.len() * casters.centers.len());
    for point in &points.positions {
        for center in &casters.centers {
            let plane = &receiver.flat.plane;
            let clip = clip_from_caster(&clip_from_view, &view_from_world, (plane, *point), *center);
            matrices.push(clip.as_mat4().to_cols_array());
        }
    }
    if matrices.is_empty() {
        matrices.push([0.0; 16]);
    }
    let bytes: &[u8] = cast_slice(&matrices);
    let name = format!("flattening onto {} from {}", receiver.name, light.light().name);
    let reason = "where each caster's shadow falls, for each point of the light, as the eye sees it";
    let key = hash_of(("flattening", bytes));
    light.buffer(&name, BufferUsage::Storage, key, Arc::new(bytes.to_vec()), reason)
}

/// The points of the light as the shader weighs them.
fn record(light: &mut LightPlan<'_>, receiver: &Receiver, points: &LightPoints, heights: &[f64]) -> SlotId {
    let view_from_world = light.view.camera.world_from_view.inverse();
    let count = points.positions.len() as u32;
    let center = view_from_world.transform_point3(light.light().position.truncate());
    let head = PlanarLight {
        center: center.as_vec3().to_array(),
        radius_m: points.radius_m as f32,
        count,
        center_point: points.center_point.map_or(count, |number| number as u32),
        ..PlanarLight::default()
    };
    let offsets: Vec<[f32; 4]> = points
        .offsets
        .iter()
        .zip(heights)
        .map(|(offset, height)| {
            let lit = if *height > 0.0 { 1.0 } else { 0.0 };
            view_from_world.transform_vector3(*offset).extend(lit).as_vec4().to_array()
        })
        .collect();
    let bytes = [bytes_of(&head), cast_slice(&offsets)].concat();
    let key = hash_of(("planar light", &bytes));
    let name = format!("points of {} over {}", light.light().name, receiver.name);
    light.buffer(
        &name,
        BufferUsage::Storage,
        key,
        Arc::new(bytes),
        "the points of the light, by which bits are weighed",
    )
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
    let mut runs: Vec<(bool, Vec<(u32, u32)>, u64)> = Vec::new();
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
    let draw = |(masked, parts, vertices): (bool, Vec<(u32, u32)>, u64)| {
        let (style, flags): (_, &[&str]) = if masked {
            // A mask without a texture reads a white one: no variant of its own.
            (SurfaceStyle::PulledMasked, &["RECEIVER", "MASKED", "BASE_COLOR_TEXTURE", "SECOND_UV"])
        } else {
            (SurfaceStyle::Pulled, &["RECEIVER"])
        };
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
