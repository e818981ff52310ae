//! The chains of all casters of a light together, as the shaders read them: edges, triangles, and the lists over them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::DVec3;
use shadowgraph_engine::scene::{Image, ImageKey};

use super::chain::{BesideTriangle, CasterChain, SoftEdge, SoftTriangle};
use super::clusters::clusters;
use super::lists::{ListedEdge, SoftGrid};
use super::masks::{MaskedTriangle, Masks};
use super::near_light_triangles::near_lists;

/// `struct SoftCluster` of soft_near.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub(super) struct SoftCluster {
    pub center: [f32; 3],
    pub radius_m: f32,
    pub first: u32,
    pub end: u32,
    pub caster: u32,
    pub pad_0: u32,
}

/// Everything about a light's casters that does not depend on the eye.
pub(super) struct Chains {
    pub(super) edges: Arc<Vec<u8>>,
    pub(super) triangles: Arc<Vec<u8>>,
    /// Triangles as the light sees them, where it is beside some caster; else empty.
    pub(super) beside: Arc<Vec<u8>>,
    pub(super) lists: Arc<Vec<u8>>,
    pub(super) clusters: Arc<Vec<u8>>,
    pub(super) near_clusters: usize,
    /// Where lists of near triangles begin; 0 where there are none.
    pub(super) near_lists: usize,
    pub(super) cluster_count: usize,
    pub(super) edge_count: usize,
    pub(super) triangle_count: usize,
    pub(super) longest_lists: [usize; 2],
    /// Of triangles with holes, which come last; `None` where there are none.
    pub(super) masks: Option<Masks>,
    pub(super) grid: SoftGrid,
    pub(super) centers: Vec<DVec3>,
}

/// Triangles of all casters, those that lie together next to one another.
#[derive(Default)]
struct Clustered {
    clusters: Vec<SoftCluster>,
    records: Vec<SoftTriangle>,
    beside: Vec<BesideTriangle>,
    /// The corners of each triangle in the world, and whether it hides the light's centre from some receiver.
    triangles: Vec<([DVec3; 3], bool)>,
}

impl Clustered {
    /// Adds the near triangles of a caster, or its others.
    fn add(&mut self, caster: u32, chain: &CasterChain, near: bool) {
        let chosen: Vec<_> = chain.triangles.iter().filter(|triangle| triangle.near == near).collect();
        let corners: Vec<[DVec3; 3]> = chosen.iter().map(|triangle| triangle.corners).collect();
        let (order, found) = clusters(&corners);
        let first = self.records.len();
        self.clusters.extend(found.into_iter().map(|cluster| {
            let center = cluster.center - chain.center;
            SoftCluster {
                center: center.as_vec3().to_array(),
                // As much as rounding may take.
                radius_m: ((cluster.radius_m + center.length() * 1e-6) * (1.0 + 1e-6)) as f32,
                first: (first + cluster.triangles.start) as u32,
                end: (first + cluster.triangles.end) as u32,
                caster,
                pad_0: 0,
            }
        }));
        let ordered = || order.iter().map(|i| chosen[*i]);
        self.records.extend(ordered().map(|triangle| SoftTriangle { caster, ..triangle.record }));
        self.beside.extend(ordered().map(|triangle| triangle.beside));
        self.triangles.extend(ordered().map(|triangle| (triangle.corners, triangle.hides_center)));
    }

    /// Appends other triangles.
    fn append(&mut self, others: Self) {
        let first = self.records.len() as u32;
        self.clusters.extend(others.clusters.into_iter().map(|cluster| SoftCluster {
            first: first + cluster.first,
            end: first + cluster.end,
            ..cluster
        }));
        self.records.extend(others.records);
        self.beside.extend(others.beside);
        self.triangles.extend(others.triangles);
    }
}

