//! The front caps of a shadow volume.

use shadowgraph_engine::geometry::Chain;
use shadowgraph_engine::scene::Instance;

use super::volume::CastShape;

/// A corner of a cap.
fn cap(vertex: u32) -> u32 {
    vertex << 2
}

/// The corners of front caps: of those that count as the chain does, and of those that count the other way round.
#[derive(Default)]
pub(super) struct FrontCaps {
    /// Of the mesh's own triangles.
    pub(super) own: [Vec<u32>; 2],
    /// Of triangles that close the mesh.
    pub(super) unseen: [Vec<u32>; 2],
}

impl FrontCaps {
    /// The caps of a chain.
    pub(super) fn new(instance: &Instance, shape: &CastShape<'_>, chain: &Chain) -> Self {
        let own_count = instance.mesh.triangle_count() as u32;
        let welded = shape.topology().triangles();
        let mut caps = Self::default();
        for (turned, list) in [&chain.caps_front, &chain.caps_back].into_iter().enumerate() {
            caps.own[turned].reserve(list.len() * 3);
            for &triangle in list {
                let (caps, [a, b, c]) = if triangle < own_count {
                    (&mut caps.own[turned], instance.mesh.triangle(triangle as usize))
                } else if matches!(shape, CastShape::Doubled(_)) {
                    // The reverse of a triangle is that triangle, counted the other way round.
                    (&mut caps.own[1 - turned], instance.mesh.triangle((triangle - own_count) as usize))
                } else {
                    (&mut caps.unseen[turned], welded[triangle as usize])
                };
                caps.extend_from_slice(&[cap(a), cap(b), cap(c)]);
            }
        }
        caps
    }
}
