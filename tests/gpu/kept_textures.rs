//! Textures that outlive a frame: drawn once for a key, again for another, and never taken for what they are not.

use shadowgraph::engine::plan::{
    self, Access, BlendState, CompareFunction, DrawState, Lifetime, Load, MULTIPLY, PlanError, Resource,
    Shader, TextureDesc, TextureFormat,
};
use shadowgraph::engine::render::Frame;
use shadowgraph::engine::scene::{ParamValue, Params};
use shadowgraph::engine::shadow::{
    Binding, Channels, ColorTarget, Contribution, Draw, Geometry, Pass, TechniqueEntry,
};
use shadowgraph::prelude::*;
use shadowgraph_testing::{Plain, catalog_with, renderer_with, technique};

const TEXT: &str = "
#import common/fullscreen

@group(1) @binding(0) var kept: texture_2d<f32>;

@fragment
fn quarter() -> @location(0) vec4f {
    return vec4f(0.25);
}

@fragment
fn copy() -> @location(0) vec4f {
    return textureLoad(kept, vec2u(0u), 0);
}
";

fn fullscreen(fragment: &'static str, blend: BlendState, bindings: Vec<(u32, Binding)>) -> Draw {
    let shader = Shader::written("keeper", TEXT, &[], "fullscreen_vertex", Some(fragment)).unwrap();
    let state = DrawState::new(CompareFunction::Always, vec![Some(blend)]);
    Draw::new(fragment, Geometry::fullscreen(shader), state).reading(bindings)
}

fn pass(name: &str, color: ColorTarget, draw: Draw) -> Pass {
    Pass { name: name.into(), reason: "a test".into(), colors: vec![color], depth: None, draws: vec![draw] }
}

/// Draws 1/4 into one kept texture, adds twice that into a second, and darkens its light by what is in the second.
/// Every draw beyond what one key needs is one too many, and doubles what is seen.
fn keeper(params: &Params) -> Plain {
    let number = |name: &str| match params.get(name) {
        Some(ParamValue::Number(value)) => *value,
        _ => 8.0,
    };
    let (key, size) = (number("key") as u64, number("size") as u32);
    Plain::new(move |light, out| {
        let (format, size) = (TextureFormat::R16Float, [size; 2]);
        let lifetime = Lifetime::Kept(key);
        let mut kept =
            |name| out.texture(TextureDesc { lifetime, ..TextureDesc::new(name, format, size, "a test") });
        let (first, second) = (kept("first"), kept("second"));
        let onto = |slot: Resource, load| ColorTarget::new(slot, load);
        let sum = BlendState { color: plan::BlendComponent::OVER, alpha: plan::BlendComponent::OVER };
        let sum = BlendState {
            color: plan::BlendComponent { dst_factor: plan::BlendFactor::One, ..sum.color },
            ..sum
        };
        let clear = Load::Clear([0.0; 4]);
        out.pass(pass("draw", onto(first, clear), fullscreen("quarter", BlendState::REPLACE, vec![])));
        let from = |slot: Resource| vec![(0, Binding::Texture(slot))];
        out.pass(pass("blur", onto(second, clear), fullscreen("copy", sum, from(first))));
        out.pass(pass("blur again", onto(second, Load::Keep), fullscreen("copy", sum, from(first))));
        let name = format!("apply to {}", light.light().name);
        out.pass(pass(&name, ColorTarget::VISIBILITY, fullscreen("copy", MULTIPLY, from(second))));
        Ok(Contribution::visibility(Channels::One))
    })
    .with_params(params)
}

const KEEPER: [TechniqueEntry; 1] = [technique!("Keeper", keeper)];

/// The yard with a node for each (key, size), each with a lamp of its own.
fn yard(nodes: &[(u64, u32)]) -> Scene {
    let mut scene = shadowgraph_testing::with_floor();
    shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(0.0, 1.5, 0.0));
    for (index, (key, size)) in nodes.iter().enumerate() {
        let lamp = shadowgraph_testing::add_lamp(&mut scene, &format!("lamp {index}"));
        let node = ShadowNode::new("Keeper").with_param("key", ParamValue::Number(*key as f64));
        let mut node = node.with_param("size", ParamValue::Number(f64::from(*size)));
        node.lights = Scope::Nodes(vec![lamp]);
        scene.add_shadow(&format!("node {index}"), node);
    }
    scene
}

