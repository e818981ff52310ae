//! Writing meshes: the binary chunk, its views and accessors.

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

use super::GltfError;
use crate::geometry::{Influences, Mesh, MeshData, Part};

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const POINTS: u32 = 0;

/// The binary chunk while it grows, with the views and accessors into it.
#[derive(Debug, Default)]
pub(super) struct Binary {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

/// The accessors of one engine mesh, shared by the primitives of every glTF mesh made from it.
#[derive(Clone, Debug, Default)]
pub(super) struct WrittenMesh {
    attributes: Value,
    /// The morph targets' accessors, names and weights.
    targets: Vec<Value>,
    target_names: Vec<String>,
    weights: Vec<f32>,
    /// One index accessor for each part; parts without triangles have none.
    indices: Vec<Option<usize>>,
}

impl Binary {
    /// Appends bytes as a view of their own, aligned to 4, and returns its index.
    pub(super) fn add_view(&mut self, bytes: impl IntoIterator<Item = u8>, target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.views.len() - 1
    }

    /// Appends a vertex stream and returns its accessor.
    fn add_stream<const N: usize>(&mut self, kind: &str, values: impl Iterator<Item = [f32; N]>) -> usize {
        self.add_floats(kind, values, Some(ARRAY_BUFFER))
    }

    /// Appends floats for any purpose and returns their accessor.
    pub(super) fn add_floats<const N: usize>(
        &mut self,
        kind: &str,
        values: impl Iterator<Item = [f32; N]>,
        target: Option<u32>,
    ) -> usize {
        let view = self.add_view(values.flatten().flat_map(f32::to_le_bytes), target);
        let count = self.views[view]["byteLength"].as_u64().unwrap_or(0) / (4 * N as u64);
        self.accessors
            .push(json!({ "bufferView": view, "componentType": FLOAT, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    /// Appends a mesh's streams and indices.
    pub(super) fn add_mesh(&mut self, mesh: &Mesh) -> WrittenMesh {
        let data = mesh.data();
        if data.indices.is_empty() {
            // glTF has no mesh without vertices; a lone point has no surface either.
            let position = self.add_stream("VEC3", [[0.0; 3]].into_iter());
            self.accessors[position]["min"] = json!([0.0, 0.0, 0.0]);
            self.accessors[position]["max"] = json!([0.0, 0.0, 0.0]);
            return WrittenMesh { attributes: json!({ "POSITION": position }), ..WrittenMesh::default() };
        }
        let position = self.add_stream("VEC3", data.positions.iter().map(Vec3::to_array));
        let start = data.positions[0];
        let min = data.positions.iter().fold(start, |min, p| min.min(*p));
        let max = data.positions.iter().fold(start, |max, p| max.max(*p));
        self.accessors[position]["min"] = json!(min.to_array());
        self.accessors[position]["max"] = json!(max.to_array());
        let normal = self.add_stream("VEC3", data.normals.iter().map(Vec3::to_array));
        let mut attributes = json!({ "POSITION": position, "NORMAL": normal });
        if !data.uvs.is_empty() {
            attributes["TEXCOORD_0"] = self.add_stream("VEC2", data.uvs.iter().map(Vec2::to_array)).into();
        }
        if !data.second_uvs.is_empty() {
            let uvs = data.second_uvs.iter().map(Vec2::to_array);
            attributes["TEXCOORD_1"] = self.add_stream("VEC2", uvs).into();
        }
        if !data.colors.is_empty() {
            attributes["COLOR_0"] = self.add_stream("VEC4", data.colors.iter().map(Vec4::to_array)).into();
        }
        if !data.influences.is_empty() {
            self.add_influences(data, &mut attributes);
        }
        let targets = self.add_morphs(data);
        let bytes = data.indices.iter().flat_map(|index| index.to_le_bytes());
        let view = self.add_view(bytes, Some(ELEMENT_ARRAY_BUFFER));
        let indices = data.parts.iter().map(|part| self.add_indices(view, part)).collect();
        WrittenMesh {
            attributes,
            targets,
            target_names: data.morphs.iter().map(|morph| morph.name.clone()).collect(),
            weights: data.morphs.iter().map(|morph| morph.weight).collect(),
            indices,
        }
    }

    /// Joints and weights in sets of four; the second set only where some vertex needs it.
    fn add_influences(&mut self, data: &MeshData, attributes: &mut Value) {
        let more = data.influences.iter().any(|influences| influences.weights()[4] != 0.0);
        for set in 0..if more { 2 } else { 1 } {
            let four = set * 4..set * 4 + 4;
            let joints = |influences: &Influences| influences.joints()[four.clone()].to_vec();
            let bytes = data.influences.iter().flat_map(joints).flat_map(u16::to_le_bytes);
            let view = self.add_view(bytes, Some(ARRAY_BUFFER));
            self.accessors.push(json!({
                "bufferView": view, "componentType": UNSIGNED_SHORT, "count": data.influences.len(), "type": "VEC4",
            }));
            attributes[format!("JOINTS_{set}")] = (self.accessors.len() - 1).into();
            let weights =
                |influences: &Influences| std::array::from_fn(|i| influences.weights()[four.start + i]);
            let weights = self.add_stream::<4>("VEC4", data.influences.iter().map(weights));
            attributes[format!("WEIGHTS_{set}")] = weights.into();
        }
    }

    /// Every morph target; glTF wants the bounds of displacements, as of positions.
    fn add_morphs(&mut self, data: &MeshData) -> Vec<Value> {
        let mut targets = Vec::with_capacity(data.morphs.len());
        for morph in &data.morphs {
            let mut target = json!({});
            // A target without streams is none to glTF, so that one that moves nothing says so at length.
            let still = morph.positions.is_empty() && morph.normals.is_empty();
            let zeros = vec![Vec3::ZERO; if still { data.positions.len() } else { 0 }];
            let positions = if still { &zeros } else { &morph.positions };
            if let Some(start) = positions.first() {
                let accessor = self.add_stream("VEC3", positions.iter().map(Vec3::to_array));
                let min = positions.iter().fold(*start, |min, p| min.min(*p));
                let max = positions.iter().fold(*start, |max, p| max.max(*p));
                self.accessors[accessor]["min"] = json!(min.to_array());
                self.accessors[accessor]["max"] = json!(max.to_array());
                target["POSITION"] = accessor.into();
            }
            if !morph.normals.is_empty() {
                target["NORMAL"] = self.add_stream("VEC3", morph.normals.iter().map(Vec3::to_array)).into();
            }
            targets.push(target);
        }
        targets
    }

    fn add_indices(&mut self, view: usize, part: &Part) -> Option<usize> {
        let (start, count) = (part.triangles.start as usize, part.triangles.len());
        if count == 0 {
            return None;
        }
        self.accessors.push(json!({
            "bufferView": view, "byteOffset": start * 12, "componentType": UNSIGNED_INT, "count": count * 3,
            "type": "SCALAR",
        }));
        Some(self.accessors.len() - 1)
    }

    /// Checks that the chunk fits its 32-bit length.
    pub(super) fn check_size(&self) -> Result<(), GltfError> {
        if self.bytes.len() <= u32::MAX as usize / 2 {
            return Ok(());
        }
        let problem = format!("are {} bytes; a .glb of this project takes 2 GiB", self.bytes.len());
        Err(GltfError::Save { what: "its meshes and images".into(), problem })
    }
}

impl WrittenMesh {
    /// The glTF mesh in these materials, one for each part.
    pub(super) fn in_materials(&self, name: &str, materials: &[usize]) -> Value {
        let primitive = |indices: Option<usize>, material: &usize| {
            let mut primitive =
                json!({ "attributes": self.attributes, "indices": indices?, "material": material });
            if !self.targets.is_empty() {
                primitive["targets"] = self.targets.clone().into();
            }
            Some(primitive)
        };
        let mut primitives: Vec<Value> =
            self.indices.iter().zip(materials).filter_map(|(i, material)| primitive(*i, material)).collect();
        if primitives.is_empty() {
            primitives.push(json!({ "attributes": self.attributes, "mode": POINTS }));
        }
        let mut mesh = json!({ "name": name, "primitives": primitives });
        if !self.targets.is_empty() {
            mesh["weights"] = json!(self.weights);
            mesh["extras"] = json!({ "targetNames": self.target_names });
        }
        mesh
    }
}
