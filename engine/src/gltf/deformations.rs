//! What bends a primitive: joint influences of its vertices and its morph targets, sparse accessors included.

use glam::Vec3;
use serde_json::{Map, Value};

use super::GltfError;
use super::accessors::{Accessors, Integers};
use super::limits::{Budget, Warnings};
use crate::geometry::{Influences, MeshData, MorphTarget};

/// The accessors of a primitive's influences and morph targets.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct BendStreams {
    /// Joints and weights of each set of four.
    sets: Vec<(usize, usize)>,
    /// Displacements of positions and of normals of each target.
    targets: Vec<(Option<usize>, Option<usize>)>,
}

impl BendStreams {
    /// The streams that `primitive` names.
    pub(super) fn of(
        primitive: &Map<String, Value>,
        mesh: usize,
        wrong: &dyn Fn(String) -> GltfError,
        warnings: &mut Warnings,
    ) -> Result<Self, GltfError> {
        let stream = |semantic: String| attribute(primitive.get("attributes"), &semantic);
        let mut sets = Vec::new();
        for set in 0..2 {
            match (stream(format!("JOINTS_{set}")), stream(format!("WEIGHTS_{set}"))) {
                (Some(joints), Some(weights)) => sets.push((joints, weights)),
                (None, None) => {}
                (joints, _) => {
                    let (has, lacks) =
                        if joints.is_some() { ("JOINTS", "WEIGHTS") } else { ("WEIGHTS", "JOINTS") };
                    return Err(wrong(format!("it has {has}_{set}, but no {lacks}_{set}")));
                }
            }
        }
        if stream("JOINTS_2".into()).is_some() {
            warnings.add(format!("mesh {mesh}: joints beyond the eighth of a vertex are ignored"));
        }
        let target =
            |target: &Value| (attribute(Some(target), "POSITION"), attribute(Some(target), "NORMAL"));
        let targets = primitive.get("targets").and_then(Value::as_array);
        let targets = targets.into_iter().flatten().map(target).collect();
        Ok(Self { sets, targets })
    }

    /// The number of morph targets.
    pub(super) fn target_count(&self) -> usize {
        self.targets.len()
    }

    /// Reads the streams of the run of vertices that begins at `start` and ends with the mesh.
    pub(super) fn append(
        &self,
        accessors: &Accessors<'_>,
        start: usize,
        data: &mut MeshData,
        budget: &mut Budget,
        wrong: &dyn Fn(String) -> GltfError,
    ) -> Result<(), GltfError> {
        let vertices = data.positions.len() - start;
        let same_length = |stream: &str, count: usize| match count == vertices {
            true => Ok(()),
            false => Err(wrong(format!("{stream} has {count} entries for {vertices} vertices"))),
        };
        if !self.sets.is_empty() {
            let mut pairs: Vec<Vec<(u16, f32)>> = vec![Vec::new(); vertices];
            for (joints, weights) in &self.sets {
                budget.charge_elements(vertices as u64 * 8)?;
                let joints = accessors.joints(*joints, "JOINTS", budget)?;
                same_length("JOINTS", joints.len())?;
                let weights = accessors.floats::<4>(*weights, "WEIGHTS", Integers::Normalized, budget)?;
                same_length("WEIGHTS", weights.len())?;
                for ((pairs, joints), weights) in pairs.iter_mut().zip(joints).zip(weights) {
                    pairs.extend(joints.into_iter().zip(weights));
                }
            }
            let off =
                |pairs: &&Vec<(u16, f32)>| (pairs.iter().map(|pair| pair.1).sum::<f32>() - 1.0).abs() > 0.01;
            let twice = |pairs: &&Vec<(u16, f32)>| {
                let moving = || pairs.iter().filter(|pair| pair.1 != 0.0).enumerate();
                moving().any(|(i, a)| moving().any(|(j, b)| i < j && a.0 == b.0))
            };
            let (off, twice) = (pairs.iter().filter(off).count(), pairs.iter().filter(twice).count());
            let name = super::names::shown(&data.name);
            if off > 0 {
                accessors
                    .document
                    .note(format!("mesh '{name}': joint weights of {off} vertices do not add up to 1"));
            }
            if twice > 0 {
                accessors.document.note(format!("mesh '{name}': {twice} vertices name one joint twice"));
            }
            data.influences.resize(start, Influences::default());
            data.influences.extend(pairs.into_iter().map(Influences::new));
        }
        // Triangles without normals get their planes', however they are bent.
        let has_normals = data.normals.len() == data.positions.len();
        for (index, (positions, normals)) in self.targets.iter().enumerate() {
            budget.charge_elements(vertices as u64 * 2)?;
            let mut read =
                |accessor: &Option<usize>, purpose, stream: &mut Vec<Vec3>| -> Result<(), GltfError> {
                    let Some(accessor) = accessor else { return Ok(()) };
                    budget.charge_elements(start as u64)?;
                    let moved = accessors.floats::<3>(*accessor, purpose, Integers::AsDeclared, budget)?;
                    same_length(purpose, moved.len())?;
                    stream.resize(start, Vec3::ZERO);
                    stream.extend(moved.into_iter().map(Vec3::from));
                    Ok(())
                };
            let target = &mut data.morphs[index];
            read(positions, "POSITION of a morph target", &mut target.positions)?;
            if has_normals {
                read(normals, "NORMAL of a morph target", &mut target.normals)?;
            }
        }
        Ok(())
    }
}

/// Fills up what an earlier primitive has and a later one lacks.
pub(super) fn pad(data: &mut MeshData, vertices: usize) {
    if !data.influences.is_empty() {
        data.influences.resize(vertices, Influences::default());
    }
    for target in &mut data.morphs {
        for stream in [&mut target.positions, &mut target.normals] {
            if !stream.is_empty() {
                stream.resize(vertices, Vec3::ZERO);
            }
        }
    }
}

/// The accessor of an attribute, if there is one.
pub(super) fn attribute(attributes: Option<&Value>, name: &str) -> Option<usize> {
    Some(attributes?.get(name)?.as_u64()? as usize)
}

/// The morph targets of a mesh, still without vertices: names from `extras.targetNames`, weights from the mesh.
pub(super) fn targets(
    mesh: usize,
    declaration: &Map<String, Value>,
    count: usize,
    budget: &mut Budget,
) -> Result<Vec<MorphTarget>, GltfError> {
    budget.charge_elements(count as u64 * 8)?;
    let weights = declaration.get("weights").and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    if !weights.is_empty() && weights.len() != count {
        let problem = format!("has {} weights for {count} morph targets", weights.len());
        return Err(GltfError::Field { item: format!("mesh {mesh}"), field: "weights".into(), problem });
    }
    let name =
        |index: usize| Some(declaration.get("extras")?.get("targetNames")?.get(index)?.as_str()?.to_owned());
    let target = |index: usize| MorphTarget {
        name: name(index).unwrap_or_default(),
        weight: weights.get(index).and_then(Value::as_f64).unwrap_or(0.0) as f32,
        ..MorphTarget::default()
    };
    Ok((0..count).map(target).collect())
}
