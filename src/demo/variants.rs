//! A scene with other lights.

use std::f64::consts::TAU;

use glam::DVec3;
use shadowgraph_engine::scene::{Content, Light, Scene};

/// The scene with `count` lamps in a ring above it in place of its lights; they give as much light together, however many.
pub fn under_lamps(scene: &Scene, count: u32) -> Scene {
    let mut scene = scene.emptied_of(|content| matches!(content, Content::Light(_)));
    for i in 0..count {
        let angle_rad = TAU * f64::from(i) / f64::from(count) + 0.6;
        let place = DVec3::new(3.6 * angle_rad.cos(), 6.5, 3.6 * angle_rad.sin());
        scene.add_light(Light::point(&format!("lamp{i}"), 160.0 / count as f32), place, DVec3::ZERO);
    }
    scene
}
