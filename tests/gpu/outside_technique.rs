//! A technique from outside the library: it plugs in beside the built-in ones, is judged by the same reference, and
//! shares lights with them.

mod rows;

use crate::own_technique::{DiscShadow, catalog, disc_mesh};
use shadowgraph::engine::math::Projection;
use shadowgraph::engine::plan::{FactorAt, FramePlan, SlotKind, TextureFormat};
use shadowgraph::engine::render::{Adapter, FrameError, plan_frame};
use shadowgraph::engine::scene::{NodeKey, ParamValue, placed};
use shadowgraph::engine::shadow::{Cache, OptionError, Registry, ShadowError};
use shadowgraph::measure::{ErrorTable, evaluate, expect_shadow};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [480, 300];
/// The declared known error, in numbers: how far from the shadow's boundary a pixel may be wrong, ...
const WRONG_WITHIN_PX: f64 = 1.0;
/// ... and for how much of the boundary: a pixel in a hundred, where rounding of the receiver moves it across.
const WRONG_SHARE_OF_BOUNDARY: f64 = 0.01;

/// A floor, a wall, two discs and a box, without lights or shadow nodes.
struct Stage {
    scene: Scene,
    discs: Vec<NodeKey>,
    boxes: Vec<NodeKey>,
}

fn add(scene: &mut Scene, data: MeshData, place: DAffine3) -> NodeKey {
    scene.add_mesh(Mesh::new(data).unwrap(), Material::default(), place)
}

fn tilted(at: DVec3, around_x_rad: f64, around_z_rad: f64) -> DAffine3 {
    placed(at, DQuat::from_rotation_z(around_z_rad) * DQuat::from_rotation_x(around_x_rad), DVec3::ONE)
}

fn stage() -> Stage {
    let mut scene = Scene::new();
    add(&mut scene, shapes::plane(Vec2::splat(12.0)).named("floor"), DAffine3::IDENTITY);
    let wall = shapes::cuboid(Vec3::new(-6.0, 0.0, -4.5), Vec3::new(6.0, 4.0, -4.0));
    add(&mut scene, wall.named("wall"), DAffine3::IDENTITY);
    let discs = vec![
        add(&mut scene, disc_mesh("plate", 0.9, 512), tilted(DVec3::new(-0.6, 1.4, 0.0), 0.5, 0.3)),
        add(&mut scene, disc_mesh("coin", 0.5, 512), tilted(DVec3::new(1.1, 0.5, 0.8), 1.4, -0.2)),
    ];
    let cuboid = shapes::cuboid(Vec3::new(0.2, 0.0, -0.9), Vec3::new(0.9, 1.9, -0.3));
    let boxes = vec![add(&mut scene, cuboid.named("box"), DAffine3::IDENTITY)];
    Stage { scene, discs, boxes }
}

fn lamp(scene: &mut Scene) -> NodeKey {
    scene.add_light(Light::point("lamp", 40.0), DVec3::new(-2.0, 4.5, 2.5), DVec3::ZERO)
}

fn eye(position: DVec3) -> CameraSnapshot {
    CameraSnapshot::looking(Camera::perspective("eye", 0.8), position, DVec3::new(0.0, 0.6, 0.0))
}

fn request() -> FrameRequest {
    FrameRequest::new(eye(DVec3::new(2.5, 3.0, 6.0)), SIZE_PX)
}

fn renderer() -> Option<Renderer> {
    Some(Renderer::new(shadowgraph_testing::renderer()?.gpu().clone(), catalog()))
}

/// The frame plan, without a device.
fn plan_of(scene: &Scene) -> Result<FramePlan, FrameError> {
    let snapshot = scene.snapshot().unwrap();
    let registry = Registry::collect(&snapshot, &catalog())?;
    plan_frame(&snapshot, &registry, &request(), &Adapter::imagined(), &Cache::new())
}

fn format_of(plan: &FramePlan, name: &str) -> Option<TextureFormat> {
    let slot = plan.slots.iter().find(|slot| slot.name == name)?;
    if let SlotKind::Texture { format, .. } = slot.kind { Some(format) } else { None }
}

