//! What is refused before anything is drawn, and that each refusal names both parties and what is accepted.

use glam::{DAffine3, DVec3, Vec3};
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::render::{Adapter, FrameError, FrameRequest};
use shadowgraph_engine::scene::{
    AlphaMode, Camera, CameraSnapshot, Light, Material, ParamValue, Scene, ShadowNode,
};
use shadowgraph_engine::shadow::{Cache, Features, OptionError, ShadowError};
use shadowgraph_testing::*;

/// The yard with this shadow node; the error of planning it.
fn refusal(shadow: ShadowNode) -> ShadowError {
    let mut scene = yard();
    scene.add_shadow("shadows", shadow);
    shadow_error(&scene, &request())
}

fn shadow_error(scene: &Scene, request: &FrameRequest) -> ShadowError {
    match try_plan(scene, request) {
        Err(FrameError::Shadow(error)) => error,
        other => panic!("expected a refusal, got {other:?}"),
    }
}

fn assert_names(error: &ShadowError, names: &[&str]) {
    let text = error.to_string();
    assert!(!text.contains('\n'), "one line: {text}");
    for name in names {
        assert!(text.contains(name), "'{name}' is not named in: {text}");
    }
}

#[test]
fn an_unknown_technique_lists_the_known() {
    let error = refusal(ShadowNode::new("ShadowVolumeHarder"));
    assert!(matches!(&error, ShadowError::UnknownTechnique { .. }));
    assert_names(&error, &["'shadows'", "'ShadowVolumeHarder'", "known: ", "ShadowVolumeHard"]);
    // Scenes use type names; the short ones are the command line's.
    assert!(matches!(refusal(ShadowNode::new("hard")), ShadowError::UnknownTechnique { .. }));
}

#[test]
fn an_unknown_option_lists_those_there_are() {
    let error = refusal(hard(&[("depthtest", "auto")]));
    assert!(matches!(&error, ShadowError::Option { source: OptionError::Unknown { .. }, .. }));
    let options = ["depthTest", "geometry", "extrusion", "closure", "passes", "counter", "terminator"];
    assert_names(&error, &["'shadows'", "ShadowVolumeHard", "'depthtest'"]);
    assert_names(&error, &options);
}

#[test]
fn a_bad_value_lists_what_is_accepted() {
    let error = refusal(hard(&[("depthTest", "zpas")]));
    assert!(matches!(&error, ShadowError::Option { source: OptionError::BadValue { .. }, .. }));
    assert_names(&error, &["'shadows'", "'depthTest'", "'zpas'", "auto, zpass, zfail"]);
    let error = refusal(hard(&[("geometry", "")]));
    assert_names(&error, &["'geometry'", "auto, closed, open"]);
    let error = refusal(hard(&[("extrusion", "ToBounds")]));
    assert_names(&error, &["'extrusion'", "auto, infinite, toBounds"]);
    // The wrong type of value.
    let node = ShadowNode::new("ShadowVolumeHard");
    for (value, shown) in [
        (ParamValue::Number(2.5), "2.5"),
        (ParamValue::Flag(true), "true"),
        (ParamValue::Numbers(vec![1.0]), "[1.0]"),
    ] {
        let error = refusal(node.clone().with_param("geometry", value));
        assert_names(&error, &["'geometry'", shown, "auto, closed, open"]);
    }
}

#[test]
fn every_accepted_value_is_accepted() {
    for (option, values) in [
        ("depthTest", vec!["auto", "zfail", "zpass"]),
        ("geometry", vec!["auto", "closed", "open"]),
        ("extrusion", vec!["auto", "infinite", "toBounds"]),
    ] {
        for value in values {
            let plan = plan(&shadowed_yard(&[(option, value)]), &request());
            assert!(!volume_draws(&plan, "lamp").is_empty(), "{option}={value}");
        }
    }
}

#[test]
fn masked_casters_are_asked_texel_by_texel_and_are_no_solids() {
    let mut scene = yard();
    let leaves = Material { alpha_mode: AlphaMode::Mask { cutoff: 0.5 }, ..Material::default() };
    let mut solid = scene.clone();
    scene.add_mesh(quad("hedge", 1.0), leaves.clone(), at(3.0, 1.0, 0.0));
    let crate_node = scene.find("crate").unwrap();
    let mut scoped = scene.clone();
    scene.add_shadow("shadows", hard(&[]));
    let plan_of_all = plan(&scene, &request());
    let masks: Vec<_> = plan_of_all.passes_named("masks of lamp").collect();
    assert_eq!(masks.len(), 1, "{plan_of_all}");
    // One triangle over the picture that looks for both; the crate goes on counting in the stencil.
    assert_eq!(masks[0].draws.len(), 1);
    assert_eq!((masks[0].draws[0].name.as_str(), masks[0].draws[0].vertices()), ("2 masked triangles", 3));
    assert!(volume_draws(&plan_of_all, "lamp").iter().all(|draw| draw.name.starts_with("crate ")));
    // What is not in the node's scope costs nothing.
    scoped.add_shadow("shadows", hard(&[]).with_casters([crate_node]));
    assert_eq!(plan(&scoped, &request()).passes_named("masks").count(), 0);
    // A box with holes has no inside.
    solid.add_mesh(unit_box("basket"), leaves, at(3.0, 1.0, 0.0));
    solid.add_shadow("shadows", hard(&[("geometry", "closed")]));
    let error = shadow_error(&solid, &request());
    assert!(matches!(&error, ShadowError::Unsupported { .. }));
    assert_names(&error, &["'shadows'", "ShadowVolumeHard", "'basket'", "geometry=closed", "auto, open"]);
}

