//! The kinds of valid and invalid files that the Khronos validator's own tests hold, rebuilt as small changes of one
//! document: what is valid loads, what is not is refused or noted. Here: numbers, shapes and looks.

use crate::kinds::Expect::{Loads, Notes, Refused};
use crate::kinds::{check, document, rows};
use serde_json::json;
use shadowgraph_engine::gltf;

#[test]
fn the_document_itself_is_valid() {
    let loaded = gltf::load_slice(document().to_string().as_bytes(), None).unwrap();
    assert_eq!((loaded.warnings, loaded.remarks), (vec![], vec![]));
    let snapshot = loaded.scene.snapshot().unwrap();
    assert_eq!((snapshot.instances.len(), snapshot.lights.len(), snapshot.cameras.len()), (2, 1, 1));
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
        "bounds that are not" { "/accessors/0/max" = [9, 1, 1] } Notes("'max'");
        "bounds of another width" { "/accessors/0/max" = [1] } Notes("'max'");
        "bounds that are no numbers" { "/accessors/0/max" = ["1"] } Refused("accessors[0].max");
        "floats said to be normalized" { "/accessors/0/normalized" = true } Notes("normalized");
        "no bounds of positions" { "/accessors/0/max" = null } Notes("no min and max");
        "text in the place of yes or no" { "/accessors/0/normalized" = "yes" } Refused("true or false");
    });
}

#[test]
fn sparse_accessors() {
    check(rows! {
        "sparse over zeros" {
            "/accessors/2" = { "componentType": 5126, "count": 4, "type": "VEC2", "sparse": { "count": 1,
                "indices": { "bufferView": 7, "componentType": 5121 }, "values": { "bufferView": 2 } } }
        } Loads;
        "sparse over values" {
            "/accessors/1/sparse" = { "count": 2.0,
                "indices": { "bufferView": 7, "componentType": 5121 }, "values": { "bufferView": 1, "byteOffset": 0e0 } }
        } Loads;
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
        "an unknown light" { "/extensions/KHR_lights_punctual/lights/0/type" = "area" } Notes("light 0");
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
