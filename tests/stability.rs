//! Sweeps: one thing of a scene goes from harmless to extreme, and nothing may be wrong on the way.
//!
//! Every step is judged by the exact reference: 0 wrong pixels outside the ambiguity band, the band no wider than it
//! may be, and a shadow to get wrong. Each step prints a row.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "rows of measurements are what a reader of the log is after")]

mod common;

use glam::{DMat4, Vec2};
use shadowgraph::engine::geometry::shapes::{cuboid, plane, quad, torus_knot};
use shadowgraph::engine::math::Projection;
use shadowgraph::measure::{evaluate, expect_shadow};
use shadowgraph::prelude::*;

const SIZE_PX: [u32; 2] = [320, 240];

/// A scene with its camera before it is put anywhere.
struct Setup {
    light: Light,
    light_position: DVec3,
    light_target: DVec3,
    eye: DVec3,
    target: DVec3,
    fov_y_deg: f64,
    near_m: f64,
    floor_half_m: f32,
    /// Puts meshes, light and camera elsewhere; scales the near distance too.
    world_from_base: DAffine3,
}

impl Default for Setup {
    fn default() -> Self {
        Self {
            light: Light::point("lamp", 30.0),
            light_position: DVec3::new(-1.0, 4.0, 1.0),
            light_target: DVec3::ZERO,
            eye: DVec3::new(3.0, 4.0, 6.0),
            target: DVec3::new(0.0, 0.5, 0.0),
            fov_y_deg: 45.0,
            near_m: 0.1,
            floor_half_m: 4.0,
            world_from_base: DAffine3::IDENTITY,
        }
    }
}

impl Setup {
    /// A closed knot, a box on the floor and an open leaf, under a node that holds `world_from_base`.
    fn scene(&self) -> Scene {
        let v = Vec3::new;
        let leaf = quad([v(-1.5, 0.75, 0.5), v(-0.75, 0.75, 0.5), v(-0.75, 1.5, -0.25), v(-1.5, 1.5, -0.25)]);
        let mut scene = Scene::new();
        let root = scene.add(None, "world", self.world_from_base, Content::Group);
        for data in [
            plane(Vec2::splat(self.floor_half_m)).named("floor"),
            cuboid(v(-0.25, 0.75, -0.5), v(0.75, 1.375, 0.5)),
            cuboid(v(1.25, 0.0, 0.75), v(1.75, 0.5, 1.25)),
            torus_knot([2, 3], 0.4, 0.1, [48, 8]).moved(v(-0.4, 2.0, -0.6)),
            leaf,
        ] {
            let key = scene.add_mesh(common::mesh(data), Material::default(), DAffine3::IDENTITY);
            scene.reparent(key, Some(root)).unwrap();
        }
        // Lights and cameras know no scale: they stand where their base places come to lie.
        let place = |p: DVec3| self.world_from_base.transform_point3(p);
        scene.add_light(self.light.clone(), place(self.light_position), place(self.light_target));
        scene.add_shadow("shadows", ShadowVolumeHard::default());
        scene
    }

    fn request(&self) -> FrameRequest {
        let place = |p: DVec3| self.world_from_base.transform_point3(p);
        let scale = DMat4::from(self.world_from_base).x_axis.length();
        let projection =
            Projection::Perspective { fov_y_rad: self.fov_y_deg.to_radians(), near_m: self.near_m * scale };
        let camera = Camera { name: "eye".into(), projection };
        FrameRequest::new(PosedCamera::looking(camera, place(self.eye), place(self.target)), SIZE_PX)
    }
}

