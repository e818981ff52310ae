//! The reference for lights with a size against closed forms, against the hard reference, and against itself.

use std::f64::consts::PI;

use glam::{DVec3, DVec4};
use shadowgraph::cases::{self, Case};
use shadowgraph::engine::scene::SceneSnapshot;
use shadowgraph::engine::shadow::LightDisc;
use shadowgraph::measure::{
    Hit, LightQuery, LightSize, Measured, Reference, ReferenceImage, Samples, SizedCasters, compare,
    convex_visible_share, disc_samples,
};

const SIZE_PX: [u32; 2] = [96, 96];

fn case(name: &str) -> Case {
    let cases = cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST));
    cases.into_iter().find(|case| case.name() == name).unwrap_or_else(|| panic!("no case is called '{name}'"))
}

fn query(snapshot: &SceneSnapshot) -> LightQuery {
    LightQuery { casters: (0..snapshot.instances.len()).collect(), ..LightQuery::default() }
}

fn sized(snapshot: &SceneSnapshot, size: LightSize, samples: Samples) -> LightQuery {
    let casters = query(snapshot).casters;
    LightQuery {
        sized: vec![SizedCasters { casters, transparent: vec![], size, samples }],
        ..LightQuery::default()
    }
}

fn render_with(case: &Case, size: LightSize, samples: Samples) -> ReferenceImage {
    let snapshot = case.scene.snapshot().unwrap();
    let lights = [sized(&snapshot, size, samples)];
    Reference::new(&snapshot).render(&case.camera, SIZE_PX, &lights, &|_, _| {})
}

fn render(case: &Case, size: LightSize, samples: u32) -> ReferenceImage {
    render_with(case, size, Samples::Converged(samples))
}

fn size_of(case: &Case) -> LightSize {
    LightSize::of(&case.options)
}

/// Where the floor (y = 0, instance 0) is seen: pixel and point.
fn floor_points(case: &Case, image: &ReferenceImage) -> Vec<(usize, DVec3)> {
    let [width, height] = SIZE_PX.map(f64::from);
    let point = |pixel: usize| {
        let (x, y) = ((pixel % 96) as f64 + 0.5, (pixel / 96) as f64 + 0.5);
        let (ndc_x, ndc_y) = (2.0 * x / width - 1.0, 1.0 - 2.0 * y / height);
        let (from, direction) = case.camera.projection.view_ray(ndc_x, ndc_y, width / height);
        let from = case.camera.world_from_view.transform_point3(from);
        let direction = case.camera.world_from_view.transform_vector3(direction);
        from + direction * (-from.y / direction.y)
    };
    let on_floor = |hit: &Option<Hit>| hit.is_some_and(|hit| hit.instance == 0);
    let hits = image.hits.iter().enumerate().filter(|(_, hit)| on_floor(hit));
    hits.map(|(pixel, _)| (pixel, point(pixel))).collect()
}

/// The share of the unit disc beyond a chord at signed distance `t` from the centre.
fn beyond(t: f64) -> f64 {
    let t = t.clamp(-1.0, 1.0);
    (t.acos() - t * (1.0 - t * t).sqrt()) / PI
}

/// Compares with a closed form wherever there is one; prints and bounds the error over the penumbra.
fn compare_with(
    name: &str,
    image: &ReferenceImage,
    exact: impl Iterator<Item = (usize, f64)>,
    max_error: f64,
    least: usize,
) {
    let (mut count, mut penumbra, mut sum, mut max) = (0, 0_usize, 0.0, 0.0_f64);
    for (pixel, exact) in exact {
        let difference = f64::from(image.lights[0].factor[pixel]) - exact;
        count += 1;
        max = max.max(difference.abs());
        if exact > 0.0 && exact < 1.0 {
            penumbra += 1;
            sum += difference * difference;
        } else {
            assert!(difference == 0.0, "{name}: off by {difference} outside the penumbra");
        }
    }
    let rmse = (sum / penumbra.max(1) as f64).sqrt();
    println!("{name}: {penumbra} of {count} pixels in the penumbra, rmse {rmse:.5}, max {max:.5}");
    assert!(penumbra > least && count > penumbra, "{name}: too little to compare");
    assert!(max <= max_error && rmse <= max_error / 3.0, "{name}: rmse {rmse}, max {max}");
}

