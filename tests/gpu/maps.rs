//! Maps of what a light sees: no surface shadows itself, no shadow comes off, at any angle, for every kind of light and at every
//! resolution, measured in texels; the exercises of the textbook; what is kept, and what a moving eye changes.

mod large;
mod texels;

use std::sync::Arc;

use glam::{Vec2, Vec3};
use shadowgraph::engine::geometry::shapes::{cuboid, icosphere, plane, sheet};
use shadowgraph::engine::render::Adapter;
use shadowgraph::engine::scene::{AlphaMode, CameraSnapshot, Image, TextureRef};
use shadowgraph::engine::shadow::Cache;
use shadowgraph::measure::{KnownReferences, evaluate};
use shadowgraph::prelude::*;
use texels::{InTexels, judge};

const SIZE_PX: [u32; 2] = [192, 144];
/// Where thousands of pixels are wrong, of which each is asked about.
const SMALL_PX: [u32; 2] = [64, 48];

fn block(center: Vec3, half: Vec3) -> MeshData {
    cuboid(center - half, center + half)
}

/// A floor with what maps get wrong: a box on it, a wall thinner than a texel, a plate close above it, a step into which light
/// falls, a ball, and a sheet in waves.
fn stage() -> Scene {
    let mut scene = Scene::new();
    let mut add = |name: &str, data: MeshData| {
        scene.add_mesh(shadowgraph_testing::mesh(data.named(name)), Material::default(), DAffine3::IDENTITY);
    };
    add("floor", plane(Vec2::splat(6.0)));
    add("box", block(Vec3::new(-1.2, 0.3, 0.6), Vec3::splat(0.3)));
    add("wall", block(Vec3::new(0.2, 0.4, 0.9), Vec3::new(0.5, 0.4, 0.002)));
    add("plate", block(Vec3::new(1.4, 0.1, 0.8), Vec3::new(0.3, 0.002, 0.3)));
    add("step", block(Vec3::new(1.6, 0.2, -0.9), Vec3::new(0.8, 0.2, 0.4)));
    add("ball", icosphere(0.35, 3).moved(Vec3::new(-0.4, 0.5, -0.7)));
    add(
        "waves",
        sheet(16, 16, |u, v| {
            let (x, z) = (u - 0.5, 0.5 - v);
            Vec3::new(-1.8 + x, 0.25 + 0.05 * (9.0 * x).sin() * (7.0 * z).cos(), -1.0 + z)
        }),
    );
    scene
}

fn eye() -> CameraSnapshot {
    shadowgraph_testing::camera(DVec3::new(1.4, 2.9, 3.6), DVec3::new(0.0, 0.1, 0.0))
}

/// A light that meets the floor at this angle from its normal, at the middle of the stage.
fn add_light(scene: &mut Scene, kind: &str, angle_deg: f64) {
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let towards = DVec3::new(0.8 * sin, cos, 0.6 * sin);
    let (position, distance_m) = (towards * 7.0, 7.0);
    match kind {
        "sun" => scene.add_light(Light::directional(kind, 3.0), DVec3::ZERO, -towards),
        "lamp" => scene.add_light(Light::point(kind, 10.0 * distance_m), position, DVec3::ZERO),
        _ => scene.add_light(Light::spot(kind, 10.0 * distance_m, 0.55), position, DVec3::ZERO),
    };
}

/// How wrong a map is on the stage.
fn on_stage(
    renderer: &mut Renderer,
    (kind, angle_deg): (&str, f64),
    (node, size_px): (ShadowMap, [u32; 2]),
    references: &mut KnownReferences,
) -> InTexels {
    let mut scene = stage();
    add_light(&mut scene, kind, angle_deg);
    scene.add_shadow("shadows", node);
    judge(renderer, &scene, &eye(), size_px, 2.0, references).unwrap()
}

