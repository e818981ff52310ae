//! Casters follow what moves: skinned, animated and instanced scenes against the exact reference, and one renderer
//! through several times against fresh ones.
//!
//! Fox.glb is data that is not part of the project; without it its tests are skipped.

use shadowgraph::engine::gltf;
use shadowgraph::measure::{ErrorTable, evaluate};
use shadowgraph::prelude::*;

fn fox() -> Option<Scene> {
    let path = shadowgraph_testing::model("Fox.glb")?;
    Some(gltf::load(path).unwrap().scene)
}

/// The fox, about a hundred metres long as its file has it, over a floor under a lamp and a sun.
fn lit_fox() -> Option<Scene> {
    let mut scene = fox()?;
    let floor = scene.add_mesh(
        shadowgraph_testing::mesh(shapes::plane(Vec2::splat(400.0))),
        Material::matt("floor", Vec3::splat(0.7)),
        DAffine3::IDENTITY,
    );
    if let Content::Mesh(floor) = &mut scene.node_mut(floor).unwrap().content {
        floor.shadow.casts = false;
    }
    scene.add_light(Light::point("lamp", 1e5), DVec3::new(-90.0, 260.0, 120.0), DVec3::ZERO);
    scene.add_light(Light::directional("sun", 3.0), DVec3::new(1.0, 2.0, -0.6), DVec3::ZERO);
    scene.add_shadow("shadows", ShadowVolumeHard::default());
    Some(scene)
}

fn request(size_px: [u32; 2]) -> FrameRequest {
    let camera = Camera::perspective("eye", 0.8);
    FrameRequest::new(
        CameraSnapshot::looking(camera, DVec3::new(150.0, 130.0, 210.0), DVec3::new(0.0, 30.0, 0.0)),
        size_px,
    )
}

#[test]
fn the_fox_casts_exactly_at_every_time() {
    let Some(mut scene) = lit_fox() else { return };
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let [survey, walk, run] = ["Survey", "Walk", "Run"].map(|name| scene.find_animation(name).unwrap());
    let mut keys = std::collections::HashSet::new();
    for (clip, seconds) in [(survey, 0.0), (survey, 1.7), (walk, 0.25), (run, 0.1), (run, 0.55)] {
        scene.animate(clip, seconds).unwrap();
        let evaluation = evaluate(&mut renderer, &scene, &request([1280, 720]), &|_, _| {}).unwrap();
        let name = &scene.animation(clip).unwrap().name;
        println!("{name} at {seconds} s\n{}", ErrorTable(&evaluation.errors));
        assert_eq!(evaluation.errors.len(), 2);
        for error in &evaluation.errors {
            assert!(error.passes() && error.wrong_outside_band == 0, "{name} at {seconds} s: {error:?}");
            assert!(error.shadow_pixels > 5_000 && error.shadow_pixels < error.compared, "{error:?}");
        }
        keys.insert(scene.snapshot().unwrap().instances[0].pose_key);
    }
    assert_eq!(keys.len(), 5, "five times are five poses");
}

/// Everything that is kept from frame to frame is kept for what it was computed for.
#[test]
fn one_renderer_through_time_draws_what_fresh_ones_draw() {
    let Some(mut scene) = lit_fox() else { return };
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let clip = scene.find_animation("Run").unwrap();
    let request = FrameRequest { factors: true, ..request([480, 270]) };
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    let mut seen = Vec::new();
    for seconds in [0.0, 0.5, 0.0, 0.25, 0.5] {
        scene.animate(clip, seconds).unwrap();
        let kept = renderer.render(&scene, &request, &options).unwrap();
        let mut fresh = shadowgraph_testing::renderer().unwrap();
        let fresh = fresh.render(&scene, &request, &options).unwrap();
        assert_eq!(kept.picture, fresh.picture, "{seconds} s");
        assert_eq!(kept.factors, fresh.factors, "{seconds} s");
        seen.push(kept.factors);
    }
    assert!(seen[0] == seen[2] && seen[1] == seen[4] && seen[0] != seen[1]);

    // Nothing moves: nothing is bent, extracted or uploaded again, not even after a change elsewhere.
    let before = renderer.work_done();
    scene.animate(clip, 0.5).unwrap();
    scene.set_background(Vec3::splat(0.5));
    renderer.render(&scene, &request, &options).unwrap();
    assert_eq!(renderer.work_done(), before);
}

