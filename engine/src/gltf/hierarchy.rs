//! Which node is whose child, and that the nodes form trees.

use super::GltfError;
use super::fields::Item;

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

    /// Checks the nodes that a scene lists: roots, each once.
    pub(super) fn check_roots(&self, scene: usize, roots: &[usize]) -> Result<(), GltfError> {
        let mut listed = vec![false; self.parents.len()];
        for &node in roots {
            let problem = match self.parents[node] {
                Some(parent) => format!("is a child of node {parent}"),
                None if listed[node] => "it lists already".into(),
                None => {
                    listed[node] = true;
                    continue;
                }
            };
            return Err(GltfError::NotARoot { scene, node, problem });
        }
        Ok(())
    }
}
