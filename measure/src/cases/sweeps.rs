//! Sweeps: one thing of a scene goes from harmless to extreme, and nothing may be wrong on the way.
//!
//! [`all`] lists them; [`Sweep::steps`] makes the scenes, each with the value of what is swept. Like hard cases, they
//! carry one shadow node over everything; [`Case::scene_with`] puts another technique in its place. A new parameter,
//! of a light, a material or a technique's own option ([`Case::options`]), is one more row of the table.
//!
//! The reference judges the very f32 vertices that the GPU gets, so a step is right when the engine lost nothing
//! *more* than its input had lost. [`Sweep::f32_loses`] says where that input is no longer the scene that was meant.

use glam::{DAffine3, DVec3, Vec2};
use shadowgraph_engine::geometry::MeshData;
use shadowgraph_engine::geometry::shapes::{cuboid, plane, quad, torus_knot};
use shadowgraph_engine::scene::Params;
use shadowgraph_engine::shadow::TechniqueEntry;

use super::stage::{Stage, at, p, v};
use super::{About, Case, Cast, counts, glass};

/// How a sweep's parameter is best plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Equal steps.
    Linear,
    /// Equal ratios; every value is positive.
    Log,
}

/// One parameter of a scene over its range.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// A name no other sweep has.
    pub id: &'static str,
    /// What is swept.
    pub parameter: &'static str,
    /// Its unit; empty for plain numbers.
    pub unit: &'static str,
    /// How to plot it.
    pub axis: Axis,
    /// What breaks in techniques that get it wrong.
    pub what_breaks: &'static str,
    /// Where f32 must lose, and why; empty where it need not lose anywhere.
    pub f32_loses: &'static str,
    /// Which casters it is about. Of techniques through which transparent ones cast, a sweep about glass compares every quality
    /// setting.
    pub about: About,
    /// The option that is swept, where it is one.
    pub option: Option<&'static str>,
    stages: fn() -> Vec<(f64, Stage)>,
}

impl Sweep {
    /// Makes the scenes, each with the parameter's value. Cases are called after the sweep and the value.
    pub fn steps(&self, cast: &Cast) -> Vec<(f64, Case)> {
        let case = |(value, stage): (f64, Stage)| {
            (value, stage.into_case(self.id, self.what_breaks, self.about, cast))
        };
        (self.stages)().into_iter().map(case).collect()
    }

    /// Whether every quality setting of a technique is tried, not its default only.
    pub fn tries_all_of(&self, technique: &TechniqueEntry) -> bool {
        self.compares(technique) || (self.option.is_some() && self.concerns(technique))
    }

    /// Whether it is there to compare the quality settings of a technique.
    pub fn compares(&self, technique: &TechniqueEntry) -> bool {
        self.about == About::Glass && casts_transparent(technique)
    }

    /// Whether the sweep says anything about a technique: whether it has the option that is swept, and does not leave
    /// to others what is swept.
    pub fn concerns(&self, technique: &TechniqueEntry) -> bool {
        let left_out = self.about == About::Glass && !casts_transparent(technique);
        !left_out && self.option.is_none_or(|option| (technique.options)().find(option).is_some())
    }
}

/// Whether transparent surfaces cast through a technique with default options.
fn casts_transparent(technique: &TechniqueEntry) -> bool {
    (technique.from_params)(&Params::new()).is_ok_and(|technique| technique.traits().casts_transparent)
}

/// Every sweep. Listing is cheap; scenes are made by [`Sweep::steps`].
pub fn all() -> Vec<Sweep> {
    SWEEPS.to_vec()
}

const OFFSET: &str = "cracks far from the origin";
const TOUCH: &str = "directions of extrusion that lose their digits when light and caster almost touch";

/// What most sweeps have in common.
const BASE: Sweep = Sweep {
    id: "",
    parameter: "",
    unit: "m",
    axis: Axis::Log,
    what_breaks: "",
    f32_loses: "",
    about: About::Anything,
    option: None,
    stages: Vec::new,
};

