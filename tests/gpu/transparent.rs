//! `TransparentShadow`: the hand-made answers of the glass cases in every setting, what is lit exactly, and every order of
//! drawing.

use shadowgraph::cases::{self, Case, sweeps};
use shadowgraph::measure::{ErrorTable, LayerEvaluation, Measured, evaluate_layers};
use shadowgraph::prelude::*;
use shadowgraph_engine::plan::{FramePlan, SlotKind, TextureFormat};
use shadowgraph_engine::render::{Adapter, FrameError, plan_frame};
use shadowgraph_engine::scene::{AlphaMode, ParamValue};
use shadowgraph_engine::shadow::{Cache, Features, Registry, Setting, ShadowError, TechniqueEntry};
use shadowgraph_nodes::{Accumulate, TransparentShadow};

/// The value of `light`'s factor at the pixel that shows `point`.
fn factor_at(case: &Case, measured: &Measured, light: &str, point: DVec3) -> [f32; 3] {
    let [width, height] = case.size_px;
    let aspect = f64::from(width) / f64::from(height);
    let view = case.camera.world_from_view.inverse().transform_point3(point);
    let clip = case.camera.projection.clip_from_view(aspect) * view.extend(1.0);
    let (x, y) = (clip.x / clip.w * 0.5 + 0.5, 0.5 - clip.y / clip.w * 0.5);
    let pixel = (y * f64::from(height)) as usize * width as usize + (x * f64::from(width)) as usize;
    let (_, factors) = measured.lights.iter().find(|(name, _)| name == light).unwrap();
    match factors.len() / (width * height) as usize {
        1 => [factors[pixel]; 3],
        channels => [0, 1, 2].map(|i| factors[pixel * channels + i]),
    }
}

/// How far the worst probe of `case` is off in this setting; `None` when it is refused.
fn worst_probe(
    renderer: &mut Renderer,
    case: &Case,
    entry: &TechniqueEntry,
    setting: Setting,
) -> Option<f32> {
    let scene = case.scene_with(entry, &(setting.params)()).unwrap();
    let measured = match shadowgraph_testing::measure(renderer, &scene, &case.request()) {
        Ok(measured) => measured,
        Err(RenderError::Frame(error)) => {
            println!("{} {}: {error}", case.name(), setting.name);
            return None;
        }
        Err(error) => panic!("{}: {error}", case.name()),
    };
    let off = |probe: &cases::Probe| {
        let found = factor_at(case, &measured, &probe.light, probe.p_in_world);
        (0..3).map(|i| (found[i] - probe.factor[i]).abs()).fold(0.0, f32::max)
    };
    Some(case.probes.iter().map(off).fold(0.0, f32::max))
}

fn glass_cases() -> Vec<Case> {
    let ids = [
        "alpha-0",
        "alpha-1",
        "channel-0",
        "glass-order",
        "glass-deep",
        "tinted-bottle",
        "stained-glass",
        "glass-self",
        "panes-intersecting",
        "opaque-behind-glass",
        "count-figure",
    ];
    let hard = cases::all()
        .into_iter()
        .filter(|entry| ids.contains(&entry.id))
        .flat_map(|entry| entry.build(&shadowgraph::CAST));
    let steps = sweeps::all().into_iter().filter(|sweep| sweep.id.starts_with("glass-"));
    hard.chain(steps.flat_map(|sweep| sweep.steps(&shadowgraph::CAST)).map(|(_, case)| case)).collect()
}

