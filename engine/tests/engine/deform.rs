//! Bent meshes: where vertices go is worked out by hand, and what stays the same is not computed again.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use shadowgraph_engine::geometry::{Influences, Mesh, MeshData, MorphTarget};
use shadowgraph_engine::scene::{
    Animation, Channel, Content, Instance, Interpolation, Material, MeshNode, NodeKey, Property, Scene,
    SceneError, Skin, Track, Transform, placed,
};

/// Rings of four vertices along x from 0 to 2, closed at both ends; `joints` says what each vertex follows.
fn bar(joints: impl Fn(Vec3) -> Influences) -> MeshData {
    let mut data = MeshData { name: "bar".into(), ..MeshData::default() };
    for ring in 0..=8 {
        let x = ring as f32 * 0.25;
        data.positions
            .extend([[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]].map(|[y, z]| Vec3::new(x, y, z)));
    }
    for ring in 0..8_u32 {
        for side in 0..4_u32 {
            let [a, b] = [ring * 4 + side, ring * 4 + (side + 1) % 4];
            data.indices.extend([a, b, b + 4, a, b + 4, a + 4]);
        }
    }
    data.indices.extend([0, 3, 2, 0, 2, 1, 32, 33, 34, 32, 34, 35]);
    data.influences = data.positions.iter().map(|p| joints(*p)).collect();
    data
}

/// Follows the lower joint below x = 1, the upper one above, both equally in between.
fn halves(p: Vec3) -> Influences {
    match p.x {
        x if x < 1.0 => Influences::new([(0, 1.0), (1, 0.0)]),
        x if x > 1.0 => Influences::new([(1, 1.0)]),
        _ => Influences::new([(0, 0.5), (1, 0.5)]),
    }
}

/// A bar on two joints, the upper one at x = 1, and the node that holds it.
fn two_joints(data: MeshData) -> (Scene, [NodeKey; 3]) {
    let mut scene = Scene::new();
    let lower = scene.add_group("lower");
    let upper = scene.add(Some(lower), "upper", DAffine3::from_translation(DVec3::X), Content::Group);
    let binds = vec![DAffine3::IDENTITY, DAffine3::from_translation(-DVec3::X)];
    let skin = scene.add_skin(Skin::new("bones", vec![lower, upper], binds)).unwrap();
    // The node stands elsewhere, which must not matter.
    let node = scene.add_mesh(
        Mesh::new(data).unwrap(),
        Material::default(),
        DAffine3::from_scale(DVec3::splat(7.0)),
    );
    mesh_node(&mut scene, node).skin = Some(skin);
    (scene, [lower, upper, node])
}

fn mesh_node(scene: &mut Scene, node: NodeKey) -> &mut MeshNode {
    match &mut scene.node_mut(node).unwrap().content {
        Content::Mesh(content) => content,
        other => panic!("{other:?} is no mesh"),
    }
}

fn only(scene: &Scene) -> Instance {
    scene.snapshot().unwrap().instances.remove(0)
}

#[track_caller]
fn assert_near(got: DVec3, wanted: DVec3, rounding: f64) {
    assert!((got - wanted).length() <= rounding, "{got}, not {wanted}");
}

#[test]
fn a_bar_on_two_joints_bends_as_worked_out() {
    let (mut scene, [lower, upper, _]) = two_joints(bar(halves));
    let rest = bar(halves);
    for angle in [0.0, 0.3, FRAC_PI_2, 3.0] {
        scene.node_mut(upper).unwrap().parent_from_local =
            placed(DVec3::X, DQuat::from_rotation_z(angle), DVec3::ONE);
        let bent = only(&scene);
        for (vertex, p) in rest.positions.iter().enumerate() {
            let p = p.as_dvec3();
            // Turned about (1, 0, 0): worked out without a matrix.
            let (sin, cos) = angle.sin_cos();
            let turned = DVec3::new(1.0 + (p.x - 1.0) * cos - p.y * sin, (p.x - 1.0) * sin + p.y * cos, p.z);
            let wanted = match p.x {
                x if x < 1.0 => p,
                x if x > 1.0 => turned,
                _ => (p + turned) * 0.5,
            };
            assert_near(bent.world_position(vertex as u32), wanted, 3e-7);
        }
        // The normals of the far half turn with it.
        let normal = bent.mesh.data().normals[34].as_dvec3();
        let still = Mesh::new(rest.clone()).unwrap().data().normals[34].as_dvec3();
        assert_near(normal, DQuat::from_rotation_z(angle) * still, 1e-6);
    }
    // The whole skeleton far away: the f32 vertices keep their digits.
    scene.node_mut(lower).unwrap().parent_from_local = DAffine3::from_translation(DVec3::new(1e6, 0.0, -3e6));
    let far = only(&scene);
    assert_near(far.world_position(0), DVec3::new(1e6, -0.1, -3e6 - 0.1), 3e-7);
}

