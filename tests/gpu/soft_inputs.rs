//! What techniques for lights with a size may ask of the frame: the normal of every pixel's surface, and that the
//! engine leaves the receiver's own shadow to them.

use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use shadowgraph::engine::plan::{BufferDesc, MULTIPLY, Shader, SlotKind};
use shadowgraph::engine::scene::{NodeKey, ShadowFlags};
use shadowgraph::engine::shadow::{Binding, Channels, Contribution, TechniqueEntry, hash_of};
use shadowgraph::prelude::*;
use shadowgraph_testing::{Plain, catalog_with, over_visibility, renderer_with, technique};

const TEXT: &str = "
#import common/frame
#import common/fullscreen
#import common/lights
#import common/receiver_depth

@group(1) @binding(0) var<storage, read> light: array<u32>;
@group(1) @binding(1) var planes: texture_2d<u32>;

@fragment
fn facing(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let plane = unpacked_plane(textureLoad(planes, vec2u(position.xy), 0));
    let towards = lights[light[0]].position.xyz;
    return vec4f(select(0.25, 0.5 + 0.5 * dot(plane.normal, towards), plane.far_m > 0.0));
}
";

/// Leaves (1 + n·l)/2 in the visibility, for the direction l towards its light, and 0.25 where nothing receives. It decides
/// itself what is turned away, or leaves that to the engine.
fn facing(own_shadow: bool) -> Plain {
    Plain::new(move |light, out| {
        let bytes = bytemuck::cast_slice::<u32, u8>(&[light.light_index() as u32; 4]).to_vec();
        let key = hash_of(&bytes);
        let number = out.buffer(BufferDesc::storage("number", key, Arc::new(bytes), "a test"));
        let planes = out.receiver_planes();
        let shader = Shader::written("facing", TEXT, &[], "fullscreen_vertex", Some("facing"))?;
        let bindings = vec![(0, Binding::Storage(number)), (1, Binding::Texture(planes))];
        out.pass(over_visibility("facing", shader, Some(MULTIPLY), bindings));
        Ok(Contribution { own_shadow, ..Contribution::visibility(Channels::One) })
    })
}

const FACING: [TechniqueEntry; 2] =
    [technique!("Facing", |_| facing(true)), technique!("FacingUndecided", |_| facing(false))];

/// A floor, and boxes of all sizes and turns: one mirrored, one stretched, one of a tenth of a millimetre seen near.
fn yard() -> Scene {
    let mut scene = shadowgraph_testing::with_floor();
    let turn = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 0.9, -0.3);
    let mut add = |name: &str, scale: DVec3, place: DVec3| -> NodeKey {
        shadowgraph_testing::add_box(
            &mut scene,
            name,
            DAffine3::from_scale_rotation_translation(scale, turn, place),
        )
    };
    add("even", DVec3::ONE, DVec3::new(0.0, 1.0, 0.0));
    add("mirrored", DVec3::new(-1.0, 1.0, 1.0), DVec3::new(2.0, 1.0, 0.0));
    add("stretched", DVec3::new(0.02, 3.0, 0.5), DVec3::new(-2.0, 1.0, 0.0));
    add("huge", DVec3::splat(4000.0), DVec3::new(-6000.0, 1.0, -9000.0));
    add("tiny", DVec3::splat(1e-2), DVec3::new(5.97, 4.98, 7.95));
    let deaf = add("deaf", DVec3::ONE, DVec3::new(0.0, 1.0, 3.0));
    if let Content::Mesh(mesh) = &mut scene.node_mut(deaf).unwrap().content {
        mesh.shadow = ShadowFlags { receives: false, casts: true };
    }
    scene
}

fn served(mut scene: Scene, technique: &str) -> Scene {
    scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(1.0, -1.0, 0.5));
    scene.add_shadow("facing", ShadowNode::new(technique));
    scene
}

