//! What a plan may say, said by techniques of these tests' own and executed: slots are told apart by id and not by name,
//! shaders that do not compose are errors, and everything that maps need is there.

use std::sync::Arc;

use shadowgraph::engine::plan::{
    Access, BufferDesc, CompareFunction, DrawState, MULTIPLY, PlanError, Shader, Slot, SlotKind, Stencil,
    StencilFaceState, StencilOperation, TextureDesc, TextureFormat,
};
use shadowgraph::engine::scene::ParamValue;
use shadowgraph::engine::shadow::{
    Binding, Channels, ColorTarget, Contribution, DepthTarget, Draw, Geometry, Pass, PassList, ShadowError,
    TechniqueEntry, hash_of,
};
use shadowgraph::prelude::*;
use shadowgraph_testing::{Plain, catalog_with, over_visibility, pass, renderer_with, technique};

/// A technique of one plan.
macro_rules! does {
    ($plan:expr) => {
        technique!("Does", |_| Plain::new($plan))
    };
}

/// A crate over a floor under one lamp, with such a node.
fn scene() -> Scene {
    let mut scene = shadowgraph_testing::yard();
    scene.add_shadow("does", ShadowNode::new("Does"));
    scene
}

fn plan(entry: TechniqueEntry) -> Result<shadowgraph::engine::plan::FramePlan, ShadowError> {
    let (catalog, adapter) = (catalog_with(&[entry]), shadowgraph::engine::render::Adapter::imagined());
    let cache = &shadowgraph::engine::shadow::Cache::new();
    shadowgraph_testing::try_plan_with(&scene(), &shadowgraph_testing::request(), &catalog, &adapter, cache)
        .map_err(|error| match error {
            shadowgraph::engine::render::FrameError::Shadow(error) => error,
            other => panic!("{other}"),
        })
}

/// The factor of the first light, over a floor that fills the picture.
fn factor(entry: TechniqueEntry) -> Option<(Vec<f32>, [usize; 2])> {
    let mut renderer = renderer_with(&[entry])?;
    let down = shadowgraph_testing::camera(DVec3::new(0.0, 3.0, 0.01), DVec3::ZERO);
    let request = FrameRequest { factors: true, ..FrameRequest::new(down, [64, 48]) };
    let frame = renderer.render(&scene(), &request, &RenderOptions::default()).unwrap();
    Some((frame.factors[0].pixels.floats().unwrap(), [64, 48]))
}

/// Lights may have one name: their images once were one texture, which held the last light's factor.
#[test]
fn lights_of_one_name_have_factors_of_their_own() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = shadowgraph_testing::yard();
    let far = Light::point("lamp", 40.0).with_range(0.5);
    scene.add_light(far, DVec3::new(30.0, 30.0, 0.0), DVec3::ZERO);
    scene.add_shadow("shadows", ShadowVolumeHard::default());
    let request = FrameRequest { factors: true, ..shadowgraph_testing::request() };
    let frame = renderer.render(&scene, &request, &RenderOptions::default()).unwrap();
    let dark = |at: usize| frame.factors[at].pixels.floats().unwrap().iter().filter(|f| **f == 0.0).count();
    assert_eq!(frame.factors.len(), 2);
    assert!(dark(0) > dark(1), "{} and {} dark pixels", dark(0), dark(1));
}

/// Two textures of one name and shape, of which the first is read after the second was drawn.
#[test]
fn slots_of_one_name_and_shape_are_two_textures() {
    const TEXT: &str = "
        #import common/fullscreen
        @group(1) @binding(0) var first: texture_2d<f32>;
        @fragment fn read() -> @location(0) vec4f { return textureLoad(first, vec2u(0u), 0); }
    ";
    let twins = does!(|_, out| {
        let desc = TextureDesc::new("twin", TextureFormat::R16Float, [8, 8], "a test");
        let [first, second] = [out.texture(desc), out.texture(desc)];
        for (texture, value) in [(first, 0.5), (second, 0.25)] {
            let load = shadowgraph::engine::plan::Load::Clear([value; 4]);
            out.pass(Pass { colors: vec![ColorTarget::new(texture, load)], ..pass("twin", vec![]) });
        }
        let shader = Shader::written("read", TEXT, &[], "fullscreen_vertex", Some("read"))?;
        out.pass(over_visibility("read", shader, Some(MULTIPLY), vec![(0, Binding::Texture(first))]));
        Ok(Contribution::visibility(Channels::One))
    });
    let Some((factor, _)) = factor(twins) else { return };
    assert!(factor.iter().all(|f| [0.0, 0.5, 1.0].contains(f)) && factor.contains(&0.5), "{factor:?}");
}

