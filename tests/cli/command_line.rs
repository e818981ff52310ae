//! The contract of the command line: what `render` and `inspect` accept, write and print.

use std::path::Path;

use crate::program::{Folder, Ran, names_all};
use glam::DVec3;
use serde_json::Value;
use shadowgraph_engine::scene::{Camera, Light, Scene};
use shadowgraph_nodes::ShadowVolumeHard;
use shadowgraph_testing::{add_box, at, renderer, shadowed_yard, with_floor, yard};

/// Looks at the yard from the front; sky above, the whole shadow in view.
const EYE: DVec3 = DVec3::new(0.0, 3.0, 8.0);
const FOV_Y_DEG: f64 = 60.0;
pub(crate) const VIEW: &str = "--eye 0,3,8 --target 0,0,0 --fov-y 60";
const SIZE: [u32; 2] = [64, 48];

/// A folder with the yard as `yard.glb`, or nothing where there is no adapter.
pub(crate) fn yard_on_gpu() -> Option<Folder> {
    renderer()?;
    let folder = Folder::new();
    folder.save("yard.glb", &shadowed_yard(&[]));
    Some(folder)
}

fn render(folder: &Folder, arguments: &str) -> Ran {
    folder.run(&format!("render yard.glb -o out.png --size 64x48 {VIEW} {arguments}")).ok()
}

fn picture(path: &Path) -> image::RgbaImage {
    image::open(path).expect("a picture").into_rgba8()
}

fn factors(path: &Path) -> image::Rgb32FImage {
    let picture = image::open(path).expect("a picture");
    assert!(matches!(picture, image::DynamicImage::ImageRgb32F(_)), "{:?}", picture.color());
    picture.into_rgb32f()
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).expect("it is there")).expect("it is JSON")
}

/// The pixel in which `point` is seen.
fn pixel_of(point: DVec3) -> [u32; 2] {
    let forward = -EYE.normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let from_eye = point - EYE;
    let scale = 1.0 / (from_eye.dot(forward) * (FOV_Y_DEG.to_radians() / 2.0).tan());
    let [width, height] = SIZE.map(f64::from);
    let x = (from_eye.dot(right) * scale * height / width + 1.0) * width / 2.0;
    let y = (1.0 - from_eye.dot(right.cross(forward)) * scale) * height / 2.0;
    [x as u32, y as u32]
}

/// How many pixels differ by more than rounding.
fn different(a: &image::RgbaImage, b: &image::RgbaImage) -> usize {
    assert_eq!(a.dimensions(), b.dimensions());
    let far = |a: &image::Rgba<u8>, b: &image::Rgba<u8>| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 4);
    a.pixels().zip(b.pixels()).filter(|(a, b)| far(a, b)).count()
}

#[test]
fn pictures_have_the_size_that_was_asked_for() {
    let Some(folder) = yard_on_gpu() else { return };
    for (text, size) in [("1x1", (1, 1)), ("255x131", (255, 131)), ("3x200", (3, 200))] {
        let ran = folder.run(&format!("render yard.glb -o {text}.png --size {text}")).ok();
        assert!(ran.stderr.lines().any(|line| line.starts_with("adapter: ")), "{}", ran.stderr);
        assert_eq!(picture(&folder.path(format!("{text}.png"))).dimensions(), size);
    }
    folder.run("render yard.glb --output default.png").ok();
    assert_eq!(picture(&folder.path("default.png")).dimensions(), (1280, 720));
    assert_eq!(folder.names("."), ["1x1.png", "255x131.png", "3x200.png", "default.png", "yard.glb"]);
}

#[test]
fn factors_are_linear_and_right_at_known_places() {
    let Some(folder) = yard_on_gpu() else { return };
    render(&folder, "--visibility factors/of/yard");
    assert_eq!(folder.names("factors/of/yard"), ["lamp.exr"]);
    let factors = factors(&folder.path("factors/of/yard/lamp.exr"));
    assert_eq!(factors.dimensions(), SIZE.into());
    let factor = |point: [f64; 3]| {
        let [x, y] = pixel_of(point.into());
        let rgb = factors.get_pixel(x, y).0;
        assert!(rgb[0].to_bits() == rgb[1].to_bits() && rgb[1].to_bits() == rgb[2].to_bits(), "{rgb:?}");
        rgb[0]
    };
    // The lamp 6 m up and the crate's top, 2 m up and 0.5 m to each side, make a shadow of 0.75 m to each side.
    for dark in [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.5, 0.0, 0.5], [-0.5, 0.0, -0.5]] {
        assert_eq!(factor(dark), 0.0, "{dark:?}");
    }
    for lit in [[1.2, 0.0, 0.0], [-1.2, 0.0, 0.0], [0.0, 0.0, 1.3], [3.0, 0.0, 2.0], [4.0, 0.0, -3.0]] {
        assert_eq!(factor(lit), 1.0, "{lit:?}");
    }
    assert_eq!(factor([0.0, 1.5, 0.5]), 0.0, "the crate's front is turned away from the lamp");
    for x in [0, 30, 63] {
        assert!(factors.get_pixel(x, 0).0.iter().all(|f| f.is_nan()), "the sky has no factor");
    }
    assert!(factors.pixels().all(|p| p.0[0].is_nan() || p.0[0] == 0.0 || p.0[0] == 1.0));
}

