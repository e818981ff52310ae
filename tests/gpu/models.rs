//! Real meshes: models that were never made for shadow volumes, under each kind of light and each depth test.
//!
//! Bunny and teapot are open, the monkey is non-manifold, the plant's leaves are loose quads: whatever the mesh, not
//! one pixel outside the ambiguity band may be wrong. The reference depends on scene, camera, light and casters only,
//! so one reference picture judges all three depth tests.
//!
//! The models are data that is not part of the project; without their folder the test is skipped.

use shadowgraph::engine::gltf;
use shadowgraph::measure::{
    LightError, LightQuery, Reference, ReferenceImage, compare, expect_shadow, queries,
};
use shadowgraph::prelude::*;

const MODELS: [&str; 7] = ["stanford-bunny", "teapot", "suzanne", "spot", "knot63k", "plant", "boxes1k"];
const DEPTH_TESTS: [(&str, DepthTest); 3] =
    [("auto", DepthTest::Auto), ("zfail", DepthTest::ZFail), ("zpass", DepthTest::ZPass)];
const SIZE_PX: [u32; 2] = [1280, 720];

/// The three lights, with where they stand.
fn lights() -> [(Light, DVec3); 3] {
    [
        (Light::point("point", 50.0), DVec3::new(3.0, 6.5, 2.0)),
        (Light::directional("directional", 3.0), DVec3::new(2.0, 3.0, 1.5)),
        (Light::spot("spot", 50.0, 0.6), DVec3::new(-3.0, 5.0, 3.0)),
    ]
}

/// What all lights shine at.
const LIT_POINT: DVec3 = DVec3::new(0.0, 0.5, 0.0);

/// A model over a floor that casts nothing.
fn model_scene(folder: &std::path::Path, name: &str) -> Scene {
    let mut scene = gltf::load(folder.join(format!("{name}.glb"))).unwrap().scene;
    let floor = shadowgraph_testing::mesh(shapes::plane(Vec2::splat(12.0)));
    let key = scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
    if let Content::Mesh(floor) = &mut scene.node_mut(key).unwrap().content {
        floor.shadow.casts = false;
    }
    scene
}

/// A request for the picture from `eye` towards `target`.
fn request(eye: DVec3, target: DVec3) -> FrameRequest {
    let camera = Camera::perspective("eye", 45_f64.to_radians());
    FrameRequest::new(CameraSnapshot::looking(camera, eye, target), SIZE_PX)
}

/// The horizontal direction in which shadows of things at the origin fall.
fn away_from(light: glam::DVec4) -> DVec3 {
    DVec3::new(-light.x, 0.0, -light.z).normalize()
}

/// A place just above the floor where the near rectangle, whichever way it is turned, is all in shadow: the one
/// furthest away from the light, so that it is not within the model.
fn eye_in_shadow(reference: &Reference, query: &LightQuery, light: glam::DVec4) -> DVec3 {
    let casters = reference.caster_set(&query.casters);
    let mut tracer = reference.tracer();
    // 4.1 cm up and 7.4 cm aside reach the corners of a rectangle 10 cm before the eye.
    let around = [DVec3::ZERO, DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let away = away_from(light);
    let steps = || (-60..=60).map(|step| f64::from(step) * 0.05);
    let mut places: Vec<DVec3> = steps().flat_map(|x| steps().map(move |z| DVec3::new(x, 0.2, z))).collect();
    places.sort_by(|a, b| b.dot(away).total_cmp(&a.dot(away)));
    let dark = |place: &DVec3, tracer: &mut shadowgraph::measure::Tracer<'_>| {
        around.iter().all(|step| tracer.is_blocked(*place + *step * 0.14, None, light, &casters))
    };
    places.into_iter().find(|place| dark(place, &mut tracer)).expect("the model casts a shadow to stand in")
}

/// What one light's part of `image` says, alone.
fn only_light(image: &ReferenceImage, index: usize) -> ReferenceImage {
    ReferenceImage {
        size_px: image.size_px,
        hits: image.hits.clone(),
        ties: image.ties.clone(),
        lights: vec![image.lights[index].clone()],
    }
}

