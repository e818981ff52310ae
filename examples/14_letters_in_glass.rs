//! Letters in a glass box (Kim, Kim & Turk, figure 7): the shadow of the letters lies on the floor, tinted by the box, and
//! two lamps tint it twice.
//!
//! `cargo run --example 14_letters_in_glass` draws `out/14_letters_in_glass.png`.

mod common;

use std::error::Error;

use shadowgraph::engine::scene::AlphaMode;
use shadowgraph::prelude::*;

/// Of a surface (1 − `alpha`)·`color` of the light passes.
fn glass(name: &str, color: Vec3, alpha: f32) -> Material {
    let base_color = color.extend(alpha);
    Material { base_color, alpha_mode: AlphaMode::Blend, roughness: 0.2, ..Material::matt(name, color) }
}

/// The outline of a letter in a box of width 1 and height 1.5, counter-clockwise.
fn outline(letter: char) -> Vec<Vec2> {
    let points: &[[f32; 2]] = match letter {
        'T' => &[
            [0.38, 0.0],
            [0.62, 0.0],
            [0.62, 1.26],
            [1.0, 1.26],
            [1.0, 1.5],
            [0.0, 1.5],
            [0.0, 1.26],
            [0.38, 1.26],
        ],
        'I' => &[[0.38, 0.0], [0.62, 0.0], [0.62, 1.5], [0.38, 1.5]],
        'N' => &[
            [0.0, 0.0],
            [0.24, 0.0],
            [0.24, 1.02],
            [0.76, 0.0],
            [1.0, 0.0],
            [1.0, 1.5],
            [0.76, 1.5],
            [0.76, 0.48],
            [0.24, 1.5],
            [0.0, 1.5],
        ],
        _ => &[],
    };
    points.iter().map(|p| Vec2::from(*p)).collect()
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let ground = Material::matt("ground", Vec3::splat(0.8));
    scene.add_mesh(Mesh::new(shapes::plane(Vec2::splat(14.0)))?, ground, DAffine3::IDENTITY);

    let tints = [
        Vec3::new(1.0, 0.3, 0.2),
        Vec3::new(1.0, 0.85, 0.2),
        Vec3::new(0.3, 0.85, 0.35),
        Vec3::new(0.3, 0.5, 1.0),
    ];
    for ((letter, tint), i) in "TINT".chars().zip(tints).zip(0..) {
        let prism = shapes::extruded(&outline(letter), -0.15, 0.15);
        let left = -2.35 + 1.2 * i as f32;
        let prism = prism.moved(Vec3::new(left, 0.35, 0.0)).named(&letter.to_string());
        scene.add_mesh(Mesh::new(prism)?, glass("letter", tint, 0.25), DAffine3::IDENTITY);
    }
    let case = shapes::cuboid(Vec3::new(-2.7, 0.02, -0.6), Vec3::new(2.7, 2.2, 0.6)).named("case");
    scene.add_mesh(Mesh::new(case)?, glass("case", Vec3::new(0.85, 0.95, 1.0), 0.08), DAffine3::IDENTITY);

    scene.add_lamp(Light::point("left lamp", 120.0), DVec3::new(-3.2, 5.2, -3.4));
    scene.add_lamp(Light::point("right lamp", 80.0), DVec3::new(4.4, 4.8, -3.0));
    scene.add_shadow("shadows", TransparentShadow::default());

    let camera = Camera::perspective("eye", 0.6);
    let camera = CameraSnapshot::looking(camera, DVec3::new(0.6, 4.6, 8.8), DVec3::new(0.1, 0.5, 0.9));
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(1.0), "14_letters_in_glass")
}
