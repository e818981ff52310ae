//! `SoftShadow` on a GPU: exact for lights without a size, converging for those with one, kept in textures, crisp from
//! nearby. That it is exact on every hard case's planes is also what `conformance` asks; here it is asked without a
//! size.

use shadowgraph::cases::{self, Case};
use shadowgraph::engine::render::Frame;
use shadowgraph::engine::scene::{NodeKey, ParamValue};
use shadowgraph::engine::shadow::Options;
use shadowgraph::measure::{
    ErrorTable, EvaluateError, Evaluation, KnownReferences, LightError, evaluate, evaluate_again,
};
use shadowgraph::prelude::*;
use shadowgraph_testing::renderer;

/// Whether a case is about a light with a size.
fn is_soft(case: &Case) -> bool {
    let size = |name: &str| case.options.get(name).is_some_and(|value| *value != ParamValue::Number(0.0));
    size("radius") || size("angle")
}

/// Every case whose name contains one of `names`.
fn all_cases(names: &[&str]) -> impl Iterator<Item = Case> {
    let all = cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST));
    all.filter(|case| names.iter().any(|name| case.name().contains(name)))
}

fn failures(name: &str, errors: &[LightError]) -> Option<String> {
    let failed: Vec<LightError> =
        errors.iter().filter(|error| error.compared > 0 && !error.passes()).cloned().collect();
    (!failed.is_empty()).then(|| format!("{name}\n{}", ErrorTable(&failed)))
}

#[test]
fn without_a_size_shadows_are_exact_on_planes() {
    let Some(mut renderer) = renderer() else { return };
    let filter = std::env::var("CASE").unwrap_or_default();
    let (mut shadows, mut wrong) = (0, Vec::new());
    for case in all_cases(&[&filter]).filter(|case| !is_soft(case)) {
        let size = SoftShadow { radius_m: 0.0, angle_deg: 0.0, ..SoftShadow::DIRECT }.to_params();
        let scene = case.scene_with(&SoftShadow::ENTRY, &size).unwrap();
        match evaluate(&mut renderer, &scene, &case.request(), &|_, _| {}) {
            Ok(Evaluation { errors, .. }) => {
                shadows += usize::from(errors.iter().any(|error| error.measured_shadow_pixels > 0));
                wrong.extend(failures(&case.name(), &errors));
            }
            // Four samples a pixel, or no plane to receive.
            Err(EvaluateError::Render(RenderError::Frame(_) | RenderError::Shadow(_))) => {}
            Err(error) => panic!("{}: {error}", case.name()),
        }
    }
    println!("{shadows} with shadows");
    assert!(!filter.is_empty() || shadows >= 220, "{shadows}");
    assert!(wrong.is_empty(), "{} fail:\n{}", wrong.len(), wrong.join("\n"));
}

/// The penumbra's RMSE with so many points, beside the whole light.
fn curve(renderer: &mut Renderer, case: &Case, counts: &[u32]) -> Vec<f64> {
    let mut references = KnownReferences::with_samples(1024);
    let error = |count: &u32| {
        let options = SoftShadow { samples: *count, ..SoftShadow::DIRECT }.to_params();
        let scene = case.scene_with(&SoftShadow::ENTRY, &options).unwrap();
        let judged = evaluate_again(renderer, &scene, &case.request(), &mut references, &|_, _| {}).unwrap();
        judged.errors[0].penumbra_rmse
    };
    counts.iter().map(error).collect()
}

#[test]
fn factors_converge_to_the_whole_lights() {
    let Some(mut renderer) = renderer() else { return };
    let names = [
        "edge-at-centre/upright",
        "edge-through-centre/sun",
        "tripod",
        "penumbra-overlap/slit",
        "penumbra-width/high",
    ];
    for case in all_cases(&names) {
        let errors = curve(&mut renderer, &case, &[4, 16, 64, 256, 1024]);
        println!("{:30} {errors:.4?}", case.name());
        // About N^-0.75; the reference's own samples leave 0.003.
        for (error, bound) in errors.iter().zip([0.15, 0.07, 0.02, 0.008, 0.005]) {
            assert!(error < &bound, "{}: {errors:.4?}", case.name());
        }
    }
}