/// Renders and returns the linear factor of each light, by name.
fn factors(renderer: &mut Renderer, scene: &Scene) -> Vec<(String, Vec<f32>)> {
    let request = FrameRequest { factors: true, ..request() };
    let frame = renderer.render(scene, &request, &RenderOptions::default()).unwrap();
    frame.factors.into_iter().map(|f| (f.light, f.pixels.floats().unwrap())).collect()
}

fn refusal(scene: &Scene) -> ShadowError {
    Registry::collect(&scene.snapshot().unwrap(), &catalog()).unwrap_err()
}

#[test]
fn wrong_pixels_are_only_those_its_known_error_declares() {
    let Some(mut renderer) = renderer() else { return };
    let lights = [
        Light::point("lamp", 40.0),
        Light::directional("sun", 3.0),
        Light::spot("spot", 60.0, 0.5).with_range(20.0),
    ];
    let flat = Projection::Orthographic { half_height_m: 2.5, near_m: 0.1, far_m: 40.0 };
    let mut eyes = vec![
        eye(DVec3::new(2.5, 3.0, 6.0)),
        // From below and behind, where the discs turn their dark sides to the eye; then low over the floor.
        eye(DVec3::new(-3.0, 0.5, -3.0)),
        eye(DVec3::new(0.5, 0.15, 5.0)),
    ];
    eyes.push(CameraSnapshot { projection: flat, ..eyes[0].clone() });
    for light in lights {
        let Stage { mut scene, discs, .. } = stage();
        scene.add_light(light.clone(), DVec3::new(-2.0, 4.5, 2.5), DVec3::ZERO);
        scene.add_shadow("discs", ShadowNode::from(DiscShadow::default()).with_casters(discs));
        for (index, camera) in eyes.iter().enumerate() {
            let request = FrameRequest::new(camera.clone(), SIZE_PX);
            let evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
            expect_shadow(&evaluation.errors).unwrap();
            let table = ErrorTable(&evaluation.errors);
            eprintln!("eye {index}\n{table}");
            let error = &evaluation.errors[0];
            assert!(error.boundary_distance_max_px <= WRONG_WITHIN_PX, "eye {index}\n{table}");
            let allowed = WRONG_SHARE_OF_BOUNDARY * error.boundary_pixels as f64;
            assert!(error.wrong as f64 <= allowed, "eye {index}\n{table}");
            // Nothing but 0 and 1 at a hard rim.
            assert!(evaluation.measured.lights[0].1.iter().all(|f| f.is_nan() || *f == 0.0 || *f == 1.0));
        }
    }
}

#[test]
fn a_disc_far_from_the_origin_neither_shadows_itself_nor_shifts() {
    let Some(mut renderer) = renderer() else { return };
    let far = DVec3::new(40_000.0, 800.0, -25_000.0);
    let mut scene = Scene::new();
    let floor = shapes::plane(Vec2::splat(12.0)).named("floor");
    add(&mut scene, floor, DAffine3::from_translation(far));
    let disc = add(&mut scene, disc_mesh("plate", 0.9, 512), tilted(far + DVec3::Y, 0.5, 0.3));
    scene.add_light(Light::point("lamp", 40.0), far + DVec3::new(-2.0, 4.5, 2.5), far);
    scene.add_shadow("discs", ShadowNode::from(DiscShadow::default()).with_casters([disc]));
    let camera = CameraSnapshot::looking(
        Camera::perspective("eye", 0.8),
        far + DVec3::new(2.5, 3.0, 6.0),
        far + DVec3::Y,
    );
    let request = FrameRequest::new(camera, SIZE_PX);
    let evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
    expect_shadow(&evaluation.errors).unwrap();
    let error = &evaluation.errors[0];
    assert!(error.boundary_distance_max_px <= WRONG_WITHIN_PX, "{}", ErrorTable(&evaluation.errors));
}

#[test]
fn alone_it_needs_a_visibility_target_and_no_stencil() {
    let Stage { mut scene, discs, .. } = stage();
    lamp(&mut scene);
    scene.add_shadow("discs", ShadowNode::from(DiscShadow::default()).with_casters(discs));
    let plan = plan_of(&scene).unwrap();
    assert_eq!(format_of(&plan, "visibility"), Some(TextureFormat::R16Float));
    assert_eq!(format_of(&plan, "depth"), Some(TextureFormat::Depth32Float));
    assert_eq!(format_of(&plan, "light mask"), None);
    assert_eq!(plan.lights[0].factor, FactorAt::Visibility(0));
    assert_eq!(plan.lights[0].techniques, ["DiscShadow"]);
    let passes: Vec<&str> = plan.passes.iter().map(|pass| pass.name.as_str()).collect();
    assert_eq!(passes, ["depth prepass", "discs of lamp", "shading"]);
    assert_eq!(plan.passes[1].draws.len(), 1, "one draw for all discs\n{plan}");
}

