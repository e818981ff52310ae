//! A scene saved as .glb loads back the same.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, Vec4};
use shadowgraph_engine::geometry::{Mesh, MeshData, Part};
use shadowgraph_engine::gltf::{self, GltfError};
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::{
    AlphaMode, Camera, Content, Image, ImageKey, Light, LightKind, Material, MeshNode, NodeKey, ParamValue,
    Scene, SceneSnapshot, Scope, ShadowFlags, ShadowNode, TextureRef, UvTransform, Wrap, placed,
};

/// A tetrahedron in two parts.
fn tetrahedron() -> Mesh {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.1, 0.2, 1.0 / 3.0)];
    Mesh::new(MeshData {
        name: "tetrahedron".into(),
        uvs: positions.iter().map(|p| Vec2::new(p.x * 0.7, p.y)).collect(),
        colors: positions.iter().map(|p| Vec4::new(p.x, 0.3, p.z, 0.9)).collect(),
        positions,
        indices: vec![0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3],
        parts: vec![Part { triangles: 0..1, material_slot: 1 }, Part { triangles: 1..4, material_slot: 0 }],
        ..MeshData::default()
    })
    .unwrap()
}

/// A material of which nothing is at its default.
fn glass(image: ImageKey) -> Material {
    let transform =
        UvTransform { offset: Vec2::new(0.1, 0.2), rotation_rad: 0.3, scale: Vec2::new(2.0, -3.0) };
    let wrap = [Wrap::Mirror, Wrap::Clamp];
    let texture = TextureRef { wrap, smooth: false, transform, ..TextureRef::new(image) };
    Material {
        name: "glass".into(),
        base_color: Vec4::new(0.1, 0.2, 0.3, 0.4),
        base_color_texture: Some(texture),
        metallic: 0.25,
        roughness: 0.1,
        metallic_roughness_texture: Some(TextureRef::new(image)),
        emissive: Vec3::new(0.1, 7.3, 0.0),
        emissive_texture: Some(texture),
        normal_texture: Some((texture, 0.7)),
        occlusion_texture: Some((texture, 0.6)),
        alpha_mode: AlphaMode::Mask { cutoff: 0.3 },
        double_sided: false,
        unlit: false,
        transmission: 0.65,
        surface: None,
    }
}

fn rich_scene() -> Scene {
    let mut scene = Scene::new();
    scene.set_ambient(Vec3::new(0.1, 0.123_456_79, 0.3));
    scene.set_background(Vec3::new(0.7, 0.0, 0.1));
    let rgba8 = (0..24).map(|i| i * 10).collect();
    let image = scene.add_image(Arc::new(Image { name: "checker".into(), width: 3, height: 2, rgba8 }));
    let glass = scene.add_material(glass(image));
    let blend = Material { alpha_mode: AlphaMode::Blend, ..Material::matt("sign", Vec3::splat(0.5)) };
    let sign = scene.add_material(Material { unlit: true, ..blend });
    let mesh = scene.add_mesh_data(Arc::new(tetrahedron()));
    let group =
        scene.add(None, "group", DAffine3::from_translation(DVec3::new(0.1, 0.2, 1e-9)), Content::Group);
    let shear = DAffine3::from_mat3_translation(
        DMat3::from_cols_array(&[0.1, 0.7, 0.3, 0.2, -0.9, 1.0 / 3.0, 0.0, 0.01, -2.0]),
        DVec3::new(std::f64::consts::PI, 1e6 + 0.1, -7.0),
    );
    let content = MeshNode::in_materials(mesh, vec![glass, sign]);
    let caster = scene.add(Some(group), "caster", shear, Content::Mesh(content));
    // The same mesh in other materials: slot 1 has none and wears the default one.
    let shadow = ShadowFlags { casts: false, receives: true };
    let content = MeshNode { shadow, ..MeshNode::new(mesh, sign) };
    let turned = placed(DVec3::X, DQuat::from_rotation_y(0.3), DVec3::new(1.0, -1.0, 2.0));
    let other = scene.add(Some(caster), "", turned, Content::Mesh(content));
    let hidden = scene.add_mesh(tetrahedron(), Material::default(), DAffine3::IDENTITY);
    scene.node_mut(hidden).unwrap().visible = false;
    let empty = Mesh::new(MeshData { name: "empty".into(), ..MeshData::default() }).unwrap();
    scene.add_mesh(empty, Material::default(), DAffine3::IDENTITY);

    let lamp = Light::spot("lamp", 300.1, 0.777).with_color(Vec3::new(1.0, 0.9, 0.1)).with_range(12.34);
    let lamp = scene.add_light(lamp, DVec3::new(1.0, 5.0, 2.0), DVec3::ZERO);
    let sun = scene.add_light(Light::directional("sun", 1e5), DVec3::new(1.0, 5.0, 2.0), DVec3::ZERO);
    let quiet = scene.add_light_data(Light { casts_shadows: false, ..Light::point("quiet", 3.0) });
    scene.add(Some(group), "another name", DAffine3::IDENTITY, Content::Light(quiet));
    scene.add_camera(Camera::perspective("view", 0.789), DVec3::new(3.0, 2.0, 1.0), DVec3::ZERO);
    let projection = Projection::Orthographic { half_height_m: 2.1, near_m: 0.0, far_m: 33.3 };
    scene.add_camera(Camera { name: "plan".into(), projection }, DVec3::new(0.0, 9.0, 0.1), DVec3::ZERO);

    scene.add_shadow("all", ShadowNode::new("AnyTechnique"));
    let some = ShadowNode::new("OtherTechnique")
        .with_param("word", ParamValue::Text("auto".into()))
        .with_param("size", ParamValue::Number(0.1))
        .with_param("flag", ParamValue::Flag(true))
        .with_param("color", ParamValue::Numbers(vec![0.1, 2.0, -3e300]))
        .with_lights([lamp, sun])
        .with_casters([group, other])
        .with_receivers([caster]);
    scene.add_shadow("some", some);
    scene.add_shadow("none", ShadowNode::new("AnyTechnique").with_casters([]));
    scene
}

