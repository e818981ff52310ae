//! Boxes cut by planes.

use glam::DVec3;
use shadowgraph_engine::math::Plane;

/// The faces of a box with these corners.
pub(super) fn faces_of(corners: &[DVec3; 8]) -> Vec<Vec<DVec3>> {
    let faces = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    faces.map(|face| face.map(|corner| corners[corner]).to_vec()).to_vec()
}

/// The faces of a convex body on the positive side of a plane, with the one that the cut makes; of a single face, what is left
/// of it.
pub fn cut(faces: &[Vec<DVec3>], plane: &Plane) -> Vec<Vec<DVec3>> {
    let mut kept = Vec::new();
    let mut lid: Vec<DVec3> = Vec::new();
    for face in faces {
        let mut outline = Vec::with_capacity(face.len() + 1);
        for (number, &from) in face.iter().enumerate() {
            let to = face[(number + 1) % face.len()];
            let (height, next) = (plane.height(from), plane.height(to));
            if height >= 0.0 {
                outline.push(from);
            }
            if (height >= 0.0) != (next >= 0.0) {
                let crossing = from + (to - from) * (height / (height - next));
                outline.push(crossing);
                lid.push(crossing);
            }
        }
        if !outline.is_empty() {
            kept.push(outline);
        }
    }
    if lid.len() > 2 {
        let middle = lid.iter().sum::<DVec3>() / lid.len() as f64;
        let (x, y) = plane.normal.any_orthonormal_pair();
        let angle = |p: &DVec3| (*p - middle).dot(y).atan2((*p - middle).dot(x));
        lid.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        kept.push(lid);
    }
    kept
}
