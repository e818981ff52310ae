//! Meshes: all primitives of a glTF mesh become one engine mesh with one part each, so that a closed surface split
//! by material welds closed.

use std::collections::HashMap;

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Map, Value};

use super::GltfError;
use super::accessors::{Accessors, Integers};
use super::deformations::{self, BendStreams, attribute};
use super::document::{Section, remedy};
use super::limits::{Budget, Warnings};
use super::names::shown;
use crate::geometry::{MAX_MESH_ELEMENTS, MeshData, Part};

/// A glTF mesh: its shape, and which glTF material each slot is (`None`: the default material).
#[derive(Debug)]
pub(super) struct ReadMesh {
    pub(super) data: MeshData,
    pub(super) materials: Vec<Option<usize>>,
}

/// How a primitive's vertices make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Triangles,
    TriangleStrip,
    TriangleFan,
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
    let declaration = accessors.document.used(Section::Meshes, mesh)?;
    let name =
        declaration.get("name").and_then(Value::as_str).map_or_else(|| format!("mesh{mesh}"), str::to_owned);
    let read = ReadMesh { data: MeshData { name, ..MeshData::default() }, materials: Vec::new() };
    let (runs, slots) = (HashMap::new(), HashMap::new());
    let mut reader = Reader { accessors, mesh, declaration, budget, warnings, read, runs, slots };
    let primitives = declaration.get("primitives").and_then(Value::as_array);
    let primitives = primitives.into_iter().flatten().filter_map(Value::as_object);
    for (index, primitive) in primitives.enumerate() {
        reader.primitive(index, primitive)?;
    }
    let mut read = reader.read;
    let vertices = read.data.positions.len();
    pad(&mut read.data, vertices);
    Ok(read)
}

/// What a mesh is read with, and what was read so far.
struct Reader<'r, 'a> {
    accessors: &'r Accessors<'a>,
    mesh: usize,
    declaration: &'r Map<String, Value>,
    budget: &'r mut Budget,
    warnings: &'r mut Warnings,
    read: ReadMesh,
    /// The vertices of earlier primitives, by their accessors.
    runs: HashMap<Streams, Run>,
    /// The slot of each material.
    slots: HashMap<Option<usize>, usize>,
}

impl Reader<'_, '_> {
    /// Reads one primitive; one that makes no triangles is left out with a warning.
    fn primitive(&mut self, index: usize, primitive: &Map<String, Value>) -> Result<(), GltfError> {
        let mesh = self.mesh;
        let wrong = |problem: String| GltfError::Primitive { mesh, primitive: index, problem };
        let mode = match primitive.get("mode").and_then(Value::as_u64).unwrap_or(4) {
            0..=3 => {
                self.warnings.add(format!("mesh {mesh}: points and lines are ignored"));
                return Ok(());
            }
            4 => Mode::Triangles,
            5 => Mode::TriangleStrip,
            _ => Mode::TriangleFan,
        };
        refuse_draco(self.accessors, primitive)?;
        note_attributes(self.accessors, primitive, mesh, self.warnings);
        let Some(streams) = self.streams(index, primitive, &wrong)? else { return Ok(()) };
        self.targets(streams.bend.target_count(), &wrong)?;
        let run = match self.runs.get(&streams) {
            Some(run) => *run,
            None => append(self.accessors, &streams, &mut self.read.data, self.budget, &wrong)?,
        };
        let triangles = triangles(self.accessors, primitive, mode, mesh, index, run.vertices, self.budget)?;
        let material = primitive.get("material").and_then(Value::as_u64).map(|material| material as usize);
        self.part(streams, run, &triangles, material)
    }

    /// The accessors of a primitive's vertices; `None`, with a warning, where it has no positions.
    fn streams(
        &mut self,
        index: usize,
        primitive: &Map<String, Value>,
        wrong: &dyn Fn(String) -> GltfError,
    ) -> Result<Option<Streams>, GltfError> {
        let mesh = self.mesh;
        let stream = |semantic: &str| attribute(primitive.get("attributes"), semantic);
        let Some(positions) = stream("POSITION") else {
            self.warnings.add(format!("mesh {mesh}, primitive {index}: it has no POSITION, and is ignored"));
            return Ok(None);
        };
        if !self.accessors.has_bounds(positions) {
            self.accessors.document.note(format!("mesh {mesh}: POSITION has no min and max"));
        }
        Ok(Some(Streams {
            positions,
            normals: stream("NORMAL"),
            uvs: stream("TEXCOORD_0"),
            second_uvs: stream("TEXCOORD_1"),
            colors: stream("COLOR_0"),
            bend: BendStreams::of(primitive, mesh, wrong, self.warnings)?,
        }))
    }