/// The factor over a floor point under a half-plane y = `height`, x < 0.
fn under_half_plane(point: DVec3, center: DVec3, radius_m: f64, height: f64) -> f64 {
    let to_center = center - point;
    let distance = to_center.length();
    // The plane of the point and the edge, its normal to the lit side.
    let normal = (DVec3::new(0.0, height, point.z) - point).cross(DVec3::Z).normalize();
    let sin = normal.dot(to_center / distance);
    let disc_radius = radius_m * distance / (distance * distance - radius_m * radius_m).sqrt();
    beyond(-sin / (1.0 - sin * sin).sqrt() * distance / disc_radius)
}

#[test]
fn a_half_plane_before_a_lamp_is_the_closed_form() {
    for name in ["edge-through-centre/lamp", "edge-through-centre/turned"] {
        let case = case(name);
        let image = render(&case, size_of(&case), 4096);
        let center = DVec3::new(0.0, 4.0, 0.0);
        // Near the edge's middle, where the board's other edges are out of the way.
        let near =
            floor_points(&case, &image).into_iter().filter(|(_, p)| p.x.abs() < 0.6 && p.z.abs() < 1.5);
        compare_with(
            name,
            &image,
            near.map(|(pixel, p)| (pixel, under_half_plane(p, center, 0.3, 1.5))),
            0.005,
            100,
        );
    }
}

#[test]
fn a_half_plane_before_the_sun_is_the_closed_form() {
    let case = case("edge-through-centre/sun");
    let size = LightSize { half_angle_rad: 10_f64.to_radians(), ..LightSize::NONE };
    let image = render(&case, size, 4096);
    let slope = size.half_angle_rad.tan();
    let near = floor_points(&case, &image).into_iter().filter(|(_, p)| p.x.abs() < 0.6 && p.z.abs() < 1.5);
    compare_with("sun", &image, near.map(|(pixel, p)| (pixel, beyond(-p.x / (1.5 * slope)))), 0.005, 100);
}

#[test]
fn samples_converge_and_overlaps_count_once() {
    // One board above another on the same side: as the lower alone.
    let case = case("penumbra-overlap/same-side");
    let center = DVec3::new(0.0, 4.0, 0.0);
    let mut last = f64::INFINITY;
    for samples in [64, 1024, 4096] {
        let image = render(&case, size_of(&case), samples);
        let near =
            floor_points(&case, &image).into_iter().filter(|(_, p)| p.x.abs() < 0.5 && p.z.abs() < 1.2);
        let exact = near.map(|(pixel, p)| {
            let [a, b] = [1.5, 1.2].map(|height| under_half_plane(p, center, 0.4, height));
            (pixel, a.min(b))
        });
        let exact: Vec<_> = exact.collect();
        let squares = exact.iter().map(|(pixel, f)| (f64::from(image.lights[0].factor[*pixel]) - f).powi(2));
        let rmse = (squares.sum::<f64>() / exact.len() as f64).sqrt();
        println!("{samples} samples: rmse {rmse:.5} over {} pixels", exact.len());
        assert!(rmse < last / 2.0 && rmse < 0.25 / f64::from(samples).sqrt(), "{rmse} after {last}");
        last = rmse;
    }
}

#[test]
fn without_size_and_inside_the_sphere_it_is_the_hard_shadow() {
    for name in ["radius-0/lamp", "radius-0/sun", "light-touches-caster/face"] {
        let case = case(name);
        let snapshot = case.scene.snapshot().unwrap();
        let hard = Reference::new(&snapshot).render(&case.camera, SIZE_PX, &[query(&snapshot)], &|_, _| {});
        let image = render(&case, LightSize::NONE, 4096);
        // NaN is not equal to itself: bits are.
        let bits =
            |image: &ReferenceImage| image.lights[0].factor.iter().map(|f| f.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&hard), bits(&image), "{name}");
    }
    // Every surface in view is within the sphere.
    let case = case("receiver-inside-light");
    let snapshot = case.scene.snapshot().unwrap();
    let hard = Reference::new(&snapshot).render(&case.camera, SIZE_PX, &[query(&snapshot)], &|_, _| {});
    let image = render(&case, LightSize { radius_m: 50.0, ..LightSize::NONE }, 256);
    let light = &hard.lights[0];
    let judged = (0..light.factor.len()).filter(|pixel| light.compared[*pixel]);
    let differing = judged.filter(|pixel| light.factor[*pixel] != image.lights[0].factor[*pixel]).count();
    assert_eq!(differing, 0);
}