#[test]
fn nothing_shadows_itself_and_no_shadow_comes_off_by_more_than_two_texels() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut wrong = Vec::new();
    for kind in ["sun", "lamp", "spot"] {
        for angle_deg in [0.0, 45.0, 80.0] {
            let mut references = KnownReferences::default();
            for (resolution, pcf) in [(512, 1), (1024, 1), (2048, 1), (512, 3)] {
                let node = ShadowMap { resolution, pcf, ..ShadowMap::default() };
                let found = on_stage(&mut renderer, (kind, angle_deg), (node, SIZE_PX), &mut references);
                println!("{kind} {angle_deg:>2} degrees, {resolution:>4}, pcf {pcf}: {found:?}");
                assert!(found.compared > 15_000 && found.in_shadow > 300, "{found:?}");
                if found.acne + found.far_leaks > 0 {
                    wrong.push(format!("{kind} at {angle_deg} degrees, {resolution}, pcf {pcf}: {found:?}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Broken on purpose: without a bias, and without planes either, surfaces shadow themselves; biased too much, shadows come off.
#[test]
fn what_is_wrong_is_found_to_be() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let base = ShadowMap { resolution: 512, pcf: 1, ..ShadowMap::default() };
    let unbiased = ShadowMap { constant_bias_m: Some(0.0), faces: Faces::Both, ..base };
    let floating = ShadowMap { constant_bias_m: Some(0.2), ..base };
    for kind in ["sun", "lamp", "spot"] {
        let mut references = KnownReferences::default();
        let mut on_stage = |node| on_stage(&mut renderer, (kind, 60.0), (node, SMALL_PX), &mut references);
        let found = on_stage(unbiased);
        assert!(found.acne > 60, "{kind}: {found:?}");
        let found = on_stage(floating);
        assert!(found.far_leaks > 3, "{kind}: {found:?}");
    }
}

/// Biases that are set are used as the textbook says: with back faces of solids, what is closed needs none on its lit side.
#[test]
fn back_faces_of_solids_need_no_bias_on_their_lit_side() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut acne = |faces| {
        let mut scene = Scene::new();
        let mut add = |name: &str, data: MeshData, casts| {
            let mesh = shadowgraph_testing::mesh(data.named(name));
            let node = scene.add_mesh(mesh, Material::default(), DAffine3::IDENTITY);
            if let Content::Mesh(mesh) = &mut scene.node_mut(node).unwrap().content {
                mesh.shadow.casts = casts;
            }
        };
        add("floor", plane(Vec2::splat(4.0)), false);
        add("ball", icosphere(0.8, 4).moved(Vec3::Y), true);
        add_light(&mut scene, "lamp", 40.0);
        let node =
            ShadowMap { constant_bias_m: Some(0.0), resolution: 256, pcf: 1, faces, ..ShadowMap::default() };
        scene.add_shadow("shadows", node);
        judge(&mut renderer, &scene, &eye(), SIZE_PX, 2.0, &mut KnownReferences::default()).unwrap().acne
    };
    let (both, back) = (acne(Faces::Both), acne(Faces::Auto));
    assert!(both > 200 && back == 0, "{both} with all faces, {back} with back faces");
}

/// Exercise 1 of the textbook: seen from the light there is no shadow; and a spot at the eye that shines backwards lights nothing
/// that the eye sees.
#[test]
fn seen_from_the_light_there_is_no_shadow() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let (eye, target) = (DVec3::new(2.0, 2.5, 3.0), DVec3::new(0.0, 0.2, 0.0));
    let camera = shadowgraph_testing::camera(eye, target);
    for kind in ["sun", "lamp", "spot"] {
        let mut scene = stage();
        match kind {
            "sun" => scene.add_light(Light::directional(kind, 3.0), DVec3::ZERO, target - eye),
            "lamp" => scene.add_light(Light::point(kind, 60.0), eye, DVec3::ZERO),
            _ => scene.add_light(Light::spot(kind, 60.0, 0.9), eye, target),
        };
        scene.add_shadow("shadows", ShadowMap::default());
        let found =
            judge(&mut renderer, &scene, &camera, SIZE_PX, 2.0, &mut KnownReferences::default()).unwrap();
        assert_eq!((found.acne, found.far_leaks), (0, 0), "{kind}: {found:?}");
        // A direction is that of the eye in the picture's middle only.
        if kind != "sun" {
            assert!(found.dark <= 10, "{kind}: {found:?}");
        }
    }
    let mut scene = stage();
    scene.add_light(Light::spot("backwards", 60.0, 0.5), eye, eye * 2.0 - target);
    scene.add_shadow("shadows", ShadowMap::default());
    let request = FrameRequest::new(camera, SIZE_PX);
    let plan = renderer.plan(&scene, &request).unwrap();
    assert!(plan.passes.iter().all(|pass| !pass.name.contains("backwards")), "{plan}");
}

/// Exercise 2: a smaller volume of what the light sees makes the same texels smaller, and edges as much better.
#[test]
fn a_smaller_volume_of_light_has_better_edges() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut wrong = |far_away: bool| {
        let mut scene = stage();
        if far_away {
            for x in [-40.0, 40.0] {
                let post = block(Vec3::new(0.0, 1.0, 0.0), Vec3::new(0.1, 1.0, 0.1));
                let post = shadowgraph_testing::mesh(post);
                let place = DAffine3::from_translation(DVec3::new(x, 0.0, -x));
                scene.add_mesh(post, Material::default(), place);
            }
            // What makes the window wide has to be in view.
            let wide =
                shadowgraph_testing::mesh(plane(Vec2::splat(60.0)).moved(Vec3::Y * -0.01).named("earth"));
            scene.add_mesh(wide, Material::default(), DAffine3::IDENTITY);
        }
        add_light(&mut scene, "spot", 30.0);
        let (key, _) = scene.lights().next().unwrap();
        if let shadowgraph::engine::scene::LightKind::Spot { inner_rad, outer_rad } =
            &mut scene.light_mut(key).unwrap().kind
        {
            (*inner_rad, *outer_rad) = if far_away { (1.0, 1.04) } else { (0.4, 0.55) };
        }
        scene.add_shadow("shadows", ShadowMap { resolution: 512, pcf: 1, ..ShadowMap::default() });
        let found =
            judge(&mut renderer, &scene, &eye(), SIZE_PX, 2.0, &mut KnownReferences::default()).unwrap();
        assert_eq!((found.acne, found.far_leaks), (0, 0), "{found:?}");
        (found.leaks + found.dark) as f64 / found.compared as f64
    };
    let (narrow, wide) = (wrong(false), wrong(true));
    assert!(wide > 1.5 * narrow, "{narrow} of a narrow cone, {wide} of a wide one");
}

/// The exercise with a glass panel whose texture has alpha 0 or 1: before headlights, its image is on the wall behind it.
#[test]
fn headlights_throw_the_image_of_a_panel_onto_the_wall() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = Scene::new();
    let mut texels = vec![255; 4 * 64];
    for (number, texel) in texels.chunks_exact_mut(4).enumerate() {
        // A face: two eyes and a mouth are holes.
        let (x, y) = (number % 8, number / 8);
        let hole = (y == 2 && (x == 2 || x == 5)) || (y == 5 && (2..6).contains(&x));
        texel[3] = if hole { 0 } else { 255 };
    }
    let image = scene.add_image(Arc::new(Image { name: "face".into(), width: 8, height: 8, rgba8: texels }));
    let panel = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        base_color_texture: Some(TextureRef { smooth: false, ..TextureRef::new(image) }),
        ..Material::default()
    };
    let upright = |half: f32, z: f32| {
        let corner = |x: f32, y: f32| Vec3::new(x * half, 1.2 + y * half, z);
        MeshData {
            positions: vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
            uvs: vec![Vec2::new(0.0, 1.0), Vec2::ONE, Vec2::new(1.0, 0.0), Vec2::ZERO],
            indices: vec![0, 1, 2, 0, 2, 3],
            ..MeshData::default()
        }
    };
    scene.add_mesh(shadowgraph_testing::mesh(upright(1.0, 0.0)), panel, DAffine3::IDENTITY);
    scene.add_mesh(shadowgraph_testing::mesh(upright(6.0, -2.0)), Material::default(), DAffine3::IDENTITY);
    for (name, x) in [("left", -0.6), ("right", 0.6)] {
        let place = DVec3::new(x, 0.7, 4.0);
        scene.add_light(Light::spot(name, 60.0, 0.6), place, place + DVec3::new(0.0, 0.05, -1.0));
    }
    scene.add_shadow("shadows", ShadowMap { pcf: 1, ..ShadowMap::default() });
    let camera = shadowgraph_testing::camera(DVec3::new(2.5, 1.4, 2.5), DVec3::new(0.0, 1.2, -1.6));
    let request = FrameRequest::new(camera, [320, 240]);
    let evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
    for error in &evaluation.errors {
        let drawn = &evaluation.measured.lights.iter().find(|(name, _)| *name == error.name).unwrap().1;
        let dark = drawn.iter().filter(|factor| **factor == 0.0).count();
        println!("{}: {} wrong of {}, {dark} dark", error.name, error.wrong, error.compared);
        // Some seventy edges of texels that are 40 pixels long, off by a fraction of a pixel.
        assert!(error.shadow_pixels > 4000 && error.wrong < 100, "{}: {}", error.name, error.wrong);
        assert!(error.boundary_distance_max_px <= 2.0, "{}", error.boundary_distance_max_px);
    }
}

