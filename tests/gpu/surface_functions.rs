//! Surfaces that reflect light by WGSL of their own: they get each light's factor, and nothing else changes.

use std::sync::Arc;

use glam::{Vec2, Vec4};
use shadowgraph::engine::geometry::shapes::plane;
use shadowgraph::engine::render::FrameError;
use shadowgraph::engine::scene::{AlphaMode, Image, Instance, SurfaceFunctionError, TextureRef};
use shadowgraph::prelude::*;
use shadowgraph_testing::{at, quad, unit_box};

const SIZE_PX: [u32; 2] = [320, 180];

/// What the engine itself does with light.
const ORDINARY: &str = "fn reflected(surface: Surface, light: LightArriving) -> vec3f {
    return light.factor * light.irradiance * reflect_light(surface, light.towards_in_view);
}";
/// The factor, and nothing but.
const FACTOR: &str = "fn reflected(surface: Surface, light: LightArriving) -> vec3f { return light.factor; }
fn outgoing(surface: Surface, lights: vec3f, ambient: vec3f, emitted: vec3f) -> vec3f { return lights; }";

fn function(name: &str, wgsl: &str) -> Option<Arc<SurfaceFunction>> {
    Some(Arc::new(SurfaceFunction::new(name, wgsl).unwrap()))
}

fn frame(
    renderer: &mut Renderer,
    scene: &Scene,
    request: &FrameRequest,
) -> shadowgraph::engine::render::Frame {
    let exposure = Exposure::Fixed(1.0);
    let options = RenderOptions { exposure, read_picture: true, ..RenderOptions::default() };
    renderer.render(scene, request, &options).unwrap()
}

fn values(renderer: &mut Renderer, scene: &Scene, request: &FrameRequest) -> Vec<f32> {
    // Not every adapter has four samples of 32-bit floats.
    if request.antialias == Antialias::Multisample4 {
        let bytes = frame(renderer, scene, request).picture.unwrap().bytes;
        return bytes.into_iter().map(|byte| f32::from(byte) / 255.0).collect();
    }
    let request = FrameRequest { picture: PictureFormat::LinearF32, ..request.clone() };
    frame(renderer, scene, &request).picture.unwrap().floats().unwrap()
}

fn request() -> FrameRequest {
    let camera = Camera::perspective("eye", 0.6);
    FrameRequest::new(
        CameraSnapshot::looking(camera, DVec3::new(2.5, 3.0, 5.0), DVec3::new(0.0, 0.4, 0.0)),
        SIZE_PX,
    )
}

/// Every kind of material on a floor, all of which reflect by `surface`.
fn yard(surface: Option<&Arc<SurfaceFunction>>, lights: usize, shadows: ShadowVolumeHard) -> Scene {
    let mut scene = Scene::new();
    scene.set_ambient(Vec3::splat(0.2));
    let image =
        Image { name: "texels".into(), width: 2, height: 1, rgba8: vec![255, 128, 40, 255, 90, 200, 255, 0] };
    let texture = TextureRef::new(scene.add_image(Arc::new(image)));
    let own = |material: Material| Material { surface: surface.cloned(), ..material };
    let matt = |name, color| own(Material::matt(name, color));
    let masked = Material {
        alpha_mode: AlphaMode::Mask { cutoff: 0.5 },
        base_color_texture: Some(texture),
        ..matt("masked", Vec3::ONE)
    };
    let glass = Material {
        alpha_mode: AlphaMode::Blend,
        base_color: Vec4::new(0.2, 0.9, 0.4, 0.4),
        ..matt("glass", Vec3::ONE)
    };
    let mut painted = plane(Vec2::splat(0.5));
    painted.colors = vec![
        Vec4::new(1.0, 0.2, 0.2, 1.0),
        Vec4::new(0.2, 1.0, 0.2, 1.0),
        Vec4::new(0.2, 0.2, 1.0, 1.0),
        Vec4::ONE,
    ];
    let metal =
        Material { metallic: 0.8, roughness: 0.35, emissive: Vec3::splat(0.05), ..matt("metal", Vec3::ONE) };
    scene.add_mesh(quad("floor", 6.0), matt("floor", Vec3::splat(0.7)), DAffine3::IDENTITY);
    scene.add_mesh(unit_box("box"), metal, at(-0.8, 0.9, 0.0) * DAffine3::from_rotation_y(0.4));
    scene.add_mesh(shadowgraph_testing::mesh(painted), matt("painted", Vec3::ONE), at(0.9, 0.5, 0.3));
    // Masks are no counts.
    if shadows.passes == Passes::Multi {
        scene.add_mesh(
            shadowgraph_testing::mesh(plane(Vec2::splat(0.5)).named("masked")),
            masked,
            at(0.2, 0.7, 1.0),
        );
    }
    scene.add_mesh(
        shadowgraph_testing::mesh(plane(Vec2::splat(0.4)).named("glass")),
        glass,
        at(-0.4, 1.8, 1.0),
    );
    for (index, place) in
        [DVec3::new(-2.0, 5.0, 2.0), DVec3::new(3.0, 4.0, 1.0)].into_iter().take(lights).enumerate()
    {
        scene.add_light(Light::point(&format!("lamp{index}"), 30.0), place, DVec3::ZERO);
    }
    scene.add_shadow("shadows", shadows);
    scene
}