#[test]
fn blended_casters_are_left_to_others_and_the_plan_says_so() {
    let mut scene = yard();
    let glass = Material { alpha_mode: AlphaMode::Blend, ..Material::default() };
    scene.add_mesh(unit_box("pane"), glass, at(3.0, 1.0, 0.0));
    scene.add_shadow("shadows", hard(&[]));
    let plan = plan(&scene, &request());
    assert!(has_note(&plan, "'pane' casts nothing through 'shadows'"), "{plan}");
    assert!(volume_draws(&plan, "lamp").iter().all(|draw| draw.name.starts_with("crate ")));
}

#[test]
fn unlit_surfaces_cast_nothing() {
    let mut scene = yard();
    let sky = Material { unlit: true, ..Material::default() };
    scene.add_mesh(cuboid("sky", Vec3::splat(50.0)), sky, DAffine3::IDENTITY);
    scene.add_shadow("shadows", hard(&[]));
    assert!(
        volume_draws(&plan(&scene, &request()), "lamp").iter().all(|draw| draw.name.starts_with("crate "))
    );
}

#[test]
fn pictures_of_no_size_or_beyond_the_adapter_are_refused() {
    let scene = shadowed_yard(&[]);
    let limit = Adapter::imagined().max_size_px;
    let sized = |width, height| FrameRequest::new(request().camera, [width, height]);
    for (width, height) in [(0, 48), (64, 0), (0, 0), (limit + 1, 48), (64, limit + 1), (u32::MAX, u32::MAX)]
    {
        let error = try_plan(&scene, &sized(width, height)).unwrap_err();
        assert_eq!(error, FrameError::Size { width, height, limit });
        let text = error.to_string();
        assert!(
            text.contains(&format!("{width}x{height}")) && text.contains(&format!("1 to {limit}")),
            "{text}"
        );
    }
    for (width, height) in [(1, 1), (limit, 1), (1, limit)] {
        assert_eq!(plan(&scene, &sized(width, height)).size_px, [width, height]);
    }
}

#[test]
fn zpass_is_refused_where_the_near_plane_may_be_dark() {
    let scene = shadowed_yard(&[("depthTest", "zpass")]);
    let error = shadow_error(&scene, &request_in_shadow());
    assert_names(&error, &["'shadows'", "depthTest=zpass", "'crate'", "accepted for it: auto, zfail"]);
    assert!(volume_draws(&plan(&scene, &request()), "lamp").iter().all(|draw| !counts_behind(draw)));
    let scene = shadowed_yard(&[("depthTest", "zfail")]);
    assert!(volume_draws(&plan(&scene, &request()), "lamp").iter().all(|draw| counts_behind(draw)));
}

#[test]
fn closed_is_refused_for_what_is_no_solid() {
    let mut scene = shadowed_yard(&[("geometry", "closed")]);
    scene.add_mesh(quad("sheet", 1.0), Material::default(), at(3.0, 1.0, 0.0));
    let error = shadow_error(&scene, &request());
    assert_names(&error, &["'shadows'", "geometry=closed", "'sheet'", "4 unpaired edges", "auto, open"]);
}

#[test]
fn to_bounds_is_refused_where_it_is_not_exact() {
    let mut scene = Scene::new();
    scene.add_mesh(cuboid("room", Vec3::splat(3.0)), Material::default(), DAffine3::IDENTITY);
    scene.add_light(Light::point("lamp", 1.0), DVec3::Y, DVec3::ZERO);
    scene.add_shadow("shadows", hard(&[("extrusion", "toBounds")]));
    let inside = FrameRequest::new(camera(DVec3::new(1.0, 0.0, 2.0), DVec3::ZERO), SIZE_PX);
    let error = shadow_error(&scene, &inside);
    assert_names(&error, &["'shadows'", "extrusion=toBounds", "'room'", "accepted for it: auto, infinite"]);
}

#[test]
fn what_the_adapter_lacks_is_named() {
    let without = |features: Features| Adapter {
        name: "Old GPU",
        features: Features::all() - features,
        max_size_px: 64,
        ..Adapter::imagined()
    };
    let try_without = |features, request: &FrameRequest| {
        let catalog = shadowgraph_nodes::catalog();
        try_plan_with(&shadowed_yard(&[]), request, &catalog, &without(features), &Cache::new())
    };
    let Err(FrameError::Shadow(error)) = try_without(Features::DEPTH32FLOAT_STENCIL8, &request()) else {
        panic!("a stencil is needed")
    };
    assert!(matches!(&error, ShadowError::MissingFeature { .. }));
    assert_names(&error, &["'shadows'", "ShadowVolumeHard", "DEPTH32FLOAT_STENCIL8", "'Old GPU'"]);
    // Clamped depth is needed by orthographic views from within a shadow alone.
    let projection = Projection::Orthographic { half_height_m: 0.2, near_m: 0.0, far_m: 20.0 };
    let ortho = Camera { name: "plan view".into(), projection };
    let (eye, target) = (DVec3::new(0.1, 0.3, 0.1), DVec3::new(3.0, 0.0, 3.0));
    let ortho = FrameRequest::new(CameraSnapshot::looking(ortho, eye, target), SIZE_PX);
    let Err(FrameError::Shadow(error)) = try_without(Features::DEPTH_CLIP_CONTROL, &ortho) else {
        panic!("depth must be clamped")
    };
    assert_names(&error, &["DEPTH_CLIP_CONTROL", "orthographic", "'Old GPU'"]);
    assert!(try_without(Features::empty(), &ortho).is_ok());
    assert!(try_without(Features::DEPTH_CLIP_CONTROL, &request_in_shadow()).is_ok());
}
