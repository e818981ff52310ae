//! What each part of a material does to the picture, against values worked out by hand.

use std::sync::Arc;

use glam::{Vec2, Vec4};
use shadowgraph::engine::geometry::shapes::{plane, quad};
use shadowgraph::engine::scene::{AlphaMode, Image, TexCoord, TextureRef, UvTransform};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [33, 33];
const MIDDLE: usize = 16 * 33 + 16;

/// A floor of 2 m whose u runs along +x and v along +z, seen from above with −z up; nothing lights it yet.
struct Floor {
    scene: Scene,
    data: MeshData,
    material: Material,
}

impl Floor {
    fn new() -> Self {
        let mut scene = Scene::new();
        scene.set_ambient(Vec3::ZERO);
        scene.set_background(Vec3::ZERO);
        let material = Material { roughness: 1.0, ..Material::matt("floor", Vec3::splat(0.5)) };
        Self { scene, data: plane(Vec2::ONE), material }
    }

    /// A texture of one colour, or of several side by side.
    fn texture(&mut self, texels: &[[u8; 4]]) -> TextureRef {
        let (width, rgba8) = (texels.len() as u32, texels.concat());
        let image = Image { name: "texels".into(), width, height: 1, rgba8 };
        TextureRef { smooth: false, ..TextureRef::new(self.scene.add_image(Arc::new(image))) }
    }

    fn sun(mut self, travels: DVec3) -> Self {
        self.scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, travels);
        self
    }

    /// Linear radiance in the middle of the picture.
    fn radiance(mut self, renderer: &mut Renderer) -> Vec3 {
        self.scene.add_mesh(shadowgraph_testing::mesh(self.data), self.material, DAffine3::IDENTITY);
        let camera = Camera::perspective("eye", 0.3);
        let camera = CameraSnapshot::looking(camera, DVec3::new(0.0, 4.0, 0.0), DVec3::ZERO);
        let mut request = FrameRequest::new(camera, SIZE_PX);
        request.picture = PictureFormat::LinearF32;
        let exposure = Exposure::Fixed(1.0);
        let options = RenderOptions { exposure, read_picture: true, ..RenderOptions::default() };
        let frame = renderer.render(&self.scene, &request, &options).unwrap();
        let floats = frame.picture.unwrap().floats().unwrap();
        Vec3::from_slice(&floats[MIDDLE * 4..])
    }
}

fn assert_near(value: Vec3, expected: Vec3, what: &str) {
    let off = (value - expected).abs().max_element();
    // Software adapters decode sRGB by a polynomial that is good to 0.4 %.
    assert!(off <= 5e-3 * expected.max_element().max(0.05), "{what}: {value}, expected {expected}");
}

/// sRGB to linear.
fn linear(byte: u8) -> f32 {
    let v = f32::from(byte) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

#[test]
fn normal_maps_are_the_right_way_round() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    // Tilted by 45° along +u, and up the picture (against v).
    let (along_u, up) = ([218, 128, 218, 255], [128, 218, 218, 255]);
    let mut lit_by = |texel, scale: f32, travels: DVec3| {
        let mut floor = Floor::new();
        floor.material.normal_texture = Some((floor.texture(&[texel]), scale));
        floor.sun(travels).radiance(&mut renderer).x
    };
    for (texel, towards) in [(along_u, DVec3::X), (up, DVec3::NEG_Z)] {
        let facing = lit_by(texel, 1.0, -(towards + DVec3::Y));
        let away = lit_by(texel, 1.0, towards - DVec3::Y);
        assert!(facing > 0.2 && away < 0.02 * facing, "{towards}: {facing} towards, {away} away");
        // Scaled to nothing the floor is flat again, and both lights are the same.
        let (flat_facing, flat_away) =
            (lit_by(texel, 0.0, -(towards + DVec3::Y)), lit_by(texel, 0.0, towards - DVec3::Y));
        assert!((flat_facing - flat_away).abs() < 0.02 * flat_facing, "{flat_facing} and {flat_away}");
        assert!(flat_facing < 0.9 * facing);
    }
}

#[test]
fn emission_is_factor_times_texture_and_needs_no_light() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut floor = Floor::new();
    // A strength of 4 comes as a factor above 1.
    floor.material.emissive = Vec3::new(4.0, 1.0, 0.5);
    let texture = floor.texture(&[[128, 255, 0, 255]]);
    floor.material.emissive_texture = Some(texture);
    let expected = Vec3::new(4.0 * linear(128), 1.0, 0.0);
    assert_near(floor.radiance(&mut renderer), expected, "emission");
}

