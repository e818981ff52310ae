//! `SoftShadow`: its options, what it refuses, and its plans. No GPU.

use shadowgraph::engine::gltf;
use shadowgraph::engine::plan::{Access, FramePlan, Geometry, SlotKind, TextureFormat};
use shadowgraph::engine::scene::{NodeKey, ParamValue, Params};
use shadowgraph::engine::shadow::{Cache, Features, Options, ShadowError};
use shadowgraph::prelude::*;
use shadowgraph_engine::render::{Adapter, FrameError};
use shadowgraph_nodes::{Flat, NotPlanar};
use shadowgraph_testing::*;

/// Drawn in the picture from 16 points.
const IN_PICTURE: SoftShadow = SoftShadow { samples: 16, ..SoftShadow::DIRECT };

/// The node with these receivers.
fn planar(receivers: impl IntoIterator<Item = NodeKey>, node: SoftShadow) -> ShadowNode {
    ShadowNode::from(node).with_receivers(receivers)
}

fn find(scene: &Scene, name: &str) -> NodeKey {
    scene.nodes().find(|(_, node)| node.name == name).unwrap().0
}

fn shadowed(node: SoftShadow) -> Scene {
    let mut scene = yard();
    let floor = find(&scene, "floor");
    scene.add_shadow("shadows", planar([floor], node));
    scene
}

fn refused(scene: &Scene) -> ShadowError {
    match try_plan(scene, &request()) {
        Err(FrameError::Shadow(error)) => error,
        other => panic!("not refused: {other:?}"),
    }
}

/// Each point of the light has its glass multiplied, four points at a time are added; and none of it where nothing is glass.
#[test]
fn glass_takes_a_pass_for_each_point_and_wide_floats_where_there_are_some() {
    let mut scene = shadowed(SoftShadow { samples: 10, ..IN_PICTURE });
    let tints = |plan: &FramePlan| plan.passes_named("tints on floor from lamp").count();
    assert_eq!(tints(&plan(&scene, &request())), 0);
    let glass = Material { transmission: 0.5, ..Material::default() };
    scene.add_mesh(quad("pane", 0.5), glass, at(-1.5, 1.0, 0.0));
    let with = |features: Features| {
        let adapter = Adapter { features, ..Adapter::imagined() };
        try_plan_with(&scene, &request(), &shadowgraph_nodes::catalog(), &adapter, &Cache::new()).unwrap()
    };
    for (features, format, noted) in [
        (Features::all(), TextureFormat::Rgba32Float, false),
        (Features::all() - Features::FLOAT32_BLENDABLE, TextureFormat::Rgba16Float, true),
    ] {
        let plan = with(features);
        assert_eq!(tints(&plan), 10, "{plan}");
        let sums: Vec<_> = plan.passes_named("tinted light of lamp on floor").collect();
        assert_eq!(sums.len(), 3, "{plan}");
        let sum = plan.slot(sums[0].colors[0].slot);
        assert!(matches!(sum.kind, SlotKind::Texture { format: f, .. } if f == format), "{plan}");
        assert_eq!(has_note(&plan, "half floats"), noted, "{plan}");
    }
}

#[test]
fn direct_mode_draws_each_point_once_and_weighs() {
    let plan = plan(&shadowed(IN_PICTURE), &request());
    let names: Vec<&str> = plan.passes.iter().map(|pass| pass.name.as_str()).collect();
    assert_eq!(
        names,
        ["depth prepass", "shadows on floor from lamp", "share of lamp on floor", "shading"],
        "{plan}"
    );
    let marks = &plan.passes[1];
    // The receiver, and 16 points of the light.
    assert_eq!(marks.draws.len(), 17, "{plan}");
    let points = marks.draws[1..].iter();
    assert!(
        points.clone().all(|draw| matches!(draw.geometry, Geometry::IndexedProcedural { count: 36, .. }))
    );
    let references: Vec<u8> = points.map(|draw| draw.state.stencil.unwrap().reference).collect();
    assert_eq!(references, (239..=254).rev().collect::<Vec<u8>>());
    let depth = marks.depth.as_ref().unwrap();
    assert_eq!(depth.stencil, Some(Access::Clear(0.0)));
    let bits = plan.slot(marks.colors[0].slot);
    assert!(matches!(bits.kind, SlotKind::Texture { format: TextureFormat::Rg8Unorm, layers: 1, .. }));
    assert!(plan.slots.iter().all(|slot| slot.kept.is_none()));
}

#[test]
fn a_light_without_size_is_one_point() {
    let hard = SoftShadow { radius_m: 0.0, ..IN_PICTURE };
    let plan = plan(&shadowed(hard), &request());
    let marks = plan.passes_named("shadows on").next().unwrap();
    assert_eq!(marks.draws.len(), 2);
    assert!(matches!(
        plan.slot(marks.colors[0].slot).kind,
        SlotKind::Texture { format: TextureFormat::R8Unorm, .. }
    ));
}