/// Judges the default options and, where they choose z-pass, z-fail to infinity too.
fn sweep(name: &str, steps: impl IntoIterator<Item = (String, Setup)>) {
    let Some(mut renderer) = common::renderer() else { return };
    let mut failures = Vec::new();
    let mut judged = 0;
    let infinite = ShadowVolumeHard {
        depth_test: DepthTest::ZFail,
        extrusion: Extrusion::Infinite,
        ..ShadowVolumeHard::default()
    };
    for (step, setup) in steps {
        for (word, node) in [("auto", ShadowVolumeHard::default()), ("zfail", infinite)] {
            let mut scene = setup.scene();
            let key = scene.shadows().next().unwrap().0;
            *scene.shadow_mut(key).unwrap() = node.into();
            judged += 1;
            let row = format!("{name} {step} {word}");
            let errors = match evaluate(&mut renderer, &scene, &setup.request(), &|_, _| {}) {
                Ok(evaluation) => evaluation.errors,
                Err(error) => {
                    failures.push(format!("{row}: {error}"));
                    continue;
                }
            };
            let error = &errors[0];
            println!(
                "{row:<36} wrong {:>2}  out of band {}  band {:>4} of boundary {:>4}  shadow {:>5} of {:>5}  \
                 other triangle {}",
                error.wrong,
                error.wrong_outside_band,
                error.band_pixels,
                error.boundary_pixels,
                error.shadow_pixels,
                error.compared,
                error.different_triangle,
            );
            let lit = error.shadow_pixels < error.compared;
            if !error.passes() || !lit || expect_shadow(&errors).is_err() {
                failures.push(format!("{row}: {error:?}"));
            }
        }
    }
    assert!(judged > 0);
    assert!(failures.is_empty(), "{} of {judged} fail:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn far_from_the_origin() {
    sweep(
        "offset",
        (0..=6).map(|exponent| {
            let offset_m = 10_f64.powi(exponent);
            let shift = DVec3::new(offset_m, 0.3 * offset_m, -offset_m);
            let world_from_base = DAffine3::from_translation(shift);
            (format!("1e{exponent} m"), Setup { world_from_base, ..Setup::default() })
        }),
    );
}

#[test]
fn tiny_and_huge() {
    sweep(
        "scale",
        (-4..=4).map(|exponent| {
            let world_from_base = DAffine3::from_scale(DVec3::splat(10_f64.powi(exponent)));
            (format!("1e{exponent}"), Setup { world_from_base, ..Setup::default() })
        }),
    );
}

#[test]
fn grazing_sun() {
    sweep(
        "sun at",
        [45.0, 10.0, 3.0, 1.0, 0.5, 0.2, 0.1, 0.05_f64].map(|degrees| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let setup = Setup {
                light: Light::directional("sun", 3.0),
                light_position: DVec3::ZERO,
                light_target: DVec3::new(-0.8 * cos, -sin, 0.6 * cos),
                floor_half_m: 40.0,
                ..Setup::default()
            };
            (format!("{degrees} deg"), setup)
        }),
    );
}

fn sinking_lamp(heights_m: &[f64]) {
    let steps = heights_m.iter().map(|height_m| {
        let light_position = DVec3::new(-3.0, *height_m, 1.5);
        (format!("{height_m} m"), Setup { light_position, floor_half_m: 20.0, ..Setup::default() })
    });
    sweep("lamp at", steps);
}

#[test]
fn grazing_lamp() {
    // The lamp sinks towards the plane of the floor.
    sinking_lamp(&[1.0, 0.1, 0.01, 1e-3]);
}

/// Known: with sides to infinity forced, the last column of pixels is lit, probably by the driver's clipping of sides
/// that are all but edge-on; with the default ends the same frame is right.
#[test]
#[should_panic(expected = "of 2 fail")]
fn grazing_lamp_within_a_200_000th_of_the_floor() {
    skip_by_panicking("1 of 2 fail");
    sinking_lamp(&[1e-4]);
}

/// Known issues are seen on an adapter or not at all.
fn skip_by_panicking(expected: &str) {
    assert!(common::renderer().is_some(), "skipped without an adapter, as if it were so: {expected}");
}

