//! Transparent surfaces that shadows fall on: layer by layer, in the order of every pixel.

mod pictures;

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use shadowgraph::cases::{self, Case};
use shadowgraph::engine::geometry::shapes::{icosphere, plane, quad};
use shadowgraph::engine::plan::{FramePlan, SlotKind};
use shadowgraph::engine::render::{Adapter, FrameError};
use shadowgraph::engine::scene::{AlphaMode, ParamValue};
use shadowgraph::engine::shadow::{Cache, Layers, ShadowTechnique, TechniqueEntry, Traits};
use shadowgraph::measure::{
    ErrorTable, LayerEvaluation, LightQuery, LightSize, Reference, ReferenceShadow, Samples, SizedCasters,
    evaluate, evaluate_layers,
};
use shadowgraph::nodes::ShadowVolumeHard;
use shadowgraph::prelude::*;
use shadowgraph_testing::{Plain, catalog_with, renderer_with, technique};

/// Hard shadows of what is opaque, on layers too.
fn on_layers(receiver_layers: Layers) -> Plain {
    let hard = ShadowVolumeHard::default();
    Plain::new(move |light, out| hard.plan(light, out))
        .with_traits(Traits { receiver_layers, ..hard.traits() })
        .casting(move |instance| hard.casts(instance))
}

const ON_LAYERS: [TechniqueEntry; 3] = [
    ReferenceShadow::ENTRY,
    technique!("HardOnLayers", |_| on_layers(Layers::All)),
    technique!("HardOnFirst", |_| on_layers(Layers::First)),
];

fn renderer() -> Option<Renderer> {
    renderer_with(&ON_LAYERS)
}

fn blended(color: Vec3, alpha: f32) -> Material {
    Material { base_color: color.extend(alpha), alpha_mode: AlphaMode::Blend, ..Material::default() }
}

/// A pane whose height over the floor is 1.5 m and rises by `slope` for every metre along x.
fn pane(slope: f32) -> MeshData {
    let at = |x: f32, z: f32| Vec3::new(x, 1.5 + slope * x, z);
    quad([at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0), at(-1.0, -1.0)]).named("pane")
}

/// A floor, `panes`, and a lamp whose shadow node is `node`.
fn panes_over_floor(panes: &[(MeshData, Material)], floor: Material, node: &str) -> Scene {
    let mut scene = Scene::new();
    scene.set_background(Vec3::ZERO);
    scene.add_mesh(
        shadowgraph_testing::mesh(plane(Vec2::splat(3.0)).named("floor")),
        floor,
        DAffine3::IDENTITY,
    );
    for (data, material) in panes {
        scene.add_mesh(shadowgraph_testing::mesh(data.clone()), material.clone(), DAffine3::IDENTITY);
    }
    scene.add_light(Light::point("lamp", 60.0), DVec3::new(0.3, 5.0, 0.2), DVec3::ZERO);
    scene.add_shadow("shadows", ShadowNode::new(node));
    scene
}

fn from_above(size_px: [u32; 2]) -> FrameRequest {
    // x runs to the right.
    let eye = DVec3::new(0.0, 6.0, 0.4);
    let camera = CameraSnapshot::looking(Camera::perspective("eye", 0.6), eye, DVec3::ZERO);
    FrameRequest::new(camera, size_px)
}

fn linear(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    let request = FrameRequest { picture: PictureFormat::LinearF32, ..request.clone() };
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    renderer.render(scene, &request, &options).unwrap().picture.unwrap().floats().unwrap()
}

/// Every layer that the view has, judged.
fn judged(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<LayerEvaluation> {
    let layers = renderer.plan(scene, request).unwrap().layers;
    assert!(layers > 0);
    assert_eq!(surfaces_on(scene, request, layers), 0, "a surface is left behind the last layer");
    evaluate_layers(renderer, scene, request, 0..layers, &|_, _| {}).unwrap()
}

/// The pixels at which the reference sees a surface on this layer.
fn surfaces_on(scene: &Scene, request: &FrameRequest, layer: u32) -> usize {
    let FrameRequest { camera, size_px, antialias, .. } = request;
    let reference = Reference::new(&scene.snapshot().unwrap());
    let images = reference.render_layers(camera, *size_px, *antialias, &[], layer..layer + 1, &|_, _| {});
    images[0].hits.iter().flatten().count()
}

fn glass_case(name: &str) -> Case {
    let cases = cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST));
    cases.into_iter().find(|case| case.name() == name).unwrap_or_else(|| panic!("no case '{name}'"))
}

