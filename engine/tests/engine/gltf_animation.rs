//! What moves, in glTF: skins and animations against a second evaluation straight from the JSON, every component type,
//! instances, the choice of a scene, and a round trip.

use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4, Vec3, Vec4Swizzles};
use serde_json::{Value, json};
use shadowgraph_engine::geometry::{Influences, Mesh, MeshData, MorphTarget};
use shadowgraph_engine::gltf::{self, GltfError, LoadOptions, SceneChoice};
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
            let posed = scene.pose().unwrap();
            let fox = posed.instances.iter().find(|instance| instance.name == "fox").unwrap();
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
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.1, 0.2, 1.0 / 3.0)];
    let data = MeshData {
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
    };
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

/// What a posed scene says of its shapes.
fn shapes(scene: &Scene) -> String {
    let posed = scene.pose().unwrap();
    posed
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

/// One triangle with whatever `change` does to it: positions (0), joints (1), weights (2), a vector stream (3), times (4).
fn document(change: impl FnOnce(&mut Value)) -> Value {
    let floats = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0]);
    bytes.extend([255, 0, 0, 0, 128, 127, 0, 0, 0, 0, 0, 0]);
    bytes.extend([2.0_f32, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 4.0].iter().flat_map(|x| x.to_le_bytes()));
    bytes.extend([0.0_f32, 1.0, 2.0].iter().flat_map(|x| x.to_le_bytes()));
    let hex: String = bytes.iter().map(|byte| format!("%{byte:02X}")).collect();
    let stream = |view: usize, component: u32, kind: &str| json!({ "bufferView": view, "componentType": component, "count": 3, "type": kind });
    let view =
        |start: usize, length: usize| json!({ "buffer": 0, "byteOffset": start, "byteLength": length });
    let mut document = json!({
        "asset": { "version": "2.0" }, "scene": 0,
        "scenes": [{ "nodes": [0, 1, 2] }, { "name": "empty" }, { "name": "only", "nodes": [2] }],
        "nodes": [{ "name": "shape", "mesh": 0, "skin": 0 }, { "name": "a" }, { "name": "b", "translation": [0, 5, 0] }],
        "skins": [{ "name": "bones", "joints": [1, 2] }],
        "animations": [{ "name": "clip", "samplers": [{ "input": 4, "output": 3 }],
            "channels": [{ "sampler": 0, "target": { "node": 2, "path": "translation" } }] }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2 } }] }],
        "accessors": [stream(0, 5126, "VEC3"), stream(1, 5121, "VEC4"), stream(2, 5121, "VEC4"),
            stream(3, 5126, "VEC3"), stream(4, 5126, "SCALAR")],
        "bufferViews": [view(0, 36), view(36, 12), view(48, 12), view(60, 36), view(96, 12)],
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:,{hex}") }],
    });
    document["accessors"][2]["normalized"] = true.into();
    change(&mut document);
    document
}

fn load(document: &Value) -> Result<gltf::Loaded, GltfError> {
    gltf::load_slice(document.to_string().as_bytes(), None)
}

#[track_caller]
fn refused(names: &[&str], change: impl FnOnce(&mut Value)) {
    let error = load(&document(change)).expect_err("it should be refused").to_string();
    for name in names {
        assert!(error.contains(name), "'{error}' does not say '{name}'");
    }
}

#[test]
fn small_integers_bend_as_floats_do() {
    let mut loaded = load(&document(|_| {})).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let at = |scene: &Scene| {
        let posed = scene.pose().unwrap();
        [0, 1, 2].map(|vertex| posed.instances[0].world_position(vertex))
    };
    let near = |got: [DVec3; 3], wanted: [[f64; 3]; 3]| {
        got.iter().zip(wanted).all(|(got, wanted)| (*got - DVec3::from(wanted)).length() < 1e-6)
    };
    // The second vertex follows joint b by 128/255 and joint a by the rest, the third none and so its first, b.
    let share = 128.0 / 255.0;
    assert!(
        near(at(&loaded.scene), [[0.0; 3], [1.0, 5.0 * share, 0.0], [0.0, 6.0, 0.0]]),
        "{:?}",
        at(&loaded.scene)
    );
    let clip = loaded.scene.find_animation("clip").unwrap();
    loaded.scene.animate(clip, 0.5).unwrap();
    assert!(near(at(&loaded.scene), [[0.0; 3], [1.0 + share, 1.5 * share, 0.0], [1.0, 2.5, 0.0]]));
    assert_eq!(loaded.scene.animation(clip).unwrap().duration_s(), 2.0);
}

