//! Maps beside volumes: how wrong `ShadowMap` and `SilhouetteMap` are against their resolution, and what they cost beside
//! `ShadowVolumeHard`, in scenes like those of the silhouette maps' paper (004 Table 1: a crowd before a wall, a vehicle, a
//! castle), on its curved objects (bowling pins) and on three of the scenes that the report times.
//!
//! `cargo run --example 19_maps_beside_volumes` prints three tables for each scene. The first: wrong pixels, how far edges are off
//! on average (wrong pixels over the pixels of the edge), and how far wrong pixels are from the edge. The second: what the paper's
//! model of memory traffic needs, and what it says: fragments of volumes for each pixel of the scene (O), and the share of pixels
//! on silhouettes (P) of a map of 512 texels. The third: times of whole frames in turns, as multiples of the frame without shadows; *still*
//! when maps are kept, *moved* when the light moves in every frame and everything is drawn anew. Pictures go to `out/`.

#![allow(clippy::print_stdout, reason = "printing rows is what it is for")]

mod common;

use std::error::Error;
use std::time::Instant;

use glam::{DMat4, DVec4};
use shadowgraph::engine::geometry::shapes::Ends;
use shadowgraph::engine::geometry::{Chain, facing_signs};
use shadowgraph::measure::timing::Spread;
use shadowgraph::measure::{KnownReferences, evaluate_again, measured};
use shadowgraph::nodes::common::cut_casters::cut_outline;
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [1280, 720];
const ROUNDS: usize = 15;
const RESOLUTIONS: [u32; 6] = [128, 256, 512, 1024, 2048, 4096];

type Result<T> = std::result::Result<T, Box<dyn Error>>;

type MakeScene = fn() -> Result<Scene>;

fn main() -> Result<()> {
    let scenes: [(&str, MakeScene); 7] = [
        ("crowd", crowd),
        ("vehicle", vehicle),
        ("castle", castle),
        ("strike", strike),
        ("knot13k", || speed("knot13k")),
        ("boxes1k", || speed("boxes1k")),
        ("plant", || speed("plant")),
    ];
    let only = std::env::args().nth(1);
    for (name, build) in
        scenes.into_iter().filter(|(name, _)| only.as_deref().is_none_or(|only| only == *name))
    {
        let scene = build()?;
        let triangles: usize = scene.snapshot()?.instances.iter().map(|i| i.mesh.triangle_count()).sum();
        println!("\n{name}: {triangles} triangles, {}x{}", SIZE_PX[0], SIZE_PX[1]);
        let right_enough = errors(&scene)?;
        traffic(&scene)?;
        times(&scene, right_enough)?;
        for (kind, node) in [
            ("map", ShadowNode::from(ShadowMap { pcf: 1, resolution: 512, ..ShadowMap::default() })),
            ("silhouette", SilhouetteMap { resolution: 512, ..SilhouetteMap::default() }.into()),
        ] {
            let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
            let picture = format!("19_{name}_{kind}");
            common::picture(
                &mut renderer,
                &shadowed(&scene, node),
                &camera(&scene)?,
                Exposure::default(),
                &picture,
            )?;
        }
    }
    Ok(())
}

fn shadowed(scene: &Scene, node: impl Into<ShadowNode>) -> Scene {
    let mut scene = scene.clone();
    scene.add_shadow("shadows", node);
    scene
}

fn camera(scene: &Scene) -> Result<CameraSnapshot> {
    Ok(scene.snapshot()?.cameras.first().ok_or("a scene has no camera")?.clone())
}

/// The share of wrong pixels with which a technique is right enough.
const RIGHT_ENOUGH: f64 = 0.001;