fn approaching_light(gaps_m: &[f64]) {
    // Over the middle of the box's top, over its edge, over its corner; then beside its side.
    let places = [
        ("face", DVec3::new(0.2, 1.375, 0.1), DVec3::Y),
        ("edge", DVec3::new(0.75, 1.375, 0.1), DVec3::Y),
        ("corner", DVec3::new(0.75, 1.375, 0.5), DVec3::ONE.normalize()),
        ("side", DVec3::new(0.75, 1.0, 0.1), DVec3::X),
    ];
    let steps = places.into_iter().flat_map(|(name, place, out)| {
        gaps_m.iter().map(move |gap_m| {
            let setup = Setup { light_position: place + out * *gap_m, ..Setup::default() };
            (format!("{name} by {gap_m:e} m"), setup)
        })
    });
    sweep("light before", steps);
}

#[test]
fn light_touching_the_caster() {
    approaching_light(&[0.1, 1e-2, 1e-3, 1e-4, 0.0]);
}

/// Known: nearer than about 10⁻⁵ of the caster's size, but not touching. Seen from there an edge of one metre spans all
/// but some roundings of a half circle, and extruded directions, f32 in view space, lose what is left of it. The cure
/// would be to split such edges before they are extruded.
#[test]
#[should_panic(expected = "of 24 fail")]
fn light_almost_touching_the_caster() {
    skip_by_panicking("8 of 24 fail");
    approaching_light(&[1e-5, 1e-6, 1e-7]);
}

#[test]
fn near_plane() {
    let steps = [1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0];
    // From outside; and from within the box's shadow, where a large near rectangle is partly out of it.
    let outside = steps.map(|near_m| (format!("{near_m} m outside"), Setup { near_m, ..Setup::default() }));
    let inside = steps.map(|near_m| {
        let setup = Setup {
            near_m,
            eye: DVec3::new(0.6, 0.3, -0.2),
            target: DVec3::new(-1.5, 0.0, 2.5),
            ..Setup::default()
        };
        (format!("{near_m} m inside"), setup)
    });
    sweep("near plane", outside.into_iter().chain(inside));
}

#[test]
fn field_of_view() {
    let degrees = [5.0, 15.0, 45.0, 90.0, 120.0, 150.0];
    let outside = degrees.map(|fov_y_deg| {
        let target = DVec3::new(0.8, 0.0, -0.5);
        (format!("{fov_y_deg} deg outside"), Setup { fov_y_deg, target, ..Setup::default() })
    });
    let inside = degrees.map(|fov_y_deg| {
        // Looks at the edge of the shadow it stands in.
        let (eye, target) = (DVec3::new(0.6, 0.3, -0.2), DVec3::new(-0.19, 0.0, 0.3));
        (format!("{fov_y_deg} deg inside"), Setup { fov_y_deg, eye, target, ..Setup::default() })
    });
    sweep("fov", outside.into_iter().chain(inside));
}

#[test]
fn spot_cones() {
    // The axis meets the box's edge, so that however narrow the cone, there is shadow and light in it.
    let widths = [0.05, 0.2, 0.4, 0.8, 1.2, 1.5, std::f64::consts::FRAC_PI_2];
    let narrow = widths.map(|outer_rad| {
        let setup = Setup {
            light: Light::spot("lamp", 30.0, outer_rad),
            light_target: DVec3::new(0.75, 1.375, 0.0),
            ..Setup::default()
        };
        (format!("{outer_rad:.2} rad"), setup)
    });
    // The cone's edge sweeps over the casters.
    let swept = [-1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5].map(|x| {
        let setup = Setup {
            light: Light::spot("lamp", 30.0, 0.25).with_range(6.0),
            light_target: DVec3::new(x, 0.6, 0.0),
            ..Setup::default()
        };
        (format!("towards x {x}"), setup)
    });
    sweep("cone", narrow.into_iter().chain(swept));
}