const SWEEPS: &[Sweep] = &[
    Sweep {
        id: "offset-by-node",
        parameter: "distance from the origin, by a node's transform",
        what_breaks: OFFSET,
        stages: offset_by_node,
        ..BASE
    },
    Sweep {
        id: "offset-exact",
        parameter: "distance from the origin, in vertices of whole metres",
        what_breaks: OFFSET,
        stages: offset_exact,
        ..BASE
    },
    Sweep {
        id: "offset-rounded",
        parameter: "distance from the origin, in vertices of sixteenths of a metre",
        what_breaks: OFFSET,
        f32_loses: "from 2\u{b2}\u{2070} m (1.05e6) on an f32 no longer holds sixteenths, at 1e7 only whole metres: the \
                    vertices themselves are elsewhere, some on top of each other. That scene, not the one meant, is \
                    drawn exactly",
        stages: offset_rounded,
        ..BASE
    },
    Sweep {
        id: "scale",
        parameter: "size of the scene",
        unit: "",
        what_breaks: "absolute epsilons",
        stages: scale,
        ..BASE
    },
    Sweep {
        id: "light-far",
        parameter: "distance of a lamp",
        what_breaks: "a far lamp's position swamps the vertices it is subtracted from",
        stages: light_far,
        ..BASE
    },
    Sweep {
        id: "light-near-face",
        parameter: "distance of a lamp from a box's face",
        what_breaks: TOUCH,
        stages: || light_near(p(0.2, 1.375, 0.1), DVec3::Y),
        ..BASE
    },
    Sweep {
        id: "light-near-edge",
        parameter: "distance of a lamp from a box's edge",
        what_breaks: TOUCH,
        stages: || light_near(p(0.75, 1.375, 0.1), DVec3::Y),
        ..BASE
    },
    Sweep {
        id: "light-near-corner",
        parameter: "distance of a lamp from a box's corner",
        what_breaks: TOUCH,
        stages: || light_near(p(0.75, 1.375, 0.5), DVec3::ONE.normalize()),
        ..BASE
    },
    Sweep {
        id: "light-near-side",
        parameter: "distance of a lamp from a box's side",
        what_breaks: TOUCH,
        stages: || light_near(p(0.75, 1.0, 0.1), DVec3::X),
        ..BASE
    },
    Sweep {
        id: "grazing-sun",
        parameter: "height of the sun",
        unit: "deg",
        what_breaks: "near-infinite shadows and all but parallel planes",
        stages: grazing_sun,
        ..BASE
    },
    Sweep {
        id: "grazing-lamp",
        parameter: "height of a lamp over the floor",
        what_breaks: "near-infinite shadows and all but parallel planes",
        stages: grazing_lamp,
        ..BASE
    },
    Sweep {
        id: "overlap-closed",
        parameter: "boxes between light and floor",
        unit: "",
        what_breaks: "counts wrap at multiples of 256 and lose integers above 2048",
        stages: || overlap(counts::boxes),
        ..BASE
    },
    Sweep {
        id: "overlap-open",
        parameter: "sheets between light and floor",
        unit: "",
        what_breaks: "counts wrap at multiples of 256 and lose integers above 2048",
        stages: || overlap(counts::quads),
        ..BASE
    },
    Sweep {
        id: "near-plane",
        parameter: "near distance, the eye in the light",
        what_breaks: "holes where the near plane cuts a volume; depth without digits",
        stages: || near_plane(yard_eye(), 1.0),
        ..BASE
    },
    Sweep {
        id: "near-plane-in-shadow",
        parameter: "near distance, the eye in the shadow",
        what_breaks: "z-pass chosen for a near rectangle that is partly in shadow",
        stages: || near_plane([p(0.6, 0.3, -0.2), p(-1.5, 0.0, 2.5)], 0.7),
        ..BASE
    },
    Sweep {
        id: "field-of-view",
        parameter: "opening angle, the eye in the light",
        unit: "deg",
        axis: Axis::Linear,
        what_breaks: "bounds of the near rectangle",
        stages: || field_of_view([yard_eye()[0], p(0.8, 0.0, -0.5)]),
        ..BASE
    },
    Sweep {
        id: "field-of-view-in-shadow",
        parameter: "opening angle, the eye in the shadow",
        unit: "deg",
        axis: Axis::Linear,
        what_breaks: "bounds of the near rectangle",
        // Looks at the edge of the shadow it stands in.
        stages: || field_of_view([p(0.6, 0.3, -0.2), p(-0.19, 0.0, 0.3)]),
        ..BASE
    },
    Sweep {
        id: "cone-width",
        parameter: "half-angle of a spot's cone",
        unit: "deg",
        what_breaks: "scissors and culling by the cone",
        stages: cone_width,
        ..BASE
    },
    Sweep {
        id: "cone-across",
        parameter: "where a spot's axis meets the scene",
        axis: Axis::Linear,
        what_breaks: "casters culled at the cone's edge",
        stages: cone_across,
        ..BASE
    },
    Sweep {
        id: "light-radius",
        parameter: "radius of a lamp",
        what_breaks: "a light larger than its casters, than the scene, than the distance to them",
        option: Some("radius"),
        stages: light_radius,
        ..BASE
    },
    Sweep {
        id: "light-angle",
        parameter: "half-angle of the sun",
        unit: "deg",
        what_breaks: "a light larger than its casters",
        option: Some("angle"),
        stages: light_angle,
        ..BASE
    },
    Sweep {
        id: "glass-depth",
        parameter: "tinted boxes between light and floor",
        unit: "",
        what_breaks: "logarithms and products lose digits with every layer",
        about: About::Glass,
        stages: glass_depth,
        ..BASE
    },
    Sweep {
        id: "glass-transmission",
        parameter: "what a surface lets pass",
        unit: "",
        axis: Axis::Linear,
        what_breaks: "logarithms of next to nothing",
        about: About::Glass,
        stages: glass_transmission,
        ..BASE
    },
];