/// Prints wrong pixels and distances against the resolution; returns the first that is right enough, of maps with one comparison
/// and of silhouettes.
fn errors(scene: &Scene) -> Result<[Option<u32>; 2]> {
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    let request = FrameRequest::new(camera(scene)?, SIZE_PX);
    let mut references = KnownReferences::default();
    println!(
        "{:<10} {:>24} {:>24} {:>24} {:>24}",
        "texels", "map pcf 1", "map pcf 3", "silhouette", "one byte"
    );
    let mut row = |label: &str, nodes: &[ShadowNode]| -> Result<Vec<f64>> {
        let (mut cells, mut shares) = (String::new(), Vec::new());
        for node in nodes {
            let scene = shadowed(scene, node.clone());
            let evaluation = evaluate_again(&mut renderer, &scene, &request, &mut references, &|_, _| {})?;
            let error = &evaluation.errors[0];
            let off_px = error.wrong as f64 / error.boundary_pixels.max(1) as f64;
            let share = error.wrong as f64 / error.compared.max(1) as f64;
            shares.push(share);
            let (share, from_edge_px) = (100.0 * share, error.boundary_distance_mean_px);
            cells += &format!(" {share:>8.3} % {off_px:.3} {from_edge_px:.2} px");
        }
        println!("{label:<10}{cells}");
        Ok(shares)
    };
    let mut right_enough = [None; 2];
    for resolution in RESOLUTIONS {
        let map = |pcf| ShadowMap { resolution, pcf, ..ShadowMap::default() };
        let silhouette =
            |point_format| SilhouetteMap { resolution, point_format, ..SilhouetteMap::default() };
        let shares = row(
            &resolution.to_string(),
            &[
                map(1).into(),
                map(3).into(),
                silhouette(PointFormat::TwoBytes).into(),
                silhouette(PointFormat::OneByte).into(),
            ],
        )?;
        for (first, share) in right_enough.iter_mut().zip([shares[0], shares[2]]) {
            *first = first.or((share <= RIGHT_ENOUGH).then_some(resolution));
        }
    }
    row("volumes", &[ShadowVolumeHard::default().into()])?;
    Ok(right_enough)
}

/// The model of 004 §4: a map reads 4 bytes for each pixel of the scene, a silhouette map 24 more for each on a silhouette, and
/// volumes 5.5 for each of their fragments.
fn traffic(scene: &Scene) -> Result<()> {
    let camera = camera(scene)?;
    let mut renderer = common::renderer(shadowgraph_nodes::catalog())?;
    // Where the four texels around a pixel do not agree, the mean of them is neither 0 nor 1.
    let corners = ShadowMap { resolution: 512, pcf: 2, ..ShadowMap::default() };
    let request = FrameRequest { factors: true, ..FrameRequest::new(camera.clone(), SIZE_PX) };
    let frame = renderer.render(&shadowed(scene, corners), &request, &RenderOptions::default())?;
    let measured = measured(&frame, SIZE_PX)?;
    let pixels = measured.ids.iter().filter(|ids| ids[0] != u32::MAX).count() as f64;
    let on_silhouettes =
        measured.lights[0].1.iter().filter(|factor| **factor > 0.0 && **factor < 1.0).count();
    let share = on_silhouettes as f64 / pixels;
    let (edges, fragments) = volume_fill(scene, &camera)?;
    let overdraw = fragments / pixels;
    println!(
        "silhouette edges {edges}, pixels {pixels}, O = {overdraw:.2}, P = {:.2} %; bytes for each pixel: map 4, silhouettes {:.2}, volumes {:.1}",
        100.0 * share,
        4.0 + 24.0 * share,
        5.5 * overdraw
    );
    Ok(())
}

/// The silhouette edges of all casters, and the pixels that the sides of their volumes cover, each side from its edge to infinity.
fn volume_fill(scene: &Scene, camera: &CameraSnapshot) -> Result<(usize, f64)> {
    let snapshot = scene.snapshot()?;
    let light = snapshot.lights[0].position;
    let [width, height] = SIZE_PX.map(f64::from);
    let clip_from_view = camera.projection.clip_from_view(width / height);
    let clip_from_world = clip_from_view * DMat4::from(camera.world_from_view.inverse());
    let (mut edges, mut fragments) = (0, 0.0);
    for instance in snapshot.instances.iter().filter(|instance| instance.shadow.casts) {
        let topology = instance.mesh.topology();
        let p_in_world: Vec<DVec3> = (0..instance.mesh.positions().len() as u32)
            .map(|vertex| instance.world_position(vertex))
            .collect();
        let signs = facing_signs(&p_in_world, topology.triangles(), light);
        let signs = match topology.orientation(&instance.world_from_local) {
            Some(orientation) => orientation.lit_only(&signs),
            None => signs,
        };
        let chain = Chain::extract(topology, &signs);
        edges += chain.silhouette_edges;
        for side in &chain.sides {
            let [a, b] = side.map(|vertex| p_in_world[vertex as usize].extend(1.0));
            let far = |p: DVec4| (p * light.w - light).truncate().extend(0.0);
            let side = [a, b, far(b), far(a)].map(|corner| clip_from_world * corner);
            fragments += visible_share(side.to_vec()) * width * height;
        }
    }
    Ok((edges, fragments))
}