/// A floor, a crate above it, a lamp, and a node; and what may move.
struct Yard {
    scene: Scene,
    floor: NodeKey,
    body: NodeKey,
    lamp: NodeKey,
}

impl Yard {
    fn new(node: SoftShadow) -> Self {
        let mut yard = Self::unshadowed();
        yard.shadow(node, &[yard.floor]);
        yard
    }

    fn unshadowed() -> Self {
        let mut scene = shadowgraph_testing::with_floor();
        let body = shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(0.0, 1.5, 0.0));
        let lamp = shadowgraph_testing::add_lamp(&mut scene, "lamp");
        let floor = scene.nodes().find(|(_, node)| node.name == "floor").unwrap().0;
        Self { scene, floor, body, lamp }
    }

    fn shadow(&mut self, node: SoftShadow, receivers: &[NodeKey]) {
        self.scene.add_shadow("shadows", ShadowNode::from(node).with_receivers(receivers.iter().copied()));
    }

    fn shift(&mut self, node: NodeKey) {
        self.scene.node_mut(node).unwrap().parent_from_local.translation += DVec3::new(0.25, 0.5, 0.125);
    }
}

const TEXTURE: SoftShadow = SoftShadow {
    samples: 16,
    radius_m: 0.2,
    angle_deg: 0.27,
    mode: PlanarMode::Texture,
    resolution: 512,
    weight: 1.0,
    color: [0.0; 3],
};

/// [`TEXTURE`] in this mode; drawn directly, it has no texels.
fn in_mode(mode: PlanarMode) -> SoftShadow {
    let resolution = match mode {
        PlanarMode::Direct => SoftShadow::default().resolution,
        PlanarMode::Texture => TEXTURE.resolution,
    };
    SoftShadow { mode, resolution, ..TEXTURE }
}

#[test]
fn a_texture_is_drawn_again_only_when_something_moved() {
    let Some(mut renderer) = renderer() else { return };
    let mut yard = Yard::new(TEXTURE);
    let mut draw = |scene: &Scene, eye: DVec3| -> (usize, Frame) {
        let request = FrameRequest {
            factors: true,
            ..FrameRequest::new(shadowgraph_testing::camera(eye, DVec3::ZERO), [160, 120])
        };
        let frame = renderer.render(scene, &request, &RenderOptions::default()).unwrap();
        let kept = ["shadows on floor", "texture of floor", "texels of floor"];
        let drawn =
            frame.plan.passes.iter().filter(|pass| kept.iter().any(|name| pass.name.starts_with(name)));
        (drawn.count() - frame.kept.len(), frame)
    };
    let (here, there) = (DVec3::new(3.0, 5.0, 6.0), DVec3::new(-4.0, 3.0, 5.0));
    assert_eq!(draw(&yard.scene, here).0, 3);
    assert_eq!(draw(&yard.scene, here).0, 0);
    assert_eq!(draw(&yard.scene, there).0, 0, "the camera is nothing that moves");
    for moved in [yard.lamp, yard.body, yard.floor] {
        yard.shift(moved);
        assert_eq!(draw(&yard.scene, here).0, 3);
        assert_eq!(draw(&yard.scene, here).0, 0);
    }
    // What is kept is what would be drawn.
    let (_, kept) = draw(&yard.scene, there);
    let mut fresh = Renderer::new(renderer.gpu().clone(), shadowgraph_nodes::catalog());
    let request = FrameRequest {
        factors: true,
        ..FrameRequest::new(shadowgraph_testing::camera(there, DVec3::ZERO), [160, 120])
    };
    let drawn = fresh.render(&yard.scene, &request, &RenderOptions::default()).unwrap();
    assert!(drawn.kept.is_empty());
    assert_eq!(kept.factors[0].pixels.bytes, drawn.factors[0].pixels.bytes);
}

