//! `render --antialias` and `--gpu-budget`: what they accept, write and say.

use crate::program::{Folder, names_all};

const VIEW: &str = "--eye 0,3,8 --target 0,0,0 --fov-y 60 --size 64x48";

fn folder() -> Option<Folder> {
    shadowgraph_testing::renderer()?;
    let folder = Folder::new();
    folder.save("yard.glb", &shadowgraph_testing::shadowed_yard(&[]));
    Some(folder)
}

/// Factors strictly between lit and dark, and the number of all that are not NaN.
fn between(folder: &Folder) -> (usize, usize) {
    let picture = image::open(folder.path("factors/lamp.exr")).unwrap().into_rgb32f();
    assert_eq!(picture.dimensions(), (64, 48));
    let seen: Vec<f32> = picture.pixels().map(|texel| texel.0[0]).filter(|value| !value.is_nan()).collect();
    (seen.iter().filter(|value| **value > 0.0 && **value < 1.0).count(), seen.len())
}

#[test]
fn both_ways_smooth_edges_and_the_report_says_which() {
    let Some(folder) = folder() else { return };
    for (how, smooth) in [("none", false), ("msaa4", true), ("ssaa4", true)] {
        folder
            .run(&format!(
                "render yard.glb -o out.png {VIEW} --antialias {how} --visibility factors --error --json out.json"
            ))
            .ok();
        let report = std::fs::read(folder.path("out.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        assert_eq!(report["antialias"], how);
        assert_eq!(report["size_px"], serde_json::json!([64, 48]));
        assert_eq!(report["lights"][0]["error"]["exact"], true, "{how}: {report}");
        assert_eq!(image::open(folder.path("out.png")).unwrap().into_rgba8().dimensions(), (64, 48));
        let (between, seen) = between(&folder);
        assert!(seen > 500 && (between > 10) == smooth, "{how}: {between} of {seen}");
    }
}

#[test]
fn what_cannot_be_is_refused_in_one_line() {
    let Some(folder) = folder() else { return };
    let error = folder.refuses(2, &format!("render yard.glb -o out.png {VIEW} --antialias fxaa"));
    names_all(&error, &["fxaa", "none, msaa4, ssaa4"]);
    let limit = shadowgraph_testing::renderer().unwrap().gpu().limits.max_texture_dimension_2d;
    let large = format!("render yard.glb -o out.png --size {limit}x2 --antialias ssaa4");
    names_all(&folder.refuses(2, &large), &[&format!("{limit}x2"), "ssaa4", &format!("{}x4", limit * 2)]);
    let technique = format!("render yard.glb -o out.png {VIEW} --antialias msaa4 --technique reference");
    names_all(&folder.refuses(1, &technique), &["Reference", "R16Float", "ssaa4"]);
    let poor = "render yard.glb -o out.png --size 2000x1000 --gpu-budget 1";
    names_all(&folder.refuses(1, poor), &["budget", "1048576"]);
    assert_eq!(folder.refuses(2, "render yard.glb -o out.png --gpu-budget 0").lines().count(), 1);
}