fn yard_eye() -> [DVec3; 2] {
    [p(3.0, 4.0, 6.0), p(0.0, 0.5, 0.0)]
}

/// What stands in the yard: a floor, two boxes, an open leaf. All coordinates are multiples of 1/16 m.
fn furniture(floor_half_m: f32) -> Vec<MeshData> {
    vec![
        plane(Vec2::splat(floor_half_m)).named("floor"),
        cuboid(v(-0.25, 0.75, -0.5), v(0.75, 1.375, 0.5)).named("box"),
        cuboid(v(1.25, 0.0, 0.75), v(1.75, 0.5, 1.25)).named("crate"),
        quad([v(-1.5, 0.75, 0.5), v(-0.75, 0.75, 0.5), v(-0.75, 1.5, -0.25), v(-1.5, 1.5, -0.25)])
            .named("leaf"),
    ]
}

/// The yard with a knot in it, put elsewhere by every mesh's node; near distance 0.1 m there. No light yet.
fn yard(step: impl Into<String>, floor_half_m: f32, world_from_yard: DAffine3) -> Stage {
    let [eye, target] = yard_eye().map(|point| world_from_yard.transform_point3(point));
    let knot = torus_knot([2, 3], 0.4, 0.1, [48, 8]).moved(v(-0.4, 2.0, -0.6));
    let stage = Stage::new(step).eye(eye, target).lens(45.0, 0.1 * world_from_yard.matrix3.x_axis.length());
    let shapes = furniture(floor_half_m).into_iter().chain([knot]);
    shapes.fold(stage, |stage, shape| stage.caster_at(shape, world_from_yard))
}

/// The yard's lamp, unless the lamp is what is swept.
const LAMP: DVec3 = DVec3::new(-1.0, 4.0, 1.0);

fn powers_of_ten(exponents: std::ops::RangeInclusive<i32>) -> impl Iterator<Item = f64> {
    exponents.map(|exponent| 10_f64.powi(exponent))
}

/// Away along every axis, in whole metres.
fn shift(distance_m: f64) -> DAffine3 {
    at(distance_m, (0.3 * distance_m).round(), -distance_m)
}

fn offset_by_node() -> Vec<(f64, Stage)> {
    let step = |distance_m: f64| {
        let world_from_yard = shift(distance_m);
        let lamp = world_from_yard.transform_point3(LAMP);
        (distance_m, yard(format!("{distance_m:e}-m"), 4.0, world_from_yard).point(lamp))
    };
    powers_of_ten(0..=7).map(step).collect()
}

/// The furniture with the shift written into its vertices, everything `size` times as large.
fn baked(distance_m: f64, size: f64) -> (f64, Stage) {
    let world_from_yard = shift(distance_m) * DAffine3::from_scale(DVec3::splat(size));
    let [eye, target] = yard_eye().map(|point| world_from_yard.transform_point3(point));
    let stage = Stage::new(format!("{distance_m:e}-m"))
        .point(world_from_yard.transform_point3(LAMP))
        .eye(eye, target)
        .lens(45.0, 0.125 * size);
    let bake = |stage: Stage, shape: MeshData| stage.caster(shape.transformed(&world_from_yard));
    (distance_m, furniture(4.0).into_iter().fold(stage, bake))
}

fn offset_exact() -> Vec<(f64, Stage)> {
    powers_of_ten(0..=7).map(|distance_m| baked(distance_m, 16.0)).collect()
}

fn offset_rounded() -> Vec<(f64, Stage)> {
    powers_of_ten(0..=7).map(|distance_m| baked(distance_m, 1.0)).collect()
}

fn scale() -> Vec<(f64, Stage)> {
    let step = |size: f64| {
        let world_from_yard = DAffine3::from_scale(DVec3::splat(size));
        (size, yard(format!("{size:e}"), 4.0, world_from_yard).point(LAMP * size))
    };
    powers_of_ten(-5..=5).map(step).collect()
}

fn yard_with_lamp(step: String, floor_half_m: f32, lamp: DVec3) -> Stage {
    yard(step, floor_half_m, DAffine3::IDENTITY).point(lamp)
}

