//! Scenes with one thing wrong deep inside, and outputs that fail late: each is named, nothing is left or lost.

use crate::program::{Folder, names_all, yard_parts};
use serde_json::{Value, json};
use shadowgraph_engine::gltf;
use shadowgraph_testing::{renderer, shadowed_yard};

/// Writes the yard as `scene.gltf` and `scene.bin`, after `change`.
fn write_changed(folder: &Folder, change: impl FnOnce(&mut Value, &mut Vec<u8>)) {
    let (mut json, mut bin) = yard_parts();
    json["buffers"][0]["uri"] = "scene.bin".into();
    change(&mut json, &mut bin);
    folder.write("scene.gltf", json.to_string());
    folder.write("scene.bin", bin);
}

/// The glTF accessor of the first mesh's positions.
fn positions(json: &Value) -> usize {
    json["meshes"][0]["primitives"][0]["attributes"]["POSITION"].as_u64().expect("an index") as usize
}

/// Both commands refuse the changed yard with the same line, which holds all of `names`.
#[track_caller]
fn refused(names: &[&str], change: impl FnOnce(&mut Value, &mut Vec<u8>)) {
    let folder = Folder::new();
    write_changed(&folder, change);
    let said = folder.refuses(1, "inspect scene.gltf");
    names_all(&said, names);
    assert_eq!(said, folder.refuses(1, "render scene.gltf -o out.png --visibility factors --json out.json"));
}

#[test]
fn the_unchanged_yard_is_accepted() {
    let folder = Folder::new();
    write_changed(&folder, |_, _| {});
    folder.run("inspect scene.gltf").ok();
}

#[test]
fn indices_out_of_range() {
    refused(&["accessors[0].bufferView", "out of bounds"], |json, _| {
        json["accessors"][0]["bufferView"] = 999.into();
    });
    refused(&["node 0 'floor'", "mesh 999"], |json, _| {
        json["nodes"][0]["mesh"] = 999.into();
    });
    refused(&["meshes[0].primitives[0].indices", "out of bounds"], |json, _| {
        json["meshes"][0]["primitives"][0]["indices"] = 999.into();
    });
    refused(&["scene 999", "the file has 1"], |json, _| {
        json["scene"] = 999.into();
    });
    refused(&["mesh 0", "4294967295"], |json, bin| {
        let indices = json["meshes"][0]["primitives"][0]["indices"].as_u64().expect("an index") as usize;
        let view = json["accessors"][indices]["bufferView"].as_u64().expect("an index") as usize;
        let at = json["bufferViews"][view]["byteOffset"].as_u64().unwrap_or(0) as usize;
        json["accessors"][indices]["componentType"] = 5125.into();
        json["accessors"][indices]["count"] = 3.into();
        bin[at..at + 4].fill(255);
    });
}

#[test]
fn numbers_that_are_none() {
    refused(&["accessor 0 (POSITION)", "NaN", "finite"], |json, bin| {
        let accessor = positions(json);
        let view = json["accessors"][accessor]["bufferView"].as_u64().expect("an index") as usize;
        let at = json["bufferViews"][view]["byteOffset"].as_u64().unwrap_or(0) as usize;
        bin[at..at + 4].copy_from_slice(&f32::NAN.to_le_bytes());
    });
    // Finite, but beyond what the square of a distance can be.
    refused(&["node 0 'floor'", "1e200", "from -1e18 to 1e18"], |json, _| {
        json["nodes"][0]["translation"] = json!([1e200, 1e200, 1e308]);
    });
    refused(&["matrix"], |json, _| {
        json["nodes"][0]["matrix"] = json!([1, 2, 3]);
    });
}

#[test]
fn sizes_and_counts_without_bytes_behind_them() {
    refused(&["accessor", "bytes"], |json, _| {
        let accessor = positions(json);
        json["accessors"][accessor]["count"] = 4_000_000_000_u64.into();
    });
    refused(&["buffer 0", "1000000000000000"], |json, _| {
        json["buffers"][0]["byteLength"] = 1_000_000_000_000_000_u64.into();
    });
    refused(&["buffer"], |json, _| {
        json["buffers"][0]["byteLength"] = u64::MAX.into();
    });
    refused(&["buffer 0", "byteLength"], |_, bin| bin.truncate(bin.len() / 2));
    refused(&["nosuch.bin"], |json, _| {
        json["buffers"][0]["uri"] = "nosuch.bin".into();
    });
}

#[test]
fn cycles_and_second_parents() {
    refused(&["node", "under itself"], |json, _| {
        let count = json["nodes"].as_array().expect("nodes").len();
        json["nodes"]
            .as_array_mut()
            .expect("nodes")
            .extend([json!({ "children": [count + 1] }), json!({ "children": [count] })]);
    });
    refused(&["at most one parent"], |json, _| {
        json["nodes"][1]["children"] = json!([0]);
        json["nodes"][2]["children"] = json!([0]);
    });
}

