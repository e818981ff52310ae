//! Small scenes and the error tables of shadow nodes over them.

use glam::Vec3;
use shadowgraph::measure::{ErrorTable, LightError, evaluate};
use shadowgraph::prelude::*;

use shadowgraph_testing::mesh;

/// The frames of these tests, in pixels.
pub(crate) const SIZE_PX: [u32; 2] = [256, 256];

pub(crate) fn p(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// The box around `center` reaching `half` to each side, without the faces numbered in `missing` (x+, x−, y+, y−,
/// z+, z−).
pub(crate) fn open_box(name: &str, center: [f32; 3], half: f32, missing: &[usize]) -> MeshData {
    let center = Vec3::from(center);
    shapes::cuboid(center - half, center + half)
        .without_triangles(|triangle| missing.contains(&(triangle / 2)))
        .named(name)
}

/// A scene of meshes that cast and receive, lit by point lights.
pub(crate) fn scene(meshes: Vec<MeshData>, lights: &[DVec3]) -> Scene {
    let mut scene = Scene::new();
    for data in meshes {
        scene.add_mesh(mesh(data), Material::default(), DAffine3::IDENTITY);
    }
    for (index, position) in lights.iter().enumerate() {
        scene.add_light(Light::point(&format!("light{index}"), 30.0), *position, DVec3::ZERO);
    }
    scene
}

/// A floor of 8 m at height 0.
pub(crate) fn floor() -> MeshData {
    shapes::plane(Vec2::splat(4.0)).named("floor")
}

/// The scene with a node over everything.
pub(crate) fn with_node(scene: &Scene, node: ShadowVolumeHard) -> Scene {
    let mut scene = scene.clone();
    scene.add_shadow("shadows", node);
    scene
}

pub(crate) fn request(eye: DVec3, target: DVec3) -> FrameRequest {
    let camera = Camera::perspective("eye", 50_f64.to_radians());
    FrameRequest::new(CameraSnapshot::looking(camera, eye, target), SIZE_PX)
}

/// The errors of every light, printed as a table.
pub(crate) fn errors(
    renderer: &mut Renderer,
    what: &str,
    scene: &Scene,
    request: &FrameRequest,
) -> Vec<LightError> {
    let evaluation = evaluate(renderer, scene, request, &|_, _| {}).unwrap();
    println!("{what}\n{}", ErrorTable(&evaluation.errors));
    for error in &evaluation.errors {
        let (dark, lit) = (error.shadow_pixels > 0, error.shadow_pixels < error.compared);
        assert!(dark && lit, "{what}: no shadow to get wrong");
    }
    evaluation.errors
}