/// A material with its textures spelled out: image keys differ from scene to scene.
fn described_material(scene: &Scene, material: &Material) -> String {
    let normal = material.normal_texture.map(|(texture, _)| texture);
    let occlusion = material.occlusion_texture.map(|(texture, _)| texture);
    let worn = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.emissive_texture,
        normal,
        occlusion,
    ];
    let mut text = String::new();
    for texture in worn {
        let image = texture.map(|texture| scene.image(texture.image).unwrap());
        let bytes = image.map(|image| &image.rgba8);
        text += &format!("{image:?} {bytes:?} {:?}\n", texture.map(|t| (t.wrap, t.smooth, t.transform)));
    }
    let scales = (material.normal_texture.map(|t| t.1), material.occlusion_texture.map(|t| t.1));
    let plain = Material {
        base_color_texture: None,
        metallic_roughness_texture: None,
        emissive_texture: None,
        normal_texture: None,
        occlusion_texture: None,
        ..material.clone()
    };
    format!("{text}{scales:?} {plain:?}\n")
}

/// What a scene's snapshot says, without the keys and identities that differ from scene to scene.
fn described(scene: &Scene) -> String {
    let SceneSnapshot {
        instances,
        lights,
        cameras,
        shadow_nodes,
        world_bounds,
        images: _,
        ambient,
        background,
    } = scene.snapshot().unwrap();
    let mut text = format!("{world_bounds:?} {ambient:?} {background:?}\n");
    for i in instances {
        let mut data = i.mesh.data().clone();
        data.parts.iter_mut().for_each(|part| part.material_slot = 0);
        text += &format!("{} {:?} {:?} {data:?}\n", i.name, i.world_from_local, i.shadow);
        text.extend(i.materials.iter().map(|material| described_material(scene, material)));
    }
    for light in lights {
        text += &format!("{} {:?} {:?} {:?}\n", light.name, light.light, light.position, light.direction);
    }
    for camera in cameras {
        text += &format!("{} {:?} {:?}\n", camera.name, camera.world_from_view, camera.projection);
    }
    for node in shadow_nodes {
        let ShadowNode { technique, params, .. } = &node.shadow;
        text += &format!("{} {technique} {params:?} ", node.name);
        text += &format!("{:?} {:?} {:?}\n", node.lights, node.casters, node.receivers);
    }
    text
}

/// Every node's name, visibility, number of children and kind, in order.
fn outline(scene: &Scene) -> Vec<(String, bool, usize, std::mem::Discriminant<Content>)> {
    let nodes = scene.depth_first().into_iter().map(|key| scene.node(key).unwrap());
    nodes
        .map(|n| (n.name.clone(), n.visible, n.children().len(), std::mem::discriminant(&n.content)))
        .collect()
}

