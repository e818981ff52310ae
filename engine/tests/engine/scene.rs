//! The scene graph: hierarchy, transforms, scopes, removal, revisions. No device.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, DVec4, Vec3};
use shadowgraph_engine::geometry::{Mesh, MeshData, shapes};
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::{
    Camera, Content, Light, LightKind, Material, MeshNode, NodeKey, Scene, SceneError, ShadowNode,
};

fn cube() -> Mesh {
    Mesh::new(shapes::cuboid(Vec3::splat(-0.5), Vec3::splat(0.5)).named("cube")).unwrap()
}

fn add_cube(scene: &mut Scene, parent: Option<NodeKey>, name: &str, at: DAffine3) -> NodeKey {
    let mesh = scene.add_mesh_data(Arc::new(cube()));
    let material = scene.add_material(Material::default());
    scene.add(parent, name, at, Content::Mesh(MeshNode::new(mesh, material)))
}

fn moved(x: f64, y: f64, z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(x, y, z))
}

#[test]
fn transforms_of_every_kind_compose_down_the_tree() {
    let mut scene = Scene::new();
    let turned = DAffine3::from_rotation_translation(DQuat::from_rotation_y(FRAC_PI_2), DVec3::X);
    let root = scene.add(None, "root", turned, Content::Group);
    let mirrored = DAffine3::from_scale(DVec3::new(-1.0, 2.0, 1.0));
    let middle = scene.add(Some(root), "middle", mirrored, Content::Group);
    let sheared = DAffine3::from_mat3(DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z));
    let leaf = add_cube(&mut scene, Some(middle), "leaf", sheared);
    let p = DVec3::new(0.25, 0.5, -0.5);
    let expected = turned.transform_point3(mirrored.transform_point3(sheared.transform_point3(p)));
    let world = scene.world_from_local(leaf).unwrap();
    assert!(world.transform_point3(p).distance(expected) < 1e-15);
    let snapshot = scene.snapshot().unwrap();
    assert_eq!(snapshot.instances[0].world_from_local, world);
    // The box around it is the box around its transformed vertices, not around a transformed box.
    let vertices = (0..snapshot.instances[0].mesh.positions().len() as u32)
        .map(|v| snapshot.instances[0].world_position(v));
    let (low, high) = vertices.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    assert_eq!((snapshot.world_bounds.min, snapshot.world_bounds.max), (low, high));
}

#[test]
fn singular_transforms_flatten_without_a_nan() {
    for scale in
        [DVec3::new(1.0, 0.0, 1.0), DVec3::new(1.0, 0.0, 0.0), DVec3::ZERO, DVec3::new(1.0, 1e-12, 1.0)]
    {
        let mut scene = Scene::new();
        add_cube(&mut scene, None, "flat", moved(3.0, 2.0, 1.0) * DAffine3::from_scale(scale));
        let snapshot = scene.snapshot().unwrap();
        let instance = &snapshot.instances[0];
        assert!(instance.world_from_local.inverse().is_finite(), "{scale}");
        let expected = moved(3.0, 2.0, 1.0).transform_point3(scale * 0.5);
        let nearest =
            (0..8).map(|v| instance.world_position(v).distance(expected)).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-6, "{scale}: {nearest}");
    }
}

#[test]
fn reparenting_keeps_the_forest_a_forest() {
    let mut scene = Scene::new();
    let a = scene.add_group("a");
    let b = scene.add(Some(a), "b", moved(1.0, 0.0, 0.0), Content::Group);
    let c = add_cube(&mut scene, Some(b), "c", moved(0.0, 1.0, 0.0));
    assert_eq!(
        scene.reparent(a, Some(c)),
        Err(SceneError::Cycle { node: "a".into(), parent: "c".into() }),
        "a cycle is refused and named"
    );
    assert!(scene.reparent(a, Some(a)).is_err());
    scene.reparent(c, None).unwrap();
    assert_eq!(scene.world_from_local(c).unwrap().translation, DVec3::Y);
    assert_eq!((scene.roots(), scene.subtree(a)), (&[a, c][..], vec![a, b]));
    assert_eq!(scene.node(c).unwrap().parent(), None);
    assert!(scene.node(b).unwrap().children().is_empty());
}

