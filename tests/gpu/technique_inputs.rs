//! What a technique may ask of the frame beside depth and stencil: the visible triangle of every pixel, its light's
//! number, and where the world lies.

use std::sync::Arc;

use glam::DVec4;
use shadowgraph::engine::plan::{BlendState, BufferDesc, Shader};
use shadowgraph::engine::shadow::{Binding, Channels, Contribution, TechniqueEntry, hash_of};
use shadowgraph::prelude::*;
use shadowgraph_testing::{Plain, catalog_with, over_visibility, renderer_with, technique};

const TEXT: &str = "
#import common/frame
#import common/fullscreen
#import common/lights

struct Asked {
    p_in_world: vec4f,
    light: u32,
    caster: u32,
}

@group(1) @binding(0) var<storage, read> asked: Asked;
@group(1) @binding(1) var visible: texture_2d<u32>;

@fragment
fn silhouette(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let p_in_view = frame.view_from_world * asked.p_in_world;
    let there = distance(p_in_view.xyz, lights[asked.light].position.xyz) < 1e-4;
    let seen = textureLoad(visible, vec2u(position.xy), 0).x;
    return vec4f(select(select(0.5, 1.0, there), 0.0, seen == asked.caster));
}
";

/// Darkens its own casters wherever they are seen, and everything else to 0.5 when the light is not where its number
/// says. No shadow at all; but everything in it must be right for its factor to be.
const SILHOUETTES: TechniqueEntry = technique!("Silhouettes", |_| Plain::new(|light, out| {
    let caster = light.casters().next().unwrap().0 as u32;
    let DVec4 { x, y, z, w } = light.light().position;
    let mut bytes = bytemuck::cast_slice::<f32, u8>(&[x, y, z, w].map(|v| v as f32)).to_vec();
    bytes.extend(bytemuck::cast_slice::<u32, u8>(&[light.light_index() as u32, caster, 0, 0]));
    let key = hash_of(&bytes);
    let asked = out.buffer(BufferDesc::storage("asked", key, Arc::new(bytes), "a test"));
    let shader = Shader::written("silhouettes", TEXT, &[], "fullscreen_vertex", Some("silhouette"))?;
    let bindings = vec![(0, Binding::Storage(asked)), (1, Binding::Texture(out.visible_triangles()))];
    let name = format!("silhouettes for {}", light.light().name);
    out.pass(over_visibility(&name, shader, Some(BlendState::REPLACE), bindings));
    Ok(Contribution::visibility(Channels::One))
}));

/// Two lamps, of which the second has the technique, and a sun.
fn scene() -> Scene {
    let mut scene = shadowgraph_testing::with_floor();
    let caster = shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(0.0, 0.5, 0.0));
    shadowgraph_testing::add_lamp(&mut scene, "other");
    let lamp = scene.add_light(Light::point("lamp", 30.0), DVec3::new(3.0, 6.0, -2.0), DVec3::ZERO);
    let mut node = ShadowNode::new("Silhouettes");
    node.lights = Scope::Nodes(vec![lamp]);
    node.casters = Scope::Nodes(vec![caster]);
    scene.add_shadow("silhouettes", node);
    scene
}

#[test]
fn triangles_light_and_world_are_where_they_are_said_to_be() {
    let Some(mut renderer) = renderer_with(&[SILHOUETTES]) else { return };
    for antialias in [Antialias::None, Antialias::Supersample4] {
        let request = FrameRequest { factors: true, antialias, ..shadowgraph_testing::request() };
        let frame = renderer.render(&scene(), &request, &RenderOptions::default()).unwrap();
        assert_eq!(frame.factors.len(), 1);
        let seen = frame.visible_triangles.unwrap();
        let factors = frame.factors[0].pixels.floats().unwrap();
        let (mut crates, mut floors) = (0, 0);
        for (id, factor) in seen.iter().zip(factors) {
            // Instance 0 is the floor, 1 the crate.
            match id[0] {
                0 => {
                    floors += 1;
                    assert!(factor == 1.0, "{factor}");
                }
                1 => {
                    crates += 1;
                    assert!(factor == 0.0, "{factor}");
                }
                _ => {}
            }
        }
        assert!(crates > 20 && floors > 200, "{crates} pixels of the crate, {floors} of the floor");
    }
}

#[test]
fn visible_triangles_are_in_the_plan_only_when_asked_for() {
    let plan = |scene: &Scene, request: &FrameRequest| {
        let adapter = shadowgraph::engine::render::Adapter::imagined();
        let cache = shadowgraph::engine::shadow::Cache::new();
        shadowgraph_testing::try_plan_with(scene, request, &catalog_with(&[SILHOUETTES]), &adapter, &cache)
    };
    let asked = plan(&scene(), &shadowgraph_testing::request()).unwrap();
    assert_eq!(asked.passes_named("visible triangles").count(), 1);
    // Nobody measures: nothing is read back.
    assert_eq!(asked.visible_triangles, None);
    let before = asked.passes.iter().position(|pass| pass.name == "visible triangles");
    let after = asked.passes.iter().position(|pass| pass.name == "silhouettes for lamp");
    assert!(before < after);
    // Measured and asked for: still once.
    let both = plan(&scene(), &FrameRequest { factors: true, ..shadowgraph_testing::request() }).unwrap();
    assert_eq!(both.passes_named("visible triangles").count(), 1);
    assert!(both.visible_triangles.is_some());
    let unasked = plan(&shadowgraph_testing::shadowed_yard(&[]), &shadowgraph_testing::request()).unwrap();
    assert_eq!(unasked.passes_named("visible triangles").count(), 0);
    let sampled = FrameRequest { antialias: Antialias::Multisample4, ..shadowgraph_testing::request() };
    assert!(plan(&scene(), &sampled).unwrap_err().to_string().contains("Silhouettes"));
}
