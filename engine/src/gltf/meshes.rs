//! Meshes: all primitives of a glTF mesh become one engine mesh with one part each, so that a closed surface split
//! by material welds closed.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};
use gltf::json;
use json::mesh::{Mode, Semantic};
use json::validation::Checked;

use super::GltfError;
use super::accessors::{Accessors, Integers};
use super::deformations::{self, BendStreams};
use super::limits::{Budget, Warnings};
use crate::geometry::{MAX_MESH_ELEMENTS, MeshData, Part};

/// A glTF mesh: its shape, and which glTF material each slot is (`None`: the default material).
#[derive(Debug)]
pub(super) struct ReadMesh {
    pub(super) data: MeshData,
    pub(super) materials: Vec<Option<usize>>,
}

/// The accessors of a primitive's vertices. Primitives that share them share the vertices.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Streams {
    positions: usize,
    normals: Option<usize>,
    uvs: Option<usize>,
    second_uvs: Option<usize>,
    colors: Option<usize>,
    bend: BendStreams,
}

/// The run of vertices that a primitive's indices count from.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: usize,
    vertices: usize,
}

/// Reads mesh `mesh` of the document.
pub(super) fn read(
    accessors: &Accessors<'_>,
    mesh: usize,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<ReadMesh, GltfError> {
    let declaration = accessors.root.meshes.get(mesh).ok_or_else(|| GltfError::IndexOutOfRange {
        item: "a node".into(),
        field: "mesh".into(),
        kind: "mesh",
        index: mesh as u64,
        count: accessors.root.meshes.len(),
    })?;
    let name = declaration.name.clone().unwrap_or_else(|| format!("mesh{mesh}"));
    let mut read = ReadMesh { data: MeshData { name, ..MeshData::default() }, materials: Vec::new() };
    let mut runs: HashMap<Streams, Run> = HashMap::new();
    let mut slots: HashMap<Option<usize>, usize> = HashMap::new();
    for (index, primitive) in declaration.primitives.iter().enumerate() {
        let wrong = |problem: String| GltfError::Primitive { mesh, primitive: index, problem };
        let Checked::Valid(mode) = primitive.mode else { return Err(wrong("its mode is unknown".into())) };
        if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            warnings.add(format!("mesh {mesh}: points and lines are ignored"));
            continue;
        }
        let stream = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).map(json::Index::value);
        let streams = Streams {
            positions: stream(Semantic::Positions).ok_or_else(|| wrong("it has no POSITION".into()))?,
            normals: stream(Semantic::Normals),
            uvs: stream(Semantic::TexCoords(0)),
            second_uvs: stream(Semantic::TexCoords(1)),
            colors: stream(Semantic::Colors(0)),
            bend: BendStreams::of(primitive, mesh, &wrong, warnings)?,
        };
        let targets = streams.bend.target_count();
        if read.data.parts.is_empty() {
            read.data.morphs = deformations::targets(mesh, declaration, targets, budget)?;
        } else if targets != read.data.morphs.len() {
            let others = read.data.morphs.len();
            return Err(wrong(format!(
                "it has {targets} morph targets, the mesh's first primitive {others}"
            )));
        }
        let run = match runs.get(&streams) {
            Some(run) => *run,
            None => append(accessors, &streams, &mut read.data, budget, &wrong)?,
        };
        let triangles = triangles(accessors, primitive, mode, mesh, index, run.vertices, budget)?;
        let first = read.data.indices.len() / 3;
        if first + triangles.len() > MAX_MESH_ELEMENTS {
            let what = format!("mesh {mesh}: triangles");
            let (count, limit) = ((first + triangles.len()) as u64, MAX_MESH_ELEMENTS as u64);
            return Err(GltfError::TooLarge { what, count, limit });
        }
        // Without normals the triangles are flat, and share no vertex with one another.
        if streams.normals.is_some() {
            runs.insert(streams, run);
            let start = run.start as u32;
            read.data.indices.extend(triangles.iter().flatten().map(|vertex| start + vertex));
        } else {
            budget.charge_elements(triangles.len() as u64 * 3 * (1 + read.data.morphs.len() as u64))?;
            unshare(&mut read.data, run, &triangles);
        }
        let material = primitive.material.map(|material| material.value());
        let material_slot = *slots.entry(material).or_insert_with(|| {
            read.materials.push(material);
            read.materials.len() - 1
        });
        let end = (first + triangles.len()) as u32;
        read.data.parts.push(Part { triangles: first as u32..end, material_slot });
    }
    let vertices = read.data.positions.len();
    pad(&mut read.data, vertices);
    Ok(read)
}

/// Fills up the optional streams that an earlier primitive has and a later one lacks, or the reverse.
fn pad(data: &mut MeshData, vertices: usize) {
    if !data.uvs.is_empty() {
        data.uvs.resize(vertices, Vec2::ZERO);
    }
    if !data.second_uvs.is_empty() {
        data.second_uvs.resize(vertices, Vec2::ZERO);
    }
    if !data.colors.is_empty() {
        data.colors.resize(vertices, Vec4::ONE);
    }
    deformations::pad(data, vertices);
}