#[test]
fn every_light_has_its_file_whatever_its_name() {
    if renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    let mut scene = yard();
    let names = ["a/b", "a/b", "../up", "LAMP", "", "..", "schön"];
    for (index, name) in names.into_iter().enumerate() {
        scene.add_light(Light::point(name, 10.0), DVec3::new(index as f64, 4.0, 1.0), DVec3::ZERO);
    }
    // Only the lamp has shadows; the others shine everywhere.
    let lamp = scene.nodes().find(|(_, node)| node.name == "lamp").expect("the yard has a lamp").0;
    let mut shadows: shadowgraph_engine::scene::ShadowNode = ShadowVolumeHard::default().into();
    shadows.lights = shadowgraph_engine::scene::Scope::Nodes(vec![lamp]);
    scene.add_shadow("shadows", shadows);
    folder.save("yard.glb", &scene);
    render(&folder, "--visibility factors --json out.json");

    let files = folder.names("factors");
    assert_eq!(files.len(), names.len() + 1, "{files:?}");
    let plain = |name: &String| name.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c));
    assert!(files.iter().all(plain), "{files:?}");
    let mut lower: Vec<String> = files.iter().map(|name| name.to_lowercase()).collect();
    lower.dedup();
    assert_eq!(lower.len(), files.len(), "{files:?} would collide where case does not count");
    assert_eq!(folder.names("."), ["factors", "out.json", "out.png", "yard.glb"]);
    for file in &files {
        let dark = factors(&folder.path("factors").join(file)).pixels().filter(|p| p.0[0] == 0.0).count();
        assert_eq!(dark > 0, file == "lamp.exr", "{file} has {dark} dark pixels");
    }
    let report = json(&folder.path("out.json"));
    let mut named: Vec<String> = report["lights"]
        .as_array()
        .expect("lights")
        .iter()
        .map(|light| format!("{}.exr", light["name"].as_str().expect("a name")))
        .collect();
    named.sort();
    assert_eq!(named, files);
}

#[test]
fn json_holds_everything_measured() {
    let Some(folder) = yard_on_gpu() else { return };
    let ran = render(&folder, "--json out.json --frames 2 --error --visibility factors");
    names_all(&ran.stdout, &["frame, wall clock: median", "light", "lamp", "out of band"]);
    let report = json(&folder.path("out.json"));
    assert!(report["adapter"].as_str().is_some_and(|name| ran.stderr.contains(name)), "{report}");
    assert!(report["gpu_bytes"].as_u64() > Some(64 * 48 * 4), "{report}");
    let ordered = |times: &Value| {
        let [min, median, max] = ["min_ms", "median_ms", "max_ms"].map(|key| times[key].as_f64());
        min > Some(0.0) && min <= median && median <= max
    };
    let frames = &report["frames"];
    assert!(ordered(frames) && ordered(&frames["wall"]), "{frames}");
    assert!(frames["gpu"].is_null() || ordered(&frames["gpu"]), "{frames}");
    assert!(ordered(&frames["plan"]) && ordered(&frames["encode"]), "{frames}");
    let timestamps = !frames["gpu"].is_null();
    let passes = report["passes"].as_array().expect("passes");
    assert!(!passes.is_empty());
    for pass in passes {
        assert!(pass["name"].as_str().is_some_and(|name| !name.is_empty()), "{pass}");
        assert!(pass["draws"].is_u64() && pass["vertices"].is_u64(), "{pass}");
        assert_eq!(pass["gpu_ms"].as_f64().is_some(), timestamps, "{pass}");
    }
    assert!(passes.iter().any(|pass| pass["vertices"].as_u64() > Some(0)));
    let [light] = &report["lights"].as_array().expect("lights")[..] else { panic!("{report}") };
    assert_eq!(light["name"], "lamp");
    assert_eq!(light["technique"], "ShadowVolumeHard");
    let error = &light["error"];
    for key in ["compared", "wrong", "leak", "false", "wrong_outside_band", "band_pixels", "boundary_pixels"]
    {
        assert!(error[key].is_u64(), "{key}: {error}");
    }
    for key in ["rmse", "signed_mean", "p99", "max"] {
        assert!(error[key].is_f64(), "{key}: {error}");
    }
    assert!(error["compared"].as_u64() > Some(500), "{error}");
    assert_eq!(error["wrong_outside_band"], 0, "{error}");
    assert!(error["wrong"].as_u64() <= error["band_pixels"].as_u64(), "{error}");

    // The passes are those of the picture: asking for factors as well adds none.
    render(&folder, "--json plain.json");
    let plain = json(&folder.path("plain.json"));
    let names = |report: &Value| -> Vec<Value> {
        report["passes"].as_array().expect("passes").iter().map(|pass| pass["name"].clone()).collect()
    };
    assert_eq!(names(&plain), names(&report));
    assert!(plain["frames"].is_null() && plain["lights"][0]["error"].is_null(), "{plain}");
}