#[test]
fn it_is_what_asking_every_sample_gives() {
    // Every sample at every pixel by the plain question: is it blocked?
    for name in ["tripod", "caster-in-light/box", "penumbra-overlap/half-planes"] {
        let case = case(name);
        let size = size_of(&case);
        let snapshot = case.scene.snapshot().unwrap();
        let reference = Reference::new(&snapshot);
        let image = render(&case, size, 256);
        let casters = reference.caster_set(&query(&snapshot).casters);
        let light = snapshot.lights[0].position;
        let mut tracer = reference.tracer();
        let mut penumbra = 0;
        for (pixel, point) in floor_points(&case, &image) {
            let to_light = light.truncate() - point;
            let LightDisc { radius, u, v } = size.disc(to_light.extend(1.0));
            let samples = disc_samples(256, 1);
            let lit = samples.iter().filter(|sample| {
                let position = light + ((u * sample.x + v * sample.y) * radius).extend(0.0);
                !tracer.is_blocked(point, image.hits[pixel], position, &casters)
            });
            let exact = lit.count() as f32 / 256.0;
            penumbra += usize::from(exact > 0.0 && exact < 1.0);
            // The floor's points are computed otherwise here: a sample may fall to the other side of an edge.
            let difference = (exact - image.lights[0].factor[pixel]).abs();
            assert!(difference <= 1.5 / 256.0, "{name}: {exact} is not {}", image.lights[0].factor[pixel]);
        }
        println!("{name}: {penumbra} penumbra pixels");
        assert!(penumbra > 20, "{name}: {penumbra}");
    }
}

/// The errors of a picture that has the reference's factors, changed by `change(pixel, factor)`.
fn errors(image: &ReferenceImage, change: impl Fn(usize, f32) -> f32) -> shadowgraph::measure::LightError {
    let ids = image.hits.iter().map(|hit| hit.map_or([u32::MAX; 2], |hit| [hit.instance, hit.triangle]));
    let light = &image.lights[0];
    let factor = light.factor.iter().enumerate().map(|(pixel, factor)| change(pixel, *factor)).collect();
    let lights = vec![(light.name.clone(), factor)];
    compare(&Measured { size_px: image.size_px, ids: ids.collect(), lights }, image).unwrap().remove(0)
}

#[test]
fn one_sample_too_many_at_one_pixel_is_outside() {
    for count in [16, 64, 1024] {
        let case = case("penumbra-overlap/half-planes");
        let image = render_with(&case, size_of(&case), Samples::Same(count));
        let soft = image.lights[0].soft.as_ref().unwrap();
        assert_eq!(soft.same_samples, Some(count));
        let same = errors(&image, |_, factor| factor);
        println!(
            "{count}: {} of {} pixels ambiguous, band {:.1} against boundary {:.1}",
            same.band_pixels,
            same.compared,
            soft.bounds.iter().filter(|b| b[1] < 1.0).map(|b| b[1] - b[0]).sum::<f32>(),
            soft.boundary_px
        );
        assert!(same.passes() && same.outside_bounds == 0 && !same.band_too_wide, "{same:?}");
        // Any factor that ambiguous samples allow is right; one sample more is not.
        let bounds = |pixel: usize| soft.bounds[pixel];
        assert!(errors(&image, |pixel, _| bounds(pixel)[0]).passes());
        assert!(errors(&image, |pixel, _| bounds(pixel)[1]).passes());
        let settled = |pixel: &usize| {
            let [least, largest] = bounds(*pixel);
            image.lights[0].compared[*pixel] && least == largest && least > 0.2 && least < 0.8
        };
        let pixel = (0..soft.bounds.len()).find(settled).unwrap();
        let off =
            errors(&image, |other, factor| if other == pixel { factor + 1.0 / count as f32 } else { factor });
        assert_eq!((off.outside_bounds, off.passes(), off.wrong), (1, false, 0), "{off:?}");
        assert!(off.leak_mean > 0.0 && off.false_mean == 0.0);
    }
}

