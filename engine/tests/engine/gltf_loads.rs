//! What exporters write loads as they mean it: zeros, WebP, packed buffers; files elsewhere and files that would take too
//! much memory are refused before they are read.

use crate::kinds::{base64, bytes_of, document, packed};
use glam::Vec3;
use serde_json::{Value, json};
use shadowgraph_engine::gltf::{self, GltfError, LoadOptions, Loaded};

fn load(document: &Value) -> Result<Loaded, GltfError> {
    gltf::load_slice(document.to_string().as_bytes(), None)
}

fn first_mesh(loaded: &Loaded) -> &shadowgraph_engine::geometry::MeshData {
    loaded.scene.meshes().next().unwrap().1.data()
}

#[test]
fn accessors_without_a_view_are_zero_but_for_what_is_sparse() {
    let mut document = document();
    document["accessors"][2] = json!({ "componentType": 5126, "count": 4, "type": "VEC2", "sparse": { "count": 1,
        "indices": { "bufferView": 7, "componentType": 5121 }, "values": { "bufferView": 2, "byteOffset": 16 } } });
    let loaded = load(&document).unwrap();
    let uvs: Vec<[f32; 2]> = first_mesh(&loaded).uvs.iter().map(|uv| uv.to_array()).collect();
    assert_eq!(uvs, [[0.0; 2], [1.0; 2], [0.0; 2], [0.0; 2]]);
}

/// Base64 in a URI may have its own letters escaped.
#[test]
fn escaped_base64_is_the_same() {
    let plain = load(&document()).unwrap();
    let mut document = document();
    let uri = document["buffers"][0]["uri"].as_str().unwrap().to_owned();
    let (head, data) = uri.split_once(',').unwrap();
    let escaped = data.replace('+', "%2B").replace('/', "%2f").replace('=', "%3D").replace('A', "%41");
    assert_ne!(data, escaped);
    document["buffers"][0]["uri"] = format!("{head},{escaped}").into();
    assert_eq!(first_mesh(&load(&document).unwrap()), first_mesh(&plain));
}

/// Shadow nodes that name every level of a deep chain, and a skin of very many joints down it: in time that grows with the
/// file, not with its square.
#[test]
fn deep_chains_with_lists_and_joints_take_no_longer_than_wide_ones() {
    const LEVELS: usize = 60_000;
    let mut document = document();
    let nodes = document["nodes"].as_array_mut().unwrap();
    nodes[5]["children"] = json!([6]);
    let level = |level: usize| json!({ "translation": [0.0, 1e-5, 0.0], "children": [7 + level] });
    nodes.extend((0..LEVELS).map(level));
    let last = nodes.len();
    nodes.push(json!({ "mesh": 0 }));
    let down: Vec<usize> = (6..last).collect();
    document["skins"][0]["joints"] = down.clone().into();
    let casters: Vec<usize> = down.into_iter().rev().collect();
    document["nodes"][3]["extensions"]["SHADOWGRAPH_shadow_node"]["casters"] = casters.into();
    let started = std::time::Instant::now();
    let loaded = load(&document).unwrap();
    let snapshot = loaded.scene.snapshot().unwrap();
    assert_eq!((snapshot.instances.len(), snapshot.shadow_nodes[0].casters.len()), (3, 1));
    let deepest = snapshot.instances.iter().find(|instance| instance.name == format!("node {last}")).unwrap();
    assert!((deepest.world_from_local.translation.y - 0.6).abs() < 1e-9);
    assert!(started.elapsed().as_secs() < 20, "{:?}", started.elapsed());
}

#[test]
fn webp_is_decoded_and_preferred() {
    let mut document = document();
    document["textures"][0] = json!({ "source": 0, "extensions": { "EXT_texture_webp": { "source": 1 } } });
    document["extensionsUsed"].as_array_mut().unwrap().push("EXT_texture_webp".into());
    document["extensionsRequired"] = json!(["EXT_texture_webp"]);
    let loaded = load(&document).unwrap();
    let images: Vec<_> = loaded.scene.images().map(|(_, image)| image).collect();
    assert_eq!((images.len(), images[0].name.as_str()), (1, "image1"));
    assert_eq!(images[0].rgba8, [200, 100, 50, 255].repeat(4));
}

