//! The front caps of a shadow volume, and the slivers that close them where their edges are cut.

use std::collections::BTreeMap;

use shadowgraph_engine::geometry::Chain;
use shadowgraph_engine::scene::Instance;

use super::beside_light::Cutter;
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
    /// What lies between their edges and the places where these are cut.
    pub(super) slivers: Vec<u32>,
    /// Of triangles that close the mesh.
    pub(super) unseen: [Vec<u32>; 2],
}

impl FrontCaps {
    /// The caps of a chain.
    pub(super) fn new(
        instance: &Instance,
        shape: &CastShape<'_>,
        chain: &Chain,
        cutter: &mut Option<Cutter<'_>>,
    ) -> Self {
        let own_count = instance.mesh.triangle_count() as u32;
        let welded = shape.topology().triangles();
        let mut caps = Self::default();
        let (mut own_slivers, mut unseen_slivers) = (Slivers::default(), Slivers::default());
        for (turned, list) in [&chain.caps_front, &chain.caps_back].into_iter().enumerate() {
            for &triangle in list {
                let corners = welded[triangle as usize];
                let slivers = if triangle < own_count {
                    caps.own[turned].extend(instance.mesh.triangle(triangle as usize).map(cap));
                    &mut own_slivers
                } else if matches!(shape, CastShape::Doubled(_)) {
                    // The reverse of a triangle is that triangle, counted the other way round.
                    let own = instance.mesh.triangle((triangle - own_count) as usize);
                    caps.own[1 - turned].extend(own.map(cap));
                    &mut own_slivers
                } else {
                    caps.unseen[turned].extend(corners.map(cap));
                    &mut unseen_slivers
                };
                for sliver in cutter.as_mut().map_or_else(Vec::new, |cutter| cutter.slivers(corners)) {
                    slivers.add(sliver, [1, -1][turned]);
                }
            }
        }
        caps.slivers.extend(own_slivers.left().map(cap));
        caps.unseen[0].extend(unseen_slivers.left().map(cap));
        caps
    }
}

/// What lies between edges and the places where they are cut, and how often it counts. Where two caps meet their slivers cancel,
/// and are not to be drawn: a sliver that the near plane cuts covers what it likes.
#[derive(Default)]
struct Slivers(BTreeMap<[u32; 3], i32>);

impl Slivers {
    /// Adds (end, cut, end), which counts `count` times as it is wound.
    fn add(&mut self, [p, middle, q]: [u32; 3], count: i32) {
        let (sliver, count) = if p < q { ([p, middle, q], count) } else { ([q, middle, p], -count) };
        *self.0.entry(sliver).or_default() += count;
    }

    /// The corners of those that are left, wound so that each counts once.
    fn left(self) -> impl Iterator<Item = u32> {
        self.0.into_iter().flat_map(|([p, middle, q], count)| {
            let sliver = if count > 0 { [p, middle, q] } else { [q, middle, p] };
            std::iter::repeat_n(sliver, count.unsigned_abs() as usize).flatten()
        })
    }
}
