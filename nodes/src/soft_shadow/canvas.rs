//! What shadows are drawn on: the picture, or a texture on the receiver.
//!
//! Both are seen by a rigid camera: the eye, or one that looks straight down onto the plane. So casters are flattened
//! and bits weighed by the same code.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4};
use shadowgraph_engine::math::Plane;
use shadowgraph_engine::plan::{BufferDesc, Lifetime, Resource, TextureDesc, TextureFormat};
use shadowgraph_engine::shadow::{LightContext, PassList, hash_of};

use super::casters::{Casters, clip_from_caster};
use super::receivers::Receiver;
use super::shadowed_area::ShadowedArea;
use super::{Lit, POINTS_OF_A_LAYER};

/// The head of `struct PlanarLight` of soft_shadow.wgsl, which its points follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct PlanarLight {
    pub center: [f32; 3],
    pub radius_m: f32,
    pub count: u32,
    pub center_point: u32,
    pub half_m: [f32; 2],
    pub all_above: u32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
}

/// `struct PlanarTexture` of soft_shadow.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct PlanarTexture {
    pub x_axis: [f32; 3],
    pub x_offset: f32,
    pub y_axis: [f32; 3],
    pub y_offset: f32,
}

/// Names and byte offsets of a structure's fields, and its whole size.
pub(super) type Layout = (Vec<(&'static str, usize)>, usize);

macro_rules! fields {
    ($type:ty: $($field:ident),*) => { vec![$((stringify!($field), std::mem::offset_of!($type, $field))),*] };
}

/// Every structure of the shader as it is here, and the flags under which the shader has it: what the layout test
/// compares.
pub fn planar_layouts() -> [(&'static str, &'static str, Layout); 4] {
    use super::batches::{GlassCorner, MaskedCorner};
    let mut light = fields!(PlanarLight: center, radius_m, count, center_point, half_m, all_above);
    light.push(("points", size_of::<PlanarLight>()));
    let texture = fields!(PlanarTexture: x_axis, x_offset, y_axis, y_offset);
    let corner = fields!(MaskedCorner: position, caster, uv, alpha, cutoff, reading, pad_0, pad_1, pad_2);
    let glass = fields!(GlassCorner:
        position, caster, color, base_color, uv, cutoff, transmission, alpha_mode, reading);
    // A runtime-sized array counts as one element.
    [
        ("RECEIVER", "PlanarLight", (light, size_of::<PlanarLight>() + size_of::<[f32; 4]>())),
        ("RECEIVER", "PlanarTexture", (texture, size_of::<PlanarTexture>())),
        ("GLASS", "GlassCorner", (glass, size_of::<GlassCorner>())),
        ("MASKED", "MaskedCorner", (corner, size_of::<MaskedCorner>())),
    ]
}

/// Where shadows are marked.
#[derive(Clone, Copy, Debug)]
pub(super) struct Targets {
    /// Bits of the points.
    pub(super) bits: Resource,
    /// Which point marked a pixel last.
    pub(super) stencil: Resource,
}

/// What shadows are drawn on.
#[derive(Clone, Debug)]
pub(super) struct Canvas {
    /// In pixels or texels.
    pub(super) size_px: [u32; 2],
    /// To where its camera is the origin.
    pub(super) view_from_world: DAffine3,
    /// From there to clip space; w is the distance for a perspective camera.
    pub(super) clip_from_view: DMat4,
    /// Half its sides on the receiver; none for the picture.
    pub(super) half_m: Option<DVec2>,
    /// What its contents depend on, for a texture, which is kept.
    pub(super) key: Option<u64>,
}

impl Canvas {
    /// The picture, as the eye sees the receiver.
    pub(super) fn picture(light: &LightContext<'_>) -> Self {
        let size_px = light.view.size_px;
        let [width, height] = size_px.map(f64::from);
        Self {
            size_px,
            view_from_world: light.view.camera.world_from_view.inverse(),
            clip_from_view: light.view.camera.projection.clip_from_view(width / height),
            half_m: None,
            key: None,
        }
    }

    /// A texture over where shadows may fall on `receiver`, as fine as the view shows it, and of at most `resolution` texels along its
    /// longer side; `None` where none fall.
    pub(super) fn texture(
        light: &LightContext<'_>,
        receiver: &Receiver,
        lit: &Lit,
        casters: &Casters,
        resolution: u32,
    ) -> Option<Self> {
        let Plane { normal, offset } = receiver.flat.plane;
        let points = lit.points.positions.iter().map(|point| point.to_array().map(f64::to_bits));
        let points: Vec<_> = points.chain([[lit.points.radius_m.to_bits(); 4]]).collect();
        let plane_bits = normal.extend(offset).to_array().map(f64::to_bits);
        let poses: Vec<u64> =
            receiver.instances.iter().map(|index| light.snapshot.instances[*index].pose_key).collect();
        let key = hash_of(("planar texture", plane_bits, points, poses, casters.key));
        let compute = || ShadowedArea::new(light.snapshot, (receiver, lit, casters));
        let area = light.cache.get_or_compute("shadowed area", key, compute);
        let area = (*area).as_ref()?;
        let resolution = area.texels_shown(light.view, resolution);
        let key = hash_of((key, resolution));
        Some(area.canvas(resolution, key))
    }

    /// The targets for `count` points.
    pub(super) fn targets(&self, out: &mut PassList<'_>, count: usize) -> Targets {
        let format = match count {
            ..=8 => TextureFormat::R8Unorm,
            9..=16 => TextureFormat::Rg8Unorm,
            _ => TextureFormat::Rgba8Unorm,
        };
        let layers = count.div_ceil(POINTS_OF_A_LAYER) as u32;
        let lifetime = self.key.map_or(Lifetime::Scratch, Lifetime::Kept);
        let mut target = |name: &str, format, layers, reason: &str| {
            let desc = TextureDesc::new(name, format, self.size_px, reason);
            out.texture(TextureDesc { layers, lifetime, ..desc })
        };
        let reason = format!("one bit for each of {count} points of a light");
        let bits = target("shadowed bits", format, layers, &reason);
        let reason = "where the receiver is, and which point of the light marked it last";
        Targets { bits, stencil: target("receiver stencil", TextureFormat::Stencil8, 1, reason) }
    }

    /// For each point of the light and each caster: from the caster to clip space, flattened.
    pub(super) fn matrices(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        (receiver, lit, casters): (&Receiver, &Lit, &Casters),
    ) -> Resource {
        let compute = || {
            let plane = &receiver.flat.plane;
            let flatten = |point: &DVec4, center: &DVec3| {
                let clip =
                    clip_from_caster(&self.clip_from_view, &self.view_from_world, (plane, *point), *center);
                clip.as_mat4().to_cols_array()
            };
            let of_point = |point: &DVec4| {
                casters.centers.iter().map(|center| flatten(point, center)).collect::<Vec<_>>()
            };
            let matrices: Vec<[f32; 16]> = lit.points.positions.iter().flat_map(of_point).collect();
            if matrices.is_empty() { vec![0; 64] } else { cast_slice(&matrices).to_vec() }
        };
        let (bytes, key) = match self.key {
            Some(key) => {
                (light.cache.get_or_compute("flattening", key, compute), hash_of(("flattening", key)))
            }
            None => {
                let bytes = Arc::new(compute());
                let key = hash_of(("flattening", &bytes));
                (bytes, key)
            }
        };
        let name = format!("flattening onto {} from {}", receiver.name, light.light().name);
        let reason = "where each caster's shadow falls, for each point of the light";
        out.buffer(BufferDesc::storage(&name, key, bytes, reason))
    }

    /// The points of the light as the shader weighs them.
    pub(super) fn points(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        (receiver, lit): (&Receiver, &Lit),
    ) -> Resource {
        let Lit { points, heights } = lit;
        let count = points.positions.len() as u32;
        let center = self.view_from_world.transform_point3(light.light().position.truncate());
        let head = PlanarLight {
            center: center.as_vec3().to_array(),
            radius_m: points.radius_m as f32,
            count,
            center_point: points.center_point.map_or(count, |number| number as u32),
            half_m: self.half_m.unwrap_or_default().as_vec2().to_array(),
            all_above: u32::from(heights.iter().all(|height| *height > 0.0)),
            ..PlanarLight::default()
        };
        let point = |(offset, height): (&DVec3, &f64)| {
            let lit = if *height > 0.0 { 1.0 } else { 0.0 };
            self.view_from_world.transform_vector3(*offset).extend(lit).as_vec4().to_array()
        };
        let offsets: Vec<[f32; 4]> = points.offsets.iter().zip(heights).map(point).collect();
        let bytes = [bytes_of(&head), cast_slice(&offsets)].concat();
        let key = hash_of(("planar light", &bytes));
        let name = format!("points of {} over {}", light.light().name, receiver.name);
        let reason = "the points of the light, by which bits are weighed";
        out.buffer(BufferDesc::storage(&name, key, Arc::new(bytes), reason))
    }

    /// Where the texture lies, as the eye sees it.
    pub(super) fn place(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        receiver: &Receiver,
    ) -> Resource {
        let half = self.half_m.unwrap_or(DVec2::ONE);
        let canvas_from_eye = self.view_from_world * light.view.camera.world_from_view;
        let rows = canvas_from_eye.matrix3.transpose();
        let [width, height] = self.size_px.map(f64::from);
        // Texels run down.
        let (x, y) = (0.5 * width / half.x, -0.5 * height / half.y);
        let place = PlanarTexture {
            x_axis: (rows.x_axis * x).as_vec3().to_array(),
            x_offset: (canvas_from_eye.translation.x * x + 0.5 * width) as f32,
            y_axis: (rows.y_axis * y).as_vec3().to_array(),
            y_offset: (canvas_from_eye.translation.y * y + 0.5 * height) as f32,
        };
        let bytes = bytes_of(&place).to_vec();
        let key = hash_of(("planar texture's place", &bytes));
        let name = format!("place of the shadows on {}", receiver.name);
        let reason = "where the texture lies, as the eye sees it";
        out.buffer(BufferDesc::storage(&name, key, Arc::new(bytes), reason))
    }
}