/// A map that nothing changed is not drawn again, whatever the eye does; what moved is.
#[test]
fn a_map_that_nothing_changed_costs_nothing() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for kind in ["sun", "lamp", "spot"] {
        let mut scene = stage();
        add_light(&mut scene, kind, 40.0);
        scene.add_shadow("shadows", ShadowMap { resolution: 256, ..ShadowMap::default() });
        let mut render = |scene: &Scene, shift: f64| {
            let eye =
                shadowgraph_testing::camera(DVec3::new(1.4 + shift, 2.9, 3.6), DVec3::new(shift, 0.1, 0.0));
            let request = FrameRequest::new(eye, SIZE_PX);
            let frame = renderer.render(scene, &request, &RenderOptions::default()).unwrap();
            let map = format!("map of {kind}");
            let planned = frame.plan.passes.iter().filter(|pass| pass.name == map).count();
            (planned, frame.kept.iter().filter(|name| **name == map).count())
        };
        let (planned, kept) = render(&scene, 0.0);
        assert!(planned > 0 && kept == 0, "{kind}: {planned} planned, {kept} kept");
        assert_eq!(render(&scene, 0.0), (planned, planned), "{kind}: nothing moved");
        assert_eq!(render(&scene, 0.002), (planned, planned), "{kind}: only the eye moved");
        let moved = scene.find("box").unwrap();
        scene.node_mut(moved).unwrap().parent_from_local = DAffine3::from_translation(DVec3::X * 0.01);
        assert_eq!(render(&scene, 0.002).1, 0, "{kind}: the box moved");
    }
}

