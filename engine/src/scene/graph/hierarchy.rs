//! The hierarchy: walking it, transforms along it, moving and removing what hangs in it.

use std::collections::{HashMap, HashSet};

use glam::DAffine3;

use super::{NodeKey, Scene, SceneError};

impl Scene {
    /// The first node called `name`, depth first.
    pub fn find(&self, name: &str) -> Option<NodeKey> {
        self.depth_first().into_iter().find(|key| self.nodes[*key].name == name)
    }

    /// Every node of the forest, parents before children, in the order they were added.
    pub fn depth_first(&self) -> Vec<NodeKey> {
        self.roots.iter().flat_map(|root| self.subtree(*root)).collect()
    }

    /// `root` and everything under it, parents first; empty when the node is gone.
    pub fn subtree(&self, root: NodeKey) -> Vec<NodeKey> {
        let mut keys = Vec::new();
        let mut open = vec![root];
        while let Some(key) = open.pop() {
            if let Some(node) = self.nodes.get(key) {
                keys.push(key);
                open.extend(node.children.iter().rev());
            }
        }
        keys
    }

    /// All that lies at or under any of `roots`; what several of them have in common is visited once.
    pub(in crate::scene) fn subtrees(&self, roots: &[NodeKey]) -> HashSet<NodeKey> {
        let mut keys = HashSet::new();
        let mut open = roots.to_vec();
        while let Some(key) = open.pop() {
            if let Some(node) = self.nodes.get(key)
                && keys.insert(key)
            {
                open.extend(&node.children);
            }
        }
        keys
    }

    /// [`Scene::world_from_local`] of many nodes, in time that grows with how many there are and not with how deep
    /// they lie as well; the last digits may differ.
    pub(in crate::scene) fn worlds_from_locals(&self, keys: &[NodeKey]) -> Vec<Option<DAffine3>> {
        let mut known: HashMap<NodeKey, DAffine3> = HashMap::new();
        let mut path = Vec::new();
        let mut world = |key: NodeKey| {
            let mut next = Some(key);
            let mut world_from_local = DAffine3::IDENTITY;
            while let Some(key) = next {
                if let Some(found) = known.get(&key) {
                    world_from_local = *found;
                    break;
                }
                path.push(key);
                next = self.nodes.get(key)?.parent;
            }
            while let Some(key) = path.pop() {
                world_from_local *= self.nodes.get(key)?.parent_from_local;
                known.insert(key, world_from_local);
            }
            Some(world_from_local)
        };
        keys.iter().map(|key| if self.nodes.contains_key(*key) { world(*key) } else { None }).collect()
    }

    /// The transform from the node's local space to the world; `None` when the node is gone.
    pub fn world_from_local(&self, key: NodeKey) -> Option<DAffine3> {
        let mut node = self.nodes.get(key)?;
        let mut world_from_local = node.parent_from_local;
        while let Some(parent) = node.parent {
            node = &self.nodes[parent];
            world_from_local = node.parent_from_local * world_from_local;
        }
        Some(world_from_local)
    }

    /// Hangs `key` under `parent` (`None`: makes it a root), keeping its local transform.
    ///
    /// # Errors
    /// [`SceneError::Missing`] when either is gone, [`SceneError::Cycle`] when `parent` lies under `key`.
    pub fn reparent(&mut self, key: NodeKey, parent: Option<NodeKey>) -> Result<(), SceneError> {
        for key in [Some(key), parent].into_iter().flatten() {
            if !self.nodes.contains_key(key) {
                return Err(SceneError::Missing { what: "node", key: format!("{key:?}") });
            }
        }
        if let Some(parent) = parent
            && self.subtree(key).contains(&parent)
        {
            let name = |key: NodeKey| self.nodes[key].name.clone();
            return Err(SceneError::Cycle { node: name(key), parent: name(parent) });
        }
        self.touch();
        self.unlink(key);
        self.nodes[key].parent = parent;
        match parent {
            Some(parent) => self.nodes[parent].children.push(key),
            None => self.roots.push(key),
        }
        Ok(())
    }

    /// Removes `key` and everything under it, and the animation channels that moved it; what the nodes referred to
    /// stays until [`Scene::remove_unused`].
    ///
    /// # Errors
    /// [`SceneError::Missing`] when the node is gone already.
    pub fn remove(&mut self, key: NodeKey) -> Result<(), SceneError> {
        if !self.nodes.contains_key(key) {
            return Err(SceneError::Missing { what: "node", key: format!("{key:?}") });
        }
        self.touch();
        self.unlink(key);
        for key in self.subtree(key) {
            self.nodes.remove(key);
        }
        for animation in self.animations.values_mut() {
            animation.channels.retain(|channel| self.nodes.contains_key(channel.node));
        }
        Ok(())
    }

    fn unlink(&mut self, key: NodeKey) {
        match self.nodes[key].parent {
            Some(parent) => self.nodes[parent].children.retain(|child| *child != key),
            None => self.roots.retain(|root| *root != key),
        }
    }
}
