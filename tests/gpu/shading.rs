//! What the picture itself promises: radiance, falloff, cones, materials, colours, and black where no light comes.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{Vec2, Vec4};
use shadowgraph::engine::geometry::shapes::{cuboid, plane, quad};
use shadowgraph::engine::scene::{AlphaMode, Image, LightKind, TextureRef};
use shadowgraph::prelude::*;

/// Odd, so that a pixel centre lies on the axis of view.
const SIZE_PX: [u32; 2] = [129, 129];
const MIDDLE: [u32; 2] = [64, 64];

/// A black scene with a floor of `material` at height 0, 20 m to each side.
fn floor_of(material: Material) -> Scene {
    let mut scene = Scene::new();
    scene.set_ambient(Vec3::ZERO);
    scene.set_background(Vec3::ZERO);
    let floor = shadowgraph_testing::mesh(plane(Vec2::splat(20.0)).named("floor"));
    scene.add_mesh(floor, material, DAffine3::IDENTITY);
    scene
}

/// As Lambert as the material model gets: no mirror at normal incidence but for the 4 % of dielectrics, rough.
fn matt(albedo: f32) -> Material {
    Material { roughness: 1.0, ..Material::matt("matt", Vec3::splat(albedo)) }
}

fn camera(eye: DVec3, target: DVec3) -> CameraSnapshot {
    CameraSnapshot::looking(Camera::perspective("eye", 0.8), eye, target)
}

/// Ten metres above the origin, looking down.
fn from_above() -> CameraSnapshot {
    camera(DVec3::new(0.0, 10.0, 0.0), DVec3::ZERO)
}

/// Linear radiance, row by row.
fn radiance(renderer: &mut Renderer, scene: &Scene, camera: &CameraSnapshot) -> Vec<Vec3> {
    let mut request = FrameRequest::new(camera.clone(), SIZE_PX);
    request.picture = PictureFormat::LinearF32;
    let frame = renderer.render(scene, &request, &options()).unwrap();
    let floats = frame.picture.unwrap().floats().unwrap();
    floats.chunks_exact(4).map(|texel| Vec3::new(texel[0], texel[1], texel[2])).collect()
}

/// The 8-bit sRGB picture.
fn srgb(renderer: &mut Renderer, scene: &Scene, camera: &CameraSnapshot) -> Vec<[u8; 4]> {
    let frame = renderer.render(scene, &FrameRequest::new(camera.clone(), SIZE_PX), &options()).unwrap();
    let picture = frame.picture.unwrap();
    picture.bytes.chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2], texel[3]]).collect()
}

fn options() -> RenderOptions {
    RenderOptions { exposure: Exposure::Fixed(1.0), read_picture: true, ..RenderOptions::default() }
}

fn at<T: Copy>(picture: &[T], [x, y]: [u32; 2]) -> T {
    picture[(y * SIZE_PX[0] + x) as usize]
}

/// The pixel that shows `point`.
fn pixel_of(camera: &CameraSnapshot, point: DVec3) -> [u32; 2] {
    let p = camera.world_from_view.inverse().transform_point3(point);
    let half_tan = (0.8_f64 * 0.5).tan();
    let place = |ndc: f64, size: u32| ((ndc * 0.5 + 0.5) * f64::from(size)).floor() as u32;
    [place(p.x / (-p.z * half_tan), SIZE_PX[0]), place(-p.y / (-p.z * half_tan), SIZE_PX[1])]
}

fn assert_near(value: f32, expected: f32, relative: f32, what: &str) {
    let off = (value - expected).abs() / expected.abs();
    assert!(off <= relative, "{what}: {value}, expected {expected} within {relative}");
}

