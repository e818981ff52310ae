//! A young tree of leaf cards: shadows of what a texture leaves of them.

use std::f32::consts::TAU;

use glam::{DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{lathe, plane, quad, sheet};
use shadowgraph_engine::scene::{Camera, Light, Scene, ShadowNode};

use shadowgraph_measure::cases::strewn::noise;

use super::set::{Set, stand};

const CARDS: u32 = 260;
const CARDS_PER_BOUGH: u32 = 52;

/// A twig with seven leaves: how much of it is at this place, (0, 0) at the top left; its midribs are darker.
fn twig(x: u32, y: u32) -> [u8; 4] {
    let p = Vec2::new((x as f32 + 0.5) / 64.0 - 1.0, 1.0 - (y as f32 + 0.5) / 64.0);
    // Distances in units of half the picture: to the stem, and to leaves along it.
    let mut inside = 0.035 - p.x.abs();
    if p.y > 0.55 {
        inside = -1.0;
    }
    let mut rib = false;
    for i in 0..7_u32 {
        let side = if i == 6 {
            0.0
        } else if i % 2 == 0 {
            1.0
        } else {
            -1.0
        };
        let foot = Vec2::new(0.0, -0.75 + 0.2 * i as f32);
        let along = Vec2::new(side * 0.85, 0.55).normalize_or(Vec2::Y);
        let from_foot = p - foot;
        let (u, v) = (from_foot.dot(along) / 0.72, from_foot.dot(along.perp()));
        let width = 0.2 * (u.clamp(0.0, 1.0) * std::f32::consts::PI).sin().powf(0.8);
        let leaf = if (0.0..1.0).contains(&u) { width - v.abs() } else { -1.0 };
        if leaf > inside {
            inside = leaf;
            rib = v.abs() < 0.015;
        }
    }
    let shade = if rib { 0.7 } else { 1.0 } * (0.85 + 0.15 * noise(y * 128 + x));
    let [r, g, b] = [88.0, 138.0, 46.0].map(|channel| (channel * shade) as u8);
    [r, g, b, ((0.5 + inside * 32.0).clamp(0.0, 1.0) * 255.0) as u8]
}

/// One bough's cards around the crown's middle, each bent a little.
fn bough(number: u32) -> MeshData {
    let cards = (0..CARDS_PER_BOUGH).map(|i| {
        let seed = number * CARDS_PER_BOUGH + i;
        // Spread over a sphere, drawn in towards the trunk.
        let (height, turn) = (1.0 - 2.0 * (seed as f32 + 0.5) / CARDS as f32, seed as f32 * 2.399_963);
        let ring = (1.0 - height * height).sqrt();
        let out = Vec3::new(ring * turn.cos(), height * 0.9, ring * turn.sin());
        let middle = out * (0.28 + 0.6 * noise(seed + 900).sqrt()) + Vec3::Y * 1.75;
        let size = 0.17 + 0.09 * noise(seed + 1800);
        let up =
            (out + Vec3::new(noise(seed + 2700) - 0.5, 0.35, noise(seed + 3600) - 0.5)).normalize_or(Vec3::Y);
        let spin = noise(seed + 4500) * TAU;
        let (right, across) = up.any_orthonormal_pair();
        let right = right * spin.cos() + across * spin.sin();
        let bend = up.cross(right) * 0.25 * size;
        sheet(1, 2, move |u, v| {
            let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
            middle + right * (x * size) + up * (y * size) + bend * (1.0 - y * y)
        })
    });
    MeshData::merged("bough", cards)
}

pub(super) fn foliage() -> Scene {
    let mut set = Set::new();
    let group = set.scene.add_group("garden");
    let gravel = set.paint("gravel", [0.62, 0.58, 0.5], 0.95);
    let plaster = set.paint("plaster", [0.78, 0.72, 0.63], 0.95);
    let bark = set.paint("bark", [0.16, 0.1, 0.06], 0.9);
    let clay = set.paint("terracotta", [0.46, 0.17, 0.085], 0.8);
    let leaves = set.cutout("twig", [128, 128], 0.55, twig);
    set.put(group, "ground", plane(Vec2::splat(7.0)), gravel, stand(0.0, 0.0, 0.0, 0.0));
    let wall = [[-7.0, 0.0], [7.0, 0.0], [7.0, 4.5], [-7.0, 4.5]].map(|[x, y]| Vec3::new(x, y, -1.9));
    set.put(group, "wall", quad(wall), plaster, stand(0.0, 0.0, 0.0, 0.0));
    let trunk = [[0.07, 0.3], [0.045, 1.2], [0.03, 2.2], [0.0, 2.3]].map(Vec2::from);
    set.put(group, "trunk", lathe(&trunk, 16), bark, stand(0.0, 0.0, 0.0, 0.0));
    let pot = [[0.0, 0.0], [0.26, 0.0], [0.34, 0.42], [0.3, 0.42], [0.28, 0.33], [0.0, 0.33]].map(Vec2::from);
    set.put(group, "pot", lathe(&pot, 48), clay, stand(0.0, 0.0, 0.0, 0.0));
    for number in 0..CARDS / CARDS_PER_BOUGH {
        set.put(group, "leaves", bough(number), leaves, stand(0.0, 0.0, 0.0, 0.0));
    }

    let sun = Light::directional("sun", 4.0).with_color(Vec3::new(1.0, 0.93, 0.8));
    set.scene.add_light(sun, DVec3::ZERO, DVec3::new(0.75, -1.0, -0.62));
    let lamp = Light::point("lamp", 9.0).with_color(Vec3::new(0.55, 0.7, 1.0));
    set.scene.add_light(lamp, DVec3::new(2.6, 2.6, 1.7), DVec3::ZERO);
    set.scene.add_camera(
        Camera::perspective("main", 0.6),
        DVec3::new(0.9, 2.1, 5.6),
        DVec3::new(0.35, 1.25, -0.3),
    );
    set.scene.add_shadow("leaf shadows", ShadowNode::new("ShadowVolumeHard"));
    set.scene
}
