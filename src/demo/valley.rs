//! A valley through a day: hills, a wood and a hamlet under a sun that moves (`--time`).
//!
//! One sun, two nodes: kilometres of land and wood are looked up in cascades of `ShadowMap`, and the hamlet in front, where an edge shows,
//! is counted exactly. The lantern on the square throws its shadows by a silhouette map in six directions.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{Ends, cone, cylinder, extruded, icosphere, sheet};
use shadowgraph_engine::scene::{
    Animation, Camera, Channel, Interpolation, Light, NodeKey, ParamValue, Property, Scene, ShadowNode,
    Track, placed,
};
use shadowgraph_measure::cases::strewn::noise;

use super::set::{Set, slab, slabs, stand};

/// Half the land's width, in metres.
const HALF_M: f32 = 420.0;
/// The day, in seconds.
const DAY_S: f32 = 12.0;
const KEYS: u32 = 24;

/// How high the land is.
fn height(x: f32, z: f32) -> f32 {
    let wave =
        |scale: f32, phase: f32| ((x / scale + phase).sin() * (z / scale * 1.13 - phase).cos()) * scale;
    let hills = 0.2 * wave(92.0, 0.4) + 0.17 * wave(47.0, 1.9) + 0.07 * wave(19.0, 4.1);
    // Flat where the hamlet is, rising towards the rim.
    let away = (x * x + z * z).sqrt();
    let rim = ((away - 120.0) / 300.0).clamp(0.0, 1.0);
    let open = ((away - 34.0) / 60.0).clamp(0.0, 1.0);
    (hills * open * open + 70.0 * rim * rim) * 1.0
}

pub(super) fn valley() -> Scene {
    let mut set = Set::new();
    let land = set.scene.add_group("land");
    let hamlet = set.scene.add_group("hamlet");
    build_land(&mut set, land);
    wood(&mut set, land);
    build_hamlet(&mut set, hamlet);
    let scene = &mut set.scene;
    let sun = Light::directional("sun", 7.0).with_color(Vec3::new(1.0, 0.9, 0.74));
    let sun = scene.add_light(sun, DVec3::ZERO, DVec3::NEG_Y);
    day(scene, sun);
    let lantern = Light::point("lantern", 70.0).with_color(Vec3::new(1.0, 0.62, 0.3));
    let lantern = scene.add_light(lantern, DVec3::new(3.5, 4.35, 5.5), DVec3::ZERO);
    scene.set_ambient(Vec3::new(0.26, 0.33, 0.46));
    scene.set_background(Vec3::new(0.45, 0.6, 0.85));
    scene.add_camera(
        Camera::perspective("main", 0.72),
        DVec3::new(-13.0, 12.5, 47.0),
        DVec3::new(1.5, 4.6, 0.0),
    );
    let number = ParamValue::Number;
    let maps = ShadowNode::new("ShadowMap")
        .with_param("cascades", number(4.0))
        .with_param("resolution", number(2048.0));
    scene.add_shadow("sun over the land", maps.with_lights([sun]).with_casters([land]));
    let hard = ShadowNode::new("ShadowVolumeHard");
    scene.add_shadow("sun on the hamlet", hard.with_lights([sun]).with_casters([hamlet]));
    let silhouettes = ShadowNode::new("SilhouetteMap");
    scene.add_shadow("lantern", silhouettes.with_lights([lantern]).with_casters([hamlet]));
    set.scene
}

/// The sun from morning to evening; what rests is the afternoon.
fn day(scene: &mut Scene, sun: NodeKey) {
    let turned = |hour: f64| {
        // From the right over the back to the left, 60° high at noon.
        let turn = (hour - 0.5) * std::f64::consts::PI * 0.9;
        let towards = DVec3::new(-turn.sin(), 0.1 + 0.55 * turn.cos(), -0.3 * turn.cos() - 0.12).normalize();
        DQuat::from_rotation_arc(DVec3::NEG_Z, -towards)
    };
    let narrow = |q: DQuat| q.to_array().map(|value| value as f32);
    let rest = DQuat::from_array(narrow(turned(0.8)).map(f64::from)).normalize();
    let fail = |error: &dyn std::fmt::Display| -> ! { panic!("a demo's animation: {error}") };
    let rest = shadowgraph_engine::scene::Transform { rotation: rest, ..Default::default() };
    scene.set_transform(sun, rest).unwrap_or_else(|error| fail(&error));
    let times = (0..=KEYS).map(|key| DAY_S * key as f32 / KEYS as f32).collect();
    let values = (0..=KEYS).flat_map(|key| narrow(turned(f64::from(key) / f64::from(KEYS)))).collect();
    let track = Track::new(Property::Rotation, Interpolation::Linear, times, values)
        .unwrap_or_else(|error| fail(&error));
    let day = Animation::new("day", vec![Channel::new(sun, track)]);
    scene.add_animation(day).unwrap_or_else(|error| fail(&error));
}