#[test]
fn texture_transforms_and_second_coordinates_choose_the_texel() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let texels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]];
    let mut seen = |uv: Vec2, second: Vec2, tex_coord, transform| {
        let mut floor = Floor::new();
        floor.material.emissive = Vec3::ONE;
        floor.data.uvs = vec![uv; 4];
        floor.data.second_uvs = vec![second; 4];
        let texture = TextureRef { tex_coord, transform, ..floor.texture(&texels) };
        floor.material.emissive_texture = Some(texture);
        floor.radiance(&mut renderer)
    };
    let (first, third) = (Vec2::new(0.1, 0.5), Vec2::new(0.6, 0.5));
    let plain = UvTransform::default();
    assert_near(seen(first, third, TexCoord::First, plain), Vec3::X, "first coordinates");
    assert_near(seen(first, third, TexCoord::Second, plain), Vec3::Z, "second coordinates");
    let shifted = UvTransform { offset: Vec2::new(0.25, 0.0), ..plain };
    assert_near(seen(first, third, TexCoord::First, shifted), Vec3::Y, "offset");
    let scaled = UvTransform { scale: Vec2::new(0.5, 1.0), ..plain };
    assert_near(seen(first, third, TexCoord::Second, scaled), Vec3::Y, "scale");
    // A quarter turn takes v to u.
    let turned = UvTransform { rotation_rad: std::f32::consts::FRAC_PI_2, ..plain };
    assert_near(seen(Vec2::new(0.1, 0.6), third, TexCoord::First, turned), Vec3::Z, "rotation");
}

#[test]
fn occlusion_dims_ambient_light_by_its_strength_and_no_other() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut lit = |occluded: bool, ambient: f32| {
        let mut floor = Floor::new();
        floor.scene.set_ambient(Vec3::splat(ambient));
        // Red counts; it lies on the second coordinates, as baked occlusion often does.
        floor.data.second_uvs = vec![Vec2::new(0.75, 0.5); 4];
        let texture = floor.texture(&[[255, 0, 0, 255], [51, 255, 255, 255]]);
        let texture = TextureRef { tex_coord: TexCoord::Second, ..texture };
        floor.material.occlusion_texture = occluded.then_some((texture, 0.5));
        if ambient == 0.0 {
            floor = floor.sun(DVec3::NEG_Y);
        }
        floor.radiance(&mut renderer)
    };
    // 1 + 0.5·(0.2 − 1)
    assert_near(lit(true, 1.0), lit(false, 1.0) * 0.6, "ambient");
    assert_near(lit(true, 0.0), lit(false, 0.0), "sun");
}

#[test]
fn roughness_is_green_and_metallic_blue() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut lit = |texel: Option<[u8; 4]>, metallic: f32, roughness: f32| {
        let mut floor = Floor::new();
        floor.material = Material { metallic, roughness, ..floor.material };
        let texture = texel.map(|texel| floor.texture(&[texel]));
        floor.material.metallic_roughness_texture = texture;
        floor.sun(DVec3::new(0.4, -1.0, 0.2)).radiance(&mut renderer)
    };
    let (green, blue) = (102.0 / 255.0, 204.0 / 255.0);
    let textured = lit(Some([255, 102, 204, 255]), 1.0, 1.0);
    assert_near(textured, lit(None, blue, green), "factors of 1");
    assert_near(lit(Some([255, 102, 204, 255]), 0.5, 0.5), lit(None, blue * 0.5, green * 0.5), "halves");
    assert!((textured - lit(None, green, blue)).abs().max_element() > 1e-2, "the channels differ");
}

#[test]
fn blended_surfaces_let_the_rest_through() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut floor = Floor::new();
    floor.material = Material { unlit: true, ..Material::matt("floor", Vec3::X) };
    let pane = Material {
        base_color: Vec4::new(0.0, 1.0, 0.0, 0.25),
        alpha_mode: AlphaMode::Blend,
        unlit: true,
        ..Material::default()
    };
    let over = DAffine3::from_translation(DVec3::Y);
    floor.scene.add_mesh(shadowgraph_testing::mesh(plane(Vec2::ONE)), pane, over);
    assert_near(floor.radiance(&mut renderer), Vec3::new(0.75, 0.25, 0.0), "a quarter of the pane");
}

#[test]
fn single_sided_surfaces_are_not_seen_from_behind() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let v = Vec3::new;
    for (double_sided, mirrored, expected) in
        [(true, false, Vec3::Y), (false, false, Vec3::X), (false, true, Vec3::X)]
    {
        let mut floor = Floor::new();
        floor.material = Material { unlit: true, ..Material::matt("floor", Vec3::X) };
        // Facing down, and still facing down in a mirror.
        let card = quad([v(-1.0, 1.0, -1.0), v(1.0, 1.0, -1.0), v(1.0, 1.0, 1.0), v(-1.0, 1.0, 1.0)]);
        let material = Material { unlit: true, double_sided, ..Material::matt("card", Vec3::Y) };
        let place = DAffine3::from_scale(DVec3::new(if mirrored { -1.0 } else { 1.0 }, 1.0, 1.0));
        floor.scene.add_mesh(shadowgraph_testing::mesh(card), material, place);
        assert_near(floor.radiance(&mut renderer), expected, &format!("{double_sided} {mirrored}"));
    }
}

#[test]
fn unlit_surfaces_have_their_colour_whatever_the_light() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for light in [DVec3::NEG_Y, DVec3::Y] {
        let mut floor = Floor::new();
        floor.scene.set_ambient(Vec3::splat(0.3));
        let texture = floor.texture(&[[128, 64, 255, 255]]);
        floor.material.unlit = true;
        floor.material.base_color = Vec4::new(1.0, 0.5, 0.25, 1.0);
        floor.material.base_color_texture = Some(texture);
        let expected = Vec3::new(linear(128), 0.5 * linear(64), 0.25);
        assert_near(floor.sun(light).radiance(&mut renderer), expected, "unlit");
    }
}
