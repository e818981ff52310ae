//! What moves, in glTF: skins and animations against a second evaluation straight from the JSON, and a round trip.

use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4, Vec3, Vec4Swizzles};
use serde_json::{Value, json};
use shadowgraph_engine::geometry::{Influences, Mesh, MeshData, MorphTarget};
use shadowgraph_engine::gltf;
use shadowgraph_engine::scene::{
    Animation, Channel, Content, Interpolation, Material, Property, Scene, Skin, Track, Transform,
};

/// Fox.glb, which is no part of the project; `None` where it is not.
fn fox() -> Option<Vec<u8>> {
    shadowgraph_testing::model("Fox.glb").map(|path| std::fs::read(path).unwrap())
}

/// A .glb taken apart by hand; written without a look at the loader.
struct Parts<'a> {
    json: Value,
    bin: &'a [u8],
}

impl<'a> Parts<'a> {
    fn of(glb: &'a [u8]) -> Self {
        let size = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        Self { json: serde_json::from_slice(&glb[20..20 + size]).unwrap(), bin: &glb[28 + size..] }
    }

    fn number(&self, path: &str) -> usize {
        self.json.pointer(path).and_then(Value::as_u64).unwrap_or(0) as usize
    }

    /// The components of element `element` of an accessor of floats or unsigned integers.
    fn element(&self, accessor: usize, element: usize) -> Vec<f64> {
        let of = |field: &str| self.number(&format!("/accessors/{accessor}/{field}"));
        let view = of("bufferView");
        let of_view = |field: &str| self.number(&format!("/bufferViews/{view}/{field}"));
        let width = match self.json["accessors"][accessor]["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            other => panic!("{other}"),
        };
        let size = match of("componentType") {
            5121 => 1,
            5123 => 2,
            _ => 4,
        };
        let stride = if of_view("byteStride") == 0 { width * size } else { of_view("byteStride") };
        let at = of_view("byteOffset") + of("byteOffset") + element * stride;
        (0..width)
            .map(|i| {
                let bytes = &self.bin[at + i * size..][..size];
                match of("componentType") {
                    5121 => f64::from(bytes[0]),
                    5123 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
                    5126 => f64::from(f32::from_le_bytes(bytes.try_into().unwrap())),
                    other => panic!("component type {other}"),
                }
            })
            .collect()
    }

    fn numbers(&self, path: &str, default: &[f64]) -> Vec<f64> {
        let array = self.json.pointer(path).and_then(Value::as_array);
        array.map_or(default.to_vec(), |array| array.iter().map(|n| n.as_f64().unwrap()).collect())
    }

    /// The matrix of a node with the channels of `animation` at `seconds`, all of them linear.
    fn local(&self, node: usize, animation: usize, seconds: f64) -> DMat4 {
        let mut values = [
            ("translation", self.numbers(&format!("/nodes/{node}/translation"), &[0.0; 3])),
            ("rotation", self.numbers(&format!("/nodes/{node}/rotation"), &[0.0, 0.0, 0.0, 1.0])),
            ("scale", self.numbers(&format!("/nodes/{node}/scale"), &[1.0; 3])),
        ];
        let animation = &self.json["animations"][animation];
        for channel in animation["channels"].as_array().unwrap() {
            if channel["target"]["node"] != json!(node) {
                continue;
            }
            let sampler = &animation["samplers"][channel["sampler"].as_u64().unwrap() as usize];
            assert!(sampler.get("interpolation").is_none_or(|way| way == "LINEAR"));
            let [input, output] = ["input", "output"].map(|field| sampler[field].as_u64().unwrap() as usize);
            let keys = self.number(&format!("/accessors/{input}/count"));
            let time = |key: usize| self.element(input, key)[0];
            let next = (0..keys).find(|key| time(*key) > seconds).unwrap_or(keys);
            let (a, b) = (next.saturating_sub(1), next.min(keys - 1));
            let t = if a == b { 0.0 } else { (seconds - time(a)) / (time(b) - time(a)) };
            let (from, to) = (self.element(output, a), self.element(output, b));
            let path = channel["target"]["path"].as_str().unwrap();
            let slot = values.iter_mut().find(|(name, _)| *name == path).unwrap();
            slot.1 = if path == "rotation" {
                // By turning through the angle between the two, not by a formula for slerp.
                let (from, to) = (DQuat::from_slice(&from).normalize(), DQuat::from_slice(&to).normalize());
                let to = if from.dot(to) < 0.0 { -to } else { to };
                let (axis, angle) = (from.inverse() * to).to_axis_angle();
                (from * DQuat::from_axis_angle(axis, angle * t)).to_array().to_vec()
            } else {
                from.iter().zip(&to).map(|(a, b)| a + (b - a) * t).collect()
            };
        }
        let [translation, rotation, scale] = values.map(|(_, values)| values);
        DMat4::from_translation(DVec3::from_slice(&translation))
            * DMat4::from_quat(DQuat::from_slice(&rotation).normalize())
            * DMat4::from_scale(DVec3::from_slice(&scale))
    }

