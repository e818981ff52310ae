//! A scene drawn in ink, with one thing in it that is not.

use std::sync::Arc;

use glam::{Vec2, Vec3};
use shadowgraph::engine::geometry::MeshError;
use shadowgraph::prelude::*;

/// The surface function.
pub(crate) const HATCHING: &str = include_str!("hatching.wgsl");
/// Where the ball stands, and its radius.
pub(crate) const BALL: ([f64; 3], f32) = ([1.55, 0.42, 1.0], 0.42);

/// A floor, a box and a knot that reflect by `surface`, and a ball that shines; one light.
pub(crate) fn scene(surface: Option<Arc<SurfaceFunction>>) -> Result<Scene, MeshError> {
    let mut scene = Scene::new();
    // What the picture's tone curve makes of paper.
    scene.set_background(Vec3::new(0.76, 0.70, 0.58));
    scene.set_ambient(Vec3::splat(0.25));
    let floor = Mesh::new(shapes::plane(Vec2::splat(30.0)).named("floor"))?;
    let stand = Mesh::new(shapes::cuboid(Vec3::new(-0.5, 0.0, -0.5), Vec3::new(0.5, 0.7, 0.5)).named("box"))?;
    let knot = Mesh::new(shapes::torus_knot([2, 3], 0.62, 0.17, [400, 32]).named("knot"))?;
    let ball = Mesh::new(shapes::icosphere(BALL.1, 6).named("ball"))?;
    let paper = |color| Material { surface: surface.clone(), ..Material::matt("paper", color) };
    scene.add_mesh(floor, paper(Vec3::ONE), DAffine3::IDENTITY);
    scene.add_mesh(stand, paper(Vec3::new(0.72, 0.76, 0.8)), DAffine3::from_rotation_y(0.5));
    scene.add_mesh(knot, paper(Vec3::ONE), DAffine3::from_translation(DVec3::new(0.0, 1.75, 0.0)));
    let red = Material { roughness: 0.3, ..Material::matt("lacquer", Vec3::new(0.62, 0.03, 0.02)) };
    scene.add_mesh(ball, red, DAffine3::from_translation(DVec3::from(BALL.0)));
    scene.add_light(Light::directional("sun", 2.6), DVec3::ZERO, DVec3::new(3.2, -4.6, -2.2));
    scene.add_shadow("shadows", ShadowVolumeHard::default());
    Ok(scene)
}

/// From where it is drawn.
pub(crate) fn camera() -> CameraSnapshot {
    let camera = Camera::perspective("eye", 0.5);
    CameraSnapshot::looking(camera, DVec3::new(1.9, 3.9, 7.6), DVec3::new(0.75, 1.1, 0.0))
}
