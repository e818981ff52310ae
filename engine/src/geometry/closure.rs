//! Closing open meshes, for casters only: caps over the open loops, or a reverse for every face.
//!
//! Lindrud & Löfgren 2004 §3.1 weigh both. Neither moves or adds a vertex, and the mesh that is seen stays as it is:
//! the closed one is a [`Topology`] over the same vertices, with the mesh's own triangles first.
//!
//! *Where a mesh is open.* An edge is open as often as its signed uses do not cancel. In a mesh wound one way that is
//! their "open edge", one that belongs to one face only; at an edge with more faces it is what is left of them after
//! those that cancel, and an edge between two faces wound against each other is open twice. Whatever the mesh, as many
//! open edges lead to a vertex as away from it (the boundary of triangles has no boundary), so they can always be
//! walked as closed loops, and caps over the loops always close it as a chain.

use glam::{DVec2, DVec3, Vec3};
use thiserror::Error;

use super::{Mesh, Topology};

/// The most edges of a loop that is capped: cutting a polygon into triangles takes up to the square of it.
pub const MAX_CAPPED_EDGES: usize = 1 << 14;

/// Why a mesh was not capped.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("mesh '{mesh}' has an open loop of {edges} edges; at most {MAX_CAPPED_EDGES} are capped")]
pub struct LoopTooLong {
    /// The mesh's name.
    pub mesh: String,
    /// The edges of its longest loop.
    pub edges: usize,
}

/// A mesh closed by caps.
#[derive(Debug)]
pub struct Capped {
    /// The mesh's own triangles, then the caps.
    pub topology: Topology,
    /// How many loops were capped.
    pub loops: usize,
    /// How many of their edges belong to more than one face.
    pub shared_edges: usize,
}

/// The mesh with a cap over each of its open loops.
///
/// # Errors
/// [`LoopTooLong`] beyond [`MAX_CAPPED_EDGES`].
pub fn capped(mesh: &Mesh) -> Result<Capped, LoopTooLong> {
    let topology = mesh.topology();
    let loops = open_loops(topology);
    let edges = loops.iter().map(Vec::len).max().unwrap_or(0);
    if edges > MAX_CAPPED_EDGES {
        return Err(LoopTooLong { mesh: mesh.name().into(), edges });
    }
    let caps = loops.iter().flat_map(|around| cap(mesh.positions(), around)).flatten();
    let indices: Vec<u32> = mesh.data().indices.iter().copied().chain(caps).collect();
    let open_edges = (0..topology.edges().len()).filter(|edge| balance(topology, *edge) != 0);
    Ok(Capped {
        topology: Topology::new(mesh.positions(), &indices),
        loops: loops.len(),
        shared_edges: open_edges.filter(|edge| topology.uses(*edge).len() > 1).count(),
    })
}

/// The mesh with the reverse of every triangle: that of triangle t is number t + the mesh's own count.
pub fn doubled(mesh: &Mesh) -> Topology {
    let own = &mesh.data().indices;
    let reverses = own.chunks_exact(3).flat_map(|corners| [corners[0], corners[2], corners[1]]);
    Topology::new(mesh.positions(), &own.iter().copied().chain(reverses).collect::<Vec<_>>())
}

fn balance(topology: &Topology, edge: usize) -> i32 {
    topology.uses(edge).iter().map(|use_of| use_of.sigma).sum()
}

/// The closed loops of open edges, each as its vertices in the direction in which a cap has to run. No loop visits a
/// vertex twice: where loops touch, they are cut apart.
pub fn open_loops(topology: &Topology) -> Vec<Vec<u32>> {
    // A cap runs against what is left of the mesh's own direction.
    let mut open: Vec<[u32; 2]> = Vec::new();
    for (index, edge) in topology.edges().iter().enumerate() {
        let left = balance(topology, index);
        let against = if left > 0 { [edge.q, edge.p] } else { [edge.p, edge.q] };
        open.extend(std::iter::repeat_n(against, left.unsigned_abs() as usize));
    }
    open.sort_unstable();
    let first_from = |vertex: u32| open.partition_point(|[from, _]| *from < vertex);
    // For each run of equal `from`, by its first place, how many have been walked.
    let mut walked = vec![0; open.len()];
    let mut next_of = |vertex: u32| {
        let first = first_from(vertex);
        let &[from, to] = open.get(first + walked.get(first)?)?;
        (from == vertex).then(|| {
            walked[first] += 1;
            to
        })
    };
    let mut loops = Vec::new();
    let mut place_on_path = std::collections::HashMap::new();
    for &[start, _] in &open {
        let mut path = vec![start];
        place_on_path.insert(start, 0);
        while let Some(next) = path.last().and_then(|last| next_of(*last)) {
            if let Some(&place) = place_on_path.get(&next) {
                // The path has come back to itself: what lies between is a loop.
                let around = path[place..].to_vec();
                path.drain(place + 1..).for_each(|vertex| {
                    place_on_path.remove(&vertex);
                });
                loops.push(around);
            } else {
                place_on_path.insert(next, path.len());
                path.push(next);
            }
        }
        place_on_path.clear();
    }
    loops
}