#[test]
fn what_no_disc_can_shadow_costs_nothing() {
    let mut scene = Scene::new();
    add(&mut scene, shapes::plane(Vec2::splat(12.0)).named("floor"), DAffine3::IDENTITY);
    // The lamp's light ends before it reaches the disc.
    let disc = add(&mut scene, disc_mesh("plate", 0.5, 64), DAffine3::from_translation(DVec3::Y * 12.0));
    let light = Light::point("lamp", 40.0).with_range(6.0);
    scene.add_light(light, DVec3::new(-2.0, 4.5, 2.5), DVec3::ZERO);
    scene.add_shadow("discs", ShadowNode::from(DiscShadow::default()).with_casters([disc]));
    let plan = plan_of(&scene).unwrap();
    assert_eq!(plan.lights[0].factor, FactorAt::Lit);
    assert_eq!(format_of(&plan, "visibility"), None);
    assert!(plan.notes.iter().any(|note| note.contains("'plate'")), "{plan}");
}

#[test]
fn with_volumes_on_one_light_the_factor_is_the_product() {
    let Some(mut renderer) = renderer() else { return };
    let with = |disc: bool, hard: bool| {
        let Stage { mut scene, discs, boxes } = stage();
        lamp(&mut scene);
        if disc {
            scene.add_shadow("discs", ShadowNode::from(DiscShadow { edge_m: 0.2 }).with_casters(discs));
        }
        if hard {
            let hard = ShadowNode::from(ShadowVolumeHard::default());
            scene.add_shadow("boxes", hard.with_casters(boxes));
        }
        scene
    };
    let [disc, hard, both] = [(true, false), (false, true), (true, true)]
        .map(|(d, h)| factors(&mut renderer, &with(d, h)).remove(0).1);
    let differing = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| a != b).count();
    let product: Vec<f32> = disc.iter().zip(&hard).map(|(d, h)| d * h).collect();
    assert_eq!(differing(&both, &product), 0);
    assert!(differing(&product, &disc) > 100 && differing(&product, &hard) > 100, "both must cast");
    let plan = plan_of(&with(true, true)).unwrap();
    assert_eq!(plan.lights[0].factor, FactorAt::Visibility(0));
    assert_eq!(plan.lights[0].techniques, ["DiscShadow edge=0.2", "ShadowVolumeHard"]);
}

/// A known bug of the engine, runnable: shading takes the three colours of a one-channel visibility texture, which reads
/// as (factor, 0, 0), so that everything a light with such a factor lights turns red.
#[test]
fn one_factor_for_all_colours_leaves_white_light_white() {
    let Some(mut renderer) = renderer() else { return };
    let Stage { mut scene, discs, .. } = stage();
    scene.set_ambient(Vec3::ZERO);
    lamp(&mut scene);
    scene.add_shadow("discs", ShadowNode::from(DiscShadow::default()).with_casters(discs));
    let request = FrameRequest { picture: PictureFormat::LinearF32, ..request() };
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    let picture = renderer.render(&scene, &request, &options).unwrap().picture.unwrap().floats().unwrap();
    // Everything here is grey under white light; the background is not.
    let lit = picture.chunks_exact(4).filter(|texel| texel[0] > 0.1);
    let coloured = lit.clone().filter(|texel| (texel[0] - texel[2]).abs() > 1e-3 * texel[0]).count();
    assert!(lit.count() > 1000 && coloured == 0, "{coloured} pixels are coloured");
}

