//! Plans of `ShadowVolumeSoft`: what they contain and leave out, without a GPU.

use glam::DVec3;
use shadowgraph_engine::plan::FramePlan;
use shadowgraph_engine::render::{Adapter, FrameRequest};
use shadowgraph_engine::scene::{Light, Material, ParamValue, Scene, ShadowNode};
use shadowgraph_engine::shadow::Cache;
use shadowgraph_nodes::ShadowVolumeSoft;
use shadowgraph_testing::*;

fn soft(options: &[(&str, ParamValue)]) -> ShadowNode {
    let node: ShadowNode = ShadowVolumeSoft::default().into();
    options.iter().fold(node, |node, (name, value)| node.with_param(name, value.clone()))
}

fn soft_yard(options: &[(&str, ParamValue)]) -> Scene {
    let mut scene = yard();
    scene.add_shadow("shadows", soft(options));
    scene
}

fn pass_names(plan: &FramePlan) -> Vec<&str> {
    plan.passes.iter().map(|pass| pass.name.as_str()).collect()
}

fn text(value: &str) -> ParamValue {
    ParamValue::Text(value.into())
}

const NO_SIZE: [(&str, ParamValue); 2] =
    [("radius", ParamValue::Number(0.0)), ("angle", ParamValue::Number(0.0))];

#[test]
fn a_light_without_size_has_the_hard_plan() {
    let options = [
        vec![],
        vec![("geometry", "open")],
        vec![("depthTest", "zfail")],
        vec![("counter", "float")],
        vec![("closure", "backfaces")],
    ];
    for options in options {
        for request in [request(), request_in_shadow()] {
            let own = options.iter().map(|(name, value)| (*name, text(value)));
            let all: Vec<(&str, ParamValue)> = NO_SIZE.into_iter().chain(own).collect();
            let [mut soft, mut hard] = [soft_yard(&all), shadowed_yard(&options)].map(|s| plan(&s, &request));
            // The plan says which technique it is by.
            soft.lights.iter_mut().chain(&mut hard.lights).for_each(|light| light.techniques.clear());
            assert_eq!(soft.to_string(), hard.to_string(), "{options:?}");
        }
    }
    // Of the two sizes, each kind of light has its own.
    let mut scene = with_floor();
    add_box(&mut scene, "crate", at(0.0, 1.5, 0.0));
    scene.add_light(Light::directional("sun", 1.0), DVec3::ZERO, DVec3::new(0.2, -1.0, 0.1));
    scene.add_shadow("shadows", soft(&[("angle", ParamValue::Number(0.0))]));
    assert!(has_stencil(&plan(&scene, &request())));
}

#[test]
fn sampled_marks_asks_and_keeps_what_does_not_move() {
    let scene = soft_yard(&[]);
    let of_lamp = [
        "depth prepass",
        "receiver planes",
        "pack soft edges of lamp",
        "pack soft triangles of lamp",
        "pack soft lists of lamp",
        "mark what lamp may light partly",
        "soft shadow of lamp",
        "shading",
    ];
    let plan = plan(&scene, &request());
    assert_eq!(pass_names(&plan), of_lamp, "{plan}");
    assert!(!has_stencil(&plan), "{plan}");
    let kept: Vec<&str> =
        plan.slots.iter().filter(|slot| slot.kept.is_some()).map(|slot| slot.name.as_str()).collect();
    assert_eq!(kept, ["soft edges of lamp", "soft triangles of lamp", "soft lists of lamp"]);
    // The lamp sees the box's top only, and its four edges are all that can be a silhouette.
    let draw = &plan.passes_named("soft shadow").next().expect("it is there").draws[0];
    assert_eq!(draw.name, "4 edges, 12 triangles");
    assert!(
        !plan.slots.iter().any(|slot| slot.name.starts_with("soft clusters")),
        "nothing is near the lamp"
    );
}

#[test]
fn nothing_moved_nothing_computed() {
    let catalog = shadowgraph_nodes::catalog();
    let cache = Cache::new();
    let scene = soft_yard(&[]);
    let keys = |request: &FrameRequest| {
        let plan = try_plan_with(&scene, request, &catalog, &Adapter::imagined(), &cache).expect("a plan");
        let kept: Vec<Option<u64>> =
            plan.slots.iter().map(|slot| slot.kept).filter(Option::is_some).collect();
        (kept, cache.computed())
    };
    let (first, computed) = keys(&request());
    assert_eq!(keys(&request()), (first.clone(), computed));
    // The eye may move: what the light sees stays.
    let elsewhere = FrameRequest::new(camera(DVec3::new(-6.0, 4.0, 8.0), DVec3::ZERO), SIZE_PX);
    assert_eq!(keys(&elsewhere), (first, computed));
}

