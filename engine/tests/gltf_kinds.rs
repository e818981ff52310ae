//! The kinds of valid and invalid files that the Khronos validator's own tests hold, rebuilt as small changes of one
//! document: what is valid loads, what is not is refused or noted.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod kinds;

use kinds::Expect::{self, Loads, Notes, Refused};
use kinds::{Row, document};
use serde_json::json;
use shadowgraph_engine::gltf;

/// Checks every row, and names all that are not as expected.
#[track_caller]
fn check(rows: Vec<Row>) {
    let mut wrong = Vec::new();
    assert!(!rows.is_empty());
    for Row { name, document, expect } in rows {
        let loaded = gltf::load_slice(document.to_string().as_bytes(), None);
        if let Some(problem) = judge(expect, &loaded) {
            wrong.push(format!("{name}: {problem}"));
        }
    }
    assert!(wrong.is_empty(), "{} kinds:\n{}", wrong.len(), wrong.join("\n"));
}

fn judge(expect: Expect, loaded: &Result<gltf::Loaded, gltf::GltfError>) -> Option<String> {
    match (expect, loaded) {
        (Loads, Ok(loaded)) if loaded.warnings.is_empty() && loaded.remarks.is_empty() => None,
        (Notes(text), Ok(loaded))
            if loaded.warnings.iter().chain(&loaded.remarks).any(|n| n.contains(text)) =>
        {
            None
        }
        (Refused(text), Err(error)) if error.to_string().contains(text) => None,
        (expect, Ok(loaded)) => {
            Some(format!("{expect:?}, but it loaded: {:?} {:?}", loaded.warnings, loaded.remarks))
        }
        (expect, Err(error)) => Some(format!("{expect:?}, but: {error}")),
    }
}

#[test]
fn the_document_itself_is_valid() {
    let loaded = gltf::load_slice(document().to_string().as_bytes(), None).unwrap();
    assert_eq!((loaded.warnings, loaded.remarks), (vec![], vec![]));
    let posed = loaded.scene.pose().unwrap();
    assert_eq!((posed.instances.len(), posed.lights.len(), posed.cameras.len()), (2, 1, 1));
}

macro_rules! rows {
    ($($name:literal { $($path:literal = $value:tt),* } $expect:expr;)*) => {
        vec![$(Row::new($name, &[$(($path, json!($value))),*], $expect)),*]
    };
}