#[test]
fn shared_and_unshared_lights_of_one_frame_stay_apart() {
    let Some(mut renderer) = renderer() else { return };
    let Stage { mut scene, discs, boxes } = stage();
    let lamp = lamp(&mut scene);
    let sun = scene.add_light(Light::directional("sun", 2.0), DVec3::new(3.0, 5.0, 1.0), DVec3::ZERO);
    let side = scene.add_light(Light::point("side", 20.0), DVec3::new(4.0, 2.5, 0.0), DVec3::ZERO);
    let back = scene.add_light(Light::point("back", 20.0), DVec3::new(-1.0, 3.0, -3.0), DVec3::ZERO);
    let disc = ShadowNode::from(DiscShadow::default()).with_casters(discs);
    scene.add_shadow("discs", disc.with_lights([lamp, sun]));
    let hard = ShadowNode::from(ShadowVolumeHard::default()).with_casters(boxes);
    scene.add_shadow("boxes", hard.with_lights([lamp, sun, side, back]));
    let plan = plan_of(&scene).unwrap();
    let places: Vec<FactorAt> = plan.lights.iter().map(|light| light.factor).collect();
    assert_eq!(
        places,
        [FactorAt::Visibility(0), FactorAt::Visibility(1), FactorAt::MaskBit(0), FactorAt::MaskBit(1)]
    );
    let evaluation = evaluate(&mut renderer, &scene, &request(), &|_, _| {}).unwrap();
    expect_shadow(&evaluation.errors).unwrap();
    let table = ErrorTable(&evaluation.errors);
    eprintln!("{table}");
    for error in &evaluation.errors {
        assert!(error.boundary_distance_max_px <= WRONG_WITHIN_PX, "{table}");
    }
    // Lights without discs are as exact as ever.
    assert!(evaluation.errors[2..].iter().all(|error| error.passes()), "{table}");
}

#[test]
fn a_smooth_rim_fades_about_the_hard_one() {
    let Some(mut renderer) = renderer() else { return };
    let mut with_edge = |edge_m: f64| {
        let Stage { mut scene, discs, .. } = stage();
        lamp(&mut scene);
        scene.add_shadow("discs", ShadowNode::from(DiscShadow { edge_m }).with_casters(discs));
        factors(&mut renderer, &scene).remove(0).1
    };
    let (hard, soft) = (with_edge(0.0), with_edge(0.1));
    let between = soft.iter().filter(|factor| **factor > 0.0 && **factor < 1.0).count();
    assert!(between > 200, "only {between} pixels between dark and lit");
    // Half of the rim is gained where the hard shadow is lit, half lost where it is dark; elsewhere nothing changes.
    assert!(hard.iter().zip(&soft).all(|(hard, soft)| (hard - soft).abs() <= 0.5 + 1e-3));
}

#[test]
fn options_it_does_not_have_are_named_with_those_it_has() {
    let node = |name: &str, value: ParamValue| {
        let Stage { mut scene, discs, .. } = stage();
        lamp(&mut scene);
        scene.add_shadow("discs", ShadowNode::new("DiscShadow").with_param(name, value).with_casters(discs));
        refusal(&scene)
    };
    let unknown = node("radius", ParamValue::Number(1.0));
    assert!(
        matches!(&unknown, ShadowError::Option { node, source: OptionError::Unknown { .. } } if node == "discs")
    );
    assert!(unknown.to_string().contains("no option 'radius' (it has: edge)"), "{unknown}");
    let negative = node("edge", ParamValue::Number(-0.1)).to_string();
    assert!(negative.contains("option 'edge' is -0.1, accepted: a number from 0"), "{negative}");
    assert!(node("edge", ParamValue::Number(f64::NAN)).to_string().contains("accepted"));
}

#[test]
fn the_library_alone_does_not_know_it() {
    let Stage { mut scene, .. } = stage();
    scene.add_shadow("discs", DiscShadow::default());
    let error = Registry::collect(&scene.snapshot().unwrap(), &shadowgraph_nodes::catalog()).unwrap_err();
    assert!(matches!(error, ShadowError::UnknownTechnique { technique, .. } if technique == "DiscShadow"));
}

