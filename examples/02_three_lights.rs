//! Three lights of three kinds: a directional moon, a point lamp that ends at its range, and a spot with its cone.
//! Every light has a shadow of its own; where one is blocked, the others still colour the ground.
//!
//! `cargo run --example 02_three_lights` draws `out/02_three_lights.png`.
#![allow(clippy::print_stdout, reason = "it tells what the lights are")]

mod common;

use std::error::Error;

use shadowgraph::engine::geometry::shapes::Ends;
use shadowgraph::engine::scene::LightKind;
use shadowgraph::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let white = Material::matt("white", Vec3::splat(0.78));
    let at = |x: f64, y: f64, z: f64| DAffine3::from_translation(DVec3::new(x, y, z));
    scene.add_mesh(Mesh::new(shapes::plane(Vec2::splat(14.0)))?, white.clone(), DAffine3::IDENTITY);
    // A ring of columns, every other one higher, around a ball.
    for i in 0..8 {
        let angle = f64::from(i) / 8.0 * std::f64::consts::TAU + 0.2;
        let height = if i % 2 == 0 { 1.5 } else { 0.8 };
        let column = Mesh::new(shapes::cylinder(0.14, height, 64, Ends::Closed))?;
        scene.add_mesh(column, white.clone(), at(1.7 * angle.cos(), 0.0, 1.7 * angle.sin()));
    }
    scene.add_mesh(Mesh::new(shapes::icosphere(0.45, 5))?, white, at(0.0, 0.45, 0.0));

    // Parallel light everywhere, in lux; it shines from its position towards its target.
    let moon = Light::directional("moon", 1.1).with_color(Vec3::new(0.3, 0.45, 1.0));
    scene.add_light(moon, DVec3::new(-3.0, 4.0, -5.0), DVec3::ZERO);
    // Light from one point, in candela. It fades to nothing at its range, and beyond it there is no shadow to draw.
    let lamp = Light::point("lamp", 6.0).with_color(Vec3::new(1.0, 0.62, 0.25)).with_range(6.5);
    scene.add_lamp(lamp, DVec3::new(-0.7, 1.7, 1.0));
    // Light within a cone, in candela; the angle is from the axis to the edge.
    let spot = Light::spot("spot", 42.0, 0.34).with_color(Vec3::new(1.0, 0.25, 0.5));
    scene.add_light(spot, DVec3::new(5.0, 4.2, 0.5), DVec3::new(0.6, 0.0, 0.0));
    scene.add_shadow("shadows", ShadowVolumeHard::default());

    for (_, light) in scene.lights() {
        let kind = match light.kind {
            LightKind::Directional => "parallel, lux".to_owned(),
            LightKind::Point => "from a point, candela".to_owned(),
            LightKind::Spot { outer_rad, .. } => {
                format!("within {:.0} degrees, candela", outer_rad.to_degrees())
            }
        };
        let range = light.range_m.map_or("no end".into(), |m| format!("ends at {m} m"));
        println!("{:5} {:5} {kind}, {range}", light.name, light.intensity);
    }
    let camera = Camera::perspective("eye", 0.62);
    let camera = CameraSnapshot::looking(camera, DVec3::new(0.6, 5.2, 7.4), DVec3::new(0.1, 0.1, 0.2));
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(1.4), "02_three_lights")
}