fn build_land(set: &mut Set, land: NodeKey) {
    let grass = set.picture("grass", [256, 256], 1.0, |x, y| {
        let field = noise((x / 32) * 91 + (y / 32) * 57);
        let tone = 0.85 + 0.2 * noise(x * 131 + y * 7919) + 0.25 * (field - 0.5);
        let green = if field > 0.72 { [168.0, 158.0, 86.0] } else { [104.0, 132.0, 66.0] };
        green.map(|c: f32| (c * tone).clamp(0.0, 255.0) as u8)
    });
    let ground = sheet(130, 130, |u, v| {
        let (x, z) = ((u * 2.0 - 1.0) * HALF_M, (1.0 - v * 2.0) * HALF_M);
        Vec3::new(x, height(x, z), z)
    });
    set.put(land, "ground", ground, grass, DAffine3::IDENTITY);
    let road = set.paint("gravel", [0.46, 0.42, 0.36], 1.0);
    let way = sheet(80, 1, |u, v| {
        let x = (u * 2.0 - 1.0) * 30.0;
        let z = 9.0 + 2.0 * (x * 0.1).sin() + (0.5 - v) * 3.4;
        Vec3::new(x, height(x, z) + 0.03, z)
    });
    set.put(land, "road", way, road, DAffine3::IDENTITY);
}

/// Firs on the slopes, none in the hamlet.
fn wood(set: &mut Set, land: NodeKey) {
    let needles =
        [set.paint("fir", [0.045, 0.1, 0.04], 1.0), set.paint("young fir", [0.09, 0.16, 0.05], 1.0)];
    let fir = MeshData::merged(
        "fir",
        [
            cylinder(0.22, 1.5, 6, Ends::Closed),
            cone(2.2, 3.6, 10, Ends::Closed).moved(Vec3::Y * 1.2),
            cone(1.7, 3.2, 10, Ends::Closed).moved(Vec3::Y * 3.0),
            cone(1.1, 2.8, 10, Ends::Closed).moved(Vec3::Y * 4.9),
        ],
    );
    let fir = set.shape(fir);
    let mut planted = 0;
    for i in 0..2_400_u32 {
        let (x, z) = ((noise(i * 2 + 11) * 2.0 - 1.0) * 260.0, (noise(i * 2 + 12) * 2.0 - 1.0) * 260.0);
        let thicket = (x * 0.021).sin() + (z * 0.027 + 1.3).cos();
        let near = x.abs() < 30.0 && (-26.0..46.0).contains(&z);
        if near || thicket < 0.35 || planted >= 300 {
            continue;
        }
        planted += 1;
        let size = 0.8 + 0.9 * f64::from(noise(i + 501));
        let place = stand(
            f64::from(x),
            f64::from(height(x, z)) - 0.2,
            f64::from(z),
            360.0 * f64::from(noise(i + 77)),
        );
        set.place(
            land,
            "fir",
            fir,
            needles[i as usize % 2],
            place * DAffine3::from_scale(DVec3::splat(size)),
        );
    }
}

