//! The scenes of the sweeps, step by step.

use glam::{DAffine3, DVec3, Vec2};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{cuboid, plane, quad, torus_knot};
use shadowgraph_engine::scene::ParamValue;

use super::super::stage::{Stage, at, p, v};
use super::super::{counts, glass};

pub(super) fn yard_eye() -> [DVec3; 2] {
    [p(3.0, 4.0, 6.0), p(0.0, 0.5, 0.0)]
}

/// What stands in the yard: a floor, two boxes, an open leaf. All coordinates are multiples of 1/16 m.
pub(super) fn furniture(floor_half_m: f32) -> Vec<MeshData> {
    vec![
        plane(Vec2::splat(floor_half_m)).named("floor"),
        cuboid(v(-0.25, 0.75, -0.5), v(0.75, 1.375, 0.5)).named("box"),
        cuboid(v(1.25, 0.0, 0.75), v(1.75, 0.5, 1.25)).named("crate"),
        quad([v(-1.5, 0.75, 0.5), v(-0.75, 0.75, 0.5), v(-0.75, 1.5, -0.25), v(-1.5, 1.5, -0.25)])
            .named("leaf"),
    ]
}

/// The yard with a knot in it, put elsewhere by every mesh's node; near distance 0.1 m there. No light yet.
pub(super) fn yard(step: impl Into<String>, floor_half_m: f32, world_from_yard: DAffine3) -> Stage {
    let [eye, target] = yard_eye().map(|point| world_from_yard.transform_point3(point));
    let knot = torus_knot([2, 3], 0.4, 0.1, [48, 8]).moved(v(-0.4, 2.0, -0.6));
    let stage = Stage::new(step).eye(eye, target).lens(45.0, 0.1 * world_from_yard.matrix3.x_axis.length());
    let shapes = furniture(floor_half_m).into_iter().chain([knot]);
    shapes.fold(stage, |stage, shape| stage.caster_at(shape, world_from_yard))
}

/// The yard's lamp, unless the lamp is what is swept.
const LAMP: DVec3 = DVec3::new(-1.0, 4.0, 1.0);

pub(super) fn powers_of_ten(exponents: std::ops::RangeInclusive<i32>) -> impl Iterator<Item = f64> {
    exponents.map(|exponent| 10_f64.powi(exponent))
}

/// Away along every axis, in whole metres.
pub(super) fn shift(distance_m: f64) -> DAffine3 {
    at(distance_m, (0.3 * distance_m).round(), -distance_m)
}

pub(super) fn offset_by_node() -> Vec<(f64, Stage)> {
    let step = |distance_m: f64| {
        let world_from_yard = shift(distance_m);
        let lamp = world_from_yard.transform_point3(LAMP);
        (distance_m, yard(format!("{distance_m:e}-m"), 4.0, world_from_yard).point(lamp))
    };
    powers_of_ten(0..=7).map(step).collect()
}

/// The furniture with the shift written into its vertices, everything `size` times as large.
pub(super) fn baked(distance_m: f64, size: f64) -> (f64, Stage) {
    let world_from_yard = shift(distance_m) * DAffine3::from_scale(DVec3::splat(size));
    let [eye, target] = yard_eye().map(|point| world_from_yard.transform_point3(point));
    let stage = Stage::new(format!("{distance_m:e}-m"))
        .point(world_from_yard.transform_point3(LAMP))
        .eye(eye, target)
        .lens(45.0, 0.125 * size);
    let bake = |stage: Stage, shape: MeshData| stage.caster(shape.transformed(&world_from_yard));
    (distance_m, furniture(4.0).into_iter().fold(stage, bake))
}

pub(super) fn offset_exact() -> Vec<(f64, Stage)> {
    powers_of_ten(0..=7).map(|distance_m| baked(distance_m, 16.0)).collect()
}

pub(super) fn offset_rounded() -> Vec<(f64, Stage)> {
    powers_of_ten(0..=7).map(|distance_m| baked(distance_m, 1.0)).collect()
}

pub(super) fn scale() -> Vec<(f64, Stage)> {
    let step = |size: f64| {
        let world_from_yard = DAffine3::from_scale(DVec3::splat(size));
        (size, yard(format!("{size:e}"), 4.0, world_from_yard).point(LAMP * size))
    };
    powers_of_ten(-5..=5).map(step).collect()
}

pub(super) fn yard_with_lamp(step: String, floor_half_m: f32, lamp: DVec3) -> Stage {
    yard(step, floor_half_m, DAffine3::IDENTITY).point(lamp)
}

pub(super) fn light_far() -> Vec<(f64, Stage)> {
    let step = |distance_m: f64| {
        (distance_m, yard_with_lamp(format!("{distance_m:e}-m"), 4.0, LAMP.normalize() * distance_m))
    };
    [4.0].into_iter().chain(powers_of_ten(1..=7)).map(step).collect()
}