#[test]
fn removal_takes_the_subtree_and_leaves_typed_errors() {
    let mut scene = Scene::new();
    let a = scene.add_group("a");
    let b = add_cube(&mut scene, Some(a), "b", DAffine3::IDENTITY);
    let other = add_cube(&mut scene, None, "other", DAffine3::IDENTITY);
    scene.remove(a).unwrap();
    assert!(scene.node(a).is_none() && scene.node(b).is_none() && scene.node(other).is_some());
    assert!(matches!(scene.remove(a), Err(SceneError::Missing { what: "node", .. })));
    assert!(matches!(scene.reparent(other, Some(a)), Err(SceneError::Missing { .. })));
    assert_eq!((scene.find("b"), scene.find("other")), (None, Some(other)));
    assert_eq!(scene.meshes().count(), 2);
    scene.remove_unused();
    assert_eq!(scene.meshes().count(), 1);
    assert_eq!(scene.snapshot().unwrap().instances.len(), 1);
    // A node whose mesh was taken away is named.
    if let Content::Mesh(content) = &mut scene.node_mut(other).unwrap().content {
        content.mesh = Default::default();
    }
    assert!(scene.snapshot().unwrap_err().to_string().contains("'other'"));
}

#[test]
fn every_change_is_a_new_revision_and_looking_is_none() {
    let mut scene = Scene::new();
    let node = add_cube(&mut scene, None, "cube", DAffine3::IDENTITY);
    let light = scene.add_light(Light::point("lamp", 1.0), DVec3::Y, DVec3::ZERO);
    let mut last = scene.revision();
    let _ = (scene.snapshot().unwrap(), scene.find("cube"), scene.world_from_local(node));
    assert_eq!(scene.revision(), last);
    let copy = scene.clone();
    assert_eq!(copy.revision(), last, "a copy is the same scene until it changes");
    let changes: [fn(&mut Scene, NodeKey); 5] = [
        |scene, node| scene.node_mut(node).unwrap().parent_from_local = moved(1.0, 0.0, 0.0),
        |scene, node| scene.reparent(node, None).unwrap(),
        |scene, _| scene.set_ambient(Vec3::ONE),
        |scene, _| scene.remove_unused(),
        |scene, node| scene.remove(node).unwrap(),
    ];
    for change in changes {
        change(&mut scene, node);
        assert!(scene.revision() > last);
        last = scene.revision();
    }
    let key = scene.lights().next().unwrap().0;
    scene.light_mut(key).unwrap().intensity = 2.0;
    assert!(scene.revision() > last && scene.node(light).is_some());
}

#[test]
fn shadow_nodes_reach_what_their_scopes_name() {
    let mut scene = Scene::new();
    let group = scene.add_group("furniture");
    let chair = add_cube(&mut scene, Some(group), "chair", DAffine3::IDENTITY);
    let wall = add_cube(&mut scene, None, "wall", DAffine3::IDENTITY);
    let lamp = scene.add_light(Light::point("lamp", 1.0), DVec3::Y, DVec3::ZERO);
    scene.add_light(Light::directional("sun", 1.0), DVec3::Y, DVec3::ZERO);
    scene.add_shadow("all", ShadowNode::new("Any"));
    scene.add_shadow(
        "some",
        ShadowNode::new("Any").with_lights([lamp]).with_casters([group]).with_receivers([wall]),
    );
    let snapshot = scene.snapshot().unwrap();
    let [all, some] = &snapshot.shadow_nodes[..] else { panic!("two shadow nodes") };
    assert_eq!((&all.lights[..], &all.casters[..]), (&[0, 1][..], &[0, 1][..]));
    assert_eq!((&some.lights[..], &some.casters[..], &some.receivers[..]), (&[0][..], &[0][..], &[1][..]));
    // Flags and visibility take things out of every scope.
    if let Content::Mesh(content) = &mut scene.node_mut(chair).unwrap().content {
        content.shadow.casts = false;
    }
    let sun = scene.lights().find(|(_, light)| light.name == "sun").unwrap().0;
    scene.light_mut(sun).unwrap().casts_shadows = false;
    scene.node_mut(wall).unwrap().visible = false;
    let snapshot = scene.snapshot().unwrap();
    assert_eq!(snapshot.instances.len(), 1);
    assert_eq!((&snapshot.shadow_nodes[0].lights[..], snapshot.shadow_nodes[0].casters.len()), (&[0][..], 0));
}

