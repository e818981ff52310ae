//! Bad input: one clear line that names the thing and what is accepted, the right exit code, nothing half-written.

use crate::program::{Folder, names_all};
use shadowgraph_testing::{renderer, shadowed_yard};

/// `arguments` must fail with `code` and one line that holds all of `names`, and leave the folder as it was.
#[track_caller]
fn refused(folder: &Folder, arguments: &str, code: i32, names: &[&str]) {
    names_all(&folder.refuses(code, arguments), names);
}

fn folder_with_yard() -> Folder {
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    folder
}

#[test]
fn files_that_are_no_scenes() {
    let folder = folder_with_yard();
    let whole = std::fs::read(folder.path("yard.glb")).expect("it was written");
    folder.write("empty.glb", b"");
    folder.write("cut.glb", &whole[..whole.len() / 2]);
    folder.write("garbage.glb", b"glTF, or not");
    folder.write("garbage.gltf", b"{ this is no JSON");
    folder
        .write("bare.gltf", br#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [] }], "scene": 0 }"#);
    folder.write(
        "range.gltf",
        br#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [7] }], "scene": 0 }"#,
    );
    folder.write(
        "cycle.gltf",
        br#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "scene": 0,
              "nodes": [{ "children": [1] }, { "children": [0] }] }"#,
    );
    folder.write(
        "huge.gltf",
        br#"{ "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "scene": 0, "nodes": [{ "mesh": 0 }],
              "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 } }] }],
              "buffers": [{ "byteLength": 1000000000000000 }],
              "bufferViews": [{ "buffer": 0, "byteLength": 1000000000000000 }],
              "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 4000000000, "type": "VEC3" }] }"#,
    );
    for (name, says) in [
        ("missing.glb", "missing.glb"),
        ("empty.glb", "empty.glb"),
        ("cut.glb", "cut.glb"),
        ("garbage.glb", "garbage.glb"),
        ("garbage.gltf", "garbage.gltf"),
        ("bare.gltf", "no mesh"),
        ("range.gltf", "7"),
        ("cycle.gltf", ""),
        ("huge.gltf", ""),
        (".", ""),
    ] {
        refused(&folder, &format!("inspect {name}"), 1, &[says]);
        refused(&folder, &format!("render {name} -o out.png"), 1, &[says]);
    }
}

#[test]
fn shadow_nodes_that_cannot_be() {
    let folder = Folder::new();
    let scene = |extension: &str| {
        format!(
            r#"{{ "asset": {{ "version": "2.0" }}, "scenes": [{{ "nodes": [0] }}], "scene": 0,
                  "extensionsUsed": ["SHADOWGRAPH_shadow_node"],
                  "nodes": [{{ "name": "mine", "extensions": {{ "SHADOWGRAPH_shadow_node": {extension} }} }}] }}"#
        )
    };
    for (extension, says) in [
        (r#"{ "type": "ShadowVolumeHart" }"#, ["ShadowVolumeHart", "ShadowVolumeHard"]),
        (r#"{ "type": "ShadowVolumeHard", "params": { "depth": "auto" } }"#, ["'depth'", "depthTest"]),
        (r#"{ "type": "ShadowVolumeHard", "params": { "depthTest": "maybe" } }"#, ["'maybe'", "zfail"]),
        (r#"{ "type": "ShadowVolumeHard", "lights": [9] }"#, ["mine", "9"]),
        (r#"{ "type": "ShadowVolumeHard", "casters": [0] }"#, ["mine", "casters"]),
    ] {
        folder.write("scene.gltf", scene(extension).as_bytes());
        refused(&folder, "inspect scene.gltf", 1, &says);
    }
}

#[test]
fn usage_that_cannot_be() {
    let folder = folder_with_yard();
    for (arguments, names) in [
        ("render yard.glb", &["--output"][..]),
        ("render yard.glb -o out.png --size 0x9", &["1280x720"]),
        ("render yard.glb -o out.png --size large", &["large", "1280x720"]),
        ("render yard.glb -o out.png --camera nobody", &["'nobody'"]),
        ("render yard.glb -o out.png --eye 1,2,3", &["--target"]),
        ("render yard.glb -o out.png --eye 1,2,3 --target 1,2,3", &["same point"]),
        ("render yard.glb -o out.png --eye 1,2 --target 1,2,3", &["1,2"]),
        ("render yard.glb -o out.png --eye 1,2,3 --target 0,0,0 --fov-y 0", &["fov-y", "180"]),
        ("render yard.glb -o out.png --eye 1,2,3 --target 0,0,0 --fov-y 180", &["fov-y"]),
        ("render yard.glb -o out.png --eye 1,2,3 --target 0,0,0 --fov-y NaN", &["fov-y"]),
        ("render yard.glb -o out.png --light lamp:1,2,3", &["point:X,Y,Z"]),
        ("render yard.glb -o out.png --light spot:1,2,3:0,-1,0:120", &["120"]),
        ("render yard.glb -o out.png --technique softest", &["'softest'", "hard"]),
        ("render yard.glb -o out.png --technique hard:depthTest=never", &["'never'", "zfail"]),
        ("render yard.glb -o out.png --technique hard:depth=zfail", &["'depth'", "depthTest"]),
        ("render yard.glb -o out.png --technique hard:closure=lid", &["'lid'", "none, cap, backfaces"]),
        ("render yard.glb -o out.png --technique hard:counter=stencil", &["'stencil'", "stencil8, float"]),
        ("render yard.glb -o out.png --technique hard:terminator=1", &["'terminator'", "geometric, smooth"]),
        ("render yard.glb -o out.png --technique hard:weight=0.5", &["'weight'", "passes=single only"]),
        (
            "render yard.glb -o out.png --technique hard:passes=single,weight=2",
            &["'weight'", "a number from 0 to 1"],
        ),
        (
            "render yard.glb -o out.png --technique hard:passes=single,counter=float",
            &["'counter'", "auto, stencil8 with passes=single"],
        ),
        ("render yard.glb -o out.png --floor 0:-3", &["0:12"]),
        ("render yard.glb -o out.png --frames 0", &["--frames"]),
        ("paint yard.glb", &["paint"]),
    ] {
        refused(&folder, arguments, 2, names);
    }
}

#[test]
fn what_the_machine_cannot_do() {
    if renderer().is_none() {
        return;
    }
    let folder = folder_with_yard();
    folder.write("file", b"in the way");
    refused(&folder, "render yard.glb -o out.png --size 100000x100000", 2, &["100000x100000"]);
    refused(&folder, "render yard.glb -o out.png --size 40000x10", 2, &["40000x10"]);
    refused(&folder, "render yard.glb -o out.png --adapter nosuch", 2, &["'nosuch'"]);
    refused(&folder, "render yard.glb -o nowhere/out.png", 1, &["nowhere/out.png"]);
    refused(&folder, "render yard.glb -o out.png --json nowhere/out.json", 1, &["nowhere/out.json"]);
    refused(&folder, "render yard.glb -o out.png --visibility file", 1, &["file"]);
    refused(&folder, "render yard.glb -o .", 2, &["no file name"]);
    let many = " --light point:1,2,3".repeat(2000);
    refused(&folder, &format!("render yard.glb -o out.png{many}"), 1, &["2000", "1024"]);
}