fn remove(scene: &mut Scene, name: &str) {
    let is_it = |node: &&Instance| node.name == name;
    let node = scene.snapshot().unwrap().instances.iter().find(is_it).unwrap().node;
    scene.remove(node).unwrap();
}

#[test]
fn the_ordinary_reflection_written_out_is_the_ordinary_picture() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let ordinary = function("ordinary", ORDINARY);
    let single = ShadowVolumeHard { passes: Passes::Single, weight: 0.5, ..ShadowVolumeHard::default() };
    for antialias in [Antialias::None, Antialias::Multisample4, Antialias::Supersample4] {
        for (lights, shadows) in
            [(1, ShadowVolumeHard::default()), (2, ShadowVolumeHard::default()), (2, single)]
        {
            let what = format!("{antialias} {lights} {shadows:?}");
            let request = FrameRequest { antialias, ..request() };
            if shadows == single && antialias != Antialias::None {
                continue;
            }
            let [with, without] = [ordinary.as_ref(), None].map(|surface| {
                let mut scene = yard(surface, lights, shadows);
                if antialias == Antialias::Multisample4 {
                    // Nor are masks, as casters, known for every sample.
                    remove(&mut scene, "masked");
                }
                values(&mut renderer, &scene, &request)
            });
            assert!(without.iter().any(|value| *value > 0.3), "{what}: nothing is lit");
            let off = with.iter().zip(&without).map(|(a, b)| (a - b).abs() / b.max(0.1)).fold(0.0, f32::max);
            assert!(off < 1e-5, "{what}: off by {off}");
        }
    }
}

#[test]
fn the_factor_it_gets_is_the_one_that_is_measured() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let factor = function("factor", FACTOR);
    for lights in [1, 2] {
        let shadows = ShadowVolumeHard::default;
        let mut scene = yard(factor.as_ref(), lights, shadows());
        // Blended surfaces have no factor of their own.
        remove(&mut scene, "glass");
        let request = FrameRequest { factors: true, picture: PictureFormat::LinearF32, ..request() };
        let frame = frame(&mut renderer, &scene, &request);
        let picture = frame.picture.unwrap().floats().unwrap();
        let factors: Vec<_> = frame.factors.iter().map(|image| image.pixels.floats().unwrap()).collect();
        assert_eq!(factors.len(), lights);
        let (mut dark, mut compared, mut off) = (0, 0, 0);
        for (pixel, [instance, _]) in frame.visible_triangles.unwrap().into_iter().enumerate() {
            if instance == u32::MAX {
                continue;
            }
            let expected: f32 = factors.iter().map(|factor| factor[pixel]).sum();
            dark += usize::from(expected == 0.0);
            compared += 1;
            off += usize::from(picture[pixel * 4] != expected);
        }
        assert!(compared > 20_000 && dark > 300, "{compared} compared, {dark} dark");
        assert_eq!(off, 0, "of {compared} pixels with {lights} lights");
    }
}

#[test]
fn factors_are_those_of_the_scene_without_it() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let factor = function("factor", FACTOR);
    let request = FrameRequest { factors: true, ..request() };
    let with = frame(&mut renderer, &yard(factor.as_ref(), 2, ShadowVolumeHard::default()), &request);
    let without = frame(&mut renderer, &yard(None, 2, ShadowVolumeHard::default()), &request);
    assert_eq!(with.factors, without.factors);
    assert_eq!(with.visible_triangles, without.visible_triangles);
    assert_ne!(with.picture, without.picture);
}

