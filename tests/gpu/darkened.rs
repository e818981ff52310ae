//! What `weight`, `color` and `apply` of the soft nodes do to pictures: every value of a linear picture is what the factors, the
//! pictures of each light alone and the option say. That the engine does so for any technique is in `tints`; here the nodes'
//! own options are.

use shadowgraph::prelude::*;

/// A floor, a crate over it, and two lamps of which only some shine, without ambient light.
fn yard(shines: [bool; 2]) -> Scene {
    let mut scene = shadowgraph_testing::with_floor();
    scene.set_ambient(Vec3::ZERO);
    scene.set_background(Vec3::splat(0.25));
    shadowgraph_testing::add_box(&mut scene, "crate", shadowgraph_testing::at(0.0, 1.5, 0.0));
    for (lamp, (candela, place)) in
        [(90.0, DVec3::new(1.0, 6.0, 2.0)), (50.0, DVec3::new(-2.5, 5.0, 1.0))].into_iter().enumerate()
    {
        let candela = if shines[lamp] { candela } else { 0.0 };
        scene.add_light(Light::point(&format!("lamp {lamp}"), candela), place, DVec3::ZERO);
    }
    scene
}

const SIZE_PX: [u32; 2] = [96, 72];

fn request() -> FrameRequest {
    let camera = shadowgraph_testing::camera(DVec3::new(3.0, 5.0, 6.0), DVec3::new(0.0, 0.3, 0.0));
    FrameRequest { picture: PictureFormat::LinearF32, factors: true, ..FrameRequest::new(camera, SIZE_PX) }
}

/// The linear picture, four floats a pixel, and the factor of each lamp.
fn render(renderer: &mut Renderer, scene: &Scene) -> (Vec<f32>, Vec<Vec<f32>>) {
    let exposure = Exposure::Fixed(1.0);
    let options = RenderOptions { read_picture: true, exposure, ..RenderOptions::default() };
    let frame = renderer.render(scene, &request(), &options).unwrap();
    let factors = frame.factors.iter().map(|image| image.pixels.floats().unwrap()).collect();
    (frame.picture.unwrap().floats().unwrap(), factors)
}

/// How a node applies its factor.
#[derive(Clone, Copy, Debug)]
struct Applied {
    weight: f64,
    color: [f64; 3],
    to_picture: bool,
}

impl Applied {
    /// What is left of a light, or of the picture, in one channel.
    fn left(&self, factor: f32, channel: usize) -> f64 {
        1.0 - self.weight * (1.0 - f64::from(factor)) * (1.0 - self.color[channel])
    }
}

/// Both lamps under `node`: every value of the picture is as `applied` says, and would not be if that were ignored.
fn check(renderer: &mut Renderer, node: &ShadowNode, applied: Applied) {
    let plain = Applied { weight: 1.0, color: [0.0; 3], to_picture: false };
    let alone = [[true, false], [false, true]].map(|shines| render(renderer, &yard(shines)).0);
    let unlit = render(renderer, &yard([false, false])).0;
    let mut scene = yard([true, true]);
    let floor = scene.find("floor").unwrap();
    let receives = node.technique == "SoftShadow";
    let node = if receives { node.clone().with_receivers([floor]) } else { node.clone() };
    scene.add_shadow("shadows", node.clone());
    let (picture, factors) = render(renderer, &scene);
    let penumbra = factors.concat().iter().filter(|factor| (0.05..0.95).contains(*factor)).count();
    assert!(factors.len() == 2 && penumbra > 100, "{node:?}: {penumbra} pixels in penumbrae");
    let expected = |index: usize, applied: Applied| -> f64 {
        let (pixel, channel) = (index / 4, index % 4);
        let lamps = factors.iter().zip(&alone).map(|(factor, alone)| {
            let light = f64::from(alone[index] - unlit[index]);
            (light, applied.left(factor[pixel], channel))
        });
        let unlit = f64::from(unlit[index]);
        if applied.to_picture {
            let (light, left) =
                lamps.fold((unlit, 1.0), |(sum, all), (light, left)| (sum + light, all * left));
            light * left
        } else {
            lamps.fold(unlit, |sum, (light, left)| sum + light * left)
        }
    };
    let (mut worst, mut ignored) = (0.0_f64, 0);
    // Where a triangle is turned away from a lamp, a picture without nodes is dark whatever its normals; a node's horizon is weighed.
    let is_turned = |index: &usize| alone.iter().any(|alone| alone[*index] == unlit[*index]);
    let is_sky = |index: &usize| factors.iter().all(|factor| factor[index / 4] == 1.0);
    let values = picture.iter().enumerate().filter(|(index, _)| index % 4 < 3);
    for (index, value) in values.filter(|(index, _)| !is_turned(index) || is_sky(index)) {
        let right = expected(index, applied);
        worst = worst.max((f64::from(*value) - right).abs() / (right.abs() + 0.01));
        ignored += usize::from((expected(index, plain) - right).abs() > 0.02 * right.abs() + 0.01);
    }
    println!("{} {applied:?}: off by {worst:.1e}; {ignored} values would differ", node.technique);
    assert!(worst < 2e-3, "{node:?}: off by {worst}");
    assert!(ignored > 300, "{node:?}: only {ignored} values would differ if it were ignored");
}

#[test]
fn soft_shadows_darken_lights_or_the_picture_by_their_weight() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (quality, weight, apply) in [
        (Quality::Sampled, 0.7, Apply::PerPixel),
        (Quality::Sampled, 0.3, Apply::Darken),
        (Quality::Sampled, 0.8, Apply::Darken),
        (Quality::PerReceiver, 0.4, Apply::PerPixel),
        (Quality::PerReceiver, 0.6, Apply::Darken),
        (Quality::Wedge, 0.5, Apply::PerPixel),
        (Quality::Wedge, 0.6, Apply::Darken),
    ] {
        let samples = ShadowVolumeSoft::default().samples;
        let node = ShadowVolumeSoft { radius_m: 0.4, quality, samples, weight, apply, ..Default::default() };
        let applied = Applied { weight, color: [0.0; 3], to_picture: apply == Apply::Darken };
        check(&mut renderer, &ShadowNode::from(node), applied);
    }
}

#[test]
fn planar_shadows_have_weight_and_colour() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (mode, weight, color) in [
        (PlanarMode::Direct, 0.3, [0.0; 3]),
        (PlanarMode::Direct, 1.0, [0.6, 0.1, 0.0]),
        (PlanarMode::Direct, 0.75, [0.0, 0.2, 0.8]),
        (PlanarMode::Texture, 0.6, [0.0; 3]),
        (PlanarMode::Texture, 0.8, [0.3, 0.5, 0.1]),
    ] {
        let node = SoftShadow { radius_m: 0.4, mode, weight, color, ..SoftShadow::default() };
        check(&mut renderer, &ShadowNode::from(node), Applied { weight, color, to_picture: false });
    }
}