/// The share of the picture that a polygon in clip space covers.
fn visible_share(polygon: Vec<DVec4>) -> f64 {
    let planes = [DVec4::X, DVec4::NEG_X, DVec4::Y, DVec4::NEG_Y, DVec4::NEG_Z].map(|side| side + DVec4::W);
    let polygon = cut_outline(polygon, &planes);
    let corners: Vec<DVec2> = polygon.iter().map(|corner| corner.truncate().truncate() / corner.w).collect();
    let ends = corners.iter().zip(corners.iter().cycle().skip(1));
    // Twice the area of triangles from the middle; the picture's area is 4.
    ends.map(|(a, b)| a.perp_dot(*b)).sum::<f64>().abs() / 8.0
}

/// Times of whole frames, in turns; of maps also at the resolutions that are right enough.
fn times(scene: &Scene, [map_texels, silhouette_texels]: [Option<u32>; 2]) -> Result<()> {
    let map = |resolution| ShadowMap { resolution, pcf: 1, ..ShadowMap::default() };
    let silhouette = |resolution| SilhouetteMap { resolution, ..SilhouetteMap::default() };
    let mut rows: Vec<(String, Option<ShadowNode>)> = vec![
        ("no shadows".into(), None),
        ("volumes".into(), Some(ShadowVolumeHard::default().into())),
        ("map 2048".into(), Some(map(2048).into())),
        ("silhouette 2048".into(), Some(silhouette(2048).into())),
    ];
    rows.extend(map_texels.map(|texels| (format!("map {texels}: 0.1 %"), Some(map(texels).into()))));
    rows.extend(
        silhouette_texels
            .map(|texels| (format!("silhouette {texels}: 0.1 %"), Some(silhouette(texels).into()))),
    );
    let request = FrameRequest::new(camera(scene)?, SIZE_PX);
    let mut renderers = Vec::new();
    for (_, node) in &rows {
        let scene = node.as_ref().map_or(scene.clone(), |node| shadowed(scene, node.clone()));
        renderers.push((common::renderer(shadowgraph_nodes::catalog())?, scene));
    }
    println!("{:<24} {:>14} {:>8} {:>14} {:>8}", "", "still ms", "times", "moved ms", "times");
    let mut medians = vec![[Vec::new(), Vec::new()]; rows.len()];
    for round in 0..ROUNDS + 2 {
        for (place, (renderer, scene)) in renderers.iter_mut().enumerate() {
            for moved in [false, true] {
                if moved {
                    let is_light = |content: &Content| matches!(content, Content::Light(_));
                    let lamp = scene.nodes().find_map(|(key, node)| is_light(&node.content).then_some(key));
                    let lamp = lamp.ok_or("a scene has no light")?;
                    let node = scene.node_mut(lamp).ok_or("a scene has no light")?;
                    let shift = DVec3::X * if round % 2 == 0 { 1e-3 } else { -1e-3 };
                    node.parent_from_local = DAffine3::from_translation(shift) * node.parent_from_local;
                }
                let start = Instant::now();
                renderer.render(scene, &request, &RenderOptions::default())?;
                let took = start.elapsed();
                // What moved is drawn once more, so that the next frame is still.
                if moved {
                    renderer.render(scene, &request, &RenderOptions::default())?;
                }
                if round >= 2 {
                    medians[place][usize::from(moved)].push(took.as_secs_f64() * 1e3);
                }
            }
        }
    }
    let bare = medians[0].clone();
    for ((name, _), [still, moved]) in rows.iter().zip(&medians) {
        let ratio =
            |own: &[f64], bare: &[f64]| Spread::of(own.iter().zip(bare).map(|(a, b)| a / b).collect());
        let (still_ms, moved_ms) = (Spread::of(still.clone()), Spread::of(moved.clone()));
        println!(
            "{name:<24} {:>14.2} {:>8.2} {:>14.2} {:>8.2}",
            still_ms.median,
            ratio(still, &bare[0]).median,
            moved_ms.median,
            ratio(moved, &bare[1]).median
        );
    }
    Ok(())
}

/// A floor, a lamp and an eye.
fn stage(half_m: f32, lamp: DVec3, eye: DVec3, target: DVec3) -> Result<Scene> {
    let mut scene = Scene::new();
    let floor = shapes::plane(Vec2::splat(half_m)).named("floor");
    scene.add_mesh(Mesh::new(floor)?, Material::matt("floor", Vec3::splat(0.7)), DAffine3::IDENTITY);
    scene.add_light(Light::point("lamp", (lamp.length_squared() * 12.0) as f32), lamp, DVec3::ZERO);
    scene.add_camera(Camera::perspective("main", 0.75), eye, target);
    Ok(scene)
}

