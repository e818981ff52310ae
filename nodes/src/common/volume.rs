//! The shadow volume of one caster and one light: its indices, and the record its vertex shader reads.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4};
use shadowgraph_engine::geometry::{Chain, facing_signs, restricted_signs};
use shadowgraph_engine::scene::Instance;

use super::extrusion::End;

/// `struct Volume` of the shadow volume shaders.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct VolumeUniform {
    pub light_high: [f32; 4],
    pub light_low: [f32; 4],
    pub end_normal: [f32; 3],
    pub end_offset: f32,
    pub end_kind: u32,
    pub end_scale: f32,
    pub instance: u32,
    pub pad_0: u32,
}

impl VolumeUniform {
    /// The byte offset of every field, and the whole size: what the layout test compares.
    pub fn layout() -> (Vec<(&'static str, usize)>, usize) {
        use std::mem::offset_of;
        let fields = vec![
            ("light_high", offset_of!(Self, light_high)),
            ("light_low", offset_of!(Self, light_low)),
            ("end_normal", offset_of!(Self, end_normal)),
            ("end_offset", offset_of!(Self, end_offset)),
            ("end_kind", offset_of!(Self, end_kind)),
            ("end_scale", offset_of!(Self, end_scale)),
            ("instance", offset_of!(Self, instance)),
            ("pad_0", offset_of!(Self, pad_0)),
        ];
        (fields, size_of::<Self>())
    }

    /// The record of `instance` (number `index` of the frame) for the homogeneous world-space `light`. The
    /// instance's transform must not be singular.
    pub fn new(instance: &Instance, index: usize, light: DVec4, end: End) -> Self {
        let world_from_shader = instance.world_from_shader();
        let shader_from_world = world_from_shader.inverse();
        let light_in_shader = if light.w > 0.0 {
            shader_from_world.transform_point3(light.truncate())
        } else {
            shader_from_world.transform_vector3(light.truncate())
        };
        let high = light_in_shader.as_vec3();
        let low = (light_in_shader - high.as_dvec3()).as_vec3();
        let (end_kind, plane, end_scale) = match end {
            End::Infinite => (0, None, 0.0),
            End::Plane(plane) => (1, Some(plane), 0.0),
            End::Scaled(scale) => (2, None, scale as f32),
        };
        // normal·(M p + t) = offset  ⇔  (Mᵀ normal)·p = offset − normal·t
        let normal = plane.map_or(DVec3::ZERO, |p| world_from_shader.matrix3.transpose() * p.normal);
        let offset = plane.map_or(0.0, |p| p.offset - p.normal.dot(world_from_shader.translation));
        Self {
            light_high: high.extend(light.w as f32).to_array(),
            light_low: low.extend(0.0).to_array(),
            end_normal: normal.as_vec3().to_array(),
            end_offset: offset as f32,
            end_kind,
            end_scale,
            instance: index as u32,
            pad_0: 0,
        }
    }
}

/// What the facing signs of one caster say before it is cast: kept between frames.
#[derive(Clone, Debug)]
pub struct CasterFacing {
    /// Welded vertices in the world.
    pub p_in_world: Vec<DVec3>,
    /// The sign of every triangle that is cast, 0 for the others.
    pub signs: Vec<i8>,
    /// The triangles with a sign other than 0.
    pub cast: Vec<u32>,
}

impl CasterFacing {
    /// The facing signs of `instance` towards `light`; with `closed`, only those facing it outwards.
    pub fn new(instance: &Instance, light: DVec4, closed: bool) -> Self {
        let topology = instance.mesh.topology();
        let p_in_world: Vec<DVec3> = (0..instance.mesh.positions().len() as u32)
            .map(|vertex| instance.world_position(vertex))
            .collect();
        let mut signs = facing_signs(&p_in_world, topology.triangles(), light);
        if closed && let Some(orientation) = topology.orientation(&instance.world_from_local) {
            signs = orientation.lit_only(&signs);
        }
        let cast = (0..signs.len() as u32).filter(|triangle| signs[*triangle as usize] != 0).collect();
        Self { p_in_world, signs, cast }
    }
}

/// Indices of a volume, each 4·vertex + 2·side + far, in runs that are drawn as the view demands.
#[derive(Clone, Debug, PartialEq)]
pub struct VolumeIndices {
    /// All runs, one after the other.
    pub indices: Vec<u32>,
    /// First triangle (q, p, p∞) of every side: all there is of it when both ends meet at infinity.
    pub sides_near: Range<u32>,
    /// Second triangle (q, p∞, q∞) of every side.
    pub sides_far: Range<u32>,
    /// Far caps.
    pub far_caps: Range<u32>,
    /// Front caps of triangles the light sees from the front, in the mesh's own order of corners.
    pub front_caps: Range<u32>,
    /// Front caps of triangles the light sees from behind, in the mesh's own order of corners: they count the other
    /// way round. (Turning the triangle instead could change its depth by a rounding, and caps must equal the
    /// visible surface bit by bit.)
    pub front_caps_turned: Range<u32>,
    /// Different silhouette edges.
    pub silhouette_edges: usize,
}

impl VolumeIndices {
    /// The volume of the given triangles of a caster.
    pub fn new(instance: &Instance, facing: &CasterFacing, triangles: &[u32]) -> Self {
        let topology = instance.mesh.topology();
        let all = triangles.len() == facing.cast.len();
        let restricted;
        let signs = if all {
            &facing.signs
        } else {
            restricted = restricted_signs(&facing.signs, triangles.iter().copied());
            &restricted
        };
        let chain = Chain::extract(topology, signs);
        let near = |vertex: u32| vertex << 2 | 2;
        let far = |vertex: u32| vertex << 2 | 3;
        let cap = |vertex: u32| vertex << 2;
        let mut indices = Vec::with_capacity(chain.sides.len() * 6 + triangles.len() * 6);
        let mut run = |add: &mut dyn FnMut(&mut Vec<u32>)| {
            let start = indices.len() as u32;
            add(&mut indices);
            start..indices.len() as u32
        };
        let sides_near =
            run(&mut |i| chain.sides.iter().for_each(|&[p, q]| i.extend([near(q), near(p), far(p)])));
        let sides_far =
            run(&mut |i| chain.sides.iter().for_each(|&[p, q]| i.extend([near(q), far(p), far(q)])));
        let far_caps = run(&mut |i| {
            for &triangle in &chain.caps_front {
                let [a, b, c] = topology.triangles()[triangle as usize];
                i.extend([far(a), far(c), far(b)]);
            }
            for &triangle in &chain.caps_back {
                i.extend(topology.triangles()[triangle as usize].map(far));
            }
        });
        // Front caps use the mesh's own indices, as the visible surface does.
        let own = |triangle: u32| instance.mesh.triangle(triangle as usize).map(cap);
        let front_caps = run(&mut |i| chain.caps_front.iter().for_each(|t| i.extend(own(*t))));
        let front_caps_turned = run(&mut |i| chain.caps_back.iter().for_each(|t| i.extend(own(*t))));
        let silhouette_edges = chain.silhouette_edges;
        Self { indices, sides_near, sides_far, far_caps, front_caps, front_caps_turned, silhouette_edges }
    }
}
