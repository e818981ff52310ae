//! Skins: the nodes that move a mesh's vertices.

use glam::DAffine3;

use super::{NodeKey, SceneError};

/// The joints of a skinned mesh. The mesh's influences name them by their place in the list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skin {
    /// Its name; need not be unique.
    pub name: String,
    /// The nodes that move the vertices.
    pub joints: Vec<NodeKey>,
    /// For each joint the transform from the mesh's local space to the joint's, as they were bound; empty when all
    /// are the identity. Any affine map, singular ones included.
    pub joint_from_mesh: Vec<DAffine3>,
}

impl Skin {
    /// A skin of `joints`, bound by `joint_from_mesh`.
    pub fn new(name: &str, joints: Vec<NodeKey>, joint_from_mesh: Vec<DAffine3>) -> Self {
        Self { name: name.into(), joints, joint_from_mesh }
    }

    /// What is wrong with it, if anything.
    pub(super) fn check(&self) -> Result<(), SceneError> {
        let bad =
            |problem: String| Err(SceneError::BadContent { what: "skin", name: self.name.clone(), problem });
        let (joints, binds) = (self.joints.len(), self.joint_from_mesh.len());
        if joints == 0 {
            return bad("it has no joints (at least 1 is needed)".into());
        }
        if binds != 0 && binds != joints {
            return bad(format!("it has {binds} bind matrices for {joints} joints"));
        }
        match self.joint_from_mesh.iter().position(|bind| !bind.is_finite()) {
            Some(joint) => bad(format!("the bind matrix of joint {joint} is not finite")),
            None => Ok(()),
        }
    }
}
