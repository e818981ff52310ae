//! `terminator=smooth`: pictures of smooth casters without their facets' terminator, and nothing else changed.

use shadowgraph::prelude::*;

use super::stage::{floor, p, request, scene, with_node};

fn smooth() -> ShadowVolumeHard {
    ShadowVolumeHard { terminator: Terminator::Smooth, ..Default::default() }
}

/// A ball of few facets, another shape before it that casts on it, and a floor.
fn still_life(light: DVec3) -> Scene {
    let mut scene = scene(vec![floor()], &[light]);
    let mut add = |data: MeshData, place: DVec3| {
        scene.add_mesh(
            shadowgraph_testing::mesh(data),
            Material::default(),
            DAffine3::from_translation(place),
        );
    };
    add(shapes::uv_sphere(0.9, 10, 6).named("ball"), p(0.0, 1.2, 0.0));
    // Concave: a ring whose near half casts on its far half.
    add(shapes::torus(0.7, 0.22, 12, 8).named("ring"), p(2.0, 0.6, 0.4));
    add(shapes::cuboid(Vec3::splat(-0.15), Vec3::splat(0.15)).named("block"), p(0.5, 2.4, 0.7));
    scene
}

/// The picture in linear radiance and the triangle of every pixel.
fn linear(renderer: &mut Renderer, scene: &Scene, view: &FrameRequest) -> (Vec<f32>, Vec<[u32; 2]>, Vec<u8>) {
    let request = FrameRequest { picture: PictureFormat::LinearF32, factors: true, ..view.clone() };
    let options = RenderOptions { read_picture: true, exposure: Exposure::Fixed(1.0), ..Default::default() };
    let frame = renderer.render(scene, &request, &options).unwrap();
    let bytes = frame.picture.unwrap().bytes;
    let picture = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    (picture, frame.visible_triangles.unwrap(), frame.factors[0].pixels.bytes.clone())
}

#[test]
fn only_the_far_sides_of_solids_change_and_factors_never_do() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (light, eye) in [
        (p(2.5, 3.0, 2.0), p(-1.0, 2.0, 4.5)),
        (p(-2.5, 2.8, 0.5), p(2.0, 2.5, 4.0)),
        // The eye in the ball's shadow: z-fail.
        (p(0.5, 4.0, -2.5), p(-0.1, 0.5, 1.0)),
    ] {
        let base = still_life(light);
        let view = request(eye, p(0.4, 0.9, 0.0));
        let (before, ids, factors) =
            linear(&mut renderer, &with_node(&base, ShadowVolumeHard::default()), &view);
        for node in [
            smooth(),
            ShadowVolumeHard { counter: CounterKind::Float, ..smooth() },
            ShadowVolumeHard { depth_test: DepthTest::ZFail, ..smooth() },
        ] {
            let (after, same_ids, same_factors) = linear(&mut renderer, &with_node(&base, node), &view);
            assert!(ids == same_ids && factors == same_factors, "{node:?}: factors are geometric");
            let (snapshot, _) = renderer.snapshot(&base).unwrap();
            let (mut changed, mut brighter) = (0, 0);
            for pixel in 0..ids.len() {
                let [instance, triangle] = ids[pixel];
                if before[pixel * 4] == after[pixel * 4] {
                    continue;
                }
                changed += 1;
                brighter += usize::from(after[pixel * 4] > before[pixel * 4]);
                let instance = &snapshot.instances[instance as usize];
                let [a, b, c] = instance.world_triangle(triangle as usize);
                let turned_away = (b - a).cross(c - a).dot(light - a) < 0.0;
                assert!(
                    turned_away && instance.name != "floor",
                    "{node:?}: pixel {pixel} of {}",
                    instance.name
                );
            }
            println!("{eye}: {changed} pixels changed, {brighter} of them brighter");
            assert!(brighter == changed, "light is added past the facets' terminator, never taken");
            assert!(changed > 100 || eye.y < 1.0, "nothing is smoothed");
        }
    }
}

