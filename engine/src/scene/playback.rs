//! Playing animations: what a clip makes of the nodes at one moment.
//!
//! A moment is shown by setting transforms and weights, so that everything else sees a scene like any other. The
//! result depends on the clip and the time alone: nodes that no channel of the clip moves are set back to rest first.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use super::{
    Animation, AnimationKey, Content, NodeKey, Property, Scene, SceneError, Skin, SkinKey, Transform,
};

/// How a node stands while no animation moves it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Rest {
    pub(super) transform: Transform,
    /// The weights of its mesh's morph targets; empty for the mesh's own.
    pub(super) weights: Vec<f64>,
}

/// Skins and animations.
impl Scene {
    /// Stores a skin and returns its key; mesh nodes name it.
    ///
    /// # Errors
    /// [`SceneError::BadContent`] for a skin without joints, or whose bind matrices are not finite or not as many.
    pub fn add_skin(&mut self, skin: Skin) -> Result<SkinKey, SceneError> {
        skin.check()?;
        self.touch();
        Ok(self.skins.insert(skin))
    }

    /// The skin behind `key`, if it is still there.
    pub fn skin(&self, key: SkinKey) -> Option<&Skin> {
        self.skins.get(key)
    }

    /// Every skin with its key.
    pub fn skins(&self) -> impl Iterator<Item = (SkinKey, &Skin)> {
        self.skins.iter()
    }

    /// Places a node by translation, rotation and scale: that is also where it rests.
    ///
    /// # Errors
    /// [`SceneError::Missing`] when the node is gone.
    pub fn set_transform(&mut self, key: NodeKey, transform: Transform) -> Result<(), SceneError> {
        let node = self.nodes.get_mut(key);
        let node = node.ok_or_else(|| SceneError::Missing { what: "node", key: format!("{key:?}") })?;
        let weights = weights_of(&node.content).to_vec();
        node.parent_from_local = transform.matrix();
        node.rest = Some(Rest { transform, weights });
        self.touch();
        Ok(())
    }

    /// Stores an animation and returns its key. Nodes it moves rest as they stand now, unless they have been placed by
    /// [`Scene::set_transform`].
    ///
    /// # Errors
    /// [`SceneError`] when it moves a node that is not there, one whose transform shears or flattens, or weights of a
    /// node without as many morph targets.
    pub fn add_animation(&mut self, animation: Animation) -> Result<AnimationKey, SceneError> {
        let mut rests = BTreeMap::new();
        for channel in &animation.channels {
            let bad = |problem: String| {
                let name = animation.name.clone();
                SceneError::BadContent { what: "animation", name, problem }
            };
            let node = self.nodes.get(channel.node);
            let node = node.ok_or_else(|| bad(format!("it moves {:?}, which is not there", channel.node)))?;
            if channel.track.property() == Property::Weights {
                let targets = match &node.content {
                    Content::Mesh(content) => {
                        self.mesh(content.mesh).map_or(0, |mesh| mesh.data().morphs.len())
                    }
                    _ => 0,
                };
                let width = channel.track.width();
                if targets != width {
                    return Err(bad(format!(
                        "it sets {width} weights of node '{}', whose mesh has {targets} morph targets",
                        node.name
                    )));
                }
            }
            if node.rest.is_none() {
                let transform = Transform::of(&node.parent_from_local).ok_or_else(|| {
                    bad(format!(
                        "it moves node '{}', whose transform is no translation, rotation and scale",
                        node.name
                    ))
                })?;
                let weights = weights_of(&node.content).to_vec();
                rests.insert(channel.node, Rest { transform, weights });
            }
        }
        for (key, rest) in rests {
            self.nodes[key].rest = Some(rest);
        }
        self.touch();
        Ok(self.animations.insert(animation))
    }

    /// The animation behind `key`, if it is still there.
    pub fn animation(&self, key: AnimationKey) -> Option<&Animation> {
        self.animations.get(key)
    }

    /// Every animation with its key, in the order they were added.
    pub fn animations(&self) -> impl Iterator<Item = (AnimationKey, &Animation)> {
        self.animations.iter()
    }

    /// The first animation called `name`.
    pub fn find_animation(&self, name: &str) -> Option<AnimationKey> {
        self.animations.iter().find(|(_, animation)| animation.name == name).map(|(key, _)| key)
    }

    /// Shows `animation` at `seconds`: before its first key and after its last as there
    /// ([`Animation::looped`] is for playing over and over). Nodes that only other animations move go to rest.
    ///
    /// Counts as a change of the scene if anything moved.
    ///
    /// # Errors
    /// [`SceneError`] when the animation is gone, the time is not finite, or weights no longer fit the mesh. Nothing
    /// has moved then.
    pub fn animate(&mut self, animation: AnimationKey, seconds: f64) -> Result<(), SceneError> {
        self.show(&[animation], seconds)
    }

    /// Shows every animation at `seconds`; where several set one property of a node, the last counts.
    ///
    /// # Errors
    /// As [`Scene::animate`].
    pub fn animate_all(&mut self, seconds: f64) -> Result<(), SceneError> {
        let all: Vec<AnimationKey> = self.animations.keys().collect();
        self.show(&all, seconds)
    }

    /// Sets every node that an animation moves back to rest.
    ///
    /// # Errors
    /// As [`Scene::animate`].
    pub fn rest(&mut self) -> Result<(), SceneError> {
        self.show(&[], 0.0)
    }

    fn show(&mut self, shown: &[AnimationKey], seconds: f64) -> Result<(), SceneError> {
        if !seconds.is_finite() {
            return Err(SceneError::BadTime { seconds });
        }
        let mut poses: BTreeMap<NodeKey, Rest> = BTreeMap::new();
        for channel in self.animations.values().flat_map(|animation| &animation.channels) {
            // Removing a node removes its channels, and every other had a rest when its animation came.
            if let Some(rest) = self.nodes.get(channel.node).and_then(|node| node.rest.as_ref()) {
                poses.entry(channel.node).or_insert_with(|| rest.clone());
            }
        }
        for key in shown {
            let missing = || SceneError::Missing { what: "animation", key: format!("{key:?}") };
            for channel in &self.animations.get(*key).ok_or_else(missing)?.channels {
                let Some(pose) = poses.get_mut(&channel.node) else { continue };
                let values = channel.track.sample(seconds);
                match channel.track.property() {
                    Property::Translation => pose.transform.translation = DVec3::from_slice(&values),
                    Property::Rotation => pose.transform.rotation = DQuat::from_slice(&values),
                    Property::Scale => pose.transform.scale = DVec3::from_slice(&values),
                    Property::Weights => pose.weights = values,
                }
            }
        }
        let mut moved = false;
        for (key, pose) in poses {
            let node = &mut self.nodes[key];
            let matrix = pose.transform.matrix();
            moved |= node.parent_from_local != matrix;
            node.parent_from_local = matrix;
            if let Content::Mesh(content) = &mut node.content
                && content.weights != pose.weights
            {
                content.weights = pose.weights;
                moved = true;
            }
        }
        if moved {
            self.touch();
        }
        Ok(())
    }
}

fn weights_of(content: &Content) -> &[f64] {
    match content {
        Content::Mesh(content) => &content.weights,
        _ => &[],
    }
}