#[test]
fn what_does_not_fit_is_named() {
    refused(&["node 0 'shape'", "'skin' names skin 3", "has 1"], |d| d["nodes"][0]["skin"] = 3.into());
    refused(&["skin 0 'bones'", "'joints' names node 9", "has 3"], |d| d["skins"][0]["joints"][1] = 9.into());
    refused(&["skin 0 'bones'", "no joints"], |d| d["skins"][0]["joints"] = json!([]));
    refused(&["node 0 'shape'", "joint 1", "1 joints"], |d| d["skins"][0]["joints"] = json!([1]));
    refused(&["inverseBindMatrices", "Mat4"], |d| d["skins"][0]["inverseBindMatrices"] = 0.into());
    refused(&["accessor 9", "has 5"], |d| d["skins"][0]["inverseBindMatrices"] = 9.into());
    refused(&["joint node 1", "not in the loaded scene"], |d| d["scenes"][0]["nodes"] = json!([0, 2]));
    refused(&["JOINTS", "Vec3 of F32", "U8 or U16"], |d| {
        d["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = 3.into();
    });
    refused(&["primitive 0", "JOINTS_0", "no WEIGHTS_0"], |d| {
        d["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove("WEIGHTS_0");
    });
    refused(&["animation 0 'clip'", "sampler 7", "has 1"], |d| {
        d["animations"][0]["channels"][0]["sampler"] = 7.into();
    });
    refused(&["animation 0 'clip'", "node 7", "has 3"], |d| {
        d["animations"][0]["channels"][0]["target"]["node"] = 7.into();
    });
    refused(&["'input'", "accessor 7", "has 5"], |d| d["animations"][0]["samplers"][0]["input"] = 7.into());
    refused(&["interpolation", "CUBICSPLINE"], |d| {
        d["animations"][0]["samplers"][0]["interpolation"] = "QUICK".into();
    });
    refused(&["sampler 0", "9 values for 3 keys", "27"], |d| {
        d["animations"][0]["samplers"][0]["interpolation"] = "CUBICSPLINE".into();
    });
    refused(&["Vec4", "needed"], |d| d["animations"][0]["channels"][0]["target"]["path"] = "rotation".into());
    refused(&["9 weights of node 'b'", "0 morph targets"], |d| {
        d["animations"][0]["channels"][0]["target"]["path"] = "weights".into();
        d["accessors"][3] = json!({ "bufferView": 3, "componentType": 5126, "count": 9, "type": "SCALAR" });
        d["animations"][0]["samplers"][0]["input"] = 5.into();
        d["accessors"]
            .as_array_mut()
            .unwrap()
            .push(json!({ "bufferView": 4, "componentType": 5126, "count": 1, "type": "SCALAR" }));
    });
    refused(&["key 2", "ascending"], |d| {
        // Byte 104 begins the third time: 2.0 becomes 2e-31, before 1.
        let uri = d["buffers"][0]["uri"].as_str().unwrap().to_owned();
        let at = "data:,".len() + (96 + 11) * 3;
        d["buffers"][0]["uri"] = format!("{}%10{}", &uri[..at], &uri[at + 3..]).into();
    });
    refused(&["node 1 'a'", "1e308", "1e18"], |d| d["nodes"][1]["translation"] = json!([0, 1e308, 0]));
    refused(&["node 2 'b'", "'weights' must be 0 numbers"], |d| {
        d["nodes"][2]["mesh"] = 0.into();
        d["nodes"][2]["weights"] = json!([1]);
    });
    for (path, target, kind, count) in [
        ("accessors[0].bufferView", "/accessors/0/bufferView", "buffer views", 5),
        ("bufferViews[1].buffer", "/bufferViews/1/buffer", "buffers", 1),
        ("meshes[0].primitives[0].indices", "/meshes/0/primitives/0/indices", "accessors", 5),
        ("meshes[0].primitives[0].material", "/meshes/0/primitives/0/material", "materials", 0),
        ("attributes[\"JOINTS_0\"]", "/meshes/0/primitives/0/attributes/JOINTS_0", "accessors", 5),
    ] {
        let range = format!("the file has {count} {kind}");
        refused(&[path, "index 999 is out of bounds", &range], |d| {
            let (parent, key) = target.rsplit_once('/').unwrap();
            d.pointer_mut(parent).unwrap()[key] = 999.into();
        });
    }
}

#[test]
fn what_is_left_out_is_said() {
    let warned = |text: &str, change: &dyn Fn(&mut Value)| {
        let loaded = load(&document(|d| change(d))).unwrap();
        assert!(
            loaded.warnings.iter().any(|warning| warning.contains(text)),
            "{text}: {:?}",
            loaded.warnings
        );
        loaded.scene.pose().unwrap();
    };
    warned("no vertex names a joint", &|d| {
        d["meshes"][0]["primitives"][0]["attributes"] = json!({ "POSITION": 0 });
    });
    warned("'pointer' are ignored", &|d| {
        d["animations"][0]["channels"][0]["target"]["path"] = "pointer".into();
    });
    warned("without a node", &|d| d["animations"][0]["channels"][0]["target"] = json!({ "path": "scale" }));
    warned("skin without a mesh", &|d| d["nodes"][1]["skin"] = 0.into());
    // Of another scene nothing is taken, its animations neither.
    let options = LoadOptions { scene: SceneChoice::Name("only"), ..LoadOptions::default() };
    let only = gltf::load_slice_with(document(|_| {}).to_string().as_bytes(), None, &options).unwrap();
    assert_eq!(
        (only.scene.nodes().count(), only.scene.animations().count(), only.scene_index),
        (1, 1, Some(2))
    );
    assert_eq!(only.scene_names, ["", "empty", "only"]);
    let options = LoadOptions { scene: SceneChoice::Index(1), ..LoadOptions::default() };
    let empty = gltf::load_slice_with(document(|_| {}).to_string().as_bytes(), None, &options).unwrap();
    assert_eq!((empty.scene.nodes().count(), empty.scene.animations().count()), (0, 0));
    let options = LoadOptions { scene: SceneChoice::Name("other"), ..LoadOptions::default() };
    let error = gltf::load_slice_with(document(|_| {}).to_string().as_bytes(), None, &options).unwrap_err();
    assert!(error.to_string().contains("'other'") && error.to_string().contains("'only'"), "{error}");
}

#[test]
fn morph_targets_may_be_sparse_and_quantised() {
    let mut loaded = load(&document(|d| {
        d["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        d["nodes"][0] = json!({ "mesh": 0, "weights": [0.5, 2] });
        // The last vertex moves by (0, 3, 0); and one by normalised bytes, of which the second vertex is (1, 0, 0).
        let values = json!({ "bufferView": 3, "byteOffset": 12 });
        d["accessors"][3] = json!({ "componentType": 5126, "count": 3, "type": "VEC3", "sparse": { "count": 1,
            "indices": { "bufferView": 1, "byteOffset": 4, "componentType": 5121 }, "values": values } });
        d["accessors"][1] = json!({ "bufferView": 1, "componentType": 5120, "count": 3, "type": "VEC3" });
        d["bufferViews"][1]["byteStride"] = 4.into();
        d["meshes"][0] = json!({ "extras": { "targetNames": ["up", "out"] }, "weights": [0, 0],
            "primitives": [{ "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": 3 }, { "POSITION": 1 }] }] });
        d["animations"] = json!([]);
        // Sparse indices must not lie in a view with a stride; this one is read byte by byte.
        d["bufferViews"].as_array_mut().unwrap().push(json!({ "buffer": 0, "byteOffset": 40, "byteLength": 1 }));
        d["accessors"][3]["sparse"]["indices"] = json!({ "bufferView": 5, "componentType": 5121 });
    }))
    .unwrap();
    let names = |scene: &Scene| -> Vec<String> {
        scene
            .meshes()
            .flat_map(|(_, mesh)| mesh.data().morphs.iter().map(|morph| morph.name.clone()))
            .collect()
    };
    assert_eq!(names(&loaded.scene), ["up", "out"]);
    let bent = loaded.scene.pose().unwrap().instances.remove(0);
    let rest = [DVec3::ZERO, DVec3::X, DVec3::Y];
    let up = [DVec3::ZERO, DVec3::Y * 3.0, DVec3::ZERO];
    let out = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]].map(DVec3::from);
    for vertex in 0..3 {
        let wanted = rest[vertex] + up[vertex] * 0.5 + out[vertex] * 2.0;
        assert!((bent.world_position(vertex as u32) - wanted).length() < 1e-6, "{vertex}");
    }
    // Flat normals follow the bent triangle.
    let [a, b, c] = [0, 1, 2].map(|vertex| bent.world_position(vertex));
    let normal = bent.mesh.data().normals[0].as_dvec3();
    assert!((normal - (b - a).cross(c - a).normalize()).length() < 1e-6, "{normal}");
    loaded.scene.rest().unwrap();
}