#[test]
fn full_shadow_is_black_and_its_neighbour_is_not() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for light in
        [Light::point("lamp", 100.0), Light::directional("sun", 3.0), Light::spot("cone", 100.0, 0.9)]
    {
        let name = light.name.clone();
        let mut scene = floor_of(matt(0.8));
        let roof = shadowgraph_testing::mesh(cuboid(Vec3::new(-1.0, 2.0, -1.0), Vec3::new(1.0, 2.2, 1.0)));
        scene.add_mesh(roof, matt(0.8), DAffine3::IDENTITY);
        scene.add_light(light, DVec3::new(0.0, 6.0, 0.0), DVec3::ZERO);
        scene.add_shadow("shadows", ShadowVolumeHard::default());
        let camera = camera(DVec3::new(0.0, 1.5, 9.0), DVec3::new(0.0, 0.5, 0.0));
        let picture = radiance(&mut renderer, &scene, &camera);
        for point in [DVec3::ZERO, DVec3::new(0.6, 0.0, 0.5), DVec3::new(-0.8, 0.0, -0.8)] {
            let dark = at(&picture, pixel_of(&camera, point));
            assert_eq!(dark, Vec3::ZERO, "{name}: {point} is in shadow");
        }
        let lit = at(&picture, pixel_of(&camera, DVec3::new(2.5, 0.0, 0.0)));
        assert!(lit.min_element() > 0.1, "{name}: {lit} is lit");
    }
}

#[test]
fn a_matt_floor_has_lambert_radiance_under_the_sun() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for degrees in [0.0_f64, 30.0, 60.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let mut scene = floor_of(matt(0.5));
        scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(sin, -cos, 0.0));
        let value = at(&radiance(&mut renderer, &scene, &from_above()), MIDDLE);
        // The eye looks along the normal. What a rough dielectric mirrors is added by the model's own formulae:
        // GGX with α = 1 is 1/π, and its shadowing term, written as visibility, is 1/(2 (n·l + n·v)).
        let (n_l, v_h) = (cos as f32, (degrees.to_radians() * 0.5).cos() as f32);
        let fresnel = 0.04 + 0.96 * (1.0 - v_h).powi(5);
        let lambert = (1.0 - fresnel) * 0.5 / PI;
        let mirrored = fresnel / PI * 0.5 / (n_l + 1.0);
        let expected = 3.0 * n_l * (lambert + mirrored);
        assert_near(value.x, expected, 0.01, &format!("sun at {degrees} degrees"));
        assert_near(value.x, 3.0 * n_l * 0.5 / PI, 0.05, &format!("plain Lambert at {degrees} degrees"));
        assert!(value.x == value.y && value.y == value.z, "a grey floor under a white sun is grey: {value}");
    }
}

#[test]
fn point_light_falls_off_with_the_square_of_the_distance() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    // On the axis of view, light and eye are on one ray and the angles the same at every distance.
    let mut value_at = |height_m: f64| {
        let mut scene = floor_of(matt(0.5));
        scene.add_light(Light::point("lamp", 100.0), DVec3::new(0.0, height_m, 0.0), DVec3::ZERO);
        at(&radiance(&mut renderer, &scene, &from_above()), MIDDLE).x
    };
    let near = value_at(1.0);
    assert_near(near, 100.0 * (0.96 * 0.5 + 0.04 * 0.25) / PI, 0.01, "100 cd from 1 m");
    for height_m in [2.0_f64, 4.0, 8.0] {
        let expected = near / (height_m * height_m) as f32;
        assert_near(value_at(height_m), expected, 1e-3, &format!("lamp {height_m} m up"));
    }
}

#[test]
fn light_ends_at_its_range() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let camera = from_above();
    let (height_m, range_m) = (1.0_f64, 3.0_f64);
    let mut picture = |range: Option<f64>| {
        let mut scene = floor_of(matt(0.5));
        let lamp = Light { range_m: range, ..Light::point("lamp", 100.0) };
        scene.add_light(lamp, DVec3::new(0.0, height_m, 0.0), DVec3::ZERO);
        radiance(&mut renderer, &scene, &camera)
    };
    let (ended, endless) = (picture(Some(range_m)), picture(None));
    let mut last_window = 1.0;
    for x in [0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 2.75] {
        let [ended, endless] =
            [&ended, &endless].map(|p| at(p, pixel_of(&camera, DVec3::new(x, 0.0, 0.0))).x);
        let window = ended / endless;
        assert!(window > 0.0 && window < last_window, "{x} m aside: window {window} after {last_window}");
        // Where the pixel's centre lies is known to half a pixel, 3 cm.
        let [near, far] = [x + 0.035, (x - 0.035).max(0.0)].map(|x| {
            let reach = (x * x + height_m * height_m) / (range_m * range_m);
            (1.0 - reach * reach).max(0.0).powi(2) as f32
        });
        assert!(window > near * 0.999 && window < far * 1.001, "{x} m aside: {window} not in {near}..{far}");
        last_window = window;
    }
    for x in [2.95, 3.5, 3.9] {
        let [ended, endless] = [&ended, &endless].map(|p| at(p, pixel_of(&camera, DVec3::new(x, 0.0, 0.0))));
        assert!(ended == Vec3::ZERO && endless.x > 0.0, "{x} m aside is beyond the range: {ended}");
    }
}