#[test]
fn direct_shadows_are_crisp_from_nearby_and_textures_err_by_less_than_a_texel() {
    let Some(mut renderer) = renderer() else { return };
    // The edge of the crate's shadow, ever larger.
    for height_m in [4.0, 0.4, 0.04, 0.004] {
        let edge = DVec3::new(0.75, 0.0, 0.0);
        let camera =
            shadowgraph_testing::camera(edge + DVec3::new(0.1, 1.0, 0.3).normalize() * height_m, edge);
        let request = FrameRequest::new(camera, [128, 128]);
        for mode in [PlanarMode::Direct, PlanarMode::Texture] {
            let mut yard = Yard::new(SoftShadow { radius_m: 0.0, ..in_mode(mode) });
            if let Content::Mesh(mesh) = &mut yard.scene.node_mut(yard.body).unwrap().content {
                mesh.shadow.receives = false;
            }
            // As near as that, the camera's near plane would cut the floor off.
            let mut request = request.clone();
            if let shadowgraph::engine::math::Projection::Perspective { near_m, .. } =
                &mut request.camera.projection
            {
                *near_m = 1e-4;
            }
            let judged = evaluate(&mut renderer, &yard.scene, &request, &|_, _| {}).unwrap();
            let error = &judged.errors[0];
            let pixel_m = height_m * 0.8 / 128.0;
            println!(
                "{mode:?} {height_m} m: {} wrong, {:.1} px off",
                error.leak_outside_band + error.false_outside_band,
                error.boundary_distance_max_px
            );
            if mode == PlanarMode::Direct {
                assert!(error.passes(), "{height_m} m:\n{}", ErrorTable(&judged.errors));
            } else {
                // The shadow's side is 1.2 m and a margin, on 512 texels.
                let texel_m = 1.25 / 512.0;
                let bound_px = texel_m * std::f64::consts::FRAC_1_SQRT_2 / pixel_m + 2.0;
                assert!(error.boundary_distance_max_px < bound_px, "{height_m} m: {bound_px}");
            }
        }
    }
}

#[test]
fn several_nodes_lights_and_receivers_multiply() {
    let Some(mut renderer) = renderer() else { return };
    let build = |lamps: &[usize], nodes: &[usize]| {
        let mut scene = shadowgraph_testing::with_floor();
        let floor = scene.nodes().next().unwrap().0;
        let wall = scene.add_mesh(
            shadowgraph_testing::quad("wall", 3.0),
            Material::default(),
            DAffine3::from_rotation_translation(DQuat::from_rotation_x(1.3), DVec3::new(0.0, 2.0, -3.0)),
        );
        let bodies = [0, 1].map(|i| {
            let place = shadowgraph_testing::at(f64::from(i) * 0.7 - 0.3, 1.0 + f64::from(i), 0.0);
            shadowgraph_testing::add_box(&mut scene, &format!("box {i}"), place)
        });
        for lamp in lamps {
            let light = Light::point(&format!("lamp {lamp}"), 60.0);
            scene.add_light(light, DVec3::new(*lamp as f64 * 2.0 - 1.0, 5.0, 2.0), DVec3::ZERO);
        }
        for node in nodes {
            let soft = ShadowNode::from(SoftShadow { radius_m: 0.3, ..SoftShadow::DIRECT });
            scene.add_shadow("shadows", soft.with_casters([bodies[*node]]).with_receivers([floor, wall]));
        }
        scene
    };
    let request = FrameRequest {
        factors: true,
        ..FrameRequest::new(
            shadowgraph_testing::camera(DVec3::new(2.0, 4.0, 7.0), DVec3::new(0.0, 0.5, -0.5)),
            [160, 120],
        )
    };
    let mut factors = |lamps: &[usize], nodes: &[usize]| {
        let frame = renderer.render(&build(lamps, nodes), &request, &RenderOptions::default()).unwrap();
        frame.factors.iter().map(|image| image.pixels.floats().unwrap()).collect::<Vec<_>>()
    };
    let both = factors(&[0, 1], &[0, 1]);
    for lamp in [0, 1] {
        let first = &factors(&[lamp], &[0])[0];
        let second = &factors(&[lamp], &[1])[0];
        let product = first.iter().zip(second).map(|(a, b)| a * b);
        let apart = both[lamp].iter().zip(product).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 2e-3, "lamp {lamp}: {apart}");
        assert!(first.iter().any(|f| *f < 0.5) && second.iter().any(|f| *f < 0.5));
        assert_ne!(first, second);
    }
    assert_ne!(both[0], both[1]);
}

