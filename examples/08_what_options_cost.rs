//! What the options of `ShadowVolumeHard` cost and save: a row for each, timed in turn on the same scenes.
//!
//! `cargo run --example 08_what_options_cost [WORD]` (only tables with that word in their title) prints frame times (of
//! rounds in which every row gets one frame), what is drawn, and how many pixels are wrong outside the ambiguity band.
//! Absolute times are this machine's; ratios are what to read.
#![allow(clippy::print_stdout, reason = "printing rows is what it is for")]

mod common;

use std::error::Error;
use std::time::{Duration, Instant};

use glam::{DVec4, Vec3};
use shadowgraph::demo;
use shadowgraph::engine::plan::{FramePlan, Geometry, SlotKind};
use shadowgraph::engine::render::{Adapter, plan_frame};
use shadowgraph::engine::scene::SceneSnapshot;
use shadowgraph::engine::shadow::{Cache, Registry};
use shadowgraph::measure::timing::{Pace, Runner, Spread, take_turns};
use shadowgraph::measure::{Reference, compare, measured, queries};
use shadowgraph::nodes::common::volume::VolumeUniform;
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [1280, 720];
const PACE: Pace = Pace { min_rounds: 7, max_rounds: 15, budget: Duration::from_secs(6) };

/// A row: its name and its node; `None` for no shadows.
type Row = (&'static str, Option<ShadowVolumeHard>);

fn main() -> Result<(), Box<dyn Error>> {
    let auto = ShadowVolumeHard::default();
    let single = ShadowVolumeHard { passes: Passes::Single, ..auto };
    let float = ShadowVolumeHard { counter: CounterKind::Float, ..auto };
    let rows: [Row; 11] = [
        ("no shadows", None),
        ("default", Some(auto)),
        ("extrusion=infinite", Some(ShadowVolumeHard { extrusion: Extrusion::Infinite, ..auto })),
        ("depthTest=zfail", Some(ShadowVolumeHard { depth_test: DepthTest::ZFail, ..auto })),
        ("geometry=open", Some(ShadowVolumeHard { geometry: GeometryMode::Open, ..auto })),
        (
            "geometry=open,depthTest=zfail",
            Some(ShadowVolumeHard { geometry: GeometryMode::Open, depth_test: DepthTest::ZFail, ..auto }),
        ),
        ("closure=cap", Some(ShadowVolumeHard { closure: Closure::Cap, ..auto })),
        ("closure=backfaces", Some(ShadowVolumeHard { closure: Closure::Backfaces, ..auto })),
        ("passes=single", Some(single)),
        ("counter=float", Some(float)),
        ("terminator=smooth", Some(ShadowVolumeHard { terminator: Terminator::Smooth, ..auto })),
    ];
    for (name, _, scene) in demo::speed() {
        table(name, &scene, &rows)?;
    }
    let counters: [Row; 3] =
        [("no shadows", None), ("counter=stencil8", Some(auto)), ("counter=float", Some(float))];
    for layers in [30_u32, 300, 2049, 4096] {
        table(&format!("{layers} boxes, one above the other"), &stack(layers)?, &counters)?;
    }
    let passes: [Row; 3] =
        [("no shadows", None), ("passes=multi", Some(auto)), ("passes=single", Some(single))];
    let knot = demo::speed().swap_remove(0).2;
    for lights in [1, 4, 16] {
        table(&format!("knot13k under {lights} lamps"), &demo::under_lamps(&knot, lights), &passes)?;
    }
    Ok(())
}

/// `layers` thin boxes over a floor, under a lamp right above.
fn stack(layers: u32) -> Result<Scene, Box<dyn Error>> {
    let pitch = 1.0 / layers as f32;
    let boxes = (0..layers).map(|i| {
        let y = 1.0 + i as f32 * pitch;
        shapes::cuboid(Vec3::new(-0.25, y, -0.25), Vec3::new(0.25, y + pitch * 0.5, 0.25))
    });
    let mut scene = Scene::new();
    let floor = shapes::plane(Vec2::splat(4.0)).named("floor");
    scene.add_mesh(Mesh::new(floor)?, Material::default(), DAffine3::IDENTITY);
    scene.add_mesh(Mesh::new(MeshData::merged("boxes", boxes))?, Material::default(), DAffine3::IDENTITY);
    scene.add_lamp(Light::point("lamp", 60.0), DVec3::new(0.0, 6.0, 0.0));
    scene.add_camera(Camera::perspective("main", 0.8), DVec3::new(1.5, 2.5, 3.0), DVec3::new(0.0, 0.4, 0.0));
    Ok(scene)
}

/// The scene with its shadow nodes replaced by the row's.
fn with_row(scene: &Scene, node: Option<ShadowVolumeHard>) -> Scene {
    let mut scene = scene.without_shadows();
    if let Some(node) = node {
        scene.add_shadow("shadows", node);
    }
    scene
}

fn table(name: &str, scene: &Scene, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    if std::env::args().nth(1).is_some_and(|word| !name.contains(&word)) {
        return Ok(());
    }
    let snapshot = scene.snapshot()?;
    let camera = snapshot.cameras.first().ok_or("a scene has no camera")?.clone();
    let request = FrameRequest::new(camera, SIZE_PX);
    let mut runners = Vec::new();
    for (_, node) in rows {
        runners.push(Runner {
            renderer: common::renderer(shadowgraph_nodes::catalog())?,
            scene: with_row(scene, *node),
            request: request.clone(),
        });
    }
    let times_ms = take_turns(&mut runners, &PACE)?;
    println!("{name} ({}, {} rounds)", runners[0].renderer.gpu().name(), times_ms[0].len());
    println!(
        "  {:<30} {:>9} {:>9} {:>10} {:>9} {:>9} {:>9} {:>10} {:>7} {:>7}",
        "", "median ms", "least ms", "shadow ms", "of deflt", "vertices", "Mpx", "bytes", "plan ms", "wrong"
    );
    let spread = |index: usize| Spread::of(times_ms[index].clone());
    // Other work on the machine only ever adds time: what shadows cost is taken from the least of each row.
    let least = |index: usize| spread(index).min;
    let mut reference = None;
    for (index, ((row, node), runner)) in rows.iter().zip(&mut runners).enumerate() {
        let plan = runner.renderer.plan(&runner.scene, &request)?;
        let (snapshot, registry) = runner.renderer.snapshot(&runner.scene)?;
        let wrong = if node.is_some() {
            let reference = reference.get_or_insert_with(|| {
                Reference::new(&snapshot).render(&request.camera, SIZE_PX, &queries(&registry), &|_, _| {})
            });
            let request = FrameRequest { factors: true, ..request.clone() };
            let frame = runner.renderer.render(&runner.scene, &request, &RenderOptions::default())?;
            let errors = compare(&measured(&frame, SIZE_PX)?, reference)?;
            errors.iter().map(|error| error.wrong_outside_band).sum::<usize>().to_string()
        } else {
            String::new()
        };
        let vertices: u64 =
            plan.passes_named("volumes of").flat_map(|pass| &pass.draws).map(|draw| draw.vertices()).sum();
        let shadow_ms = least(index) - least(0);
        let share = if index > 0 { shadow_ms / (least(1) - least(0)) } else { 0.0 };
        println!(
            "  {row:<30} {:>9.2} {:>9.2} {shadow_ms:>10.2} {share:>9.2} {vertices:>9} {:>9.2} {:>10} {:>7.2} {wrong:>7}",
            spread(index).median,
            least(index),
            drawn_px(&snapshot, &plan, &request) * 1e-6,
            plan.bytes(),
            plan_ms(&snapshot, &registry, &request)?
        );
    }
    Ok(())
}

/// The time of planning with nothing kept from before: silhouettes are extracted anew. The best of five.
fn plan_ms(
    snapshot: &SceneSnapshot,
    registry: &Registry,
    request: &FrameRequest,
) -> Result<f64, Box<dyn Error>> {
    let mut best_ms = f64::INFINITY;
    for _ in 0..5 {
        let start = Instant::now();
        plan_frame(snapshot, registry, request, &Adapter::imagined(), &Cache::new())?;
        best_ms = best_ms.min(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(best_ms)
}

/// The pixels that all triangles of all volumes cover together, as the vertex shader places them.
fn drawn_px(snapshot: &SceneSnapshot, plan: &FramePlan, request: &FrameRequest) -> f64 {
    let [width, height] = SIZE_PX.map(f64::from);
    let clip_from_world = request.camera.projection.clip_from_view(width / height)
        * glam::DMat4::from(request.camera.world_from_view.inverse());
    let words = |slot: shadowgraph::engine::plan::SlotId| match &plan.slot(slot).kind {
        SlotKind::Buffer { contents, .. } => &contents.0[..],
        SlotKind::Texture { .. } | SlotKind::Image { .. } => &[],
    };
    let mut area_px = 0.0;
    for draw in plan.passes_named("volumes of").flat_map(|pass| &pass.draws) {
        let Geometry::Indexed { instance, indices, first, count, record, .. } = &draw.geometry else {
            continue;
        };
        let (instance, indices, first, count, record) = (*instance, *indices, *first, *count, *record);
        let records: Vec<VolumeUniform> = draw
            .bindings
            .iter()
            .filter_map(|(_, binding)| binding.resource())
            .flat_map(|slot| bytemuck::pod_collect_to_vec(words(slot)))
            .collect();
        let record = records[record as usize];
        let instance = &snapshot.instances[instance as usize];
        let indices: Vec<u32> = bytemuck::pod_collect_to_vec(words(indices));
        let world_from_shader = instance.world_from_shader();
        let corner = |index: &u32| -> DVec4 {
            let p =
                instance.mesh.positions()[(index >> 2) as usize].as_dvec3() - instance.mesh.shader_origin();
            if index & 3 != 3 {
                return clip_from_world * world_from_shader.transform_point3(p).extend(1.0);
            }
            let light =
                DVec4::from(record.light_high.map(f64::from)) + DVec4::from(record.light_low.map(f64::from));
            let away = p * light.w - light.truncate();
            let normal = Vec3::from(record.end_normal).as_dvec3();
            match record.end_kind {
                0 => clip_from_world * world_from_shader.transform_vector3(away).extend(0.0),
                1 => {
                    let stretch = (f64::from(record.end_offset) - normal.dot(p)) / normal.dot(away);
                    clip_from_world * world_from_shader.transform_point3(p + away * stretch).extend(1.0)
                }
                _ => {
                    let end = p + away * f64::from(record.end_scale);
                    clip_from_world * world_from_shader.transform_point3(end).extend(1.0)
                }
            }
        };
        for triangle in indices[first as usize..(first + count) as usize].chunks_exact(3) {
            area_px += clipped_area(triangle.iter().map(corner).collect()) * width * height / 4.0;
        }
    }
    area_px
}

/// The area of a polygon in clip space that is in view, in normalised device coordinates.
fn clipped_area(polygon: Vec<DVec4>) -> f64 {
    let planes = [DVec4::X, -DVec4::X, DVec4::Y, -DVec4::Y].map(|axis| axis + DVec4::W);
    let planes = planes.into_iter().chain([DVec4::W - DVec4::Z, DVec4::Z]);
    let inside = planes.fold(polygon, |polygon, plane| {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, &p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % polygon.len()];
            let (h_p, h_q) = (plane.dot(p), plane.dot(q));
            if h_p >= 0.0 {
                kept.push(p);
            }
            if (h_p < 0.0) != (h_q < 0.0) {
                kept.push(p + (q - p) * (h_p / (h_p - h_q)));
            }
        }
        kept
    });
    let ndc: Vec<DVec2> =
        inside.iter().filter(|p| p.w > 0.0).map(|p| p.truncate().truncate() / p.w).collect();
    let cross = |i: usize| ndc[i].perp_dot(ndc[(i + 1) % ndc.len()]);
    ((0..ndc.len()).map(cross).sum::<f64>() * 0.5).abs()
}