/// A name from a file is shown, but ends no line and steers no terminal.
#[test]
fn names_cannot_forge_messages() {
    let folder = Folder::new();
    write_changed(&folder, |json, _| {
        let nodes = json["nodes"].as_array_mut().expect("nodes");
        for node in nodes {
            node["name"] = "evil\nerror: forged\u{1b}[2J".into();
        }
    });
    let printed = folder.run("inspect scene.gltf").ok().stdout;
    assert!(!printed.contains('\u{1b}'), "{printed}");
    write_changed(&folder, |json, _| {
        let nodes = json["nodes"].as_array_mut().expect("nodes");
        let shadow = nodes.iter_mut().find(|node| !node["extensions"][gltf::SHADOW_NODE].is_null());
        let shadow = shadow.expect("the yard has a shadow node");
        shadow["name"] = "evil\nerror: forged\u{1b}[2J".into();
        shadow["extensions"][gltf::SHADOW_NODE]["type"] = "Nonsense\nerror: too".into();
    });
    let said = folder.refuses(1, "inspect scene.gltf");
    assert!(!said.contains('\u{1b}'), "{said}");
    names_all(&said, &["Nonsense", "ShadowVolumeHard"]);
}

#[test]
fn techniques_that_are_not_there_name_those_that_are() {
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    for technique in ["lightmap", "silhouettes:resolution=512"] {
        let said = folder.refuses(2, &format!("render yard.glb -o out.png --technique {technique}"));
        let name = technique.split(':').next().expect("a name");
        names_all(&said, &[&format!("'{name}'"), "none", "hard", "map", "silhouette", "reference"]);
    }
}

#[test]
fn no_option_is_passed_over() {
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    for (technique, named) in [
        ("none:depthTest=zfail", "'depthTest'"),
        ("reference:depthTest=zfail", "'depthTest'"),
        ("hard:depthTest=zpass,depthTest=zfail", "given twice"),
        ("hard:depthTest=zpass,", "key=value"),
    ] {
        let said = folder.refuses(2, &format!("render yard.glb -o out.png --technique {technique}"));
        names_all(&said, &[named]);
    }
}

#[test]
fn places_that_cannot_be_written() {
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    std::fs::create_dir(folder.path("folder")).expect("it can be made");
    let refused = |code, arguments: &str, names: &[&str]| {
        names_all(&folder.refuses(code, &format!("render yard.glb {arguments}")), names);
    };
    refused(1, "-o folder", &["'folder'", "is a folder"]);
    refused(1, "-o out.png --json folder", &["'folder'", "is a folder"]);
    refused(1, "-o yard.glb/out.png", &["yard.glb/out.png"]);
    refused(1, "-o out.png --visibility yard.glb/factors", &["yard.glb/factors"]);
    refused(2, "-o yard.glb", &["'yard.glb'", "is read"]);
    refused(2, "-o out.png --json folder/../yard.glb", &["yard.glb", "is read"]);
    refused(2, "-o out.png --json ./out.png", &["out.png", "two outputs"]);
    if cfg!(target_os = "linux") {
        refused(1, "-o /proc/out.png", &["/proc/out.png"]);
    }
}

/// Not even a late failure leaves a part of the outputs, or costs the files that were there.
#[test]
fn a_late_failure_undoes_what_was_staged() {
    if renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    folder.write("out.png", b"the picture of yesterday");
    folder.write("out.json", b"its figures");
    let outputs = "-o out.png --json out.json --visibility new/factors --size 16x16";
    // There is nothing to compare; that is found out once the picture is there.
    let said = folder.refuses(1, &format!("render yard.glb {outputs} --technique none --error"));
    names_all(&said, &["nothing to compare"]);

    // A folder in the place of a factor is met last of all.
    std::fs::create_dir_all(folder.path("factors/lamp.exr")).expect("it can be made");
    let outputs = "-o out.png --json out.json --visibility factors --size 16x16";
    names_all(&folder.refuses(1, &format!("render yard.glb {outputs}")), &["lamp.exr", "is a folder"]);
    std::fs::remove_dir(folder.path("factors/lamp.exr")).expect("it is empty");

    folder.run(&format!("render yard.glb {outputs}")).ok();
    assert_eq!(folder.names("."), ["factors", "out.json", "out.png", "yard.glb"]);
    assert_eq!(folder.names("factors"), ["lamp.exr"]);
    assert!(image::open(folder.path("out.png")).is_ok(), "old files are replaced");
}