fn scene_of(case: &Case, technique: &str, options: &[(&str, &str)]) -> Scene {
    let entry = *catalog_with(&ON_LAYERS).find(technique).unwrap();
    let params = options.iter().map(|(name, value)| ((*name).into(), ParamValue::Text((*value).into())));
    case.scene_with(&entry, &params.collect()).unwrap()
}

fn check(name: &str, evaluations: &[LayerEvaluation]) -> usize {
    let mut compared = 0;
    for evaluation in evaluations {
        for error in &evaluation.errors {
            let table = ErrorTable(std::slice::from_ref(error)).to_string();
            // A layer may be empty, the number being a bound, or have only surfaces in the light's own direction.
            let nothing = error.compared == 0 && error.different_triangle == 0;
            assert!(error.passes() || nothing, "{name}, layer {}:\n{table}", evaluation.layer);
            let seen = evaluation.measured.ids.iter().filter(|id| id[0] != u32::MAX).count();
            assert!(seen.abs_diff(error.hit_pixels) <= 64, "{name}: {seen} of {} pixels", error.hit_pixels);
            compared += error.compared;
        }
    }
    compared
}

#[test]
fn factors_on_layers_are_those_of_the_reference() {
    let Some(mut renderer) = renderer() else { return };
    for name in ["opaque-behind-glass/box-above", "tinted-bottle", "glass-self/shell", "panes-intersecting"] {
        let case = glass_case(name);
        let scene = scene_of(&case, "HardOnLayers", &[]);
        let layers = judged(&mut renderer, &scene, &case.request());
        let compared = check(name, &layers);
        assert!(compared > 500, "{name}: {compared}");
        if name.starts_with("opaque") {
            assert!(layers[0].errors[0].shadow_pixels > 20, "{}", ErrorTable(&layers[0].errors));
        }
    }
}

#[test]
fn coloured_factors_on_layers_are_those_of_the_reference() {
    let Some(mut renderer) = renderer() else { return };
    for name in ["glass-self/shell", "panes-intersecting", "stained-glass/window", "count-figure"] {
        let case = glass_case(name);
        let scene = scene_of(&case, "Reference", &[("selfShadow", "full")]);
        let layers = judged(&mut renderer, &scene, &case.request());
        let compared = check(name, &layers);
        assert!(compared > 500, "{name}: {compared}");
        // Light that has passed one pane falls on another.
        let shadow: usize = layers.iter().map(|layer| layer.errors[0].shadow_pixels).sum();
        assert!(shadow > 500 || name.starts_with("stained"), "{name}: {shadow}");
        let opaque = evaluate(&mut renderer, &scene, &case.request(), &|_, _| {}).unwrap();
        assert!(opaque.errors[0].passes(), "{name}:\n{}", ErrorTable(&opaque.errors));
    }
}

/// A pane that rises so, under a tile and a lamp of 1.5 m: the pane casts colours, the tile soft shadows.
fn pane_under_wide_lamp(slope: f32) -> Scene {
    let mut scene = Scene::new();
    let floor = shadowgraph_testing::mesh(plane(Vec2::splat(3.0)).named("floor"));
    scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
    let glass = blended(Vec3::new(1.0, 0.4, 0.1), 0.5);
    let glass = scene.add_mesh(shadowgraph_testing::mesh(pane(slope)), glass, DAffine3::IDENTITY);
    let tile = shadowgraph_testing::mesh(plane(Vec2::splat(0.5)).named("tile"));
    let tile = scene.add_mesh(tile, Material::default(), shadowgraph_testing::at(0.2, 3.4, 0.0));
    scene.add_light(Light::point("lamp", 60.0), DVec3::new(0.3, 5.0, 0.2), DVec3::ZERO);
    scene.add_shadow("glass", ShadowNode::new("TransparentShadow").with_casters([glass]));
    let mut soft = ShadowNode::new("ShadowVolumeSoft").with_casters([tile]);
    soft.params.insert("radius".into(), ParamValue::Number(1.5));
    soft.params.insert("samples".into(), ParamValue::Number(16.0));
    scene.add_shadow("soft", soft);
    scene
}