#[test]
fn a_saved_scene_loads_back_the_same() {
    let scene = rich_scene();
    let bytes = gltf::to_glb(&scene).unwrap().bytes;
    let loaded = gltf::load_slice(&bytes, None).unwrap();
    assert_eq!(outline(&scene), outline(&loaded.scene));
    assert_eq!(described(&scene), described(&loaded.scene));
    assert_eq!(loaded.node_keys.len(), scene.depth_first().len());
    // Only the empty mesh, written as a point, is worth a word.
    assert_eq!(loaded.warnings.len(), 1, "{:?}", loaded.warnings);
    let again = gltf::load_slice(&gltf::to_glb(&loaded.scene).unwrap().bytes, None).unwrap();
    assert_eq!(described(&again.scene), described(&scene));
}

#[test]
fn scopes_come_back_as_the_same_nodes() {
    let scene = rich_scene();
    let loaded = gltf::load_slice(&gltf::to_glb(&scene).unwrap().bytes, None).unwrap();
    let places = |scene: &Scene| -> Vec<Option<Vec<usize>>> {
        let order = scene.depth_first();
        let place = |key: &NodeKey| order.iter().position(|other| other == key).unwrap();
        let scopes = scene.shadows().flat_map(|(_, node)| [&node.lights, &node.casters, &node.receivers]);
        scopes
            .map(|scope| match scope {
                Scope::All => None,
                Scope::Nodes(keys) => Some(keys.iter().map(place).collect()),
            })
            .collect()
    };
    assert_eq!(places(&scene), places(&loaded.scene));
    assert_eq!(places(&scene).iter().flatten().map(Vec::len).sum::<usize>(), 5);
}

#[test]
fn files_are_written_whole_or_not_at_all() {
    let folder = std::env::temp_dir().join(format!("shadowgraph-save-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("scene.glb");
    gltf::save(&rich_scene(), &path).unwrap();
    assert_eq!(described(&gltf::load(&path).unwrap().scene), described(&rich_scene()));
    let before = std::fs::read(&path).unwrap();

    let mut bad = Scene::new();
    bad.add(None, "bad", DAffine3::from_scale(DVec3::splat(f64::NAN)), Content::Group);
    assert!(matches!(gltf::save(&bad, &path), Err(GltfError::Save { .. })));
    assert!(matches!(gltf::save(&Scene::new(), folder.join("no/where.glb")), Err(GltfError::Io { .. })));
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "temporary files are left over");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn an_empty_scene_survives() {
    let loaded = gltf::load_slice(&gltf::to_glb(&Scene::new()).unwrap().bytes, None).unwrap();
    assert_eq!(loaded.scene.nodes().count(), 0);
}

#[test]
fn keys_of_removed_things_are_refused() {
    let mut scene = rich_scene();
    let group = scene.find("group").unwrap();
    scene.remove(group).unwrap();
    let error = gltf::to_glb(&scene).unwrap_err().to_string();
    assert!(error.contains("'some'") && error.contains("no longer in the scene"), "{error}");
}

#[test]
fn spot_angles_survive_to_the_last_bit() {
    let mut scene = Scene::new();
    let kind = LightKind::Spot { inner_rad: 0.1, outer_rad: std::f64::consts::FRAC_PI_2 };
    scene.add_light(Light { kind, ..Light::point("wide", 1.0) }, DVec3::ONE, DVec3::ZERO);
    let loaded = gltf::load_slice(&gltf::to_glb(&scene).unwrap().bytes, None).unwrap();
    assert_eq!(loaded.scene.lights().next().unwrap().1.kind, kind);
}

/// What is saved is held against a reader that is not ours.
#[test]
fn another_reader_takes_what_is_saved() {
    let scene = rich_scene();
    let saved = gltf::to_glb(&scene).unwrap().bytes;
    let ::gltf::Gltf { document, blob } = ::gltf::Gltf::from_slice(&saved).unwrap();
    let ours = |is: fn(&Content) -> bool| scene.nodes().filter(|(_, node)| is(&node.content)).count();
    let cameras = document.nodes().filter(|node| node.camera().is_some()).count();
    assert_eq!(cameras, ours(|content| matches!(content, Content::Camera(_))));
    let meshes = document.nodes().filter(|node| node.mesh().is_some()).count();
    assert_eq!(meshes, ours(|content| matches!(content, Content::Mesh(_))));
    let blob = blob.unwrap();
    for primitive in document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()) {
        let positions = primitive.get(&::gltf::Semantic::Positions).unwrap();
        let view = positions.view().unwrap();
        assert!(view.offset() + view.length() <= blob.len());
        assert_eq!(positions.dimensions(), ::gltf::accessor::Dimensions::Vec3);
    }
}
