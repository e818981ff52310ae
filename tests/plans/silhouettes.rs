//! Two ways to a silhouette: the toggle list of "Real-time shadow generation" (IJMA 3/3, 2011, §3.2), and signed counts.
//! No GPU.
//!
//! The list goes through the faces that the light sees and adds each edge that is not in it and deletes each that is:
//! what is left was met an odd number of times. On closed meshes with two faces to an edge it is the signed counts; at an
//! edge with more it loses what meets in pairs and weighs two.

use std::collections::BTreeSet;

use glam::{DVec3, DVec4, Vec3};
use proptest::prelude::*;
use shadowgraph::engine::geometry::{Chain, Mesh, MeshData, facing_signs, shapes};
use shadowgraph::engine::gltf;

/// The edges of the toggle list.
fn toggled(mesh: &Mesh, signs: &[i8]) -> BTreeSet<[u32; 2]> {
    let mut list = BTreeSet::new();
    for (corners, sign) in mesh.topology().triangles().iter().zip(signs) {
        let [a, b, c] = *corners;
        let collapsed = a == b || b == c || c == a;
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let edge = [p.min(q), p.max(q)];
            if *sign > 0 && !collapsed && !list.remove(&edge) {
                list.insert(edge);
            }
        }
    }
    list
}

/// The edges with a weight, and the largest weight, when the faces that the light sees cast; and when all cast.
fn counted(mesh: &Mesh, signs: &[i8]) -> [(BTreeSet<[u32; 2]>, u32); 2] {
    let lit: Vec<i8> = signs.iter().map(|sign| (*sign).max(0)).collect();
    [&lit[..], signs].map(|signs| {
        let chain = Chain::extract(mesh.topology(), signs);
        (chain.sides.iter().map(|&[p, q]| [p.min(q), p.max(q)]).collect(), chain.max_edge_weight)
    })
}

fn signs(mesh: &Mesh, light: DVec4) -> Vec<i8> {
    let positions: Vec<DVec3> = mesh.positions().iter().map(|p| p.as_dvec3()).collect();
    facing_signs(&positions, mesh.topology().triangles(), light)
}

/// Whether the two ways agree, and how many edges there are.
fn agree(mesh: &Mesh, light: DVec4) -> Result<usize, String> {
    let signs = signs(mesh, light);
    let toggled = toggled(mesh, &signs);
    let [(lit, lit_weight), (all, all_weight)] = counted(mesh, &signs);
    if signs.contains(&0) {
        // Beside an edge-on face the open mode weighs 1, where the list of lit faces may have nothing.
        return (toggled == lit).then_some(toggled.len()).ok_or("edge-on faces".into());
    }
    let same = toggled == lit && toggled == all && lit_weight <= 1 && (all_weight == 2 || all.is_empty());
    let what =
        format!("{} toggled, {} lit, {} in all, weight {all_weight}", toggled.len(), lit.len(), all.len());
    same.then_some(toggled.len()).ok_or(what)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Balls and rings with every vertex moved anywhere: closed, and as crossed and folded as can be.
    #[test]
    fn toggled_edges_are_the_signed_counts_on_closed_meshes(
        moves in prop::collection::vec(prop::array::uniform3(-1.5..1.5_f32), 64),
        ring in any::<bool>(),
        light in (prop::array::uniform3(-4.0..4.0_f64), prop::sample::select(vec![0.0, 1.0])),
    ) {
        let mut data = if ring { shapes::torus(1.0, 0.4, 7, 5) } else { shapes::icosphere(1.0, 2) };
        // Welding goes by position, so that all copies of a vertex must move alike.
        let place = |p: Vec3| moves[(p.x.to_bits() ^ p.y.to_bits().rotate_left(9) ^ p.z.to_bits().rotate_left(17)) as usize % 64];
        data.positions = data.positions.iter().map(|p| *p + Vec3::from(place(*p + 0.0)) * 0.5).collect();
        data.normals.clear();
        let mesh = Mesh::new(data).unwrap();
        prop_assume!(mesh.topology().closedness().unbalanced_edges == 0);
        prop_assume!(mesh.topology().closedness().non_manifold_edges == 0);
        let [x, y, z] = light.0;
        let edges = agree(&mesh, DVec4::new(x, y, z, light.1));
        prop_assert!(edges.is_ok(), "{:?}", edges);
    }
}

#[test]
fn closed_models_agree() {
    let Some(folder) = shadowgraph_testing::model("") else { return };
    for name in ["spot", "knot13k", "knot63k", "boxes1k"] {
        let snapshot = gltf::load(folder.join(format!("{name}.glb"))).unwrap().scene.snapshot().unwrap();
        let meshes: Vec<_> = snapshot.instances.iter().map(|instance| &instance.mesh).collect();
        assert!(!meshes.is_empty());
        for mesh in meshes {
            let closedness = mesh.topology().closedness();
            assert_eq!((closedness.unbalanced_edges, closedness.non_manifold_edges), (0, 0), "{name}");
            for light in [DVec4::new(3.0, 6.5, 2.0, 1.0), DVec4::new(2.0, 3.0, 1.5, 0.0)] {
                let edges = agree(mesh, light).unwrap_or_else(|what| panic!("{name}: {what}"));
                assert!(edges > 100, "{name}: {edges}");
            }
        }
    }
}

/// Two wedges with one edge in common, one within the other: seen from the side, the edge is a silhouette of both. The
/// list deletes at the second what it added at the first, and the shadow tears open; signed counts weigh two.
#[test]
fn an_edge_of_four_faces_is_lost_by_the_list() {
    let wedge = |half: f32, depth: f32| MeshData {
        positions: vec![Vec3::ZERO, Vec3::Z, Vec3::new(half, -depth, 0.5), Vec3::new(-half, -depth, 0.5)],
        indices: [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].concat(),
        ..MeshData::default()
    };
    let mesh = Mesh::new(MeshData::merged("wedges", [wedge(1.0, 1.0), wedge(0.4, 0.9)])).unwrap();
    assert_eq!(mesh.topology().closedness().unbalanced_edges, 0);
    assert_eq!(mesh.topology().closedness().non_manifold_edges, 1);
    let common = [0, 1];
    for x in [-6.0, 6.0] {
        let signs = signs(&mesh, DVec4::new(x, 0.5, 0.5, 1.0));
        let [(lit, weight), _] = counted(&mesh, &signs);
        assert_eq!((lit.contains(&common), weight), (true, 2));
        let toggled = toggled(&mesh, &signs);
        assert!(!toggled.contains(&common));
        assert!(lit.iter().all(|edge| *edge == common || toggled.contains(edge)), "nothing else is lost");
    }
}