#[test]
fn many_points_take_layers_and_many_receivers_share_targets() {
    let mut scene = yard();
    let floor = find(&scene, "floor");
    let wall = scene.add_mesh(
        quad("wall", 4.0),
        Material::default(),
        DAffine3::from_rotation_translation(DQuat::from_rotation_x(1.2), DVec3::new(0.0, 1.0, -6.0)),
    );
    let node = SoftShadow { samples: 80, ..IN_PICTURE };
    scene.add_shadow("shadows", planar([floor, wall], node));
    let plan = plan(&scene, &request());
    assert_eq!(plan.passes_named("shadows on").count(), 6, "{plan}");
    let bits: Vec<_> = plan.slots.iter().filter(|slot| slot.name == "shadowed bits").collect();
    assert!(matches!(bits[..], [slot] if matches!(slot.kind, SlotKind::Texture { layers: 3, .. })), "{plan}");
    assert_eq!(plan.slots.iter().filter(|slot| slot.name == "receiver stencil").count(), 1);
    assert_eq!(plan.passes_named("share of").count(), 2);
}

#[test]
fn what_cannot_shadow_the_receiver_is_left_out_and_said() {
    let mut scene = shadowed(IN_PICTURE);
    add_box(&mut scene, "cellar", at(0.0, -3.0, 0.0));
    add_box(&mut scene, "attic", at(0.0, 9.0, 0.0));
    let plan = plan(&scene, &request());
    assert!(has_note(&plan, "'cellar' on 'floor' for 'lamp': lies in the plane or under it"), "{plan}");
    assert!(has_note(&plan, "'attic' on 'floor' for 'lamp': lies beyond the light"), "{plan}");
    // Alone they leave no pass.
    let mut scene = with_floor();
    add_lamp(&mut scene, "lamp");
    add_box(&mut scene, "cellar", at(0.0, -3.0, 0.0));
    let floor = find(&scene, "floor");
    scene.add_shadow("shadows", planar([floor], IN_PICTURE));
    let plan = shadowgraph_testing::plan(&scene, &request());
    assert_eq!(plan.passes.len(), 1, "{plan}");
}

#[test]
fn texture_mode_keeps_what_it_draws() {
    let textured = SoftShadow { mode: PlanarMode::Texture, resolution: 256, ..IN_PICTURE };
    let plan = plan(&shadowed(textured), &request());
    let text = plan.to_string();
    assert_eq!(text.matches("kept: runs only when").count(), 3, "{plan}");
    let texture = plan.slots.iter().find(|slot| slot.name == "shadow texture").unwrap();
    assert!(texture.kept.is_some());
    // What is left of every frame: the receiver's two triangles.
    let share = plan.passes_named("share of").next().unwrap();
    assert_eq!(share.draws.iter().map(|draw| draw.vertices()).sum::<u64>(), 6);
}

/// In halves of what is asked for: pictures of other sizes and eyes near and far.
#[test]
fn a_texture_is_as_fine_as_the_view_shows_it() {
    let scene = shadowed(SoftShadow { resolution: 2048, ..SoftShadow::default() });
    let longer_side = |eye: DVec3, size_px: [u32; 2]| {
        let plan = plan(&scene, &FrameRequest::new(camera(eye, DVec3::ZERO), size_px));
        let texture = plan.slots.iter().find(|slot| slot.name == "shadow texture").unwrap();
        let SlotKind::Texture { size_px: [width, height], .. } = texture.kind else { panic!("{plan}") };
        width.max(height)
    };
    let eye = DVec3::new(6.0, 5.0, 8.0);
    let near = longer_side(eye, [640, 480]);
    assert!((64..=512).contains(&near) && near.is_power_of_two(), "{near}");
    assert_eq!(longer_side(eye, [1280, 960]), 2 * near);
    assert_eq!(longer_side(eye, [320, 240]), near / 2);
    // No more than asked for, nor fewer than sixteen.
    assert_eq!(longer_side(eye * 0.01, [1280, 960]), 2048);
    assert_eq!(longer_side(eye * 1e4, [640, 480]), 16);
    // A step to the side changes nothing, so nothing is drawn anew.
    assert_eq!(longer_side(eye + DVec3::X * 0.01, [640, 480]), near);
}