#[test]
fn packed_vertices_and_triangles_are_unpacked() {
    let loaded = load(&packed()).unwrap();
    let data = first_mesh(&loaded);
    let grid: Vec<Vec3> = (0..20)
        .map(|i: u8| Vec3::new(f32::from(i % 5), f32::from(i / 5), if i == 7 { 0.5 } else { 0.0 }))
        .collect();
    assert_eq!(data.positions, grid);
    let mut wanted: Vec<[u32; 3]> = Vec::new();
    for corner in (0..3).flat_map(|y| (0..4).map(move |x| y * 5 + x)) {
        wanted.extend([[corner, corner + 1, corner + 5], [corner + 1, corner + 6, corner + 5]]);
    }
    wanted.push([19, 0, 7]);
    // Packing may turn a triangle, but not turn it over.
    let turned = |triangle: &[u32]| {
        let first = (0..3).min_by_key(|i| triangle[*i]).unwrap();
        [triangle[first], triangle[(first + 1) % 3], triangle[(first + 2) % 3]]
    };
    let found: Vec<[u32; 3]> = data.indices.chunks(3).map(turned).collect();
    assert_eq!(found, wanted.iter().map(|triangle| turned(triangle)).collect::<Vec<_>>());
}

/// A document with a buffer for each of the filters: a sequence of indices, normals, translations and rotations.
fn packed_by_filters() -> Value {
    let mut document = packed();
    document["accessors"].as_array_mut().unwrap().resize(5, Value::Null);
    let mut set = |place: usize, hex: &str, extension: Value, accessor: Value| {
        let bytes = bytes_of(hex);
        let uri = format!("data:application/octet-stream;base64,{}", base64(&bytes));
        document["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": bytes.len(), "uri": uri }));
        let buffer = document["buffers"].as_array().unwrap().len() - 1;
        let mut packed = extension;
        packed["buffer"] = buffer.into();
        packed["byteLength"] = bytes.len().into();
        let length = packed["count"].as_u64().unwrap() * packed["byteStride"].as_u64().unwrap();
        document["bufferViews"].as_array_mut().unwrap().push(json!({ "buffer": 1, "byteLength": length,
            "byteStride": packed["byteStride"], "extensions": { "EXT_meshopt_compression": packed } }));
        let view = document["bufferViews"].as_array().unwrap().len() - 1;
        document["accessors"][place] = accessor;
        document["accessors"][place]["bufferView"] = view.into();
    };
    // The same triangles as a sequence; normals of the unit octahedron; floats of 8 and 24 bits.
    let sequence = "d10004100e14020e04100e14020e04100e14020e04100e14020a04100e14020e04100e14020e04100e14020e04100e14020a\
                    04100e14020e04100e14020e04100e14020e04100e1402044a1c00000000"
        .replace(' ', "");
    set(
        1,
        &sequence,
        json!({ "mode": "INDICES", "byteStride": 4, "count": 75 }),
        json!({ "componentType": 5125, "count": 75, "type": "SCALAR" }),
    );
    set(
        2,
        "a0013f000000fefd58013f0000009270bb00000000000000000000000000000000000000000000000000000000000000007f7f",
        json!({ "mode": "ATTRIBUTES", "filter": "OCTAHEDRAL", "byteStride": 4, "count": 4 }),
        json!({ "componentType": 5120, "normalized": true, "count": 4, "type": "VEC3" }),
    );
    set(3, "a001300000002b01300000001c0001300000001f000130000000400120000000000130000000ff0130000000eb011000000001300000000d\
            0000000000000000000000000000000000000000003000f300e0fff1803e00fc".replace(' ', "").as_str(),
        json!({ "mode": "ATTRIBUTES", "filter": "EXPONENTIAL", "byteStride": 12, "count": 2 }),
        json!({ "componentType": 5126, "count": 2, "type": "VEC3" }));
    set(4, "a00130000000fc0130000000b3013c000000fcc7013c000000b3d80130000000fc0130000000b3013c000000060500000000000000\
            000000000000000000000000000000000000825a825a825afc7f".replace(' ', "").as_str(),
        json!({ "mode": "ATTRIBUTES", "filter": "QUATERNION", "byteStride": 8, "count": 3 }),
        json!({ "componentType": 5122, "normalized": true, "count": 3, "type": "VEC4" }));
    document["extensionsUsed"] = json!(["EXT_meshopt_compression", "EXT_mesh_gpu_instancing"]);
    document["nodes"] = json!([
        { "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 3 } } } },
        { "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": { "attributes": { "ROTATION": 4 } } } },
        { "mesh": 1 }]);
    document["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
    document["accessors"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" }));
    document["meshes"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "primitives": [{ "attributes": { "POSITION": 5, "NORMAL": 2 } , "mode": 5 }] }));
    document
}

