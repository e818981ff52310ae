//! `closure`: Lindrud & Löfgren 2004 §3.1, their open cube among others.

use shadowgraph::measure::{Reference, compare, queries};
use shadowgraph::prelude::*;

use super::stage::{errors, floor, open_box, p, request, scene, with_node};

const TOP: usize = 2;
const BOTTOM: usize = 3;
const FRONT: usize = 4;

fn closed_by(closure: Closure) -> ShadowVolumeHard {
    ShadowVolumeHard { closure, ..Default::default() }
}

/// "A cube with one face removed, a smaller (closed) model sitting inside it, and a light shining into the open side."
fn their_example() -> Scene {
    let small = open_box("small", [0.1, 0.35, 0.0], 0.2, &[]);
    scene(vec![floor(), open_box("cube", [0.0, 0.6, 0.0], 0.5, &[TOP]), small], &[p(0.4, 4.0, 0.3)])
}

#[test]
fn capping_darkens_the_inside_of_an_open_cube_and_backfaces_do_not() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let example = their_example();
    let from_above = request(p(0.6, 3.0, 1.6), p(0.0, 0.4, 0.0));
    for closure in [Closure::None, Closure::Backfaces] {
        let scene = with_node(&example, closed_by(closure));
        let errors = errors(&mut renderer, &format!("{closure:?}"), &scene, &from_above);
        assert!(errors.iter().all(|error| error.passes()), "{closure:?} is exact");
    }
    let errors = errors(&mut renderer, "Cap", &with_node(&example, closed_by(Closure::Cap)), &from_above);
    let [error] = &errors[..] else { panic!("one light") };
    // All that is seen of the lit inside, a twentieth of the picture, is dark; nothing else is wrong.
    assert!(error.false_outside_band > 3000, "{error:?}");
    assert_eq!(error.leak_outside_band, 0, "{error:?}");
    assert!(!error.passes(), "the table must not call this exact");
}

#[test]
fn a_cap_casts_exactly_like_a_lid() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    // From inside the cube, looking down, the lid is behind the eye: both scenes show the same surfaces.
    let from_inside = request(p(-0.3, 0.9, -0.3), p(0.1, 0.3, 0.1));
    let capped = with_node(&their_example(), closed_by(Closure::Cap));
    let measured = shadowgraph_testing::measure(&mut renderer, &capped, &from_inside).unwrap();
    let mut lidded = their_example();
    let lid = open_box("lid", [0.0, 0.6, 0.0], 0.5, &[0, 1, 3, 4, 5]);
    lidded.add_mesh(shadowgraph_testing::mesh(lid), Material::default(), DAffine3::IDENTITY);
    lidded.add_shadow("shadows", ShadowVolumeHard::default());
    let (snapshot, registry) = renderer.snapshot(&lidded).unwrap();
    let reference = Reference::new(&snapshot).render(
        &from_inside.camera,
        from_inside.size_px,
        &queries(&registry),
        &|_, _| {},
    );
    let errors = compare(&measured, &reference).unwrap();
    assert!(errors[0].passes() && errors[0].shadow_pixels == errors[0].compared, "{errors:?}");
    assert!(errors[0].compared > 60_000, "{errors:?}");
}

#[test]
fn capping_closes_the_opening_before_a_light_inside() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let lantern =
        scene(vec![floor(), open_box("lantern", [0.0, 1.0, 0.0], 0.5, &[FRONT])], &[p(0.0, 1.0, 0.0)]);
    let view = request(p(2.5, 2.5, 4.0), p(0.0, 0.2, 0.6));
    let none = errors(&mut renderer, "none", &with_node(&lantern, closed_by(Closure::None)), &view);
    let backfaces =
        errors(&mut renderer, "backfaces", &with_node(&lantern, closed_by(Closure::Backfaces)), &view);
    assert!(none[0].passes() && backfaces[0].passes());
    let cap = errors(&mut renderer, "cap", &with_node(&lantern, closed_by(Closure::Cap)), &view);
    // The patch of light on the floor is gone.
    assert!(cap[0].false_outside_band > 2000 && cap[0].leak_outside_band == 0, "{cap:?}");
}

#[test]
fn capping_is_exact_where_no_light_comes_through_the_opening() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    for (name, missing, light) in [
        ("below", BOTTOM, p(1.5, 4.0, 0.5)),
        ("away", FRONT, p(0.5, 3.0, -3.0)),
        ("low", TOP, p(3.0, 0.9, 0.4)),
    ] {
        let cup = scene(vec![floor(), open_box("cup", [0.0, 0.9, 0.0], 0.5, &[missing])], &[light]);
        let view = request(p(-1.5, 2.5, -4.0), p(-0.5, 0.2, 0.0));
        let errors = errors(&mut renderer, name, &with_node(&cup, closed_by(Closure::Cap)), &view);
        assert!(errors[0].passes(), "{name}");
    }
}
