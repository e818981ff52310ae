//! Silhouette maps: straight edges are exact whatever the resolution, corners and open edges too; what one point a texel cannot
//! say (004 Fig. 7); points in one byte; the same picture whatever the order of casters; and beside shadow maps, edges half as far
//! off at most.

use glam::{Vec2, Vec3};
use shadowgraph::engine::geometry::shapes::{cuboid, icosphere, plane};
use shadowgraph::measure::{LightError, evaluate};
use shadowgraph::prelude::*;
use shadowgraph_nodes::Show;

const SIZE_PX: [u32; 2] = [256, 192];

fn add(scene: &mut Scene, name: &str, data: MeshData) {
    let mesh = shadowgraph_testing::mesh(data.named(name));
    scene.add_mesh(mesh, Material::default(), DAffine3::IDENTITY);
}

fn block(center: Vec3, half: Vec3) -> MeshData {
    cuboid(center - half, center + half)
}

fn floor() -> Scene {
    let mut scene = Scene::new();
    add(&mut scene, "floor", plane(Vec2::splat(6.0)));
    scene
}

fn light(scene: &mut Scene, kind: &str) {
    let position = DVec3::new(2.0, 5.0, 1.5);
    match kind {
        "sun" => scene.add_light(Light::directional(kind, 3.0), DVec3::ZERO, -position),
        "lamp" => scene.add_light(Light::point(kind, 60.0), position, DVec3::ZERO),
        _ => scene.add_light(Light::spot(kind, 60.0, 0.6), position, DVec3::ZERO),
    };
}

/// The error of the one light, seen from above.
fn error(renderer: &mut Renderer, scene: &Scene, node: impl Into<ShadowNode>) -> LightError {
    let mut scene = scene.clone();
    scene.add_shadow("shadows", node);
    let camera = shadowgraph_testing::camera(DVec3::new(0.3, 4.5, 2.6), DVec3::new(-0.3, 0.2, 0.0));
    let request = FrameRequest::new(camera, SIZE_PX);
    evaluate(renderer, &scene, &request, &|_, _| {}).unwrap().errors.remove(0)
}

fn map(resolution: u32) -> ShadowMap {
    ShadowMap { resolution, pcf: 1, ..ShadowMap::default() }
}

fn silhouette(resolution: u32) -> SilhouetteMap {
    SilhouetteMap { resolution, ..SilhouetteMap::default() }
}

/// A box, a ball and an open sheet, several texels apart: at 128 texels a side not one pixel is wrong beyond the band, for all
/// kinds of lights, and the corners of outlines are where they are.
#[test]
fn outlines_apart_are_exact_at_few_texels() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = floor();
    add(&mut scene, "box", block(Vec3::new(-0.8, 0.9, 0.3), Vec3::new(0.4, 0.2, 0.3)));
    add(&mut scene, "sheet", plane(Vec2::new(0.5, 0.3)).moved(Vec3::new(0.6, 1.1, -0.5)));
    for kind in ["sun", "lamp", "spot"] {
        let mut scene = scene.clone();
        light(&mut scene, kind);
        let coarse = error(&mut renderer, &scene, map(128));
        let fine = error(&mut renderer, &scene, silhouette(128));
        println!("{kind}: {} wrong of a map, {} with silhouettes", coarse.wrong, fine.wrong_outside_band);
        assert!(coarse.wrong_outside_band > 8, "{kind}: {}", coarse.wrong_outside_band);
        assert_eq!(fine.wrong_outside_band, 0, "{kind}");
        assert!(fine.shadow_pixels > 500, "{kind}: {}", fine.shadow_pixels);
    }
}

/// With one comparison a pixel and features of two texels and more, edges are on average at most half as far off as those of a
/// shadow map of equal resolution.
#[test]
fn edges_are_half_as_far_off_as_those_of_a_shadow_map() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = floor();
    add(&mut scene, "ball", icosphere(0.6, 4).moved(Vec3::new(-0.6, 0.8, 0.2)));
    add(&mut scene, "box", block(Vec3::new(0.7, 0.7, -0.4), Vec3::new(0.3, 0.2, 0.3)));
    light(&mut scene, "lamp");
    for resolution in [128, 256, 512] {
        // The area between two edges over the length of one.
        let off = |error: &LightError| error.wrong as f64 / error.boundary_pixels as f64;
        let of_map = error(&mut renderer, &scene, map(resolution));
        let of_silhouettes = error(&mut renderer, &scene, silhouette(resolution));
        let (map_px, silhouettes_px) = (off(&of_map), off(&of_silhouettes));
        println!(
            "{resolution}: {map_px:.4} px, {} wrong; {silhouettes_px:.4} px, {} wrong",
            of_map.wrong, of_silhouettes.wrong
        );
        assert!(silhouettes_px <= 0.5 * map_px, "{resolution}: {silhouettes_px} and {map_px} px");
    }
}