#[test]
fn spot_shines_within_its_cone_only() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let camera = from_above();
    let (inner_rad, outer_rad) = (0.3_f64, 0.6_f64);
    let mut picture = |kind: LightKind| {
        let mut scene = floor_of(matt(0.5));
        let lamp = Light { kind, ..Light::point("lamp", 100.0) };
        scene.add_light(lamp, DVec3::new(0.0, 4.0, 0.0), DVec3::ZERO);
        radiance(&mut renderer, &scene, &camera)
    };
    let cone = picture(LightKind::Spot { inner_rad, outer_rad });
    let bare = picture(LightKind::Point);
    let share = |angle_rad: f64| {
        let pixel = pixel_of(&camera, DVec3::new(4.0 * angle_rad.tan(), 0.0, 0.0));
        at(&cone, pixel).x / at(&bare, pixel).x
    };
    for angle_rad in [0.0, 0.1, 0.2, 0.28] {
        assert_near(share(angle_rad), 1.0, 1e-4, &format!("{angle_rad} rad, within the inner cone"));
    }
    for angle_rad in [0.35, 0.4, 0.45, 0.5, 0.55_f64] {
        // Where the pixel's centre lies is known to half a pixel, 3.5 cm of 4 m.
        let [low, high] = [0.035, -0.035].map(|aside_m| {
            let cos = (angle_rad.tan() + aside_m / 4.0).atan().cos();
            let cone = (cos - outer_rad.cos()) / (inner_rad.cos() - outer_rad.cos());
            cone.clamp(0.0, 1.0).powi(2) as f32
        });
        let share = share(angle_rad);
        assert!(share > low * 0.999 && share < high * 1.001, "{angle_rad} rad: {share} not in {low}..{high}");
    }
    for angle_rad in [0.63, 0.7, 0.75] {
        assert_eq!(share(angle_rad), 0.0, "{angle_rad} rad, outside the cone");
    }
}

#[test]
fn metal_and_roughness_are_ordered() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    // In the mirror direction of the sun, and far off it.
    let mut value = |metallic: f32, roughness: f32, sun: DVec3| {
        let red = Material { metallic, roughness, ..Material::matt("red", Vec3::new(0.8, 0.1, 0.1)) };
        let mut scene = floor_of(red);
        scene.add_light(Light::directional("sun", 1.0), DVec3::ZERO, sun);
        let camera = camera(DVec3::new(0.0, 5.0, 5.0), DVec3::ZERO);
        at(&radiance(&mut renderer, &scene, &camera), MIDDLE)
    };
    let (mirrored, aside) = (DVec3::new(0.0, -1.0, 1.0), DVec3::new(1.0, -1.0, -0.5));
    let roughnesses = [0.2, 0.4, 0.6, 0.8, 1.0];
    for metallic in [0.0, 1.0] {
        let peaks = roughnesses.map(|roughness| value(metallic, roughness, mirrored).x);
        assert!(peaks.windows(2).all(|p| p[0] > p[1]), "metallic {metallic}: rougher is duller: {peaks:?}");
    }
    let off = [0.2, 0.6].map(|roughness| value(1.0, roughness, aside).x);
    assert!(off[0] < off[1], "off the mirror direction rough metal is brighter: {off:?}");
    let dull = value(0.0, 0.2, aside);
    assert!(dull.x > 10.0 * off[0], "a dielectric scatters where smooth metal does not: {dull}, {off:?}");
    // Metal tints what it mirrors, a dielectric does not.
    let [metal, plastic] = [1.0, 0.0].map(|metallic| value(metallic, 0.2, mirrored));
    assert!(metal.x > 4.0 * metal.y, "a red metal's highlight is red: {metal}");
    assert!(plastic.x < 2.0 * plastic.y, "a red plastic's highlight is all but white: {plastic}");
    assert!(metal.x > 5.0 * plastic.x, "metal mirrors more than plastic: {metal}, {plastic}");
}