#[test]
fn hand_made_answers_hold_in_every_setting() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let entry = TransparentShadow::ENTRY;
    let mut wrong = Vec::new();
    let only = std::env::var("CASE").unwrap_or_default();
    for case in glass_cases().into_iter().filter(|case| case.name().contains(&only)) {
        for setting in entry.all_settings() {
            let Some(off) = worst_probe(&mut renderer, &case, &entry, setting) else { continue };
            println!("{:32} {:10} {off:.6}", case.name(), setting.name);
            let bound = match setting.name {
                "default" | "grid-log" | "log32" => 1e-3,
                _ => 2.0,
            };
            if off > bound {
                wrong.push(format!("{} {}: {off}", case.name(), setting.name));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A floor, and things of five tints one behind the other: boxes, a ball, a fan of sheets, and a sheet of many colours.
/// `order` says in which order they stand in the scene; `nodes` shadow nodes share them.
fn pile(order: &[usize], nodes: usize, accumulate: Accumulate) -> (Scene, FrameRequest) {
    let mut scene = Scene::new();
    let floor = shadowgraph_testing::mesh(shapes::plane(Vec2::splat(6.0)).named("floor"));
    scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
    let fan = (0..5).map(|i| {
        let y = 0.2 * i as f32;
        shapes::quad([v(-0.5, 1.0, 0.0), v(0.5, 1.0, 0.0), v(0.5, 1.0 - y, 0.7), v(-0.5, 1.0 - y, 0.7)])
    });
    let mut sheet = shapes::sheet(3, 3, |x, y| v(x * 2.0 - 1.0, 0.55, y * 2.0 - 1.0));
    let many = |i: usize| glam::Vec4::new(0.9, 0.1 * (i % 7) as f32, 0.5, 0.4);
    sheet.colors = (0..sheet.positions.len()).map(many).collect();
    let things = [
        (shapes::cuboid(v(-0.6, 0.3, -0.6), v(0.4, 1.1, 0.5)), v(0.9, 0.3, 0.2), 0.3),
        (shapes::cuboid(v(-0.2, 0.2, -0.3), v(0.7, 1.6, 0.3)), v(0.2, 0.8, 0.9), 0.45),
        (shapes::icosphere(0.6, 3).moved(v(0.1, 1.3, 0.1)), v(0.7, 0.7, 0.1), 0.1),
        (MeshData::merged("fan", fan), v(0.97, 0.5, 0.0), 0.0625),
        (shapes::torus(0.6, 0.15, 24, 12).moved(v(0.0, 1.9, 0.0)), v(0.9, 0.3, 0.2), 0.3),
        (sheet, v(1.0, 1.0, 1.0), 1.0),
    ];
    let mut keys = Vec::new();
    for index in order {
        let (data, color, alpha) = things[*index].clone();
        let glass = Material {
            base_color: color.extend(alpha),
            alpha_mode: AlphaMode::Blend,
            ..Material::matt("glass", color)
        };
        keys.push(scene.add_mesh(shadowgraph_testing::mesh(data), glass, DAffine3::IDENTITY));
    }
    scene.add_light(Light::point("lamp", 60.0), DVec3::new(0.7, 4.0, 0.4), DVec3::ZERO);
    scene.add_light(Light::directional("sun", 3.0), DVec3::new(2.0, 4.0, 1.0), DVec3::ZERO);
    for casters in keys.chunks(keys.len().div_ceil(nodes).max(1)) {
        let node = ShadowNode::from(TransparentShadow { accumulate, ..TransparentShadow::default() });
        scene.add_shadow("glass", node.with_casters(casters.iter().copied()));
    }
    let camera = Camera::perspective("eye", 0.8);
    let camera = CameraSnapshot::looking(camera, DVec3::new(2.4, 2.6, 3.4), DVec3::new(0.0, 0.4, 0.0));
    (scene, FrameRequest::new(camera, [160, 120]))
}

/// Each light's name and factors, as bits.
fn factor_bits(renderer: &mut Renderer, (scene, request): &(Scene, FrameRequest)) -> Vec<(String, Vec<u32>)> {
    let measured = shadowgraph_testing::measure(renderer, scene, request).unwrap();
    let bits = |values: &Vec<f32>| values.iter().map(|value| value.to_bits()).collect();
    measured.lights.iter().map(|(name, values)| (name.clone(), bits(values))).collect()
}

#[test]
fn the_order_of_drawing_changes_no_pixel() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let orders: [[usize; 6]; 4] =
        [[0, 1, 2, 3, 4, 5], [5, 4, 3, 2, 1, 0], [2, 0, 4, 1, 5, 3], [3, 5, 1, 4, 0, 2]];
    for accumulate in [Accumulate::Counts, Accumulate::GridLog] {
        let first = factor_bits(&mut renderer, &pile(&orders[0], 1, accumulate));
        assert_eq!(first.len(), 2);
        for (light, bits) in &first {
            let tinted = bits.iter().filter(|bits| **bits != 1.0_f32.to_bits()).count();
            assert!(tinted > 2000 && tinted < bits.len() / 2, "{light}: {tinted} of {}", bits.len());
        }
        for order in &orders[1..] {
            assert_eq!(
                factor_bits(&mut renderer, &pile(order, 1, accumulate)),
                first,
                "{accumulate:?} {order:?}"
            );
        }
    }
    // The check can fail: half-float logarithms do depend on it.
    let of = |renderer: &mut Renderer, order| factor_bits(renderer, &pile(order, 1, Accumulate::Log16));
    assert_ne!(of(&mut renderer, &orders[0]), of(&mut renderer, &orders[1]));
}

/// A grid of logarithms takes no more than 7e-4 from a factor, however many surfaces there are.
#[test]
fn the_grid_is_within_its_error_of_counts() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let entry = TransparentShadow::ENTRY;
    let mut worst = 0.0_f32;
    let names = ["glass-deep/128-boxes", "glass-self/shell"];
    for case in glass_cases().into_iter().filter(|case| names.contains(&case.name().as_str())) {
        let mut factors = |accumulate: &str| {
            let params = [("accumulate".to_owned(), ParamValue::Text(accumulate.into()))].into();
            let scene = case.scene_with(&entry, &params).unwrap();
            shadowgraph_testing::measure(&mut renderer, &scene, &case.request())
                .ok()
                .map(|found| found.lights)
        };
        // Where the grid would be too coarse it is refused.
        let (Some(counts), Some(grid)) = (factors("counts"), factors("gridLog")) else { continue };
        let pairs = counts.iter().zip(&grid).flat_map(|((_, counts), (_, grid))| counts.iter().zip(grid));
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        println!("{}: {off:.1e}", case.name());
        worst = worst.max(off);
    }
    assert!(worst > 0.0 && worst <= 7e-4, "{worst}");
}

/// Several nodes are several products in half floats: the same but for their rounding, and exactly lit where they are.
#[test]
fn nodes_that_share_a_light_multiply() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let order = [0, 1, 2, 3, 4, 5];
    let (scene, request) = pile(&order, 1, Accumulate::Counts);
    let one = shadowgraph_testing::measure(&mut renderer, &scene, &request).unwrap();
    for nodes in [2, 3, 6] {
        let (scene, request) = pile(&order, nodes, Accumulate::Counts);
        let several = shadowgraph_testing::measure(&mut renderer, &scene, &request).unwrap();
        for ((light, one), (_, several)) in one.lights.iter().zip(&several.lights) {
            let worst = one.iter().zip(several).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 2e-3 && worst > 0.0, "{light}, {nodes} nodes: {worst}");
            assert!(
                one.iter().zip(several).all(|(a, b)| (*a == 1.0) == (*b == 1.0)),
                "{light}, {nodes} nodes"
            );
        }
    }
}

