//! A still life as a product shot: glass, fruit and a bowl on a table before a wall.
//!
//! The key light is shared by two nodes. `key on the table` throws soft shadows of all that is opaque onto table and wall, which
//! are planes, so a planar node is enough; `key through glass` colours what passes the bottles. The window's light from the left has a size and falls
//! on curved things: `window light` samples it. A spot from the right is looked up in a silhouette map.

use glam::{DAffine3, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cylinder, icosphere, lathe, quad, torus_knot};
use shadowgraph_engine::scene::{
    Camera, Light, Material, MaterialKey, NodeKey, ParamValue, Scene, ShadowNode,
};
use shadowgraph_measure::cases::strewn::noise;

use super::furniture::smoothed;
use super::set::{Set, slab, stand};

const HOME: DAffine3 = DAffine3::IDENTITY;

pub(super) fn still_life() -> Scene {
    let mut set = Set::new();
    let stage = set.scene.add_group("stage");
    let things = set.scene.add_group("things");
    let glass = set.scene.add_group("glass");
    let planes = build_stage(&mut set, stage);
    fruit(&mut set, things);
    crockery(&mut set, things);
    bottles(&mut set, glass);

    let scene = &mut set.scene;
    let key = Light::point("key", 4.6).with_color(Vec3::new(1.0, 0.93, 0.82));
    let key = scene.add_light(key, DVec3::new(0.5, 0.95, -0.3), DVec3::ZERO);
    let window = Light::point("window", 2.4).with_color(Vec3::new(0.72, 0.84, 1.0));
    let window = scene.add_light(window, DVec3::new(-2.2, 1.3, 1.1), DVec3::ZERO);
    let spot = Light::spot("spot", 1.5, 0.45).with_color(Vec3::new(1.0, 0.75, 0.5));
    let spot = scene.add_light(spot, DVec3::new(1.25, 0.75, 0.85), DVec3::new(0.1, 0.05, 0.1));
    scene.set_ambient(Vec3::new(0.12, 0.125, 0.145));
    scene.set_background(Vec3::new(0.05, 0.05, 0.06));
    scene.add_camera(
        Camera::perspective("main", 0.5),
        DVec3::new(0.1, 0.78, 1.62),
        DVec3::new(0.02, 0.1, 0.06),
    );
    let number = ParamValue::Number;
    let planar = ShadowNode::new("SoftShadow")
        .with_param("radius", number(0.07))
        .with_param("samples", number(128.0))
        .with_param("mode", ParamValue::Text("texture".into()))
        .with_param("resolution", number(2048.0));
    scene.add_shadow(
        "key on the table",
        planar.with_lights([key]).with_casters([things]).with_receivers(planes),
    );
    scene.add_shadow(
        "key through glass",
        ShadowNode::new("TransparentShadow").with_lights([key]).with_casters([glass]),
    );
    let soft = ShadowNode::new("ShadowVolumeSoft").with_param("radius", number(0.22));
    scene.add_shadow("window light", soft.with_lights([window]).with_casters([things]));
    scene.add_shadow("spot", ShadowNode::new("SilhouetteMap").with_lights([spot]).with_casters([things]));
    set.scene
}

/// The table's top and the wall, each a plane; what receives.
fn build_stage(set: &mut Set, stage: NodeKey) -> [NodeKey; 2] {
    let oak = set.picture("oak", [512, 512], 0.45, |x, y| {
        let plank = y / 102;
        let wave = (8.0 * (noise(plank * 17 + x / 40) - 0.5)) as i32 + y as i32;
        let grain =
            0.86 + 0.16 * noise((wave.max(0) as u32) * 613 + plank) + 0.05 * noise(x / 6 * 71 + y * 13);
        let joint = if y % 102 < 2 { 0.5 } else { 1.0 };
        [150.0, 98.0, 58.0].map(|c: f32| (c * grain * joint).min(255.0) as u8)
    });
    let wall = set.paint("wall", [0.3, 0.34, 0.33], 0.95);
    let flat = |half_x: f32, near: f32, far: f32| {
        quad([
            Vec3::new(-half_x, 0.0, near),
            Vec3::new(half_x, 0.0, near),
            Vec3::new(half_x, 0.0, far),
            Vec3::new(-half_x, 0.0, far),
        ])
    };
    let top = set.put(stage, "table top", flat(1.3, 0.9, -0.6), oak, HOME);
    let upright = quad([
        Vec3::new(-2.6, -0.6, -0.62),
        Vec3::new(2.6, -0.6, -0.62),
        Vec3::new(2.6, 2.2, -0.62),
        Vec3::new(-2.6, 2.2, -0.62),
    ]);
    let back = set.put(stage, "back wall", upright, wall, HOME);
    [top, back]
}