#[test]
fn packed_indices_and_filters_are_unpacked() {
    let loaded = load(&packed_by_filters()).unwrap();
    let snapshot = loaded.scene.snapshot().unwrap();
    assert_eq!(snapshot.instances[0].mesh.triangle_count(), 25);
    let places: Vec<[f64; 3]> =
        snapshot.instances[..2].iter().map(|i| i.world_from_local.translation.to_array()).collect();
    assert_eq!(places[0], [1.5, -0.25, 1000.0]);
    assert!((places[1][0] - 3e-5).abs() < 1e-9 && places[1][2] == -7.0, "{places:?}");
    let turned: Vec<glam::DQuat> = snapshot.instances[2..5]
        .iter()
        .map(|i| i.world_from_local.to_scale_rotation_translation().1)
        .collect();
    for (found, wanted) in turned.iter().zip([[0.5; 4], [0.0, 0.0, 0.0, 1.0], [0.8, 0.0, 0.6, 0.0]]) {
        let wanted = glam::DQuat::from_array(wanted);
        assert!(found.dot(wanted).abs() > 1.0 - 1e-8, "{found} is not {wanted}");
    }
    let normals: Vec<Vec3> = snapshot.instances[5].mesh.data().normals.clone();
    let wanted = [[0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [0.0, -1.0, 0.0], [0.6, 0.48, 0.64]].map(Vec3::from);
    assert!(normals.iter().zip(wanted).all(|(found, wanted)| found.distance(wanted) < 0.01), "{normals:?}");
}

#[test]
fn packed_data_that_are_damaged_are_refused_by_name() {
    let refused = |path: &str, value: Value, says: &str| {
        let mut document = packed();
        *document.pointer_mut(path).unwrap() = value;
        let error = load(&document).unwrap_err();
        assert!(matches!(error, GltfError::Compressed { .. }) && error.to_string().contains(says), "{error}");
        assert!(error.to_string().contains("buffer view 0"), "{error}");
    };
    let extension = "/bufferViews/0/extensions/EXT_meshopt_compression";
    refused(&format!("{extension}/mode"), json!("POINTS"), "ATTRIBUTES");
    refused(&format!("{extension}/byteStride"), json!(10), "byteStride");
    refused(&format!("{extension}/count"), json!(400), "too early");
    refused(&format!("{extension}/count"), json!(10), "end");
    refused(&format!("{extension}/byteLength"), json!(40), "");
    refused("/bufferViews/0/byteLength", json!(500), "its byteLength says 500");
}

/// Two folders: the scene's, and one beside it that is not the scene's business.
struct Folders(std::path::PathBuf);

impl Folders {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("shadowgraph-{name}-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("scene/data")).unwrap();
        std::fs::create_dir_all(folder.join("other")).unwrap();
        Self(folder)
    }

    /// Writes the document with its buffer at `uri`, whose bytes go to `file`.
    fn write(&self, uri: &str, file: &str) -> std::path::PathBuf {
        let mut document = document();
        let data = document["buffers"][0]["uri"].take();
        let bytes = image_bytes(data.as_str().unwrap());
        std::fs::write(self.0.join(file), bytes).unwrap();
        document["buffers"][0]["uri"] = uri.into();
        let path = self.0.join("scene/scene.gltf");
        std::fs::write(&path, document.to_string()).unwrap();
        path
    }
}

impl Drop for Folders {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The bytes of a base64 data URI.
fn image_bytes(uri: &str) -> Vec<u8> {
    let letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let data = uri.split_once(',').unwrap().1.trim_end_matches('=');
    let mut bytes = Vec::new();
    let (mut bits, mut count) = (0_u32, 0);
    for letter in data.chars() {
        bits = bits << 6 | letters.find(letter).unwrap() as u32;
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
        }
    }
    bytes
}

#[test]
fn files_outside_the_folder_are_read_only_when_asked_for() {
    let folders = Folders::new("outside");
    for (uri, file) in
        [("data/a.bin", "scene/data/a.bin"), ("data/../b.bin", "scene/b.bin"), ("%61.bin", "scene/a.bin")]
    {
        let loaded = gltf::load(folders.write(uri, file)).unwrap();
        let read: Vec<_> = loaded.files.iter().map(|path| path.canonicalize().unwrap()).collect();
        assert_eq!(
            read,
            [folders.0.join("scene/scene.gltf"), folders.0.join(file)].map(|p| p.canonicalize().unwrap())
        );
    }
    let mut outside = vec![
        ("../other/a.bin", "other/a.bin"),
        ("%2e%2e/other/a.bin", "other/a.bin"),
        ("..%2Fother%2Fa.bin", "other/a.bin"),
    ];
    if cfg!(unix) {
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("../other", folders.0.join("scene/linked")).unwrap();
            std::os::unix::fs::symlink("../other/a.bin", folders.0.join("scene/link.bin")).unwrap();
        }
        outside.extend([("linked/a.bin", "other/a.bin"), ("link.bin", "other/a.bin")]);
    }
    for (uri, file) in outside {
        let path = folders.write(uri, file);
        let error = gltf::load(&path).unwrap_err();
        assert!(matches!(error, GltfError::OutsideFile { .. }), "{uri}: {error}");
        assert!(
            ["buffer 0", "--outside-files", "outside_files"]
                .iter()
                .all(|word| error.to_string().contains(word)),
            "{error}"
        );
        let options = LoadOptions { outside_files: true, ..LoadOptions::default() };
        assert_eq!(gltf::load_with(&path, &options).unwrap().files.len(), 2);
    }
}

