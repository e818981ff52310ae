//! Glass under `SoftShadow`: planes are tinted by what passes it, point by point of the light. That it is exact for lights without a
//! size is asked on every hard case in `planar`.

use shadowgraph::engine::scene::{AlphaMode, Image, TextureRef};
use shadowgraph::measure::{ErrorTable, KnownReferences, evaluate_again};
use shadowgraph::prelude::*;
use shadowgraph_testing::renderer;

fn glass(color: Vec3, alpha: f32) -> Material {
    Material { alpha_mode: AlphaMode::Blend, base_color: color.extend(alpha), ..Material::default() }
}

/// Over a floor: two panes that overlap, one with a chequered texture, a box of glass, and an opaque one beside them.
fn yard(node: ShadowNode) -> Scene {
    let mut scene = shadowgraph_testing::with_floor();
    let floor = scene.nodes().next().unwrap().0;
    let texel =
        |i: usize| if (i % 8 + i / 8).is_multiple_of(2) { [200, 40, 40, 160] } else { [250, 250, 120, 60] };
    let image = scene.add_image(std::sync::Arc::new(Image {
        name: "squares".into(),
        width: 8,
        height: 8,
        rgba8: (0..64).flat_map(texel).collect(),
    }));
    let squares = TextureRef { smooth: false, ..TextureRef::new(image) };
    let textured = Material { base_color_texture: Some(squares), ..glass(Vec3::ONE, 1.0) };
    let pane = |name: &str| shadowgraph_testing::quad(name, 0.7);
    scene.add_mesh(pane("squares"), textured, shadowgraph_testing::at(-0.6, 1.2, 0.0));
    scene.add_mesh(
        pane("blue"),
        glass(Vec3::new(0.3, 0.5, 0.9), 0.4),
        shadowgraph_testing::at(0.1, 1.6, 0.4),
    );
    let green = glass(Vec3::new(0.4, 0.9, 0.5), 0.3);
    scene.add_mesh(shadowgraph_testing::unit_box("block"), green, shadowgraph_testing::at(1.4, 0.8, -0.4));
    let body = shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(0.9, 2.0, 1.2));
    // Its own horizon is not the planes' business.
    if let Content::Mesh(mesh) = &mut scene.node_mut(body).unwrap().content {
        mesh.shadow.receives = false;
    }
    shadowgraph_testing::add_lamp(&mut scene, "lamp");
    scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(-0.5, -1.0, -0.2));
    scene.add_shadow("shadows", node.with_receivers([floor]));
    scene
}

fn request() -> FrameRequest {
    FrameRequest::new(
        shadowgraph_testing::camera(DVec3::new(2.5, 5.0, 6.0), DVec3::new(0.2, 0.0, 0.0)),
        [240, 180],
    )
}

#[test]
fn penumbrae_of_glass_converge_to_the_whole_lights() {
    let Some(mut renderer) = renderer() else { return };
    let mut references = KnownReferences::with_samples(1024);
    let mut error = |samples: u32, mode: PlanarMode| {
        let resolution = if mode == PlanarMode::Texture { 512 } else { SoftShadow::default().resolution };
        let node =
            SoftShadow { samples, radius_m: 0.3, angle_deg: 2.0, mode, resolution, ..SoftShadow::default() };
        let scene = yard(node.into());
        let judged = evaluate_again(&mut renderer, &scene, &request(), &mut references, &|_, _| {}).unwrap();
        println!("{samples} {mode:?}\n{}", ErrorTable(&judged.errors));
        assert!(judged.errors.iter().all(|light| light.penumbra_pixels > 300));
        judged.errors.iter().map(|light| light.penumbra_rmse).fold(0.0, f64::max)
    };
    for (samples, bound) in [(16, 0.07), (64, 0.024), (256, 0.01)] {
        let direct = error(samples, PlanarMode::Direct);
        assert!(direct < bound, "{samples}: {direct}");
    }
    let texture = error(64, PlanarMode::Texture);
    assert!(texture < 0.03, "{texture}");
}