/// Indices of which the shader makes vertices, in a frame that has no visibility: they once moved by a slot.
#[test]
fn indices_stay_what_they_are_where_no_visibility_is() {
    const TEXT: &str = "
        @vertex fn corner(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
            return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
        }
    ";
    let counts = does!(|_, out| {
        let bytes: Vec<u8> = [0_u32, 1, 2].iter().flat_map(|index| index.to_ne_bytes()).collect();
        let indices = out.buffer(BufferDesc::index("corners", hash_of(&bytes), Arc::new(bytes), "a test"));
        let shader = Shader::written("corners", TEXT, &[], "corner", None)?;
        let geometry = Geometry::IndexedProcedural { shader, indices, first: 0, count: 3, record: 0 };
        let face = StencilFaceState {
            compare: CompareFunction::Always,
            fail_op: StencilOperation::Keep,
            depth_fail_op: StencilOperation::Keep,
            pass_op: StencilOperation::IncrementWrap,
        };
        let mut state = DrawState::new(CompareFunction::Always, vec![]);
        state.stencil =
            Some(Stencil { front: face, back: face, read_mask: 0xff, write_mask: 0xff, reference: 0 });
        let draws = vec![Draw::new("everything", geometry, state)];
        out.pass(Pass { depth: Some(DepthTarget::COUNT), ..pass("count", draws) });
        Ok(Contribution::counts(1))
    });
    let plan = plan(counts).unwrap();
    assert!(plan.slots.iter().all(|slot| slot.name != "visibility"), "{plan}");
    let draw = &plan.passes.iter().find(|pass| pass.name == "count").unwrap().draws[0];
    let shadowgraph::engine::plan::Geometry::IndexedProcedural { indices, .. } = draw.geometry else {
        panic!("{draw:?}")
    };
    assert!(matches!(plan.slot(indices).kind, SlotKind::Buffer { .. }), "{plan}");
    let Some((factor, _)) = factor(counts) else { return };
    assert!(factor.iter().all(|f| *f == 0.0), "everything counts");
}

/// A shader that cannot be composed was once an empty one, which drew nothing.
#[test]
fn a_shader_that_does_not_compose_is_an_error() {
    let error = plan(does!(|_, _| {
        Shader::written("lost", "#import nowhere\n", &[], "fullscreen_vertex", None)?;
        Ok(Contribution::default())
    }))
    .unwrap_err();
    assert!(matches!(error, ShadowError::Shader(_)), "{error}");
    assert!(error.to_string().contains("'lost'") && error.to_string().contains("'nowhere'"), "{error}");
}

/// What a technique returns and what its passes do must be the same.
#[test]
fn passes_that_do_what_nobody_said_are_refused() {
    let darkens = plan(does!(|_, out| {
        out.pass(Pass { colors: vec![ColorTarget::VISIBILITY], ..pass("dark", vec![]) });
        Ok(Contribution::default())
    }));
    assert!(darkens.unwrap_err().to_string().contains("no channels are stated"));
    let counts = plan(does!(|_, out| {
        out.pass(Pass { depth: Some(DepthTarget::COUNT), ..pass("count", vec![]) });
        Ok(Contribution::default())
    }));
    assert!(counts.unwrap_err().to_string().contains("no bound is stated"));
}

const MAPS: &str = "
#import common/fullscreen

@group(1) @binding(0) var maps: texture_depth_2d_array;
@group(1) @binding(1) var compare: sampler_comparison;

@vertex fn at_three_quarters(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.75, 1.0);
}

@fragment fn looked_up(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let uv = position.xy / vec2f(64.0, 48.0);
    let first = textureSampleCompareLevel(maps, compare, uv, 0, 0.5);
    let second = textureSampleCompareLevel(maps, compare, uv, 1, 0.5);
    return vec4f(second * (1.0 - first));
}
";

