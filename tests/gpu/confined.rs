//! Visibilities are cleared and read only where something darkens them, and no picture changes by that.

use glam::{DVec3, Vec2, Vec3};
use shadowgraph::engine::plan::Load;
use shadowgraph::engine::scene::{AlphaMode, ParamValue, ShadowNode};
use shadowgraph::prelude::*;

/// A wide floor seen from afar, on which a box of glass and one of wood stand near the middle.
fn wide_floor(node: &str, options: &[(&str, &str)], lamps: usize, glass_only: bool) -> Scene {
    let mut scene = Scene::new();
    let floor = shapes::plane(Vec2::splat(20.0)).named("floor");
    let floor = scene.add_mesh(
        shadowgraph_testing::mesh(floor),
        Material::matt("floor", Vec3::splat(0.7)),
        DAffine3::IDENTITY,
    );
    let glass =
        Material { alpha_mode: AlphaMode::Blend, ..Material::matt("glass", Vec3::new(0.4, 0.8, 0.6)) };
    let glass = Material { base_color: Vec3::new(0.4, 0.8, 0.6).extend(0.4), ..glass };
    let cube = |x: f32| shapes::cuboid(Vec3::new(x - 0.4, 0.1, -0.4), Vec3::new(x + 0.4, 0.9, 0.4));
    let glass =
        scene.add_mesh(shadowgraph_testing::mesh(cube(-0.6).named("glass")), glass, DAffine3::IDENTITY);
    let wood = scene.add_mesh(
        shadowgraph_testing::mesh(cube(0.6).named("wood")),
        Material::matt("wood", Vec3::X),
        DAffine3::IDENTITY,
    );
    for i in 0..lamps {
        let lamp = Light::point(&format!("lamp {i}"), 160.0);
        scene.add_light(lamp, DVec3::new(3.0 - 2.0 * i as f64, 7.0, 2.0), DVec3::ZERO);
    }
    let mut node =
        ShadowNode::new(node).with_casters(if glass_only { vec![glass] } else { vec![glass, wood] });
    for (name, value) in options {
        let value = value.parse().map_or(ParamValue::Text((*value).into()), ParamValue::Number);
        node.params.insert((*name).into(), value);
    }
    let planar = node.technique == "SoftShadow";
    scene.add_shadow("shadows", if planar { node.with_receivers([floor]) } else { node });
    scene
}

#[test]
fn no_picture_changes_where_visibilities_are_confined() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let eye = shadowgraph_testing::camera(DVec3::new(6.0, 9.0, 14.0), DVec3::ZERO);
    let mut confined = 0;
    for (node, options) in [
        ("ShadowVolumeHard", &[][..]),
        ("ShadowVolumeSoft", &[]),
        ("ShadowVolumeSoft", &[("quality", "perReceiver")]),
        ("ShadowVolumeSoft", &[("quality", "wedge")]),
        ("SoftShadow", &[]),
        ("SoftShadow", &[("mode", "direct")]),
        ("TransparentShadow", &[]),
        ("TransparentShadow", &[("selfShadow", "partial")]),
        ("TransparentShadow", &[("selfShadow", "none")]),
        ("TransparentShadow", &[("accumulate", "log16"), ("selfShadow", "none")]),
    ] {
        for (lamps, glass_only) in [(1, false), (1, true), (2, true)] {
            let scene = wide_floor(node, options, lamps, glass_only);
            let request = FrameRequest {
                picture: PictureFormat::LinearF32,
                ..FrameRequest::new(eye.clone(), [320, 180])
            };
            let whole = FrameRequest { factors: true, ..request.clone() };
            let mut drawn = |request: &FrameRequest| {
                let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
                // Once with something else left in the textures.
                let away = shadowgraph_testing::camera(DVec3::new(0.0, 2.0, 3.0), DVec3::ZERO);
                renderer.render(&scene, &FrameRequest { camera: away, ..request.clone() }, &options).unwrap();
                let frame = renderer.render(&scene, request, &options).unwrap();
                (frame.picture.unwrap().floats().unwrap(), frame.plan)
            };
            let ((own, plan), (wanted, with_factors)) = (drawn(&request), drawn(&whole));
            assert_eq!(with_factors.shadowed_px, [0, 0, 320, 180], "images of factors hold all pixels");
            assert!(own == wanted, "{node} {options:?}, {lamps} lamps: the picture differs\n{plan}");
            let colors = plan.passes.iter().flat_map(|pass| &pass.colors);
            let is_confined = plan.shadowed_px != [0, 0, 320, 180];
            assert_eq!(
                colors.filter(|color| matches!(color.load, Load::ClearWithin(..))).count() > 0,
                is_confined,
                "{plan}"
            );
            confined += usize::from(is_confined);
        }
    }
    assert!(confined >= 8, "{confined} are confined");
}