/// What a frame's factor is at every pixel, beside (1 + n·l)/2 there in f64 and whether the surface is turned away.
fn factors(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<(f32, f64, bool)> {
    let request = FrameRequest { factors: true, ..request.clone() };
    let frame = renderer.render(scene, &request, &RenderOptions::default()).unwrap();
    let (snapshot, _) = renderer.snapshot(scene).unwrap();
    let towards = snapshot.lights[0].position.truncate().normalize();
    let eye = request.camera.world_from_view.translation;
    let seen = frame.visible_triangles.unwrap();
    let factors = frame.factors[0].pixels.floats().unwrap();
    let pixels = seen.iter().zip(factors).filter(|(id, _)| id[0] != u32::MAX);
    pixels
        .map(|(id, factor)| {
            let instance = &snapshot.instances[id[0] as usize];
            let [a, b, c] = instance.mesh.triangle(id[1] as usize).map(|v| instance.world_position(v));
            let normal = (b - a).cross(c - a).normalize();
            let normal = if normal.dot(eye - a) < 0.0 { -normal } else { normal };
            let cosine = normal.dot(towards);
            let expected = if instance.shadow.receives { 0.5 + 0.5 * cosine } else { 1.0 };
            (factor, expected, cosine < 0.0)
        })
        .collect()
}

#[test]
fn normals_are_those_of_triangles_and_turned_surfaces_keep_what_the_technique_says() {
    let Some(mut renderer) = renderer_with(&FACING) else { return };
    for antialias in [Antialias::None, Antialias::Supersample4] {
        let request = FrameRequest { antialias, ..shadowgraph_testing::request() };
        let pixels = factors(&mut renderer, &served(yard(), "Facing"), &request);
        for (factor, expected, _) in &pixels {
            assert!((f64::from(*factor) - expected).abs() < 6e-4, "{factor} instead of {expected}");
        }
        assert!(pixels.iter().filter(|(.., turned)| *turned).count() > 20);
        // Left to the engine, what is turned away is dark.
        let pixels = factors(&mut renderer, &served(yard(), "FacingUndecided"), &request);
        for (factor, expected, turned) in &pixels {
            let expected = if *turned && *expected != 1.0 { 0.0 } else { *expected };
            assert!((f64::from(*factor) - expected).abs() < 6e-4, "{factor} instead of {expected}");
        }
    }
}

#[test]
fn normals_are_in_the_plan_only_when_asked_for() {
    let plan = |scene: &Scene, request: &FrameRequest| {
        let adapter = shadowgraph::engine::render::Adapter::imagined();
        let cache = shadowgraph::engine::shadow::Cache::new();
        shadowgraph_testing::try_plan_with(scene, request, &catalog_with(&FACING), &adapter, &cache)
    };
    let has = |plan: &shadowgraph::engine::plan::FramePlan, name: &str| {
        plan.slots.iter().any(|slot| slot.name == name)
    };
    let asked = plan(&served(yard(), "Facing"), &shadowgraph_testing::request()).unwrap();
    assert_eq!(asked.passes_named("receiver planes").count(), 1);
    assert!(!has(&asked, "visible triangles") && asked.visible_triangles.is_none());
    assert!(asked.to_string().contains("own shadows in its factor"));
    // Measured too: one pass for both.
    let both =
        plan(&served(yard(), "Facing"), &FrameRequest { factors: true, ..shadowgraph_testing::request() })
            .unwrap();
    assert_eq!(both.passes_named("receiver planes").count(), 0);
    assert_eq!(both.passes_named("visible triangles and receiver planes").count(), 1);
    assert!(
        !both
            .slots
            .iter()
            .any(|slot| matches!(slot.kind, SlotKind::Buffer { .. }) && slot.name.contains("turned"))
    );
    let unasked = plan(&shadowgraph_testing::shadowed_yard(&[]), &shadowgraph_testing::request()).unwrap();
    assert!(!has(&unasked, "receiver planes"));
    let sampled = FrameRequest { antialias: Antialias::Multisample4, ..shadowgraph_testing::request() };
    let refused = plan(&served(yard(), "Facing"), &sampled).unwrap_err().to_string();
    assert!(refused.contains("Facing") && refused.contains("msaa4"), "{refused}");
}

#[test]
fn beside_a_hard_technique_the_horizon_is_still_in_one_factor() {
    let Some(mut renderer) = renderer_with(&FACING) else { return };
    let mut scene = yard();
    scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(1.0, -1.0, 0.5));
    let all: Vec<NodeKey> = ["even", "mirrored", "stretched", "huge", "tiny", "deaf"]
        .map(|name| scene.find(name).unwrap())
        .to_vec();
    let mut hard = shadowgraph_testing::hard(&[]);
    hard.casters = Scope::Nodes(all[..1].to_vec());
    scene.add_shadow("hard", hard);
    let mut facing = ShadowNode::new("Facing");
    facing.casters = Scope::Nodes(all[1..].to_vec());
    scene.add_shadow("facing", facing);
    let pixels = factors(&mut renderer, &scene, &shadowgraph_testing::request());
    let (mut shadowed, mut kept) = (0, 0);
    for (factor, expected, turned) in pixels {
        let fits = (f64::from(factor) - expected).abs() < 6e-4;
        assert!(fits || factor == 0.0, "{factor} is neither {expected} nor in the hard shadow");
        shadowed += u32::from(!fits);
        kept += u32::from(fits && turned && expected != 1.0);
    }
    assert!(shadowed > 20 && kept > 20, "{shadowed} in the hard shadow, {kept} turned away and not dark");
}

#[test]
fn pictures_of_turned_surfaces_are_as_dark_as_the_technique_says() {
    let Some(mut renderer) = renderer_with(&FACING) else { return };
    // A slope that lies just past the sun's horizon, with normals that still face the sun.
    let mut scene = Scene::new();
    scene.set_ambient(Vec3::ZERO);
    scene.set_background(Vec3::ZERO);
    let positions = [[-9.0, -9.0], [-9.0, 9.0], [9.0, 9.0], [9.0, -9.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    let data = MeshData {
        name: "slope".into(),
        positions: positions.to_vec(),
        normals: vec![Vec3::new(-0.3, 1.0, 0.0).normalize(); 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Default::default()
    };
    scene.add_mesh(Mesh::new(data).unwrap(), Material::default(), DAffine3::IDENTITY);
    scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(1.0, 0.05, 0.0));
    let mut brightest = |technique: &str| {
        let mut scene = scene.clone();
        scene.add_shadow("facing", ShadowNode::new(technique));
        let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
        let frame = renderer.render(&scene, &shadowgraph_testing::request(), &options).unwrap();
        let bytes = frame.picture.unwrap().bytes;
        bytes.chunks_exact(4).map(|pixel| pixel[0]).max().unwrap()
    };
    assert_eq!(brightest("FacingUndecided"), 0);
    assert!(brightest("Facing") > 20);
}