fn render(renderer: &mut Renderer, nodes: &[(u64, u32)]) -> Frame {
    let request = FrameRequest { factors: true, ..shadowgraph_testing::request() };
    let options = RenderOptions { timing: Timing::Passes, ..RenderOptions::default() };
    let frame = renderer.render(&yard(nodes), &request, &options).unwrap();
    for image in &frame.factors {
        let lit = image.pixels.floats().unwrap();
        assert!(lit.iter().all(|factor| [0.0, 0.5, 1.0].contains(factor)), "{:?}", frame.kept);
        assert!(lit.contains(&0.5), "{:?}", frame.kept);
    }
    frame
}

/// How many passes of the keeper's textures ran.
fn drawn(frame: &Frame) -> usize {
    let of_kept = |name: &String| ["draw", "blur", "blur again"].contains(&name.as_str());
    let planned = frame.plan.passes.iter().filter(|pass| of_kept(&pass.name)).count();
    let kept = frame.kept.len();
    assert!(frame.kept.iter().all(of_kept), "{:?}", frame.kept);
    let timed = frame.times.iter().filter(|time| of_kept(&time.name)).count();
    assert!(frame.times.is_empty() || timed == planned - kept);
    planned - kept
}

#[test]
fn a_kept_texture_is_drawn_once_for_each_key() {
    let Some(mut renderer) = renderer_with(&KEEPER) else { return };
    let counts = |renderer: &mut Renderer, nodes: &[(u64, u32)]| drawn(&render(renderer, nodes));
    assert_eq!(counts(&mut renderer, &[(1, 8)]), 3);
    assert_eq!(counts(&mut renderer, &[(1, 8)]), 0);
    // Another key, another size: drawn again, once.
    assert_eq!(counts(&mut renderer, &[(2, 8)]), 3);
    assert_eq!(counts(&mut renderer, &[(2, 8)]), 0);
    assert_eq!(counts(&mut renderer, &[(2, 16)]), 3);
    assert_eq!(counts(&mut renderer, &[(2, 16)]), 0);
    // Two nodes of one key share; a third with its own has textures of its own, whichever comes first.
    assert_eq!(counts(&mut renderer, &[(3, 4), (4, 4)]), 6);
    assert_eq!(counts(&mut renderer, &[(4, 4), (3, 4)]), 0);
    // One of the two is left, and drawn over only when the other is needed again.
    assert_eq!(counts(&mut renderer, &[(4, 4)]), 0);
    assert_eq!(counts(&mut renderer, &[(5, 4), (4, 4)]), 3);
    // Unused for long enough, it is gone.
    for _ in 0..6 {
        counts(&mut renderer, &[(6, 32)]);
    }
    assert_eq!(counts(&mut renderer, &[(4, 4)]), 3);
}

#[test]
fn what_is_kept_ends_with_its_device_and_is_nobody_elses() {
    let Some(mut renderer) = renderer_with(&KEEPER) else { return };
    assert_eq!(drawn(&render(&mut renderer, &[(1, 8)])), 3);
    let mut other = Renderer::new(renderer.gpu().clone(), catalog_with(&KEEPER));
    assert_eq!(drawn(&render(&mut other, &[(1, 8)])), 3);
    assert_eq!(drawn(&render(&mut renderer, &[(1, 8)])), 0);
    renderer.gpu().device.destroy();
    assert_eq!(drawn(&render(&mut renderer, &[(1, 8)])), 3);
    assert_eq!(renderer.recoveries(), 1);
    assert_eq!(drawn(&render(&mut renderer, &[(1, 8)])), 0);
}