/// Prints a run's row and says what is wrong with it.
fn judge(row: &str, error: &LightError) -> Option<String> {
    let share = 100.0 * error.wrong as f64 / error.compared.max(1) as f64;
    println!(
        "{row:<44} wrong {:>3} ({share:.5} %, leak {:>2}, false {:>2})  out of band {}  band {:>5} of boundary \
         {:>5}  shadow {:>6}  other triangle {}",
        error.wrong,
        error.leak,
        error.false_shadow,
        error.wrong_outside_band,
        error.band_pixels,
        error.boundary_pixels,
        error.shadow_pixels,
        error.different_triangle,
    );
    let lit = error.shadow_pixels < error.compared;
    let sound = error.passes() && lit && expect_shadow(std::slice::from_ref(error)).is_ok();
    (!sound).then(|| format!("{row}: {error:?}"))
}

/// Runs every depth test of one model, light and camera against one reference picture.
fn run(
    renderer: &mut Renderer,
    scene: &Scene,
    name: &str,
    request: &FrameRequest,
    reference: &ReferenceImage,
    failures: &mut Vec<String>,
) {
    let inside = name.ends_with("inside");
    for (word, depth_test) in DEPTH_TESTS {
        let mut scene = scene.clone();
        let key = scene.shadows().next().unwrap().0;
        *scene.shadow_mut(key).unwrap() = ShadowVolumeHard { depth_test, ..Default::default() }.into();
        let row = format!("{name} {word}");
        let result = shadowgraph_testing::measure(renderer, &scene, request);
        match (result, inside && depth_test == DepthTest::ZPass) {
            (Ok(measured), false) => {
                let errors = compare(&measured, reference).unwrap();
                failures.extend(errors.iter().filter_map(|error| judge(&row, error)));
            }
            (Err(error @ (RenderError::Shadow(_) | RenderError::Frame(_))), true) => {
                println!("{row:<44} refused: {error}");
            }
            (Ok(_), true) => failures.push(format!("{row}: drew something, but the eye is in shadow")),
            (Err(error), _) => failures.push(format!("{row}: {error}")),
        }
    }
}

#[test]
fn models_cast_exact_shadows_under_every_light_and_depth_test() {
    let Some(folder) = shadowgraph_testing::model("") else { return };
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let filter = std::env::var("MODEL").unwrap_or_default();
    let mut failures = Vec::new();
    let mut judged = 0;
    for model in MODELS.into_iter().filter(|model| model.contains(&filter)) {
        let base = model_scene(&folder, model);
        // The reference sees all three lights at once, the renderer one at a time.
        let mut all = base.clone();
        for (light, position) in lights() {
            all.add_light(light, position, LIT_POINT);
        }
        all.add_shadow("shadows", ShadowVolumeHard::default());
        let (snapshot, registry) = renderer.snapshot(&all).unwrap();
        let reference = Reference::new(&snapshot);
        let queries = queries(&registry);
        let outside = request(DVec3::new(3.2, 3.6, 6.2), DVec3::new(0.0, 0.9, 0.0));
        let seen_from_outside = reference.render(&outside.camera, SIZE_PX, &queries, &|_, _| {});
        for (index, (light, position)) in lights().into_iter().enumerate() {
            let name = format!("{model} {}", light.name);
            let mut scene = base.clone();
            scene.add_light(light, position, LIT_POINT);
            scene.add_shadow("shadows", ShadowVolumeHard::default());
            let image = only_light(&seen_from_outside, index);
            run(&mut renderer, &scene, &format!("{name} outside"), &outside, &image, &mut failures);

            // From within the shadow, looking out of it past its edge.
            let light = snapshot.lights[index].position;
            let eye = eye_in_shadow(&reference, &queries[index], light);
            let inside = request(eye, DVec3::new(eye.x, 0.0, eye.z) + away_from(light) * 0.7);
            let image = reference.render(&inside.camera, SIZE_PX, &queries[index..=index], &|_, _| {});
            run(&mut renderer, &scene, &format!("{name} inside"), &inside, &image, &mut failures);
            judged += 2;
        }
    }
    assert!(judged > 0, "no model is called '{filter}'");
    assert!(failures.is_empty(), "{} runs fail:\n{}", failures.len(), failures.join("\n"));
}