#[test]
fn without_casters_the_horizon_is_left() {
    let mut scene = with_floor();
    add_box(&mut scene, "far away", at(1e3, 1.5, 0.0));
    add_lamp(&mut scene, "lamp");
    scene.add_shadow("shadows", soft(&[]));
    let plan = plan(&scene, &request());
    let names = [
        "depth prepass",
        "receiver planes",
        "mark what lamp may light partly",
        "soft shadow of lamp",
        "shading",
    ];
    assert_eq!(pass_names(&plan), names, "{plan}");
}

#[test]
fn weight_and_apply_change_the_picture_and_no_factor() {
    let factors = FrameRequest { factors: true, ..request() };
    let of = |options: &[(&str, ParamValue)]| plan(&soft_yard(options), &factors);
    let [full, weighted, darkened] = [
        of(&[]),
        of(&[("weight", ParamValue::Number(0.5))]),
        of(&[("weight", ParamValue::Number(0.5)), ("apply", text("darken"))]),
    ];
    assert_ne!(full.to_string(), weighted.to_string());
    assert_ne!(weighted.to_string(), darkened.to_string());
    let factor = |plan: &FramePlan| {
        let pass = plan.passes_named("factor of lamp").next().expect("it was asked for");
        (pass.reason.clone(), pass.draws.len())
    };
    assert_eq!(factor(&full), factor(&weighted));
    assert_eq!(factor(&full), factor(&darkened));
    // Weighing an unsized light is no other than weighing a hard one.
    let all = NO_SIZE.into_iter().chain([("weight", ParamValue::Number(0.5))]);
    let hard = plan(&soft_yard(&all.collect::<Vec<_>>()), &request());
    assert_ne!(hard.to_string(), plan(&soft_yard(&NO_SIZE), &request()).to_string());
}

/// Samples ask holes in the pass that asks edges; beside areas they have a pass of their own. Without holes, nothing of it is there.
#[test]
fn holes_are_asked_by_samples_in_every_quality() {
    let mask = Material {
        alpha_mode: shadowgraph_engine::scene::AlphaMode::Mask { cutoff: 0.5 },
        ..Material::default()
    };
    for (quality, passes) in [("sampled", 1), ("perReceiver", 2), ("wedge", 2)] {
        let node = ShadowNode::new("ShadowVolumeSoft").with_param("quality", text(quality));
        let mut whole = yard();
        whole.add_shadow("shadows", node);
        let mut leafy = whole.clone();
        leafy.add_mesh(unit_box("leaves"), mask.clone(), at(1.0, 1.0, 0.0));
        let [whole, leafy] = [&whole, &leafy].map(|scene| plan(scene, &request()));
        assert!(!whole.to_string().contains("soft masks"), "{quality}: {whole}");
        assert_eq!(leafy.passes_named("pack soft masks of lamp").count(), 1, "{quality}: {leafy}");
        assert_eq!(leafy.passes_named("soft shadow of lamp").count(), passes, "{quality}: {leafy}");
    }
}

#[test]
fn what_it_refuses_it_names() {
    let number = ParamValue::Number;
    for (option, value, accepted) in [
        ("radius", number(-1.0), "a number from 0 to"),
        ("radius", text("large"), "a number from 0 to"),
        ("angle", number(61.0), "a number from 0 to 60"),
        ("weight", number(2.0), "a number from 0 to 1"),
        ("samples", number(15.0), "a whole number from 16 to 256"),
        ("samples", number(257.0), "a whole number from 16 to 256"),
        ("samples", number(16.5), "a whole number from 16 to 256"),
        ("quality", text("best"), "sampled, perReceiver, wedge"),
        ("geometry", text("soup"), "auto, closed, open"),
        ("closure", text("lid"), "none, cap, backfaces"),
        ("depthTest", text("both"), "auto, zpass, zfail"),
        ("counter", text("stencil16"), "auto, stencil8, float"),
        ("apply", text("twice"), "perPixel, darken"),
        ("sample", number(3.0), "has no option 'sample'"),
    ] {
        let scene = soft_yard(&[(option, value)]);
        let error = try_plan(&scene, &request()).expect_err(option).to_string();
        assert!(error.contains("'shadows'") && error.contains(option) && error.contains(accepted), "{error}");
    }
    let mut open = with_floor();
    open.add_mesh(quad("sheet", 1.0), Material::default(), at(0.0, 2.0, 0.0));
    add_lamp(&mut open, "lamp");
    open.add_shadow("shadows", soft(&[("geometry", text("closed"))]));
    let error = try_plan(&open, &request()).expect_err("open").to_string();
    assert!(error.contains("'sheet' is no solid") && error.contains("auto, open"), "{error}");
}
