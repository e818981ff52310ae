//! Many lights: the picture is the sum of the pictures of each light alone, and no light's shadow leaks into the next.

use glam::Vec2;
use shadowgraph::engine::geometry::shapes::{Ends, cylinder, icosphere, plane, quad, torus_knot};
use shadowgraph::engine::plan::FactorAt;
use shadowgraph::engine::render::Frame;
use shadowgraph::engine::scene::NodeKey;
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [256, 192];

/// A light of the test: what it is, where it stands, what it shines at, and whether a shadow node serves it.
struct Lamp {
    light: Light,
    position: DVec3,
    target: DVec3,
    shadowed: bool,
}

/// `count` lights on a spiral, kinds in turn; every fifth casts no shadows, some end at a range.
fn lamps(count: u32) -> Vec<Lamp> {
    (0..count)
        .map(|i| {
            let angle = f64::from(i) * 2.4;
            let reach_m = 0.6 + 2.6 * f64::from(i) / f64::from(count);
            let height_m = 2.5 + 0.3 * f64::from(i % 4);
            let position = DVec3::new(reach_m * angle.cos(), height_m, reach_m * angle.sin());
            let name = format!("lamp {i}");
            let color = Vec3::new(1.0, 0.4 + 0.1 * (i % 7) as f32, 0.3 + 0.05 * (i % 11) as f32);
            let light = match i % 3 {
                0 => Light::point(&name, 12.0),
                1 => Light::directional(&name, 1.5),
                _ => Light::spot(&name, 20.0, 0.6),
            };
            let light = if i % 4 == 2 || i % 12 == 3 { light.with_range(4.5) } else { light };
            let target = if i % 3 == 1 { DVec3::ZERO } else { DVec3::new(0.2, 0.4, 0.0) };
            Lamp { light: light.with_color(color), position, target, shadowed: i % 5 != 4 }
        })
        .collect()
}

/// `count` lights close over the floor, points and spots in turn, each of which reaches a small part of it; some beyond the
/// picture's edge.
fn small_lamps(count: u32) -> Vec<Lamp> {
    let mut lamps = lamps(count);
    for (i, lamp) in (0..count).zip(&mut lamps) {
        let (column, row) = (f64::from(i % 6), f64::from(i / 6));
        lamp.position = DVec3::new(column * 0.9 - 2.2, 0.5 + 0.1 * f64::from(i % 3), row * 0.8 - 2.0);
        lamp.target = lamp.position + DVec3::new(0.3, -1.0, 0.2 * f64::from(i % 4) - 0.3);
        let Light { name, color, .. } = &lamp.light;
        let light = if i % 2 == 0 { Light::point(name, 2.0) } else { Light::spot(name, 3.0, 0.5) };
        lamp.light = light.with_color(*color).with_range(0.9);
    }
    lamps
}

/// Closed, open and non-manifold casters on a floor, under these lights; black but for them.
fn scene_under<'a>(lamps: impl IntoIterator<Item = &'a Lamp>) -> Scene {
    let v = Vec3::new;
    let at = |x, y, z| DAffine3::from_translation(DVec3::new(x, y, z));
    let mut scene = Scene::new();
    scene.set_ambient(Vec3::ZERO);
    scene.set_background(Vec3::ZERO);
    // Three leaves on one upright edge.
    let leaf = |x: f32, z: f32| quad([v(0.0, 0.1, 0.0), v(x, 0.1, z), v(x, 1.0, z), v(0.0, 1.0, 0.0)]);
    let fins = MeshData::merged("fins", [leaf(0.5, 0.1), leaf(-0.3, 0.4), leaf(-0.2, -0.5)]);
    for (data, place) in [
        (plane(Vec2::splat(4.0)).named("floor"), DAffine3::IDENTITY),
        (torus_knot([2, 3], 0.3, 0.08, [48, 6]), at(-0.7, 0.9, 0.3)),
        (icosphere(0.35, 2), at(0.9, 0.7, -0.4)),
        (cylinder(0.25, 0.7, 20, Ends::Open), at(0.7, 0.1, 0.9)),
        (fins, at(-0.4, 0.0, 1.3)),
    ] {
        scene.add_mesh(shadowgraph_testing::mesh(data), Material::matt("matt", v(0.8, 0.75, 0.7)), place);
    }
    let mut shadowed: Vec<NodeKey> = Vec::new();
    for lamp in lamps {
        let key = scene.add_light(lamp.light.clone(), lamp.position, lamp.target);
        if lamp.shadowed {
            shadowed.push(key);
        }
    }
    if !shadowed.is_empty() {
        let node = ShadowNode::from(ShadowVolumeHard::default());
        scene.add_shadow("shadows", node.with_lights(shadowed));
    }
    scene
}