    /// The mesh's morph targets: those of its first primitive, and as many in every other.
    fn targets(&mut self, count: usize, wrong: &dyn Fn(String) -> GltfError) -> Result<(), GltfError> {
        let data = &mut self.read.data;
        if data.parts.is_empty() {
            data.morphs = deformations::targets(self.mesh, self.declaration, count, self.budget)?;
        } else if count != data.morphs.len() {
            let others = data.morphs.len();
            return Err(wrong(format!("it has {count} morph targets, the mesh's first primitive {others}")));
        }
        Ok(())
    }

    /// Adds the triangles of a primitive as one part in its material's slot.
    fn part(
        &mut self,
        streams: Streams,
        run: Run,
        triangles: &[[u32; 3]],
        material: Option<usize>,
    ) -> Result<(), GltfError> {
        let ReadMesh { data, materials } = &mut self.read;
        let first = data.indices.len() / 3;
        let end = first + triangles.len();
        if end > MAX_MESH_ELEMENTS {
            let what = format!("mesh {}: triangles", self.mesh);
            return Err(GltfError::TooLarge { what, count: end as u64, limit: MAX_MESH_ELEMENTS as u64 });
        }
        // Without normals the triangles are flat, and share no vertex with one another.
        if streams.normals.is_some() {
            self.runs.insert(streams, run);
            let start = run.start as u32;
            data.indices.extend(triangles.iter().flatten().map(|vertex| start + vertex));
        } else {
            self.budget.charge_elements(triangles.len() as u64 * 3 * (1 + data.morphs.len() as u64))?;
            unshare(data, run, triangles);
        }
        let material_slot = *self.slots.entry(material).or_insert_with(|| {
            materials.push(material);
            materials.len() - 1
        });
        data.parts.push(Part { triangles: first as u32..end as u32, material_slot });
        Ok(())
    }
}

/// Refuses a primitive whose vertices are only there compressed by Draco. Most files have no plain accessors beside it; where
/// they do, those are read.
fn refuse_draco(accessors: &Accessors<'_>, primitive: &Map<String, Value>) -> Result<(), GltfError> {
    let name = "KHR_draco_mesh_compression";
    let is_compressed = primitive.get("extensions").and_then(|all| all.get(name)).is_some();
    let positions = attribute(primitive.get("attributes"), "POSITION");
    if is_compressed && positions.is_none_or(|accessor| !accessors.has_data(accessor)) {
        return Err(GltfError::UnsupportedExtension { name: name.into(), fix: remedy(name) });
    }
    Ok(())
}

/// Notes attributes whose names mean nothing here.
fn note_attributes(
    accessors: &Accessors<'_>,
    primitive: &Map<String, Value>,
    mesh: usize,
    warnings: &mut Warnings,
) {
    const KNOWN: [&str; 3] = ["POSITION", "NORMAL", "TANGENT"];
    const NUMBERED: [&str; 4] = ["TEXCOORD_", "COLOR_", "JOINTS_", "WEIGHTS_"];
    let is_known = |name: &str| {
        let number = NUMBERED.iter().find_map(|prefix| name.strip_prefix(prefix));
        KNOWN.contains(&name)
            || number.is_some_and(|n| {
                n.bytes().all(|b| b.is_ascii_digit()) && (n == "0" || !n.starts_with('0')) && !n.is_empty()
            })
    };
    let attributes = primitive.get("attributes").and_then(Value::as_object);
    let names = attributes.into_iter().flat_map(Map::keys).map(String::as_str);
    // Names that begin with an underscore are for programs of their own.
    if names.clone().any(|name| !is_known(name) && !name.starts_with('_')) {
        warnings.add(format!("mesh {mesh}: an attribute of unknown name is ignored"));
    }
    for prefix in NUMBERED {
        let numbers: Vec<u32> =
            names.clone().filter_map(|name| name.strip_prefix(prefix)?.parse().ok()).collect();
        if numbers.iter().any(|number| *number as usize >= numbers.len()) {
            accessors
                .document
                .note(format!("mesh {mesh}: its {prefix}n are not numbered from 0 without gaps"));
        }
    }
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
        let off =
            normals.iter().filter(|n| (n.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() > 0.05).count();
        if off > 0 {
            accessors.document.note(format!("mesh '{}': {off} normals have not length 1", shown(&data.name)));
        }
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
        if data.colors[start..].iter().any(|color| color.min_element() < 0.0 || color.max_element() > 1.0) {
            accessors.document.note(format!("mesh '{}': colours are not from 0 to 1", shown(&data.name)));
        }
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
    primitive: &Map<String, Value>,
    mode: Mode,
    mesh: usize,
    index: usize,
    vertices: usize,
    budget: &mut Budget,
) -> Result<Vec<[u32; 3]>, GltfError> {
    let order: Vec<u32> = match primitive.get("indices").and_then(Value::as_u64) {
        Some(indices) => accessors.indices(indices as usize, "indices", budget)?,
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