/// Five houses, a church, a well, a lantern, fences and a tree with bare boughs.
fn build_hamlet(set: &mut Set, hamlet: NodeKey) {
    let lime = set.paint("lime", [0.78, 0.74, 0.66], 0.95);
    let tile = set.paint("tile", [0.36, 0.13, 0.08], 0.85);
    let slate = set.paint("slate", [0.14, 0.15, 0.18], 0.6);
    let timber = set.paint("timber", [0.2, 0.12, 0.07], 0.9);
    let iron = set.metal("iron", [0.18, 0.18, 0.19], 0.5);
    for (x, z, turn, length) in [
        (-11.0, 1.0, 8.0, 9.0),
        (12.5, -2.0, -14.0, 8.0),
        (-14.0, -12.0, 40.0, 8.0),
        (15.0, 12.5, 100.0, 7.0),
        (-3.0, -15.0, 95.0, 8.0),
    ] {
        house(set, hamlet, [lime, tile, timber], length, stand(x, 0.0, z, turn));
    }
    church(set, hamlet, [lime, slate, timber], stand(4.0, 0.0, -10.0, 12.0));
    let post = MeshData::merged(
        "lantern",
        [
            cylinder(0.07, 3.9, 12, Ends::Closed),
            cylinder(0.3, 0.08, 12, Ends::Closed).moved(Vec3::Y * 3.9),
            cylinder(0.02, 0.75, 6, Ends::Closed).moved(Vec3::new(0.24, 3.95, 0.0)),
            cylinder(0.02, 0.75, 6, Ends::Closed).moved(Vec3::new(-0.24, 3.95, 0.0)),
            cylinder(0.02, 0.75, 6, Ends::Closed).moved(Vec3::new(0.0, 3.95, 0.24)),
            cylinder(0.02, 0.75, 6, Ends::Closed).moved(Vec3::new(0.0, 3.95, -0.24)),
            cone(0.38, 0.3, 12, Ends::Closed).moved(Vec3::Y * 4.7),
        ],
    );
    set.put(hamlet, "lantern post", post, iron, stand(3.5, 0.0, 5.5, 0.0));
    fences(set, hamlet, timber);
    tree(set, hamlet, timber);
    let well = [
        cylinder(1.0, 0.8, 24, Ends::Open),
        slab([-1.0, 0.0, -0.06], [-0.88, 2.2, 0.06]),
        slab([0.88, 0.0, -0.06], [1.0, 2.2, 0.06]),
    ];
    set.put(hamlet, "well", MeshData::merged("", well), lime, stand(-3.0, 0.0, 3.2, 20.0));
    let roof = roof_of(1.3, 0.9, 0.8).moved(Vec3::Y * 2.2);
    set.put(hamlet, "well roof", roof, tile, stand(-3.0, 0.0, 3.2, 20.0));
    let stone = set.shape(icosphere(0.35, 2).named("stone"));
    for (x, z) in [(0.0, 8.0), (7.5, 7.2), (-7.0, 7.4), (9.0, 3.0)] {
        set.place(hamlet, "stone", stone, lime, stand(x, 0.15, z, 0.0));
    }
}

/// A roof along x over a half width: a prism.
fn roof_of(half_x: f32, half_z: f32, rise: f32) -> MeshData {
    let gable = [Vec2::new(-half_z, 0.0), Vec2::new(half_z, 0.0), Vec2::new(0.0, rise)];
    let along_z = extruded(&gable, -half_x, half_x);
    along_z.transformed(&DAffine3::from_rotation_y(std::f64::consts::FRAC_PI_2))
}

fn house(
    set: &mut Set,
    group: NodeKey,
    [wall, roof, timber]: [shadowgraph_engine::scene::MaterialKey; 3],
    length: f32,
    place: DAffine3,
) {
    let (half_x, half_z) = (0.5 * length, 2.6);
    set.put(group, "house", slab([-half_x, -0.3, -half_z], [half_x, 3.0, half_z]), wall, place);
    let gable = roof_of(half_x, half_z, 2.6).moved(Vec3::Y * 3.0);
    set.put(group, "gable", gable, wall, place);
    let slope = 2.6_f32.atan2(half_z);
    let board = |side: f32| {
        let width = (half_z * half_z + 2.6 * 2.6).sqrt() + 0.55;
        let lean =
            placed(DVec3::new(0.0, 5.68, 0.0), DQuat::from_rotation_x(f64::from(side * slope)), DVec3::ONE);
        let half = half_x + 0.4;
        let board = if side > 0.0 {
            slab([-half, 0.0, 0.0], [half, 0.12, width])
        } else {
            slab([-half, 0.0, -width], [half, 0.12, 0.0])
        };
        board.transformed(&lean)
    };
    set.put(group, "roof", MeshData::merged("", [board(1.0), board(-1.0)]), roof, place);
    set.put(group, "chimney", slab([-1.6, 4.0, -0.35], [-1.0, 6.7, 0.35]), wall, place);
    let mut frames = vec![([-0.5, 0.0, half_z], [0.5, 2.1, half_z + 0.06])];
    for x in [-0.34_f32, 0.34] {
        let x = x * length;
        frames.push(([x - 0.5, 1.1, half_z], [x + 0.5, 2.2, half_z + 0.08]));
    }
    set.put(group, "doors and shutters", slabs("", &frames), timber, place);
}