#[test]
fn a_sheet_shows_picture_reference_and_errors() {
    let Some(folder) = yard_on_gpu() else { return };
    render(&folder, "--sheet sheet.png");
    let (alone, sheet) = (picture(&folder.path("out.png")), picture(&folder.path("sheet.png")));
    let (width, height) = alone.dimensions();
    assert_eq!(sheet.dimensions(), (width * 3 + 12, height));
    let same = alone.enumerate_pixels().filter(|(x, y, pixel)| sheet.get_pixel(*x, *y) == *pixel).count();
    assert_eq!(same as u32, width * height, "the picture stands at the left");
    // The factor's column has lit and shadowed pixels.
    let column = |from: u32| {
        (0..height).flat_map(move |y| (0..width).map(move |x| (x + from, y))).collect::<Vec<(u32, u32)>>()
    };
    let whites = column(width + 6).iter().filter(|(x, y)| sheet.get_pixel(*x, *y).0[0] == 255).count();
    assert!(whites > 100 && whites < (width * height) as usize - 10, "{whites} lit pixels");
    folder.refuses(2, "render yard.glb -o twice.png --sheet twice.png");
}

#[test]
fn techniques_replace_the_scenes_own() {
    let Some(folder) = yard_on_gpu() else { return };
    let with = |technique: &str| {
        render(&folder, &format!("--technique {technique} --json out.json"));
        let report = json(&folder.path("out.json"));
        (picture(&folder.path("out.png")), report["lights"][0]["technique"].clone())
    };
    let (none, technique) = with("none");
    assert_eq!(technique, "none");
    let (hard, technique) = with("hard:depthTest=zfail,geometry=closed,extrusion=infinite");
    assert_eq!(technique, "ShadowVolumeHard");
    let (reference, technique) = with("reference");
    assert_eq!(technique, "Reference");
    let shadow = different(&none, &reference);
    assert!(shadow > 10, "{shadow} pixels are in shadow");
    assert!(different(&hard, &reference) <= 4, "{} pixels differ", different(&hard, &reference));
    render(&folder, "");
    assert!(different(&hard, &picture(&folder.path("out.png"))) <= 4);
    // Every other option draws the same shadow of a box, but for the one darkening, which leaves half of the light.
    for options in [
        "closure=cap",
        "closure=backfaces,geometry=closed",
        "counter=float,geometry=open",
        "counter=stencil8,extrusion=toBounds",
    ] {
        let (other, technique) = with(&format!("hard:{options}"));
        assert_eq!(technique, "ShadowVolumeHard");
        assert!(different(&hard, &other) <= 4, "{options}: {} pixels", different(&hard, &other));
    }
    // Smooth normals light a rim of the box's far sides, and nothing else.
    let (smooth, _) = with("hard:terminator=smooth");
    assert!((1..100).contains(&different(&hard, &smooth)), "{} pixels", different(&hard, &smooth));
    let (single, _) = with("hard:passes=single,weight=0.25");
    assert!(different(&single, &none) > 10 && different(&single, &hard) > 10);
    let label = json(&folder.path("out.json"))["lights"][0]["techniques"][0].clone();
    assert_eq!(label, "ShadowVolumeHard passes=single weight=0.25");
}