#[test]
fn parts_of_a_light_are_multiplied() {
    // The floor and one board cast as for a point, the other board as for a disc.
    let case = case("penumbra-overlap/half-planes");
    let size = size_of(&case);
    let snapshot = case.scene.snapshot().unwrap();
    let reference = Reference::new(&snapshot);
    let samples = Samples::Same(64);
    let hard = LightQuery { casters: vec![0, 1], ..LightQuery::default() };
    let part = SizedCasters { casters: vec![2], transparent: vec![], size, samples };
    let soft = LightQuery { sized: vec![part.clone()], ..LightQuery::default() };
    let both = LightQuery { sized: vec![part], ..hard.clone() };
    let image = reference.render(&case.camera, SIZE_PX, &[hard, soft, both], &|_, _| {});
    let [hard, soft, both] = &image.lights[..] else { panic!("three lights") };
    let (mut dark, mut between) = (0, 0);
    for pixel in (0..both.factor.len()).filter(|pixel| both.compared[*pixel]) {
        let product = hard.factor[pixel] * soft.factor[pixel];
        assert_eq!(both.factor[pixel], product);
        let [least, largest] = both.soft.as_ref().unwrap().bounds[pixel];
        assert!(least <= product && product <= largest);
        assert_eq!(both.ambiguous[pixel], hard.ambiguous[pixel] || soft.ambiguous[pixel]);
        dark += usize::from(hard.factor[pixel] == 0.0 && soft.factor[pixel] > 0.0);
        between += usize::from(product > 0.0 && product < 1.0);
    }
    assert!(dark > 50 && between > 50, "{dark}, {between}");
    assert_eq!(both.soft.as_ref().unwrap().same_samples, Some(64));
}

#[test]
fn one_box_is_the_closed_form() {
    for name in ["penumbra-width/low", "penumbra-width/middle", "penumbra-width/high"] {
        let case = case(name);
        let snapshot = case.scene.snapshot().unwrap();
        let [_, caster] = &snapshot.instances[..] else { panic!("a floor and a box") };
        let vertices = 0..caster.mesh.positions().len() as u32;
        let corners: Vec<DVec3> = vertices.map(|vertex| caster.world_position(vertex)).collect();
        let lamp = snapshot.lights[0].position;
        let sun = DVec4::new(-0.2, 1.0, 0.1, 0.0);
        let wide = LightSize { half_angle_rad: 0.15, ..LightSize::NONE };
        for (light, size) in
            [(lamp, size_of(&case)), (lamp, LightSize { radius_m: 0.7, ..wide }), (sun, wide)]
        {
            let mut snapshot = snapshot.clone();
            snapshot.lights[0].position = light;
            let query = sized(&snapshot, size, Samples::Converged(4096));
            let image = Reference::new(&snapshot).render(&case.camera, SIZE_PX, &[query], &|_, _| {});
            let share = |point| convex_visible_share(&corners, point, Some(DVec3::Y), light, size);
            let exact = floor_points(&case, &image).into_iter().map(|(pixel, point)| (pixel, share(point)));
            compare_with(&format!("{name} {size:?}"), &image, exact, 0.006, 50);
        }
    }
}

/// What the whole table costs with 64 samples at every pixel; `cargo test --test reference whole_table -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement"]
fn the_whole_table_is_traced_in_minutes() {
    let size = LightSize { radius_m: 0.2, half_angle_rad: 1_f64.to_radians() };
    let start = std::time::Instant::now();
    let (mut variants, mut slowest) = (0, Vec::new());
    for case in cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST)) {
        let snapshot = case.scene.snapshot().unwrap();
        let start = std::time::Instant::now();
        let lights = (0..snapshot.lights.len())
            .map(|light| LightQuery { light, ..sized(&snapshot, size, Samples::Same(64)) });
        let lights: Vec<_> = lights.collect();
        Reference::new(&snapshot).render(&case.camera, case.size_px, &lights, &|_, _| {});
        slowest.push((start.elapsed().as_secs_f64(), case.name()));
        variants += 1;
    }
    slowest.sort_by(|a, b| b.0.total_cmp(&a.0));
    println!("{variants} variants in {:.1} s", start.elapsed().as_secs_f64());
    slowest.iter().take(12).for_each(|(seconds, name)| println!("{seconds:7.2} s  {name}"));
}