/// The lamp comes as near as a micrometre.
pub(super) fn light_near(place: DVec3, out: DVec3) -> Vec<(f64, Stage)> {
    let step = |gap_m: f64| (gap_m, yard_with_lamp(format!("{gap_m:e}-m"), 4.0, place + out * gap_m));
    powers_of_ten(-7..=-1).map(step).collect()
}

pub(super) fn grazing_sun() -> Vec<(f64, Stage)> {
    let step = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let stage = yard(format!("{degrees}-deg"), 40.0, DAffine3::IDENTITY);
        (degrees, stage.sun(p(-0.8 * cos, -sin, 0.6 * cos)))
    };
    [45.0, 10.0, 3.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01].map(step).to_vec()
}

pub(super) fn grazing_lamp() -> Vec<(f64, Stage)> {
    // The lamp sinks towards the plane of the floor.
    let step =
        |height_m: f64| (height_m, yard_with_lamp(format!("{height_m}-m"), 20.0, p(-3.0, height_m, 1.5)));
    [1.0, 0.1, 0.01, 1e-3, 1e-4].map(step).to_vec()
}

pub(super) fn overlap(stack: fn(u32) -> MeshData) -> Vec<(f64, Stage)> {
    let layers = [1, 2, 16, 127, 128, 255, 256, 257, 512, 1024, 2048, 2049, 2560, 4096, 5000];
    layers.map(|layers| (f64::from(layers), counts::under(&layers.to_string(), stack(layers)))).to_vec()
}

pub(super) fn near_plane([eye, target]: [DVec3; 2], last_m: f64) -> Vec<(f64, Stage)> {
    let step = |near_m: f64| {
        let stage = yard_with_lamp(format!("{near_m}-m"), 4.0, LAMP);
        (near_m, stage.eye(eye, target).lens(45.0, near_m))
    };
    [1e-4, 1e-3, 1e-2, 0.1, 0.5, last_m].map(step).to_vec()
}

pub(super) fn field_of_view([eye, target]: [DVec3; 2]) -> Vec<(f64, Stage)> {
    let step = |degrees: f64| {
        let stage = yard_with_lamp(format!("{degrees}-deg"), 4.0, LAMP);
        (degrees, stage.eye(eye, target).lens(degrees, 0.1))
    };
    [5.0, 15.0, 45.0, 90.0, 120.0, 150.0].map(step).to_vec()
}

pub(super) fn cone_width() -> Vec<(f64, Stage)> {
    // The axis meets the box's edge, so that however narrow the cone, there is shadow and light in it.
    let step = |degrees: f64| {
        let stage = yard(format!("{degrees}-deg"), 4.0, DAffine3::IDENTITY);
        (degrees, stage.spot(LAMP, p(0.75, 1.375, 0.0), degrees.to_radians()))
    };
    [3.0, 10.0, 20.0, 45.0, 70.0, 85.0, 90.0].map(step).to_vec()
}

pub(super) fn cone_across() -> Vec<(f64, Stage)> {
    let step = |x_m: f64| {
        let stage = yard(format!("{x_m}-m"), 4.0, DAffine3::IDENTITY);
        (x_m, stage.spot_within(LAMP, p(x_m, 0.6, 0.0), 0.25, 6.0))
    };
    [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5].map(step).to_vec()
}

pub(super) fn light_radius() -> Vec<(f64, Stage)> {
    let step = |radius_m: f64| {
        let stage = yard_with_lamp(format!("{radius_m}-m"), 4.0, LAMP);
        (radius_m, stage.radius(radius_m))
    };
    [1e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0].map(step).to_vec()
}

pub(super) fn light_angle() -> Vec<(f64, Stage)> {
    let step = |degrees: f64| {
        let stage = yard(format!("{degrees}-deg"), 4.0, DAffine3::IDENTITY).sun(-LAMP);
        (degrees, stage.half_angle(degrees))
    };
    [0.01, 0.1, 0.27, 1.0, 3.0, 10.0, 30.0].map(step).to_vec()
}

pub(super) fn texels() -> Vec<(f64, Stage)> {
    let step = |texels: u32| {
        let stage = yard(format!("{texels}"), 4.0, DAffine3::IDENTITY).point(LAMP);
        (f64::from(texels), stage.option("resolution", ParamValue::Number(f64::from(texels))))
    };
    [128, 256, 512, 1024, 2048, 4096].map(step).to_vec()
}

pub(super) fn glass_depth() -> Vec<(f64, Stage)> {
    [1, 2, 4, 8, 16, 32, 64, 128, 256].map(|boxes| (f64::from(boxes), glass::tinted_stack(boxes))).to_vec()
}

pub(super) fn glass_transmission() -> Vec<(f64, Stage)> {
    [0.0, 0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 1.0]
        .map(|share: f32| (f64::from(share), glass::dimmed(&format!("{share}"), share)))
        .to_vec()
}