#[test]
fn lights_of_every_kind_replace_the_scenes_own() {
    let Some(folder) = yard_on_gpu() else { return };
    let lights = "--light point:-2,5,-1 --light directional:-1,-2,-0.5 --light=spot:-1,6,-1:0.5,-2,0.5:30";
    render(&folder, &format!("{lights} --visibility factors --json out.json --error"));
    assert_eq!(folder.names("factors"), ["light0.exr", "light1.exr", "light2.exr"]);
    let report = json(&folder.path("out.json"));
    for light in report["lights"].as_array().expect("lights") {
        assert_eq!(light["technique"], "ShadowVolumeHard", "the scene's shadow node serves them");
        assert_eq!(light["error"]["wrong_outside_band"], 0, "{light}");
    }
    // Each shadow falls away from its light: the crate hides this place from the sun and from nothing else.
    let dark = |light: usize, point: DVec3| {
        let [x, y] = pixel_of(point);
        factors(&folder.path(format!("factors/light{light}.exr"))).get_pixel(x, y).0[0] == 0.0
    };
    let behind_crate = DVec3::new(-0.75, 0.0, -0.375);
    assert!(dark(1, behind_crate) && !dark(0, behind_crate));
    let away_from_lamp = DVec3::new(1.0, 0.0, 0.5);
    assert!(dark(0, away_from_lamp) && !dark(1, away_from_lamp));
}

#[test]
fn a_floor_receives_what_the_scene_casts() {
    if renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    let mut scene = Scene::new();
    add_box(&mut scene, "crate", at(0.0, 1.5, 0.0));
    shadowgraph_testing::add_lamp(&mut scene, "lamp");
    folder.save("yard.glb", &scene);
    let dark_on_floor = || {
        let factors = factors(&folder.path("factors/lamp.exr"));
        let [x, y] = pixel_of(DVec3::new(0.5, 0.0, 0.5));
        factors.get_pixel(x, y).0[0]
    };
    render(&folder, "--technique hard --visibility factors");
    assert!(dark_on_floor().is_nan());
    render(&folder, "--technique hard --visibility factors --floor 0:12");
    assert_eq!(dark_on_floor(), 0.0);
    render(&folder, "--technique hard --visibility factors --floor -0.5:12");
    let inspected = folder.run("inspect yard.glb --technique hard --floor -0.5:12 --tree").ok();
    names_all(&inspected.stdout, &["'floor' mesh", "for 1 caster"]);
}

#[test]
fn cameras_are_chosen_by_name_or_by_eye() {
    if renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    let mut scene = shadowed_yard(&[]);
    scene.add_camera(Camera::perspective("first", 0.9), DVec3::new(6.0, 5.0, 8.0), DVec3::ZERO);
    scene.add_camera(Camera::perspective("second", FOV_Y_DEG.to_radians()), EYE, DVec3::ZERO);
    folder.save("yard.glb", &scene);
    let look = |arguments: &str| {
        let ran = folder.run(&format!("render yard.glb -o out.png --size 64x48 {arguments}")).ok();
        assert_eq!(ran.notes(), Vec::<&str>::new(), "nothing was chosen for the user");
        picture(&folder.path("out.png"))
    };
    let [default, first, second, eye] = ["", "--camera first", "--camera second", VIEW].map(look);
    assert_eq!(different(&default, &first), 0);
    assert!(different(&first, &second) > 100);
    assert!(different(&second, &eye) <= 4, "eye and target make the same picture as that camera");
    let mirrored = look("--eye -6,5,8 --target 0,0,0 --fov-y 51.5662");
    // The yard is symmetric, so only the sides of the crate and the edges of the floor tell the two apart.
    let apart = different(&first, &mirrored);
    assert!(apart > 20, "negative numbers are numbers: {apart}");
    look("--eye 0,9,0 --target 0,0,0");
}

#[test]
fn what_a_scene_lacks_is_chosen_and_said() {
    if renderer().is_none() {
        return;
    }
    let folder = Folder::new();
    let mut scene = with_floor();
    add_box(&mut scene, "crate", at(0.0, 0.5, 0.0));
    folder.save("bare.glb", &scene);
    let ran =
        folder.run("render bare.glb -o out.png --size 320x240 --visibility factors --technique hard").ok();
    let notes = ran.notes().join("\n");
    names_all(&notes, &["no light", "directional:", "no camera", "framed from"]);
    let picture = picture(&folder.path("out.png"));
    let first = picture.get_pixel(0, 0);
    assert!(picture.pixels().any(|pixel| pixel != first), "something is in view, and lit");
    let factors = factors(&folder.path("factors/light0.exr"));
    let count = |wanted: fn(f32) -> bool| factors.pixels().filter(|p| wanted(p.0[0])).count();
    // A crate of 1 m on a floor of 20 m: its shadow and dark sides are a few pixels.
    let (nothing, dark, lit) = (count(f32::is_nan), count(|f| f == 0.0), count(|f| f == 1.0));
    assert!(nothing > 100 && dark > 3 && lit > 100, "{nothing} {dark} {lit}");
    // The same choices are said by `inspect`.
    names_all(&folder.run("inspect bare.glb").ok().notes().join("\n"), &["no light", "no camera"]);
}
