//! The smallest outside technique: as short as it is said to be, and right wherever its balls are balls.

use crate::ball_shadow::BallShadow;
use shadowgraph::engine::shadow::{Registry, ShadowError};
use shadowgraph::measure::{ErrorTable, evaluate, expect_shadow};
use shadowgraph::prelude::*;

/// A floor, and a mesh called `ball` above it, which casts.
fn stage(ball: MeshData, light: Light, shadow: BallShadow) -> Scene {
    let mut scene = Scene::new();
    let mut add = |data: MeshData, place| {
        scene.add_mesh(Mesh::new(data).unwrap(), Material::default(), DAffine3::from_translation(place))
    };
    add(shapes::plane(Vec2::splat(12.0)).named("floor"), DVec3::ZERO);
    let ball = add(ball.named("ball"), DVec3::new(0.2, 0.9, -0.3));
    scene.add_light(light, DVec3::new(-2.0, 4.5, 2.5), DVec3::ZERO);
    scene.add_shadow("balls", ShadowNode::from(shadow).with_casters([ball]));
    scene
}

fn renderer() -> Option<Renderer> {
    let mut catalog = shadowgraph::nodes::catalog();
    catalog.register(BallShadow::ENTRY);
    Some(Renderer::new(shadowgraph_testing::renderer()?.gpu().clone(), catalog))
}

#[test]
fn options_shader_and_all_are_fewer_than_120_lines() {
    let lines = include_str!("../../examples/ball_shadow/mod.rs").lines().count();
    assert!(lines < 120, "{lines} lines");
}

#[test]
fn a_fine_mesh_is_wrong_by_no_more_than_its_facets() {
    let Some(mut renderer) = renderer() else { return };
    let camera = Camera::perspective("eye", 0.8);
    let camera = CameraSnapshot::looking(camera, DVec3::new(2.5, 3.0, 6.0), DVec3::new(0.0, 0.6, 0.0));
    let request = FrameRequest::new(camera, [480, 300]);
    let lights = [
        Light::point("lamp", 40.0),
        Light::directional("sun", 3.0),
        Light::spot("spot", 60.0, 0.5).with_range(20.0),
    ];
    for light in lights {
        let scene = stage(shapes::icosphere(0.6, 5), light, BallShadow::default());
        let evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
        expect_shadow(&evaluation.errors).unwrap();
        // Facets of a 40th of the radius lie less than a thousandth of it inside the ball: a pixel, at the shadow's rim.
        let error = &evaluation.errors[0];
        assert!(error.boundary_distance_max_px <= 1.0, "{}", ErrorTable(&evaluation.errors));
        // At rims and terminators one pixel in twenty of the boundary may fall on the other side.
        assert!(error.wrong * 20 <= error.boundary_pixels, "{}", ErrorTable(&evaluation.errors));
    }
}

#[test]
fn a_margin_makes_shadows_larger() {
    let Some(mut renderer) = renderer() else { return };
    let camera = Camera::perspective("eye", 0.8);
    let camera = CameraSnapshot::looking(camera, DVec3::new(2.5, 3.0, 6.0), DVec3::ZERO);
    let request = FrameRequest { factors: true, ..FrameRequest::new(camera, [160, 100]) };
    let mut dark = |margin_m| {
        let scene = stage(shapes::icosphere(0.6, 3), Light::directional("sun", 3.0), BallShadow { margin_m });
        let frame = renderer.render(&scene, &request, &RenderOptions::default()).unwrap();
        frame.factors[0].pixels.floats().unwrap().iter().filter(|factor| **factor == 0.0).count()
    };
    let (small, large) = (dark(0.0), dark(0.3));
    assert!(large as f64 > 1.5 * small as f64, "{small} and {large} dark pixels");
}

#[test]
fn what_is_no_ball_is_refused_with_its_name() {
    let mut catalog = shadowgraph::nodes::catalog();
    catalog.register(BallShadow::ENTRY);
    let cube = shapes::cuboid(-Vec3::ONE, Vec3::ONE);
    let cylinder = shapes::cylinder(0.4, 1.0, 12, shapes::Ends::Closed);
    // The corners of both lie on a ball.
    for mesh in [cube, cylinder, shapes::torus(0.5, 0.2, 12, 8)] {
        let scene = stage(mesh, Light::point("lamp", 1.0), BallShadow::default());
        let error = Registry::collect(&scene.snapshot().unwrap(), &catalog).unwrap_err();
        assert!(matches!(error, ShadowError::CasterRefused { .. }), "{error}");
        assert!(
            error.to_string().contains("'ball'") && error.to_string().contains("it is no ball"),
            "{error}"
        );
    }
    assert!(
        Registry::collect(
            &stage(shapes::icosphere(0.5, 0), Light::point("lamp", 1.0), BallShadow::default())
                .snapshot()
                .unwrap(),
            &catalog
        )
        .is_ok()
    );
}
