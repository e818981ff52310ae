//! Documents with skins, morph targets, animations and instances, changed one field at a time.

use glam::DVec3;
use serde_json::{Value, json};
use shadowgraph_engine::gltf::{self, GltfError, LoadOptions, SceneChoice};
use shadowgraph_engine::scene::Scene;

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
        let snapshot = scene.snapshot().unwrap();
        [0, 1, 2].map(|vertex| snapshot.instances[0].world_position(vertex))
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
        loaded.scene.snapshot().unwrap();
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
    let bent = loaded.scene.snapshot().unwrap().instances.remove(0);
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
    let snapshot = loaded.scene.snapshot().unwrap();
    let places: Vec<_> = snapshot
        .instances
        .iter()
        .map(|i| (i.name.as_str(), i.world_from_local.translation.to_array()))
        .collect();
    assert_eq!(
        places,
        [("leaf[0]", [2.0, 0.0, 7.0]), ("leaf[1]", [0.0, 3.0, 7.0]), ("leaf[2]", [0.0, 0.0, 11.0])]
    );
    assert!(snapshot.instances.iter().all(|i| i.mesh.id() == snapshot.instances[0].mesh.id()));
    // Saved as the nodes they are.
    let again = gltf::load_slice(&gltf::to_glb(&loaded.scene).unwrap().bytes, None).unwrap();
    assert_eq!((again.scene.meshes().count(), again.scene.snapshot().unwrap().instances.len()), (1, 3));

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
        let snapshot = load(&document(|d| change(d))).unwrap().scene.snapshot().unwrap();
        let shadow = snapshot.instances[0].shadow;
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
