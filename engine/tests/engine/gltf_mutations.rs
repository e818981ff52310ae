//! Whatever the bytes, loading ends in bounded time with a scene or an error.
//!
//! `FUZZ_INPUTS=1000000` runs more inputs than the default, `FUZZ_SEED=7` others.

use std::time::{Duration, Instant};

use glam::{DAffine3, DVec3, Vec3};
use serde_json::{Value, json};
use shadowgraph_engine::geometry::{Influences, Mesh, MeshData, MorphTarget};
use shadowgraph_engine::gltf;
use shadowgraph_engine::math::Projection;
use shadowgraph_engine::scene::{
    Animation, Camera, Channel, Content, Image, Interpolation, Light, Material, Property, Scene, ShadowNode,
    Skin, TextureRef, Track, Wrap,
};

/// A small random generator (SplitMix64): the same inputs on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }
}

/// A saved scene with a bit of everything.
fn saved() -> Vec<u8> {
    let mut scene = Scene::new();
    let rgba8 = vec![200; 16];
    let image = scene.add_image(std::sync::Arc::new(Image { name: "i".into(), width: 2, height: 2, rgba8 }));
    let texture = TextureRef { wrap: [Wrap::Clamp; 2], ..TextureRef::new(image) };
    let material = Material {
        base_color_texture: Some(texture),
        normal_texture: Some((texture, 1.0)),
        transmission: 0.5,
        emissive: Vec3::splat(3.0),
        ..Material::default()
    };
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let data = MeshData {
        name: "m".into(),
        uvs: positions.iter().map(|p| p.truncate()).collect(),
        positions,
        indices: vec![0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3],
        ..MeshData::default()
    };
    let caster = scene.add_mesh(Mesh::new(data).unwrap(), material, DAffine3::from_translation(DVec3::X));
    let lamp = scene.add_light(Light::spot("lamp", 9.0, 0.5).with_range(9.0), DVec3::Y * 3.0, DVec3::ZERO);
    scene.add_camera(Camera::perspective("eye", 0.8), DVec3::Z * 3.0, DVec3::ZERO);
    let projection = Projection::Orthographic { half_height_m: 2.0, near_m: 0.0, far_m: 9.0 };
    scene.add_camera(Camera { name: "plan".into(), projection }, DVec3::Y * 3.0, DVec3::ZERO);
    scene.add_shadow("s", ShadowNode::new("Any").with_lights([lamp]).with_casters([caster]));
    gltf::to_glb(&scene).unwrap().bytes
}

/// A saved scene in which everything moves: a skin of two joints, morph targets, three kinds of keys.
fn moving() -> Vec<u8> {
    let mut scene = Scene::new();
    let lower = scene.add_group("lower");
    let upper = scene.add(Some(lower), "upper", DAffine3::from_translation(DVec3::Y), Content::Group);
    let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let data = MeshData {
        name: "bent".into(),
        influences: (0..4).map(|i| Influences::new([(0, 0.5), (i % 2, 0.5)])).collect(),
        morphs: vec![
            MorphTarget {
                name: "a".into(),
                positions: positions.clone(),
                normals: positions.clone(),
                weight: 0.5,
            },
            MorphTarget { name: "b".into(), positions: vec![Vec3::X; 4], ..MorphTarget::default() },
        ],
        positions,
        indices: vec![0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3],
        ..MeshData::default()
    };
    let node = scene.add_mesh(Mesh::new(data).unwrap(), Material::default(), DAffine3::IDENTITY);
    let binds = vec![DAffine3::IDENTITY, DAffine3::from_translation(-DVec3::Y)];
    let skin = scene.add_skin(Skin::new("skin", vec![lower, upper], binds)).unwrap();
    if let Content::Mesh(content) = &mut scene.node_mut(node).unwrap().content {
        content.skin = Some(skin);
        content.weights = vec![0.25, 0.5];
    }
    let track = |property, interpolation, values: &[f32]| {
        Track::new(property, interpolation, vec![0.0, 1.5], values.to_vec()).unwrap()
    };
    let channels = vec![
        Channel::new(
            lower,
            track(Property::Rotation, Interpolation::Linear, &[0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]),
        ),
        Channel::new(upper, track(Property::Scale, Interpolation::Step, &[1.0, 1.0, 1.0, 2.0, 0.0, -1.0])),
        Channel::new(node, track(Property::Weights, Interpolation::CubicSpline, &[0.5; 12])),
    ];
    scene.add_animation(Animation::new("clip", channels)).unwrap();
    gltf::to_glb(&scene).unwrap().bytes
}