#[test]
fn accessors() {
    check(rows! {
        "zeros" { "/accessors/-" = { "componentType": 5126, "count": 3, "type": "VEC3" } } Loads;
        "zeros in use" { "/accessors/2" = { "componentType": 5126, "count": 4, "type": "VEC2" } } Loads;
        "zeros as positions" {
            "/accessors/0" = { "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0] }
        } Loads;
        "zeros as a morph target" {
            "/accessors/-" = { "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0] },
            "/meshes/0/primitives/0/targets" = [{ "POSITION": 9 }]
        } Loads;
        "sparse over zeros" {
            "/accessors/2" = { "componentType": 5126, "count": 4, "type": "VEC2", "sparse": { "count": 1,
                "indices": { "bufferView": 7, "componentType": 5121 }, "values": { "bufferView": 2 } } }
        } Loads;
        "sparse over values" {
            "/accessors/1/sparse" = { "count": 2.0,
                "indices": { "bufferView": 7, "componentType": 5121 }, "values": { "bufferView": 1, "byteOffset": 0e0 } }
        } Loads;
        "whole numbers with a point" {
            "/accessors/0/count" = 4.0, "/accessors/0/componentType" = 5126.0, "/accessors/0/bufferView" = 0.0,
            "/bufferViews/0/byteLength" = 48.0, "/bufferViews/0/buffer" = 0.0, "/nodes/0/mesh" = 0.0,
            "/scenes/0/nodes" = [0.0, 1.0, 2.0, 3.0, 4.0], "/scene" = 0.0, "/meshes/0/primitives/0/mode" = 4.0,
            "/nodes/3/extensions/SHADOWGRAPH_shadow_node/lights" = [2.0],
            "/nodes/2/extensions/KHR_lights_punctual/light" = 0.0, "/textures/0/source" = 0.0
        } Loads;
        "numbers with a fraction" { "/accessors/0/count" = 4.5 } Refused("accessors[0].count");
        "unknown type, unused" { "/accessors/-" = { "componentType": 5126, "count": 3, "type": "VEC7" } } Notes("VEC7");
        "unknown type" { "/accessors/0/type" = "VEC7" } Refused("accessors[0].type");
        "unknown component type" { "/accessors/0/componentType" = 5124 } Refused("5124");
        "nothing, unused" { "/accessors/-" = {} } Notes("accessors[9].count is not valid glTF: it is missing");
        "nothing" { "/accessors/0" = {} } Refused("it is missing");
        "no object" { "/accessors/0" = 5 } Refused("accessors[0]");
        "no array" { "/accessors" = {} } Refused("'accessors'");
        "unused, of no view there is" {
            "/accessors/-" = { "bufferView": 99, "componentType": 5126, "count": 3, "type": "VEC3" }
        } Notes("index 99");
        "of no view there is" { "/accessors/0/bufferView" = 99 } Refused("index 99");
        "an offset without a view" {
            "/accessors/-" = { "byteOffset": 0, "componentType": 5126, "count": 3, "type": "VEC3" }
        } Notes("byteOffset");
        "unused, a stride below the element" {
            "/bufferViews/7/byteStride" = 4, "/accessors/-" = { "bufferView": 7, "componentType": 5126, "count": 2, "type": "VEC2" }
        } Notes("bytes apart");
        "unused, too long" {
            "/accessors/-" = { "bufferView": 7, "componentType": 5126, "count": 200, "type": "VEC2" }
        } Notes("reaches beyond");
        "unused, unaligned" {
            "/accessors/-" = { "bufferView": 7, "byteOffset": 2, "componentType": 5126, "count": 2, "type": "VEC2" }
        } Notes("components' size");
        "unused matrices of bytes" {
            "/accessors/-" = { "bufferView": 7, "componentType": 5121, "count": 2, "type": "MAT2" }
        } Notes("matrices");
        "a stride below the element" { "/bufferViews/0/byteStride" = 8 } Refused("byteStride 8");
        "too long" { "/accessors/0/count" = 400 } Refused("accessor 0 needs");
        "too long by its offset" { "/accessors/0/byteOffset" = 4 } Refused("accessor 0 needs");
        "empty" { "/accessors/0/count" = 0 } Refused("at least 1");
        "more sparse values than values" {
            "/accessors/1/sparse" = { "count": 5, "indices": { "bufferView": 7, "componentType": 5121 },
                "values": { "bufferView": 1 } }
        } Refused("5 sparse values");
        "sparse places out of order" {
            "/accessors/1/sparse" = { "count": 3, "indices": { "bufferView": 4, "byteOffset": 2, "componentType": 5121 },
                "values": { "bufferView": 1 } }
        } Refused("sparse index");
        "sparse without values" {
            "/accessors/1/sparse" = { "count": 1, "indices": { "bufferView": 7, "componentType": 5121 } }
        } Refused("accessors[1].sparse.values");
        "bounds that are not" { "/accessors/0/max" = [9, 1, 1] } Notes("'max'");
        "bounds of another width" { "/accessors/0/max" = [1] } Notes("'max'");
        "bounds that are no numbers" { "/accessors/0/max" = ["1"] } Refused("accessors[0].max");
        "floats said to be normalized" { "/accessors/0/normalized" = true } Notes("normalized");
        "no bounds of positions" { "/accessors/0/max" = null } Notes("no min and max");
        "text in the place of yes or no" { "/accessors/0/normalized" = "yes" } Refused("true or false");
    });
}

#[test]
fn buffers_and_views() {
    check(rows! {
        "a placeholder, unused" { "/buffers/-" = { "byteLength": 5 } } Loads;
        "nothing behind it" { "/buffers/0/uri" = null } Refused("buffer 0");
        "unused, elsewhere" { "/buffers/-" = { "byteLength": 5, "uri": "https://example.org/a.bin" } } Notes("absolute");
        "unused, nothing" { "/buffers/-" = {} } Notes("byteLength");
        "unused, too large" { "/buffers/-" = { "byteLength": 1e300 } } Notes("buffers[1].byteLength");
        "elsewhere" { "/buffers/0/uri" = "https://example.org/a.bin" } Refused("absolute");
        "not there" { "/buffers/0/uri" = "gone.bin" } Refused("gone.bin");
        "no base64" { "/buffers/0/uri" = "data:application/octet-stream;base64,AA?A" } Refused("base64");
        "unused, no base64" {
            "/buffers/-" = { "byteLength": 3, "uri": "data:application/octet-stream;base64,AA?A" }
        } Notes("base64");
        "of another type" { "/buffers/-" = { "byteLength": 3, "uri": "data:image/png;base64,AAAA" } } Notes("image/png");
        "escaped base64" {
            "/buffers/-" = { "byteLength": 1, "uri": "data:application/octet-stream;base64,AA%3D%3D" }
        } Loads;
        "longer than its bytes" { "/buffers/0/byteLength" = 9999 } Refused("9999");
        "of no bytes" { "/buffers/-" = { "byteLength": 0 } } Notes("buffers[1].byteLength");
        "a view beyond the buffer" { "/bufferViews/0/byteOffset" = 5000 } Refused("buffer view 0");
        "a view of no buffer there is" { "/bufferViews/0/buffer" = 9 } Refused("bufferViews[0].buffer");
        "a view of no bytes" { "/bufferViews/0/byteLength" = 0 } Refused("accessor 0");
        "a stride that is too large" { "/bufferViews/7/byteStride" = 256 } Notes("byteStride");
        "a stride of no multiple of 4" { "/bufferViews/-" = { "buffer": 0, "byteLength": 4, "byteStride": 5 } }
            Notes("multiple of 4");
        "an unknown target" { "/bufferViews/7/target" = 1 } Notes("target");
        "empty arrays" { "/skins" = [], "/nodes/1/skin" = null } Notes("'skins' is empty");
        "a wrong type" { "/buffers/0/byteLength" = "many" } Refused("buffers[0].byteLength");
    });
}

#[test]
fn cameras_and_lights() {
    check(rows! {
        "a picture turned over" {
            "/cameras/0" = { "type": "orthographic",
                "orthographic": { "xmag": -1, "ymag": -1, "znear": 0, "zfar": 9 } }
        } Loads;
        "no height" {
            "/cameras/0" = { "type": "orthographic", "orthographic": { "xmag": 0, "ymag": 0, "znear": 0, "zfar": 9 } }
        } Refused("ymag");
        "unused, no height" {
            "/cameras/-" = { "type": "orthographic", "orthographic": { "xmag": 0, "ymag": 0, "znear": 0, "zfar": 9 } }
        } Notes("0");
        "far before near" { "/cameras/0/perspective/zfar" = 0.01 } Notes("zfar");
        "unused, far before near" {
            "/cameras/-" = { "type": "perspective", "perspective": { "yfov": 1, "znear": 2, "zfar": 1 } }
        } Notes("zfar");
        "both kinds" { "/cameras/0/orthographic" = { "xmag": 1, "ymag": 1, "znear": 0, "zfar": 9 } } Notes("both");
        "neither kind" { "/cameras/-" = { "type": "perspective" } } Notes("neither");
        "another kind" { "/cameras/0/type" = "fisheye" } Refused("camera 0");
        "nothing" { "/cameras/-" = {} } Notes("type");
        "no field of view" { "/cameras/0/perspective/yfov" = null } Refused("yfov");
        "an unknown light" { "/extensions/KHR_lights_punctual/lights/0/type" = "area", "/nodes/3/extensions" = null } Notes("light 0");
        "an unknown light, unused" { "/extensions/KHR_lights_punctual/lights/-" = { "type": "area" } } Notes("area");
        "a light of no type" { "/extensions/KHR_lights_punctual/lights/0/type" = null } Refused("light 0");
        "nothing of a light" { "/extensions/KHR_lights_punctual/lights/-" = {} } Notes("lights[1].type");
        "a spot without cone" { "/extensions/KHR_lights_punctual/lights/-" = { "type": "spot" } } Notes("spot");
        "an inside-out cone" {
            "/extensions/KHR_lights_punctual/lights/0" = { "type": "spot",
                "spot": { "innerConeAngle": 1, "outerConeAngle": 0.5 } }
        } Refused("inner");
        "an unused inside-out cone" {
            "/extensions/KHR_lights_punctual/lights/-" = { "type": "spot",
                "spot": { "innerConeAngle": 1, "outerConeAngle": 0.5 } }
        } Notes("cone");
        "negative light" { "/extensions/KHR_lights_punctual/lights/0/intensity" = (-1) } Refused("negative");
        "no lights" { "/extensions/KHR_lights_punctual/lights" = 5 } Refused("lights");
        "no light there is" { "/nodes/2/extensions/KHR_lights_punctual/light" = 7 } Refused("light 7");
        "a light of a mesh" { "/meshes/0/extensions" = { "KHR_lights_punctual": { "light": 0 } } } Notes("meshes");
        "a word for its colour" { "/extensions/KHR_lights_punctual/lights/0/color" = "red" } Refused("color");
    });
}

#[test]
fn meshes() {
    check(rows! {
        "no positions" { "/meshes/0/primitives/-" = { "attributes": { "NORMAL": 1 } } } Notes("no POSITION");
        "only no positions" { "/meshes/0/primitives" = [{ "attributes": { "NORMAL": 1 } }] } Notes("no POSITION");
        "points" { "/meshes/0/primitives/0/mode" = 0 } Notes("points");
        "attributes of a program" { "/meshes/0/primitives/0/attributes/_WIND" = 1 } Loads;
        "an unknown attribute" { "/meshes/0/primitives/0/attributes/WIND" = 1 } Notes("unknown name");
        "an unknown mode" { "/meshes/0/primitives/0/mode" = 8 } Refused("mode");
        "no primitives" { "/meshes/0/primitives" = null } Refused("meshes[0].primitives");
        "empty primitives" { "/meshes/0/primitives" = [] } Notes("is empty");
        "no attributes" { "/meshes/0/primitives/0/attributes" = null } Refused("attributes");
        "empty attributes" { "/meshes/0/primitives/0/attributes" = {} } Notes("no POSITION");
        "attributes of no accessor" { "/meshes/0/primitives/0/attributes/COLOR_0" = 99 } Refused("COLOR_0");
        "indices beyond the vertices" { "/accessors/1/count" = 3 , "/accessors/0/count" = 3, "/accessors/2/count" = 3 }
            Refused("index 3");
        "indices of floats" { "/meshes/0/primitives/0/indices" = 1 } Refused("U8, U16 or U32");
        "normals of another count" { "/accessors/1/count" = 3 } Refused("NORMAL has 3");
        "positions of another type" { "/accessors/0/type" = "VEC2", "/accessors/0/min" = [0, 0], "/accessors/0/max" = [1, 1] }
            Refused("POSITION");
        "gaps in the numbering" { "/meshes/0/primitives/0/attributes/TEXCOORD_2" = 2 } Notes("TEXCOORD_");
        "a padded number" { "/meshes/0/primitives/0/attributes/TEXCOORD_01" = 2 } Notes("unknown name");
        "normals of another length" { "/accessors/1/bufferView" = null } Notes("length 1");
        "colours beyond 1" { "/meshes/1/primitives/0/attributes/COLOR_0" = 9, "/accessors/-" = { "componentType": 5126,
            "count": 4, "type": "VEC3", "sparse": { "count": 1, "indices": { "bufferView": 7, "componentType": 5121 },
            "values": { "bufferView": 8 } } } } Notes("colours");
        "32-bit integers" { "/accessors/2/componentType" = 5125 } Notes("32-bit integers");
        "small integers, undeclared" { "/accessors/1" = { "bufferView": 5, "componentType": 5120, "count": 4,
            "type": "VEC3", "normalized": true } } Notes("KHR_mesh_quantization");
        "indices among the vertices" { "/accessors/4/bufferView" = 1, "/accessors/4/count" = 3 } Notes("vertices and indices");
        "a target that says otherwise" { "/bufferViews/4/target" = 34962 } Notes("target");
        "attributes in one view without a stride" { "/accessors/1/bufferView" = 0 } Notes("no byteStride");
        "indices with a stride" { "/bufferViews/4/byteStride" = 4, "/accessors/4/count" = 3 } Notes("byteStride");
        "joints without weights" { "/meshes/1/primitives/0/attributes/WEIGHTS_0" = null } Refused("WEIGHTS_0");
        "morph targets of another number" {
            "/meshes/0/primitives/-" = { "attributes": { "POSITION": 0 }, "targets": [{ "POSITION": 1 }] }
        } Refused("morph targets");
        "weights of another number" { "/meshes/0/weights" = [1, 2] } Refused("2 weights");
        "a morph target of another count" {
            "/meshes/0/primitives/0/targets" = [{ "POSITION": 8 }]
        } Refused("POSITION of a morph target");
        "a morph target of what is not there" {
            "/meshes/1/primitives/0/targets" = [{ "NORMAL": 1 }]
        } Notes("morph target");
        "an unknown material" { "/meshes/0/primitives/0/material" = 9 } Refused("materials");
        "joints of floats" { "/meshes/1/primitives/0/attributes/JOINTS_0" = 6 } Refused("JOINTS");
        "negative weights" { "/accessors/6/sparse" = { "count": 1, "indices": { "bufferView": 7, "componentType": 5121 },
            "values": { "bufferView": 8 } } } Refused("weight");
        "joints beyond the skin" { "/skins/0/joints" = [0] } Refused("joint 1");
    });
}

#[test]
fn materials_textures_and_images() {
    check(rows! {
        "no image" { "/textures/0/source" = null } Notes("has no image");
        "no image, unused" { "/textures/-" = {} } Loads;
        "an image of an extension we lack" {
            "/textures/0" = { "extensions": { "MSFT_texture_dds": { "source": 0 } } },
            "/extensionsUsed/-" = "MSFT_texture_dds"
        } Notes("MSFT_texture_dds");
        "WebP" {
            "/textures/0" = { "source": 0, "extensions": { "EXT_texture_webp": { "source": 1 } } },
            "/extensionsUsed/-" = "EXT_texture_webp"
        } Loads;
        "WebP, undeclared" {
            "/textures/0" = { "source": 0, "extensions": { "EXT_texture_webp": { "source": 1 } } }
        } Notes("EXT_texture_webp");
        "WebP of another image" {
            "/textures/0" = { "source": 0, "extensions": { "EXT_texture_webp": { "source": 7 } } }
        } Refused("images");
        "no texture there is" { "/materials/0/pbrMetallicRoughness/baseColorTexture/index" = 9 } Refused("of 'wood'");
        "no image there is" { "/textures/0/source" = 9 } Refused("textures[0].source");
        "no sampler there is" { "/textures/0/sampler" = 9 } Refused("textures[0].sampler");
        "a word for a number" { "/materials/0/pbrMetallicRoughness/metallicFactor" = "much" }
            Refused("materials[0].pbrMetallicRoughness.metallicFactor (of 'wood')");
        "too few numbers" { "/materials/0/emissiveFactor" = [1, 1] } Refused("materials[0].emissiveFactor (of 'wood')");
        "out of range" { "/materials/0/pbrMetallicRoughness/metallicFactor" = 2 } Notes("metallicFactor");
        "not finite in 32 bits" { "/materials/0/pbrMetallicRoughness/metallicFactor" = 1e300 } Refused("'wood'");
        "an unknown alpha mode" { "/materials/0/alphaMode" = "GLASS" } Refused("materials[0].alphaMode (of 'wood')");
        "unused, an unknown alpha mode" { "/materials/-" = { "alphaMode": "GLASS" } } Notes("GLASS");
        "texture coordinates beyond the second" {
            "/materials/0/pbrMetallicRoughness/baseColorTexture/texCoord" = 5
        } Notes("TEXCOORD_5");
        "texture coordinates that the mesh lacks" {
            "/materials/0/pbrMetallicRoughness/baseColorTexture/texCoord" = 1
        } Notes("TEXCOORD_1");
        "strength out of range" {
            "/materials/0/extensions" = { "KHR_materials_emissive_strength": { "emissiveStrength": -1 } }
        } Notes("emissiveStrength");
        "an extension we lack" {
            "/materials/0/extensions" = { "KHR_materials_sheen": {} }, "/extensionsUsed/-" = "KHR_materials_sheen"
        } Notes("KHR_materials_sheen");
        "an extension in a wrong place" {
            "/nodes/0/extensions" = { "KHR_materials_unlit": {} },
            "/extensionsUsed/-" = "KHR_materials_unlit"
        } Notes("KHR_materials_unlit");
        "an unknown wrap mode" { "/samplers/0/wrapS" = 5 } Refused("samplers[0].wrapS");
        "unused, an unknown wrap mode" { "/samplers/-" = { "wrapS": 5 } } Notes("samplers[1].wrapS");
        "an image that is none" { "/images/0/uri" = "data:image/png;base64,AAAA" } Refused("image 0");
        "an image cut short" { "/images/0/uri" = "data:image/png;base64,iVBORw0KGgo=" } Refused("image 0");
        "an image of another type" { "/images/0/mimeType" = "image/jpeg" } Notes("image/jpeg");
        "an image of an unknown type" { "/images/0/mimeType" = "image/gif" } Notes("image/gif");
        "an image from nowhere" { "/images/-" = {} } Notes("neither uri nor bufferView");
        "an image from two places" { "/images/-" = { "uri": "a.png", "bufferView": 0, "mimeType": "image/png" } }
            Notes("uri and a bufferView");
        "an image of no type" { "/images/-" = { "bufferView": 0 } } Notes("mimeType");
        "an image elsewhere" { "/images/0/uri" = "http://example.org/a.png" } Refused("absolute");
        "unused, an image elsewhere" { "/images/-" = { "uri": "http://example.org/a.png" } } Notes("absolute");
    });
}

#[test]
fn nodes_and_scenes() {
    check(rows! {
        "nothing" { "/nodes/-" = {} } Loads;
        "no children" { "/nodes/0/children" = [] } Notes("children");
        "a child twice" { "/nodes/4/children" = [5, 5] } Refused("node 5");
        "two parents" { "/nodes/0/children" = [5] } Refused("node 5");
        "under itself" { "/nodes/5/children" = [5] } Refused("node 5");
        "in a circle" { "/nodes/5/children" = [6], "/nodes/-" = { "children": [5] }, "/nodes/4/children" = null }
            Refused("node");
        "a mesh that is not there" { "/nodes/0/mesh" = 9 } Refused("mesh 9");
        "unused, a mesh that is not there" { "/nodes/-" = { "mesh": 9 } } Notes("nodes[6].mesh");
        "a skin that is not there" { "/nodes/1/skin" = 9 } Refused("skin 9");
        "a camera that is not there" { "/nodes/3/camera" = 9 } Refused("camera 9");
        "a child that is not there" { "/nodes/0/children" = [99] } Refused("node 99");
        "a skin without a mesh" { "/nodes/4/skin" = 0 } Notes("skin");
        "weights without a mesh" { "/nodes/4/weights" = [1] } Notes("weights");
        "weights without morph targets" { "/nodes/0/weights" = [1] } Refused("'weights'");
        "a skin of a mesh without joints" { "/nodes/0/skin" = 0 } Notes("skin");
        "placed twice" { "/nodes/0/matrix" = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], "/nodes/0/scale" = [1, 1, 1] }
            Refused("twice");
        "a matrix that shears" { "/nodes/0/matrix" = [1,0,0,0, 1,1,0,0, 0,0,1,0, 0,0,0,1] } Notes("matrix");
        "a matrix that is not affine" { "/nodes/0/matrix" = [1,0,0,1, 0,1,0,0, 0,0,1,0, 0,0,0,1] } Refused("affine");
        "an image with a stride" { "/images/-" = { "bufferView": 7, "mimeType": "image/png" },
            "/bufferViews/7/byteStride" = 4, "/skins/0/inverseBindMatrices" = null } Notes("an image");
        "a rotation of another length" { "/nodes/0/rotation" = [0, 0, 0, 0.5] } Notes("rotation");
        "a rotation of no length" { "/nodes/0/rotation" = [0, 0, 0, 0] } Refused("quaternion");
        "an infinite place" { "/nodes/0/translation" = [1e300, 0, 0] } Refused("1e300");
        "instances of a program's own" {
            "/nodes/0/extensions" = { "EXT_mesh_gpu_instancing": { "attributes": { "_ID": 4 } } },
            "/extensionsUsed/-" = "EXT_mesh_gpu_instancing"
        } Notes("shown once");
        "instances of nothing" {
            "/nodes/0/extensions" = { "EXT_mesh_gpu_instancing": { "attributes": {} } },
            "/extensionsUsed/-" = "EXT_mesh_gpu_instancing"
        } Refused("TRANSLATION");
        "a scene of what is no root" { "/scenes/0/nodes" = [0, 5] } Notes("without its parent");
        "a scene of a node and what is under it" { "/scenes/0/nodes" = [4, 5] } Refused("under another");
        "a scene of one node twice" { "/scenes/0/nodes" = [0, 0] } Refused("already");
        "a scene of nothing" { "/scenes/-" = { "nodes": [] } } Notes("is empty");
        "a scene of what is not there" { "/scenes/0/nodes" = [99] } Refused("node 99");
        "no such scene" { "/scene" = 9 } Refused("scene 9");
        "no scene" { "/scenes" = null, "/scene" = null } Notes("no scene");
        "a hidden node in a wrong place" {
            "/scenes/0/extensions" = { "KHR_node_visibility": { "visible": false } },
            "/extensionsUsed/-" = "KHR_node_visibility"
        } Notes("KHR_node_visibility");
    });
}

#[test]
fn skins_and_animations() {
    check(rows! {
        "no joints" { "/skins/0/joints" = [] } Refused("joints");
        "joints left out" { "/skins/0/joints" = null } Refused("joints");
        "nothing, unused" { "/skins/-" = {} } Notes("skins[1].joints");
        "a joint that is not there" { "/skins/0/joints" = [4, 99] } Refused("99");
        "a joint outside the scene" { "/nodes/-" = {}, "/skins/0/joints" = [4, 6] } Refused("not in the loaded scene");
        "a skeleton that is not there" { "/skins/0/skeleton" = 99 } Notes("skeleton");
        "a skeleton that is no root of the joints" { "/skins/0/skeleton" = 0 } Notes("skeleton");
        "joints without a common root" { "/skins/0/joints" = [4, 0] } Notes("common root");
        "bind matrices of another type" { "/skins/0/inverseBindMatrices" = 1 } Refused("Mat4");
        "too few bind matrices" { "/skins/0/inverseBindMatrices" = 7, "/accessors/7/count" = 1 } Refused("inverse bind");
        "bind matrices that are not affine" { "/skins/0/inverseBindMatrices" = 7,
            "/accessors/7/bufferView" = null } Refused("affine");
        "nothing of an animation" { "/animations/-" = {} } Notes("animations[1].channels");
        "empty" { "/animations/-" = { "channels": [], "samplers": [] } } Notes("is empty");
        "no sampler there is" { "/animations/0/channels/0/sampler" = 9 } Refused("sampler 9");
        "no node there is" { "/animations/0/channels/0/target/node" = 99 } Refused("node 99");
        "no times there are" { "/animations/0/samplers/0/input" = 99 } Refused("accessor 99");
        "a path of an extension" { "/animations/0/channels/0/target" = { "path": "pointer" } } Notes("pointer");
        "no target" { "/animations/0/channels/0/target" = null } Refused("target");
        "no node" { "/animations/0/channels/0/target/node" = null } Notes("without a node");
        "an unknown interpolation" { "/animations/0/samplers/0/interpolation" = "SMOOTH" } Refused("CUBICSPLINE");
        "one property twice" { "/animations/0/channels/-" = { "sampler": 0, "target": { "node": 5, "path": "translation" } } }
            Notes("twice");
        "of a node with a matrix" { "/nodes/5/matrix" = [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1] } Notes("matrix");
        "weights of a mesh without morph targets" {
            "/animations/0/channels/0/target" = { "node": 0, "path": "weights" }, "/animations/0/samplers/0/output" = 3
        } Refused("morph targets");
        "times of another type" { "/animations/0/samplers/0/input" = 0 } Refused("Scalar");
        "values of another type" { "/animations/0/samplers/0/output" = 3 } Refused("animation values");
        "values of another number" { "/animations/0/samplers/0/output" = 1 } Refused("sampler 0");
        "times that do not grow" { "/accessors/3/bufferView" = null, "/accessors/3/min" = null } Notes("do not grow");
        "times before the beginning" { "/accessors/3/bufferView" = 8, "/accessors/3/min" = null } Notes("do not grow");
        "times without bounds" { "/accessors/3/min" = null } Notes("no min and max");
        "rotations of no length" {
            "/animations/0/channels/0/target/path" = "rotation",
            "/accessors/8" = { "componentType": 5126, "count": 3, "type": "VEC4" }
        } Refused("no direction");
        "rotations of another length" {
            "/animations/0/channels/0/target/path" = "rotation",
            "/animations/0/samplers/0/output" = 6, "/accessors/6/count" = 3, "/meshes/1/primitives" = [{ "attributes": {} }],
            "/nodes/1/skin" = null
        } Notes("length 1");
        "keys with a stride" { "/bufferViews/3/byteStride" = 4 } Notes("byteStride");
        "joint weights that do not add up" { "/accessors/6/bufferView" = null } Notes("add up to 1");
        "one joint twice" { "/accessors/5/bufferView" = null } Notes("one joint twice");
        "too few keys of a spline" { "/animations/0/samplers/0/interpolation" = "CUBICSPLINE" } Refused("sampler 0");
    });
}

#[test]
fn the_document_as_a_whole() {
    check(rows! {
        "extras anywhere" { "/extras" = { "a": [1.5, {}] }, "/nodes/0/extras" = 7, "/materials/0/extras" = [null] } Loads;
        "properties nobody knows" { "/whatever" = 1, "/nodes/0/whatever" = [] } Loads;
        "an extension we lack" { "/extensionsUsed/-" = "EXT_unheard_of" } Notes("EXT_unheard_of");
        "an extension we lack and must have" {
            "/extensionsUsed/-" = "EXT_unheard_of", "/extensionsRequired" = ["EXT_unheard_of"]
        } Refused("EXT_unheard_of");
        "a requirement that is not declared" { "/extensionsRequired" = ["KHR_mesh_quantization"] } Notes("extensionsUsed");
        "an extension twice" { "/extensionsUsed/-" = "KHR_lights_punctual" } Notes("twice");
        "an extension that is not declared" { "/extensionsUsed" = ["SHADOWGRAPH_shadow_node"] } Notes("KHR_lights_punctual");
        "extensions that are no object" { "/extensions" = 5, "/nodes/2/extensions" = null,
            "/nodes/3/extensions" = null, "/extensionsUsed" = null } Notes("'extensions'");
        "empty extensions" { "/extensionsRequired" = [] } Notes("'extensionsRequired' is empty");
        "an older version" { "/asset/version" = "1.0" } Refused("1.0");
        "a newer version" { "/asset/version" = "2.5" } Loads;
        "a newer version that must be" { "/asset/version" = "2.5", "/asset/minVersion" = "2.5" } Refused("2.5");
        "no version" { "/asset" = {} } Refused("version");
        "no asset" { "/asset" = null } Refused("version");
        "Draco" {
            "/extensionsUsed/-" = "KHR_draco_mesh_compression", "/extensionsRequired" = ["KHR_draco_mesh_compression"]
        } Refused("re-export without Draco");
        "Draco beside plain accessors" {
            "/extensionsUsed/-" = "KHR_draco_mesh_compression",
            "/meshes/0/primitives/0/extensions" = { "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } }
        } Notes("KHR_draco_mesh_compression");
        "Draco instead of plain accessors" {
            "/extensionsUsed/-" = "KHR_draco_mesh_compression", "/accessors/0/bufferView" = null,
            "/meshes/0/primitives/0/extensions" = { "KHR_draco_mesh_compression": { "bufferView": 0, "attributes": {} } }
        } Refused("re-export without Draco");
    });
}

/// Containers are bytes, not documents.
#[test]
fn containers() {
    let json = document().to_string();
    let chunk = |kind: &[u8; 4], data: &[u8]| {
        let mut chunk = (data.len() as u32).to_le_bytes().to_vec();
        chunk.extend(kind);
        chunk.extend(data);
        chunk
    };
    let glb = |chunks: &[Vec<u8>]| {
        let body = chunks.concat();
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((12 + body.len() as u32).to_le_bytes());
        glb.extend(body);
        glb
    };
    let mut padded = json.clone().into_bytes();
    padded.resize(padded.len().next_multiple_of(4), b' ');
    let (main, bin) = (chunk(b"JSON", &padded), chunk(b"BIN\0", &[0; 4]));
    let whole = glb(&[main.clone(), bin.clone()]);
    let mut unaligned = padded.clone();
    unaligned.truncate(json.len());
    while unaligned.len() % 4 == 0 {
        unaligned.push(b' ');
    }
    let marked = [b"\xEF\xBB\xBF".to_vec(), json.clone().into_bytes()].concat();
    let rows: Vec<(&str, Vec<u8>, Expect)> = vec![
        ("whole", whole.clone(), Loads),
        ("without a binary chunk", glb(&[main.clone()]), Loads),
        ("with a chunk nobody knows", glb(&[main.clone(), bin.clone(), chunk(b"WHAT", &[0; 8])]), Loads),
        ("a chunk nobody knows first", glb(&[chunk(b"WHAT", &[0; 8]), main.clone()]), Refused("first chunk")),
        ("a binary chunk first", glb(&[bin.clone(), main.clone()]), Refused("out of order")),
        ("a binary chunk last", glb(&[main.clone(), chunk(b"WHAT", &[0; 8]), bin.clone()]), Notes("chunk 2")),
        ("two binary chunks", glb(&[main.clone(), bin.clone(), bin.clone()]), Refused("repeated")),
        ("two JSON chunks", glb(&[main.clone(), main.clone()]), Refused("repeated")),
        ("an empty JSON chunk", glb(&[chunk(b"JSON", b"")]), Refused("JSON")),
        ("a chunk of odd length", glb(&[chunk(b"JSON", &unaligned)]), Notes("multiple of 4")),
        ("another magic", b"glTG\x02\0\0\0".to_vec(), Refused("JSON")),
        ("another version", [&b"glTF\x03\0\0\0"[..], &whole[8..]].concat(), Refused("version '3")),
        ("cut in its header", whole[..10].to_vec(), Refused("header")),
        ("cut in a chunk", whole[..whole.len() - 4].to_vec(), Refused("header says")),
        ("only a header", b"glTF\x02\0\0\0\x0C\0\0\0".to_vec(), Refused("no JSON chunk")),
        ("a length of nothing", b"glTF\x02\0\0\0\0\0\0\0".to_vec(), Refused("header says")),
        ("nothing", vec![], Refused("JSON")),
        ("a byte order mark", marked, Notes("byte order mark")),
        ("other JSON", b"[]".to_vec(), Refused("JSON")),
        ("no JSON", b"{ glTF }".to_vec(), Refused("JSON")),
        ("no UTF-8", b"{\"asset\":{\"version\":\"2.0\",\"generator\":\"\xFF\"}}".to_vec(), Refused("JSON")),
    ];
    for (name, bytes, expect) in rows {
        let problem = judge(expect, &gltf::load_slice(&bytes, None));
        assert_eq!(problem, None, "{name}");
    }
}