    fn world(&self, node: usize, animation: usize, seconds: f64) -> DMat4 {
        let nodes = self.json["nodes"].as_array().unwrap();
        let is_parent = |candidate: &Value| {
            candidate["children"].as_array().is_some_and(|all| all.contains(&json!(node)))
        };
        let local = self.local(node, animation, seconds);
        match nodes.iter().position(is_parent) {
            Some(parent) => self.world(parent, animation, seconds) * local,
            None => local,
        }
    }

    /// Every vertex of the first mesh, skinned by the first skin.
    fn skinned(&self, animation: usize, seconds: f64) -> Vec<DVec3> {
        let attribute = |name: &str| self.number(&format!("/meshes/0/primitives/0/attributes/{name}"));
        let [positions, joints, weights] = ["POSITION", "JOINTS_0", "WEIGHTS_0"].map(attribute);
        let binds = self.number("/skins/0/inverseBindMatrices");
        let joint_nodes = self.numbers("/skins/0/joints", &[]);
        let matrices: Vec<DMat4> = joint_nodes
            .iter()
            .enumerate()
            .map(|(place, node)| {
                let bind = DMat4::from_cols_slice(&self.element(binds, place));
                self.world(*node as usize, animation, seconds) * bind
            })
            .collect();
        let count = self.number(&format!("/accessors/{positions}/count"));
        let vertex = |index: usize| {
            let p = DVec3::from_slice(&self.element(positions, index)).extend(1.0);
            let (joints, weights) = (self.element(joints, index), self.element(weights, index));
            let sum: f64 = weights.iter().sum();
            let pairs = joints.iter().zip(&weights);
            let moved: DVec4 =
                pairs.map(|(joint, weight)| matrices[*joint as usize] * p * (weight / sum)).sum();
            moved.xyz()
        };
        (0..count).map(vertex).collect()
    }
}

#[test]
fn the_fox_stands_where_a_second_evaluation_says() {
    let Some(glb) = fox() else { return };
    let parts = Parts::of(&glb);
    let mut scene = gltf::load_slice(&glb, None).unwrap().scene;
    let clips: Vec<_> =
        scene.animations().map(|(key, clip)| (key, clip.name.clone(), clip.duration_s())).collect();
    assert_eq!(clips.iter().map(|clip| clip.1.as_str()).collect::<Vec<_>>(), ["Survey", "Walk", "Run"]);
    for (animation, (key, name, duration_s)) in clips.iter().enumerate() {
        for seconds in [0.0, 0.31 * duration_s, 0.5 * duration_s, *duration_s, duration_s + 9.0] {
            scene.animate(*key, seconds).unwrap();
            let snapshot = scene.snapshot().unwrap();
            let fox = snapshot.instances.iter().find(|instance| instance.name == "fox").unwrap();
            let wanted = parts.skinned(animation, seconds);
            assert_eq!(wanted.len(), fox.mesh.positions().len());
            // f32 vertices of a fox a hundred units long, stored about its middle.
            let worst = wanted
                .iter()
                .enumerate()
                .map(|(vertex, p)| (fox.world_position(vertex as u32) - *p).length());
            let worst = worst.fold(0.0, f64::max);
            assert!(worst < 1e-5, "{name} at {seconds} s: off by {worst}");
        }
    }
}

/// A tetrahedron with two morph targets; one of its vertices follows more joints than four.
fn bent() -> MeshData {
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.1, 0.2, 1.0 / 3.0)];
    MeshData {
        name: "bent".into(),
        influences: (0..4)
            .map(|i| {
                Influences::new(
                    (0..if i == 3 { 6 } else { 2 }).map(|joint| (joint % 2, 0.1 + 0.2 * f32::from(joint))),
                )
            })
            .collect(),
        morphs: vec![
            MorphTarget {
                name: "smile".into(),
                positions: positions.iter().map(|p| *p * 0.3).collect(),
                normals: vec![Vec3::Z; 4],
                weight: 0.1,
            },
            MorphTarget { name: "".into(), normals: vec![Vec3::X * 0.1; 4], ..MorphTarget::default() },
        ],
        positions,
        indices: vec![0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3],
        ..MeshData::default()
    }
}