fn light_far() -> Vec<(f64, Stage)> {
    let step = |distance_m: f64| {
        (distance_m, yard_with_lamp(format!("{distance_m:e}-m"), 4.0, LAMP.normalize() * distance_m))
    };
    [4.0].into_iter().chain(powers_of_ten(1..=7)).map(step).collect()
}

/// The lamp comes as near as a micrometre.
fn light_near(place: DVec3, out: DVec3) -> Vec<(f64, Stage)> {
    let step = |gap_m: f64| (gap_m, yard_with_lamp(format!("{gap_m:e}-m"), 4.0, place + out * gap_m));
    powers_of_ten(-7..=-1).map(step).collect()
}

fn grazing_sun() -> Vec<(f64, Stage)> {
    let step = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let stage = yard(format!("{degrees}-deg"), 40.0, DAffine3::IDENTITY);
        (degrees, stage.sun(p(-0.8 * cos, -sin, 0.6 * cos)))
    };
    [45.0, 10.0, 3.0, 1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01].map(step).to_vec()
}

fn grazing_lamp() -> Vec<(f64, Stage)> {
    // The lamp sinks towards the plane of the floor.
    let step =
        |height_m: f64| (height_m, yard_with_lamp(format!("{height_m}-m"), 20.0, p(-3.0, height_m, 1.5)));
    [1.0, 0.1, 0.01, 1e-3, 1e-4].map(step).to_vec()
}

fn overlap(stack: fn(u32) -> MeshData) -> Vec<(f64, Stage)> {
    let layers = [1, 2, 16, 127, 128, 255, 256, 257, 512, 1024, 2048, 2049, 2560, 4096, 5000];
    layers.map(|layers| (f64::from(layers), counts::under(&layers.to_string(), stack(layers)))).to_vec()
}

fn near_plane([eye, target]: [DVec3; 2], last_m: f64) -> Vec<(f64, Stage)> {
    let step = |near_m: f64| {
        let stage = yard_with_lamp(format!("{near_m}-m"), 4.0, LAMP);
        (near_m, stage.eye(eye, target).lens(45.0, near_m))
    };
    [1e-4, 1e-3, 1e-2, 0.1, 0.5, last_m].map(step).to_vec()
}

fn field_of_view([eye, target]: [DVec3; 2]) -> Vec<(f64, Stage)> {
    let step = |degrees: f64| {
        let stage = yard_with_lamp(format!("{degrees}-deg"), 4.0, LAMP);
        (degrees, stage.eye(eye, target).lens(degrees, 0.1))
    };
    [5.0, 15.0, 45.0, 90.0, 120.0, 150.0].map(step).to_vec()
}

fn cone_width() -> Vec<(f64, Stage)> {
    // The axis meets the box's edge, so that however narrow the cone, there is shadow and light in it.
    let step = |degrees: f64| {
        let stage = yard(format!("{degrees}-deg"), 4.0, DAffine3::IDENTITY);
        (degrees, stage.spot(LAMP, p(0.75, 1.375, 0.0), degrees.to_radians()))
    };
    [3.0, 10.0, 20.0, 45.0, 70.0, 85.0, 90.0].map(step).to_vec()
}

fn cone_across() -> Vec<(f64, Stage)> {
    let step = |x_m: f64| {
        let stage = yard(format!("{x_m}-m"), 4.0, DAffine3::IDENTITY);
        (x_m, stage.spot_within(LAMP, p(x_m, 0.6, 0.0), 0.25, 6.0))
    };
    [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5].map(step).to_vec()
}

fn light_radius() -> Vec<(f64, Stage)> {
    let step = |radius_m: f64| {
        let stage = yard_with_lamp(format!("{radius_m}-m"), 4.0, LAMP);
        (radius_m, stage.radius(radius_m))
    };
    [1e-3, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0].map(step).to_vec()
}

fn light_angle() -> Vec<(f64, Stage)> {
    let step = |degrees: f64| {
        let stage = yard(format!("{degrees}-deg"), 4.0, DAffine3::IDENTITY).sun(-LAMP);
        (degrees, stage.half_angle(degrees))
    };
    [0.01, 0.1, 0.27, 1.0, 3.0, 10.0, 30.0].map(step).to_vec()
}

fn glass_depth() -> Vec<(f64, Stage)> {
    [1, 2, 4, 8, 16, 32, 64, 128, 256].map(|boxes| (f64::from(boxes), glass::tinted_stack(boxes))).to_vec()
}

fn glass_transmission() -> Vec<(f64, Stage)> {
    [0.0, 0.01, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99, 1.0]
        .map(|share: f32| (f64::from(share), glass::dimmed(&format!("{share}"), share)))
        .to_vec()
}
