//! How wrong is it? Every light's factor is compared with an exact reference, pixel by pixel.
//!
//! `cargo run --example 07_how_wrong` prints the error table, draws `out/07_how_wrong.png`, and writes for each light
//! the factor (`out/07_how_wrong-<light>.exr`, linear, NaN where nothing is) and the error map (`….png`: leaks red,
//! false shadows blue, pixels that rounding may decide either way yellow).
#![allow(clippy::print_stdout, reason = "printing the error table is what it is for")]

mod common;

use std::error::Error;

use shadowgraph::measure::{ErrorTable, evaluate, expect_shadow, pictures};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [640, 360];

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let clay = Material::matt("clay", Vec3::new(0.7, 0.55, 0.42));
    scene.add_mesh(Mesh::new(shapes::plane(Vec2::splat(40.0)))?, clay.clone(), DAffine3::IDENTITY);
    let knot = Mesh::new(shapes::torus_knot([3, 4], 0.75, 0.13, [320, 20]))?;
    let tilt = DAffine3::from_rotation_x(0.35) * DAffine3::from_rotation_y(0.5);
    scene.add_mesh(knot, clay.clone(), DAffine3::from_translation(DVec3::Y * 1.5) * tilt);
    // An open, twisted band: there is no inside, and every edge of its rim casts.
    let band = shapes::sheet(160, 8, |u, v| {
        let (angle, half) = (u * std::f32::consts::TAU, v * 0.5 - 0.25);
        let (ring, lift) = (2.0 + half * (angle * 1.5).cos(), half * (angle * 1.5).sin());
        Vec3::new(ring * angle.cos(), 0.7 + lift, -ring * angle.sin())
    });
    scene.add_mesh(Mesh::new(band.named("band"))?, clay, DAffine3::IDENTITY);
    let lamp = Light::point("lamp", 40.0).with_color(Vec3::new(1.0, 0.8, 0.6));
    scene.add_lamp(lamp, DVec3::new(-2.5, 4.5, 1.5));
    let moon = Light::directional("moon", 1.0).with_color(Vec3::new(0.55, 0.7, 1.0));
    scene.add_light(moon, DVec3::new(3.0, 4.0, -1.0), DVec3::ZERO);
    scene.add_shadow("shadows", ShadowVolumeHard::default());

    let camera = Camera::perspective("eye", 0.66);
    let camera = CameraSnapshot::looking(camera, DVec3::new(0.4, 4.2, 6.6), DVec3::new(0.0, 0.7, 0.0));
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(1.3), "07_how_wrong")?;

    // Renders again, with one factor image for each light, and traces the same pixels in f64.
    let request = FrameRequest::new(camera, SIZE_PX);
    let evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {})?;
    println!("{}", ErrorTable(&evaluation.errors));
    // An error of 0 says something only where there was a shadow to get wrong.
    expect_shadow(&evaluation.errors)?;

    for (light, factor) in &evaluation.measured.lights {
        let path = common::out_dir()?.join(format!("07_how_wrong-{light}"));
        pictures::write_factor(&path.with_extension("exr"), SIZE_PX, factor)?;
        let map = path.with_extension("png");
        pictures::write_error_map(&map, &evaluation.measured, &evaluation.reference, light)?;
        println!("{} and .exr: error map and factor of '{light}'", map.display());
    }
    Ok(())
}