/// Every layer of every light that the view has, judged: how many pixels were compared.
fn exact_on_layers(renderer: &mut Renderer, name: &str, scene: &Scene, request: &FrameRequest) -> usize {
    let count = renderer.plan(scene, request).unwrap().layers;
    let layers = evaluate_layers(renderer, scene, request, 0..count, &|_, _| {}).unwrap();
    let mut compared = 0;
    for LayerEvaluation { layer, errors, .. } in &layers {
        for error in errors {
            // A layer may be empty: the plan knows triangles, not pixels.
            let nothing = error.compared == 0 && error.different_triangle == 0;
            let table = ErrorTable(std::slice::from_ref(error)).to_string();
            assert!(error.passes() || nothing, "{name}, layer {layer}:\n{table}");
            compared += error.compared;
        }
    }
    compared
}

/// On every layer the factor is the reference's: of glass behind glass, through itself, and where panes cross.
#[test]
fn every_layer_is_exact() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let entry = TransparentShadow::ENTRY;
    let only = std::env::var("CASE").unwrap_or_default();
    let hard = glass_cases().into_iter().filter(|case| case.name().contains(&only));
    for case in hard.filter(|case| !case.name().starts_with("glass-depth")) {
        for accumulate in ["counts", "gridLog"] {
            let params = [("accumulate".to_owned(), ParamValue::Text(accumulate.into()))].into();
            let scene = case.scene_with(&entry, &params).unwrap();
            let name = format!("{} {accumulate}", case.name());
            let compared = exact_on_layers(&mut renderer, &name, &scene, &case.request());
            println!("{name:40} {compared} pixels of layers");
            // Alpha 0 is no surface; black glass lies under other glass or is one surface: all else is seen.
            assert!(compared > 0 || case.id == "alpha-0" || case.id == "alpha-1", "{name} has no layers");
        }
    }
}