fn instanced(change: impl FnOnce(&mut Value)) -> Value {
    document(|d| {
        d["nodes"][0] = json!({ "name": "leaf", "mesh": 0, "translation": [0, 0, 7], "children": [2], "extensions": {
            "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 3, "_ID": 4 } } } });
        d["scenes"][0]["nodes"] = json!([0, 1]);
        d["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
        change(d);
    })
}

#[test]
fn instances_become_nodes_that_share_a_mesh() {
    let loaded = load(&instanced(|_| {})).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    let posed = loaded.scene.pose().unwrap();
    let places: Vec<_> = posed
        .instances
        .iter()
        .map(|i| (i.name.as_str(), i.world_from_local.translation.to_array()))
        .collect();
    assert_eq!(
        places,
        [("leaf[0]", [2.0, 0.0, 7.0]), ("leaf[1]", [0.0, 3.0, 7.0]), ("leaf[2]", [0.0, 0.0, 11.0])]
    );
    assert!(posed.instances.iter().all(|i| i.mesh.id() == posed.instances[0].mesh.id()));
    // Saved as the nodes they are.
    let again = gltf::load_slice(&gltf::to_glb(&loaded.scene).unwrap().bytes, None).unwrap();
    assert_eq!((again.scene.meshes().count(), again.scene.pose().unwrap().instances.len()), (1, 3));

    let refused = |attributes: Value, names: &[&str]| {
        let change =
            |d: &mut Value| d["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = attributes;
        let error = load(&instanced(change)).unwrap_err().to_string();
        assert!(names.iter().all(|name| error.contains(name)), "{error}");
    };
    refused(json!({}), &["'leaf'", "TRANSLATION, ROTATION or SCALE"]);
    refused(json!(3), &["'leaf'", "'attributes'"]);
    refused(json!({ "SCALE": "x" }), &["'leaf'", "'SCALE'", "accessor"]);
    refused(json!({ "SCALE": 99 }), &["SCALE", "99", "5"]);
    refused(json!({ "TRANSLATION": 4 }), &["TRANSLATION", "Vec3"]);
    refused(json!({ "ROTATION": 2 }), &["'leaf'", "instance 2", "without direction"]);
    let shorter = instanced(|d| {
        d["accessors"][0]["count"] = 2.into();
        d["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = 0.into();
        d["nodes"][0]["mesh"] = Value::Null;
        d["nodes"][0]["mesh"] = 0.into();
    });
    assert!(load(&shorter).unwrap_err().to_string().contains("entries"));
    let too_many = instanced(|d| {
        let sparse = json!({ "count": 1, "indices": { "bufferView": 2, "componentType": 5121 }, "values": { "bufferView": 0 } });
        d["accessors"][3] =
            json!({ "componentType": 5126, "count": 1 << 20, "type": "VEC3", "sparse": sparse });
    });
    let error = load(&too_many).unwrap_err();
    assert!(matches!(error, GltfError::TooLarge { .. }), "{error}");
}

#[test]
fn shadow_flags_of_nodes_meshes_primitives_and_lights() {
    let flags = |change: &dyn Fn(&mut Value)| {
        let posed = load(&document(|d| change(d))).unwrap().scene.pose().unwrap();
        let shadow = posed.instances[0].shadow;
        (shadow.casts, shadow.receives)
    };
    let extension = |value: Value| json!({ "KHR_lights_shadows": value });
    assert_eq!(flags(&|_| {}), (true, true));
    assert_eq!(flags(&|d| d["nodes"][0]["extras"] = json!({ "castShadow": false })), (false, true));
    assert_eq!(flags(&|d| d["meshes"][0]["extras"] = json!({ "receiveShadow": false })), (true, false));
    let primitive = json!({ "castShadow": false, "receiveShadow": false });
    assert_eq!(
        flags(&|d| d["meshes"][0]["primitives"][0]["extensions"] = extension(primitive.clone())),
        (false, false)
    );
    // A node knows better than its mesh.
    let both = |d: &mut Value| {
        d["meshes"][0]["extras"] = json!({ "castShadow": false });
        d["nodes"][0]["extras"] = json!({ "castShadow": true });
    };
    assert_eq!(flags(&both), (true, true));
    let light = |light: Value, node: Value| {
        let loaded = load(&document(|d| {
            d["extensions"] = json!({ "KHR_lights_punctual": { "lights": [light] } });
            d["nodes"][1]["extensions"] = json!({ "KHR_lights_punctual": { "light": 0 } });
            d["nodes"][1]["extras"] = node;
        }));
        loaded.unwrap().scene.lights().next().unwrap().1.casts_shadows
    };
    assert!(light(json!({ "type": "point" }), json!({})));
    assert!(!light(
        json!({ "type": "point", "extensions": extension(json!({ "castShadow": false })) }),
        json!({})
    ));
    assert!(!light(json!({ "type": "point", "extras": { "castShadow": false } }), json!({})));
    assert!(!light(json!({ "type": "point" }), json!({ "castShadow": false })));
}