/// Hand-written: sparse accessors (of a morph target too), strip, fan, data URI, skin, quantised attributes, instances,
/// an animation with small integers, shadow flags.
fn handwritten() -> Vec<u8> {
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0], "name": "a" }, { "nodes": [1] }],
        "nodes": [
            { "mesh": 0, "children": [1, 2], "translation": [1, 2, 3], "skin": 0, "weights": [0.5] },
            { "rotation": [0, 0, 0, 1], "mesh": 0 },
            { "mesh": 1, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 1, "SCALE": 0 } } } }],
        "skins": [{ "joints": [1, 0] }],
        "animations": [{ "samplers": [{ "input": 5, "output": 4 }, { "input": 5, "output": 5, "interpolation": "STEP" }],
            "channels": [{ "sampler": 0, "target": { "node": 1, "path": "rotation" } },
                { "sampler": 1, "target": { "node": 0, "path": "weights" } }] }],
        "meshes": [
            { "weights": [0.1], "primitives": [
                { "attributes": { "POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 2 }, "mode": 5, "targets": [{ "POSITION": 0 }] },
                { "attributes": { "POSITION": 0, "JOINTS_0": 2, "WEIGHTS_0": 2 }, "mode": 0 }] },
            { "extras": { "castShadow": false }, "primitives": [{ "attributes": { "POSITION": 1, "COLOR_0": 4 }, "mode": 6,
                "indices": 3, "extensions": { "KHR_lights_shadows": { "castShadow": true } } }] }],
        "accessors": [
            { "componentType": 5126, "count": 4, "type": "VEC3", "sparse": { "count": 2,
              "indices": { "bufferView": 0, "componentType": 5121 }, "values": { "bufferView": 1 } } },
            { "bufferView": 1, "componentType": 5122, "normalized": true, "count": 4, "type": "VEC3" },
            { "bufferView": 2, "componentType": 5121, "count": 4, "type": "VEC4" },
            { "bufferView": 0, "componentType": 5121, "count": 4, "type": "SCALAR" },
            { "bufferView": 2, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4" },
            { "componentType": 5126, "count": 4, "type": "SCALAR", "sparse": { "count": 1,
              "indices": { "bufferView": 3, "componentType": 5121 }, "values": { "bufferView": 4 } } }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 4 },
            { "buffer": 0, "byteOffset": 4, "byteLength": 32, "byteStride": 8 },
            { "buffer": 0, "byteOffset": 36, "byteLength": 16 },
            { "buffer": 0, "byteOffset": 52, "byteLength": 1 },
            { "buffer": 0, "byteOffset": 56, "byteLength": 4 }],
        // Two places and two points; 16 bytes of joints, weights or quaternions, all 0 or 1; the place 3, the time 1.
        "buffers": [{ "byteLength": 60, "uri": "data:;base64,AQIDAAAAAAAAAAAAAAAAAAAAgD8AAIA/AAAAAAAAAAAAAAAAAAAAAQABAAEBAAABAQEAAQMAAAAAAIA/" }],
    })
    .to_string()
    .into_bytes()
}

/// The document of all kinds of files, its texture in WebP.
fn webp() -> Value {
    let mut document = crate::kinds::document();
    document["textures"][0] = json!({ "source": 0, "extensions": { "EXT_texture_webp": { "source": 1 } } });
    document
}

/// The same with instances, a morph target and sparse accessors.
fn instanced() -> Value {
    let mut document = crate::kinds::document();
    document["nodes"][0]["extensions"] =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0, "_ID": 4 } } });
    let sparse = json!({ "count": 1, "indices": { "bufferView": 7, "componentType": 5121 }, "values": { "bufferView": 1 } });
    document["accessors"][1]["sparse"] = sparse.clone();
    document["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse }));
    document["meshes"][1]["primitives"][0]["targets"] = json!([{ "POSITION": 9 }]);
    document["meshes"][1]["weights"] = json!([0.5]);
    document
}

/// The most memory that this process had at once, in bytes, where the system says so.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().split(' ').next()?.parse::<u64>().ok()? << 10)
}

fn split(glb: &[u8]) -> (Value, &[u8]) {
    if !glb.starts_with(b"glTF") {
        return (serde_json::from_slice(glb).unwrap(), &[]);
    }
    let size = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    (serde_json::from_slice(&glb[20..20 + size]).unwrap(), &glb[28 + size..])
}

