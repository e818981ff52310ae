//! The kinds of valid and invalid files that the Khronos validator's own tests hold, rebuilt as small changes of one
//! document: what is valid loads, what is not is refused or noted. Here: what hangs together, and files as a whole.

use crate::kinds::Expect::{self, Loads, Notes, Refused};
use crate::kinds::{check, document, judge, rows};
use serde_json::json;
use shadowgraph_engine::gltf;

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
    while unaligned.len().is_multiple_of(4) {
        unaligned.push(b' ');
    }
    let marked = [b"\xEF\xBB\xBF".to_vec(), json.clone().into_bytes()].concat();
    let rows: Vec<(&str, Vec<u8>, Expect)> = vec![
        ("whole", whole.clone(), Loads),
        ("without a binary chunk", glb(std::slice::from_ref(&main)), Loads),
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