/// Points, spots and directions, white and coloured, each alone and all at once; served by one node or by two, the other
/// of which has opaque casters.
#[test]
fn lights_of_every_kind_are_exact_on_layers() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let (mut scene, request) = pile(&[0, 1, 3, 5], 1, Accumulate::Counts);
    let spot = Light { color: v(1.0, 0.5, 0.2), ..Light::spot("spot", 90.0, 0.7) };
    scene.add_light(spot, DVec3::new(-2.0, 3.5, 1.5), DVec3::new(0.0, 0.8, 0.0));
    scene.add_light(
        Light { color: v(0.2, 0.4, 1.0), ..Light::directional("moon", 1.0) },
        DVec3::new(-1.0, 2.0, -1.5),
        DVec3::ZERO,
    );
    let compared = exact_on_layers(&mut renderer, "one node", &scene, &request);
    assert!(compared > 20_000, "{compared}");
    // Opaque casters through a node of their own: what both leave multiplies.
    let ball = shapes::icosphere(0.25, 3).moved(v(0.5, 2.4, 0.3)).named("ball");
    let ball = scene.add_mesh(shadowgraph_testing::mesh(ball), Material::default(), DAffine3::IDENTITY);
    scene.add_shadow("opaque", ShadowNode::from(ShadowVolumeHard::default()).with_casters([ball]));
    let compared = exact_on_layers(&mut renderer, "two nodes", &scene, &request);
    assert!(compared > 20_000, "{compared}");
}

