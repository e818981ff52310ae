//! Validated triangle meshes.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use glam::{DVec3, Vec2, Vec3, Vec4};
use thiserror::Error;

use super::deformable;
use super::{Influences, MorphTarget, Topology};
use crate::math::Aabb;

/// What a mesh is made from, before validation. Positions and indices are required; every other stream is either
/// empty or as long as `positions`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// The name errors and reports use.
    pub name: String,
    /// Vertex positions in local space, in metres.
    pub positions: Vec<Vec3>,
    /// Shading normals; left empty, they are computed (area-weighted over each vertex's triangles).
    pub normals: Vec<Vec3>,
    /// Texture coordinates.
    pub uvs: Vec<Vec2>,
    /// Second texture coordinates.
    pub second_uvs: Vec<Vec2>,
    /// Linear vertex colours that multiply the base colour.
    pub colors: Vec<Vec4>,
    /// Three indices per triangle, counter-clockwise seen from the front.
    pub indices: Vec<u32>,
    /// Which triangles wear which material; left empty, one part covers all with slot 0.
    pub parts: Vec<Part>,
    /// Which joints move each vertex, for meshes that are skinned.
    pub influences: Vec<Influences>,
    /// The shapes that it can blend to.
    pub morphs: Vec<MorphTarget>,
}

/// A run of triangles with one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The run, in triangles (not indices).
    pub triangles: Range<u32>,
    /// Which of the mesh node's materials the run wears.
    pub material_slot: usize,
}

/// Why a mesh was refused.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum MeshError {
    #[error("mesh '{mesh}': {count} indices are no whole number of triangles (a multiple of 3 is needed)")]
    PartialTriangle { mesh: String, count: usize },
    #[error("mesh '{mesh}': index {index} at place {place} is out of range ({vertices} vertices)")]
    IndexOutOfRange { mesh: String, place: usize, index: u32, vertices: usize },
    #[error(
        "mesh '{mesh}': position {vertex} is ({x}, {y}, {z}); positions must be finite and below 1e18 in size"
    )]
    BadPosition { mesh: String, vertex: usize, x: f32, y: f32, z: f32 },
    #[error(
        "mesh '{mesh}': {stream} has {count} entries for {vertices} vertices (as many, or none, are needed)"
    )]
    StreamLength { mesh: String, stream: &'static str, count: usize, vertices: usize },
    #[error(
        "mesh '{mesh}': parts must cover the {triangles} triangles in order without gaps; part {part} runs {start}..{end}"
    )]
    BadParts { mesh: String, part: usize, start: u32, end: u32, triangles: usize },
    #[error(
        "mesh '{mesh}': vertex {vertex} has a joint weight of {weight}; finite ones of at least 0 are needed"
    )]
    BadWeight { mesh: String, vertex: usize, weight: f32 },
    #[error("mesh '{mesh}': morph target {target} has values that are not finite")]
    BadMorph { mesh: String, target: usize },
    #[error("mesh '{mesh}': {count} {what} are more than the {limit} a mesh may have")]
    TooLarge { mesh: String, what: &'static str, count: usize, limit: usize },
}

/// A validated mesh: at least every index is in range and every position finite. Immutable; a changed shape is a
/// new mesh with a new [`Mesh::id`].
#[derive(Debug)]
pub struct Mesh {
    data: MeshData,
    id: u64,
    bounds: Aabb,
    topology: OnceLock<Topology>,
    faceted: OnceLock<bool>,
    /// The mesh that this one is a pose of.
    rest: Option<Arc<Mesh>>,
}

/// The most vertices, and the most triangles, a mesh may have: indices doubled for extruded vertices stay in u32.
pub const MAX_MESH_ELEMENTS: usize = 1 << 28;

