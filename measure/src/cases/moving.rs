//! Geometry that moves: skins bent to extremes, morph targets, animated nodes. What casts is what is drawn: the pose.

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::{icosphere, lathe, torus_knot};
use shadowgraph_engine::geometry::{Influences, Mesh, MeshData, MorphTarget};
use shadowgraph_engine::scene::{
    Animation, Channel, Content, Interpolation, Material, NodeKey, Property, Scene, Skin, Track, placed,
};

use super::Expect;
use super::stage::{Stage, p};

/// How high the joints of a stalk are apart.
const BONE_M: f32 = 0.8;

/// A closed stalk of three bones, standing on the origin.
fn stalk() -> MeshData {
    let rings = (0..=24).map(|ring| Vec2::new(0.18 - 0.003 * ring as f32, 0.1 * ring as f32));
    let outline: Vec<Vec2> = std::iter::once(Vec2::ZERO).chain(rings).chain([Vec2::new(0.0, 2.4)]).collect();
    let mut data = lathe(&outline, 16).named("stalk");
    let follows = |p: &Vec3| {
        // Each bone takes over within a tenth of its length.
        let along = (p.y / BONE_M).clamp(0.0, 2.999);
        let over = ((along.fract() - 0.95) * 10.0 + 0.5).clamp(0.0, 1.0);
        let bone = (along as u16).min(2);
        Influences::new([(bone, 1.0 - over), ((bone + 1).min(2), over)])
    };
    data.influences = data.positions.iter().map(follows).collect();
    data
}

/// A stalk whose three joints stand as given, each relative to the one below, in a scene with a floor and a lamp.
fn posed_stalk(name: &str, data: MeshData, joints: [(DQuat, DVec3); 3]) -> Stage {
    Stage::new(name).floor().point(p(-1.0, 5.0, 0.0)).with(|scene| add_stalk(scene, data, joints))
}

fn add_stalk(scene: &mut Scene, data: MeshData, joints: [(DQuat, DVec3); 3]) {
    let bone = DVec3::Y * f64::from(BONE_M);
    let mut keys: Vec<NodeKey> = Vec::new();
    for (place, (rotation, scale)) in joints.into_iter().enumerate() {
        let above = if place == 0 { DVec3::ZERO } else { bone };
        keys.push(scene.add(keys.last().copied(), "joint", placed(above, rotation, scale), Content::Group));
    }
    let binds = (0..3).map(|place| DAffine3::from_translation(-bone * f64::from(place))).collect();
    let skin = scene
        .add_skin(Skin::new("stalk", keys, binds))
        .unwrap_or_else(|error| panic!("a case's skin: {error}"));
    let mesh = Mesh::new(data).unwrap_or_else(|error| panic!("a case generates an invalid mesh: {error}"));
    // A node elsewhere: techniques that use its transform put the shadow there.
    let elsewhere = DAffine3::from_translation(DVec3::new(0.7, 3.0, -0.4));
    let node = scene.add_mesh(mesh, Material::matt("matt", Vec3::new(0.8, 0.6, 0.5)), elsewhere);
    if let Some(node) = scene.node_mut(node)
        && let Content::Mesh(content) = &mut node.content
    {
        content.skin = Some(skin);
    }
}

pub(super) fn skinned_extreme() -> Vec<Stage> {
    let turn = |axis: DVec3, degrees: f64| (DQuat::from_axis_angle(axis, degrees.to_radians()), DVec3::ONE);
    let scaled = |scale: DVec3| (DQuat::IDENTITY, scale);
    let still = scaled(DVec3::ONE);
    let mut parting = stalk().flat_shaded();
    // Every fifth triangle follows the joint below its neighbours': seams part, and the stalk falls open.
    for corners in parting.influences.chunks_exact_mut(15) {
        corners[..3].fill(Influences::new([(0, 1.0)]));
    }
    vec![
        // The upper two bones lie along +x, 0.8 m up.
        posed_stalk("bent", stalk(), [still, turn(DVec3::NEG_Z, 90.0), still])
            .dark(&[p(1.7, 0.0, 0.0)])
            .lit(&[p(1.7, 0.0, 1.0), p(0.25, 0.0, 1.3)]),
        posed_stalk("folded", stalk(), [still, turn(DVec3::NEG_Z, 175.0), turn(DVec3::X, -150.0)]),
        // Linear blending shrinks the stalk to a point between the bones.
        posed_stalk(
            "wrung",
            stalk(),
            [turn(DVec3::NEG_Z, 40.0), turn(DVec3::Y, 180.0), turn(DVec3::Y, 170.0)],
        ),
        posed_stalk(
            "mirrored",
            stalk(),
            [still, scaled(DVec3::new(-1.0, 0.8, 1.0)), turn(DVec3::NEG_Z, 70.0)],
        ),
        posed_stalk("unequal", stalk(), [scaled(DVec3::new(2.5, 0.6, 0.3)), turn(DVec3::NEG_Z, 60.0), still]),
        posed_stalk(
            "flattened",
            stalk(),
            [still, scaled(DVec3::new(1.0, 1.0, 0.0)), turn(DVec3::NEG_Z, 80.0)],
        ),
        posed_stalk("parted", parting, [still, turn(DVec3::NEG_Z, 90.0), still]).dark(&[p(1.7, 0.0, 0.0)]),
        posed_stalk("far", stalk(), [still, turn(DVec3::NEG_Z, 90.0), (DQuat::IDENTITY, DVec3::splat(40.0))])
            .expects(Expect::Matches),
    ]
}