impl Chains {
    /// Of all `casters`, listed over `grid`.
    pub(super) fn new<'a>(
        mut grid: SoftGrid,
        casters: impl Iterator<Item = &'a CasterChain>,
        images: &dyn Fn(ImageKey) -> Option<Arc<Image>>,
    ) -> Self {
        let mut edges: Vec<SoftEdge> = Vec::new();
        let mut listed_edges: Vec<ListedEdge> = Vec::new();
        let (mut near, mut far) = (Clustered::default(), Clustered::default());
        let mut masked: Vec<MaskedTriangle> = Vec::new();
        let mut is_beside = false;
        let mut centers = Vec::new();
        for (caster, chain) in (0..).zip(casters) {
            let center = chain.center;
            is_beside |= chain.beside;
            centers.push(center);
            edges.extend(chain.edges.iter().map(|edge| SoftEdge { caster, ..edge.record }));
            let listed = chain.edges.iter().map(|edge| (edge.ends, edge.record));
            listed_edges.extend(listed.map(|(ends, record)| ListedEdge { ends, record, center }));
            near.add(caster, chain, true);
            far.add(caster, chain, false);
            masked.extend(chain.masked.iter().cloned().map(|mut masked| {
                masked.triangle.record.caster = caster;
                masked
            }));
        }
        grid.place_slices(&listed_edges, &masked);
        let (ball, near_clusters) = (grid.light, near.clusters.len());
        // Near triangles come first, and are in lists of their own.
        let far_numbers = near.records.len() as u32..;
        let hiding = far_numbers.zip(&far.triangles).filter(|(_, (_, hides_center))| *hides_center);
        let hiding: Vec<(u32, [DVec3; 3])> =
            hiding.map(|(number, (corners, _))| (number, *corners)).collect();
        let (grid, mut lists, mut longest_lists) = grid.lists(&listed_edges, &hiding);
        let near_corners: Vec<[DVec3; 3]> = near.triangles.iter().map(|(corners, _)| *corners).collect();
        let mut first_near_list = 0;
        if let Some(of_cells) = near_lists(&ball, &near_corners) {
            first_near_list = lists.len();
            append_lists(&mut lists, &of_cells);
            // Each round of samples walks them.
            longest_lists[1] += 4 * of_cells.iter().map(Vec::len).max().unwrap_or_default();
        }
        let edge_count = edges.len();
        // No buffer is empty.
        if edges.is_empty() {
            edges.push(SoftEdge::default());
        }
        let mut all = near;
        all.append(far);
        let masks = (!masked.is_empty()).then(|| {
            let (mut masks, of_cells) = Masks::new(&grid, &masked, all.records.len(), images);
            masks.lists = lists.len();
            append_lists(&mut lists, &of_cells);
            all.records.extend(masked.iter().map(|masked| masked.triangle.record));
            all.beside.extend(masked.iter().map(|masked| masked.triangle.beside));
            masks
        });
        let bytes = |bytes: &[u8]| Arc::new(bytes.to_vec());
        Self {
            edges: bytes(cast_slice(&edges)),
            triangles: bytes(cast_slice(&all.records)),
            beside: bytes(if is_beside { cast_slice(&all.beside) } else { &[] }),
            lists: bytes(cast_slice(&lists)),
            clusters: bytes(cast_slice(&all.clusters)),
            near_clusters,
            near_lists: first_near_list,
            cluster_count: all.clusters.len(),
            edge_count,
            triangle_count: all.records.len(),
            longest_lists,
            masks,
            grid,
            centers,
        }
    }
}

/// Appends lists as the shader reads them: where each begins, where the last one ends, then all that is in them.
fn append_lists(lists: &mut Vec<u32>, of_cells: &[Vec<u32>]) {
    let mut place = (lists.len() + of_cells.len() + 1) as u32;
    lists.push(place);
    for list in of_cells {
        place += list.len() as u32;
        lists.push(place);
    }
    lists.extend(of_cells.iter().flatten());
}
