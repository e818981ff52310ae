//! Groups of triangles within spheres: what receivers at the light ask instead of lists.

use glam::DVec3;
use shadowgraph_engine::math::Aabb;

/// Triangles that lie together, and the sphere around them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Cluster {
    /// Its triangles, among those in the order of the clusters.
    pub triangles: std::ops::Range<usize>,
    /// The middle of their bounds, in the world.
    pub center: DVec3,
    /// How far from it they reach, in metres.
    pub radius_m: f64,
}

/// The most triangles of a cluster.
const CLUSTER: usize = 16;

/// The order of the triangles, and the clusters of that order: halved at the middle of the longest side until they are small.
pub(super) fn clusters(triangles: &[[DVec3; 3]]) -> (Vec<usize>, Vec<Cluster>) {
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    let mut clusters = Vec::new();
    let mut open = Vec::new();
    open.push(0..triangles.len());
    while let Some(range) = open.pop() {
        if range.is_empty() {
            continue;
        }
        let bounds = Aabb::from_points(order[range.clone()].iter().flat_map(|i| triangles[*i]));
        if range.len() <= CLUSTER {
            clusters.push(Cluster { triangles: range, center: bounds.center(), radius_m: bounds.radius() });
            continue;
        }
        let size = bounds.max - bounds.min;
        let axis =
            size.to_array().iter().enumerate().fold(0, |best, (i, x)| if *x > size[best] { i } else { best });
        let middle = range.len() / 2;
        let key = |i: &usize| triangles[*i].iter().map(|corner| corner[axis]).sum::<f64>();
        order[range.clone()].select_nth_unstable_by(middle, |a, b| key(a).total_cmp(&key(b)));
        open.push(range.start + middle..range.end);
        open.push(range.start..range.start + middle);
    }
    (order, clusters)
}
