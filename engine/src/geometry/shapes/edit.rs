//! Changing generated shapes before they become meshes: move, flip, flatten, merge.

use glam::{DAffine3, DMat3, DVec3, Vec3};

use crate::geometry::{MeshData, MorphTarget, Part};

/// Changing shapes before they become meshes.
impl MeshData {
    /// The same shape under another name.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        self.name = name.into();
        self
    }

    /// The shape under `transform`. A mirroring transform also turns the winding, so that outside stays outside.
    #[must_use]
    pub fn transformed(mut self, transform: &DAffine3) -> Self {
        for position in &mut self.positions {
            *position = transform.transform_point3(position.as_dvec3()).as_vec3();
        }
        let m = transform.matrix3;
        // The cofactor matrix turns normals as the inverse transpose does, and exists for singular transforms too.
        let cofactors =
            DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
        let mirrored = m.determinant() < 0.0;
        for normal in &mut self.normals {
            let turned = (cofactors * normal.as_dvec3()).normalize_or(DVec3::Y);
            *normal = (if mirrored { -turned } else { turned }).as_vec3();
        }
        for target in &mut self.morphs {
            for moved in &mut target.positions {
                *moved = transform.transform_vector3(moved.as_dvec3()).as_vec3();
            }
            // A difference of normals has no length of its own to keep; the plain turn is right for rigid transforms.
            for moved in &mut target.normals {
                *moved = transform.transform_vector3(moved.as_dvec3()).as_vec3();
            }
        }
        if mirrored {
            for corners in self.indices.chunks_exact_mut(3) {
                corners.swap(1, 2);
            }
        }
        self
    }

    /// The shape moved by `offset`.
    #[must_use]
    pub fn moved(self, offset: Vec3) -> Self {
        self.transformed(&DAffine3::from_translation(offset.as_dvec3()))
    }

    /// The shape turned inside out: winding and normals reversed.
    #[must_use]
    pub fn flipped(mut self) -> Self {
        for corners in self.indices.chunks_exact_mut(3) {
            corners.swap(1, 2);
        }
        for normal in self.normals.iter_mut().chain(self.morphs.iter_mut().flat_map(|t| &mut t.normals)) {
            *normal = -*normal;
        }
        self
    }

    /// The same triangles, none sharing a vertex, each with its plane's normal.
    #[must_use]
    pub fn flat_shaded(self) -> Self {
        fn unshared<T: Copy>(stream: &[T], indices: &[u32]) -> Vec<T> {
            if stream.is_empty() { Vec::new() } else { indices.iter().map(|&i| stream[i as usize]).collect() }
        }
        let positions = unshared(&self.positions, &self.indices);
        let plane_normal = |t: &[Vec3]| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|p| p.as_dvec3());
            [(b - a).cross(c - a).normalize_or(DVec3::Y).as_vec3(); 3]
        };
        Self {
            normals: positions.chunks_exact(3).flat_map(plane_normal).collect(),
            uvs: unshared(&self.uvs, &self.indices),
            second_uvs: unshared(&self.second_uvs, &self.indices),
            colors: unshared(&self.colors, &self.indices),
            influences: unshared(&self.influences, &self.indices),
            morphs: self
                .morphs
                .iter()
                .map(|target| MorphTarget {
                    positions: unshared(&target.positions, &self.indices),
                    normals: Vec::new(),
                    ..target.clone()
                })
                .collect(),
            indices: (0..positions.len() as u32).collect(),
            positions,
            ..self
        }
    }

    /// Several shapes as one mesh. Material slots stay what they are; a stream that one shape lacks (normals aside,
    /// which every shape here has) is dropped from all, and so are morph targets.
    #[must_use]
    pub fn merged(name: &str, shapes: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self { name: name.into(), ..Self::default() };
        let (mut has_uvs, mut has_colors, mut has_normals, mut has_parts) = (true, true, true, false);
        let mut has_influences = true;
        let mut has_second_uvs = true;
        for shape in shapes {
            let (first, first_triangle) = (all.positions.len() as u32, all.indices.len() as u32 / 3);
            let triangles = shape.indices.len() as u32 / 3;
            has_normals &= shape.normals.len() == shape.positions.len();
            has_uvs &= shape.uvs.len() == shape.positions.len();
            has_second_uvs &= shape.second_uvs.len() == shape.positions.len();
            has_colors &= shape.colors.len() == shape.positions.len();
            has_influences &= shape.influences.len() == shape.positions.len();
            has_parts |= !shape.parts.is_empty();
            all.positions.extend(shape.positions);
            all.normals.extend(shape.normals);
            all.uvs.extend(shape.uvs);
            all.second_uvs.extend(shape.second_uvs);
            all.colors.extend(shape.colors);
            all.influences.extend(shape.influences);
            all.indices.extend(shape.indices.iter().map(|index| first + index));
            let whole = Part { triangles: 0..triangles, material_slot: 0 };
            let parts = if shape.parts.is_empty() { vec![whole] } else { shape.parts };
            all.parts.extend(parts.into_iter().map(|part| Part {
                triangles: part.triangles.start + first_triangle..part.triangles.end + first_triangle,
                ..part
            }));
        }
        let keep = |has: bool| if has { usize::MAX } else { 0 };
        all.normals.truncate(keep(has_normals));
        all.uvs.truncate(keep(has_uvs));
        all.second_uvs.truncate(keep(has_second_uvs));
        all.colors.truncate(keep(has_colors));
        all.influences.truncate(keep(has_influences));
        all.parts.truncate(keep(has_parts));
        all
    }

    /// The shape with every triangle in material slot `slot`.
    #[must_use]
    pub fn in_slot(mut self, slot: usize) -> Self {
        self.parts = vec![Part { triangles: 0..self.indices.len() as u32 / 3, material_slot: slot }];
        self
    }

    /// The shape without the triangles for which `gone` says so; parts are forgotten.
    #[must_use]
    pub fn without_triangles(mut self, gone: impl Fn(usize) -> bool) -> Self {
        let kept = self.indices.chunks_exact(3).enumerate().filter(|(i, _)| !gone(*i));
        self.indices = kept.flat_map(|(_, corners)| corners.to_vec()).collect();
        self.parts.clear();
        self
    }
}