#[test]
fn unlit_surfaces_are_their_colour() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let color = Vec3::new(0.7, 0.2, 0.05);
    let mut scene = floor_of(Material { unlit: true, ..Material::matt("unlit", color) });
    let roof = shadowgraph_testing::mesh(cuboid(Vec3::new(-1.0, 12.0, -1.0), Vec3::new(1.0, 12.5, 1.0)));
    scene.add_mesh(roof, matt(0.8), DAffine3::IDENTITY);
    let picture = radiance(&mut renderer, &scene, &from_above());
    assert_eq!(at(&picture, MIDDLE), color, "without any light");
    scene.add_light(Light::directional("sun", 9.0), DVec3::ZERO, DVec3::NEG_Y);
    scene.add_shadow("shadows", ShadowVolumeHard::default());
    let picture = radiance(&mut renderer, &scene, &from_above());
    assert!(picture.iter().all(|value| *value == color), "under a sun and a shadow");
}

#[test]
fn srgb_pictures_hold_the_right_bytes() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let encoded = |linear: f32| 255.0 * (1.055 * linear.powf(1.0 / 2.4) - 0.055);
    for grey in [0.05_f32, 0.214, 0.5, 0.9] {
        let scene = floor_of(Material { unlit: true, ..Material::matt("grey", Vec3::splat(grey)) });
        let texel = at(&srgb(&mut renderer, &scene, &from_above()), MIDDLE);
        let right = texel[..3].iter().all(|byte| (f32::from(*byte) - encoded(grey)).abs() <= 1.0);
        assert!(right && texel[3] == 255, "{texel:?} for grey {grey}, which is {}", encoded(grey));
    }
}

#[test]
fn the_background_is_the_scenes() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = floor_of(matt(0.5));
    let color = Vec3::new(0.25, 0.5, 0.125);
    scene.set_background(color);
    scene.add_light(Light::directional("sun", 1.0), DVec3::ZERO, DVec3::NEG_Y);
    // The horizon runs through the middle: sky above, floor below.
    let level = camera(DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.0, 2.0, -1.0));
    let picture = radiance(&mut renderer, &scene, &level);
    assert_eq!(at(&picture, [64, 3]), color);
    assert_ne!(at(&picture, [64, 125]), color);
    let texel = at(&srgb(&mut renderer, &scene, &level), [64, 3]);
    let encoded = color.to_array().map(|c| 255.0 * (1.055 * c.powf(1.0 / 2.4) - 0.055));
    for (byte, encoded) in texel.into_iter().zip(encoded) {
        assert!((f32::from(byte) - encoded).abs() <= 1.0, "{texel:?} for {color}");
    }
}

#[test]
fn alpha_masks_have_holes() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = floor_of(Material { unlit: true, ..Material::matt("floor", Vec3::X) });
    // Left half there, right half a hole; the texture runs from x = −2 to x = 2.
    let rgba8 = (0..64 * 64).flat_map(|i| [255, 255, 255, if i % 64 < 32 { 255 } else { 0 }]).collect();
    let image = Image { name: "half".into(), width: 64, height: 64, rgba8 };
    let texture = TextureRef { smooth: false, ..TextureRef::new(scene.add_image(Arc::new(image))) };
    let leaf = Material {
        base_color: Vec4::new(0.0, 1.0, 0.0, 1.0),
        base_color_texture: Some(texture),
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        unlit: true,
        ..Material::default()
    };
    let v = Vec3::new;
    let card = quad([v(-2.0, 1.0, 2.0), v(2.0, 1.0, 2.0), v(2.0, 1.0, -2.0), v(-2.0, 1.0, -2.0)]);
    scene.add_mesh(shadowgraph_testing::mesh(card), leaf, DAffine3::IDENTITY);
    let camera = from_above();
    let picture = radiance(&mut renderer, &scene, &camera);
    for (x, expected) in [(-1.8, Vec3::Y), (-0.3, Vec3::Y), (0.3, Vec3::X), (1.8, Vec3::X), (3.0, Vec3::X)] {
        let seen = at(&picture, pixel_of(&camera, DVec3::new(x, 1.0, 0.5)));
        assert_eq!(seen, expected, "at x {x}");
    }
}