/// Four samples of a pixel are refused by name, for the light's visibility or else for the layers; four times the pixels
/// are drawn.
#[test]
fn four_samples_are_refused() {
    let (mut scene, request) = pile(&[0, 1], 1, Accumulate::Counts);
    let with = |scene: &Scene, antialias| {
        plan_without(scene, &FrameRequest { antialias, ..request.clone() }, Features::empty())
    };
    let error = with(&scene, Antialias::Multisample4).unwrap_err();
    assert!(matches!(error, FrameError::Shadow(ShadowError::NotPerSample { .. })), "{error}");
    assert!(error.to_string().contains("'glass'"), "{error}");
    assert!(with(&scene, Antialias::Supersample4).unwrap().layers > 0);
    // What is opaque is counted for each sample, but not on layers.
    let ball = shapes::icosphere(0.25, 3).moved(v(0.5, 2.4, 0.3)).named("ball");
    let ball = scene.add_mesh(shadowgraph_testing::mesh(ball), Material::default(), DAffine3::IDENTITY);
    let glass: Vec<_> = scene.shadows().map(|(key, _)| key).collect();
    for key in glass {
        let node = scene.shadow(key).unwrap().clone();
        *scene.shadow_mut(key).unwrap() = node.with_casters([ball]);
    }
    let error = with(&scene, Antialias::Multisample4).unwrap_err();
    assert!(matches!(error, FrameError::MultisampledLayers { .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains("'glass'") && said.contains("ssaa4"), "{said}");
    assert_eq!(with(&without_layers(scene), Antialias::Multisample4).unwrap().layers, 0);
}

/// A plan without a device, on an adapter that lacks `missing`.
fn plan_without(scene: &Scene, request: &FrameRequest, missing: Features) -> Result<FramePlan, FrameError> {
    let snapshot = scene.snapshot().unwrap();
    let registry = Registry::collect(&snapshot, &shadowgraph_nodes::catalog()).unwrap();
    let adapter =
        Adapter { name: "Old GPU", features: Features::all().difference(missing), ..Adapter::imagined() };
    plan_frame(&snapshot, &registry, request, &adapter, &Cache::new())
}

/// The format of the slot whose name begins so.
fn format_of(plan: &FramePlan, name: &str) -> Option<TextureFormat> {
    let slot = plan.slots.iter().find(|slot| slot.name.starts_with(name))?;
    match slot.kind {
        SlotKind::Texture { format, .. } => Some(format),
        _ => None,
    }
}

/// The scene, its transparent surfaces drawn as if lit.
fn without_layers(mut scene: Scene) -> Scene {
    let nodes: Vec<_> = scene.shadows().map(|(key, _)| key).collect();
    for key in nodes {
        let node = scene.shadow_mut(key).unwrap();
        node.params.insert("selfShadow".into(), ParamValue::Text("none".into()));
    }
    scene
}

#[test]
fn sums_are_as_wide_as_they_must_be() {
    let (none, blendable) = (Features::empty(), Features::FLOAT32_BLENDABLE);
    let sheet =
        |_: usize| shapes::quad([v(-1.0, 1.0, 1.0), v(1.0, 1.0, 1.0), v(1.0, 1.0, -1.0), v(-1.0, 1.0, -1.0)]);
    let of = |count: usize, tints: usize, data: &dyn Fn(usize) -> MeshData| {
        let (mut scene, request) = pile(&[], 1, Accumulate::Counts);
        for i in 0..count {
            let color = Vec3::new(0.5, 0.25 + 0.5 * (i % tints) as f32 / tints as f32, 0.5);
            let glass = Material {
                base_color: color.extend(0.5),
                alpha_mode: AlphaMode::Blend,
                ..Material::default()
            };
            scene.add_mesh(
                shadowgraph_testing::mesh(data(i)),
                glass,
                DAffine3::from_translation(DVec3::Y * 0.01 * i as f64),
            );
        }
        scene.add_shadow("glass", TransparentShadow::default());
        (scene, request)
    };
    // One tint is a few surfaces: half floats hold them, and nothing optional is needed.
    let (scene, request) = of(3, 1, &sheet);
    let plan = plan_without(&scene, &request, blendable).unwrap();
    assert_eq!(format_of(&plan, "surfaces before a light"), Some(TextureFormat::R16Float), "{plan}");
    // Several share a float's bits; without floats they take channels of half floats.
    let (scene, request) = of(4, 4, &sheet);
    let plan = plan_without(&scene, &request, none).unwrap();
    assert_eq!(format_of(&plan, "surfaces before a light"), Some(TextureFormat::R32Float), "{plan}");
    let plan = plan_without(&scene, &request, blendable).unwrap();
    assert!(matches!(
        format_of(&plan, "surfaces before a light"),
        Some(TextureFormat::Rg16Float | TextureFormat::Rgba16Float)
    ));
    // What draws more than half floats count needs floats, and says so.
    let (scene, request) = of(1, 1, &|_| shapes::icosphere(0.5, 5).moved(Vec3::Y * 2.0));
    let plan = plan_without(&scene, &request, none).unwrap();
    assert_eq!(format_of(&plan, "surfaces before a light"), Some(TextureFormat::R32Float), "{plan}");
    let error = plan_without(&scene, &request, blendable).unwrap_err().to_string();
    for named in ["'glass'", "FLOAT32_BLENDABLE", "accumulate=counts", "'Old GPU'"] {
        assert!(error.contains(named), "{error}");
    }
    // Many tints take more passes over the same target, and each draw turns eight of them into light.
    let (scene, request) = of(60, 60, &sheet);
    let plan = plan_without(&scene, &request, none).unwrap();
    let sums = plan.slots.iter().filter(|slot| slot.name.starts_with("surfaces before a light")).count();
    assert_eq!(sums, 1, "one target for both lights and every layer");
    let turned = |plan: &FramePlan| {
        plan.passes_named("light through glass of lamp").map(|pass| pass.draws.len()).sum::<usize>()
    };
    let (scene, request) = of(60, 60, &sheet);
    let scene = without_layers(scene);
    let opaque_only = turned(&plan_without(&scene, &request, none).unwrap());
    assert!((8..=16).contains(&opaque_only), "{opaque_only}");
}

/// Opaque casters alone are counted as through the hard technique: no float target, no visibility.
#[test]
fn what_is_opaque_needs_nothing_more() {
    let scene = |node: ShadowNode| {
        let (mut scene, request) = pile(&[], 1, Accumulate::Counts);
        scene.add_mesh(
            shadowgraph_testing::mesh(shapes::icosphere(0.5, 3)),
            Material::default(),
            DAffine3::IDENTITY,
        );
        scene.add_shadow("shadows", node);
        (scene, request)
    };
    let plan =
        |(scene, request): (Scene, FrameRequest)| plan_without(&scene, &request, Features::empty()).unwrap();
    let hard = plan(scene(ShadowVolumeHard::default().into()));
    let transparent = plan(scene(TransparentShadow::default().into()));
    assert_eq!(hard.passes, transparent.passes);
    let slots = |plan: &FramePlan| plan.slots.iter().map(ToString::to_string).collect::<Vec<_>>();
    assert_eq!(slots(&hard), slots(&transparent));
}

#[test]
fn options_are_read_and_saved() {
    let entry = TransparentShadow::ENTRY;
    for setting in entry.all_settings() {
        let params = (setting.params)();
        let technique = (entry.from_params)(&params).unwrap();
        assert!(params.iter().all(|(name, value)| technique.params().get(name) == Some(value)), "{params:?}");
    }
    let refused = |name: &str, value: &str| {
        let params = [(name.to_owned(), ParamValue::Text(value.into()))].into();
        (entry.from_params)(&params).unwrap_err().to_string()
    };
    let said = refused("accumulate", "log");
    assert!(
        said.contains("'log'") && said.contains("counts, gridLog, log16, product16, log32, product32"),
        "{said}"
    );
    assert!(refused("selfShadow", "some").contains("full, partial, none"));
    assert!(refused("radius", "1").contains("it has: accumulate, selfShadow"));
}
