//! Scenes with textures, holes and several parts: the leaf cards of the demo, and models with the materials of real files.
//! No pixel outside the ambiguity band may be wrong.

use glam::Vec2;
use shadowgraph::demo;
use shadowgraph::engine::geometry::shapes::plane;
use shadowgraph::engine::gltf;
use shadowgraph::engine::scene::ShadowFlags;
use shadowgraph::measure::{evaluate, expect_shadow};
use shadowgraph::prelude::*;

/// Judges the frame, prints a row for each light.
fn judge(name: &str, renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) {
    let found = evaluate(renderer, scene, request, &|_, _| {}).unwrap();
    for error in &found.errors {
        println!(
            "{name:<14} {:<8} wrong {} of {}, out of band {}, band {} of boundary {}",
            error.name,
            error.wrong,
            error.compared,
            error.wrong_outside_band,
            error.band_pixels,
            error.boundary_pixels
        );
        assert!(error.passes(), "{name}: {error:?}");
    }
    expect_shadow(&found.errors).unwrap();
}

#[test]
fn leaf_cards_cast_texel_by_texel() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let (_, _, scene) = demo::all().into_iter().find(|(stem, ..)| *stem == "foliage").unwrap();
    let camera = scene.snapshot().unwrap().cameras[0].clone();
    for size_px in [[480, 270], [301, 333]] {
        judge("foliage", &mut renderer, &scene, &FrameRequest::new(camera.clone(), size_px));
    }
}

#[test]
fn real_materials_cast_like_any_other() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (file, lamp, eye, target) in [
        (
            "FlightHelmet/FlightHelmet.gltf",
            DVec3::new(1.2, 1.6, 1.4),
            DVec3::new(0.75, 0.6, 1.1),
            DVec3::Y * 0.32,
        ),
        (
            "craft_speederD/craft_speederD.gltf",
            DVec3::new(3.0, 6.5, 2.0),
            DVec3::new(3.0, 2.5, 4.0),
            DVec3::Y * 0.5,
        ),
    ] {
        let Some(path) = shadowgraph_testing::model(file) else { continue };
        let mut scene = gltf::load(&path).unwrap().scene;
        let (mesh, material) = (
            scene.add_mesh_data(std::sync::Arc::new(shadowgraph_testing::mesh(
                plane(Vec2::splat(3.0)).named("floor"),
            ))),
            scene.add_material(Material::default()),
        );
        let shadow = ShadowFlags { casts: false, receives: true };
        let floor = MeshNode { shadow, ..MeshNode::new(mesh, material) };
        scene.add(None, "floor", DAffine3::IDENTITY, Content::Mesh(floor));
        scene.add_light(Light::point("lamp", 30.0), lamp, DVec3::ZERO);
        scene.add_shadow("shadows", ShadowVolumeHard::default());
        let camera = Camera::perspective("eye", 32_f64.to_radians());
        let camera = CameraSnapshot::looking(camera, eye, target);
        judge(
            file.split('/').next().unwrap(),
            &mut renderer,
            &scene,
            &FrameRequest::new(camera, [1280, 720]),
        );
    }
}