/// 004 Fig. 7: one point for each texel cannot hold two outlines that cross in it, nor two that pass it, nor a corner sharper
/// than it is. There edges are wrong, within a texel or two; with more texels they are right again.
#[test]
fn one_point_a_texel_is_too_few_where_outlines_meet() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let crossing = |scene: &mut Scene| {
        for (name, turn) in [("first", 0.35_f64), ("second", -0.5)] {
            let bar = shadowgraph_testing::mesh(block(Vec3::ZERO, Vec3::new(0.9, 0.03, 0.12)).named(name));
            let height = if turn > 0.0 { 0.9 } else { 1.1 };
            let place = DAffine3::from_rotation_y(turn);
            let place = DAffine3::from_translation(DVec3::Y * height) * place;
            scene.add_mesh(bar, Material::default(), place);
        }
    };
    let parallel = |scene: &mut Scene| {
        for number in 0..12 {
            let x = -0.9 + 0.15 * number as f32;
            add(scene, "slat", block(Vec3::new(x, 1.0, 0.0), Vec3::new(0.07, 0.01, 0.6)));
        }
    };
    let sharp = |scene: &mut Scene| {
        for number in 0..7 {
            let middle = 0.3 * (number as f32 - 3.0);
            let positions = [(-0.9, -0.12), (-0.9, 0.12), (0.9, 0.03)];
            let positions = positions.map(|(x, z)| Vec3::new(x, 1.0, middle + z)).to_vec();
            add(scene, "needle", MeshData { positions, indices: vec![0, 1, 2], ..MeshData::default() });
        }
    };
    type Change<'a> = &'a dyn Fn(&mut Scene);
    let artefacts: [(&str, Change<'_>); 3] =
        [("crossing", &crossing), ("parallel", &parallel), ("sharp", &sharp)];
    for (name, build) in artefacts {
        let mut scene = floor();
        build(&mut scene);
        light(&mut scene, "sun");
        let coarse = error(&mut renderer, &scene, silhouette(32));
        let fine = error(&mut renderer, &scene, silhouette(1024));
        println!(
            "{name}: {} wrong at 32 texels, {:.1} px from an edge at most; {} at 1024",
            coarse.wrong_outside_band, coarse.boundary_distance_max_px, fine.wrong_outside_band
        );
        assert!(coarse.wrong_outside_band > 4, "{name}: {}", coarse.wrong_outside_band);
        assert!(
            fine.wrong_outside_band * 4 <= coarse.wrong_outside_band,
            "{name}: {}",
            fine.wrong_outside_band
        );
    }
}

/// One byte a point: off by 1/32 of a texel along each side at most, so by a pixel here and there at few texels.
#[test]
fn points_in_one_byte_are_almost_as_good() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = floor();
    add(&mut scene, "box", block(Vec3::new(-0.3, 0.9, 0.0), Vec3::new(0.6, 0.2, 0.4)));
    light(&mut scene, "lamp");
    let of = |renderer: &mut Renderer, point_format| {
        let node = SilhouetteMap { point_format, ..silhouette(64) };
        error(renderer, &scene, node).wrong_outside_band
    };
    let two = of(&mut renderer, PointFormat::TwoBytes);
    let one = of(&mut renderer, PointFormat::OneByte);
    let none = error(&mut renderer, &scene, map(64)).wrong_outside_band;
    println!("64 texels: {two} wrong with two bytes, {one} with one, {none} of a shadow map");
    assert!(two <= one && one * 4 < none, "{two}, {one}, {none}");
}

/// Which outline a texel keeps does not go by the order in which casters are drawn.
#[test]
fn the_order_of_casters_changes_nothing() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let bars = [0.2_f32, -0.4, 0.7, -0.1, 0.5];
    let factors = |renderer: &mut Renderer, order: &[usize]| {
        let mut scene = floor();
        for number in order {
            let bar = block(Vec3::ZERO, Vec3::new(0.9, 0.02, 0.1));
            let bar = shadowgraph_testing::mesh(bar);
            let turn = DAffine3::from_rotation_y(bars[*number].into());
            let place = DAffine3::from_translation(DVec3::Y * (0.8 + 0.1 * *number as f64)) * turn;
            scene.add_mesh(bar, Material::default(), place);
        }
        light(&mut scene, "sun");
        scene.add_shadow("shadows", silhouette(64));
        let camera = shadowgraph_testing::camera(DVec3::new(0.3, 4.5, 2.6), DVec3::ZERO);
        let request = FrameRequest { factors: true, ..FrameRequest::new(camera, SIZE_PX) };
        let frame = renderer.render(&scene, &request, &RenderOptions::default()).unwrap();
        frame.factors[0].pixels.floats().unwrap()
    };
    let first = factors(&mut renderer, &[0, 1, 2, 3, 4]);
    assert!(first.iter().filter(|factor| **factor == 0.0).count() > 500);
    assert_eq!(first, factors(&mut renderer, &[4, 2, 0, 3, 1]));
}

/// Points are shown where edges are: as red discs, on the floor and nowhere but along the outline.
#[test]
fn points_can_be_looked_at() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut scene = floor();
    add(&mut scene, "box", block(Vec3::new(-0.3, 0.9, 0.0), Vec3::new(0.6, 0.2, 0.4)));
    light(&mut scene, "lamp");
    scene.add_shadow("shadows", SilhouetteMap { show: Show::Points, ..silhouette(64) });
    let camera = shadowgraph_testing::camera(DVec3::new(0.3, 4.5, 2.6), DVec3::ZERO);
    let request = FrameRequest { factors: true, ..FrameRequest::new(camera, SIZE_PX) };
    let frame = renderer.render(&scene, &request, &RenderOptions::default()).unwrap();
    let factors = frame.factors[0].pixels.floats().unwrap();
    let red = factors.chunks_exact(4).filter(|pixel| pixel[0] == 1.0 && pixel[1] == 0.0).count();
    println!("{red} red pixels");
    assert!(red > 40 && red < 4000, "{red}");
}