fn fruit(set: &mut Set, group: NodeKey) {
    let orange = set.paint("orange", [0.85, 0.32, 0.03], 0.45);
    let lemon = set.paint("lemon", [0.86, 0.68, 0.07], 0.4);
    let plum = set.paint("plum", [0.11, 0.035, 0.13], 0.35);
    let ball = set.shape(icosphere(0.062, 4).named("orange"));
    for (x, z) in [(0.28, 0.24), (0.41, 0.17)] {
        set.place(group, "orange", ball, orange, stand(x, 0.0621, z, 0.0));
    }
    let profile: Vec<Vec2> = (0..=24)
        .map(|i| {
            let along = i as f32 / 24.0;
            let tip = (along * 2.0 - 1.0).abs().powi(6) * 0.012;
            Vec2::new((0.046 * (along * std::f32::consts::PI).sin() - tip).max(0.0), 0.14 * along - 0.07)
        })
        .collect();
    let lemons = set.shape(lathe(&profile, 32).named("lemon"));
    let lying = |x: f64, z: f64, turn: f64| {
        stand(x, 0.0465, z, turn) * DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2)
    };
    set.place(group, "lemon", lemons, lemon, lying(0.12, 0.33, 25.0));
    let small = set.shape(icosphere(0.034, 4).named("plum"));
    for (x, z) in [(-0.34, 0.36), (-0.27, 0.4), (-0.31, 0.44)] {
        set.place(group, "plum", small, plum, stand(x, 0.0341, z, 0.0));
    }
}

fn crockery(set: &mut Set, group: NodeKey) {
    let glaze = set.paint("blue glaze", [0.06, 0.12, 0.24], 0.2);
    let bone = set.paint("bone china", [0.78, 0.75, 0.69], 0.3);
    let brass = set.metal("brass", [0.83, 0.6, 0.28], 0.25);
    let jug = [
        [0.0, 0.0],
        [0.06, 0.0],
        [0.1, 0.06],
        [0.105, 0.13],
        [0.07, 0.22],
        [0.05, 0.27],
        [0.062, 0.32],
        [0.056, 0.32],
        [0.045, 0.27],
        [0.064, 0.22],
        [0.098, 0.13],
        [0.093, 0.065],
        [0.0, 0.012],
    ];
    set.put(group, "jug", lathe(&smoothed(&jug.map(Vec2::from)), 48), glaze, stand(-0.42, 0.0005, 0.02, 0.0));
    let plate = [[0.0, 0.0], [0.08, 0.0], [0.15, 0.022], [0.152, 0.026], [0.08, 0.007], [0.0, 0.007]];
    set.put(group, "plate", lathe(&plate.map(Vec2::from), 64), bone, stand(0.31, 0.0003, 0.19, 0.0));
    let knot = torus_knot([2, 3], 0.062, 0.017, [160, 16]);
    set.put(group, "knot", knot, brass, stand(-0.08, 0.092, 0.36, 30.0));
    let foot = cylinder(0.05, 0.012, 40, Ends::Closed);
    set.put(group, "foot", foot, brass, stand(-0.08, 0.0002, 0.36, 0.0));
    set.put(
        group,
        "book",
        slab([-0.17, 0.0, -0.11], [0.17, 0.045, 0.11]),
        glaze,
        stand(0.62, 0.0004, -0.22, 24.0),
    );
    let cover = set.paint("red cloth", [0.4, 0.06, 0.045], 0.8);
    set.put(
        group,
        "book",
        slab([-0.15, 0.0, -0.1], [0.15, 0.03, 0.1]),
        cover,
        stand(0.61, 0.0456, -0.22, 12.0),
    );
}

/// Bottles with a wall of no thickness, and a glass cube.
fn bottles(set: &mut Set, group: NodeKey) {
    let green = glass(set, "green glass", [0.45, 0.85, 0.5]);
    let amber = glass(set, "amber glass", [0.98, 0.68, 0.25]);
    let rose = glass(set, "rose glass", [0.98, 0.5, 0.6]);
    let bottle = |height: f32, radius: f32| {
        let profile = [
            [0.0, 0.0],
            [0.92, 0.0],
            [1.0, 0.02],
            [1.0, 0.55],
            [0.8, 0.64],
            [0.34, 0.74],
            [0.3, 0.98],
            [0.36, 1.0],
        ];
        lathe(&smoothed(&profile.map(|[x, y]| Vec2::new(x * radius, y * height))), 48)
    };
    set.put(group, "green bottle", bottle(0.46, 0.062), green, stand(-0.14, 0.001, -0.12, 0.0));
    set.put(group, "amber bottle", bottle(0.33, 0.055), amber, stand(0.07, 0.001, 0.0, 0.0));
    let cube: MeshData = slab([-0.05, 0.0, -0.05], [0.05, 0.1, 0.05]);
    set.put(group, "rose cube", cube, rose, stand(-0.24, 0.001, 0.2, 33.0));
}

/// Glass that lets its own colour pass.
fn glass(set: &mut Set, name: &str, color: [f32; 3]) -> MaterialKey {
    set.scene.add_material(Material {
        transmission: 0.92,
        roughness: 0.08,
        ..Material::matt(name, color.into())
    })
}
