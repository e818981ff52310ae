//! What the command line does with files from elsewhere: none that is read is written over, none outside the scene's
//! folder is read unasked, deep and strange ones are told about in a few short lines.

use std::fs;

use crate::program::{Folder, names_all, yard_parts};
use serde_json::{Value, json};
use shadowgraph_engine::gltf;
use shadowgraph_testing::{renderer, shadowed_yard};

/// A folder with the yard as `scene.gltf`, after `change`, `scene.bin` and `wood.png`, which a material wears.
fn folder_with(change: impl FnOnce(&mut Value)) -> Folder {
    let folder = Folder::new();
    let (mut json, bin) = yard_parts();
    json["buffers"][0]["uri"] = "scene.bin".into();
    json["images"] = json!([{ "uri": "wood.png" }]);
    json["textures"] = json!([{ "source": 0 }]);
    json["materials"][0]["emissiveTexture"] = json!({ "index": 0 });
    change(&mut json);
    folder.write("scene.gltf", json.to_string());
    folder.write("scene.bin", bin);
    image::RgbaImage::from_pixel(2, 2, image::Rgba([9; 4]))
        .save(folder.path("wood.png"))
        .expect("it can be written");
    folder
}

#[test]
fn nothing_that_is_read_is_written_over() {
    let folder = folder_with(|_| {});
    fs::create_dir_all(folder.path("below")).expect("it can be made");
    let mut outputs = vec![
        "-o scene.gltf",
        "-o scene.bin",
        "-o wood.png",
        "-o below/../wood.png",
        "-o ./wood.png",
        "-o out.png --json scene.bin",
        "-o out.png --sheet wood.png",
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("../wood.png", folder.path("below/linked.png"))
            .expect("links can be made");
        std::os::unix::fs::symlink("below", folder.path("folder")).expect("links can be made");
        fs::hard_link(folder.path("wood.png"), folder.path("same.png")).expect("links can be made");
        fs::create_dir(folder.path("factors")).expect("it can be made");
        fs::hard_link(folder.path("scene.bin"), folder.path("factors/lamp.exr")).expect("links can be made");
        outputs.extend(["-o below/linked.png", "-o folder/linked.png", "-o same.png"]);
    }
    for output in outputs {
        names_all(
            &folder.refuses(2, &format!("render scene.gltf {output}")),
            &["is read", "cannot be written"],
        );
    }
    names_all(&folder.refuses(2, "report scene.gltf -o report --plot scene.bin"), &["is read"]);
    if renderer().is_some() && cfg!(unix) {
        // Places of factors are known once the lights are.
        let said = folder.refuses(2, "render scene.gltf -o out.png --size 16x16 --visibility factors");
        names_all(&said, &["lamp.exr", "is read"]);
        // Two names of one file are one place.
        folder.write("a.png", "old");
        fs::hard_link(folder.path("a.png"), folder.path("b.json")).expect("links can be made");
        names_all(&folder.refuses(2, "render scene.gltf -o a.png --json b.json"), &["two outputs"]);
        folder.run("render scene.gltf -o out.png --size 16x16").ok();
    }
}

#[test]
fn files_outside_the_folder_are_refused_unless_they_are_asked_for() {
    let folder = folder_with(|json| json["buffers"][0]["uri"] = "../%73cene.bin".into());
    fs::create_dir(folder.path("inner")).expect("it can be made");
    fs::rename(folder.path("scene.gltf"), folder.path("inner/scene.gltf")).expect("it can be moved");
    fs::rename(folder.path("wood.png"), folder.path("inner/wood.png")).expect("it can be moved");
    for command in ["inspect inner/scene.gltf", "render inner/scene.gltf -o out.png"] {
        let said = folder.refuses(1, command);
        names_all(&said, &["buffer 0", "scene.bin", "outside the scene's folder", "--outside-files"]);
    }
    folder.run("inspect inner/scene.gltf --outside-files").ok();
    // What is read from there is not written over either.
    names_all(&folder.refuses(2, "render inner/scene.gltf --outside-files -o scene.bin"), &["is read"]);
}

#[test]
fn memory_is_known_before_it_is_taken() {
    let folder = folder_with(|_| {});
    let wide = image::GrayImage::new(2048, 2048);
    wide.save(folder.path("wood.png")).expect("it can be written");
    let said = folder.refuses(1, "inspect scene.gltf --memory 16");
    names_all(&said, &["image 0", "20 MiB", "8 MiB", "--memory"]);
    folder.run("inspect scene.gltf --memory 64").ok();
    names_all(&folder.refuses(2, "inspect scene.gltf --memory 0"), &["--memory"]);
}