/// Judges that scene's layers; how many of their pixels are in penumbrae.
fn check_under_wide_lamp(slope: f32) -> Option<usize> {
    let mut renderer = renderer()?;
    let layers = judged(&mut renderer, &pane_under_wide_lamp(slope), &from_above([120, 96]));
    assert!(check(&format!("slope {slope}"), &layers) > 500);
    assert_eq!(layers[0].errors[0].same_samples, Some(16));
    Some(layers[0].errors[0].penumbra_pixels)
}

#[test]
fn lights_with_a_size_are_judged_on_layers() {
    for slope in [0.0, 0.9, -1.6] {
        let Some(penumbra) = check_under_wide_lamp(slope) else { return };
        assert!(penumbra > 100, "{penumbra} pixels in penumbrae");
    }
}

/// Where the lamp dips below a pane's own plane, light passes the pane: no part of it is dark by itself.
#[test]
fn a_lamp_that_dips_below_a_pane_lights_it_all_the_same() {
    for slope in [3.0, -5.0] {
        check_under_wide_lamp(slope);
    }
}

#[test]
fn only_opaque_surfaces_have_a_horizon() {
    let size = LightSize { radius_m: 1.5, half_angle_rad: 0.0 };
    let sized = vec![SizedCasters { casters: vec![], transparent: vec![], size, samples: Samples::Same(16) }];
    let query = [LightQuery { sized, ..LightQuery::default() }];
    let request = from_above([120, 96]);
    let camera = &request.camera;
    let judge = |alpha_mode: AlphaMode| {
        let mut scene = panes_over_floor(&[], Material::default(), "ShadowVolumeHard");
        let material = Material { alpha_mode, ..blended(Vec3::X, 0.5) };
        scene.add_mesh(shadowgraph_testing::mesh(pane(3.0)), material, DAffine3::IDENTITY);
        let reference = Reference::new(&scene.snapshot().unwrap());
        let nothing = |_: usize, _: usize| {};
        let opaque = reference.render(camera, request.size_px, &query, &nothing);
        let layers =
            reference.render_layers(camera, request.size_px, Antialias::None, &query, 0..1, &nothing);
        [&opaque, &layers[0]].map(|image| {
            let pane = image.hits.iter().map(|hit| hit.is_some_and(|hit| hit.instance == 1));
            let factors = image.lights[0].factor.iter().zip(pane);
            let on_pane: Vec<f32> =
                factors.filter(|(_, is_pane)| *is_pane).map(|(factor, _)| *factor).collect();
            (on_pane.len(), on_pane.iter().filter(|factor| **factor < 1.0).count())
        })
    };
    let [(seen, partly), (layers, _)] = judge(AlphaMode::Opaque);
    assert!(seen > 1000 && partly > 500 && layers == 0, "{seen} on the board, {partly} of them partly dark");
    let [(seen, _), (layers, partly)] = judge(AlphaMode::Blend);
    assert!(seen == 0 && layers > 1000 && partly == 0, "{layers} on the pane, {partly} of them partly dark");
}

#[test]
fn two_surfaces_at_one_depth_are_two_layers() {
    let Some(mut renderer) = renderer() else { return };
    let twice = |color| (pane(0.0), blended(color, 0.5));
    let panes = [twice(Vec3::X), twice(Vec3::Y)];
    let scene = panes_over_floor(&panes, Material::default(), "HardOnLayers");
    let layers = judged(&mut renderer, &scene, &from_above([120, 96]));
    assert!(check("twice", &layers) > 2000);
    let instances = |layer: &LayerEvaluation| {
        let mut seen: Vec<u32> =
            layer.measured.ids.iter().map(|id| id[0]).filter(|id| *id != u32::MAX).collect();
        seen.sort_unstable();
        seen.dedup();
        seen
    };
    // The first drawn is the nearer.
    assert_eq!(instances(&layers[0]), [1]);
    assert_eq!(instances(&layers[1]), [2]);
}

