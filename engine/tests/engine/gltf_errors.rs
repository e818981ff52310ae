//! Each kind of fault is one typed error that names the thing; what the specification allows loads.

use serde_json::{Value, json};
use shadowgraph_engine::gltf::{self, GltfError, LoadOptions, Loaded, SceneChoice, ShadowTypes};
use shadowgraph_engine::scene::{Content, LightKind, ShadowNode};

/// A document with one triangle, a light and a camera, for breaking.
fn document() -> Value {
    json!({
        "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }],
        "nodes": [
            { "name": "shape", "mesh": 0, "children": [3] },
            { "name": "lamp", "extensions": { "KHR_lights_punctual": { "light": 0 } } },
            { "name": "eye", "camera": 0 },
            { "name": "leaf" }, { "name": "elsewhere", "mesh": 0 }],
        "extensions": { "KHR_lights_punctual": { "lights": [
            { "type": "spot", "spot": { "outerConeAngle": 0.5 }, "extras": { "castShadow": false } }] } },
        "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 0.1, "zfar": 10 } }],
        "meshes": [{ "name": "triangle", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "materials": [{ "name": "grey" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR" }],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 6 }],
        "buffers": [{ "byteLength": 54, "uri": data_uri(&buffer([1.0, 0.0, 0.0])) }],
    })
}

/// Four positions, the second of them given, and the indices 0 1 2 0 2 3.
fn buffer(second: [f32; 3]) -> Vec<u8> {
    let positions = [[0.0; 3], second, [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|x: &f32| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3]);
    bytes
}

fn data_uri(bytes: &[u8]) -> String {
    let hex: String = bytes.iter().map(|byte| format!("%{byte:02X}")).collect();
    format!("data:application/octet-stream,{hex}")
}

fn load(document: &Value) -> Result<Loaded, GltfError> {
    gltf::load_slice(document.to_string().as_bytes(), None)
}

/// The document with `path` set to `value` (appended at `/-`).
fn with(path: &str, value: Value) -> Value {
    let mut document = document();
    set(&mut document, path, value);
    document
}

fn set(document: &mut Value, path: &str, value: Value) {
    let (parent, key) = path.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Array(values) if key == "-" => values.push(value),
        Value::Array(values) => values[key.parse::<usize>().unwrap()] = value,
        object => object[key] = value,
    }
}

macro_rules! refused {
    ($document:expr, $pattern:pat, $($says:literal),+) => {
        let error = load(&$document).expect_err("it should be refused");
        let text = error.to_string();
        assert!(matches!(error, $pattern), "{error:?}");
        $(assert!(text.contains($says), "'{text}' does not say '{}'", $says);)+
    };
}

#[test]
fn the_document_loads() {
    let loaded = load(&document()).unwrap();
    let snapshot = loaded.scene.snapshot().unwrap();
    assert_eq!((snapshot.instances.len(), snapshot.lights.len(), snapshot.cameras.len()), (1, 1, 1));
    assert_eq!(snapshot.instances[0].mesh.triangle_count(), 2);
    // No normals: flat ones, on vertices of their own.
    assert_eq!(snapshot.instances[0].mesh.positions().len(), 6);
    assert_eq!(snapshot.lights[0].name, "lamp");
    assert!(!snapshot.lights[0].light.casts_shadows);
    assert!(matches!(snapshot.lights[0].light.kind, LightKind::Spot { outer_rad: 0.5, inner_rad: 0.0 }));
    assert_eq!(loaded.node_keys.iter().filter(|key| key.is_some()).count(), 4);
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
}

#[test]
fn containers_and_json() {
    for bytes in [
        &b"glTF"[..],
        b"glTF\x02\0\0\0\x0C\0\0\0",
        b"glTF\x02\0\0\0\x01\0\0\0",
        b"glTF\x02\0\0\0\xFF\0\0\0{}",
    ] {
        assert!(matches!(gltf::load_slice(bytes, None), Err(GltfError::Glb { .. })), "{bytes:?}");
    }
    let old = b"glTF\x01\0\0\0\x14\0\0\0........";
    assert!(matches!(gltf::load_slice(old, None), Err(GltfError::Version { .. })));
    for bytes in [&b""[..], b"\0\0", b"{", b"[]", b"\xFF\xFE{}"] {
        assert!(matches!(gltf::load_slice(bytes, None), Err(GltfError::Json { .. })), "{bytes:?}");
    }
    assert!(matches!(gltf::load("/no/such/file.glb"), Err(GltfError::Io { .. })));
    assert!(matches!(gltf::load(env!("CARGO_MANIFEST_DIR")), Err(GltfError::NotAFile { .. })));
    refused!(with("/asset/version", json!("1.0")), GltfError::Version { .. }, "1.0", "2.0");
    refused!(with("/accessors", json!({ "count": 2 })), GltfError::Json { .. }, "'accessors'", "array");
    refused!(
        with("/accessors/0/count", json!("many")),
        GltfError::Invalid { .. },
        "accessors[0].count",
        "many"
    );
    let braces = "{".repeat(5_000_000);
    assert!(matches!(gltf::load_slice(braces.as_bytes(), None), Err(GltfError::TooLarge { .. })));
}

#[test]
fn extensions() {
    let draco = with("/extensionsRequired", json!(["KHR_draco_mesh_compression"]));
    refused!(draco, GltfError::UnsupportedExtension { .. }, "Draco", "re-export");
    let other = with("/extensionsRequired", json!(["EXT_unheard_of"]));
    refused!(other, GltfError::UnsupportedExtension { .. }, "EXT_unheard_of", "KHR_lights_punctual");
    load(&with("/extensionsRequired", json!(["KHR_mesh_quantization", "KHR_lights_punctual"]))).unwrap();
}

#[test]
fn buffers_and_accessors() {
    refused!(with("/buffers/0/byteLength", json!(55)), GltfError::BufferLength { .. }, "55", "54");
    refused!(with("/buffers/0", json!({ "byteLength": 4 })), GltfError::MissingBin { .. }, "buffer 0");
    for uri in ["https://example.org/a.bin", "/a.bin", "file:a.bin"] {
        refused!(
            with("/buffers/0/uri", json!(uri)),
            GltfError::Uri { .. },
            "buffer 0",
            "absolute",
            "relative"
        );
    }
    refused!(with("/buffers/0/uri", json!("a.bin")), GltfError::Uri { .. }, "a.bin", "base directory");
    refused!(with("/buffers/0/uri", json!("data:;base64,?")), GltfError::Uri { .. }, "base64");
    refused!(with("/bufferViews/0/byteOffset", json!(7)), GltfError::ViewRange { .. }, "view 0", "7..55");
    refused!(with("/bufferViews/0/byteOffset", json!(u64::MAX)), GltfError::ViewRange { .. }, "view 0");
    refused!(with("/bufferViews/0/buffer", json!(9)), GltfError::Invalid { .. }, "bufferViews[0].buffer");
    refused!(with("/accessors/0/count", json!(5)), GltfError::AccessorRange { .. }, "accessor 0", "60", "48");
    refused!(with("/accessors/0/count", json!(u64::MAX)), GltfError::AccessorRange { .. }, "accessor 0");
    refused!(with("/accessors/0/count", json!(0)), GltfError::Accessor { .. }, "accessor 0", "at least 1");
    refused!(with("/accessors/0/type", json!("VEC2")), GltfError::Accessor { .. }, "POSITION", "Vec3");
    refused!(with("/accessors/1/componentType", json!(5126)), GltfError::Accessor { .. }, "U8, U16 or U32");
    refused!(with("/bufferViews/0/byteStride", json!(8)), GltfError::Accessor { .. }, "byteStride 8", "12");
    refused!(
        with("/meshes/0/primitives/0/attributes/POSITION", json!(77)),
        GltfError::Invalid { .. },
        "POSITION",
        "triangle",
        "77"
    );
    let not_finite = with("/buffers/0/uri", json!(data_uri(&buffer([1.0, f32::NAN, 0.0]))));
    refused!(not_finite, GltfError::Accessor { .. }, "element 1", "finite");
    let far = with("/buffers/0/uri", json!(data_uri(&buffer([1e19, 0.0, 0.0]))));
    refused!(far, GltfError::Mesh { .. }, "triangle", "1e18");
    let sparse = |count: u64, sparse_count: u64| {
        let values = json!({ "bufferView": 0 });
        let indices = json!({ "bufferView": 1, "componentType": 5121 });
        let sparse = json!({ "count": sparse_count, "indices": indices, "values": values });
        with(
            "/accessors/0",
            json!({ "componentType": 5126, "count": count, "type": "VEC3", "sparse": sparse }),
        )
    };
    load(&sparse(4, 3)).unwrap();
    refused!(sparse(4, 4), GltfError::Accessor { .. }, "sparse index 0");
    refused!(sparse(4, 5), GltfError::Accessor { .. }, "5 sparse values");
    refused!(sparse(1 << 40, 1), GltfError::TooLarge { .. }, "accessor 0");
}

#[test]
fn meshes() {
    let mut bytes = buffer([1.0, 0.0, 0.0]);
    bytes[50] = 4;
    let out = with("/buffers/0/uri", json!(data_uri(&bytes)));
    refused!(out, GltfError::VertexIndex { .. }, "mesh 0, primitive 0", "index 4 at place 2", "4 vertices");
    refused!(with("/accessors/1/count", json!(5)), GltfError::Primitive { .. }, "5 indices");
    refused!(with("/meshes/0/primitives/0/mode", json!(9)), GltfError::Invalid { .. }, "mode");
    refused!(with("/meshes/0/primitives/0/material", json!(9)), GltfError::Invalid { .. }, "material");
    let count = |mode: u32| {
        let loaded =
            load(&with("/meshes/0/primitives/0", json!({ "attributes": { "POSITION": 0 }, "mode": mode })));
        let loaded = loaded.unwrap();
        (loaded.scene.meshes().next().unwrap().1.triangle_count(), loaded.warnings.len())
    };
    assert_eq!([0, 1, 2, 3, 5, 6].map(count), [(0, 1), (0, 1), (0, 1), (0, 1), (2, 0), (2, 0)]);
}

#[test]
fn images() {
    let mut document = document();
    document["images"] = json!([{ "name": "logo", "bufferView": 0 }]);
    document["textures"] = json!([{ "source": 0 }]);
    document["materials"] = json!([{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }]);
    document["meshes"][0]["primitives"][0]["material"] = 0.into();
    refused!(document, GltfError::Image { .. }, "logo", "PNG and JPEG");
    // A PNG that claims to be enormous and holds nothing.
    let mut png = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\x01\0\0\0\x01\0\0\x08\x06\0\0\0".to_vec();
    png.extend([0; 8]);
    document["images"] = json!([{ "name": "logo", "uri": data_uri(&png) }]);
    refused!(document, GltfError::Image { .. }, "logo");
    document["images"] = json!([{ "name": "logo", "uri": "http://x/y.png" }]);
    refused!(document, GltfError::Uri { .. }, "logo", "absolute");
    document["textures"] = json!([{ "source": 3 }]);
    refused!(document, GltfError::Invalid { .. }, "textures[0].source");
}

#[test]
fn nodes_scenes_lights_and_cameras() {
    refused!(with("/nodes/3/children", json!([3])), GltfError::NodeParents { .. }, "node 3");
    refused!(with("/nodes/4/children", json!([4])), GltfError::NodeCycle { .. }, "node 4");
    refused!(with("/nodes/0/children", json!([99])), GltfError::IndexOutOfRange { .. }, "'shape'", "99", "5");
    refused!(with("/nodes/0/mesh", json!(1u64 << 32)), GltfError::IndexOutOfRange { .. }, "4294967296");
    refused!(with("/nodes/0/children", json!(3)), GltfError::Field { .. }, "'children'");
    refused!(with("/scenes/0/nodes", json!([0, 3])), GltfError::NotARoot { .. }, "node 3", "under another");
    let orphan = load(&with("/scenes/0/nodes", json!([3]))).unwrap();
    assert!(orphan.warnings[0].contains("without its parent 0"), "{:?}", orphan.warnings);
    refused!(with("/scenes/0/nodes", json!([0, 0])), GltfError::NotARoot { .. }, "node 0", "already");
    refused!(with("/scene", json!(4)), GltfError::NoSuchScene { .. }, "scene 4");
    refused!(
        with("/nodes/0/rotation", json!([0, 0, 0, 0])),
        GltfError::Transform { .. },
        "'shape'",
        "quaternion"
    );
    let mut matrix = vec![0.0; 16];
    matrix[3] = 1.0;
    refused!(with("/nodes/0/matrix", json!(matrix)), GltfError::Transform { .. }, "affine");
    let light = |value| with("/extensions/KHR_lights_punctual/lights/0", value);
    refused!(light(json!({})), GltfError::Content { .. }, "light 0", "'point'");
    // Types of other extensions are left out.
    let loaded = load(&light(json!({ "type": "area" }))).unwrap();
    assert!(loaded.warnings[0].contains("light 0"), "{:?}", loaded.warnings);
    assert_eq!(loaded.scene.lights().count(), 0);
    refused!(light(json!({ "type": "point", "range": 0 })), GltfError::Content { .. }, "range", "above 0");
    let inside_out = json!({ "type": "spot", "spot": { "innerConeAngle": 0.6, "outerConeAngle": 0.5 } });
    refused!(light(inside_out), GltfError::Content { .. }, "inner <= outer");
    refused!(
        with("/cameras/0/perspective/yfov", json!(4)),
        GltfError::Content { .. },
        "camera 0",
        "field of view"
    );
    refused!(with("/cameras/0/type", json!("x")), GltfError::Content { .. }, "orthographic");
}

#[test]
fn one_node_may_carry_several_things() {
    let mut document = with("/nodes/0/camera", json!(0));
    document["nodes"][0]["extensions"] = json!({
        "KHR_lights_punctual": { "light": 0 },
        "SHADOWGRAPH_shadow_node": { "type": "Any", "lights": [0], "casters": [0] } });
    let loaded = load(&document).unwrap();
    let node = loaded.scene.node(loaded.node_keys[0].unwrap()).unwrap();
    assert!(matches!(node.content, Content::Mesh(_)));
    // A light, a camera, a shadow node and the child that was there before.
    assert_eq!(node.children().len(), 4);
    let snapshot = loaded.scene.snapshot().unwrap();
    assert_eq!((snapshot.lights.len(), snapshot.cameras.len(), snapshot.shadow_nodes.len()), (2, 2, 1));
}

#[test]
fn shadow_nodes() {
    let shadow = |value: Value| with("/nodes/3/extensions", json!({ "SHADOWGRAPH_shadow_node": value }));
    let params = json!({ "word": "auto", "size": 0.1, "flag": true, "numbers": [1, 2] });
    load(&shadow(
        json!({ "type": "Any", "lights": [1], "casters": [0], "receivers": [0], "params": params }),
    ))
    .unwrap();
    refused!(shadow(json!(5)), GltfError::ShadowNode { .. }, "'leaf'", "object");
    refused!(shadow(json!({})), GltfError::ShadowNode { .. }, "'leaf'", "'type'");
    refused!(
        shadow(json!({ "type": "Any", "light": [1] })),
        GltfError::ShadowNode { .. },
        "'light'",
        "casters"
    );
    refused!(
        shadow(json!({ "type": "Any", "lights": 1 })),
        GltfError::ShadowNode { .. },
        "'lights'",
        "array"
    );
    refused!(shadow(json!({ "type": "Any", "lights": [-1] })), GltfError::ShadowNode { .. }, "-1");
    refused!(shadow(json!({ "type": "Any", "lights": [9] })), GltfError::ShadowTarget { .. }, "9", "5 nodes");
    refused!(shadow(json!({ "type": "Any", "lights": [0] })), GltfError::ShadowTarget { .. }, "no light");
    refused!(shadow(json!({ "type": "Any", "casters": [1] })), GltfError::ShadowTarget { .. }, "no mesh");
    refused!(
        shadow(json!({ "type": "Any", "casters": [4] })),
        GltfError::ShadowTarget { .. },
        "not in the loaded scene"
    );
    let bad = json!({ "type": "Any", "params": { "size": { "x": 1 } } });
    refused!(shadow(bad), GltfError::ShadowNode { .. }, "'size'", "number");

    struct Only;
    impl ShadowTypes for Only {
        fn check(&self, node: &ShadowNode) -> Result<(), String> {
            (node.technique == "Known")
                .then_some(())
                .ok_or_else(|| format!("'{}' is unknown (Known is accepted)", node.technique))
        }
    }
    let options = LoadOptions { shadow_types: Some(&Only), ..LoadOptions::default() };
    let load = |kind: &str| {
        gltf::load_slice_with(shadow(json!({ "type": kind })).to_string().as_bytes(), None, &options)
    };
    load("Known").unwrap();
    let error = load("Other").unwrap_err();
    assert!(matches!(&error, GltfError::ShadowType { .. }) && error.to_string().contains("leaf"), "{error}");
}

#[test]
fn another_scene_can_be_chosen() {
    let document = with("/scenes", json!([{ "nodes": [0] }, { "nodes": [4] }, {}])).to_string();
    let load = |scene| {
        let options = LoadOptions { scene, ..LoadOptions::default() };
        gltf::load_slice_with(document.as_bytes(), None, &options)
    };
    assert!(load(SceneChoice::Index(1)).unwrap().scene.find("elsewhere").is_some());
    assert_eq!(load(SceneChoice::Index(2)).unwrap().scene.nodes().count(), 0);
    assert!(load(SceneChoice::Default).unwrap().scene.find("shape").is_some());
    assert!(matches!(load(SceneChoice::Index(3)), Err(GltfError::NoSuchScene { .. })));
}

#[test]
fn files_beside_the_document_are_found_under_escaped_names() {
    let folder = std::env::temp_dir().join(format!("shadowgraph-load-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("my data.bin"), buffer([1.0, 0.0, 0.0])).unwrap();
    let path = folder.join("scene.gltf");
    std::fs::write(&path, with("/buffers/0/uri", json!("my%20data.bin")).to_string()).unwrap();
    gltf::load(&path).unwrap();
    std::fs::write(&path, with("/buffers/0/uri", json!("missing.bin")).to_string()).unwrap();
    let error = gltf::load(&path).unwrap_err();
    assert!(matches!(error, GltfError::Io { .. }) && error.to_string().contains("missing.bin"), "{error}");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/dev/zero", folder.join("endless.bin")).unwrap();
        std::fs::write(&path, with("/buffers/0/uri", json!("endless.bin")).to_string()).unwrap();
        assert!(matches!(gltf::load(&path), Err(GltfError::NotAFile { .. })));
    }
    std::fs::remove_dir_all(&folder).unwrap();
}
