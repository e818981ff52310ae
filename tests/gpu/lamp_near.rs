//! A lamp off a box's face, edge and corner by ever less, and on them: the box's shadow is exact all the way.

use glam::{DVec3, Vec2, Vec3};
use shadowgraph::engine::geometry::shapes::{cuboid, plane};
use shadowgraph::engine::math::Projection;
use shadowgraph::measure::{ErrorTable, evaluate};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [96, 72];

/// A box of 1 m over a floor, and a lamp.
fn yard(lamp: DVec3) -> Scene {
    let mut scene = Scene::new();
    let half = Vec3::splat(0.5);
    let middle = Vec3::new(0.0, 1.0, 0.0);
    for data in [plane(Vec2::splat(4.0)), cuboid(middle - half, middle + half)] {
        scene.add_mesh(shadowgraph_testing::mesh(data), Material::default(), DAffine3::IDENTITY);
    }
    scene.add_light(Light::point("lamp", 40.0), lamp, DVec3::ZERO);
    scene.add_shadow("shadows", ShadowVolumeHard::default());
    scene
}

#[test]
fn from_a_millimetre_to_a_millionth_of_a_micrometre_nothing_is_wrong() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let (eye, target) = (DVec3::new(3.0, 4.0, 5.0), DVec3::new(0.0, 0.6, 0.0));
    let perspective = Camera::perspective("perspective", 0.8);
    let orthographic = Projection::Orthographic { half_height_m: 2.5, near_m: 0.1, far_m: 20.0 };
    let orthographic = Camera { name: "orthographic".into(), projection: orthographic };
    let places = [
        ("face", DVec3::new(0.2, 1.5, 0.1), DVec3::Y),
        ("side", DVec3::new(0.5, 1.2, 0.1), DVec3::X),
        ("edge", DVec3::new(0.5, 1.5, 0.1), DVec3::new(1.0, 1.0, 0.0).normalize()),
        ("corner", DVec3::new(0.5, 1.5, 0.5), DVec3::ONE.normalize()),
    ];
    let gaps = (3..=12).map(|power| 10_f64.powi(-power)).chain([0.0]);
    let (mut frames, mut wrong) = (0, Vec::new());
    for gap_m in gaps {
        for (name, place, out) in places {
            for camera in [&perspective, &orthographic] {
                let view = CameraSnapshot::looking(camera.clone(), eye, target);
                let request = FrameRequest::new(view, SIZE_PX);
                let found =
                    evaluate(&mut renderer, &yard(place + out * gap_m), &request, &|_, _| {}).unwrap();
                assert!(found.errors[0].compared > 2000, "{}", ErrorTable(&found.errors));
                frames += 1;
                if !found.errors[0].passes() {
                    let table = ErrorTable(&found.errors);
                    wrong.push(format!("{gap_m:e} m off a {name}, {}:\n{table}", camera.name));
                }
            }
        }
    }
    assert_eq!(frames, 88);
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}
