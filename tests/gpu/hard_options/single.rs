//! `passes=single`: all lights in one stencil, one darkening of the finished picture (Lindrud & Löfgren 2004 §5.3).

use shadowgraph::measure::evaluate;
use shadowgraph::prelude::*;

use super::stage::{floor, open_box, p, request, scene, with_node};

/// A box over a floor between two lamps: its two shadows cross under it.
fn between_two_lamps() -> Scene {
    let mut scene = scene(
        vec![floor(), open_box("box", [0.0, 1.2, 0.0], 0.4, &[])],
        &[p(-1.2, 4.0, 0.0), p(1.2, 4.0, 0.0)],
    );
    // A flag that receives nothing, in the middle of a shadow, and open sky behind.
    let flag = shapes::cuboid(Vec3::new(-0.1, 0.0, 0.5), Vec3::new(0.1, 0.1, 0.6)).named("flag");
    let key = scene.add_mesh(shadowgraph_testing::mesh(flag), Material::default(), DAffine3::IDENTITY);
    if let Content::Mesh(mesh) = &mut scene.node_mut(key).unwrap().content {
        mesh.shadow = shadowgraph::engine::scene::ShadowFlags { casts: false, receives: false };
    }
    scene
}

const WEIGHT: f64 = 0.5;

fn single(weight: f64) -> ShadowVolumeHard {
    ShadowVolumeHard { passes: Passes::Single, weight, ..Default::default() }
}

/// Linear radiance, and every light's factor.
fn rendered(
    renderer: &mut Renderer,
    scene: &Scene,
    view: &FrameRequest,
    factors: bool,
) -> (Vec<f32>, Vec<Vec<f32>>, Vec<[u32; 2]>) {
    let request = FrameRequest { picture: PictureFormat::LinearF32, factors, ..view.clone() };
    let options = RenderOptions { read_picture: true, exposure: Exposure::Fixed(1.0), ..Default::default() };
    let frame = renderer.render(scene, &request, &options).unwrap();
    let floats = |bytes: &[u8]| -> Vec<f32> {
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    };
    let factors = frame.factors.iter().map(|image| floats(&image.pixels.bytes)).collect();
    (floats(&frame.picture.unwrap().bytes), factors, frame.visible_triangles.unwrap_or_default())
}

#[test]
fn the_picture_is_darkened_once_where_any_light_is_blocked() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let base = between_two_lamps();
    let view = request(p(0.0, 3.0, 4.5), p(0.0, 0.6, 0.0));
    let (unshadowed, _, _) = rendered(&mut renderer, &base, &view, false);
    let (picture, factors, ids) = rendered(&mut renderer, &with_node(&base, single(WEIGHT)), &view, true);
    let (multi, multi_factors, _) =
        rendered(&mut renderer, &with_node(&base, ShadowVolumeHard::default()), &view, true);
    assert!(factors == multi_factors, "factors are each light's own in both");
    let (snapshot, _) = renderer.snapshot(&base).unwrap();
    let [mut lit, mut once, mut twice, mut flagged, mut sky] = [0; 5];
    for pixel in 0..ids.len() {
        let radiance = |image: &[f32]| image[pixel * 4];
        let before = radiance(&unshadowed);
        let Some(instance) = snapshot.instances.get(ids[pixel][0] as usize) else {
            sky += 1;
            assert_eq!(radiance(&picture), before, "the sky is no receiver");
            continue;
        };
        if !instance.shadow.receives {
            flagged += 1;
            assert_eq!(radiance(&picture), before, "the flag receives nothing");
            continue;
        }
        // On the floor factors are counts; on the box's own dark sides they are more than that.
        if instance.name != "floor" {
            continue;
        }
        let blocked = factors.iter().filter(|factor| factor[pixel] == 0.0).count();
        let expected = if blocked == 0 { before } else { before * (1.0 - WEIGHT as f32) };
        assert!((radiance(&picture) - expected).abs() <= 2e-6 * before, "pixel {pixel}: {blocked} blocked");
        [lit, once, twice] = match blocked {
            0 => [lit + 1, once, twice],
            1 => [lit, once + 1, twice],
            _ => [lit, once, twice + 1],
        };
        // What is right: each light's own part is gone, and where both are, there is nothing but ambient light.
        if blocked == 2 {
            assert!(radiance(&multi) < 0.75 * radiance(&picture), "the crossing is too bright in one pass");
        }
    }
    println!("lit {lit}, one light blocked {once}, both {twice}, flag {flagged}, sky {sky}");
    assert!([lit, once, twice, flagged, sky].iter().all(|count| *count > 50));
}

#[test]
fn counts_of_several_lights_add_up_and_never_cancel() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    // Lamps on opposite sides, and an eye within the shadow of one of them: z-pass and z-fail in one stencil.
    let base = scene(
        vec![
            floor(),
            open_box("open", [0.0, 0.8, 0.0], 0.5, &[4]),
            open_box("box", [1.2, 0.5, 0.6], 0.3, &[]),
        ],
        &[p(-3.0, 1.5, 0.2), p(3.0, 1.6, 0.1), p(0.0, 4.0, 0.1), p(0.2, 1.0, 4.0)],
    );
    for view in [request(p(1.0, 2.5, 4.0), p(0.0, 0.2, 0.0)), request(p(-2.2, 0.4, 0.1), p(0.5, 0.3, 0.0))] {
        let (unshadowed, _, _) = rendered(&mut renderer, &base, &view, false);
        let (picture, factors, ids) = rendered(&mut renderer, &with_node(&base, single(1.0)), &view, true);
        let (plain, _, _) = rendered(&mut renderer, &with_node(&base, single(1.0)), &view, false);
        assert!(picture == plain, "asking for factors changes nothing");
        let mut dark = [0; 5];
        for pixel in (0..ids.len()).filter(|pixel| ids[*pixel][0] == 0) {
            let blocked = factors.iter().filter(|factor| factor[pixel] == 0.0).count();
            let darkened = picture[pixel * 4] == 0.0 && unshadowed[pixel * 4] > 0.0;
            assert_eq!(darkened, blocked > 0, "pixel {pixel}: {blocked} of 4 lights are blocked");
            dark[blocked] += 1;
        }
        println!("floor pixels by blocked lights: {dark:?}");
        assert!(dark[0] > 0 && dark[1] > 0 && dark[2] > 0, "{dark:?}");
    }
}

#[test]
fn factors_stay_exact() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let scene = with_node(&between_two_lamps(), single(0.3));
    let view = request(p(0.0, 3.0, 4.5), p(0.0, 0.6, 0.0));
    let evaluation = evaluate(&mut renderer, &scene, &view, &|_, _| {}).unwrap();
    assert_eq!(evaluation.errors.len(), 2);
    assert!(evaluation.errors.iter().all(|error| error.passes()), "{:?}", evaluation.errors);
}