#[test]
fn the_far_side_of_a_lone_ball_is_as_its_normals_say() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let (mut zone, mut specks) = (0, 0);
    for step in 0..6 {
        let angle = f64::from(step) * 1.05 + 0.3;
        let light = p(3.0 * angle.cos(), 2.0 + angle.sin(), 3.0 * angle.sin());
        let mut base = Scene::new();
        let ball = shapes::uv_sphere(0.9, 10, 6).named("ball");
        base.add_mesh(
            shadowgraph_testing::mesh(ball),
            Material::matt("white", Vec3::ONE),
            DAffine3::IDENTITY,
        );
        base.add_light(Light::point("lamp", 30.0), light, DVec3::ZERO);
        // Nothing but the ball, so no pixel of it may be in anybody's shadow: brightness follows the normals everywhere.
        let view = FrameRequest { size_px: [512, 512], ..request(p(-1.5, 1.5, 2.5), DVec3::ZERO) };
        let (picture, ids, _) = linear(&mut renderer, &with_node(&base, smooth()), &view);
        let (snapshot, _) = renderer.snapshot(&base).unwrap();
        let width = view.size_px[0] as usize;
        for pixel in width + 1..ids.len() - width - 1 {
            let [instance, triangle] = ids[pixel];
            if instance != 0 {
                continue;
            }
            let [a, b, c] = snapshot.instances[0].world_triangle(triangle as usize);
            if (b - a).cross(c - a).dot(light - a) >= 0.0 {
                continue;
            }
            zone += 1;
            // A speck is much darker than all its neighbours on its own triangle.
            let neighbours = [pixel - 1, pixel + 1, pixel - width, pixel + width];
            let darkest = neighbours.iter().filter(|n| ids[**n] == ids[pixel]).map(|n| picture[n * 4]);
            let darkest = darkest.fold(f32::INFINITY, f32::min);
            specks += usize::from(picture[pixel * 4] < 0.8 * darkest && darkest.is_finite());
        }
    }
    println!("{zone} pixels turned away, {specks} specks");
    assert!(zone > 50_000 && specks == 0, "{specks} specks");
}

#[test]
fn open_casters_keep_theirs_and_the_plan_says_so() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut base = scene(vec![floor()], &[p(1.0, 4.0, 1.0)]);
    let sheet = shapes::sheet(6, 6, |u, v| Vec3::new(u, 1.0 + 0.3 * (u * 6.0).sin(), -v));
    base.add_mesh(shadowgraph_testing::mesh(sheet.named("cloth")), Material::default(), DAffine3::IDENTITY);
    let view = request(p(1.0, 3.0, 4.0), p(0.0, 0.5, 0.0));
    let plan = renderer.plan(&with_node(&base, smooth()), &view).unwrap();
    let said = plan.notes.iter().any(|note| note.contains("'cloth'") && note.contains("terminator=smooth"));
    assert!(said && plan.lights[0].smooth_terminators.is_empty(), "{plan}");
    let (with, ..) = linear(&mut renderer, &with_node(&base, smooth()), &view);
    let (without, ..) = linear(&mut renderer, &with_node(&base, ShadowVolumeHard::default()), &view);
    assert!(with == without);
}

/// One pixel of this frame was lit, where rounding shows the floor a little within a block that stands on it: caps of the block's
/// far side took it for a part of themselves.
#[test]
fn at_the_foot_of_solids_nothing_is_lit() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let (.., mut columns) =
        shadowgraph::demo::all().into_iter().find(|(name, ..)| *name == "columns").unwrap();
    let shadows: Vec<_> = columns.shadows().map(|(key, _)| key).collect();
    for key in shadows {
        *columns.shadow_mut(key).unwrap() = smooth().into();
    }
    let camera = columns.snapshot().unwrap().cameras[0].clone();
    let view = FrameRequest::new(camera, [1280, 720]);
    let found = super::stage::errors(&mut renderer, "columns", &columns, &view);
    assert!(found.iter().all(|error| error.passes()), "{found:?}");
}
