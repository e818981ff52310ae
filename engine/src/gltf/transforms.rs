//! Transforms of nodes, and how far they may reach.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::GltfError;
use super::fields::Item;
use super::names::few_digits;
use crate::scene::Transform;

/// A node's transform, from its matrix or its translation, rotation and scale.
pub(super) fn transform(node: &Item<'_>) -> Result<DAffine3, GltfError> {
    let wrong = |problem: &str| GltfError::Transform { node: node.label(), problem: problem.into() };
    let matrix = match (node.numbers::<16>("matrix")?, parts(node)?) {
        (Some(_), Some(_)) => {
            return Err(wrong("is given twice (a matrix, or translation, rotation and scale, are accepted)"));
        }
        (Some(matrix), None) => {
            if [matrix[3], matrix[7], matrix[11], matrix[15] - 1.0].iter().any(|x| x.abs() > 1e-6) {
                return Err(wrong("is not affine (the matrix's last row must be 0 0 0 1)"));
            }
            DAffine3::from_mat4(DMat4::from_cols_array(&matrix))
        }
        (None, parts) => parts.unwrap_or_default().matrix(),
    };
    check_reach(&matrix).map_err(|problem| wrong(&problem))?;
    Ok(matrix)
}

/// The largest number a transform may hold: squares of distances beyond it would leave f32.
const FARTHEST_M: f64 = 1e18;

pub(super) fn check_reach(matrix: &DAffine3) -> Result<(), String> {
    let values = matrix.to_cols_array();
    match values.iter().find(|value| value.is_nan() || value.abs() > FARTHEST_M) {
        Some(value) => Err(format!("holds {}; numbers from -1e18 to 1e18 are accepted", few_digits(*value))),
        None => Ok(()),
    }
}

/// A node's translation, rotation and scale; `None` for one that names none of them.
pub(super) fn parts(node: &Item<'_>) -> Result<Option<Transform>, GltfError> {
    let translation = node.numbers("translation")?;
    let rotation = node.numbers("rotation")?;
    let scale = node.numbers("scale")?;
    if translation.is_none() && rotation.is_none() && scale.is_none() {
        return Ok(None);
    }
    let rotation = DQuat::from_array(rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]));
    let length = rotation.length();
    if !(length > 0.0 && length.is_finite()) {
        let problem = "has a rotation without direction (a unit quaternion is needed)".into();
        return Err(GltfError::Transform { node: node.label(), problem });
    }
    // What has length 1 already, as in files this project saved, keeps its last digit.
    let rotation = if (length - 1.0).abs() < 1e-15 { rotation } else { rotation.normalize() };
    Ok(Some(Transform {
        translation: translation.map_or(DVec3::ZERO, DVec3::from),
        rotation,
        scale: scale.map_or(DVec3::ONE, DVec3::from),
    }))
}
