//! What lets a mesh change its shape: the joints that move its vertices, and its morph targets.

use glam::Vec3;

use super::MeshError;

/// The joints that move one vertex, and how much each does.
///
/// Kept in one canonical form (ascending joints, each once, those without weight left out), so that vertices which
/// two exporters' halves of a seam describe in different order still move to the same place, bit by bit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Influences {
    joints: [u16; Self::MOST],
    weights: [f32; Self::MOST],
}

impl Influences {
    /// The most joints of one vertex: two sets of four, as glTF files have them.
    pub const MOST: usize = 8;

    /// Influences from (joint, weight); of more than [`Influences::MOST`] the heaviest are kept. Weights need not sum
    /// to 1. A vertex without any weight follows the first joint named.
    pub fn new(pairs: impl IntoIterator<Item = (u16, f32)>) -> Self {
        let mut merged: Vec<(u16, f32)> = Vec::new();
        let mut first = None;
        for (joint, weight) in pairs {
            first = first.or(Some(joint));
            match merged.iter_mut().find(|(other, _)| *other == joint) {
                Some((_, sum)) => *sum += weight,
                None => merged.push((joint, weight)),
            }
        }
        merged.retain(|(_, weight)| *weight != 0.0);
        merged.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        merged.truncate(Self::MOST);
        merged.sort_by_key(|(joint, _)| *joint);
        if merged.is_empty() {
            merged.push((first.unwrap_or(0), 0.0));
        }
        let mut influences = Self::default();
        for (place, (joint, weight)) in merged.into_iter().enumerate() {
            (influences.joints[place], influences.weights[place]) = (joint, weight);
        }
        influences
    }

    /// The joints, as places in the skin's list; those without weight are 0.
    pub fn joints(&self) -> [u16; Self::MOST] {
        self.joints
    }

    /// The weights as they were given.
    pub fn weights(&self) -> [f32; Self::MOST] {
        self.weights
    }

    /// The joints with weight, or the one followed without; the weights sum to 1.
    pub fn normalized(&self) -> impl Iterator<Item = (usize, f64)> {
        let sum: f64 = self.weights.iter().map(|weight| f64::from(*weight)).sum();
        let share = move |weight: f32| if sum > 0.0 { f64::from(weight) / sum } else { 1.0 };
        let used = self.weights.iter().filter(|weight| **weight != 0.0).count().max(1);
        (0..used).map(move |place| (usize::from(self.joints[place]), share(self.weights[place])))
    }
}

/// One morph target: how far each vertex moves at a weight of 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MorphTarget {
    /// Its name; need not be unique.
    pub name: String,
    /// Displacements, one for each vertex; empty for none.
    pub positions: Vec<Vec3>,
    /// What is added to normals, one for each vertex; empty for none.
    pub normals: Vec<Vec3>,
    /// The weight where a node says nothing else.
    pub weight: f32,
}

/// Checks a mesh's influences and morph targets against its number of vertices.
pub(super) fn validate(
    mesh: &str,
    vertices: usize,
    influences: &[Influences],
    morphs: &[MorphTarget],
) -> Result<(), MeshError> {
    let length = |stream: &'static str, count: usize| match count == 0 || count == vertices {
        true => Ok(()),
        false => Err(MeshError::StreamLength { mesh: mesh.into(), stream, count, vertices }),
    };
    length("influences", influences.len())?;
    for (vertex, influences) in influences.iter().enumerate() {
        if let Some(weight) =
            influences.weights.iter().find(|weight| !(weight.is_finite() && **weight >= 0.0))
        {
            return Err(MeshError::BadWeight { mesh: mesh.into(), vertex, weight: *weight });
        }
    }
    for (target, morph) in morphs.iter().enumerate() {
        length("displacements of a morph target", morph.positions.len())?;
        length("normals of a morph target", morph.normals.len())?;
        let all = || morph.positions.iter().chain(&morph.normals);
        if !morph.weight.is_finite() || !all().all(|value| value.is_finite()) {
            return Err(MeshError::BadMorph { mesh: mesh.into(), target });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn influences_have_one_form() {
        let one = Influences::new([(3, 0.25), (1, 0.5), (3, 0.25), (7, 0.0)]);
        assert_eq!(one, Influences::new([(1, 0.5), (3, 0.5)]));
        assert_eq!(one.normalized().collect::<Vec<_>>(), [(1, 0.5), (3, 0.5)]);
        let twice = Influences::new([(1, 1.0), (3, 3.0)]);
        assert_eq!(twice.normalized().collect::<Vec<_>>(), [(1, 0.25), (3, 0.75)]);
        let none = Influences::new([(5, 0.0), (6, 0.0)]);
        assert_eq!(none.normalized().collect::<Vec<_>>(), [(5, 1.0)]);
        assert_eq!(Influences::new([]).normalized().collect::<Vec<_>>(), [(0, 1.0)]);
        let many = Influences::new((0..12).map(|joint| (joint, f32::from(joint) + 1.0)));
        assert_eq!(many.joints(), [4, 5, 6, 7, 8, 9, 10, 11]);
        let bad = [Influences::new([(0, f32::NAN)]), Influences::new([(0, -0.5)])];
        for influences in bad {
            assert!(matches!(validate("m", 1, &[influences], &[]), Err(MeshError::BadWeight { .. })));
        }
    }
}