fn joined(json: &Value, bin: &[u8]) -> Vec<u8> {
    let mut text = json.to_string().into_bytes();
    if bin.is_empty() {
        return text;
    }
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + text.len() as u32 + bin.len() as u32).to_le_bytes());
    glb.extend((text.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(text);
    glb.extend((bin.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(bin);
    glb
}

/// Paths to every value of a document.
fn paths(value: &Value, path: &str, out: &mut Vec<String>) {
    out.push(path.to_owned());
    match value {
        Value::Array(values) => {
            values.iter().enumerate().for_each(|(i, v)| paths(v, &format!("{path}/{i}"), out));
        }
        Value::Object(object) => object.iter().for_each(|(k, v)| paths(v, &format!("{path}/{k}"), out)),
        _ => {}
    }
}

/// Replaces a random value by something that might hurt.
fn edit(json: &mut Value, random: &mut Random) {
    let mut all = Vec::new();
    paths(json, "", &mut all);
    let other = json.pointer(&all[random.below(all.len())]).cloned().unwrap_or_default();
    let huge = [u64::MAX, 1 << 32, u64::from(u32::MAX), 1 << 62, 4_194_304, 2_147_483_647];
    let replacement = match random.below(12) {
        0 => json!(huge[random.below(huge.len())]),
        1 => json!(-1),
        2 => json!(random.below(8)),
        3 => json!(1e300),
        4 => Value::Null,
        5 => json!("nonsense\u{0}%zz"),
        6 => json!([]),
        7 => json!({}),
        8 => json!(0.5),
        9 => json!(["VEC2", "VEC4", "SCALAR"][random.below(3)]),
        _ => other,
    };
    let path = &all[random.below(all.len())];
    if let Some(slot) = json.pointer_mut(path) {
        match slot {
            Value::Object(object) if random.below(2) == 0 && !object.is_empty() => {
                let key = object.keys().nth(random.below(object.len())).cloned().unwrap_or_default();
                object.remove(&key);
            }
            Value::Array(values) if random.below(2) == 0 => values.push(replacement),
            // What is packed or encoded in a data URI stays readable for the most part.
            Value::String(text) if random.below(2) == 0 && text.len() > 100 && text.is_ascii() => {
                let place = text.len() / 4 + random.below(text.len() / 2);
                let letter = ["A", "/", "8", "q", "%", "="][random.below(6)];
                text.replace_range(place..=place, letter);
            }
            slot => *slot = replacement,
        }
    }
}

#[test]
fn mutated_files_neither_panic_nor_hang() {
    let setting = |name: &str| std::env::var(name).ok().and_then(|value| value.parse::<u64>().ok());
    let inputs = setting("FUZZ_INPUTS").unwrap_or(20_000);
    let mut random = Random(setting("FUZZ_SEED").unwrap_or(1));
    let documents =
        [webp(), instanced(), crate::kinds::packed()].map(|document| document.to_string().into_bytes());
    let seeds: Vec<Vec<u8>> = [saved(), moving(), handwritten()].into_iter().chain(documents).collect();
    for seed in &seeds {
        gltf::load_slice(seed, None).unwrap().scene.snapshot().unwrap();
    }
    let (mut loaded, mut slowest) = (0_u64, Duration::ZERO);
    for input in 0..inputs {
        let seed = &seeds[random.below(seeds.len())];
        let mut bytes = seed.clone();
        if random.below(3) > 0 {
            let (mut json, bin) = split(seed);
            for _ in 0..=random.below(3) {
                edit(&mut json, &mut random);
            }
            bytes = joined(&json, bin);
        }
        if random.below(3) == 0 {
            for _ in 0..=random.below(4) {
                let place = random.below(bytes.len());
                bytes[place] = random.next() as u8;
            }
        }
        if random.below(8) == 0 {
            bytes.truncate(random.below(bytes.len()));
        }
        let start = Instant::now();
        if let Ok(mut scene) = gltf::load_slice(&bytes, None) {
            loaded += 1;
            // What loads can be posed or refused at any time, and saved or refused, without a panic.
            for seconds in [0.0, 0.7, 1e9] {
                let _ = scene.scene.animate_all(seconds);
                let _ = scene.scene.snapshot();
            }
            let _ = gltf::to_glb(&scene.scene);
        }
        let elapsed = start.elapsed();
        slowest = slowest.max(elapsed);
        assert!(elapsed < Duration::from_secs(10), "input {input} took {elapsed:?}");
    }
    let peak = peak_bytes().unwrap_or(0);
    eprintln!(
        "{loaded} of {inputs} mutated files loaded; the slowest took {slowest:?}; {} MiB at most",
        peak >> 20
    );
    // The budget of one load, once more for the scene that is posed and saved, and what the allocator keeps.
    assert!(peak < 5 << 30, "{peak} bytes");
    // A test of mutations that all fail at the first check would test little.
    assert!(loaded > inputs / 20 && loaded < inputs, "{loaded} of {inputs} loaded");
}