fn add(scene: &mut Scene, data: MeshData, color: Vec3, place: DVec3) -> Result<()> {
    let name = data.name.clone();
    scene.add_mesh(Mesh::new(data)?, Material::matt(&name, color), DAffine3::from_translation(place));
    Ok(())
}

fn block(min: [f32; 3], max: [f32; 3]) -> MeshData {
    shapes::cuboid(Vec3::from(min), Vec3::from(max))
}

/// A scene of the report, without its shadow node.
fn speed(name: &str) -> Result<Scene> {
    let (_, _, mut scene) = shadowgraph::demo::speed()
        .into_iter()
        .find(|(found, ..)| *found == name)
        .ok_or("there is no such scene")?;
    common::remove(&mut scene, |content| matches!(content, Content::Shadow(_)))?;
    Ok(scene)
}

/// Thirty people before a wall, the lamp behind them.
fn crowd() -> Result<Scene> {
    let mut scene =
        stage(8.0, DVec3::new(1.5, 4.5, 7.0), DVec3::new(2.0, 2.6, 8.0), DVec3::new(0.0, 0.9, 0.0))?;
    let wall = block([-6.0, 0.0, -2.7], [6.0, 4.0, -2.5]).named("wall");
    add(&mut scene, wall, Vec3::new(0.75, 0.7, 0.6), DVec3::ZERO)?;
    for number in 0..30 {
        let (row, column) = (number / 10, number % 10);
        let x = f64::from(column) * 0.8 - 3.6 + 0.3 * f64::from(row % 2);
        let place = DVec3::new(x, 0.0, -1.6 + 0.9 * f64::from(row) + 0.1 * f64::from(number % 3));
        let color = Vec3::new(0.3 + 0.05 * (number % 7) as f32, 0.4, 0.7 - 0.06 * (number % 5) as f32);
        let limb = |radius: f32, length: f32| shapes::cylinder(radius, length, 16, Ends::Closed);
        let person = MeshData::merged(
            "person",
            [
                limb(0.07, 0.8).moved(Vec3::new(-0.1, 0.0, 0.0)),
                limb(0.07, 0.8).moved(Vec3::new(0.1, 0.0, 0.05)),
                shapes::frustum(0.16, 0.2, 0.6, 16, Ends::Closed).moved(Vec3::Y * 0.82),
                limb(0.04, 0.55).moved(Vec3::new(-0.26, 0.85, 0.0)),
                limb(0.04, 0.55).moved(Vec3::new(0.26, 0.85, 0.0)),
                shapes::uv_sphere(0.13, 10, 9).moved(Vec3::Y * 1.6),
            ],
        );
        add(&mut scene, person, color, place)?;
    }
    Ok(scene)
}

/// An open vehicle of boxes, bars and wheels.
fn vehicle() -> Result<Scene> {
    let mut scene =
        stage(5.0, DVec3::new(-2.5, 4.5, 3.0), DVec3::new(3.2, 2.4, 4.2), DVec3::new(0.0, 0.6, 0.0))?;
    let body = Vec3::new(0.35, 0.42, 0.25);
    for (min, max) in [
        ([-1.5, 0.45, -0.7], [1.5, 0.6, 0.7]),
        ([0.5, 0.6, -0.6], [1.5, 0.95, 0.6]),
        ([-1.5, 0.6, -0.7], [-1.4, 1.0, 0.7]),
        ([-1.4, 0.6, 0.62], [0.4, 0.85, 0.7]),
        ([-1.4, 0.6, -0.7], [0.4, 0.85, -0.62]),
        ([-0.6, 0.6, 0.1], [-0.1, 0.8, 0.5]),
        ([-0.6, 0.6, -0.5], [-0.1, 0.8, -0.1]),
        ([-0.7, 0.8, 0.1], [-0.6, 1.3, 0.5]),
        ([-0.7, 0.8, -0.5], [-0.6, 1.3, -0.1]),
        ([0.6, 0.45, 0.7], [1.4, 0.55, 0.95]),
        ([0.6, 0.45, -0.95], [1.4, 0.55, -0.7]),
    ] {
        add(&mut scene, block(min, max).named("plate"), body, DVec3::ZERO)?;
    }
    for (x, z) in [(0.95, 0.8), (0.95, -0.8), (-0.95, 0.8), (-0.95, -0.8)] {
        let wheel = shapes::torus(0.3, 0.12, 16, 8);
        let turned = wheel.transformed(&DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2));
        add(&mut scene, turned.named("wheel"), Vec3::splat(0.15), DVec3::new(x, 0.42, z))?;
    }
    for (from, to) in [([0.45, 0.95, 0.6], [0.45, 1.5, 0.6]), ([0.45, 0.95, -0.6], [0.45, 1.5, -0.6])] {
        let bar = block([from[0] - 0.02, from[1], from[2] - 0.02], [to[0] + 0.02, to[1], to[2] + 0.02]);
        add(&mut scene, bar.named("bar"), body, DVec3::ZERO)?;
    }
    add(&mut scene, block([0.43, 1.46, -0.6], [0.47, 1.5, 0.6]).named("bar"), body, DVec3::ZERO)?;
    let steering = shapes::torus(0.16, 0.02, 20, 8).moved(Vec3::new(0.25, 1.05, 0.3));
    add(&mut scene, steering.named("wheel"), Vec3::splat(0.1), DVec3::ZERO)?;
    Ok(scene)
}

