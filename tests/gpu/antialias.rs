//! Antialiasing beyond the hard case `msaa`: the picture is the mean of its samples, the mean factor is nearer to the
//! truth than one sample is, and what cannot be multisampled is refused.

use shadowgraph::engine::plan::{Binding, FactorAt, PlanError, SlotKind, TextureFormat};
use shadowgraph::engine::render::{Adapter, FrameError};
use shadowgraph::engine::scene::ShadowFlags;
use shadowgraph::engine::shadow::{Cache, ShadowError};
use shadowgraph::measure::{EvaluateError, Reference, evaluate, mean_of_samples, queries};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [192, 128];
const BOTH: [Antialias; 2] = [Antialias::Multisample4, Antialias::Supersample4];

/// A matt floor lit from straight above and far away, with bars floating over it: its radiance is the same wherever
/// the light reaches it, so that what the picture shows of the floor is the mean factor and nothing else.
fn grid(lights: usize, nodes: &[ShadowNode]) -> Scene {
    let mut scene = Scene::new();
    scene.set_ambient(Vec3::ZERO);
    let matt = Material::matt("matt", Vec3::splat(0.5));
    // One triangle, all of it in view: what is clipped falls apart, and its fragments are tone-mapped apart.
    let positions = vec![Vec3::new(-2.6, 0.0, 1.8), Vec3::new(2.6, 0.0, 1.8), Vec3::new(0.0, 0.0, -2.0)];
    let floor = MeshData { name: "floor".into(), positions, indices: vec![0, 1, 2], ..MeshData::default() };
    scene.add_mesh(Mesh::new(floor).unwrap(), matt.clone(), DAffine3::IDENTITY);
    let mut bars = Vec::new();
    for bar in 0..9 {
        let x = -2.0 + 0.5 * bar as f32;
        let data = shapes::cuboid(Vec3::new(x, 40.0, -3.0), Vec3::new(x + 0.13, 40.1, 3.0 - 0.3 * x));
        let turned = DAffine3::from_rotation_y(0.3);
        bars.push(scene.add_mesh(Mesh::new(data).unwrap(), matt.clone(), turned));
    }
    for light in 0..lights {
        let away = DVec3::new(0.01 * light as f64, -1.0, 0.0);
        scene.add_light(Light::directional(&format!("sun{light}"), 1.0), DVec3::ZERO, away);
    }
    // Each casts for bars of its own.
    for (place, node) in nodes.iter().enumerate() {
        let casters = Scope::Nodes(bars.iter().skip(place).step_by(nodes.len()).copied().collect());
        scene.add_shadow("shadows", ShadowNode { casters, ..node.clone() });
    }
    scene
}

/// Under the bars: only the floor is in view.
fn under_the_bars(antialias: Antialias) -> FrameRequest {
    let eye = CameraSnapshot::looking(
        Camera::perspective("eye", 0.7),
        DVec3::new(0.3, 6.0, 3.0),
        DVec3::new(0.0, 0.0, 0.2),
    );
    FrameRequest { antialias, factors: true, ..FrameRequest::new(eye, SIZE_PX) }
}

