//! Plants of open leaves, wound one way and the other, and the close-up scene of one.

use std::f32::consts::{PI, TAU};

use glam::{DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{lathe, plane, quad, sheet};
use shadowgraph_engine::scene::{Camera, Light, NodeKey, Scene, ShadowNode};

use shadowgraph_measure::cases::strewn::noise;

use super::set::{Set, stand};

/// How a plant grows.
pub(super) struct Habit {
    /// The number of leaves.
    pub(super) leaves: u32,
    /// A leaf's length, in metres.
    pub(super) length_m: f32,
    /// A leaf's greatest width, in metres.
    pub(super) width_m: f32,
    /// The stem's height, in metres; the leaves sit along its upper two thirds.
    pub(super) height_m: f32,
}

/// The plant's leaves, every second one wound the other way: none of them has an inside.
pub(super) fn foliage(habit: &Habit) -> MeshData {
    let leaf = |i: u32| {
        let age = 1.0 - i as f32 / habit.leaves as f32;
        let turn = i as f32 * 2.4 + noise(i) * 0.5;
        let rise = (0.25 + 1.0 * (1.0 - age) + 0.2 * noise(i + 100)).min(1.35);
        let length = habit.length_m * (0.75 + 0.35 * age + 0.15 * noise(i + 200));
        let out = Vec3::new(turn.cos(), 0.0, turn.sin());
        let side = out.cross(Vec3::Y);
        let base = Vec3::Y * habit.height_m * (0.35 + 0.65 * (1.0 - age));
        let stalk = 0.3;
        let blade = sheet(4, 12, move |u, v| {
            let along = stalk + (1.0 - stalk) * v;
            let across = (u - 0.5) * 2.0;
            // Widest at two fifths, closing to a thin point; the halves fold up along the midrib.
            let width = habit.width_m * 0.5 * (0.02 + (PI * v.powf(0.75)).sin().max(0.0));
            let droop = length * (0.55 + 0.3 * noise(i + 300)) * along * along * (1.5 - rise).max(0.1);
            base + out * (length * along * rise.cos())
                + Vec3::Y * (length * along * rise.sin() - droop)
                + side * (across * width)
                + Vec3::Y * (across.abs() * width * 0.35)
        });
        let petiole = sheet(1, 4, move |u, v| {
            let along = stalk * v * 1.05;
            let droop = length * 0.6 * along * along * (1.5 - rise).max(0.1);
            base + out * (length * along * rise.cos())
                + Vec3::Y * (length * along * rise.sin() - droop)
                + side * ((u - 0.5) * 0.008)
        });
        let leaf = MeshData::merged("leaf", [blade, petiole]);
        if i.is_multiple_of(2) { leaf } else { leaf.flipped() }
    };
    MeshData::merged("leaves", (0..habit.leaves).map(leaf))
}

/// A pot with an open mouth whose wall has an outside and an inside, and soil in it.
pub(super) fn pot(radius: f32, height: f32) -> [MeshData; 2] {
    let r = radius;
    let wall = [
        [0.0, 0.0],
        [r * 0.72, 0.0],
        [r * 0.95, height * 0.82],
        [r * 1.05, height * 0.82],
        [r * 1.05, height],
        [r * 0.93, height],
        [r * 0.85, height * 0.8],
    ];
    let soil = [[r * 0.9, height * 0.86], [0.0, height * 0.9]];
    [lathe(&wall.map(Vec2::from), 40).named("pot"), lathe(&soil.map(Vec2::from), 40).named("soil")]
}

/// A potted plant as three meshes under one group.
pub(super) fn potted(
    set: &mut Set,
    group: NodeKey,
    habit: &Habit,
    pot_size: [f32; 2],
    [x, z]: [f64; 2],
) -> NodeKey {
    let clay = set.paint("terracotta", [0.46, 0.17, 0.085], 0.8);
    let earth = set.paint("soil", [0.05, 0.03, 0.02], 1.0);
    let green = set.paint("leaf", [0.045, 0.16, 0.05], 0.45);
    let plant =
        set.scene.add(Some(group), "plant", stand(x, 0.0, z, 0.0), shadowgraph_engine::scene::Content::Group);
    let [wall, soil] = pot(pot_size[0], pot_size[1]);
    set.put(plant, "pot", wall, clay, stand(0.0, 0.0, 0.0, 0.0));
    set.put(plant, "soil", soil, earth, stand(0.0, 0.0, 0.0, 0.0));
    let foot = f64::from(pot_size[1]) * 0.85;
    let stem = [[0.012, 0.0], [0.007, habit.height_m], [0.0, habit.height_m + 0.01]];
    set.put(plant, "stem", lathe(&stem.map(Vec2::from), 8), green, stand(0.0, foot, 0.0, 0.0));
    set.put(plant, "leaves", foliage(habit), green, stand(0.0, foot, 0.0, 0.0));
    plant
}

/// The close-up: a plant on a table edge before a wall, a spot from the side and a dim cool lamp.
pub(super) fn leaves() -> Scene {
    let mut set = Set::new();
    let stage = set.scene.add_group("stage");
    let plaster = set.paint("plaster", [0.72, 0.69, 0.64], 0.95);
    let wood = set.paint("oak", [0.4, 0.25, 0.13], 0.6);
    let wall = [[-3.0, 0.0], [3.0, 0.0], [3.0, 2.5], [-3.0, 2.5]].map(|[x, y]| Vec3::new(x, y, -0.55));
    set.put(stage, "wall", quad(wall), plaster, stand(0.0, 0.0, 0.0, 0.0));
    set.put(stage, "table", plane(Vec2::new(3.0, 1.5)), wood, stand(0.0, 0.0, 0.9, 0.0));
    let habit = Habit { leaves: 19, length_m: 0.42, width_m: 0.17, height_m: 0.34 };
    potted(&mut set, stage, &habit, [0.13, 0.2], [0.0, 0.0]);
    // A curl of paper: one strip, seen from both sides.
    let paper = set.paint("paper", [0.8, 0.78, 0.72], 0.9);
    let curl = sheet(24, 1, |u, v| {
        let (turn, r) = (u * TAU * 0.85, 0.05 + 0.05 * u);
        Vec3::new(r * turn.cos(), r * turn.sin() + 0.1, 0.12 * v)
    });
    set.put(stage, "paper", curl, paper, stand(0.42, 0.0, 0.12, 25.0));

    let warm = Light::spot("spot", 9.0, 0.42).with_color(Vec3::new(1.0, 0.84, 0.62));
    set.scene.add_light(warm, DVec3::new(-1.3, 1.25, 1.35), DVec3::new(0.1, 0.45, -0.1));
    let cool = Light::point("window", 0.9).with_color(Vec3::new(0.5, 0.68, 1.0));
    set.scene.add_light(cool, DVec3::new(1.6, 1.5, 1.4), DVec3::ZERO);
    set.scene.add_camera(
        Camera::perspective("main", 0.62),
        DVec3::new(0.35, 0.72, 1.75),
        DVec3::new(0.06, 0.4, 0.0),
    );
    set.scene.add_shadow("leaf shadows", ShadowNode::new("ShadowVolumeHard"));
    set.scene
}