impl Mesh {
    /// Validates `data` and computes what was left out.
    ///
    /// # Errors
    /// Each way in which the data can be wrong is one variant of [`MeshError`], naming the mesh.
    pub fn new(mut data: MeshData) -> Result<Self, MeshError> {
        static NEXT_ID: AtomicU64 = AtomicU64::new(1);
        validate(&data)?;
        if data.parts.is_empty() && !data.indices.is_empty() {
            data.parts.push(Part { triangles: 0..data.indices.len() as u32 / 3, material_slot: 0 });
        }
        if data.normals.is_empty() {
            data.normals = smooth_normals(&data.positions, &data.indices);
        }
        let bounds = Aabb::from_points(data.positions.iter().map(|p| p.as_dvec3()));
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        Ok(Self { data, id, bounds, topology: OnceLock::new(), faceted: OnceLock::new(), rest: None })
    }

    /// `rest` with its vertices elsewhere: a mesh of its own, whose topology is that of `rest` for as long as the
    /// same vertices weld. A faceted mesh gets the new planes' normals, whatever `normals` are.
    ///
    /// # Errors
    /// As [`Mesh::new`].
    pub fn posed(rest: &Arc<Self>, positions: Vec<Vec3>, normals: Vec<Vec3>) -> Result<Self, MeshError> {
        let faceted = rest.is_faceted();
        let data = MeshData {
            normals: if faceted { plane_normals(&positions, &rest.data.indices) } else { normals },
            positions,
            name: rest.data.name.clone(),
            uvs: rest.data.uvs.clone(),
            second_uvs: rest.data.second_uvs.clone(),
            colors: rest.data.colors.clone(),
            indices: rest.data.indices.clone(),
            parts: rest.data.parts.clone(),
            influences: Vec::new(),
            morphs: Vec::new(),
        };
        Ok(Self { rest: Some(Arc::clone(rest)), ..Self::new(data)? })
    }

    /// Whether it is a pose of another mesh ([`Mesh::posed`]): then parts of it may have been pushed through others,
    /// inside out.
    pub fn is_posed(&self) -> bool {
        self.rest.is_some()
    }

    /// The highest joint that a vertex follows; `None` for a mesh without influences.
    pub fn highest_joint(&self) -> Option<usize> {
        self.data.influences.iter().flat_map(Influences::joints).max().map(usize::from)
    }

    /// Whether no two triangles share a vertex and each has its own plane's normal, as meshes loaded without normals
    /// do. Found on first use and kept.
    pub fn is_faceted(&self) -> bool {
        *self.faceted.get_or_init(|| {
            let mut seen = vec![false; self.data.positions.len()];
            let shared = |index: &u32| std::mem::replace(&mut seen[*index as usize], true);
            !self.data.indices.is_empty()
                && !self.data.indices.iter().any(shared)
                && plane_normals(&self.data.positions, &self.data.indices) == self.data.normals
        })
    }

    /// A number no other mesh of this process has; the key of everything cached about the mesh.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// The mesh's name.
    pub fn name(&self) -> &str {
        &self.data.name
    }

    /// The validated streams.
    pub fn data(&self) -> &MeshData {
        &self.data
    }

    /// Vertex positions in local space.
    pub fn positions(&self) -> &[Vec3] {
        &self.data.positions
    }

    /// The corners of triangle `triangle` as vertex indices.
    pub fn triangle(&self, triangle: usize) -> [u32; 3] {
        let corners = &self.data.indices[triangle * 3..triangle * 3 + 3];
        [corners[0], corners[1], corners[2]]
    }

    /// The colour of `vertex` as shaders see it, with 8 bits a channel; white without colours.
    pub fn color8(&self, vertex: u32) -> [u8; 4] {
        let byte = |channel: f32| (channel.clamp(0.0, 1.0) * 255.0).round() as u8;
        self.data.colors.get(vertex as usize).map_or([255; 4], |color| color.to_array().map(byte))
    }

    /// The number of triangles.
    pub fn triangle_count(&self) -> usize {
        self.data.indices.len() / 3
    }

    /// The box around all positions, in local space.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// Where the origin of vertex positions in shaders lies in local space. Zero unless the mesh lies far from its
    /// own origin: then coordinates relative to its middle keep the digits that the difference to the eye needs.
    pub fn shader_origin(&self) -> DVec3 {
        let center = self.bounds.center().as_vec3().as_dvec3();
        if center.length() > 8.0 * self.bounds.radius() && center.is_finite() { center } else { DVec3::ZERO }
    }

