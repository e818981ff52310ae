//! Several techniques over different casters of one light: what is left of it is the product of what each leaves.

use glam::{DVec3, Vec2, Vec3};
use shadowgraph::engine::scene::{AlphaMode, NodeKey, ParamValue};
use shadowgraph::measure::{ErrorTable, evaluate};
use shadowgraph::prelude::*;

/// A floor, a box of wood and two tinted panes, one of them behind the box, under one lamp.
struct Yard {
    scene: Scene,
    floor: NodeKey,
    wood: NodeKey,
    panes: [NodeKey; 2],
}

fn yard() -> Yard {
    let mut scene = Scene::new();
    let mut add = |data: MeshData, material: Material| {
        scene.add_mesh(shadowgraph_testing::mesh(data), material, DAffine3::IDENTITY)
    };
    let floor = add(shapes::plane(Vec2::splat(3.0)).named("floor"), Material::matt("floor", Vec3::ONE));
    let cube = shapes::cuboid(Vec3::new(-0.5, 0.4, -0.4), Vec3::new(0.3, 1.1, 0.4)).named("wood");
    let wood = add(cube, Material::matt("wood", Vec3::X));
    let tinted = |color: Vec3| Material {
        alpha_mode: AlphaMode::Blend,
        base_color: color.extend(0.5),
        ..Material::matt("tinted", color)
    };
    let pane = |x: f32, y: f32| {
        let at = |dx: f32, dz: f32| Vec3::new(x + dx, y + 0.2 * dx, dz);
        shapes::quad([at(-0.7, 0.6), at(0.7, 0.6), at(0.7, -0.6), at(-0.7, -0.6)]).named("pane")
    };
    let panes = [(0.6, 0.9, Vec3::new(0.2, 0.9, 0.4)), (0.1, 1.6, Vec3::new(0.9, 0.5, 0.1))]
        .map(|(x, y, color)| add(pane(x, y), tinted(color)));
    scene.add_light(Light::point("lamp", 60.0), DVec3::new(0.8, 4.0, 0.5), DVec3::ZERO);
    Yard { scene, floor, wood, panes }
}

fn request() -> FrameRequest {
    FrameRequest::new(shadowgraph_testing::camera(DVec3::new(2.5, 5.0, 4.0), DVec3::ZERO), [200, 150])
}

/// The wood by `technique`, the panes by [`TransparentShadow`]; on opaque surfaces.
fn shared(technique: &str, options: &[(&str, &str)]) -> Scene {
    let Yard { mut scene, floor, wood, panes } = yard();
    let mut node = ShadowNode::new(technique).with_casters([wood]);
    for (name, value) in options {
        let value = value.parse().map_or(ParamValue::Text((*value).into()), ParamValue::Number);
        node.params.insert((*name).into(), value);
    }
    if technique == "SoftShadow" {
        node = node.with_receivers([floor]);
    }
    scene.add_shadow("wood", node);
    let glass = TransparentShadow { self_shadow: SelfShadow::None, ..TransparentShadow::default() };
    scene.add_shadow("glass", ShadowNode::from(glass).with_casters(panes));
    scene
}

#[test]
fn glass_multiplies_what_other_nodes_leave() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (technique, options, most) in [
        ("ShadowVolumeHard", &[][..], 0.0),
        ("ShadowVolumeSoft", &[("radius", "0.2")], 0.0),
        ("ShadowVolumeSoft", &[("radius", "0.2"), ("samples", "256")], 0.0),
        ("ShadowVolumeSoft", &[("radius", "0.2"), ("quality", "perReceiver")], 0.004),
        ("SoftShadow", &[("radius", "0.2"), ("samples", "256"), ("mode", "direct")], 0.02),
    ] {
        let scene = shared(technique, options);
        let found = evaluate(&mut renderer, &scene, &request(), &|_, _| {}).unwrap();
        let [error] = &found.errors[..] else { panic!("one light") };
        let table = ErrorTable(&found.errors).to_string();
        let name = format!("{technique} {options:?}");
        if most == 0.0 {
            assert!(error.passes(), "{name}:\n{table}");
        } else {
            assert!(error.rmse < most, "{name}:\n{table}");
        }
        // Colours are there, and so is what the wood alone would leave.
        let factors = &found.measured.lights[0].1;
        let colored = factors.chunks_exact(3).filter(|f| (f[0] - f[1]).abs() > 0.05).count();
        let dark = factors.chunks_exact(3).filter(|f| f.iter().all(|c| *c < 0.3)).count();
        assert!(colored > 1000 && dark > 100, "{name}: {colored} coloured, {dark} dark");
    }
}

#[test]
fn a_light_with_a_size_is_judged_on_layers() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let Yard { mut scene, wood, panes, .. } = yard();
    scene.add_shadow("wood", ShadowNode::new("ShadowVolumeSoft").with_casters([wood]));
    scene.add_shadow("glass", ShadowNode::from(TransparentShadow::default()).with_casters(panes));
    let plan = renderer.plan(&scene, &request()).unwrap();
    assert!(plan.layers > 1, "{plan}");
    let layers = shadowgraph::measure::evaluate_layers(&mut renderer, &scene, &request(), 0..2, &|_, _| {});
    for layer in layers.unwrap() {
        for error in &layer.errors {
            assert!(error.compared > 0 && error.passes(), "layer {}: {error:?}", layer.layer);
        }
    }
}
