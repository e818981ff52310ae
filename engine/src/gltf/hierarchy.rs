//! Which node is whose child, and that the nodes form trees.

use super::GltfError;
use super::fields::Item;
use super::limits::Warnings;

/// Parents and children of every node of the document.
#[derive(Debug, Default)]
pub(super) struct Hierarchy {
    parents: Vec<Option<usize>>,
    children: Vec<Vec<usize>>,
}

impl Hierarchy {
    /// Reads the hierarchy; a node with two parents, or one under itself, is an error.
    pub(super) fn read(nodes: &[Item<'_>]) -> Result<Self, GltfError> {
        let mut hierarchy = Self { parents: vec![None; nodes.len()], children: Vec::new() };
        for (parent, node) in nodes.iter().enumerate() {
            let children = node.indices("children", "node", nodes.len())?;
            for &child in &children {
                if let Some(first) = hierarchy.parents[child].replace(parent) {
                    return Err(GltfError::NodeParents { node: child, first, second: parent });
                }
            }
            hierarchy.children.push(children);
        }
        // With one parent each, what the roots do not reach goes round in circles.
        let roots = (0..nodes.len()).filter(|node| hierarchy.parents[*node].is_none()).collect();
        let mut reached = vec![false; nodes.len()];
        for node in hierarchy.preorder(roots) {
            reached[node] = true;
        }
        match reached.iter().position(|reached| !reached) {
            Some(node) => Err(GltfError::NodeCycle { node }),
            None => Ok(hierarchy),
        }
    }

    pub(super) fn parent(&self, node: usize) -> Option<usize> {
        self.parents[node]
    }

    /// For every node the root above it, and the places in depth-first order where what lies under it begins and ends.
    pub(super) fn spans(&self) -> Vec<(usize, std::ops::Range<usize>)> {
        let roots = (0..self.parents.len()).filter(|node| self.parents[*node].is_none()).collect();
        let order = self.preorder(roots);
        let mut spans = vec![(0, 0..0); self.parents.len()];
        for (place, node) in order.iter().enumerate() {
            let root = self.parents[*node].map_or(*node, |parent| spans[parent].0);
            spans[*node] = (root, place..place + 1);
        }
        for node in order.iter().rev() {
            if let Some(parent) = self.parents[*node] {
                spans[parent].1.end = spans[parent].1.end.max(spans[*node].1.end);
            }
        }
        spans
    }

    /// `roots` and everything under them, parents first.
    pub(super) fn preorder(&self, roots: Vec<usize>) -> Vec<usize> {
        let mut order = Vec::new();
        let mut open = roots;
        open.reverse();
        while let Some(node) = open.pop() {
            order.push(node);
            open.extend(self.children[node].iter().rev());
        }
        order
    }

    /// Checks the nodes that a scene lists, so that none comes into the scene twice.
    ///
    /// They should be roots. Some exporters list a child and leave its parent out; it then stands as a root, with a
    /// warning.
    pub(super) fn check_roots(
        &self,
        scene: usize,
        roots: &[usize],
        warnings: &mut Warnings,
    ) -> Result<(), GltfError> {
        let nodes = self.parents.len();
        let mut listed = vec![false; nodes];
        for &node in roots {
            if std::mem::replace(&mut listed[node], true) {
                let problem = "it lists already".into();
                return Err(GltfError::NotARoot { scene, node, problem });
            }
        }
        let mut inside = vec![false; nodes];
        let all = (0..nodes).filter(|node| self.parents[*node].is_none()).collect();
        for node in self.preorder(all) {
            let Some(parent) = self.parents[node] else { continue };
            inside[node] = inside[parent] || listed[parent];
            if listed[node] && inside[node] {
                let problem = "lies under another node that it lists".into();
                return Err(GltfError::NotARoot { scene, node, problem });
            }
            if listed[node] {
                warnings.add(format!(
                    "scene {scene} lists node {node} without its parent {parent}, whose transform is left out"
                ));
            }
        }
        Ok(())
    }
}