#[test]
fn mirrored_and_unequal_joint_scales() {
    let (mut scene, [lower, upper, _]) = two_joints(bar(halves));
    let scale = DVec3::new(-2.0, 0.5, 3.0);
    let turn = DQuat::from_rotation_y(0.7);
    scene.node_mut(lower).unwrap().parent_from_local = placed(DVec3::Y, turn, scale);
    scene.node_mut(upper).unwrap().parent_from_local =
        placed(DVec3::X, DQuat::IDENTITY, DVec3::new(1.0, 4.0, 0.0));
    let bent = only(&scene);
    for (vertex, p) in bar(halves).positions.iter().enumerate() {
        let p = p.as_dvec3();
        let upper = DVec3::new(p.x, p.y * 4.0, 0.0);
        let local = if p.x < 1.0 {
            p
        } else if p.x > 1.0 {
            upper
        } else {
            (p + upper) * 0.5
        };
        assert_near(bent.world_position(vertex as u32), turn * (local * scale) + DVec3::Y, 2e-6);
    }
    assert!(bent.mesh.data().normals.iter().all(|normal| (normal.length() - 1.0).abs() < 1e-5));
    // Turned inside out: closed all the same, with a negative volume, and every component turned outwards.
    scene.node_mut(upper).unwrap().parent_from_local = DAffine3::from_translation(DVec3::X);
    let bent = only(&scene);
    let topology = bent.mesh.topology();
    assert_eq!(topology.closedness().unbalanced_edges, 0);
    assert!(topology.closedness().signed_volume < 0.0);
    assert_eq!(topology.orientation(&bent.world_from_local).unwrap().component_signs(), [-1]);
}

#[test]
fn morph_targets_come_before_joints() {
    let mut data = bar(halves);
    let count = data.positions.len();
    let lift: Vec<Vec3> = data.positions.iter().map(|p| Vec3::Y * p.x * p.x).collect();
    data.morphs = vec![
        MorphTarget { name: "lift".into(), positions: lift, ..MorphTarget::default() },
        MorphTarget {
            name: "grow".into(),
            positions: vec![Vec3::Z; count],
            weight: 0.25,
            ..MorphTarget::default()
        },
    ];
    let (mut scene, [_, upper, node]) = two_joints(data);
    scene.node_mut(upper).unwrap().parent_from_local =
        placed(DVec3::X, DQuat::from_rotation_z(FRAC_PI_2), DVec3::ONE);
    // The mesh's own weights first, then the node's; above 1 and below 0 as well.
    for (weights, [lift, grow]) in
        [(vec![], [0.0, 0.25]), (vec![0.5, -2.0], [0.5, -2.0]), (vec![0.0, 0.0], [0.0; 2])]
    {
        mesh_node(&mut scene, node).weights = weights;
        let bent = only(&scene);
        let p = DVec3::new(2.0, 0.1 + lift * 4.0, 0.1 + grow);
        assert_near(bent.world_position(34), DVec3::new(1.0 - p.y, 1.0, p.z), 1e-6);
    }
    for (weights, says) in
        [(vec![1.0], "1 weights are set, but it has 2"), (vec![0.0, f64::NAN], "target 1 is not finite")]
    {
        mesh_node(&mut scene, node).weights = weights;
        let error = scene.snapshot().unwrap_err().to_string();
        assert!(error.contains("'bar'") && error.contains(says), "{error}");
    }
}

#[test]
fn the_same_pose_is_the_same_mesh() {
    let (mut scene, [_, upper, node]) = two_joints(bar(halves));
    let turn = |scene: &mut Scene, angle: f64| {
        scene.node_mut(upper).unwrap().parent_from_local =
            placed(DVec3::X, DQuat::from_rotation_z(angle), DVec3::ONE);
        only(scene)
    };
    let first = turn(&mut scene, 0.0);
    let bent = turn(&mut scene, 0.5);
    assert!(first.mesh.id() != bent.mesh.id() && first.pose_key != bent.pose_key);
    let again = turn(&mut scene, 0.5);
    assert!(Arc::ptr_eq(&bent.mesh, &again.mesh) && bent.pose_key == again.pose_key);
    // A moved node that moves no vertex, and a clone of the scene.
    scene.node_mut(node).unwrap().parent_from_local = DAffine3::from_translation(DVec3::ONE);
    assert!(Arc::ptr_eq(&bent.mesh, &only(&scene.clone()).mesh));
    // A morphed mesh that moves as a whole keeps its shape.
    let mut data = bar(halves);
    data.morphs = vec![MorphTarget {
        positions: vec![Vec3::Y; data.positions.len()],
        weight: 1.0,
        ..Default::default()
    }];
    let mut scene = Scene::new();
    let node = scene.add_mesh(Mesh::new(data).unwrap(), Material::default(), DAffine3::IDENTITY);
    let before = only(&scene);
    scene.node_mut(node).unwrap().parent_from_local = DAffine3::from_translation(DVec3::X);
    let after = only(&scene);
    assert!(Arc::ptr_eq(&before.mesh, &after.mesh) && before.pose_key != after.pose_key);
    assert_near(after.world_position(0), DVec3::new(1.0, 0.9, -0.1), 1e-6);
}

