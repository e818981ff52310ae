//! Tentacles around a bowl: one mesh, six skins, one clip of four seconds in which a wave runs up each of them, a ball
//! that they toss, and a bud that opens by a morph target.

use std::f32::consts::{PI, TAU};

use glam::{DAffine3, DQuat, DVec3, Vec2, Vec3};
use shadowgraph_engine::geometry::shapes::{icosphere, lathe, plane};
use shadowgraph_engine::geometry::{Influences, MeshData, MorphTarget};
use shadowgraph_engine::scene::{
    Animation, Camera, Channel, Content, Interpolation, Light, NodeKey, Property, Scene, ShadowNode, Skin,
    Track, Transform,
};

use super::set::{Set, stand};

const BONES: u16 = 7;
const BONE_M: f32 = 0.3;
const TENTACLES: u32 = 6;
const CLIP_S: f32 = 4.0;
/// Keys of the clip; the last is the first again, so that it loops.
const KEYS: u32 = 16;

/// A tapering stalk with ridges, standing on the origin; each bone holds what is nearest to its middle.
fn stalk() -> MeshData {
    let height = BONE_M * f32::from(BONES);
    let ring = |i: u32| {
        let along = i as f32 / 84.0;
        let ridge = 1.0 + 0.07 * (along * 28.0 * PI).sin();
        Vec2::new((0.15 * (1.0 - along) + 0.02) * ridge, height * along)
    };
    let outline: Vec<Vec2> =
        [Vec2::ZERO].into_iter().chain((0..=84).map(ring)).chain([Vec2::new(0.0, height + 0.02)]).collect();
    let mut data = lathe(&outline, 18);
    let follows = |p: &Vec3| {
        let along = (p.y / BONE_M - 0.5).clamp(0.0, f32::from(BONES) - 1.0);
        let (bone, share) = (along as u16, along.fract());
        Influences::new([(bone, 1.0 - share), ((bone + 1).min(BONES - 1), share)])
    };
    data.influences = data.positions.iter().map(follows).collect();
    data
}

/// A closed bud whose petals open.
fn bud() -> MeshData {
    let mut data = icosphere(0.16, 4);
    let opened = |p: &Vec3| {
        let lift = (p.y / 0.16).max(0.0);
        let petal = 0.5 + 0.5 * (3.0 * p.z.atan2(p.x)).cos();
        Vec3::new(p.x, 0.0, p.z) * (2.2 * lift * petal) - Vec3::Y * (0.2 * lift * lift * (1.2 - petal))
    };
    let positions = data.positions.iter().map(opened).collect();
    data.morphs = vec![MorphTarget { name: "open".into(), positions, ..MorphTarget::default() }];
    data
}

/// How bone `bone` of tentacle `tentacle` is turned at key `key`.
fn turned(tentacle: u32, bone: u16, key: u32) -> DQuat {
    let phase = key as f32 / KEYS as f32 * TAU + tentacle as f32 * 1.9;
    let along = f32::from(bone);
    let curl = 0.16 + 0.04 * along + 0.13 * (phase - along * 0.9).sin();
    let sway = 0.14 * (phase * 1.0 + along * 0.5).cos();
    DQuat::from_rotation_x(f64::from(if bone == 0 { curl - 0.5 } else { curl }))
        * DQuat::from_rotation_z(f64::from(sway))
}

fn times() -> Vec<f32> {
    (0..=KEYS).map(|key| CLIP_S * key as f32 / KEYS as f32).collect()
}

/// A channel of rotations. Generated keys that make no track are a mistake here, so they end the program.
fn channel(node: NodeKey, property: Property, interpolation: Interpolation, values: Vec<f32>) -> Channel {
    let track = Track::new(property, interpolation, times(), values);
    Channel::new(node, track.unwrap_or_else(|error| panic!("a demo's animation: {error}")))
}

fn narrow(q: DQuat) -> [f32; 4] {
    q.to_array().map(|value| value as f32)
}