/// A hundred thousand levels: nothing on the way may call itself for each.
#[test]
fn deep_hierarchies_are_shown_drawn_and_saved() {
    const LEVELS: usize = 100_000;
    let folder = folder_with(|json| {
        let nodes = json["nodes"].as_array_mut().expect("nodes");
        let first = nodes.len();
        nodes.extend((1..LEVELS).map(|level| json!({ "children": [first + level] })));
        nodes.push(json!({ "mesh": 0 }));
        json["scenes"][0]["nodes"].as_array_mut().expect("roots").push(first.into());
    });
    let summary = folder.run("inspect scene.gltf").ok().stdout;
    names_all(&summary, &["100004 nodes", "open (4 boundary edges)"]);
    let tree = folder.run("inspect scene.gltf --tree").ok().stdout;
    names_all(&tree, &["(100000) 'node 100003' mesh"]);
    assert!(tree.len() < 100 * LEVELS, "{} bytes", tree.len());
    let loaded = gltf::load(folder.path("scene.gltf")).expect("it loads");
    let again = gltf::to_glb(&loaded.scene).expect("it can be saved");
    let again = gltf::load_slice(&again.bytes, None).expect("it loads again");
    assert_eq!(again.scene.nodes().count(), loaded.scene.nodes().count());
    if renderer().is_some() {
        folder.run("render scene.gltf -o out.png --size 16x16").ok();
    }
}

#[test]
fn empty_views_are_said() {
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    let note = |arguments: &str| {
        let ran = match renderer() {
            Some(_) => folder.run(&format!("render yard.glb -o out.png --size 16x16 {arguments}")).ok(),
            None => return folder.run(&format!("inspect yard.glb {arguments}")).ok().stdout,
        };
        let inspected = folder.run(&format!("inspect yard.glb {arguments}")).ok().stdout;
        let notes = ran.notes().join("\n");
        assert!(notes.is_empty() || inspected.contains(&notes), "{notes} is not in {inspected}");
        notes
    };
    names_all(&note("--eye 0,100,0 --target 0,200,1"), &["nothing is in view of camera 'eye'"]);
    // A millimetre before the floor, which the eye looks straight at.
    let near = note("--eye 40,0.001,0 --target 40,-1,0.001");
    assert!(near.is_empty() || near.contains("nothing is"), "{near}");
    assert!(!note("--eye 6,5,8 --target 0,0,0").contains("nothing is"));
    let folder = folder_with(|json| {
        json["cameras"] = json!([{ "type": "perspective", "perspective": { "yfov": 0.8, "znear": 1000 } }]);
        let nodes = json["nodes"].as_array_mut().expect("nodes");
        nodes.push(json!({ "name": "far sighted", "camera": 0, "translation": [0, 1, 9] }));
        let place = nodes.len() - 1;
        json["scenes"][0]["nodes"].as_array_mut().expect("roots").push(place.into());
    });
    let summary = folder.run("inspect scene.gltf").ok().stdout;
    names_all(&summary, &["nothing is seen", "'far sighted'", "near plane (1000 m)"]);
}

/// Lines a person reads: the thing by name or index, said once, with few digits.
#[test]
fn messages_are_short_and_say_each_thing_once() {
    let long = "n".repeat(4000);
    let said = |change: &dyn Fn(&mut Value)| folder_with(change).refuses(1, "inspect scene.gltf");
    let unknown = said(&|json| {
        let nodes = json["nodes"].as_array_mut().expect("nodes");
        let shadow = nodes.iter_mut().find(|node| !node["extensions"][gltf::SHADOW_NODE].is_null());
        let shadow = shadow.expect("the yard has a shadow node");
        shadow.as_object_mut().expect("an object").remove("name");
        shadow["extensions"][gltf::SHADOW_NODE]["type"] = "Nonsense".into();
    });
    names_all(&unknown, &["node 3:", "unknown type 'Nonsense'"]);
    assert_eq!(unknown.matches("shadow node").count(), 1, "{unknown}");
    let material = said(&|json| {
        json["materials"][0]["name"] = "oak".into();
        json["materials"][0]["alphaMode"] = 5.into();
    });
    names_all(&material, &["materials[0].alphaMode", "'oak'", "OPAQUE, MASK, BLEND"]);
    let named = said(&|json| {
        json["nodes"][0]["name"] = long.as_str().into();
        json["nodes"][0]["translation"] = json!([1.234_567_890_123_4e30, 0, 0]);
    });
    names_all(&named, &["node 0 'nnn", "nn…nn", "1.235e30"]);
    assert!(named.len() < 400, "{named}");
    let shown = folder_with(|json| {
        json["nodes"][0]["name"] = long.as_str().into();
        json["nodes"][1].as_object_mut().expect("an object").remove("name");
    });
    let shown = shown.run("inspect scene.gltf --tree --plan").ok().stdout;
    names_all(&shown, &["nn…nn", "'node 1'"]);
    assert!(shown.lines().all(|line| line.len() < 1000), "{shown}");
}

/// The first screen of the room, as the README shows it.
#[test]
fn the_summary_of_the_room_tells_what_matters() {
    let folder = Folder::new();
    let room = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/room.glb");
    let summary = folder.run_with(["inspect", room], &[]).ok().stdout;
    assert!(summary.lines().count() <= 45, "{summary}");
    names_all(
        &summary,
        &[
            "55 meshes",
            "5 lights",
            "'sun' directional light, 5.5 lx: ShadowVolumeHard by 'daylight' for 55 casters",
            "casters: 55 of 55 meshes",
            "'floor' open (4 boundary edges), 2 triangles",
            "closed: 32 casters, ",
            "receivers: all",
            "wrong: nothing",
        ],
    );
    let readme = include_str!("../../README.md");
    for line in summary.lines().take(9) {
        assert!(readme.contains(line), "the README does not show '{line}'");
    }
}