/// A frame of linear radiance with its factors.
fn frame_of(renderer: &mut Renderer, scene: &Scene) -> Frame {
    let camera = Camera::perspective("eye", 0.8);
    let camera = CameraSnapshot::looking(camera, DVec3::new(2.0, 3.0, 5.0), DVec3::new(0.0, 0.4, 0.2));
    let mut request = FrameRequest::new(camera, SIZE_PX);
    request.picture = PictureFormat::LinearF32;
    request.factors = true;
    let options =
        RenderOptions { exposure: Exposure::Fixed(1.0), read_picture: true, ..RenderOptions::default() };
    renderer.render(scene, &request, &options).unwrap()
}

fn picture(frame: &Frame) -> Vec<f32> {
    frame.picture.as_ref().unwrap().floats().unwrap()
}

/// The relative difference allowed between the picture of `lights` lights and the sum of their pictures.
///
/// All terms are positive. A light's term is computed by the same shader text, but for where its factor is looked up,
/// so another compilation may round its twenty or so operations otherwise (32 roundings of 2⁻²⁴ leave room); the sum
/// adds one rounding for each light. Anything that leaks is a whole term: about 1/64 of a pixel.
fn sum_bound(lights: usize) -> f64 {
    (lights + 32) as f64 * 2.0_f64.powi(-24)
}

#[test]
fn many_lights_are_the_sum_of_single_ones() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (count, small) in [(1, false), (4, false), (16, false), (64, false), (6, true), (40, true)] {
        let lamps = if small { small_lamps(count) } else { lamps(count) };
        let together = frame_of(&mut renderer, &scene_under(&lamps));
        let mut sum = vec![0.0_f64; picture(&together).len()];
        let (mut shadowed, mut dark_pixels) = (0, 0);
        for lamp in &lamps {
            let alone = frame_of(&mut renderer, &scene_under([lamp]));
            sum.iter_mut().zip(picture(&alone)).for_each(|(sum, value)| *sum += f64::from(value));
            let name = &lamp.light.name;
            let named = |frame: &Frame| {
                let mut factors = frame.factors.iter();
                factors.find(|factor| factor.light == alone.plan.lights[0].name).cloned()
            };
            let (one, all) = (named(&alone), named(&together));
            assert_eq!(one.is_some(), lamp.shadowed, "{count} lights, {name}");
            assert!(one == all, "{count} lights: the factor of {name} is another than when it is alone");
            if let Some(factor) = one {
                shadowed += 1;
                dark_pixels += factor.pixels.floats().unwrap().iter().filter(|f| **f < 0.5).count();
            }
        }
        assert_eq!(together.factors.len(), shadowed);
        let enough = if small { 10 } else { 100 };
        assert!(dark_pixels > enough * shadowed, "{count} lights: {dark_pixels} pixels to get wrong");
        // Pixels take the lights that reach their tile, where these are few of all.
        assert_eq!(together.plan.slots.iter().any(|slot| slot.name == "light tiles"), small, "{count}");
        let mut worst = 0.0_f64;
        for (index, (sum, value)) in sum.iter().zip(picture(&together)).enumerate() {
            // The fourth channel is no light.
            if index % 4 == 3 {
                continue;
            }
            let difference = (sum - f64::from(value)).abs() / sum.max(1e-6);
            assert!(
                difference <= sum_bound(lamps.len()),
                "{count} lights: pixel {} is {value}, the sum {sum}",
                index / 4
            );
            worst = worst.max(difference);
        }
        assert!(sum.iter().any(|value| *value > 0.1), "{count} lights: the picture is dark");
        println!("{count} lights, {shadowed} with shadows: largest relative difference {worst:.2e}");
    }
}

#[test]
fn a_light_in_the_stencil_looks_as_one_in_the_mask() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for lamp in &lamps(3) {
        let mut dark = lamps(1).remove(0);
        dark.light.name = "dark".into();
        dark.light.intensity = 0.0;
        let alone = frame_of(&mut renderer, &scene_under([lamp]));
        let beside = frame_of(&mut renderer, &scene_under([lamp, &dark]));
        let before = frame_of(&mut renderer, &scene_under([&dark, lamp]));
        assert_eq!(alone.plan.lights[0].factor, FactorAt::Counts);
        assert_eq!(beside.plan.lights[0].factor, FactorAt::MaskBit(0));
        assert_eq!(before.plan.lights[1].factor, FactorAt::MaskBit(1));
        let name = &lamp.light.name;
        assert!(picture(&alone).iter().any(|value| *value > 0.1), "{name}: the picture is dark");
        assert!(alone.picture == beside.picture, "{name}: the mask's first bit");
        assert!(alone.picture == before.picture, "{name}: the mask's second bit");
    }
}