#[test]
fn only_the_nearest_layer_is_shadowed_when_that_is_asked_for() {
    let Some(mut renderer) = renderer() else { return };
    let panes = [(pane(0.0).moved(Vec3::Y), blended(Vec3::X, 0.3)), (pane(0.0), blended(Vec3::Y, 0.3))];
    let picture = |renderer: &mut Renderer, node: &str| {
        let mut scene = panes_over_floor(&panes, Material::default(), node);
        shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(0.9, 3.6, 0.0));
        let request = from_above([120, 96]);
        let passes = |plan: &FramePlan| plan.passes_named("volumes of lamp").count();
        let plan = renderer.plan(&scene, &request).unwrap();
        (linear(renderer, &scene, &request), plan.layers, passes(&plan))
    };
    let (all, layers, of_all) = picture(&mut renderer, "HardOnLayers");
    let (first, of_nearest, of_first) = picture(&mut renderer, "HardOnFirst");
    // Only the first is drawn as a layer.
    assert_eq!((layers, of_nearest), (2, 1));
    // The opaque surfaces', and those of layers.
    assert_eq!((of_all, of_first), (1 + layers as usize, 2));
    let brighter = first.iter().zip(&all).filter(|(first, all)| *first > &(*all + 0.01)).count();
    let darker = first.iter().zip(&all).filter(|(first, all)| *first < &(*all - 0.01)).count();
    assert!(brighter > 100 && darker == 0, "{brighter} brighter, {darker} darker");
}

fn plan_of(scene: &Scene, request: &FrameRequest) -> Result<FramePlan, FrameError> {
    shadowgraph_testing::try_plan_with(
        scene,
        request,
        &catalog_with(&ON_LAYERS),
        &Adapter::imagined(),
        &Cache::new(),
    )
}

#[test]
fn layers_are_in_the_plan_only_where_they_are_needed() {
    let glass = [(pane(0.0), blended(Vec3::X, 0.3))];
    let request = from_above([120, 96]);
    let names = |plan: &FramePlan| {
        let passes = plan.passes.iter().map(|pass| pass.name.clone());
        passes.chain(plan.slots.iter().map(|slot| slot.name.clone())).collect::<Vec<_>>().join("\n")
    };
    let none = |scene: &Scene, request: &FrameRequest| {
        let plan = plan_of(scene, request).unwrap();
        assert!(plan.layers == 0 && !names(&plan).contains("layer"), "{plan}");
    };
    // No technique asks; nothing transparent; nothing transparent in view; the lamp reaches nothing.
    none(&panes_over_floor(&glass, Material::default(), "ShadowVolumeHard"), &request);
    none(&panes_over_floor(&[], Material::default(), "HardOnLayers"), &request);
    let away = [(pane(0.0).moved(Vec3::X * 50.0), blended(Vec3::X, 0.3))];
    none(&panes_over_floor(&away, Material::default(), "HardOnLayers"), &request);
    let behind = [(pane(0.0).moved(Vec3::Y * 9.0), blended(Vec3::X, 0.3))];
    none(&panes_over_floor(&behind, Material::default(), "HardOnLayers"), &request);

    let scene = panes_over_floor(&glass, Material::default(), "HardOnLayers");
    let plan = plan_of(&scene, &request).unwrap();
    assert!((1..=2).contains(&plan.layers), "{plan}");
    assert!(plan.layer_triangles.is_empty() && !names(&plan).contains("factor of"), "{plan}");
    // What is asked for is kept, whatever else there is.
    let request = FrameRequest { factors: true, layer_factors: 0..9, ..request };
    let with_factors = plan_of(&scene, &request).unwrap();
    assert_eq!(with_factors.layer_triangles.len(), plan.layers as usize);
    assert_eq!(with_factors.lights[0].layer_factor_images.len(), plan.layers as usize);
}

#[test]
fn memory_does_not_grow_with_layers() {
    let bytes = |count: usize| {
        let panes: Vec<_> =
            (0..count).map(|i| (pane(0.0).moved(Vec3::Y * 0.01 * i as f32), blended(Vec3::X, 0.3))).collect();
        let scene = panes_over_floor(&panes, Material::default(), "HardOnLayers");
        let plan = plan_of(&scene, &from_above([120, 96])).unwrap();
        assert!(plan.layers as usize >= count, "{count}: {}", plan.layers);
        let textures = plan.slots.iter().filter(|slot| matches!(slot.kind, SlotKind::Texture { .. }));
        textures.map(|slot| slot.bytes()).sum::<u64>()
    };
    assert_eq!(bytes(3), bytes(40));
}

