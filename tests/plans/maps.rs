//! `ShadowMap`: its options, what it refuses, and its plans. No GPU.

use shadowgraph::engine::gltf;
use shadowgraph::engine::plan::{Access, FramePlan, SlotKind, TextureFormat};
use shadowgraph::engine::scene::{ParamValue, Params};
use shadowgraph::engine::shadow::Options;
use shadowgraph::prelude::*;
use shadowgraph_testing::*;

fn shadowed(scene: &Scene, node: impl Into<ShadowNode>) -> Scene {
    let mut scene = scene.clone();
    scene.add_shadow("shadows", node);
    scene
}

fn names(plan: &FramePlan) -> Vec<&str> {
    plan.passes.iter().map(|pass| pass.name.as_str()).collect()
}

/// One face of six is drawn, since the crate is under the lamp; its map and the planes in it are kept.
#[test]
fn a_lamp_has_as_many_maps_as_directions_in_which_something_casts() {
    let plan = plan(&shadowed(&yard(), ShadowMap::default()), &request());
    assert_eq!(
        names(&plan),
        ["depth prepass", "receiver planes", "map of lamp", "look up lamp", "shading"],
        "{plan}"
    );
    let map = &plan.passes[2];
    assert_eq!(map.draws.len(), 1, "{plan}");
    let depth = plan.slot(map.depth.unwrap().slot);
    let slopes = plan.slot(map.colors[0].slot);
    let texture = |format| SlotKind::Texture { format, size_px: [2048; 2], layers: 1, samples: 1 };
    assert_eq!(depth.kind, texture(TextureFormat::Depth32Float));
    assert_eq!(slopes.kind, texture(TextureFormat::Rg16Float));
    assert!(depth.kept.is_some() && depth.kept == slopes.kept);
    assert_eq!(map.depth.unwrap().depth, Access::Clear(0.0));
    // The window is about the crate, not the whole face.
    assert!(map.reason.starts_with("2048 x 2048 texels on 0.27"), "{}", map.reason);
    assert!(plan.to_string().contains("kept until something moves that it sees"), "{plan}");
}

/// Biases that are set need no planes of casters.
#[test]
fn biases_take_the_place_of_planes() {
    let node = ShadowMap { slope_bias_texels: Some(2.0), ..ShadowMap::default() };
    let plan = plan(&shadowed(&yard(), node), &request());
    let map = plan.passes.iter().find(|pass| pass.name == "map of lamp").unwrap();
    assert!(map.colors.is_empty(), "{plan}");
    assert!(plan.slots.iter().all(|slot| !slot.name.contains("slopes")), "{plan}");
}

/// What cannot matter is not in the plan: a floor that has everything before it, lights that see no caster, views of nothing.
#[test]
fn nothing_is_drawn_that_cannot_matter() {
    let mut scene = yard();
    scene.add_mesh(quad("rug", 3.0), Material::default(), at(0.0, 0.001, 0.0));
    scene.add_light(Light::spot("aside", 20.0, 0.3), DVec3::new(30.0, 3.0, 0.0), DVec3::new(40.0, 0.0, 0.0));
    let plan = plan(&shadowed(&scene, ShadowMap::default()), &request());
    let map = plan.passes.iter().find(|pass| pass.name == "map of lamp").unwrap();
    assert_eq!(
        map.draws.iter().map(|draw| draw.name.as_str()).collect::<Vec<_>>(),
        ["crate, rug, cut to the view"],
        "{plan}"
    );
    assert!(names(&plan).iter().all(|name| !name.contains("aside")), "{plan}");
    // On the floor itself it would have nothing behind it.
    let mut scene = yard();
    scene.add_mesh(quad("rug", 3.0), Material::default(), at(0.0, 0.0, 0.0));
    let plan = shadowgraph_testing::plan(&shadowed(&scene, ShadowMap::default()), &request());
    let map = plan.passes.iter().find(|pass| pass.name == "map of lamp").unwrap();
    assert_eq!(map.draws.len(), 1, "{plan}");
    assert!(
        plan.notes.iter().any(|note| note.contains("'rug'") && note.contains("flat")),
        "{:?}",
        plan.notes
    );
}

#[test]
fn cascades_are_layers_of_one_map() {
    let mut scene = with_floor();
    for x in -3..=3 {
        add_box(&mut scene, "crate", at(3.0 * f64::from(x), 1.0, -2.0 * f64::from(x)));
    }
    scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(0.2, -1.0, 0.1));
    let plan = plan(&shadowed(&scene, ShadowMap { cascades: 3, ..ShadowMap::default() }), &request());
    let maps: Vec<u32> =
        plan.passes.iter().filter(|pass| pass.name == "map of sun").map(|p| p.depth.unwrap().layer).collect();
    assert_eq!(maps, [0, 1, 2], "{plan}");
}