/// Depth of several layers, drawn one by one, of which one gets a triangle in a part of it; then compared.
fn map(out: &mut PassList<'_>, layer: u32, viewport_px: [u32; 4]) -> Result<Contribution, ShadowError> {
    let desc = TextureDesc::new("maps", TextureFormat::Depth32Float, [64, 48], "a test");
    let maps = out.texture(TextureDesc { layers: 2, ..desc });
    let shader = Shader::written("maps", MAPS, &[], "at_three_quarters", None)?;
    let mut state = DrawState::new(CompareFunction::Always, vec![]);
    (state.depth_write, state.viewport_px) = (true, Some(viewport_px));
    let near = Draw::new("near", Geometry::fullscreen(shader), state);
    let onto = |layer, far| Some(DepthTarget { layer, ..DepthTarget::new(maps, Access::Clear(far)) });
    out.pass(Pass { depth: onto(0, 0.25), ..pass("first map", vec![]) });
    out.pass(Pass { depth: onto(layer, 0.0), ..pass("second map", vec![near]) });
    let shader = Shader::written("maps", MAPS, &[], "fullscreen_vertex", Some("looked_up"))?;
    let compare = Binding::Comparison(CompareFunction::LessEqual);
    let bindings = vec![(0, Binding::TextureArray(maps)), (1, compare)];
    out.pass(over_visibility("look up", shader, Some(MULTIPLY), bindings));
    Ok(Contribution::visibility(Channels::One))
}

#[test]
fn maps_have_layers_viewports_and_comparisons() {
    let Some((factor, [width, _])) = factor(does!(|_, out| map(out, 1, [0, 0, 32, 48]))) else { return };
    let lit = |x: std::ops::Range<usize>| {
        let pixels = factor.iter().enumerate().filter(|(i, _)| x.contains(&(i % width)));
        pixels.map(|(_, f)| f64::from(*f)).sum::<f64>() / (x.len() * factor.len() / width) as f64
    };
    // Where the crate turns its sides away, it is dark by itself.
    assert!(lit(0..31) > 0.7 && lit(33..64) == 0.0, "{} left, {} right", lit(0..31), lit(33..64));
}

#[test]
fn layers_and_viewports_that_are_not_there_are_found() {
    let error = plan(does!(|_, out| map(out, 2, [0, 0, 32, 48]))).unwrap_err();
    assert!(matches!(error, ShadowError::Plan(PlanError::WrongKind { .. })), "{error}");
    let error = plan(does!(|_, out| map(out, 1, [40, 0, 32, 48]))).unwrap_err();
    assert!(matches!(error, ShadowError::Plan(PlanError::ViewportOutside { .. })), "{error}");
}

/// A device of the machine's adapter that was not given this feature.
fn renderer_without(missing: wgpu::Features) -> Option<Renderer> {
    let own = shadowgraph_testing::renderer()?.gpu().clone();
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let adapter = adapters.into_iter().find(|adapter| adapter.get_info().name == own.info.name).unwrap();
    let device = adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: own.features - missing,
        required_limits: adapter.limits(),
        ..Default::default()
    });
    let (device, queue) = pollster::block_on(device).unwrap();
    Some(Renderer::new(Gpu::from_device(device, queue), shadowgraph_nodes::catalog()))
}

/// A device is asked only for what the frame needs, and each node states its own needs.
#[test]
fn only_what_counts_needs_a_stencil() {
    let Some(mut renderer) = renderer_without(wgpu::Features::DEPTH32FLOAT_STENCIL8) else { return };
    let mut render = |node: Option<ShadowNode>| {
        let mut scene = shadowgraph_testing::yard();
        let floor = scene.find("floor").unwrap();
        if let Some(node) = node {
            scene.add_shadow("shadows", node.with_receivers([floor]));
        }
        renderer
            .render(&scene, &shadowgraph_testing::request(), &RenderOptions::default())
            .map(|frame| frame.plan)
    };
    let number = ParamValue::Number;
    for node in [
        None,
        Some(ShadowNode::new("ShadowVolumeSoft").with_param("radius", number(0.1))),
        Some(ShadowNode::new("SoftShadow")),
        Some(ShadowNode::new("ShadowVolumeHard").with_param("counter", ParamValue::Text("float".into()))),
    ] {
        let plan = render(node).unwrap();
        let needs = TextureFormat::Depth32FloatStencil8;
        let counts = |slot: &Slot| matches!(slot.kind, SlotKind::Texture { format, .. } if format == needs);
        assert!(!plan.slots.iter().any(counts), "{plan}");
    }
    for name in ["ShadowVolumeHard", "TransparentShadow"] {
        let error = render(Some(ShadowNode::new(name))).unwrap_err().to_string();
        assert!(error.contains(name) && error.contains("DEPTH32FLOAT_STENCIL8"), "{error}");
    }
    let point = ShadowNode::new("ShadowVolumeSoft").with_param("radius", number(0.0));
    let error = render(Some(point)).unwrap_err().to_string();
    assert!(error.contains("ShadowVolumeSoft") && error.contains("DEPTH32FLOAT_STENCIL8"), "{error}");
}
