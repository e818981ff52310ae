//! The structures shaders read, as bytes. A test compares each with its WGSL twin, field by field.

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4, Mat4, Vec3};

use crate::plan::LightPlanned;
use crate::scene::{CameraSnapshot, Instance, LightKind, LightSnapshot, SceneSnapshot};

/// `struct Frame` of common/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct FrameUniform {
    pub clip_from_view: [f32; 16],
    pub view_from_clip: [f32; 16],
    pub view_from_world: [f32; 16],
    pub size_px: [f32; 2],
    pub exposure: f32,
    pub light_count: u32,
    pub ambient: [f32; 3],
    pub tone_map: u32,
    pub up_in_view: [f32; 3],
    pub eye_w: f32,
    pub shadowed_px: [u32; 4],
}

/// `struct Instance` of common/frame.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct InstanceUniform {
    pub row_x: [f32; 4],
    pub row_y: [f32; 4],
    pub row_z: [f32; 4],
    pub normal_x: [f32; 4],
    pub normal_y: [f32; 4],
    pub normal_z: [f32; 4],
    pub flags: u32,
    pub first_triangle: u32,
    pub smooth_terminators: u32,
    pub pad_0: u32,
}

/// `struct Light` of common/lights.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct LightUniform {
    pub position: [f32; 4],
    pub radiance: [f32; 3],
    pub inverse_range: f32,
    pub direction: [f32; 3],
    pub cone_scale: f32,
    pub cone_offset: f32,
    pub factor_kind: u32,
    pub factor_index: u32,
    pub own_shadow: u32,
}

/// `struct TintedFactor` of surface_shade.wgsl: a factor, and what the picture loses of its light where it is 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct TintUniform {
    pub max_darkening: [f32; 3],
    pub next: u32,
    pub kind: u32,
    pub index: u32,
    pub pad_0: u32,
    pub pad_1: u32,
}

/// Names and byte offsets of a structure's fields, and its whole size: what the layout test compares.
pub type Layout = (Vec<(&'static str, usize)>, usize);

macro_rules! layout {
    ($type:ty: $($field:ident),*) => {
        impl $type {
            /// The byte offset of every field, and the whole size.
            pub fn layout() -> $crate::gpu::Layout {
                (vec![$((stringify!($field), std::mem::offset_of!($type, $field))),*], size_of::<$type>())
            }
        }
    };
}

pub(super) use layout;

layout!(FrameUniform: clip_from_view, view_from_clip, view_from_world, size_px, exposure, light_count, ambient, tone_map, up_in_view, eye_w, shadowed_px);
layout!(InstanceUniform: row_x, row_y, row_z, normal_x, normal_y, normal_z, flags, first_triangle, smooth_terminators, pad_0);
layout!(LightUniform: position, radiance, inverse_range, direction, cone_scale, cone_offset, factor_kind, factor_index, own_shadow);
layout!(TintUniform: max_darkening, next, kind, index, pad_0, pad_1);

impl FrameUniform {
    pub(crate) fn new(
        snapshot: &SceneSnapshot,
        camera: &CameraSnapshot,
        size_px: [u32; 2],
        exposure: f32,
        tone_map: bool,
    ) -> Self {
        let aspect = f64::from(size_px[0]) / f64::from(size_px[1]);
        let clip_from_view = camera.projection.clip_from_view(aspect);
        let perspective = camera.projection.far_m().is_infinite();
        let view_from_world = camera.world_from_view.inverse();
        let up = view_from_world.transform_vector3(DVec3::Y).as_vec3();
        Self {
            clip_from_view: clip_from_view.as_mat4().to_cols_array(),
            view_from_clip: Mat4::to_cols_array(&clip_from_view.inverse().as_mat4()),
            view_from_world: DMat4::from(view_from_world).as_mat4().to_cols_array(),
            size_px: size_px.map(|n| n as f32),
            exposure,
            light_count: snapshot.lights.len() as u32,
            ambient: snapshot.ambient.to_array(),
            tone_map: u32::from(tone_map),
            up_in_view: up.to_array(),
            eye_w: f32::from(u8::from(perspective)),
            shadowed_px: [0, 0, size_px[0], size_px[1]],
        }
    }
}

impl InstanceUniform {
    pub(crate) fn new(
        instance: &Instance,
        view_from_world: &DAffine3,
        first_triangle: u32,
        smooth_terminators: u32,
    ) -> Self {
        let view_from_gpu = *view_from_world * instance.world_from_shader();
        let rows = view_from_gpu.matrix3.transpose();
        let row = |axis: usize| {
            let linear = rows.col(axis);
            DVec4::new(linear.x, linear.y, linear.z, view_from_gpu.translation[axis]).as_vec4().to_array()
        };
        let normals = normal_matrix(view_from_gpu.matrix3).transpose();
        let normal_row = |axis: usize| normals.col(axis).extend(0.0).as_vec4().to_array();
        Self {
            row_x: row(0),
            row_y: row(1),
            row_z: row(2),
            normal_x: normal_row(0),
            normal_y: normal_row(1),
            normal_z: normal_row(2),
            flags: u32::from(instance.shadow.receives) | u32::from(instance.shadow.casts) << 1,
            first_triangle,
            smooth_terminators,
            pad_0: 0,
        }
    }
}

/// The matrix that takes normals along: the cofactor matrix, which exists for singular maps too, scaled to size 1.
fn normal_matrix(m: DMat3) -> DMat3 {
    let cofactor =
        DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    let size = cofactor.to_cols_array().iter().fold(0.0_f64, |max, x| max.max(x.abs()));
    let sign = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    if size > 0.0 { cofactor * (sign / size) } else { DMat3::IDENTITY }
}

impl LightUniform {
    pub(crate) fn new(
        light: &LightSnapshot,
        planned: &LightPlanned,
        view_from_world: &DAffine3,
        exposure: f32,
    ) -> Self {
        let position = if light.position.w == 0.0 {
            view_from_world.transform_vector3(light.position.truncate())
        } else {
            view_from_world.transform_point3(light.position.truncate())
        };
        // As KHR_lights_punctual computes it: 1 at the inner angle, 0 at the outer.
        let (cone_scale, cone_offset) = match light.light.kind {
            LightKind::Spot { inner_rad, outer_rad } => {
                let scale = 1.0 / (inner_rad.cos() - outer_rad.cos()).max(1e-3);
                (scale, -outer_rad.cos() * scale)
            }
            _ => (0.0, 1.0),
        };
        let [factor_kind, factor_index] = planned.factor.kind_and_index();
        let radiance: Vec3 = light.light.color * light.light.intensity * exposure;
        Self {
            position: position.extend(light.position.w).as_vec4().to_array(),
            radiance: radiance.to_array(),
            inverse_range: light.light.range_m.map_or(0.0, |range_m| (1.0 / range_m) as f32),
            direction: view_from_world.transform_vector3(light.direction).as_vec3().to_array(),
            cone_scale: cone_scale as f32,
            cone_offset: cone_offset as f32,
            factor_kind,
            factor_index,
            own_shadow: u32::from(planned.own_shadow),
        }
    }
}
