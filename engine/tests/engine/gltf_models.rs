//! The models shared for testing load, and say what is in them.

use std::path::{Path, PathBuf};

use shadowgraph_engine::gltf;

fn files(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, out);
        } else if path.extension().is_some_and(|ending| ending == "glb" || ending == "gltf") {
            out.push(path);
        }
    }
}

#[test]
fn shared_models_load() {
    let Some(folder) = shadowgraph_testing::model("") else { return };
    let mut paths = Vec::new();
    files(&folder, &mut paths);
    paths.sort();
    assert!(!paths.is_empty(), "no models in {}", folder.display());
    for path in paths {
        let file = path.file_name().unwrap().to_string_lossy().into_owned();
        let start = std::time::Instant::now();
        let loaded = gltf::load(&path).unwrap_or_else(|error| panic!("{file}: {error}"));
        let snapshot = loaded.scene.snapshot().unwrap();
        let triangles: usize = snapshot.instances.iter().map(|instance| instance.mesh.triangle_count()).sum();
        let (took, images) = (start.elapsed(), loaded.scene.images().count());
        eprintln!("{file}: {triangles} triangles, {images} images, {took:?}, {:?}", loaded.warnings);
        let expected = match file.as_str() {
            "stanford-bunny.glb" => (69_451, 0),
            "spot.glb" => (5_856, 0),
            "teapot.glb" => (6_320, 0),
            "suzanne.glb" => (968, 0),
            "Fox.glb" => (576, 1),
            "FlightHelmet.gltf" => (94_722, 15),
            "craft_speederD.gltf" => (322, 0),
            "cakeBirthday.glb" => (1_332, 0),
            "knot13k.glb" => (13_056, 0),
            "knot63k.glb" => (62_976, 0),
            "boxes1k.glb" => (12_288, 0),
            "plant.glb" => (952, 0),
            _ => continue,
        };
        assert_eq!(triangles, expected.0, "{file}");
        assert!(images <= expected.1 && (images > 0) == (expected.1 > 0), "{file}: {images} images");
    }
}