/// Appends a primitive's vertices.
fn append(
    accessors: &Accessors<'_>,
    streams: &Streams,
    data: &mut MeshData,
    budget: &mut Budget,
    wrong: &dyn Fn(String) -> GltfError,
) -> Result<Run, GltfError> {
    let start = data.positions.len();
    let positions = accessors.floats::<3>(streams.positions, "POSITION", Integers::AsDeclared, budget)?;
    let vertices = positions.len();
    if start + vertices > MAX_MESH_ELEMENTS {
        return Err(wrong(format!("the mesh has more than {MAX_MESH_ELEMENTS} vertices")));
    }
    let same_length = |stream: &str, count: usize| match count == vertices {
        true => Ok(()),
        false => Err(wrong(format!("{stream} has {count} entries for {vertices} vertices"))),
    };
    data.positions.extend(positions.into_iter().map(Vec3::from));
    if let Some(normals) = streams.normals {
        let normals = accessors.floats::<3>(normals, "NORMAL", Integers::Normalized, budget)?;
        same_length("NORMAL", normals.len())?;
        data.normals.extend(normals.into_iter().map(Vec3::from).map(usable_normal));
    }
    if let Some(uvs) = streams.uvs {
        let uvs = accessors.floats::<2>(uvs, "TEXCOORD_0", Integers::AsDeclared, budget)?;
        same_length("TEXCOORD_0", uvs.len())?;
        data.uvs.resize(start, Vec2::ZERO);
        data.uvs.extend(uvs.into_iter().map(Vec2::from));
    }
    if let Some(uvs) = streams.second_uvs {
        let uvs = accessors.floats::<2>(uvs, "TEXCOORD_1", Integers::AsDeclared, budget)?;
        same_length("TEXCOORD_1", uvs.len())?;
        data.second_uvs.resize(start, Vec2::ZERO);
        data.second_uvs.extend(uvs.into_iter().map(Vec2::from));
    }
    if let Some(colors) = streams.colors {
        data.colors.resize(start, Vec4::ONE);
        if accessors.width(colors, "COLOR_0")? == 3 {
            let colors = accessors.floats::<3>(colors, "COLOR_0", Integers::Normalized, budget)?;
            data.colors.extend(colors.into_iter().map(|rgb| Vec3::from(rgb).extend(1.0)));
        } else {
            let colors = accessors.floats::<4>(colors, "COLOR_0", Integers::Normalized, budget)?;
            data.colors.extend(colors.into_iter().map(Vec4::from));
        }
        same_length("COLOR_0", data.colors.len() - start)?;
    }
    streams.bend.append(accessors, start, data, budget, wrong)?;
    pad(data, start + vertices);
    Ok(Run { start, vertices })
}

/// A normal that shading can normalise: quantised ones are kept, a zero one points up.
fn usable_normal(normal: Vec3) -> Vec3 {
    if normal.length_squared() > 0.0 { normal } else { Vec3::Y }
}

/// The triangles of a primitive, as vertices of its own streams, each index checked.
fn triangles(
    accessors: &Accessors<'_>,
    primitive: &json::mesh::Primitive,
    mode: Mode,
    mesh: usize,
    index: usize,
    vertices: usize,
    budget: &mut Budget,
) -> Result<Vec<[u32; 3]>, GltfError> {
    let order: Vec<u32> = match primitive.indices {
        Some(indices) => accessors.indices(indices.value(), "indices", budget)?,
        None => {
            budget.charge_elements(vertices as u64)?;
            (0..vertices as u32).collect()
        }
    };
    if let Some(place) = order.iter().position(|vertex| *vertex as usize >= vertices) {
        let out = order[place];
        return Err(GltfError::VertexIndex { mesh, primitive: index, place, index: out, vertices });
    }
    if mode == Mode::Triangles {
        if !order.len().is_multiple_of(3) {
            let problem = format!("{} indices are no whole number of triangles (3 each)", order.len());
            return Err(GltfError::Primitive { mesh, primitive: index, problem });
        }
        return Ok(order.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect());
    }
    budget.charge_elements(order.len() as u64 * 3)?;
    let corners = order.windows(3).enumerate().map(|(i, run)| match mode {
        Mode::TriangleFan => [run[1], run[2], order[0]],
        _ if i % 2 == 0 => [run[0], run[1], run[2]],
        _ => [run[0], run[2], run[1]],
    });
    // Strips are joined by triangles that name a vertex twice; those are no surface.
    Ok(corners.filter(|[a, b, c]| a != b && b != c && c != a).collect())
}

/// Replaces the run at the end of the mesh by three vertices for each triangle, with the triangle's normal.
fn unshare(data: &mut MeshData, run: Run, triangles: &[[u32; 3]]) {
    fn gather<T: Copy>(stream: &mut Vec<T>, start: usize, triangles: &[[u32; 3]]) {
        if stream.len() > start {
            let shared = stream.split_off(start);
            stream.extend(triangles.iter().flatten().map(|vertex| shared[*vertex as usize]));
        }
    }
    gather(&mut data.positions, run.start, triangles);
    gather(&mut data.uvs, run.start, triangles);
    gather(&mut data.second_uvs, run.start, triangles);
    gather(&mut data.colors, run.start, triangles);
    gather(&mut data.influences, run.start, triangles);
    for target in &mut data.morphs {
        gather(&mut target.positions, run.start, triangles);
        gather(&mut target.normals, run.start, triangles);
    }
    for corners in data.positions[run.start..].chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|i| corners[i].as_dvec3());
        let normal = (b - a).cross(c - a).try_normalize().map_or(Vec3::Y, |normal| normal.as_vec3());
        data.normals.extend([normal; 3]);
    }
    let end = data.positions.len() as u32;
    data.indices.extend(run.start as u32..end);
}