fn church(
    set: &mut Set,
    group: NodeKey,
    [wall, roof, timber]: [shadowgraph_engine::scene::MaterialKey; 3],
    place: DAffine3,
) {
    set.put(group, "nave", slab([-5.5, -0.3, -3.0], [5.5, 5.0, 3.0]), wall, place);
    set.put(group, "nave roof", roof_of(5.8, 3.4, 4.2).moved(Vec3::Y * 5.0), roof, place);
    set.put(group, "tower", slab([-9.0, -0.3, -1.9], [-5.2, 11.0, 1.9]), wall, place);
    let spire =
        cone(2.9, 7.5, 4, Ends::Closed).transformed(&DAffine3::from_rotation_y(std::f64::consts::FRAC_PI_4));
    set.put(group, "spire", spire.moved(Vec3::new(-7.1, 11.0, 0.0)), roof, place);
    let cross =
        slabs("", &[([-0.06, 0.0, -0.06], [0.06, 1.3, 0.06]), ([-0.4, 0.8, -0.06], [0.4, 0.92, 0.06])]);
    set.put(group, "cross", cross.moved(Vec3::new(-7.1, 18.4, 0.0)), timber, place);
}

fn fences(set: &mut Set, group: NodeKey, timber: shadowgraph_engine::scene::MaterialKey) {
    let run = |name: &str, length: f32| {
        let posts = (0..=(length / 0.5) as u32).map(|i| {
            let x = 0.5 * i as f32;
            ([x - 0.05, -0.2, -0.03], [x + 0.05, 1.05, 0.03])
        });
        let rails = [0.4_f32, 0.85].map(|y| ([-0.05, y - 0.05, 0.03], [length + 0.05, y + 0.05, 0.08]));
        slabs(name, &posts.chain(rails).collect::<Vec<_>>())
    };
    for (x, z, turn, length) in [(-14.0, 14.0, 0.0, 12.0), (6.5, 15.0, -10.0, 7.0), (-17.0, 6.0, 85.0, 6.0)] {
        let fence = run("fence", length);
        set.put(group, "fence", fence, timber, stand(x, 0.0, z, turn));
    }
}

/// A tree with bare boughs, each a thin cone that forks.
fn tree(set: &mut Set, group: NodeKey, timber: shadowgraph_engine::scene::MaterialKey) {
    fn grow(parts: &mut Vec<MeshData>, place: DAffine3, length: f32, radius: f32, depth: u32, seed: u32) {
        let bough =
            shadowgraph_engine::geometry::shapes::frustum(radius, radius * 0.62, length, 7, Ends::Closed);
        parts.push(bough.transformed(&place));
        if depth == 0 {
            return;
        }
        for fork in 0..3 {
            let number = seed * 3 + fork + 1;
            let turn = DQuat::from_rotation_y(f64::from(fork) * 2.1 + 2.0 * f64::from(noise(number)))
                * DQuat::from_rotation_z(0.42 + 0.35 * f64::from(noise(number + 91)));
            let at = DVec3::Y * f64::from(length * (0.72 + 0.25 * noise(number + 37)));
            let next = place * placed(at, turn, DVec3::ONE);
            grow(parts, next, length * 0.72, radius * 0.6, depth - 1, number);
        }
    }
    let mut parts = Vec::new();
    grow(&mut parts, DAffine3::IDENTITY, 2.6, 0.24, 4, 1);
    set.put(group, "tree", MeshData::merged("", parts), timber, stand(-6.5, -0.1, 11.0, 0.0));
}