#[test]
fn ink_is_where_the_shadow_is_and_the_rest_is_as_ever() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let size_px = [960, 540];
    let request = FrameRequest { factors: true, ..FrameRequest::new(crate::own_surface::camera(), size_px) };
    let hatched = crate::own_surface::scene(function("hatching", crate::own_surface::HATCHING)).unwrap();
    let with = frame(&mut renderer, &hatched, &request);
    let without = frame(&mut renderer, &crate::own_surface::scene(None).unwrap(), &request);
    let (with_px, without_px) = (with.picture.unwrap().bytes, without.picture.unwrap().bytes);
    let factor = with.factors[0].pixels.floats().unwrap();
    let (mut shadow, mut light, mut ordinary) = ([0; 2], [0; 2], 0);
    for (pixel, [instance, _]) in with.visible_triangles.unwrap().into_iter().enumerate() {
        let texel = pixel * 4..pixel * 4 + 4;
        let is_ink = usize::from(with_px[texel.clone()][1] < 120);
        match instance {
            0 if factor[pixel] == 0.0 => shadow[is_ink] += 1,
            0 => light[is_ink] += 1,
            1 | 2 => {}
            // The ball, and the sky.
            _ => {
                assert_eq!(with_px[texel.clone()], without_px[texel], "pixel {pixel}");
                ordinary += 1;
            }
        }
    }
    let share = |[paper, ink]: [usize; 2]| ink as f64 / (paper + ink) as f64;
    assert!(shadow[1] > 5_000 && (0.4..0.8).contains(&share(shadow)), "paper and ink in shadow: {shadow:?}");
    assert!(light[0] > 100_000 && light[1] == 0, "paper and ink in light: {light:?}");
    assert!(ordinary > 3_000, "{ordinary} pixels of the ball");
}

#[test]
fn one_bad_material_refuses_the_frame() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let bad = Arc::new(SurfaceFunction::unchecked("bad", "\nfn reflected(surface: Surface"));
    let mut scene = yard(None, 1, ShadowVolumeHard::default());
    let paper = Material { surface: Some(bad), ..Material::matt("paper", Vec3::ONE) };
    // Out of sight.
    scene.add_mesh(quad("page", 1.0), paper.clone(), at(0.0, 0.0, 500.0));
    let error = renderer.render(&scene, &request(), &RenderOptions::default()).unwrap_err();
    let RenderError::Frame(FrameError::SurfaceFunction { material, source }) = &error else {
        panic!("{error}")
    };
    assert!(matches!(source, SurfaceFunctionError::Wgsl { line: 2, .. }), "{error}");
    assert_eq!(material, "paper");
    let text = error.to_string();
    assert!(text.contains("'paper'") && text.contains("'bad'") && text.contains("line 2"), "{text}");

    let mut scene = yard(None, 1, ShadowVolumeHard::default());
    let unlit = Material { unlit: true, surface: function("factor", FACTOR), ..paper };
    scene.add_mesh(quad("page", 1.0), unlit, DAffine3::IDENTITY);
    let error = renderer.render(&scene, &request(), &RenderOptions::default()).unwrap_err();
    assert!(matches!(&error, RenderError::Frame(FrameError::UnlitFunction { .. })), "{error}");
    assert!(error.to_string().contains("'paper'") && error.to_string().contains("'factor'"));
}

#[test]
fn plans_name_them() {
    let ordinary = function("ordinary", ORDINARY);
    let text = |shadows| {
        let scene = yard(ordinary.as_ref(), 1, shadows);
        shadowgraph_testing::plan(&scene, &request()).to_string()
    };
    let plain = text(ShadowVolumeHard::default());
    assert!(plain.contains("the only light; 5 parts reflect by their own 'ordinary'"), "{plain}");
    assert!(!plain.contains("surface functions see"), "{plain}");
    let single =
        text(ShadowVolumeHard { passes: Passes::Single, weight: 0.5, ..ShadowVolumeHard::default() });
    assert!(single.contains("surface functions see light 'lamp0' unshadowed"), "{single}");
}
