//! What is inside shows in the shadow (Kim, Kim & Turk, figure 6): a glass egg with two knots and a core in it. Every
//! surface between a point and the light tints it, so the floor shows the inside as a drawing on tracing paper does.
//!
//! `cargo run --example 13_inner_structure` draws `out/13_inner_structure.png`.

mod common;

use std::error::Error;

use shadowgraph::engine::scene::{AlphaMode, placed};
use shadowgraph::prelude::*;

/// Of a surface (1 − `alpha`)·`color` of the light passes.
fn glass(name: &str, color: Vec3, alpha: f32) -> Material {
    let base_color = color.extend(alpha);
    Material { base_color, alpha_mode: AlphaMode::Blend, roughness: 0.25, ..Material::matt(name, color) }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new();
    let ground = Material::matt("ground", Vec3::splat(0.8));
    scene.add_mesh(Mesh::new(shapes::plane(Vec2::splat(14.0)))?, ground, DAffine3::IDENTITY);

    let place = |y: f64, turn: f64, size: DVec3| {
        placed(DVec3::new(0.0, y, 0.0), DQuat::from_rotation_y(turn) * DQuat::from_rotation_x(0.5), size)
    };
    let shell = glass("shell", Vec3::new(0.86, 0.95, 1.0), 0.08);
    let egg = placed(DVec3::Y * 1.75, DQuat::IDENTITY, DVec3::new(1.0, 1.3, 1.0));
    scene.add_mesh(Mesh::new(shapes::icosphere(1.2, 5))?, shell, egg);
    let outer = glass("outer knot", Vec3::new(1.0, 0.84, 0.62), 0.12);
    let knot = shapes::torus_knot([2, 3], 0.62, 0.1, [320, 20]);
    scene.add_mesh(Mesh::new(knot)?, outer, place(1.75, 0.4, DVec3::ONE));
    let inner = glass("inner knot", Vec3::new(0.68, 0.97, 0.8), 0.12);
    let knot = shapes::torus_knot([3, 4], 0.34, 0.06, [320, 16]);
    scene.add_mesh(Mesh::new(knot)?, inner, place(1.75, -0.3, DVec3::ONE));
    // Opaque casters of the node cast black, through the glass around them too.
    let core = Material::matt("core", Vec3::new(0.5, 0.1, 0.1));
    scene.add_mesh(Mesh::new(shapes::icosphere(0.14, 4))?, core, place(1.75, 0.0, DVec3::ONE));

    scene.add_light(Light::directional("sun", 3.2), DVec3::new(-4.0, 4.2, 1.2), DVec3::ZERO);
    scene.add_shadow("shadows", TransparentShadow::default());

    let camera = Camera::perspective("eye", 0.55);
    let camera = CameraSnapshot::looking(camera, DVec3::new(1.9, 4.6, 8.6), DVec3::new(1.3, 0.9, 0.0));
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    common::picture(&mut renderer, &scene, &camera, Exposure::Fixed(1.0), "13_inner_structure")
}