/// Cuts the polygon `around` into triangles, ear by ear, as it looks along its mean normal. One that is not flat or
/// crosses itself is cut all the same: its cap is then one of many that close it.
fn cap(positions: &[Vec3], around: &[u32]) -> Vec<[u32; 3]> {
    let corners: Vec<DVec3> = around.iter().map(|vertex| positions[*vertex as usize].as_dvec3()).collect();
    let normal: DVec3 = (0..corners.len())
        .map(|i| (corners[i] - corners[0]).cross(corners[(i + 1) % corners.len()] - corners[0]))
        .sum();
    let (x, y) = normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    let flat: Vec<DVec2> =
        corners.iter().map(|p| DVec2::new((*p - corners[0]).dot(x), (*p - corners[0]).dot(y))).collect();
    let turn = |[a, b, c]: [usize; 3]| (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]);
    // A ring of the corners that are left.
    let count = corners.len();
    let mut next: Vec<usize> = (1..=count).map(|i| i % count).collect();
    let mut previous: Vec<usize> = (0..count).map(|i| (i + count - 1) % count).collect();
    let mut triangles = Vec::with_capacity(count.saturating_sub(2));
    let (mut at, mut tried) = (0, 0);
    for left in (3..=count).rev() {
        let ear = loop {
            let ear = [previous[at], at, next[at]];
            // After a round without an ear the polygon crosses itself: any corner will do.
            if tried >= left || is_ear(&flat, &previous, &next, ear, &turn) {
                break ear;
            }
            (at, tried) = (next[at], tried + 1);
        };
        triangles.push(ear.map(|corner| around[corner]));
        let [before, _, after] = ear;
        (next[before], previous[after]) = (after, before);
        // Going on two corners further, caps of round loops are no fans of slivers.
        (at, tried) = (next[after], 0);
    }
    triangles
}