#[test]
fn lights_and_cameras_pose_as_their_nodes_stand() {
    let mut scene = Scene::new();
    scene.add_light(Light::directional("sun", 1.0), DVec3::new(0.0, 5.0, 0.0), DVec3::ZERO);
    scene.add_light(Light::spot("a/b", 1.0, 0.5).with_range(2.0), DVec3::X, DVec3::ZERO);
    scene.add_light(Light::point("a_b", 1.0), DVec3::Z, DVec3::ZERO);
    scene.add_light(Light::point("", 1.0), DVec3::Z, DVec3::ZERO);
    scene.add_camera(Camera::perspective("eye", 1.0), DVec3::new(0.0, 0.0, 4.0), DVec3::ZERO);
    let snapshot = scene.snapshot().unwrap();
    assert!((snapshot.lights[0].position - DVec4::Y).length() < 1e-15);
    assert!((snapshot.lights[1].direction - DVec3::NEG_X).length() < 1e-15);
    assert!(snapshot.lights[1].reaches(DVec3::new(0.1, 0.0, 0.0)));
    assert!(!snapshot.lights[1].reaches(DVec3::new(-1.5, 0.0, 0.0)), "beyond the range");
    assert!(!snapshot.lights[1].reaches(DVec3::new(0.9, 0.5, 0.0)), "outside the cone");
    let names: Vec<&str> = snapshot.lights.iter().map(|light| light.name.as_str()).collect();
    assert_eq!(names, ["sun", "a_b", "a_b_2", "light3"], "plain file names, none twice");
    assert_eq!(snapshot.cameras[0].world_from_view.translation, DVec3::new(0.0, 0.0, 4.0));
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |change: fn(&mut Scene)| {
        let mut scene = Scene::new();
        change(&mut scene);
        scene.snapshot().unwrap_err().to_string()
    };
    let error = refused(|scene| {
        scene.add(None, "broken", moved(f64::NAN, 0.0, 0.0), Content::Group);
    });
    assert!(error.contains("'broken'"), "{error}");
    let error = refused(|scene| {
        let light =
            Light { kind: LightKind::Spot { inner_rad: 0.5, outer_rad: 0.2 }, ..Light::point("cone", 1.0) };
        scene.add_light(light, DVec3::Y, DVec3::ZERO);
    });
    assert!(error.contains("'cone'") && error.contains("inner <= outer"), "{error}");
    let error = refused(|scene| {
        scene.add_light(Light { intensity: f32::NAN, ..Light::point("dim", 1.0) }, DVec3::Y, DVec3::ZERO);
    });
    assert!(error.contains("'dim'"), "{error}");
    let error = refused(|scene| {
        let projection = Projection::Orthographic { half_height_m: 1.0, near_m: 2.0, far_m: 1.0 };
        scene.add_camera(Camera { name: "inside out".into(), projection }, DVec3::Y, DVec3::ZERO);
    });
    assert!(error.contains("'inside out'") && error.contains("near < far"), "{error}");
    let bad = MeshData {
        name: "bad".into(),
        positions: vec![Vec3::ZERO],
        indices: vec![0, 0, 7],
        ..MeshData::default()
    };
    let error = Mesh::new(bad).unwrap_err().to_string();
    assert!(error.contains("'bad'") && error.contains('7') && error.contains("1 vertices"), "{error}");
}
