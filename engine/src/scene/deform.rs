//! Bent meshes: morph targets, then skinning, in f64 on the CPU.
//!
//! A bent mesh is a mesh like any other, so that plan, GPU, techniques and reference need to know nothing of joints:
//! what is drawn, what casts and what is judged are the same f32 vertices. It is kept for as long as the same pose is
//! asked for, with its identity, and with it everything that is kept by that identity.
//!
//! *Where it stands.* A morphed mesh stays in its local space. A skinned one leaves it: its vertices go to the world
//! by way of its joints, and the node's own transform says nothing (glTF 2.0, 3.7.3.3). It is stored about the middle
//! of its world box, so that its f32 positions keep their digits far from the origin. The same is done with meshes
//! under singular transforms, which have no inverse to take the light into local space with.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use glam::{DAffine3, DMat3, DVec3, Vec3};
use rayon::prelude::*;

use super::{MeshNode, Node, Scene, SceneError};
use crate::geometry::Mesh;
use crate::math::Aabb;

/// A mesh and where it stands.
type Placed = (Arc<Mesh>, DAffine3);

/// Farther from the world's origin nothing can be: squares of distances would leave f32.
pub(super) const FARTHEST_M: f64 = 1e18;

/// A determinant below this fraction of the product of its columns' lengths counts as zero.
const SINGULAR: f64 = 1e-7;

/// With more joints than this, what they have in common of their ways to the root is multiplied once.
const MANY_JOINTS: usize = 1024;

/// Vertices that one thread bends at least.
const VERTICES_PER_TASK: usize = 2048;

/// Everything a bent mesh depends on, bit by bit.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct PoseKey {
    mesh: u64,
    weights: Vec<u64>,
    /// The joints' transforms, or the one singular transform.
    transforms: Vec<[u64; 12]>,
    skinned: bool,
}

/// The bent meshes of recent poses.
#[derive(Debug, Default)]
pub(super) struct DeformCache {
    entries: Mutex<Entries>,
}

#[derive(Debug, Default)]
struct Entries {
    by_pose: HashMap<PoseKey, (Placed, u64)>,
    pose: u64,
}

/// A bent mesh that so many poses in a row did not need is dropped.
const KEPT_POSES: u64 = 4;

impl DeformCache {
    /// A new pose begins; what was not needed for long is dropped.
    pub(super) fn begin_pose(&self) {
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        entries.pose += 1;
        let oldest = entries.pose.saturating_sub(KEPT_POSES);
        entries.by_pose.retain(|_, (_, used)| *used >= oldest);
    }

    fn get_or_bend(
        &self,
        key: PoseKey,
        bend: impl FnOnce() -> Result<Placed, SceneError>,
    ) -> Result<Placed, SceneError> {
        let locked = || self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut entries = locked();
            let pose = entries.pose;
            if let Some((placed, used)) = entries.by_pose.get_mut(&key) {
                *used = pose;
                return Ok(placed.clone());
            }
        }
        // Not under the lock: bending runs on all threads, and one of them may be posing the same scene.
        let placed = bend()?;
        let mut entries = locked();
        let pose = entries.pose;
        Ok(entries.by_pose.entry(key).or_insert((placed, pose)).0.clone())
    }
}

impl Scene {
    /// The shape of a mesh node at this moment, and where it stands.
    pub(super) fn shaped(
        &self,
        node: &Node,
        content: &MeshNode,
        mesh: &Arc<Mesh>,
        world_from_local: DAffine3,
    ) -> Result<Placed, SceneError> {
        let weights = morph_weights(node, content, mesh)?;
        let joints = self.world_from_mesh(node, content, mesh)?;
        let singular = joints.is_none() && is_singular(&world_from_local);
        if weights.is_empty() && joints.is_none() && !singular {
            return Ok((Arc::clone(mesh), world_from_local));
        }
        let transforms = match &joints {
            Some(joints) => joints.clone(),
            None if singular => vec![world_from_local],
            None => Vec::new(),
        };
        let key = PoseKey {
            mesh: mesh.id(),
            weights: weights.iter().map(|weight| weight.to_bits()).collect(),
            transforms: transforms.iter().map(|t| t.to_cols_array().map(f64::to_bits)).collect(),
            skinned: joints.is_some(),
        };
        let (bent, about) = self.deformed.get_or_bend(key, || {
            let whole = |_: usize| transforms.first().copied();
            let skinned = |vertex: usize| {
                let influences = mesh.data().influences[vertex].normalized();
                Some(influences.fold(DAffine3::ZERO, |sum, (joint, weight)| {
                    let moved = &transforms[joint];
                    DAffine3 {
                        matrix3: sum.matrix3 + moved.matrix3 * weight,
                        translation: sum.translation + moved.translation * weight,
                    }
                }))
            };
            let bent =
                if joints.is_some() { bend(mesh, &weights, skinned) } else { bend(mesh, &weights, whole) };
            bent.map_err(|problem| SceneError::BadContent {
                what: "the pose of node",
                name: node.label(),
                problem,
            })
        })?;
        Ok((bent, if transforms.is_empty() { world_from_local } else { about }))
    }