/// Whether the corner in the middle can be cut off: it turns the polygon's way, and no corner that turns the other way
/// lies in the triangle.
fn is_ear(
    flat: &[DVec2],
    previous: &[usize],
    next: &[usize],
    ear: [usize; 3],
    turn: &impl Fn([usize; 3]) -> f64,
) -> bool {
    let [a, b, c] = ear;
    if turn(ear) <= 0.0 {
        return false;
    }
    let mut other = next[c];
    while other != a {
        let reflex = turn([previous[other], other, next[other]]) <= 0.0;
        let same_place = [a, b, c].iter().any(|corner| flat[*corner] == flat[other]);
        if reflex
            && !same_place
            && turn([a, b, other]) >= 0.0
            && turn([b, c, other]) >= 0.0
            && turn([c, a, other]) >= 0.0
        {
            return false;
        }
        other = next[other];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::super::MeshData;
    use super::*;

    fn mesh(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Mesh {
        let positions = positions.iter().map(|p| Vec3::from(*p)).collect();
        let data = MeshData { positions, indices: triangles.concat(), ..MeshData::default() };
        Mesh::new(data).expect("a test's mesh is valid")
    }

    fn area(topology: &Topology, positions: &[Vec3], from: usize) -> DVec3 {
        let triangles = topology.triangles()[from..].iter();
        let corners = triangles.map(|t| t.map(|v| positions[v as usize].as_dvec3()));
        corners.map(|[a, b, c]| (b - a).cross(c - a) * 0.5).sum()
    }

    #[test]
    fn a_cube_without_its_top_gets_it_back() {
        // z = 1 is missing; two triangles to a side.
        let positions: Vec<[f32; 3]> = (0..8).map(|i| [0, 1, 2].map(|k| (i >> k & 1) as f32)).collect();
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1]];
        let triangles: Vec<[u32; 3]> =
            quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let cube = mesh(&positions, &triangles);
        assert_eq!(cube.topology().closedness().unbalanced_edges, 4);
        let closed = capped(&cube).unwrap();
        assert_eq!((closed.loops, closed.shared_edges, closed.topology.triangles().len()), (1, 0, 12));
        let closedness = closed.topology.closedness();
        assert_eq!((closedness.unbalanced_edges, closedness.boundary_edges), (0, 0));
        assert!((closedness.signed_volume - 1.0).abs() < 1e-12, "the cap faces outwards: {closedness:?}");
        assert_eq!(area(&closed.topology, cube.positions(), 10), DVec3::Z);
        // A closed mesh has nothing to cap.
        let indices: Vec<[u32; 3]> = closed.topology.triangles().to_vec();
        assert_eq!(capped(&mesh(&positions, &indices)).unwrap().topology.triangles().len(), 12);
    }

    #[test]
    fn caps_of_concave_loops_stay_inside() {
        // A strip of walls around a star: its cap has the star's area, not that of a fan over its notches.
        let count = 20_u32;
        let rim = |z: f32| {
            (0..count).map(move |i| {
                let angle = std::f32::consts::TAU * i as f32 / count as f32;
                let r = if i % 2 == 0 { 1.0 } else { 0.3 };
                [r * angle.cos(), r * angle.sin(), z]
            })
        };
        let positions: Vec<[f32; 3]> = rim(0.0).chain(rim(1.0)).collect();
        let triangles: Vec<[u32; 3]> = (0..count)
            .flat_map(|i| {
                let j = (i + 1) % count;
                [[i, j, j + count], [i, j + count, i + count]]
            })
            .collect();
        let walls = mesh(&positions, &triangles);
        let closed = capped(&walls).unwrap();
        assert_eq!((closed.loops, closed.topology.closedness().unbalanced_edges), (2, 0));
        let added = &closed.topology.triangles()[triangles.len()..];
        assert_eq!(added.len(), 2 * (count as usize - 2));
        let star = f64::from(count) * 0.5 * 0.3 * (std::f64::consts::TAU / f64::from(count)).sin();
        let signed_and_not = |triangles: &[[u32; 3]]| {
            let areas = triangles.iter().map(|t| {
                let [a, b, c] = t.map(|v| walls.positions()[v as usize].as_dvec3());
                (b - a).cross(c - a).z * 0.5
            });
            areas.fold((0.0, 0.0), |(sum, all), area: f64| (sum + area, all + area.abs()))
        };
        let (sum, all) = signed_and_not(added);
        assert!(sum.abs() < 1e-6 && (all - 2.0 * star).abs() < 1e-6, "{sum} {all} {star}");
        assert!((closed.topology.closedness().signed_volume - star).abs() < 1e-6);
    }

    #[test]
    fn loops_that_touch_cross_or_share_edges_all_close() {
        // Two triangles that touch in a vertex are two loops.
        let bow = mesh(
            &[[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, -1.0, 0.0]],
            &[[0, 2, 1], [0, 3, 4]],
        );
        assert_eq!(open_loops(bow.topology()).len(), 2);
        // Three leaves of a book, two wound alike: what is left of the spine is one edge of its own loop.
        let book = mesh(
            &[[0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, -1.0]],
            &[[0, 1, 2], [0, 1, 3], [1, 0, 4]],
        );
        // Two faces wound against each other, and a strip with one half twist.
        let against =
            mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]], &[[0, 1, 2], [1, 2, 3]]);
        let ring: Vec<[f32; 3]> =
            (0..5).map(|i| [(i as f32).cos(), (i as f32).sin(), (i % 2) as f32]).collect();
        let twisted: Vec<[u32; 3]> = (0..5).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
        for (open, shared) in [(&bow, 0), (&book, 1), (&against, 1), (&mesh(&ring, &twisted), 5)] {
            let closed = capped(open).unwrap();
            assert_eq!(closed.topology.closedness().unbalanced_edges, 0, "{open:?}");
            assert_eq!(closed.shared_edges, shared, "{open:?}");
            for around in open_loops(open.topology()) {
                let mut once = around.clone();
                once.sort_unstable();
                once.dedup();
                assert!(around.len() >= 3 && once.len() == around.len(), "{around:?}");
            }
        }
    }

    #[test]
    fn long_loops_are_refused_by_name() {
        let count = MAX_CAPPED_EDGES as u32 + 1;
        let rim = (0..count).map(|i| {
            let angle = std::f32::consts::TAU * i as f32 / count as f32;
            [angle.cos(), angle.sin(), 0.0]
        });
        let positions: Vec<[f32; 3]> = rim.chain([[0.0; 3]]).collect();
        let fan: Vec<[u32; 3]> = (0..count).map(|i| [i, (i + 1) % count, count]).collect();
        let error = capped(&mesh(&positions, &fan)).unwrap_err();
        assert_eq!(error.edges, count as usize);
        assert!(error.to_string().contains("16385 edges"), "{error}");
        // The longest that is taken is quick.
        let fan: Vec<[u32; 3]> = (0..count - 1).map(|i| [i, (i + 1) % (count - 1), count]).collect();
        assert_eq!(capped(&mesh(&positions, &fan)).unwrap().topology.closedness().unbalanced_edges, 0);
    }

    #[test]
    fn a_doubled_mesh_is_closed_and_has_no_volume() {
        let leaf = mesh(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]);
        let doubled = doubled(&leaf);
        assert_eq!(doubled.triangles(), [[0, 1, 2], [0, 2, 1]]);
        assert_eq!(doubled.closedness().unbalanced_edges, 0);
        assert!(doubled.orientation(&glam::DAffine3::IDENTITY).is_none());
    }
}