/// Beside another node on one light, each with casters of its own: the factor is the product.
#[test]
fn beside_volumes_on_one_light() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = stage();
    add_light(&mut scene, "lamp", 40.0);
    let key = |name: &str| scene.find(name).unwrap();
    let (solids, rest) = (["box", "ball"].map(key), ["floor", "wall", "plate", "step", "waves"].map(key));
    scene.add_shadow("volumes", ShadowNode::from(ShadowVolumeHard::default()).with_casters(solids));
    let map = ShadowMap { pcf: 1, ..ShadowMap::default() };
    scene.add_shadow("maps", ShadowNode::from(map).with_casters(rest));
    let found = judge(&mut renderer, &scene, &eye(), SIZE_PX, 2.0, &mut KnownReferences::default()).unwrap();
    assert!(found.in_shadow > 300 && found.acne + found.far_leaks == 0, "{found:?}");
}

/// Texels lie where they lay, in the world, while the eye moves: each place of it has the texel it had, to a thousandth, as long as
/// texels have one size; and they seldom change it.
#[test]
fn texels_stay_where_they_are_under_a_moving_eye() {
    let (catalog, adapter, cache) = (shadowgraph_nodes::catalog(), Adapter::imagined(), Cache::new());
    let mut scene = stage();
    let wide = shadowgraph_testing::mesh(plane(Vec2::splat(200.0)).moved(Vec3::Y * -0.01).named("earth"));
    scene.add_mesh(wide, Material::default(), DAffine3::IDENTITY);
    for x in -20..20 {
        let post = shadowgraph_testing::mesh(block(Vec3::new(3.0 * x as f32, 1.0, -3.0), Vec3::splat(0.2)));
        scene.add_mesh(post, Material::default(), DAffine3::IDENTITY);
    }
    add_light(&mut scene, "sun", 50.0);
    for cascades in [1, 3] {
        let mut scene = scene.clone();
        scene.add_shadow("shadows", ShadowMap { cascades, ..ShadowMap::default() });
        let mut known: Vec<(usize, f64, f64)> = Vec::new();
        let mut keys = std::collections::HashSet::new();
        let steps = 200;
        for step in 0..steps {
            let shift = DVec3::new(0.013, 0.001, 0.007) * f64::from(step);
            let camera = shadowgraph_testing::camera(DVec3::new(1.4, 2.9, 3.6) + shift, shift);
            let request = FrameRequest::new(camera.clone(), SIZE_PX);
            let plan =
                shadowgraph_testing::try_plan_with(&scene, &request, &catalog, &adapter, &cache).unwrap();
            keys.extend(plan.slots.iter().filter_map(|slot| slot.kept));
            for (axis, size_m, texel) in texels::places(&plan, "sun", &camera, DVec3::new(0.3, 0.2, -0.4)) {
                let same = known.iter().find(|(a, size, _)| *a == axis && (size / size_m - 1.0).abs() < 1e-5);
                match same {
                    // Counted from the window's corner: by whole texels another.
                    Some((_, _, before)) => {
                        let off = texel - before;
                        let off = (off - off.round()).abs();
                        assert!(off < 2e-3, "{cascades} cascades, step {step}: off by {off} texels");
                    }
                    None => known.push((axis, size_m, texel)),
                }
            }
        }
        println!("{cascades} cascades: {} sizes, {} maps in {steps} frames", known.len(), keys.len());
        assert!(known.len() <= 8 * cascades as usize, "{known:?}");
        assert!(keys.len() < steps as usize, "{} maps were drawn", keys.len());
    }
}
