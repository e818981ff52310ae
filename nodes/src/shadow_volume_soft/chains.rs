//! The chains of all casters of a light together, as the shaders read them: edges, triangles, and the lists over them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::DVec3;

use super::chain::{BesideTriangle, CasterChain, SoftEdge, SoftTriangle};
use super::clusters::clusters;
use super::lists::{ListedEdge, SoftGrid};
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
    pub(super) grid: SoftGrid,
    pub(super) centers: Vec<DVec3>,
}

impl Chains {
    /// Of all `casters`, listed over `grid`.
    pub(super) fn new<'a>(grid: SoftGrid, casters: impl Iterator<Item = &'a CasterChain>) -> Self {
        let mut edges: Vec<SoftEdge> = Vec::new();
        let mut listed_edges: Vec<ListedEdge> = Vec::new();
        // Near triangles come first, cluster by cluster; then those of the chain.
        let ball = grid.light;
        let mut near_corners: Vec<[DVec3; 3]> = Vec::new();
        let mut near: (Vec<SoftCluster>, Vec<SoftTriangle>, Vec<Option<[DVec3; 3]>>) = Default::default();
        let mut far: (Vec<SoftCluster>, Vec<SoftTriangle>, Vec<Option<[DVec3; 3]>>) = Default::default();
        let mut beside: [Vec<BesideTriangle>; 2] = Default::default();
        let mut is_beside = false;
        let mut centers = Vec::new();
        for (number, chain) in casters.enumerate() {
            let caster = number as u32;
            is_beside |= chain.beside;
            centers.push(chain.center);
            edges.extend(chain.edges.iter().map(|edge| SoftEdge { caster, ..edge.record }));
            let center = chain.center;
            listed_edges.extend(chain.edges.iter().map(|edge| ListedEdge {
                ends: edge.ends,
                record: edge.record,
                center,
            }));
            for (is_near, (clusters_of, records, listed)) in [(true, &mut near), (false, &mut far)] {
                let chosen: Vec<_> =
                    chain.triangles.iter().filter(|triangle| triangle.near == is_near).collect();
                let corners: Vec<[DVec3; 3]> = chosen.iter().map(|triangle| triangle.corners).collect();
                let (order, found) = clusters(&corners);
                let first = records.len();
                for cluster in found {
                    let center = cluster.center - chain.center;
                    clusters_of.push(SoftCluster {
                        center: center.as_vec3().to_array(),
                        // As much as rounding may take.
                        radius_m: ((cluster.radius_m + center.length() * 1e-6) * (1.0 + 1e-6)) as f32,
                        first: (first + cluster.triangles.start) as u32,
                        end: (first + cluster.triangles.end) as u32,
                        caster,
                        pad_0: 0,
                    });
                }
                if is_near {
                    near_corners.extend(order.iter().map(|i| corners[*i]));
                }
                records.extend(order.iter().map(|i| SoftTriangle { caster, ..chosen[*i].record }));
                beside[usize::from(!is_near)].extend(order.iter().map(|i| chosen[*i].beside));
                listed.extend(order.iter().map(|i| chosen[*i].hides_center.then_some(corners[*i])));
            }
        }
        let (near_count, near_clusters) = (near.1.len(), near.0.len());
        let listed: Vec<(u32, [DVec3; 3])> = (near_count as u32..)
            .zip(&far.2)
            .filter_map(|(number, corners)| Some((number, (*corners)?)))
            .collect();
        let (grid, mut lists, mut longest_lists) = grid.lists(&listed_edges, &listed);
        let mut first_near_list = 0;
        if let Some(of_cells) = near_lists(&ball, &near_corners) {
            first_near_list = lists.len();
            let mut place = (lists.len() + of_cells.len() + 1) as u32;
            lists.push(place);
            for list in &of_cells {
                place += list.len() as u32;
                lists.push(place);
            }
            lists.extend(of_cells.iter().flatten());
            // Each round of samples walks them.
            longest_lists[1] += 4 * of_cells.iter().map(Vec::len).max().unwrap_or_default();
        }
        let shifted = far.0.iter().map(|cluster| SoftCluster {
            first: cluster.first + near_count as u32,
            end: cluster.end + near_count as u32,
            ..*cluster
        });
        let all_clusters: Vec<SoftCluster> = near.0.iter().copied().chain(shifted).collect();
        let (edge_count, triangle_count) = (edges.len(), near_count + far.1.len());
        // No buffer is empty.
        if edges.is_empty() {
            edges.push(SoftEdge::default());
        }
        let triangles: Vec<SoftTriangle> = near.1.into_iter().chain(far.1).collect();
        let beside = beside.concat();
        let bytes = |bytes: &[u8]| Arc::new(bytes.to_vec());
        Self {
            edges: bytes(cast_slice(&edges)),
            triangles: bytes(cast_slice(&triangles)),
            beside: bytes(if is_beside { cast_slice(&beside) } else { &[] }),
            lists: bytes(cast_slice(&lists)),
            clusters: bytes(cast_slice(&all_clusters)),
            near_clusters,
            near_lists: first_near_list,
            cluster_count: all_clusters.len(),
            edge_count,
            triangle_count,
            longest_lists,
            grid,
            centers,
        }
    }
}