/// A ball that can grow a nose along +x and be turned inside out, with these weights.
fn morphed(name: &str, weights: [f64; 2]) -> Stage {
    let mut data = icosphere(0.4, 3).named("ball");
    let nose = |p: &Vec3| Vec3::X * (p.x / 0.4 - 0.6).max(0.0) * 3.0;
    let morph =
        |name: &str, positions: Vec<Vec3>| MorphTarget { name: name.into(), positions, ..Default::default() };
    data.morphs = vec![
        morph("nose", data.positions.iter().map(nose).collect()),
        morph("inside out", data.positions.iter().map(|p| *p * -2.0).collect()),
    ];
    Stage::new(name).floor().point(p(-1.0, 5.0, 0.0)).with(|scene| {
        let mesh =
            Mesh::new(data).unwrap_or_else(|error| panic!("a case generates an invalid mesh: {error}"));
        let material = Material::matt("matt", Vec3::new(0.8, 0.6, 0.5));
        let node = scene.add_mesh(mesh, material, DAffine3::from_translation(DVec3::Y));
        if let Some(node) = scene.node_mut(node)
            && let Content::Mesh(content) = &mut node.content
        {
            content.weights = weights.to_vec();
        }
    })
}

pub(super) fn morph() -> Vec<Stage> {
    // The nose reaches x = 1.6 at full weight; its shadow falls under x = 1.5.
    let under_nose = [p(1.5, 0.0, 0.0)];
    vec![
        morphed("none", [0.0, 0.0]).lit(&under_nose).dark(&[p(0.25, 0.0, 0.0)]),
        morphed("half", [0.5, 0.0]).lit(&[p(1.8, 0.0, 0.0)]),
        morphed("full", [1.0, 0.0]).dark(&under_nose),
        morphed("beyond", [1.6, 0.0]).dark(&under_nose),
        morphed("negative", [-0.7, 0.0]).lit(&under_nose),
        // At ½ the ball vanishes, at 1 it is wound inwards; both targets together.
        morphed("point", [0.0, 0.5]).control(),
        morphed("inside-out", [0.0, 1.0]).dark(&[p(0.25, 0.0, 0.0)]),
        morphed("both", [1.0, 0.8]),
    ]
}

/// A knot on a carriage that slides, turns and grows, and a box on its own spline, at this time.
fn animated_at(name: &str, seconds: f64) -> Stage {
    let track = |property, interpolation, times: &[f32], values: &[f32]| {
        Track::new(property, interpolation, times.to_vec(), values.to_vec())
            .unwrap_or_else(|error| panic!("a case's track: {error}"))
    };
    Stage::new(name)
        .floor()
        .point(p(-1.0, 5.0, 1.0))
        .sun(p(0.4, -1.0, -0.3))
        .caster_at(torus_knot([2, 3], 0.4, 0.1, [64, 8]).named("knot"), DAffine3::IDENTITY)
        .control()
        .with(|scene| {
            let carriage = scene.add(None, "carriage", DAffine3::from_translation(DVec3::Y), Content::Group);
            let [knot, control] = ["knot", "control"].map(|name| scene.find(name).unwrap_or_default());
            // The scene was only just made: both nodes are there, and neither lies under the other.
            scene
                .reparent(knot, Some(carriage))
                .unwrap_or_else(|error| panic!("a case's hierarchy: {error}"));
            let half = std::f32::consts::FRAC_1_SQRT_2;
            use Interpolation::{CubicSpline, Linear, Step};
            let channels = vec![
                Channel::new(
                    carriage,
                    track(Property::Translation, Linear, &[0.0, 2.0], &[-1.5, 1.0, 0.0, 1.5, 1.2, 0.5]),
                ),
                // The long way round, were the sign not minded.
                Channel::new(
                    carriage,
                    track(
                        Property::Rotation,
                        Linear,
                        &[0.0, 1.0, 2.0],
                        &[0.0, 0.0, 0.0, 1.0, -half, 0.0, 0.0, -half, 0.0, 1.0, 0.0, 0.0],
                    ),
                ),
                Channel::new(
                    knot,
                    track(Property::Scale, Step, &[0.0, 1.5], &[1.0, 1.0, 1.0, 1.5, -0.7, 1.0]),
                ),
                Channel::new(
                    control,
                    track(
                        Property::Translation,
                        CubicSpline,
                        &[0.0, 2.0],
                        &[
                            0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -3.0, 3.0, 0.0, 0.0, -2.0, 1.0, -3.5, 0.2, -1.0,
                            0.0, 0.0, 0.0,
                        ],
                    ),
                ),
            ];
            let clip = scene.add_animation(Animation::new("drive", channels));
            let shown = clip.and_then(|clip| scene.animate(clip, seconds));
            shown.unwrap_or_else(|error| panic!("a case's animation: {error}"));
        })
}

pub(super) fn animated() -> Vec<Stage> {
    [("start", 0.0), ("turning", 0.4), ("between", 1.25), ("mirrored", 1.75), ("end", 99.0)]
        .map(|(name, seconds)| animated_at(name, seconds))
        .to_vec()
}