    /// For each joint of the node's skin the transform from the mesh as it was bound to the world.
    fn world_from_mesh(
        &self,
        node: &Node,
        content: &MeshNode,
        mesh: &Mesh,
    ) -> Result<Option<Vec<DAffine3>>, SceneError> {
        let Some(key) = content.skin else { return Ok(None) };
        let missing = |what, key: String| SceneError::Missing {
            what,
            key: format!("{key} of node '{}'", node.label()),
        };
        let bad =
            |problem: String| SceneError::BadContent { what: "mesh of node", name: node.label(), problem };
        let skin = self.skin(key).ok_or_else(|| missing("skin", format!("{key:?}")))?;
        if mesh.data().influences.is_empty() && !mesh.positions().is_empty() {
            return Err(bad("it has a skin, but no vertex names a joint".into()));
        }
        let last = mesh.highest_joint().unwrap_or(0);
        if last >= skin.joints.len() {
            return Err(bad(format!("a vertex names joint {last}, but the skin has {}", skin.joints.len())));
        }
        let mut world_from_mesh = Vec::with_capacity(skin.joints.len());
        let worlds = if skin.joints.len() > MANY_JOINTS {
            self.worlds_from_locals(&skin.joints)
        } else {
            skin.joints.iter().map(|joint| self.world_from_local(*joint)).collect()
        };
        for ((place, joint), world_from_joint) in skin.joints.iter().enumerate().zip(worlds) {
            let world_from_joint = world_from_joint.ok_or_else(|| missing("joint", format!("{joint:?}")))?;
            if !is_placed(&world_from_joint) {
                return Err(SceneError::BadTransform { node: self.nodes[*joint].label() });
            }
            let bind = skin.joint_from_mesh.get(place).copied().unwrap_or(DAffine3::IDENTITY);
            world_from_mesh.push(world_from_joint * bind);
        }
        Ok(Some(world_from_mesh))
    }
}

/// Whether a transform is finite and leads nowhere too far.
pub(super) fn is_placed(world_from_local: &DAffine3) -> bool {
    // NaN is beyond every bound.
    world_from_local.to_cols_array().iter().all(|value| value.abs() <= FARTHEST_M)
}

fn is_singular(world_from_local: &DAffine3) -> bool {
    let linear = world_from_local.matrix3;
    let size = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
    let volume = linear.determinant().abs();
    volume.is_nan() || volume <= SINGULAR * size
}

/// The weights of the morph targets; none where no target takes part.
fn morph_weights(node: &Node, content: &MeshNode, mesh: &Mesh) -> Result<Vec<f64>, SceneError> {
    let morphs = &mesh.data().morphs;
    let bad =
        |problem: String| Err(SceneError::BadContent { what: "mesh of node", name: node.label(), problem });
    let weights = match &content.weights[..] {
        [] => morphs.iter().map(|morph| f64::from(morph.weight)).collect(),
        weights if weights.len() != morphs.len() => {
            return bad(format!(
                "{} weights are set, but it has {} morph targets",
                weights.len(),
                morphs.len()
            ));
        }
        weights => weights.to_vec(),
    };
    if let Some(target) = weights.iter().position(|weight| !weight.is_finite()) {
        return bad(format!("the weight of morph target {target} is not finite"));
    }
    Ok(if weights.iter().all(|weight| *weight == 0.0) { Vec::new() } else { weights })
}

/// Bends `mesh`: morphed by `weights`, then each vertex moved by its own transform, if there is one. What was moved is
/// stored about the middle of its box, and stands there.
fn bend(
    mesh: &Arc<Mesh>,
    weights: &[f64],
    world_from_vertex: impl Fn(usize) -> Option<DAffine3> + Sync,
) -> Result<Placed, String> {
    let data = mesh.data();
    let vertex = |index: usize| {
        let mut position = data.positions[index].as_dvec3();
        let mut normal = data.normals[index].as_dvec3();
        for (morph, weight) in data.morphs.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            let of =
                |stream: &[Vec3]| stream.get(index).map_or(DVec3::ZERO, |moved| moved.as_dvec3() * *weight);
            position += of(&morph.positions);
            normal += of(&morph.normals);
        }
        match world_from_vertex(index) {
            Some(world) => (world.transform_point3(position), cofactors(&world.matrix3) * normal),
            None => (position, normal),
        }
    };
    let count = data.positions.len();
    let bent: Vec<(DVec3, DVec3)> =
        (0..count).into_par_iter().with_min_len(VERTICES_PER_TASK).map(vertex).collect();
    let moved = count > 0 && world_from_vertex(0).is_some();
    let middle = if moved {
        Aabb::from_points(bent.iter().map(|(position, _)| *position)).center()
    } else {
        DVec3::ZERO
    };
    // As f32, so that the vertices of a mesh that bends within its box stay put bit by bit where they can.
    let about = middle.as_vec3().as_dvec3();
    let positions = bent.iter().map(|(position, _)| (*position - about).as_vec3()).collect();
    let normals = bent.iter().map(|(_, normal)| normal.normalize_or(DVec3::Y).as_vec3()).collect();
    let mesh = Mesh::posed(mesh, positions, normals).map_err(|error| error.to_string())?;
    Ok((Arc::new(mesh), DAffine3::from_translation(about)))
}

/// Turns normals as the inverse transpose does, and exists for singular transforms too.
fn cofactors(m: &DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}