/// A picture of 16384 by 16384 texels, one bit each, takes 33 KB as a file; what it says of itself is enough to refuse it.
#[test]
fn what_an_image_takes_is_known_before_it_is_decoded() {
    let mut png = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |kind: &[u8; 4], data: &[u8]| {
        png.extend((data.len() as u32).to_be_bytes());
        let body = [kind, data].concat();
        png.extend(&body);
        let crc = body.iter().fold(u32::MAX, |crc, byte| {
            (0..8).fold(
                crc ^ u32::from(*byte),
                |crc, _| if crc & 1 == 1 { crc >> 1 ^ 0xEDB8_8320 } else { crc >> 1 },
            )
        });
        png.extend((!crc).to_be_bytes());
    };
    let side = 16384_u32.to_be_bytes();
    chunk(b"IHDR", &[&side[..], &side, &[1, 0, 0, 0, 0]].concat());
    chunk(b"IDAT", &[0x78, 0x9C]);
    chunk(b"IEND", b"");
    let mut document = document();
    document["images"][0] =
        json!({ "name": "wide", "uri": format!("data:image/png;base64,{}", base64(&png)) });
    let started = std::time::Instant::now();
    let error = load(&document).unwrap_err();
    assert!(matches!(error, GltfError::Memory { .. }), "{error}");
    assert!(error.to_string().contains("'wide'") && error.to_string().contains("memory"), "{error}");
    assert!(started.elapsed().as_secs_f64() < 1.0);
    // With memory enough it is tried, and found to be cut short.
    let options = LoadOptions { memory_budget: Some(8 << 30), ..LoadOptions::default() };
    let error = gltf::load_slice_with(document.to_string().as_bytes(), None, &options).unwrap_err();
    assert!(matches!(error, GltfError::Image { .. }), "{error}");
}

#[test]
fn what_a_mesh_takes_is_known_before_it_is_read() {
    let mut document = document();
    let options =
        |memory_budget| LoadOptions { memory_budget: Some(memory_budget), ..LoadOptions::default() };
    let load = |document: &Value, budget| {
        gltf::load_slice_with(document.to_string().as_bytes(), None, &options(budget))
    };
    load(&document, 4096).unwrap();
    let error = load(&document, 256).unwrap_err();
    assert!(matches!(error, GltfError::Memory { limit: 256, .. }), "{error}");
    // One accessor that a thousand primitives name is charged a thousand times.
    let primitive = document["meshes"][1]["primitives"][0].clone();
    document["meshes"][1]["primitives"] = vec![primitive; 1000].into();
    assert!(matches!(load(&document, 64 << 10), Err(GltfError::Memory { .. })));
}
