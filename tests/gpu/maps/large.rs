//! Casters larger than what a map shows of them: floors that something pierces, whole worlds around a table.

use glam::{Vec2, Vec3};
use shadowgraph::engine::geometry::shapes::{icosphere, plane};
use shadowgraph::measure::{KnownReferences, LightError, evaluate};
use shadowgraph::prelude::*;

use super::block;
use super::texels::judge;

const SIZE_PX: [u32; 2] = [256, 144];

/// All but a full turn: the seeds were found with it.
const TURN_RAD: f64 = 628.0 / 100.0;

/// The last two shadowed themselves along the floor's diagonal, as long as a rasteriser cut the floor to the map.
const SEEDS: [u64; 22] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 304, 403];

/// Numbers from 0 to 1, each seed its own.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

fn add(scene: &mut Scene, name: &str, data: MeshData) {
    scene.add_mesh(shadowgraph_testing::mesh(data.named(name)), Material::default(), DAffine3::IDENTITY);
}

fn errors(
    renderer: &mut Renderer,
    scene: &Scene,
    eye: [DVec3; 2],
    node: impl Into<ShadowNode>,
) -> Vec<LightError> {
    let mut scene = scene.clone();
    scene.add_shadow("shadows", node);
    let request = FrameRequest::new(shadowgraph_testing::camera(eye[0], eye[1]), SIZE_PX);
    evaluate(renderer, &scene, &request, &|_, _| {}).unwrap().errors
}

/// What is wrong beside the edges of shadows: none of it may be farther from them than a few pixels, nor be many pixels.
fn complaints(errors: &[LightError], what: &str, most: usize) -> Vec<String> {
    let wrong = errors.iter().filter(|error| {
        error.wrong_outside_band > most
            || (error.wrong_outside_band > 0 && error.boundary_distance_max_px > 4.0)
    });
    let line = |error: &LightError| {
        let (name, wrong, far) = (&error.name, error.wrong_outside_band, error.boundary_distance_max_px);
        format!("{what}: {name} has {wrong} wrong of {}, up to {far:.1} px from an edge", error.compared)
    };
    wrong.map(line).collect()
}

/// A floor of two triangles of 40 m with posts sunk into it, which casts, and a light.
fn pierced_floor(seed: u64) -> (Scene, CameraSnapshot) {
    let mut random = Random(seed * 977 + 13);
    let mut scene = Scene::new();
    let posts: Vec<MeshData> = (0..3)
        .map(|_| {
            let at = Vec3::new(random.between(-2.0, 2.0) as f32, 0.3, random.between(-2.0, 2.0) as f32);
            block(at, Vec3::new(0.1, 0.35, 0.1))
        })
        .collect();
    // As one mesh they are not flat, and all of the floor is shown; apart, only what is before the posts' feet.
    let floor = plane(Vec2::splat(20.0));
    if seed.is_multiple_of(4) {
        add(&mut scene, "floor", floor);
        posts.into_iter().for_each(|post| add(&mut scene, "sunk post", post));
    } else {
        add(&mut scene, "floor with posts", MeshData::merged("", posts.into_iter().chain([floor])));
    }
    let place = DVec3::new(random.between(-3.0, 3.0), random.between(2.0, 4.0), random.between(-3.0, 3.0));
    let (up, turn) = (random.between(0.6, 1.4), random.between(0.0, TURN_RAD));
    let down = DVec3::new(up.cos() * turn.cos(), -up.sin(), up.cos() * turn.sin());
    match seed % 5 {
        3 => scene.add_light(Light::point("lamp", 20.0), place, DVec3::ZERO),
        4 => scene.add_light(Light::spot("spot", 20.0, 0.6), place, 0.2 * place * DVec3::new(1.0, 0.0, 1.0)),
        _ => scene.add_light(Light::directional("sun", 3.0), DVec3::ZERO, down),
    };
    let turn = random.between(0.0, TURN_RAD);
    let eye = DVec3::new(4.0 * turn.cos(), random.between(0.5, 3.0), 4.0 * turn.sin());
    (scene, shadowgraph_testing::camera(eye, DVec3::ZERO))
}

