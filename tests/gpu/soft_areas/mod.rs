//! What the qualities of `ShadowVolumeSoft` that reckon in areas are worth: on one box, whose coverage is known in closed
//! form, on casters that overlap, and on open ones.

pub(crate) mod stage;

use glam::{DVec3, Vec3};
use shadowgraph::engine::scene::ParamValue;
use shadowgraph::engine::shadow::disc_samples;
use shadowgraph::prelude::*;
use stage::{Lamp, Pixels, Stage, block};

/// Heights of the lamp over the floor and its radius, in metres, as the methods' own measurements had them.
const LAMPS: [(f64, f64); 8] =
    [(3.0, 0.25), (3.0, 1.0), (3.0, 2.0), (4.5, 0.25), (4.5, 1.0), (6.0, 0.25), (6.0, 1.0), (6.0, 2.0)];

#[test]
fn wedges_err_as_published() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (height, radius_m) in LAMPS {
        let lamp = Lamp { p: DVec3::new(0.3, height, 0.2), radius_m };
        let errors = Stage::new(vec![block()], lamp).errors(&mut renderer, "wedge");
        println!("lamp at {height} m, radius {radius_m} m: {errors}");
        assert!(errors.penumbra > 200 && errors.rmse < 0.12 && errors.largest < 0.9, "{errors}");
        assert!(errors.rmse > 1e-4, "better than its method can be: {errors}");
    }
}

#[test]
fn what_receivers_see_of_a_box_is_exact() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (height, radius_m) in LAMPS {
        let lamp = Lamp { p: DVec3::new(0.3, height, 0.2), radius_m };
        let errors = Stage::new(vec![block()], lamp).errors(&mut renderer, "perReceiver");
        println!("lamp at {height} m, radius {radius_m} m: {errors}");
        assert!(errors.penumbra > 200 && errors.largest.max(errors.largest_outside) <= 0.0005, "{errors}");
    }
}

/// The light is its samples: so far is their share from the whole light's.
#[test]
fn samples_are_near_the_whole_light() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (samples, bound) in [(64, 0.013), (256, 0.0045)] {
        let mut worst = 0.0_f64;
        for (height, radius_m) in LAMPS.into_iter().skip(3) {
            let lamp = Lamp { p: DVec3::new(0.3, height, 0.2), radius_m };
            let options = vec![("samples", ParamValue::Number(f64::from(samples)))];
            let stage = Stage { options, ..Stage::new(vec![block()], lamp) };
            let errors = stage.errors(&mut renderer, "sampled");
            println!("{samples} samples, lamp at {height} m, radius {radius_m} m: {errors}");
            worst = worst.max(errors.rmse);
        }
        assert!(worst < bound && worst > bound / 4.0, "{samples} samples: {worst}");
    }
}

/// A level board from `low` to `high`, both sides of which cast.
fn board(low: Vec3, high: Vec3) -> MeshData {
    let corner = |x: f32, z: f32| Vec3::new(x, low.y, z);
    shapes::quad([corner(low.x, high.z), corner(high.x, high.z), corner(high.x, low.z), corner(low.x, low.z)])
}

/// Where casters overlap before the light, areas that add up hide too much; nothing is ever too light for it.
#[test]
fn overlapping_areas_add_up() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let lamp = Lamp { p: DVec3::new(0.0, 4.0, 0.0), radius_m: 0.4 };
    let first = board(Vec3::new(-2.0, 1.5, -2.0), Vec3::new(0.0, 1.5, 2.0));
    let below = board(Vec3::new(-2.0, 1.2, -2.0), Vec3::new(0.0, 1.2, 2.0));
    let across = board(Vec3::new(-2.0, 1.2, -2.0), Vec3::new(2.0, 1.2, 0.0));
    let samples = disc_samples(1024, 11);
    for (name, second, largest) in [("one below the other", below, 0.5), ("across", across, 0.25)] {
        let stage = Stage::new(vec![first.clone(), second], lamp);
        for quality in ["perReceiver", "wedge"] {
            let errors =
                stage.errors_against(&mut renderer, quality, |p| stage.right_by_samples(p, &samples));
            println!("{name}, {quality}: {errors}");
            assert!(errors.penumbra > 1000 && errors.mean < 0.0 && errors.largest <= largest, "{errors}");
            assert!(errors.largest > largest - 0.1, "better than areas can be: {errors}");
        }
    }
}

/// The block without its bottom.
fn open_block() -> MeshData {
    let mut open = block();
    let level = open.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    let bottom = |t: &[u32]| t.iter().all(|corner| open.positions[*corner as usize].y == level);
    open.indices = open.indices.chunks_exact(3).filter(|t| !bottom(t)).flatten().copied().collect();
    assert_eq!(open.indices.len(), 30);
    MeshData { parts: vec![], ..open }
}

/// How large a shadow is (in pixels of full darkness), and how many pixels its penumbra has.
fn extent(pixels: &Pixels) -> (f64, usize) {
    let darkness = pixels.iter().map(|(_, factor)| 1.0 - factor).sum();
    (darkness, pixels.iter().filter(|(_, factor)| (0.004..0.996).contains(factor)).count())
}

/// What Lindrud & Löfgren saw (§5.4): a caster that is open has a slightly larger shadow and a more compact penumbra than
/// a closed one beside it, since its layers and edges count twice. Lids over its openings cure it.
#[test]
fn open_casters_have_larger_shadows_until_they_are_closed() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let lamp = Lamp { p: DVec3::new(0.3, 4.5, 0.2), radius_m: 0.5 };
    let closed = Stage::new(vec![block()], lamp);
    let open = Stage::new(vec![open_block()], lamp);
    let option = |name, value: &str| Stage {
        options: vec![(name, ParamValue::Text(value.into()))],
        ..Stage::new(vec![open_block()], lamp)
    };
    let of = |stage: &Stage, renderer: &mut Renderer| extent(&stage.factors(renderer, "wedge"));
    let (closed, open) = (of(&closed, &mut renderer), of(&open, &mut renderer));
    let [cap, backfaces] = ["cap", "backfaces"].map(|value| of(&option("closure", value), &mut renderer));
    println!(
        "darkness and penumbra, in pixels: closed {closed:.0?}, open {open:.0?}, cap {cap:.0?}, backfaces {backfaces:.0?}"
    );
    assert!(open.0 > closed.0 * 1.02 && open.0 < closed.0 * 1.5, "not larger");
    assert!(open.1 < closed.1 * 9 / 10, "not more compact");
    assert!((cap.0 - closed.0).abs() < closed.0 * 1e-3 && cap.1.abs_diff(closed.1) < 10, "no cure");
    assert!(
        (backfaces.0 - open.0).abs() < open.0 * 1e-3,
        "a reverse for every face is the same as all faces"
    );
}