/// A thousand boxes by `EXT_mesh_gpu_instancing`, written by hand; loaded, saved and loaded again.
fn thousand() -> Scene {
    let count = 1000_usize;
    let mut floats: Vec<f32> = Vec::new();
    let mut sections = Vec::new();
    let mut section = |values: Vec<f32>, floats: &mut Vec<f32>| {
        sections.push((floats.len() * 4, values.len() * 4));
        floats.extend(values);
    };
    let corner = |i: usize, axis: usize| if i >> axis & 1 == 0 { -0.05 } else { 0.05 };
    section((0..8).flat_map(|i| [corner(i, 0), corner(i, 1), corner(i, 2)]).collect(), &mut floats);
    let grid = |i: usize| [(i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32];
    let place = |i: usize| grid(i).map(|n| n * 0.25);
    section(
        (0..count)
            .flat_map(|i| {
                let [x, y, z] = place(i);
                [x - 1.1, y + 0.2, z - 1.1]
            })
            .collect(),
        &mut floats,
    );
    section(
        (0..count).flat_map(|i| DQuat::from_rotation_y(i as f64 * 0.7).as_quat().to_array()).collect(),
        &mut floats,
    );
    section(
        (0..count)
            .flat_map(|i| [1.0, 0.5 + (i % 7) as f32 * 0.1, if i % 5 == 0 { -1.0 } else { 1.0 }])
            .collect(),
        &mut floats,
    );
    let mut bytes: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    sections.push((bytes.len(), 36));
    bytes.extend(quads.map(|[a, b, c, d]| [a, b, c, a, c, d]).concat());
    let views: Vec<_> = sections
        .iter()
        .map(|(start, length)| serde_json::json!({ "buffer": 0, "byteOffset": start, "byteLength": length }))
        .collect();
    let hex: String = bytes.iter().map(|byte| format!("%{byte:02X}")).collect();
    let stream = |view: usize, count: usize, kind: &str| serde_json::json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
    let document = serde_json::json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }],
        "extensionsRequired": ["EXT_mesh_gpu_instancing"], "extensionsUsed": ["EXT_mesh_gpu_instancing"],
        "nodes": [{ "name": "box", "mesh": 0, "extensions": { "EXT_mesh_gpu_instancing": {
            "attributes": { "TRANSLATION": 1, "ROTATION": 2, "SCALE": 3 } } } }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 4 }] }],
        "accessors": [stream(0, 8, "VEC3"), stream(1, count, "VEC3"), stream(2, count, "VEC4"),
            stream(3, count, "VEC3"), { "bufferView": 4, "componentType": 5121, "count": 36, "type": "SCALAR" }],
        "bufferViews": views,
        "buffers": [{ "byteLength": bytes.len(), "uri": format!("data:,{hex}") }],
    });
    let loaded = gltf::load_slice(document.to_string().as_bytes(), None).unwrap();
    assert!(loaded.warnings.is_empty(), "{:?}", loaded.warnings);
    gltf::load_slice(&gltf::to_glb(&loaded.scene).unwrap().bytes, None).unwrap().scene
}

fn light_thousand(scene: &mut Scene) {
    let floor = shadowgraph_testing::mesh(shapes::plane(Vec2::splat(6.0)));
    let floor = scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
    if let Content::Mesh(floor) = &mut scene.node_mut(floor).unwrap().content {
        floor.shadow.casts = false;
    }
    scene.add_light(Light::point("lamp", 60.0), DVec3::new(-1.0, 6.0, 1.5), DVec3::ZERO);
    scene.add_light(Light::directional("sun", 2.0), DVec3::new(2.0, 3.0, 1.0), DVec3::ZERO);
    scene.add_shadow("shadows", ShadowVolumeHard::default());
}

fn request_thousand(size_px: [u32; 2]) -> FrameRequest {
    let camera = Camera::perspective("eye", 0.8);
    let camera = CameraSnapshot::looking(camera, DVec3::new(3.6, 4.4, 6.0), DVec3::Y);
    FrameRequest::new(camera, size_px)
}

#[test]
fn a_thousand_instances_cast_exactly() {
    let mut scene = thousand();
    let snapshot = scene.snapshot().unwrap();
    assert_eq!(snapshot.instances.len(), 1000);
    assert_eq!(scene.meshes().count(), 1);
    assert_eq!(snapshot.instances[314].name, "box[314]");
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    light_thousand(&mut scene);
    let request = request_thousand([1280, 720]);
    let evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
    println!("{}", ErrorTable(&evaluation.errors));
    for error in &evaluation.errors {
        assert!(error.passes() && error.wrong_outside_band == 0, "{error:?}");
        assert!(error.shadow_pixels > 10_000 && error.shadow_pixels < error.compared, "{error:?}");
    }
}

/// A face of a box seen so nearly edge-on that it is an eighth of a pixel thin. Snapping its corners to 1/256 pixel tilts
/// it by millimetres: the band has to follow from the snap of this very triangle.
#[test]
fn surfaces_thinner_than_a_pixel() {
    let mut scene = thousand();
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    light_thousand(&mut scene);
    let evaluation = evaluate(&mut renderer, &scene, &request_thousand([640, 360]), &|_, _| {}).unwrap();
    println!("{}", ErrorTable(&evaluation.errors));
    for error in &evaluation.errors {
        assert!(error.passes() && error.wrong_outside_band == 0, "{error:?}");
        // As wide as before it followed from the triangle, but for a few pixels, and for those at edges of the very boxes.
        assert!(error.band_px < 100.0 && error.shadow_pixels > 2_500, "{error:?}");
    }
}