/// A bent, morphing, animated scene in numbers that f32 holds.
fn rich() -> Scene {
    let mut scene = Scene::new();
    let lower = scene.add_group("lower");
    let rest = Transform {
        translation: DVec3::new(0.1, 2.0, 1.0 / 3.0),
        rotation: DQuat::from_rotation_x(0.3),
        scale: DVec3::new(1.0, -2.0, 0.7),
    };
    scene.set_transform(lower, rest).unwrap();
    let upper = scene.add(Some(lower), "upper", DAffine3::from_translation(DVec3::Y), Content::Group);
    let data = bent();
    let many = MeshData {
        name: "many joints".into(),
        influences: (0..4).map(|i| Influences::new((0..8).map(|joint| ((joint + i) % 9, 0.125)))).collect(),
        ..data.clone()
    };
    let node =
        scene.add_mesh(Mesh::new(data).unwrap(), Material::default(), DAffine3::from_translation(DVec3::X));
    let other = scene.add_mesh(Mesh::new(many).unwrap(), Material::default(), DAffine3::IDENTITY);
    let binds = vec![
        DAffine3::from_translation(DVec3::new(0.25, -0.5, 3.0)),
        DAffine3::from_scale(DVec3::new(0.5, 2.0, 0.0)),
    ];
    let skin = scene.add_skin(Skin::new("two", vec![lower, upper], binds)).unwrap();
    let nine = scene.add_skin(Skin::new("", [lower, upper, other].repeat(3), vec![])).unwrap();
    for (key, skin, weights) in [(node, skin, vec![0.1, 0.7]), (other, nine, vec![])] {
        if let Content::Mesh(content) = &mut scene.node_mut(key).unwrap().content {
            (content.skin, content.weights) = (Some(skin), weights);
        }
    }
    let track = |property, interpolation, times: &[f32], values: &[f32]| {
        Track::new(property, interpolation, times.to_vec(), values.to_vec()).unwrap()
    };
    let turn = track(
        Property::Rotation,
        Interpolation::Linear,
        &[0.1, 1.3],
        &[0.1, 0.2, 0.3, 0.9, -0.5, 0.5, 0.5, 0.5],
    );
    let spline: Vec<f32> = (0..12).map(|i| i as f32 / 7.0).collect();
    let channels = vec![
        Channel::new(lower, turn),
        Channel::new(
            upper,
            track(Property::Scale, Interpolation::Step, &[0.1, 1.3], &[1.0, 1.0, 1.0, 2.0, -0.5, 3.0]),
        ),
        Channel::new(node, track(Property::Weights, Interpolation::CubicSpline, &[0.0, 2.0], &spline)),
    ];
    let shared = Channel { node: upper, track: channels[0].track.clone() };
    scene.add_animation(Animation::new("one", channels)).unwrap();
    let slide =
        track(Property::Translation, Interpolation::Linear, &[0.0, 9.0], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    scene.add_animation(Animation::new("two", vec![Channel::new(lower, slide), shared])).unwrap();
    scene
}

/// What a scene's snapshot says of its shapes.
fn shapes(scene: &Scene) -> String {
    let snapshot = scene.snapshot().unwrap();
    snapshot
        .instances
        .iter()
        .map(|i| format!("{} {:?} {:?}\n", i.name, i.world_from_local, i.mesh.data()))
        .collect()
}

#[test]
fn what_moves_survives_a_round_trip() {
    let mut scene = rich();
    // What is shown while saving is not what is saved: animations bring it back.
    let clips: Vec<_> = scene.animations().map(|(key, _)| key).collect();
    scene.animate(clips[1], 3.0).unwrap();
    let bytes = gltf::to_glb(&scene).unwrap().bytes;
    scene.rest().unwrap();
    assert_eq!(bytes, gltf::to_glb(&scene).unwrap().bytes);

    let loaded = gltf::load_slice(&bytes, None).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let mut again = loaded.scene;
    assert_eq!(shapes(&again), shapes(&scene));
    assert_eq!(again.skins().map(|(_, s)| s.joints.len()).collect::<Vec<_>>(), [2, 9]);
    assert_eq!(
        again.skins().next().unwrap().1.joint_from_mesh,
        scene.skins().next().unwrap().1.joint_from_mesh
    );
    let data = |scene: &Scene| scene.meshes().map(|(_, mesh)| mesh.data().clone()).collect::<Vec<_>>();
    assert_eq!(data(&again), data(&scene));
    let copies: Vec<_> = again.animations().map(|(key, _)| key).collect();
    assert_eq!(copies.len(), 2);
    for (copy, clip) in copies.into_iter().zip(clips) {
        assert_eq!(again.animation(copy).unwrap().name, scene.animation(clip).unwrap().name);
        for seconds in [0.0, 0.4, 1.0, 1.9, 20.0] {
            again.animate(copy, seconds).unwrap();
            scene.animate(clip, seconds).unwrap();
            assert_eq!(shapes(&again), shapes(&scene), "{seconds} s");
        }
    }
    assert_eq!(gltf::to_glb(&again).unwrap().bytes, bytes);
}

#[test]
fn joints_that_are_gone_are_not_saved() {
    let mut scene = rich();
    let upper = scene.find("upper").unwrap();
    scene.remove(upper).unwrap();
    let error = gltf::to_glb(&scene).unwrap_err().to_string();
    assert!(error.contains("skin 'two'") && error.contains("no longer"), "{error}");
}