fn linear(srgb: u8) -> f32 {
    let v = f32::from(srgb) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Radiance from its tone-mapped value, of greys below the shoulder.
fn before_tone_mapping(value: f32) -> f32 {
    if value < 0.04 { (value / 6.25).sqrt() } else { value + 0.04 }
}

/// The picture's light as a share of the same scene's without shadows, pixel by pixel, beside the mean factor of all lights there.
fn picture_and_factor(nodes: &[ShadowNode], lights: usize, antialias: Antialias) -> Option<Vec<(f32, f32)>> {
    let mut renderer = shadowgraph_testing::renderer()?;
    // Dim enough for the shoulder to begin beyond it.
    let options = RenderOptions {
        read_picture: true,
        exposure: Exposure::Fixed(2.0 / lights as f32),
        ..RenderOptions::default()
    };
    let request = under_the_bars(antialias);
    let [frame, unshadowed] =
        [nodes, &[]].map(|nodes| renderer.render(&grid(lights, nodes), &request, &options).unwrap());
    let size_px = antialias.factor_size_px(SIZE_PX);
    let mut factors = vec![0.0; (SIZE_PX[0] * SIZE_PX[1]) as usize];
    assert_eq!(frame.factors.len(), lights);
    for factor in &frame.factors {
        let means = mean_of_samples(size_px, &factor.pixels.floats().unwrap());
        factors.iter_mut().zip(means).for_each(|(sum, mean)| *sum += mean / lights as f32);
    }
    // Within a fragment factors are averaged before radiance is tone-mapped, between pixels after.
    let light = |texel: &[u8]| match antialias {
        Antialias::Multisample4 => before_tone_mapping(linear(texel[0])),
        _ => linear(texel[0]),
    };
    // The floor's own edges are left out.
    let seen = frame.visible_triangles.as_ref().unwrap();
    let seen: Vec<f32> = seen.iter().map(|id| if id[0] == 0 { 1.0 } else { 0.0 }).collect();
    let whole = mean_of_samples(size_px, &seen).into_iter().map(|seen| seen == 1.0);
    let [picture, unshadowed] = [frame, unshadowed].map(|frame| frame.picture.unwrap());
    assert_eq!(picture.size_px, SIZE_PX);
    let pairs = picture.bytes.chunks_exact(4).zip(unshadowed.bytes.chunks_exact(4));
    let pixels = pairs.map(|(texel, lit)| light(texel) / light(lit)).zip(factors);
    Some(pixels.zip(whole).filter(|(_, whole)| *whole).map(|(pixel, _)| pixel).collect())
}

#[test]
fn the_picture_shows_the_mean_factor_of_its_samples() {
    let [four, twice] = BOTH;
    let hard = ShadowNode::from(ShadowVolumeHard::default());
    // What asks each sample by itself, alone and with counts on the same lights.
    let map = ShadowNode::from(SilhouetteMap { resolution: 512, ..SilhouetteMap::default() });
    let both = [hard.clone(), map.clone()];
    let (hard, map) = ([hard], [map]);
    for (nodes, lights, antialias) in [
        (&hard[..], 1, four),
        (&hard, 1, twice),
        (&hard, 2, four),
        (&hard, 11, four),
        (&map, 1, four),
        (&map, 1, twice),
        (&both, 2, four),
    ] {
        let Some(pixels) = picture_and_factor(nodes, lights, antialias) else { return };
        let between = pixels.iter().filter(|(_, factor)| *factor > 0.2 && *factor < 0.8).count();
        assert!(between > 200, "{lights} {antialias}: {between} pixels on edges");
        let worst = pixels.iter().map(|(red, factor)| (red - factor).abs()).fold(0.0, f32::max);
        // Eight bits, a slight gloss, and irradiances that differ a little between the lights.
        println!(
            "{} nodes, {lights} lights, {antialias}: {between} edge pixels, off by at most {worst:.4}",
            nodes.len()
        );
        assert!(worst < 0.02, "{lights} {antialias}: {worst}");
    }
}

/// Root mean square of (mean factor − truth) over the pixels that shadow edges cross, for each way of antialiasing.
fn edge_errors(
    renderer: &mut Renderer,
    scene: &Scene,
    camera: &CameraSnapshot,
    size_px: [u32; 2],
) -> [(Antialias, f64); 3] {
    let (snapshot, registry) = renderer.snapshot(scene).unwrap();
    let truth =
        Reference::new(&snapshot).render_supersampled(camera, size_px, &queries(&registry), &|_, _| {}, 8);
    let truth = &truth.lights[0].1;
    let edges: Vec<usize> = (0..truth.len()).filter(|i| truth[*i] > 0.0 && truth[*i] < 1.0).collect();
    assert!(edges.len() > 100, "{} pixels on edges", edges.len());
    [Antialias::None, Antialias::Multisample4, Antialias::Supersample4].map(|antialias| {
        let request = FrameRequest { antialias, ..FrameRequest::new(camera.clone(), size_px) };
        let evaluation = evaluate(renderer, scene, &request, &|_, _| {}).unwrap();
        assert!(evaluation.errors.iter().all(|error| error.passes()), "{antialias}: {:?}", evaluation.errors);
        let measured = evaluation.measured;
        let means = match antialias {
            Antialias::None => measured.lights[0].1.clone(),
            _ => mean_of_samples(measured.size_px, &measured.lights[0].1),
        };
        let seen = edges.iter().filter(|i| !means[**i].is_nan());
        let squares: Vec<f64> = seen.map(|i| f64::from(means[*i] - truth[*i]).powi(2)).collect();
        (antialias, (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
    })
}

#[test]
fn smoothed_shadow_edges_are_nearer_to_the_truth() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = Scene::new();
    let mut add = |data, place| scene.add_mesh(Mesh::new(data).unwrap(), Material::default(), place);
    add(shapes::plane(Vec2::splat(6.0)).named("floor"), DAffine3::IDENTITY);
    add(shapes::torus_knot([2, 3], 0.6, 0.18, [96, 12]), DAffine3::from_translation(DVec3::Y * 1.2));
    scene.add_light(Light::point("lamp", 40.0), DVec3::new(-1.5, 4.0, 1.0), DVec3::ZERO);
    scene.add_shadow("shadows", ShadowVolumeHard::default());
    let eye = Camera::perspective("eye", 0.8);
    let eye = CameraSnapshot::looking(eye, DVec3::new(3.0, 4.0, 6.0), DVec3::new(0.0, 0.5, 0.0));
    let errors = edge_errors(&mut renderer, &scene, &eye, SIZE_PX);
    println!("{errors:?}");
    let [(_, none), (_, four), (_, twice)] = errors;
    // One sample errs by √(1/6) of an edge's step on the average; four halve that at least.
    assert!(four < 0.5 * none && twice < 0.5 * none, "{errors:?}");
}

/// `cargo test --test gpu what_antialiasing -- --ignored --nocapture`: the figures the documentation quotes.
#[test]
#[ignore = "measures: run it alone on a quiet machine"]
fn what_antialiasing_costs_and_gains_on_the_speed_scenes() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let scenes = [
        ("knot13k", DVec3::new(3.2, 3.6, 6.2), DVec3::new(0.0, 0.9, 0.0)),
        ("boxes1k", DVec3::new(3.6, 4.4, 7.0), DVec3::new(0.0, 0.5, 0.0)),
    ];
    for (name, eye, target) in scenes {
        let Some(path) = shadowgraph_testing::model(&format!("{name}.glb")) else { continue };
        let mut scene = shadowgraph::engine::gltf::load(&path).unwrap().scene;
        let floor = Mesh::new(shapes::plane(Vec2::splat(12.0)).named("floor")).unwrap();
        let (mesh, material) =
            (scene.add_mesh_data(std::sync::Arc::new(floor)), scene.add_material(Material::default()));
        let shadow = ShadowFlags { casts: false, receives: true };
        let floor = MeshNode { shadow, ..MeshNode::new(mesh, material) };
        scene.add(None, "floor", DAffine3::IDENTITY, Content::Mesh(floor));
        scene.add_light(Light::point("lamp", 100.0), DVec3::new(3.0, 6.5, 2.0), DVec3::ZERO);
        scene.add_shadow("shadows", ShadowVolumeHard::default());
        let camera = Camera::perspective("eye", 45_f64.to_radians());
        let camera = CameraSnapshot::looking(camera, eye, target);
        let size_px = [1280, 720];
        let ways = [Antialias::None, Antialias::Multisample4, Antialias::Supersample4];
        let mut times_ms = [const { Vec::new() }; 3];
        // In turn, so that whatever else the machine does falls on all three.
        for round in 0..14 {
            for (antialias, times_ms) in ways.into_iter().zip(&mut times_ms) {
                let request = FrameRequest { antialias, ..FrameRequest::new(camera.clone(), size_px) };
                let start = std::time::Instant::now();
                renderer.render(&scene, &request, &RenderOptions::default()).unwrap();
                if round >= 3 {
                    times_ms.push(start.elapsed().as_secs_f64() * 1e3);
                }
            }
        }
        let medians = times_ms.map(|mut times_ms| {
            times_ms.sort_by(f64::total_cmp);
            times_ms[times_ms.len() / 2]
        });
        // A quarter of the pixels says as much about edges, and its truth is traced in a quarter of the time.
        let errors = edge_errors(&mut renderer, &scene, &camera, [640, 360]);
        for ((antialias, error), median_ms) in errors.into_iter().zip(medians) {
            let ratio = median_ms / medians[0];
            println!("{name} {antialias}: {median_ms:.1} ms, {ratio:.2} of none, edge error {error:.4}");
        }
    }
}

fn request(antialias: Antialias) -> FrameRequest {
    FrameRequest { antialias, ..shadowgraph_testing::request() }
}

#[test]
fn four_samples_are_resolved_by_the_pass_that_draws_the_picture() {
    let plan = shadowgraph_testing::plan(
        &shadowgraph_testing::shadowed_yard(&[]),
        &request(Antialias::Multisample4),
    );
    let shading = plan.passes.last().unwrap();
    assert_eq!(shading.name, "shading");
    assert_eq!(shading.colors[0].resolve, Some(plan.picture));
    assert_eq!(plan.lights[0].factor, FactorAt::Counts);
    for slot in plan.slots.iter().filter(|slot| ["depth", "picture in samples"].contains(&slot.name.as_str()))
    {
        assert!(matches!(slot.kind, SlotKind::Texture { samples: 4, .. }), "{slot}");
    }
    // Depth tells which samples show a fragment.
    let bindings = &shading.draws[0].bindings;
    assert!(bindings.iter().any(|(number, binding)| *number == 3 && matches!(binding, Binding::Texture(_))));
    let text = plan.to_string();
    assert!(text.contains("of 4 samples") && text.contains("resolved into 'picture'"), "{text}");
    // Nothing is shadowed: nothing but the picture and its depth has samples, and nothing reads them.
    let plan = shadowgraph_testing::plan(&shadowgraph_testing::yard(), &request(Antialias::Multisample4));
    assert_eq!(plan.slots.len(), 3, "{plan}");
    assert!(plan.passes.iter().all(|pass| pass.draws.iter().all(|draw| draw.bindings.is_empty())));
}

#[test]
fn four_pixels_are_averaged_by_a_pass_of_its_own() {
    let plan = shadowgraph_testing::plan(
        &shadowgraph_testing::shadowed_yard(&[]),
        &request(Antialias::Supersample4),
    );
    assert_eq!(plan.size_px, shadowgraph_testing::SIZE_PX.map(|n| n * 2));
    assert_eq!(plan.picture_size_px(), shadowgraph_testing::SIZE_PX);
    assert_eq!(plan.passes.last().unwrap().name, "average");
}

#[test]
fn samples_that_do_not_match_are_refused_by_the_plan() {
    let good = shadowgraph_testing::plan(
        &shadowgraph_testing::shadowed_yard(&[]),
        &request(Antialias::Multisample4),
    );
    let sampled = |name: &str| good.slots.iter().position(|slot| slot.name == name).unwrap();
    let mut plan = good.clone();
    if let SlotKind::Texture { samples, .. } = &mut plan.slots[sampled("picture in samples")].kind {
        *samples = 1;
    }
    let error = plan.validate().unwrap_err();
    assert!(matches!(error, PlanError::Samples { samples: 4, other_samples: 1, .. }), "{error}");
    let mut plan = good.clone();
    if let SlotKind::Texture { format, .. } = &mut plan.slots[sampled("picture")].kind {
        *format = TextureFormat::Rgba8Unorm;
    }
    let error = plan.validate().unwrap_err();
    assert!(matches!(error, PlanError::Resolve { .. }), "{error}");
    let mut plan = good.clone();
    let depth = plan.passes.last_mut().unwrap().draws[0].bindings.iter_mut().find(|(number, _)| *number == 3);
    let (_, binding) = depth.unwrap();
    *binding = Binding::TextureArray(binding.resource().unwrap());
    assert!(matches!(plan.validate(), Err(PlanError::WrongKind { .. })));
}

#[test]
fn what_has_no_samples_is_refused_with_what_is_accepted() {
    let assert_names = |error: &dyn std::error::Error, parts: &[&str]| {
        let text = error.to_string();
        parts.iter().for_each(|part| assert!(text.contains(part), "'{part}' is not in '{text}'"));
    };
    let four = request(Antialias::Multisample4);
    // A factor for each fragment is none for each sample.
    let mut scene = shadowgraph_testing::yard();
    scene.add_shadow("fog", ShadowNode::new("Veil"));
    let plan = |scene: &Scene, request: &FrameRequest, adapter: &Adapter<'_>| {
        let catalog = shadowgraph_testing::catalog_with(&[shadowgraph_testing::VEIL]);
        shadowgraph_testing::try_plan_with(scene, request, &catalog, adapter, &Cache::new())
    };
    let error = plan(&scene, &four, &Adapter::imagined()).unwrap_err();
    assert!(matches!(error, FrameError::Shadow(ShadowError::NotPerSample { .. })));
    assert_names(&error, &["'fog'", "Veil", "R16Float", "msaa4", "ssaa4"]);
    assert!(plan(&scene, &request(Antialias::Supersample4), &Adapter::imagined()).is_ok());
    // Nor is a counter of floats, and its own format is named.
    let counting = shadowgraph_testing::shadowed_yard(&[("counter", "float")]);
    let error = plan(&counting, &four, &Adapter::imagined()).unwrap_err();
    assert_names(&error, &["'shadows'", "ShadowVolumeHard", "R16Float", "ssaa4"]);
    // One darkening of the picture is per sample, as its stencil is.
    let darkened =
        plan(&shadowgraph_testing::shadowed_yard(&[("passes", "single")]), &four, &Adapter::imagined())
            .unwrap();
    let last = darkened.passes.last().unwrap();
    assert!(last.name == "darkening" && last.colors[0].resolve == Some(darkened.picture), "{darkened}");
    // A picture of 32-bit floats.
    let scene = shadowgraph_testing::shadowed_yard(&[]);
    let linear = FrameRequest { picture: PictureFormat::LinearF32, ..four.clone() };
    let error = plan(&scene, &linear, &Adapter::imagined()).unwrap_err();
    assert_names(&error, &["the picture", "Rgba32Float", "ssaa4"]);
    let linear = FrameRequest { antialias: Antialias::Supersample4, ..linear };
    assert!(plan(&scene, &linear, &Adapter::imagined()).is_ok());
    // An adapter without such a depth.
    let poor =
        Adapter { name: "Old GPU", multisampled: &[TextureFormat::Rgba8UnormSrgb], ..Adapter::imagined() };
    let error = plan(&scene, &four, &poor).unwrap_err();
    assert_names(&error, &["depth", "Depth32FloatStencil8", "'Old GPU'", "accepted for it: none, ssaa4"]);
    // More lights than one layer of the mask holds.
    let mut scene = shadowgraph_testing::with_floor();
    shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(0.0, 1.5, 0.0));
    for light in 0..33 {
        shadowgraph_testing::add_lamp(&mut scene, &format!("lamp{light}"));
    }
    scene.add_shadow("shadows", shadowgraph_testing::hard(&[]));
    let error = plan(&scene, &four, &Adapter::imagined()).unwrap_err();
    assert_names(&error, &["33", "32", "ssaa4"]);
    // Twice the size is too large.
    let small = Adapter { max_size_px: 100, ..Adapter::imagined() };
    let error = plan(&shadowgraph_testing::yard(), &request(Antialias::Supersample4), &small).unwrap_err();
    assert_names(&error, &["64x48", "128x96", "ssaa4", "100"]);
    assert!(plan(&shadowgraph_testing::yard(), &four, &small).is_ok());
    assert!(plan(&shadowgraph_testing::yard(), &FrameRequest { factors: true, ..four }, &small).is_err());
}

#[test]
fn the_reference_as_a_technique_is_supersampled_and_not_multisampled() {
    let Some(renderer) = shadowgraph_testing::renderer() else { return };
    let mut catalog = shadowgraph_nodes::catalog();
    catalog.register(shadowgraph::measure::ReferenceShadow::ENTRY);
    let mut renderer = Renderer::new(renderer.gpu().clone(), catalog);
    let mut scene = shadowgraph_testing::yard();
    scene.add_shadow("truth", ShadowNode::new("Reference"));
    let judged =
        |renderer: &mut Renderer, antialias| evaluate(renderer, &scene, &request(antialias), &|_, _| {});
    let evaluation = judged(&mut renderer, Antialias::Supersample4).unwrap();
    assert!(evaluation.errors[0].passes() && evaluation.errors[0].shadow_pixels > 0);
    let error = judged(&mut renderer, Antialias::Multisample4).unwrap_err();
    let EvaluateError::Render(error) = error else { panic!("{error}") };
    assert!(error.to_string().contains("Reference"), "{error}");
}
