//! The smallest whole technique: a row of balls, from coarse to fine, all with round shadows. See `ball_shadow/` for the
//! technique, which takes fewer than 120 lines with its options and its shader.
//!
//! `cargo run --example 18_ball_shadow` draws `out/18_ball_shadow.png`.
#![allow(clippy::print_stdout, reason = "it tells where the picture is")]

mod ball_shadow;
mod common;

use std::error::Error;

use ball_shadow::BallShadow;
use shadowgraph::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let floor = Mesh::new(shapes::plane(Vec2::splat(10.0)).named("floor"))?;
    scene.add_mesh(floor, Material::matt("floor", Vec3::splat(0.7)), DAffine3::IDENTITY);
    let mut balls = Vec::new();
    for detail in 0..5 {
        let ball = Mesh::new(shapes::icosphere(0.4, detail).named("ball"))?;
        let paint = Material::matt("paint", Vec3::new(0.8, 0.15 * f64::from(detail) as f32, 0.05));
        let place = DAffine3::from_translation(DVec3::new(f64::from(detail) - 2.0, 0.75, 0.0));
        balls.push(scene.add_mesh(ball, paint, place));
    }
    scene.add_lamp(Light::point("lamp", 45.0), DVec3::new(-1.0, 5.0, 2.5));
    scene.add_light(Light::directional("sky", 0.6), DVec3::new(3.0, 2.0, 1.0), DVec3::ZERO);
    scene.add_shadow("balls", ShadowNode::from(BallShadow::default()).with_casters(balls));

    let mut catalog = shadowgraph::nodes::catalog();
    catalog.register(BallShadow::ENTRY);
    let mut renderer = common::renderer(catalog)?;
    let camera = Camera::perspective("eye", 0.6);
    let camera = CameraSnapshot::looking(camera, DVec3::new(0.5, 3.0, 6.5), DVec3::new(0.0, 0.3, 0.0));
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(0.9), "18_ball_shadow")
}