    /// Vertex `vertex` as shaders see it: about [`Self::shader_origin`], rounded once.
    pub fn shader_position(&self, vertex: u32) -> Vec3 {
        about(self.shader_origin(), self.data.positions[vertex as usize])
    }

    /// All vertices as shaders see them.
    pub fn shader_positions(&self) -> Vec<Vec3> {
        let origin = self.shader_origin();
        self.data.positions.iter().map(|position| about(origin, *position)).collect()
    }

    /// Welded vertices, edges and closedness; computed on first use and kept.
    pub fn topology(&self) -> &Topology {
        self.topology.get_or_init(|| match &self.rest {
            Some(rest) => rest.topology().posed(&self.data.positions, &self.data.indices),
            None => Topology::new(&self.data.positions, &self.data.indices),
        })
    }
}

fn validate(data: &MeshData) -> Result<(), MeshError> {
    let mesh = || data.name.clone();
    let vertices = data.positions.len();
    let triangles = data.indices.len() / 3;
    for (what, count) in [("vertices", vertices), ("triangles", triangles)] {
        if count > MAX_MESH_ELEMENTS {
            return Err(MeshError::TooLarge { mesh: mesh(), what, count, limit: MAX_MESH_ELEMENTS });
        }
    }
    if !data.indices.len().is_multiple_of(3) {
        return Err(MeshError::PartialTriangle { mesh: mesh(), count: data.indices.len() });
    }
    if let Some(place) = data.indices.iter().position(|&index| index as usize >= vertices) {
        return Err(MeshError::IndexOutOfRange { mesh: mesh(), place, index: data.indices[place], vertices });
    }
    if let Some(vertex) = data.positions.iter().position(|p| !p.is_finite() || p.abs().max_element() >= 1e18)
    {
        let Vec3 { x, y, z } = data.positions[vertex];
        return Err(MeshError::BadPosition { mesh: mesh(), vertex, x, y, z });
    }
    for (stream, count) in [
        ("normals", data.normals.len()),
        ("uvs", data.uvs.len()),
        ("second uvs", data.second_uvs.len()),
        ("colors", data.colors.len()),
    ] {
        if count != 0 && count != vertices {
            return Err(MeshError::StreamLength { mesh: mesh(), stream, count, vertices });
        }
    }
    deformable::validate(&data.name, vertices, &data.influences, &data.morphs)?;
    let mut expected_start = 0;
    for (part, Part { triangles: run, .. }) in data.parts.iter().enumerate() {
        let last = part + 1 == data.parts.len();
        if run.start != expected_start || run.end < run.start || (last && run.end as usize != triangles) {
            return Err(MeshError::BadParts {
                mesh: mesh(),
                part,
                start: run.start,
                end: run.end,
                triangles,
            });
        }
        expected_start = run.end;
    }
    Ok(())
}

/// A position relative to an origin, which is mostly zero.
fn about(origin: DVec3, position: Vec3) -> Vec3 {
    if origin == DVec3::ZERO { position } else { (position.as_dvec3() - origin).as_vec3() }
}

/// The normal of the last triangle at each vertex; +y where there is none, or no area.
fn plane_normals(positions: &[Vec3], indices: &[u32]) -> Vec<Vec3> {
    let mut normals = vec![Vec3::Y; positions.len()];
    for corner in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| positions[corner[i] as usize].as_dvec3());
        let normal = (b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3();
        corner.iter().for_each(|vertex| normals[*vertex as usize] = normal);
    }
    normals
}

/// Area-weighted vertex normals; vertices without area get +y so that shading stays finite.
fn smooth_normals(positions: &[Vec3], indices: &[u32]) -> Vec<Vec3> {
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for corner in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| positions[corner[i] as usize].as_dvec3());
        let area_normal = (b - a).cross(c - a);
        for &index in corner {
            sums[index as usize] += area_normal;
        }
    }
    sums.into_iter().map(|sum| sum.try_normalize().map_or(Vec3::Y, |n| n.as_vec3())).collect()
}
