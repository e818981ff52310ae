//! Batches: the triangles of all casters onto one receiver that one draw flattens, as the shader reads them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use glam::{DVec3, DVec4};
use shadowgraph_engine::math::{Aabb, facing_sign};
use shadowgraph_engine::plan::{BufferDesc, Resource};
use shadowgraph_engine::scene::{ImageKey, Material};
use shadowgraph_engine::shadow::{LightContext, PassList, hash_of};

use super::above_plane::{AbovePlane, Vertex};
use super::points::LightPoints;
use super::receivers::Receiver;
use crate::common::mask_vertices::alpha_mode_of;

/// A corner of a triangle without holes: from its caster's middle, and the caster's number.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Corner {
    position: [f32; 3],
    caster: u32,
}

/// `struct MaskedCorner` of soft_shadow.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedCorner {
    pub position: [f32; 3],
    pub caster: u32,
    pub uv: [f32; 2],
    pub alpha: f32,
    pub cutoff: f32,
    pub reading: u32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
}

/// `struct GlassCorner` of soft_shadow.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub(super) struct GlassCorner {
    pub position: [f32; 3],
    pub caster: u32,
    pub color: [f32; 4],
    pub base_color: [f32; 4],
    pub uv: [f32; 2],
    pub cutoff: f32,
    pub transmission: f32,
    pub alpha_mode: u32,
    pub reading: u32,
    pub pad_0: u32,
    pub pad_1: u32,
}

/// What triangles do to light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    /// They stop it.
    Whole,
    /// They stop it where they have no holes.
    Masked,
    /// They tint it.
    Glass,
}

impl Kind {
    /// That of a material's surfaces, if these cast.
    pub(super) fn of(material: &Material) -> Option<Self> {
        let kinds = [
            (Self::Whole, material.casts_whole()),
            (Self::Masked, material.casts_by_texel()),
            (Self::Glass, material.is_transparent()),
        ];
        kinds.into_iter().find(|(_, is)| *is).map(|(kind, _)| kind)
    }
}

/// Triangles that one draw flattens.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// What they do to light.
    pub(super) kind: Kind,
    /// What holes or colours are looked up in.
    pub(super) image: Option<Resource>,
    /// Their corners.
    pub(super) corners: Resource,
    /// Their corners' numbers.
    pub(super) indices: Resource,
    /// For each point of the light: where its indices begin, and how many there are.
    pub(super) runs: Vec<(u32, u32)>,
}

/// What a batch is made of.
struct BatchBytes {
    corners: Arc<Vec<u8>>,
    indices: Arc<Vec<u8>>,
    runs: Vec<(u32, u32)>,
}

/// One part of a caster.
pub(super) struct Run {
    /// The caster's number.
    pub(super) caster: u32,
    pub(super) above: Arc<AbovePlane>,
    /// The key under which `above` is kept.
    pub(super) key: u64,
    pub(super) material: Arc<Material>,
    /// The middle of the caster.
    pub(super) center: DVec3,
    /// The caster's bounds, and a little more.
    pub(super) bounds: Aabb,
}

impl Run {
    /// What of the material is in the corners: colour, how alpha counts, transmission, and how its texture is read.
    fn material_bits(&self) -> ([u32; 4], (u32, u32), u32, u32) {
        let material = &self.material;
        let (alpha_mode, cutoff) = alpha_mode_of(material);
        let color = material.base_color.to_array().map(f32::to_bits);
        (color, (alpha_mode, cutoff.to_bits()), material.transmission.to_bits(), self.reading())
    }

    fn reading(&self) -> u32 {
        self.material.base_color_texture.map_or(0, |texture| texture.reading_bits())
    }

    /// The corner of a triangle, as the shader has it for this kind.
    fn corner(&self, kind: Kind, vertex: &Vertex) -> Vec<u8> {
        let (material, caster) = (&self.material, self.caster);
        let position = (vertex.p_in_world - self.center).as_vec3().to_array();
        let (uv, reading) = (vertex.uv.as_vec2().to_array(), self.reading());
        let (alpha_mode, cutoff) = alpha_mode_of(material);
        match kind {
            Kind::Whole => bytes_of(&Corner { position, caster }).to_vec(),
            Kind::Masked => {
                let alpha = material.base_color.w * vertex.color.w as f32;
                bytes_of(&MaskedCorner {
                    position,
                    caster,
                    uv,
                    alpha,
                    cutoff,
                    reading,
                    ..MaskedCorner::default()
                })
                .to_vec()
            }
            Kind::Glass => bytes_of(&GlassCorner {
                position,
                caster,
                color: vertex.color.as_vec4().to_array(),
                base_color: material.base_color.to_array(),
                uv,
                cutoff,
                transmission: material.transmission,
                alpha_mode,
                reading,
                ..GlassCorner::default()
            })
            .to_vec(),
        }
    }
}