fn add_tentacle(set: &mut Set, group: NodeKey, index: u32, channels: &mut Vec<Channel>) -> Skin {
    let angle = TAU * index as f32 / TENTACLES as f32 + 0.3;
    let place = DVec3::new(f64::from(angle.sin()), 0.0, f64::from(angle.cos())) * 1.15;
    let mut joints = Vec::new();
    for bone in 0..BONES {
        let parent = joints.last().copied().unwrap_or(group);
        let facing = DQuat::from_rotation_y(f64::from(angle) + std::f64::consts::PI);
        let (translation, base) = match bone {
            0 => (place, facing),
            _ => (DVec3::Y * f64::from(BONE_M), DQuat::IDENTITY),
        };
        let at_key = |key: u32| base * turned(index, bone, key);
        let name = format!("tentacle {index} bone {bone}");
        let joint = set.scene.add(Some(parent), &name, DAffine3::IDENTITY, Content::Group);
        // What rests is the first key, with its f32 digits: there the clip begins and ends.
        let rotation = DQuat::from_array(narrow(at_key(0)).map(f64::from)).normalize();
        let rest = Transform { translation, rotation, scale: DVec3::ONE };
        set.scene.set_transform(joint, rest).unwrap_or_else(|error| panic!("a demo's joint: {error}"));
        let values = (0..=KEYS).flat_map(|key| narrow(at_key(key % KEYS))).collect();
        channels.push(channel(joint, Property::Rotation, Interpolation::Linear, values));
        joints.push(joint);
    }
    let bind = |bone: u16| DAffine3::from_translation(-DVec3::Y * f64::from(f32::from(bone) * BONE_M));
    Skin::new(&format!("tentacle {index}"), joints, (0..BONES).map(bind).collect())
}

pub(super) fn tentacles() -> Scene {
    let mut set = Set::new();
    let stage = set.scene.add_group("stage");
    let slate = set.paint("slate", [0.42, 0.43, 0.45], 0.9);
    let skin_paint = set.paint("skin", [0.42, 0.1, 0.2], 0.35);
    let brass = set.metal("brass", [0.75, 0.55, 0.25], 0.35);
    let petal = set.paint("petal", [0.85, 0.55, 0.12], 0.6);
    set.put(stage, "ground", plane(Vec2::splat(14.0)), slate, stand(0.0, 0.0, 0.0, 0.0));
    let bowl = [
        [0.0, 0.02],
        [0.5, 0.02],
        [0.42, 0.1],
        [0.3, 0.16],
        [0.62, 0.42],
        [0.7, 0.42],
        [0.34, 0.1],
        [0.0, 0.1],
    ];
    set.put(stage, "bowl", lathe(&bowl.map(Vec2::from), 48), brass, stand(0.0, 0.0, 0.0, 0.0));
    let bud_node = set.put(stage, "bud", bud(), petal, stand(0.0, 0.3, 0.0, 0.0));
    let ball = set.put(stage, "ball", icosphere(0.17, 3), brass, stand(0.0, 1.5, 0.0, 0.0));

    let mut channels = Vec::new();
    let shape = set.shape(stalk().named("stalk"));
    for index in 0..TENTACLES {
        let skin = add_tentacle(&mut set, stage, index, &mut channels);
        let skin = set.scene.add_skin(skin).unwrap_or_else(|error| panic!("a demo's skin: {error}"));
        let node = set.place(stage, "tentacle", shape, skin_paint, DAffine3::IDENTITY);
        if let Some(node) = set.scene.node_mut(node)
            && let Content::Mesh(content) = &mut node.content
        {
            content.skin = Some(skin);
        }
    }
    let turn = |key: u32| (key % KEYS) as f32 / KEYS as f32 * TAU;
    let tossed = (0..=KEYS).flat_map(|key| {
        [0.25 * turn(key).cos(), 1.75 + 0.35 * (2.0 * turn(key)).sin(), 0.25 * turn(key).sin()]
    });
    channels.push(channel(ball, Property::Translation, Interpolation::Linear, tossed.collect()));
    let opened = (0..=KEYS).map(|key| 0.55 + 0.45 * turn(key).cos()).collect();
    channels.push(channel(bud_node, Property::Weights, Interpolation::Linear, opened));
    let clip = set.scene.add_animation(Animation::new("wave", channels));
    clip.unwrap_or_else(|error| panic!("a demo's animation: {error}"));

    let lamp = Light::point("lamp", 60.0).with_color(Vec3::new(1.0, 0.86, 0.68));
    set.scene.add_light(lamp, DVec3::new(-2.2, 4.4, 1.6), DVec3::ZERO);
    let moon = Light::directional("moon", 1.6).with_color(Vec3::new(0.5, 0.66, 1.0));
    set.scene.add_light(moon, DVec3::new(4.0, 3.6, 1.5), DVec3::ZERO);
    set.scene.add_camera(
        Camera::perspective("main", 0.62),
        DVec3::new(1.9, 2.9, 5.1),
        DVec3::new(0.1, 0.7, 0.0),
    );
    set.scene.add_shadow("shadows", ShadowNode::new("ShadowVolumeHard"));
    set.scene
}