#[test]
fn what_is_no_disc_is_refused_by_name_and_with_the_reason() {
    let disc = || disc_mesh("thing", 1.0, 64);
    let mut dented = disc();
    dented.positions[5].y += 0.01;
    let mut oval = disc();
    oval.positions.iter_mut().for_each(|p| p.x *= 1.2);
    let half = disc().without_triangles(|triangle| triangle >= 32);
    let mut arc = disc();
    arc.positions.truncate(34);
    arc.indices.retain(|index| *index < 34);
    arc.indices.truncate(arc.indices.len() / 3 * 3);
    arc.normals.truncate(34);
    let ring = {
        let inner = disc_mesh("thing", 0.5, 64);
        MeshData::merged("thing", [disc(), inner])
    };
    let stretched = placed(DVec3::ZERO, DQuat::IDENTITY, DVec3::new(1.0, 1.0, 2.0));
    let flattened = placed(DVec3::ZERO, DQuat::IDENTITY, DVec3::new(1.0, 1.0, 0.0));
    let moved = DAffine3::from_translation(DVec3::Y);
    let refused = [
        (shapes::cuboid(Vec3::ZERO, Vec3::ONE), moved, "off the plane"),
        (shapes::uv_sphere(1.0, 32, 16), moved, "off the plane"),
        (dented, moved, "off the plane"),
        (oval, moved, "neither 0 nor the radius"),
        (ring, moved, "neither 0 nor the radius"),
        (half, moved, "cover 50.0 %"),
        (arc, moved, "leaves out"),
        (disc_mesh("thing", 1.0, 12), moved, "leaves out 30.0 degrees"),
        (shapes::plane(Vec2::ONE), moved, "leaves out 90.0 degrees"),
        (disc(), stretched, "neither 0 nor the radius"),
        (disc(), flattened, "no area"),
    ];
    for (data, place, reason) in refused {
        let mut scene = Scene::new();
        add(&mut scene, data.named("thing"), place);
        lamp(&mut scene);
        scene.add_shadow("discs", DiscShadow::default());
        match refusal(&scene) {
            ShadowError::CasterRefused { node, technique: "DiscShadow", caster, reason: given } => {
                assert_eq!((node.as_str(), caster.as_str()), ("discs", "thing"));
                assert!(given.contains(reason), "'{given}' does not say '{reason}'");
            }
            other => panic!("not the refusal of a caster: {other}"),
        }
    }
}

#[test]
fn turned_scaled_and_mirrored_discs_are_discs() {
    for scale in [DVec3::splat(3.0), DVec3::new(-0.5, 0.5, 0.5), DVec3::new(2.0, 7.0, 2.0)] {
        let mut scene = Scene::new();
        let place = placed(DVec3::new(1.0, 2.0, 3.0), DQuat::from_rotation_x(1.0), scale);
        add(&mut scene, disc_mesh("disc", 0.3, 24), place);
        lamp(&mut scene);
        scene.add_shadow("discs", DiscShadow::default());
        let registry = Registry::collect(&scene.snapshot().unwrap(), &catalog()).unwrap();
        assert_eq!(registry.lights[0][0].casters, [0]);
    }
}

#[test]
fn nothing_moved_nothing_is_uploaded_again() {
    let Some(mut renderer) = renderer() else { return };
    let Stage { mut scene, discs, .. } = stage();
    lamp(&mut scene);
    scene.add_shadow("discs", ShadowNode::from(DiscShadow::default()).with_casters(discs));
    renderer.render(&scene, &request(), &RenderOptions::default()).unwrap();
    let before = renderer.work_done();
    renderer.render(&scene, &request(), &RenderOptions::default()).unwrap();
    assert_eq!(renderer.work_done(), before);
}

#[test]
fn its_shader_is_valid_and_laid_out_as_its_records_are() {
    use wgpu::naga::{TypeInner, front::wgsl, valid};
    let text = shadowgraph::shaders::compose("DiscShadow", crate::own_technique::SHADER, &[]).unwrap();
    let module = wgsl::parse_str(&text).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&text)));
    valid::Validator::new(valid::ValidationFlags::all(), valid::Capabilities::empty())
        .validate(&module)
        .unwrap();
    let layout = |name: &str| {
        let (_, found) = module.types.iter().find(|(_, t)| t.name.as_deref() == Some(name)).unwrap();
        let TypeInner::Struct { members, span } = &found.inner else { panic!("{name} is no struct") };
        let fields = members.iter().map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize));
        (fields.collect::<Vec<_>>(), *span as usize)
    };
    for (name, (fields, size)) in crate::own_technique::layouts() {
        let (in_shader, span) = layout(name);
        let fields: Vec<(String, usize)> = fields.iter().map(|(n, at)| ((*n).to_owned(), *at)).collect();
        assert_eq!((in_shader, span), (fields, size), "{name}");
    }
}