/// Whether two meshes have one table of edges.
fn shares_tables(a: &Mesh, b: &Mesh) -> bool {
    std::ptr::eq(a.topology().edges(), b.topology().edges())
}

#[test]
fn topology_is_kept_while_the_same_vertices_weld() {
    // Every triangle on vertices of its own, as after loading without normals.
    let shared = bar(halves);
    let (mut scene, [_, upper, _]) = two_joints(shared.clone().flat_shaded());
    let rest = scene.meshes().next().unwrap().1.clone();
    assert!(rest.is_faceted());
    scene.node_mut(upper).unwrap().parent_from_local =
        placed(DVec3::X, DQuat::from_rotation_z(0.8), DVec3::ONE);
    let bent = only(&scene);
    assert!(shares_tables(&bent.mesh, &rest));
    assert_eq!(bent.mesh.topology().closedness().unbalanced_edges, 0);
    let corners =
        |triangle| bent.mesh.triangle(triangle).map(|v| bent.mesh.positions()[v as usize].as_dvec3());
    for triangle in 0..bent.mesh.triangle_count() {
        let [a, b, c] = corners(triangle);
        let normal = bent.mesh.data().normals[bent.mesh.triangle(triangle)[0] as usize].as_dvec3();
        assert_near(normal, (b - a).cross(c - a).normalize(), 1e-6);
    }
    // Measures are those of the pose, not of the rest.
    let fresh = Mesh::new(bent.mesh.data().clone()).unwrap();
    assert_eq!(fresh.topology().closedness(), bent.mesh.topology().closedness());
    assert_eq!(fresh.topology().triangles(), bent.mesh.topology().triangles());

    // One triangle at the end follows the other joint: its seam parts, and the bar is open there.
    let mut parting = shared.flat_shaded();
    let last = parting.influences.len() - 3;
    parting.influences[last..].fill(Influences::new([(0, 1.0)]));
    let (mut scene, [_, upper, _]) = two_joints(parting);
    let rest = scene.meshes().next().unwrap().1.clone();
    assert_eq!(rest.topology().closedness().boundary_edges, 0);
    assert!(shares_tables(&only(&scene).mesh, &rest));
    scene.node_mut(upper).unwrap().parent_from_local =
        placed(DVec3::X, DQuat::from_rotation_z(0.8), DVec3::ONE);
    let bent = only(&scene);
    assert!(!shares_tables(&bent.mesh, &rest));
    assert_eq!(bent.mesh.topology().closedness().boundary_edges, 6);
}

#[test]
fn odd_weights_have_a_defined_place() {
    // Of vertex 34: two shares of another sum, no weight at all, a joint twice.
    let at_end = |influences: Influences| {
        let mut data = bar(halves);
        data.influences[34] = influences;
        let (mut scene, [_, upper, _]) = two_joints(data);
        scene.node_mut(upper).unwrap().parent_from_local =
            DAffine3::from_translation(DVec3::new(1.0, 2.0, 0.0));
        only(&scene).world_position(34)
    };
    let p = DVec3::new(2.0, 0.1, 0.1);
    assert_near(at_end(Influences::new([(0, 1.0), (1, 3.0)])), p + DVec3::Y * 1.5, 1e-6);
    assert_near(at_end(Influences::new([(1, 0.0), (0, 0.0)])), p + DVec3::Y * 2.0, 1e-6);
    assert_near(at_end(Influences::new([(1, 0.25), (0, 0.5), (1, 0.25)])), p + DVec3::Y, 1e-6);
}

