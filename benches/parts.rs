//! What a frame is made of, timed apart: `cargo bench`, or `cargo bench -- adjacency` for some of it.
//!
//! Frames need an adapter; where there is none they are left out.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot go on has nothing to say")]

use divan::{Bencher, black_box};
use shadowgraph::demo;
use shadowgraph::engine::geometry::Topology;
use shadowgraph::engine::gltf;
use shadowgraph::engine::render::{Adapter, Planner, plan_frame};
use shadowgraph::engine::shadow::{Cache, Registry};
use shadowgraph::measure::{Reference, queries};
use shadowgraph::prelude::*;

fn main() {
    divan::main();
}

/// About so many triangles of a closed torus knot.
fn knot(triangles: u32) -> MeshData {
    let around = (f64::from(triangles) / 23.0).sqrt() as u32;
    shapes::torus_knot([2, 3], 0.8, 0.2, [triangles / (2 * around), around])
}

/// A demo or speed scene with its camera, by its name.
fn scene(name: &str) -> (Scene, CameraSnapshot) {
    let all = demo::all().into_iter().chain(demo::speed());
    let (_, _, scene) = all.into_iter().find(|(stem, ..)| *stem == name).unwrap();
    let camera = scene.snapshot().unwrap().cameras[0].clone();
    (scene, camera)
}

#[divan::bench(args = [1_000, 10_000, 100_000])]
fn adjacency(bencher: Bencher<'_, '_>, triangles: u32) {
    let mesh = Mesh::new(knot(triangles)).unwrap();
    bencher
        .counter(divan::counter::ItemsCount::new(mesh.triangle_count()))
        .bench_local(|| Topology::new(black_box(mesh.positions()), &mesh.data().indices));
}

/// Signs, silhouettes and caps of a moving light: everything but the kept adjacency is made anew.
#[divan::bench(args = ["knot13k", "knot63k", "boxes1k", "plant"])]
fn extraction(bencher: Bencher<'_, '_>, name: &str) {
    plan_with_moving_lights(bencher, scene(name));
}

/// The same for lights with a size: edges, triangles, and the lists of which matter where.
#[divan::bench(args = ["knot13k", "boxes1k", "plant"])]
fn soft_lists(bencher: Bencher<'_, '_>, name: &str) {
    let (given, camera) = scene(name);
    let mut soft = given.without_shadows();
    soft.add_shadow("soft", ShadowVolumeSoft::default());
    plan_with_moving_lights(bencher, (soft, camera));
}

fn plan_with_moving_lights(bencher: Bencher<'_, '_>, (scene, camera): (Scene, CameraSnapshot)) {
    let snapshot = scene.snapshot().unwrap();
    let registry = Registry::collect(&snapshot, &shadowgraph::nodes::catalog()).unwrap();
    let request = FrameRequest::new(camera, [1280, 720]);
    let cache = Cache::new();
    let mut turn = 0.0;
    bencher.bench_local(|| {
        let mut moved = snapshot.clone();
        turn += 1e-3;
        moved.lights.iter_mut().for_each(|light| light.position.x += turn);
        cache.begin_frame();
        plan_frame(&moved, &registry, &request, &Adapter::imagined(), &cache).unwrap()
    });
}

/// 4 096 boxes over a floor, under 16 lamps.
fn crowd() -> (Scene, CameraSnapshot) {
    let mut scene = Scene::new();
    let floor = Mesh::new(shapes::plane(Vec2::splat(140.0))).unwrap();
    scene.add_mesh(floor, Material::default(), DAffine3::IDENTITY);
    let cuboid = Mesh::new(shapes::cuboid(Vec3::splat(-0.5), Vec3::splat(0.5))).unwrap();
    let cuboid = MeshNode::new(scene.add_mesh_data(cuboid.into()), scene.add_material(Material::default()));
    for place in 0..4096 {
        let at = DVec3::new(f64::from(place % 64) * 2.0 - 63.0, 1.0, f64::from(place / 64) * 2.0 - 63.0);
        scene.add(None, "box", DAffine3::from_translation(at), Content::Mesh(cuboid.clone()));
    }
    for lamp in 0..16 {
        let at = DVec3::new(f64::from(lamp % 4) * 30.0 - 45.0, 12.0, f64::from(lamp / 4) * 30.0 - 45.0);
        scene.add_lamp(Light::point(&format!("lamp{lamp}"), 100.0), at);
    }
    scene.add_shadow("shadows", ShadowVolumeHard::default());
    let eye = Camera::perspective("eye", 0.9);
    (scene, CameraSnapshot::looking(eye, DVec3::new(0.0, 20.0, 80.0), DVec3::ZERO))
}

/// A frame in which nothing but the eye moved.
#[divan::bench(args = ["room", "knots", "boxes1k", "crowd"])]
fn planning(bencher: Bencher<'_, '_>, name: &str) {
    let (scene, mut camera) = if name == "crowd" { crowd() } else { scene(name) };
    let mut planner = Planner::new(shadowgraph::nodes::catalog());
    let turn = DAffine3::from_rotation_y(1e-4);
    let mut plan = |camera: &CameraSnapshot| {
        let request = FrameRequest::new(camera.clone(), [1280, 720]);
        planner.plan(&scene, &request, &Adapter::imagined()).unwrap()
    };
    // The first frame extracts; that is timed by itself.
    plan(&camera);
    bencher.bench_local(|| {
        camera.world_from_view *= turn;
        plan(&camera)
    });
}

#[divan::bench(args = ["room", "leaves"])]
fn gltf_load(bencher: Bencher<'_, '_>, name: &str) {
    let path = std::path::Path::new("assets").join(name).with_extension("glb");
    bencher.bench_local(|| gltf::load(black_box(&path)).unwrap());
}

/// First hit, shadow ray and ambiguity band of every pixel.
#[divan::bench(args = ["knot13k", "boxes1k", "plant"], sample_count = 10)]
fn reference_rays(bencher: Bencher<'_, '_>, name: &str) {
    const SIZE_PX: [u32; 2] = [160, 90];
    let (scene, camera) = scene(name);
    let snapshot = scene.snapshot().unwrap();
    let registry = Registry::collect(&snapshot, &shadowgraph::nodes::catalog()).unwrap();
    let (reference, queries) = (Reference::new(&snapshot), queries(&registry));
    bencher
        .counter(divan::counter::ItemsCount::new(SIZE_PX[0] as usize * SIZE_PX[1] as usize))
        .bench_local(|| reference.render(&camera, SIZE_PX, &queries, &|_, _| {}));
}

#[divan::bench(args = ["room", "knot13k", "boxes1k", "plant"], sample_count = 20)]
fn frame(bencher: Bencher<'_, '_>, name: &str) {
    let choice = std::env::var("SHADOWGRAPH_ADAPTER").map_or(AdapterChoice::Auto, AdapterChoice::Named);
    let Ok(gpu) = Gpu::open(&choice) else { return };
    let (scene, camera) = scene(name);
    let mut renderer = Renderer::new(gpu, shadowgraph::nodes::catalog());
    let request = FrameRequest::new(camera, [640, 360]);
    renderer.render(&scene, &request, &RenderOptions::default()).unwrap();
    bencher.bench_local(|| renderer.render(&scene, &request, &RenderOptions::default()).unwrap());
}