/// Four round towers with cones, walls with battlements between them, and a keep.
fn castle() -> Result<Scene> {
    let mut scene =
        stage(7.0, DVec3::new(5.0, 6.0, 3.0), DVec3::new(3.0, 5.2, 8.0), DVec3::new(0.0, 0.6, 0.0))?;
    let stone = Vec3::new(0.62, 0.58, 0.52);
    for (x, z) in [(-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0)] {
        let place = DVec3::new(x, 0.0, z);
        add(&mut scene, shapes::cylinder(0.5, 1.8, 16, Ends::Closed).named("tower"), stone, place)?;
        let roof = shapes::cone(0.6, 0.9, 16, Ends::Closed).named("roof");
        add(&mut scene, roof, Vec3::new(0.5, 0.2, 0.15), place + DVec3::Y * 1.8)?;
    }
    for along_x in [true, false] {
        for side in [-2.0_f32, 2.0] {
            let bar = |from: f32, to: f32, bottom: f32, top: f32, half: f32| {
                if along_x {
                    block([from, bottom, side - half], [to, top, side + half])
                } else {
                    block([side - half, bottom, from], [side + half, top, to])
                }
            };
            add(&mut scene, bar(-1.6, 1.6, 0.0, 1.1, 0.15).named("wall"), stone, DVec3::ZERO)?;
            for number in 0..8 {
                let from = -1.5 + 0.4 * number as f32;
                add(&mut scene, bar(from, from + 0.2, 1.1, 1.3, 0.15).named("merlon"), stone, DVec3::ZERO)?;
            }
        }
    }
    add(&mut scene, block([-0.6, 0.0, -0.6], [0.6, 2.4, 0.6]).named("keep"), stone, DVec3::ZERO)?;
    for number in 0..16 {
        let (side, place) = (number / 4, -0.6 + 0.32 * (number % 4) as f32);
        let [x, z] = match side {
            0 => [place, -0.6],
            1 => [0.4, place],
            2 => [place, 0.4],
            _ => [-0.6, place],
        };
        add(&mut scene, block([x, 2.4, z], [x + 0.2, 2.6, z + 0.2]).named("merlon"), stone, DVec3::ZERO)?;
    }
    Ok(scene)
}

/// Ten bowling pins and a ball.
fn strike() -> Result<Scene> {
    let mut scene =
        stage(4.0, DVec3::new(-2.0, 3.0, 2.2), DVec3::new(1.2, 1.4, 3.0), DVec3::new(0.0, 0.3, -0.2))?;
    let profile = [
        (0.0, 0.0),
        (0.1, 0.0),
        (0.16, 0.15),
        (0.19, 0.32),
        (0.16, 0.5),
        (0.085, 0.75),
        (0.075, 0.85),
        (0.1, 0.98),
        (0.085, 1.08),
        (0.0, 1.13),
    ];
    let profile: Vec<Vec2> = profile.iter().map(|(x, y)| Vec2::new(*x, *y) * 0.8).collect();
    for row in 0..4 {
        for column in 0..=row {
            let x = (f64::from(column) - 0.5 * f64::from(row)) * 0.55;
            let place = DVec3::new(x, 0.0, -0.45 * f64::from(row));
            add(&mut scene, shapes::lathe(&profile, 28).named("pin"), Vec3::new(0.9, 0.88, 0.82), place)?;
        }
    }
    let ball = shapes::icosphere(0.3, 3).named("ball");
    add(&mut scene, ball, Vec3::new(0.15, 0.2, 0.5), DVec3::new(0.35, 0.3, 1.0))?;
    Ok(scene)
}