#[test]
fn floors_that_posts_pierce_do_not_shadow_themselves() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let (mut wrong, mut shadowed) = (Vec::new(), 0);
    for seed in SEEDS {
        let (mut scene, eye) = pierced_floor(seed);
        scene.add_shadow("shadows", ShadowMap { pcf: 1, ..ShadowMap::default() });
        let found =
            judge(&mut renderer, &scene, &eye, SIZE_PX, 2.0, &mut KnownReferences::default()).unwrap();
        shadowed += found.in_shadow;
        if found.acne + found.far_leaks > 0 {
            wrong.push(format!("seed {seed}: {found:?}"));
        }
    }
    assert!(shadowed > 12_000, "{shadowed}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A table with a book and a lamp eight millimetres under a plate: in the middle of a sphere of 100 km, sunk into a floor of 2 km, and
/// with two boxes 100 km up beside the sun. (Corners 100 km away are off by a centimetre in f32, and a floor with them.)
#[test]
fn what_is_far_away_costs_no_digits_here() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut table = Scene::new();
    add(&mut table, "top", block(Vec3::new(0.0, -0.02, 0.0), Vec3::new(0.8, 0.02, 0.5)));
    add(&mut table, "book", block(Vec3::new(0.4, 0.01, 0.0), Vec3::new(0.1, 0.01, 0.07)));
    add(&mut table, "cup", block(Vec3::new(-0.3, 0.05, 0.1), Vec3::splat(0.05)));
    add(&mut table, "plate", block(Vec3::new(0.0, 0.6, 0.0), Vec3::new(0.1, 0.005, 0.1)));
    table.add_light(Light::directional("sun", 3.0), DVec3::ZERO, DVec3::new(0.5, -1.0, -0.3));
    table.add_light(Light::spot("spot", 20.0, 0.5), DVec3::new(1.2, 1.5, 0.8), DVec3::new(0.1, 0.0, 0.0));
    table.add_light(Light::point("lamp", 8.0), DVec3::new(0.0, 0.587, 0.0), DVec3::ZERO);
    // From afar, and close up to the book.
    let eyes = [
        ([DVec3::new(0.9, 0.8, 1.2), DVec3::new(0.05, 0.0, 0.0)], 30),
        ([DVec3::new(0.46, 0.14, 0.14), DVec3::new(0.38, 0.0, -0.02)], 60),
    ];
    let far = 100_000.0_f32;
    // The box around both stands in the sun's way, and neither of them.
    let beside = |x: f32| block(Vec3::new(-0.5, 1.0, 0.3) * far + Vec3::X * x, Vec3::splat(2.0));
    let sky = MeshData::merged("boxes beside the sun", [beside(-30.0), beside(30.0)]);
    let worlds = [
        ("nothing around", None),
        ("a sphere", Some(icosphere(far, 3).flipped())),
        (
            "a floor with the table's legs in it",
            Some(plane(Vec2::splat(0.01 * far)).moved(Vec3::new(0.0, -0.03, 0.0))),
        ),
        ("boxes far above", Some(sky)),
    ];
    let mut wrong = Vec::new();
    for (name, world) in worlds {
        let mut scene = table.clone();
        if let Some(world) = world {
            add(&mut scene, "world", world);
            // No sun shines into a sphere.
            if name == "a sphere" {
                scene.remove(scene.find("sun").unwrap()).unwrap();
            }
        }
        let nodes = [
            ("map", ShadowNode::from(ShadowMap { pcf: 1, ..ShadowMap::default() })),
            ("silhouettes", SilhouetteMap::default().into()),
        ];
        for ((technique, node), (eye, most)) in nodes.iter().flat_map(|node| eyes.map(|eye| (node, eye))) {
            let found = errors(&mut renderer, &scene, eye, node.clone());
            let what = format!("{technique} with {name}");
            found.iter().for_each(|e| println!("{what}: {} {} wrong", e.name, e.wrong_outside_band));
            wrong.extend(complaints(&found, &what, most));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