/// A light that the receiver's plane cuts: what is under the horizon is dark, though the centre is above or below it.
#[test]
fn the_horizon_cuts_the_light() {
    let Some(mut renderer) = renderer() else { return };
    for height_m in [0.1, -0.1] {
        let mut scene = shadowgraph_testing::with_floor();
        shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(2.0, 0.6, 0.0));
        let floor = scene.nodes().next().unwrap().0;
        scene.add_light(Light::point("lamp", 100.0), DVec3::new(-1.0, height_m, 0.0), DVec3::ZERO);
        let node = SoftShadow { radius_m: 0.3, samples: 256, ..SoftShadow::DIRECT };
        scene.add_shadow("shadows", ShadowNode::from(node).with_receivers([floor]));
        let request =
            FrameRequest::new(shadowgraph_testing::camera(DVec3::new(2.0, 4.0, 6.0), DVec3::ZERO), [96, 72]);
        let mut references = KnownReferences::with_samples(1024);
        let judged = evaluate_again(&mut renderer, &scene, &request, &mut references, &|_, _| {}).unwrap();
        let error = &judged.errors[0];
        println!("{height_m}: {:.4}, {:.4}", error.penumbra_rmse, error.rmse);
        assert!(
            error.penumbra_pixels > 1000 && error.penumbra_rmse < 0.012,
            "{}",
            ErrorTable(&judged.errors)
        );
    }
}

#[test]
fn where_receivers_lie_on_each_other_a_pixel_is_darkened_once() {
    let Some(mut renderer) = renderer() else { return };
    let camera = shadowgraph_testing::camera(DVec3::new(3.0, 5.0, 6.0), DVec3::ZERO);
    let request = FrameRequest { factors: true, ..FrameRequest::new(camera, [160, 120]) };
    for mode in [PlanarMode::Direct, PlanarMode::Texture] {
        let mut draw = |floors: usize| {
            let mut yard = Yard::unshadowed();
            let mut receivers = vec![yard.floor];
            for _ in 1..floors {
                let again = yard.scene.add_mesh(
                    shadowgraph_testing::quad("floor again", 10.0),
                    Material::default(),
                    DAffine3::IDENTITY,
                );
                if let Content::Mesh(mesh) = &mut yard.scene.node_mut(again).unwrap().content {
                    mesh.shadow.casts = false;
                }
                receivers.push(again);
            }
            yard.shadow(in_mode(mode), &receivers);
            let frame = renderer.render(&yard.scene, &request, &RenderOptions::default()).unwrap();
            frame.factors[0].pixels.floats().unwrap()
        };
        let (one, two) = (draw(1), draw(2));
        assert!(one.iter().any(|factor| *factor > 0.1 && *factor < 0.9), "{mode:?}: a penumbra");
        let farthest = one.iter().zip(&two).map(|(one, two)| (one - two).abs()).fold(0.0, f32::max);
        assert!(farthest == 0.0, "{mode:?}: {farthest}");
    }
}

#[test]
fn what_faces_away_is_dark_beside_what_the_horizon_cuts() {
    let Some(mut renderer) = renderer() else { return };
    for mode in [PlanarMode::Direct, PlanarMode::Texture] {
        let mut yard = Yard::unshadowed();
        // The lamp is cut by the floor's plane, and behind the wall's.
        yard.scene.node_mut(yard.lamp).unwrap().parent_from_local.translation = DVec3::new(0.5, 0.05, -3.5);
        let place = DAffine3::from_rotation_translation(
            DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
            DVec3::new(0.0, 0.0, -1.0),
        );
        let wall = yard.scene.add_mesh(shadowgraph_testing::quad("wall", 1.0), Material::default(), place);
        yard.shadow(in_mode(mode), &[yard.floor, wall]);
        let camera = shadowgraph_testing::camera(DVec3::new(1.0, 2.0, 5.0), DVec3::new(0.0, 0.3, -1.0));
        let request = FrameRequest { factors: true, ..FrameRequest::new(camera, [128, 96]) };
        let frame = renderer.render(&yard.scene, &request, &RenderOptions::default()).unwrap();
        let factors = frame.factors[0].pixels.floats().unwrap();
        // The floor is instance 0, the crate 1.
        let seen = frame.visible_triangles.unwrap();
        let on_wall = seen.iter().zip(&factors).filter(|(id, _)| id[0] == 2);
        assert!(on_wall.clone().count() > 300, "{}", on_wall.clone().count());
        assert_eq!(on_wall.filter(|(_, factor)| **factor != 0.0).count(), 0, "{mode:?}");
    }
}