/// Parts of casters that one draw can flatten: all of one kind, looked up in one image or in none.
pub(super) struct Runs {
    pub(super) kind: Kind,
    pub(super) image: Option<ImageKey>,
    pub(super) runs: Vec<Run>,
}

impl Runs {
    /// Puts corners and indices into buffers. Returns the batch, and a hash of what its shadow depends on.
    pub(super) fn upload(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        receiver: &Receiver,
        points: &LightPoints,
    ) -> (Batch, u64) {
        let Self { kind, image, runs } = self;
        let keys: Vec<_> = runs.iter().map(|run| (run.caster, run.key, run.material_bits())).collect();
        // Only a point within a caster's bounds may lie on one of its triangles.
        let near: Vec<usize> = (0..points.positions.len())
            .filter(|number| {
                let point = points.positions[*number];
                point.w > 0.0 && runs.iter().any(|run| run.bounds.contains(point.truncate()))
            })
            .collect();
        let bits_of = |number: &usize| points.positions[*number].to_array().map(f64::to_bits);
        let near_bits: Vec<_> = near.iter().map(|number| (number, bits_of(number))).collect();
        let key = hash_of(("flattened", kind, image, keys, points.positions.len(), near_bits));
        let bytes = light.cache.get_or_compute("flattened", key, || self.bytes(points, &near));
        let BatchBytes { corners, indices, runs } = &*bytes;
        let triangles = runs.iter().map(|(_, count)| count / 3).max().unwrap_or_default();
        let name = &receiver.name;
        let what = match kind {
            Kind::Whole => "casters",
            Kind::Masked => "masked casters",
            Kind::Glass => "glass",
        };
        let image = image.map(|image| out.image(image, "looked up where light would pass"));
        let reason = format!("{triangles} triangles above '{name}'");
        let (corners_name, indices_name) =
            (format!("{what} over {name}"), format!("triangles of {what} over {name}"));
        let corners =
            BufferDesc::storage(&corners_name, hash_of((key, "corners")), Arc::clone(corners), &reason);
        let indices =
            BufferDesc::index(&indices_name, hash_of((key, "indices")), Arc::clone(indices), &reason);
        let (corners, indices) = (out.buffer(corners), out.buffer(indices));
        (Batch { kind: *kind, image, corners, indices, runs: runs.clone() }, key)
    }

    /// Corners and indices; for the points that are `near` some caster, indices of their own.
    fn bytes(&self, points: &LightPoints, near: &[usize]) -> BatchBytes {
        let (mut corners, mut indices) = (Vec::new(), Vec::new());
        let mut first = 0;
        for run in &self.runs {
            let above = &run.above;
            corners.extend(above.vertices.iter().flat_map(|vertex| run.corner(self.kind, vertex)));
            indices.extend(above.indices.iter().map(|index| first + index));
            first += above.vertices.len() as u32;
        }
        let mut of_points = vec![(0, indices.len() as u32); points.positions.len()];
        for number in near {
            let first = indices.len() as u32;
            indices.extend(runs_seen(&self.runs, points.positions[*number]));
            of_points[*number] = (first, indices.len() as u32 - first);
        }
        let indices = Arc::new(cast_slice(&indices).to_vec());
        BatchBytes { corners: Arc::new(corners), indices, runs: of_points }
    }
}

/// The indices of triangles that `point` does not see edge-on. The shadow of the others is a line; but a corner in
/// which the point itself lies has none, and where it would be drawn is rounding.
fn runs_seen(runs: &[Run], point: DVec4) -> Vec<u32> {
    let mut seen = Vec::new();
    let mut first = 0;
    for Run { above, .. } in runs {
        for triangle in above.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| above.vertices[triangle[i] as usize].p_in_world);
            if facing_sign(a, b, c, point) != 0 {
                seen.extend(triangle.iter().map(|index| first + index));
            }
        }
        first += above.vertices.len() as u32;
    }
    seen
}
