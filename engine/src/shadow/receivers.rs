//! Choosing receivers where a scene names none.

use super::ShadowTechnique;
use crate::scene::{SceneSnapshot, Scope};

/// The receivers of a node that shades all it can: every mesh, or, for a technique that shades receivers only, every
/// mesh that it accepts. If it accepts none, every mesh again, so that its refusal gives the reason.
pub fn receivers_for(snapshot: &SceneSnapshot, technique: &dyn ShadowTechnique) -> Scope {
    let receives = snapshot.instances.iter().filter(|i| i.shadow.receives && technique.receives(i).is_ok());
    let nodes: Vec<_> = receives.map(|instance| instance.node).collect();
    if technique.traits().shades_receivers_only && !nodes.is_empty() {
        Scope::Nodes(nodes)
    } else {
        Scope::All
    }
}