#[test]
fn what_layers_cannot_do_is_refused_by_name() {
    let glass = [(pane(0.0), blended(Vec3::X, 0.3))];
    let scene = panes_over_floor(&glass, Material::default(), "HardOnLayers");
    let sampled = FrameRequest { antialias: Antialias::Multisample4, ..from_above([120, 96]) };
    let error = plan_of(&scene, &sampled).unwrap_err().to_string();
    assert!(error.contains("'shadows' (HardOnLayers)") && error.contains("ssaa4"), "{error}");
    let twice = FrameRequest { antialias: Antialias::Supersample4, ..from_above([120, 96]) };
    assert!(plan_of(&scene, &twice).unwrap().layers > 0);
    let many = MeshData::merged("many", (0..1100).map(|i| pane(0.0).moved(Vec3::Y * 0.001 * i as f32)));
    let scene = panes_over_floor(&[(many, blended(Vec3::X, 0.01))], Material::default(), "HardOnLayers");
    let error = plan_of(&scene, &from_above([120, 96])).unwrap_err().to_string();
    assert!(error.contains("'shadows'") && error.contains("the limit is 1024"), "{error}");
}

/// Triangles of all sizes and directions around the eye, before and behind it.
fn soup(seed: u32, count: usize) -> MeshData {
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0
    };
    let mut positions = Vec::new();
    for _ in 0..count {
        let middle = Vec3::new(random() * 2.0, 3.0 + random() * 4.0, random() * 2.0);
        let size = 0.05 + random().abs() * 2.0;
        positions.extend((0..3).map(|_| middle + Vec3::new(random(), random(), random()) * size));
    }
    let indices = (0..positions.len() as u32).collect();
    MeshData { name: "soup".into(), positions, indices, ..MeshData::default() }
}

#[test]
fn no_pixel_has_more_layers_than_were_counted() {
    for seed in 0..12 {
        let double_sided = seed % 2 == 0;
        let material = Material { double_sided, ..blended(Vec3::X, 0.3) };
        // Now and then under a mirroring transform. Of so many, four turn towards the eye somewhere.
        let mut scene = panes_over_floor(&[], Material::default(), "HardOnLayers");
        let mirrored = DAffine3::from_scale(DVec3::new(if seed % 3 == 0 { -1.0 } else { 1.0 }, 1.0, 1.0));
        scene.add_mesh(shadowgraph_testing::mesh(soup(seed, 150)), material, mirrored);
        let request = from_above([96, 64]);
        let layers = plan_of(&scene, &request).unwrap().layers;
        assert!(layers > 3, "{layers}");
        assert_eq!(surfaces_on(&scene, &request, layers), 0, "seed {seed}: more than {layers} layers");
        // What the floor hides and what lies next to edges is counted too; but little of it is there.
        assert!(surfaces_on(&scene, &request, layers - 3) > 0, "seed {seed}: {layers} layers are too many");
    }
}

#[test]
fn balls_have_as_many_layers_as_they_have_sides() {
    let ball = |y: f32| (icosphere(0.8, 3).moved(Vec3::Y * y).named("ball"), blended(Vec3::X, 0.3));
    let scene = panes_over_floor(&[ball(1.0), ball(3.0)], Material::default(), "HardOnLayers");
    let layers = plan_of(&scene, &from_above([320, 240])).unwrap().layers;
    // Two sides each; and what lies next to edges and corners may count twice.
    assert!((4..=7).contains(&layers), "{layers}");
    let single = |y: f32| {
        let (data, material) = ball(y);
        (data, Material { double_sided: false, ..material })
    };
    let scene = panes_over_floor(&[single(1.0), single(3.0)], Material::default(), "HardOnLayers");
    let layers = plan_of(&scene, &from_above([320, 240])).unwrap().layers;
    assert!((2..=4).contains(&layers), "{layers}");
}