#[test]
fn bad_skins_and_poses_are_named() {
    let (mut scene, [lower, upper, node]) = two_joints(bar(halves));
    let bind = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(f64::NAN, 1.0, 1.0)));
    for skin in [
        Skin::new("none", vec![], vec![]),
        Skin::new("few", vec![lower, upper], vec![DAffine3::IDENTITY]),
        Skin::new("nan", vec![lower], vec![bind]),
    ] {
        let name = skin.name.clone();
        let error = scene.add_skin(skin).unwrap_err();
        assert!(
            matches!(&error, SceneError::BadContent { what: "skin", .. })
                && error.to_string().contains(&name)
        );
    }
    // A singular bind is a map like any other.
    let flat = Skin::new("flat", vec![lower, upper], vec![DAffine3::ZERO, DAffine3::ZERO]);
    let flat = scene.add_skin(flat).unwrap();
    mesh_node(&mut scene, node).skin = Some(flat);
    assert_eq!(only(&scene).world_bounds.min, DVec3::ZERO);

    let one = scene.add_skin(Skin::new("one", vec![lower], vec![])).unwrap();
    mesh_node(&mut scene, node).skin = Some(one);
    let error = scene.snapshot().unwrap_err().to_string();
    assert!(error.contains("names joint 1") && error.contains("the skin has 1"), "{error}");

    scene.node_mut(upper).unwrap().parent_from_local = DAffine3::from_translation(DVec3::splat(1e30));
    mesh_node(&mut scene, node).skin = Some(flat);
    assert!(matches!(scene.snapshot(), Err(SceneError::BadTransform { node }) if node == "upper"));
    scene.remove(upper).unwrap();
    assert!(matches!(scene.snapshot(), Err(SceneError::Missing { what: "joint", .. })));

    let plain = scene.add_mesh(
        Mesh::new(MeshData { influences: vec![], ..bar(halves) }).unwrap(),
        Material::default(),
        DAffine3::IDENTITY,
    );
    scene.remove(node).unwrap();
    mesh_node(&mut scene, plain).skin = Some(one);
    assert!(scene.snapshot().unwrap_err().to_string().contains("no vertex names a joint"));
    scene.remove(plain).unwrap();
    scene.remove_unused();
    assert_eq!(scene.skins().count(), 0);
}

fn slide(node: NodeKey, to: f32) -> Channel {
    let values = vec![0.0, 0.0, 0.0, to, 0.0, 0.0];
    Channel::new(
        node,
        Track::new(Property::Translation, Interpolation::Linear, vec![0.0, 2.0], values).unwrap(),
    )
}

#[test]
fn a_clip_and_a_time_say_where_everything_is() {
    let mut scene = Scene::new();
    let (a, b) = (scene.add_group("a"), scene.add_group("b"));
    let rest =
        Transform { translation: DVec3::Y, rotation: DQuat::from_rotation_x(0.5), scale: DVec3::splat(2.0) };
    scene.set_transform(a, rest).unwrap();
    let first = scene.add_animation(Animation::new("first", vec![slide(a, 4.0)])).unwrap();
    let second = scene.add_animation(Animation::new("second", vec![slide(b, 8.0)])).unwrap();
    let at = |scene: &Scene| [a, b].map(|key| scene.node(key).unwrap().parent_from_local.translation);

    scene.animate(first, 1.0).unwrap();
    assert_eq!(at(&scene), [DVec3::X * 2.0, DVec3::ZERO]);
    let shown = scene.node(a).unwrap().parent_from_local;
    assert_eq!(shown.matrix3, rest.matrix().matrix3, "what is not animated stays at rest");
    let revision = scene.revision();
    scene.animate(first, 1.0).unwrap();
    assert_eq!(scene.revision(), revision, "nothing moved, nothing changed");
    scene.animate(second, 99.0).unwrap();
    assert_eq!(at(&scene), [DVec3::Y, DVec3::X * 8.0]);
    scene.animate_all(0.5).unwrap();
    assert_eq!(at(&scene), [DVec3::X, DVec3::X * 2.0]);
    for seconds in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(matches!(scene.animate(first, seconds), Err(SceneError::BadTime { .. })));
    }
    assert_eq!(at(&scene), [DVec3::X, DVec3::X * 2.0]);
    scene.rest().unwrap();
    assert_eq!(scene.node(a).unwrap().parent_from_local, rest.matrix());
    assert_eq!(scene.find_animation("second"), Some(second));
    // A removed node takes its channels with it.
    scene.remove(b).unwrap();
    assert_eq!(scene.animation(second).unwrap().channels.len(), 0);
    scene.animate_all(1.0).unwrap();
}

#[test]
fn animations_that_do_not_fit_are_refused() {
    let mut scene = Scene::new();
    let node = scene.add_group("sheared");
    let refused = |scene: &mut Scene, channel: Channel, says: &str| {
        let error = scene.add_animation(Animation::new("clip", vec![channel])).unwrap_err().to_string();
        assert!(error.contains("'clip'") && error.contains(says), "{error}");
    };
    let weights = || Track::new(Property::Weights, Interpolation::Step, vec![0.0], vec![0.0, 1.0]).unwrap();
    refused(
        &mut scene,
        Channel::new(node, weights()),
        "2 weights of node 'sheared', whose mesh has 0 morph targets",
    );
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z);
    scene.node_mut(node).unwrap().parent_from_local = DAffine3::from_mat3(shear);
    refused(&mut scene, slide(node, 1.0), "'sheared', whose transform is no translation");
    scene.remove(node).unwrap();
    refused(&mut scene, slide(node, 1.0), "not there");
    assert_eq!(scene.animations().count(), 0);
}