#[test]
fn a_frame_that_fails_leaves_nothing_that_counts_as_drawn() {
    let Some(mut renderer) = renderer_with(&KEEPER) else { return };
    // The scene's own shader does not compile on the device, after the passes of the kept textures were recorded.
    let request = shadowgraph_testing::request();
    let plan = renderer.plan(&yard(&[(1, 8)]), &request).unwrap();
    let (snapshot, _) = renderer.snapshot(&yard(&[(1, 8)])).unwrap();
    let mut broken = (*plan).clone();
    let last = broken.passes.iter_mut().rfind(|pass| pass.name.starts_with("apply")).unwrap();
    let plan::Geometry::Procedural { shader, .. } = &mut last.draws[0].geometry else { panic!("{broken}") };
    shader.source = "fn nothing".into();
    let mut executor = shadowgraph::engine::gpu::Executor::new(renderer.gpu().clone());
    let inputs = shadowgraph::engine::gpu::FrameInputs {
        snapshot: &snapshot,
        camera: &request.camera,
        exposure: 1.0,
        tone_map: true,
        timing: Timing::Off,
        read_back: &[],
    };
    executor.execute(&broken, &inputs).unwrap_err();
    assert_eq!(executor.execute(&plan, &inputs).unwrap().kept, [] as [&str; 0]);
    assert_eq!(executor.execute(&plan, &inputs).unwrap().kept.len(), 3);
    executor.execute(&broken, &inputs).unwrap_err();
    assert_eq!(executor.execute(&plan, &inputs).unwrap().kept, [] as [&str; 0]);
}

#[test]
fn plans_say_what_is_kept_and_refuse_what_cannot_be() {
    let plan = |nodes: &[(u64, u32)]| {
        let adapter = shadowgraph::engine::render::Adapter::imagined();
        let cache = shadowgraph::engine::shadow::Cache::new();
        shadowgraph_testing::try_plan_with(
            &yard(nodes),
            &shadowgraph_testing::request(),
            &catalog_with(&KEEPER),
            &adapter,
            &cache,
        )
        .unwrap()
    };
    let valid = plan(&[(31, 8)]);
    let text = valid.to_string();
    assert!(text.contains("kept under 000000000000001f"), "{text}");
    assert!(text.contains("kept: runs only when 'second' does not hold this key yet"), "{text}");
    // Two lights of one key: one texture.
    let count = |plan: &plan::FramePlan| plan.slots.iter().filter(|s| s.kept.is_some()).count();
    assert_eq!(
        (count(&valid), count(&plan(&[(31, 8), (31, 8)])), count(&plan(&[(31, 8), (32, 8)]))),
        (2, 2, 4)
    );

    let mut unwritten = valid.clone();
    unwritten.passes.retain(|pass| !pass.name.starts_with("blur"));
    let error = unwritten.validate().unwrap_err();
    assert!(matches!(error, PlanError::ReadBeforeWrite { .. }), "{error}");
    let mut mixed = valid.clone();
    let (picture, depth) = (mixed.picture, mixed.slots.iter().position(|slot| slot.name == "depth").unwrap());
    let draw = mixed.passes.iter_mut().find(|pass| pass.name == "draw").unwrap();
    draw.depth = Some(plan::DepthTarget {
        slot: plan::SlotId(depth),
        layer: 0,
        depth: Access::Clear(0.0),
        stencil: None,
    });
    let error = mixed.validate().unwrap_err();
    assert!(matches!(error, PlanError::KeptBesideOthers { .. }), "{error}");
    assert!(["'draw'", "'first'", "'depth'"].iter().all(|name| error.to_string().contains(name)), "{error}");
    let mut sampled = valid.clone();
    sampled.slots.iter_mut().filter(|slot| slot.kept.is_some()).for_each(|slot| {
        if let plan::SlotKind::Texture { samples, .. } = &mut slot.kind {
            *samples = 4;
        }
    });
    assert!(matches!(sampled.validate().unwrap_err(), PlanError::NotKeepable { .. }));
    assert_ne!(picture, plan::SlotId(depth));
}
