//! `--time`, `--animation` and `--scene` on the command line, and what `inspect` says of what moves.

use crate::program::{Folder, names_all};
use glam::DVec3;
use serde_json::{Value, json};
use shadowgraph::prelude::*;
use shadowgraph_engine::gltf;
use shadowgraph_testing::shadowed_yard;

/// The yard, whose box slides 3 m along x in 2 s, or jumps.
fn moving_yard() -> Scene {
    let mut scene = shadowed_yard(&[]);
    let node = scene.find("crate").unwrap();
    let clip = |name: &str, interpolation, to: f32| {
        let values = vec![0.0, 1.5, 0.0, to, 1.5, 0.0];
        let track = Track::new(Property::Translation, interpolation, vec![0.0, 2.0], values).unwrap();
        Animation::new(name, vec![Channel::new(node, track)])
    };
    scene.add_animation(clip("slide", Interpolation::Linear, 3.0)).unwrap();
    scene.add_animation(clip("jump", Interpolation::Step, -3.0)).unwrap();
    scene
}

#[test]
fn times_and_animations_are_chosen() {
    let folder = Folder::new();
    folder.save("yard.glb", &moving_yard());
    folder.save("still.glb", &shadowed_yard(&[]));
    let printed = folder.run("inspect yard.glb --time 1").ok().stdout;
    names_all(&printed, &["animations", "'slide' 2.000 s, 1 channels, 1 nodes", "'jump' 2.000 s"]);
    for text in ["nan", "inf", "-1", "soon"] {
        let said = folder.refuses(2, &format!("inspect yard.glb --time {text}"));
        names_all(&said, &["--time", "seconds from 0"]);
    }
    names_all(&folder.refuses(2, "inspect still.glb --time 1"), &["--time", "no animation"]);
    names_all(&folder.refuses(2, "inspect yard.glb --animation jump"), &["--time"]);
    let said = folder.refuses(2, "inspect yard.glb --time 1 --animation run");
    names_all(&said, &["'run'", "'slide'", "'jump'"]);
}

/// Frames are timed while something moves; the picture is that of the first.
#[test]
fn motion_is_timed() {
    let folder = Folder::new();
    folder.save("yard.glb", &moving_yard());
    folder.save("still.glb", &shadowed_yard(&[]));
    let view = "--size 64x48 --eye 6,5,8 --target 0,0,0";
    for moves in ["--orbit", "--play"] {
        names_all(&folder.refuses(2, &format!("render yard.glb -o out.png {moves}")), &["--frames"]);
    }
    names_all(
        &folder.refuses(2, "render yard.glb -o out.png --frames 2 --orbit --play"),
        &["--orbit", "--play"],
    );
    if shadowgraph_testing::renderer().is_none() {
        return;
    }
    names_all(
        &folder.refuses(2, "render still.glb -o out.png --frames 2 --play"),
        &["--play", "no animation"],
    );
    for moves in ["", "--orbit", "--play", "--play --time 1 --animation jump"] {
        let out = format!("render yard.glb {view} -o out.png --frames 5 --json out.json {moves}");
        let ran = folder.run(&out).ok();
        names_all(&ran.stdout, &["on the CPU, planning: median", "on the CPU, encoding: median"]);
        let report: Value = serde_json::from_slice(&std::fs::read(folder.path("out.json")).unwrap()).unwrap();
        let part = |part: &str| report["frames"][part]["median_ms"].as_f64().unwrap();
        let (plan_ms, encode_ms, wall_ms) = (part("plan"), part("encode"), part("wall"));
        assert!(plan_ms > 0.0 && plan_ms + encode_ms < wall_ms, "{moves}: {report}");
    }
}

/// What is rendered is the pose: the same factor as of a scene that was moved by hand.
#[test]
fn renders_show_the_time_that_was_asked_for() {
    if shadowgraph_testing::renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    folder.save("yard.glb", &moving_yard());
    let mut by_hand = shadowed_yard(&[]);
    let node = by_hand.find("crate").unwrap();
    let mut factors = Vec::new();
    for (x, arguments) in
        [(1.5, "--time 1"), (3.0, "--time 99"), (-3.0, "--time 2 --animation jump"), (0.0, "")]
    {
        by_hand.node_mut(node).unwrap().parent_from_local =
            DAffine3::from_translation(DVec3::new(x, 1.5, 0.0));
        folder.save("by-hand.glb", &by_hand);
        let view = "--size 64x48 --eye 6,5,8 --target 0,0,0 -o out.png --visibility";
        folder.run(&format!("render yard.glb {arguments} {view} shown")).ok();
        folder.run(&format!("render by-hand.glb {view} wanted")).ok();
        let [shown, wanted] =
            ["shown", "wanted"].map(|name| std::fs::read(folder.path(format!("{name}/lamp.exr"))).unwrap());
        assert!(shown == wanted, "{arguments}");
        factors.push(shown);
    }
    assert!(factors.iter().all(|factor| factors.iter().filter(|other| *other == factor).count() == 1));
}

#[test]
fn scenes_are_chosen_by_name_or_index() {
    let folder = Folder::new();
    let glb = gltf::to_glb(&shadowed_yard(&[])).unwrap().bytes;
    let size = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    let mut document: Value = serde_json::from_slice(&glb[20..20 + size]).unwrap();
    document["buffers"][0]["uri"] = "scene.bin".into();
    let nodes = document["scenes"][0]["nodes"].clone();
    document["scenes"] =
        json!([{ "name": "bare", "nodes": [0] }, { "name": "yard", "nodes": nodes }, { "nodes": [] }]);
    folder.write("scene.gltf", document.to_string());
    folder.write("scene.bin", &glb[28 + size..]);
    let lists = |arguments: &str| folder.run(&format!("inspect scene.gltf {arguments}")).ok().stdout;
    names_all(&lists(""), &["scenes", "0 'bare', shown", "1 'yard'"]);
    for choice in ["yard", "1"] {
        names_all(&lists(&format!("--scene {choice}")), &["1 'yard', shown", "'crate'", "light"]);
    }
    names_all(&folder.refuses(2, "inspect scene.gltf --scene garden"), &["--scene", "'garden'", "'yard'"]);
    names_all(&folder.refuses(2, "inspect scene.gltf --scene 7"), &["--scene", "scene 7", "the file has 3"]);
    names_all(&folder.refuses(1, "inspect scene.gltf --scene 2"), &["no mesh"]);
}