#[test]
fn receivers_that_are_no_planes_are_refused_by_name() {
    let mut scene = yard();
    let (floor, body) = (find(&scene, "floor"), find(&scene, "crate"));
    scene.add_shadow("shadows", planar([floor, body], IN_PICTURE));
    let error = refused(&scene);
    assert!(
        matches!(&error, ShadowError::ReceiverRefused { receiver, .. } if receiver == "crate"),
        "{error}"
    );
    let text = error.to_string();
    assert!(text.contains("'crate'") && text.contains("1.000e0 m out of its plane"), "{text}");
    // A tenth of a millimetre in a metre is a bump; what f32 leaves of a turned plane is none.
    let bump = |height: f32| {
        let mut data = shapes::plane(Vec2::splat(0.5));
        data.positions[0].y = height;
        let mut scene = Scene::new();
        scene.add_mesh(mesh(data), Material::default(), DAffine3::IDENTITY);
        Flat::of(&scene.snapshot().unwrap().instances[0])
    };
    assert!(matches!(bump(1e-4), Err(NotPlanar::Deviates { deviation_m, .. }) if deviation_m > 2e-5));
    assert!(bump(1e-8).is_ok());
    let mut data = shapes::plane(Vec2::splat(7.0));
    let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
    data.positions.iter_mut().for_each(|p| *p = turn * *p + Vec3::new(3.0, -50.0, 20.0));
    let mut scene = Scene::new();
    scene.add_mesh(mesh(data), Material::default(), DAffine3::from_rotation_y(0.4));
    assert!(Flat::of(&scene.snapshot().unwrap().instances[0]).is_ok());
}

#[test]
fn four_samples_a_pixel_are_refused() {
    let request = FrameRequest { antialias: Antialias::Multisample4, ..request() };
    let error = try_plan(&shadowed(IN_PICTURE), &request).unwrap_err();
    assert!(matches!(error, FrameError::Shadow(ShadowError::NotPerSample { .. })), "{error}");
}

#[test]
fn options_say_what_is_accepted() {
    let read = |name: &str, value: ParamValue| {
        SoftShadow::from_params(&Params::from([(name.into(), value)])).map_err(|error| error.to_string())
    };
    let number = ParamValue::Number;
    assert_eq!(read("samples", number(64.0)).unwrap().samples, 64);
    for value in [0.0, 2.5, 1025.0] {
        assert!(read("samples", number(value)).unwrap_err().contains("from 1 to 1024"), "{value}");
    }
    assert!(read("radius", number(-1.0)).unwrap_err().contains("from 0"));
    assert!(read("mode", ParamValue::Text("baked".into())).unwrap_err().ends_with("texture, direct"));
    assert!(read("resolution", number(10_000.0)).unwrap_err().contains("8192"));
    assert!(read("weight", number(1.5)).unwrap_err().contains("from 0 to 1"));
    assert_eq!(read("color", ParamValue::Numbers(vec![0.1, 0.2, 1.0])).unwrap().color, [0.1, 0.2, 1.0]);
    for color in [
        ParamValue::Numbers(vec![0.1, 0.2]),
        ParamValue::Numbers(vec![0.0, 0.0, 2.0]),
        ParamValue::Text("red".into()),
    ] {
        assert!(read("color", color).unwrap_err().contains("a/b/c"));
    }
    assert!(read("receivers", number(1.0)).unwrap_err().contains("no option 'receivers'"));
}

#[test]
fn a_saved_node_loads_back_the_same() {
    let node = SoftShadow {
        samples: 48,
        radius_m: 0.25,
        angle_deg: 1.5,
        mode: PlanarMode::Texture,
        resolution: 512,
        weight: 0.75,
        color: [0.25, 0.5, 1.0],
    };
    let scene = shadowed(node);
    let folder = std::env::temp_dir().join(format!("shadowgraph-planar-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("planar.glb");
    gltf::save(&scene, &path).unwrap();
    let loaded = gltf::load(&path).unwrap().scene;
    std::fs::remove_dir_all(&folder).unwrap();
    let (_, shadow) = loaded.shadows().next().unwrap();
    assert_eq!(SoftShadow::from_params(&shadow.params), Ok(node));
    assert_eq!(shadow.receivers, Scope::Nodes(vec![find(&loaded, "floor")]));
}

/// On layers of glass there is no plane that receives: the node draws its shadows once.
#[test]
fn nothing_is_drawn_for_layers_on_which_nothing_receives() {
    let (_, _, scene) =
        shadowgraph::demo::mixed().into_iter().find(|(name, ..)| *name == "still-life").unwrap();
    let camera = scene.snapshot().unwrap().cameras[0].clone();
    let plan = plan(&scene, &FrameRequest::new(camera, [320, 180]));
    let passes = |part: &str| plan.passes.iter().filter(|pass| pass.name.contains(part)).count();
    assert!(plan.layers > 2 && passes("from behind") > 10, "{plan}");
    assert!(passes("on table top from key") > 0, "{plan}");
    let on_layers =
        plan.passes.iter().filter(|pass| pass.name.contains("table top") && pass.name.contains("layer"));
    assert_eq!(on_layers.count(), 0, "{plan}");
}