#[test]
fn each_of_four_samples_a_pixel_is_asked() {
    let four = FrameRequest { antialias: Antialias::Multisample4, ..request() };
    let scene = shadowed(&yard(), ShadowMap::default());
    let (one, plan) = (plan(&scene, &request()), plan(&scene, &four));
    let size_px = |plan: &FramePlan, name: &str| {
        plan.slots.iter().find(|slot| slot.name == name).map(|slot| match slot.kind {
            SlotKind::Texture { size_px, samples: 1, .. } => size_px,
            _ => panic!("{slot}"),
        })
    };
    // A texel for every sample, of what is asked and of what it is asked about.
    let twice = request().size_px.map(|n| 2 * n);
    for name in ["visibility", "depth of samples", "receiver planes"] {
        assert_eq!(size_px(&plan, name), Some(twice), "{plan}");
    }
    assert_eq!(size_px(&one, "depth of samples"), None, "{one}");
    // Nothing else is drawn oftener, and what confines the look-up confines it to the same place.
    let look_up = |plan: &FramePlan| {
        let pass = plan
            .passes
            .iter()
            .find(|pass| pass.name == "look up lamp")
            .expect("a light is looked up")
            .clone();
        pass.draws[0].scissor_px.expect("the look-up is confined")
    };
    assert_eq!(look_up(&one).map(|n| 2 * n), look_up(&plan));
}

#[test]
fn options_survive_a_file_and_what_is_wrong_is_named() {
    let node = ShadowMap {
        resolution: 512,
        faces: Faces::Back,
        pcf: 5,
        constant_bias_m: Some(0.01),
        slope_bias_texels: None,
        normal_bias_texels: Some(1.5),
        cascades: 2,
    };
    let glb = gltf::to_glb(&shadowed(&yard(), node)).unwrap();
    let loaded = gltf::load_slice(&glb.bytes, None).unwrap().scene;
    let (_, shadow) = loaded.shadows().next().unwrap();
    assert_eq!(ShadowMap::from_params(&shadow.params), Ok(node));
    assert!(!shadow.params.contains_key("slopeBias"), "{:?}", shadow.params);
    let refused = |name: &str, value: f64| {
        let params = Params::from([(name.to_owned(), ParamValue::Number(value))]);
        ShadowMap::from_params(&params).unwrap_err().to_string()
    };
    assert!(refused("resolution", 16.0).contains("a whole number from 32 to 8192"));
    assert!(refused("pcf", 9.0).contains("a whole number from 1 to 7"));
    assert!(refused("constantBias", -1.0).contains("a number from 0 to 1000"));
    assert!(refused("slopeBias", f64::NAN).contains("slopeBias"));
}

/// Depth first, then the points beside it, kept together; one draw for all outlines.
#[test]
fn silhouettes_are_drawn_after_the_depth_they_are_hidden_by() {
    let plan = plan(&shadowed(&yard(), SilhouetteMap::default()), &request());
    assert_eq!(
        names(&plan),
        ["depth prepass", "receiver planes", "map of lamp", "silhouettes of lamp", "look up lamp", "shading"],
        "{plan}"
    );
    let pass = &plan.passes[3];
    let points = plan.slot(pass.colors[0].slot);
    let wanted =
        SlotKind::Texture { format: TextureFormat::Rg8Unorm, size_px: [1024; 2], layers: 1, samples: 1 };
    assert_eq!(points.kind, wanted);
    assert!(points.kept.is_some() && points.kept == plan.slot(pass.depth.unwrap().slot).kept);
    // The lamp is right above: of the crate it sees the top, whose four edges end it.
    assert_eq!(pass.draws.len(), 1, "{plan}");
    assert_eq!(pass.draws[0].name, "4 edges", "{plan}");
    let node = SilhouetteMap { point_format: PointFormat::OneByte, ..SilhouetteMap::default() };
    let plan = shadowgraph_testing::plan(&shadowed(&yard(), node), &request());
    let points = plan.slots.iter().find(|slot| slot.name == "silhouette points of lamp").unwrap();
    assert!(matches!(points.kind, SlotKind::Texture { format: TextureFormat::R8Unorm, .. }), "{plan}");
}

/// A floor that a post pierces by a centimetre casts, and a map shows of it what is before the post's foot: not all that is in view.
#[test]
fn a_pierced_floor_does_not_widen_a_map() {
    let widest_m = |sunk_m: f32| {
        let mut scene = Scene::new();
        scene.add_mesh(
            mesh(shapes::plane(Vec2::splat(200.0)).named("floor")),
            Material::default(),
            DAffine3::IDENTITY,
        );
        let post = shapes::cuboid(Vec3::new(-0.1, -sunk_m, -0.1), Vec3::new(0.1, 1.0, 0.1));
        scene.add_mesh(mesh(post.named("post")), Material::default(), DAffine3::IDENTITY);
        scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(0.4, -1.0, 0.2));
        let plan = plan(&shadowed(&scene, ShadowMap::default()), &request());
        let map = plan.passes.iter().find(|pass| pass.name == "map of sun").expect("the post casts");
        let size = map.reason.split(" texels on ").nth(1).expect("it says what it shows").to_owned();
        let sides = size.trim_end_matches(" m").split(" x ").map(|side| side.parse::<f64>().unwrap());
        sides.fold(0.0, f64::max)
    };
    let (on_top, sunk) = (widest_m(0.0), widest_m(0.01));
    assert!(on_top < 5.0 && sunk < 1.2 * on_top, "{on_top} and {sunk} m");
}
