//! The random search: its scenes are what their families say, it sees broken techniques, and a fixed set of seeds is right.

use std::sync::Arc;

use crate::broken::{Broken, Spoil};
use crate::known::KNOWN_SEEDS;
use shadowgraph::engine::shadow::{Catalog, TechniqueEntry};
use shadowgraph::engine::shadow::{Draw, Geometry};
use shadowgraph::measure::evaluate;
use shadowgraph::prelude::*;
use shadowgraph::search::{
    Bend, Brute, FailureKind, Family, Judge, Recipe, Tally, Verdict, Wear, recipe_of, shrink,
};

/// The seeds that every change must pass: about a minute on two cores.
pub(crate) const FIXED_SEEDS: std::ops::Range<u64> = 0..450;

/// Seeds by which the search found faults that are mended: each a scene of its own, of the kind that its number says.
pub(crate) const MENDED_SEEDS: &[u64] = &[
    90_737, 91_054, 200_222, 201_415, 202_153, 202_789, 203_018, 301_543, 402_994, 403_549, 404_833, 500_603,
    503_614, 503_807, 600_058, 7_001_572, 9_002_100, 9_002_756, 9_501_271, 15_003_252, 15_003_447,
];

/// The same of kinds that were searched by themselves.
pub(crate) const MENDED_OF_KIND: &[(Family, u64)] =
    &[(Family::Soup, 16_000_757), (Family::Stretched, 16_000_737)];

#[test]
fn the_fixed_seeds_are_right() {
    let Some(renderer) = shadowgraph_testing::renderer() else { return };
    let mut judge = Judge::new(renderer);
    let mut tally = Tally::default();
    let mut wrong = Vec::new();
    let of_all = FIXED_SEEDS.chain(MENDED_SEEDS.iter().copied());
    let of_all = of_all.map(|seed| (Family::of_seed(seed, &[]), seed));
    for (family, seed) in of_all.chain(MENDED_OF_KIND.iter().copied()) {
        let recipe = recipe_of(seed, family, judge.catalog());
        let verdict = judge.judge(&recipe);
        tally.count(&recipe, &verdict);
        let known = KNOWN_SEEDS.iter().find(|(known, _)| *known == seed);
        match (verdict, known) {
            (Verdict::Wrong(failure), None) => {
                wrong.push(format!(
                    "{}-{seed}: {:?} {}",
                    recipe.family,
                    failure.kind,
                    failure.lines.join("; ")
                ));
            }
            (Verdict::Wrong(_), Some((_, why))) => println!("known: {}-{seed}: {why}", recipe.family),
            (_, Some(_)) => wrong.push(format!("{}-{seed} is right now: strike it out", recipe.family)),
            (_, None) => {}
        }
    }
    println!("{tally}");
    let refused = tally.refused();
    assert!(refused * 50 <= tally.scenes(), "{refused} of {} scenes refused", tally.scenes());
    assert!(
        wrong.is_empty(),
        "{} wrong; `shadowgraph fuzz 1 --seed SEED --kinds KIND` writes one made small:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
}

/// Scenes under maps, which owe bounds: few of them are drawn by chance.
#[test]
fn maps_keep_their_bounds_on_random_scenes() {
    let Some(renderer) = shadowgraph_testing::renderer() else { return };
    let mut judge = Judge::new(renderer);
    let mut tally = Tally::default();
    let mut wrong = Vec::new();
    for seed in 0..60 {
        let recipe = recipe_of(seed, Family::Maps, judge.catalog());
        let verdict = judge.judge(&recipe);
        tally.count(&recipe, &verdict);
        if let Verdict::Wrong(failure) = verdict {
            wrong.push(format!("maps-{seed}: {:?} {}", failure.kind, failure.lines.join("; ")));
        }
    }
    println!("{tally}");
    assert!(tally.refused() * 20 <= tally.scenes(), "{} of {} refused", tally.refused(), tally.scenes());
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_seed_is_the_same_scene_and_another_is_not() {
    let catalog = shadowgraph::nodes::catalog();
    for family in Family::ALL {
        assert_eq!(recipe_of(5, *family, &catalog), recipe_of(5, *family, &catalog));
        assert_ne!(recipe_of(5, *family, &catalog).bodies, recipe_of(6, *family, &catalog).bodies);
    }
}

/// Whether some of so many scenes of a family are of a kind.
fn some(family: Family, is: impl Fn(&Recipe) -> bool) -> bool {
    let catalog = shadowgraph::nodes::catalog();
    (0..40).any(|seed| is(&recipe_of(seed, family, &catalog)))
}

#[test]
fn every_family_has_what_it_says() {
    let wears = |recipe: &Recipe, is: fn(&Wear) -> bool| recipe.bodies.iter().any(|body| is(&body.wear));
    let glass = |recipe: &Recipe| wears(recipe, |wear| matches!(wear, Wear::Glass { .. }));
    let mask = |recipe: &Recipe| wears(recipe, |wear| matches!(wear, Wear::Mask { .. }));
    let single = |recipe: &Recipe| recipe.bodies.iter().any(|body| !body.double_sided);
    assert!(some(Family::Glass, glass) && some(Family::Ties, glass) && some(Family::NodesMixed, glass));
    assert!(some(Family::Masks, mask) && some(Family::Ties, mask) && some(Family::Ties, single));
    assert!(some(Family::NodesMixed, |recipe| recipe.nodes.len() > 1));
    for bent in
        [|bend: &Bend| matches!(bend, Bend::Skin { .. }), |bend: &Bend| matches!(bend, Bend::Morph { .. })]
    {
        assert!(some(Family::Bent, |recipe| recipe.bodies.iter().any(|body| bent(&body.bend))));
    }
    assert!(some(Family::Stretched, |recipe| recipe.bodies.iter().any(is_long)));
    assert!(some(Family::Soup, |recipe| recipe.bodies.iter().any(|body| edges_of(body).2)));
    assert!(some(Family::InnerWalls, |recipe| recipe.bodies.iter().any(is_mirrored)));
    // Lamps that are a corner, to the last digit; and such that are almost.
    let beside = |recipe: &Recipe, least: f64, most: f64| {
        let corners = recipe.bodies.iter().flat_map(|b| (0..b.triangles.len()).flat_map(|t| b.corners(t)));
        let corners: Vec<DVec3> = corners.collect();
        recipe
            .lamps
            .iter()
            .any(|lamp| corners.iter().any(|c| (least..=most).contains(&c.distance(lamp.position))))
    };
    assert!(some(Family::LampBeside, |recipe| beside(recipe, 0.0, 0.0)));
    assert!(some(Family::LampBeside, |recipe| beside(recipe, 1e-13, 1e-4)));
    // Every scene holds something, and makes a scene.
    let catalog = shadowgraph::nodes::catalog();
    for (family, seed) in Family::ALL.iter().flat_map(|family| (0..40).map(move |seed| (*family, seed))) {
        let recipe = recipe_of(seed, family, &catalog);
        assert!(recipe.triangle_count() > 0 && !recipe.lamps.is_empty() && !recipe.nodes.is_empty());
        let snapshot = recipe.build(&catalog).unwrap().snapshot().unwrap();
        assert_eq!((snapshot.instances.len(), snapshot.cameras.len()), (recipe.bodies.len(), 1));
    }
}

fn is_long(body: &shadowgraph::search::Body) -> bool {
    (0..body.triangles.len()).any(|triangle| {
        let [a, b, c] = body.corners(triangle);
        let sides = [a.distance(b), b.distance(c), c.distance(a)];
        let [least, most] =
            [sides.iter().copied().fold(f64::MAX, f64::min), sides.into_iter().fold(0.0, f64::max)];
        most > 10_000.0 * least
    })
}

fn is_mirrored(body: &shadowgraph::search::Body) -> bool {
    body.frame_from_local().matrix3.determinant() < 0.0
}

/// Corners, triangles, and whether three or more triangles share an edge.
fn edges_of(body: &shadowgraph::search::Body) -> (usize, usize, bool) {
    let edge = |t: &[u32; 3], i: usize| {
        let (a, b) = (t[i], t[(i + 1) % 3]);
        (a.min(b), a.max(b))
    };
    let mut edges: Vec<_> =
        body.triangles.iter().flat_map(|t| [edge(t, 0), edge(t, 1), edge(t, 2)]).collect();
    edges.sort_unstable();
    let many = edges.windows(3).any(|three| three[0] == three[1] && three[1] == three[2]);
    (body.positions.len(), body.triangles.len(), many)
}

/// Takes the last triangles of a volume away.
fn shorten(draw: &mut Draw) {
    if let Geometry::Indexed { count, .. } = &mut draw.geometry {
        *count = (*count - 6).max(3);
    }
}

#[test]
fn a_broken_technique_is_found_and_made_small() {
    let Some(renderer) = shadowgraph_testing::renderer() else { return };
    let mut catalog = Catalog::new();
    catalog.register(TechniqueEntry {
        from_params: |_| {
            let technique = ShadowVolumeHard { depth_test: DepthTest::ZFail, ..Default::default() };
            Ok(Arc::new(Broken { technique: Arc::new(technique), spoil: Spoil::Draws(shorten) }))
        },
        settings: &[],
        ..ShadowVolumeHard::ENTRY
    });
    let mut sound = Judge::new(Renderer::new(renderer.gpu().clone(), shadowgraph::nodes::catalog()));
    let mut broken = Judge::new(Renderer::new(renderer.gpu().clone(), catalog));
    let wrong = |judge: &mut Judge, recipe: &Recipe| match judge.judge(recipe) {
        Verdict::Wrong(failure) if failure.kind == FailureKind::Outside => Some(failure.pixels),
        _ => None,
    };
    let recipes = (0..40).map(|seed| {
        let mut recipe = recipe_of(seed, Family::Open, sound.catalog());
        recipe.nodes[0].technique = "ShadowVolumeHard".into();
        recipe.nodes[0].params.clear();
        recipe
    });
    let recipes: Vec<Recipe> = recipes.collect();
    let found = recipes.iter().find(|recipe| wrong(&mut broken, recipe).is_some_and(|pixels| pixels > 50));
    let found = found.expect("not one of 40 scenes shows that volumes lack triangles");
    assert_eq!(wrong(&mut sound, found), None);
    let small = shrink(found, 300, &mut |recipe| wrong(&mut broken, recipe).is_some_and(|pixels| pixels > 5));
    println!("{} triangles of {}", small.triangle_count(), found.triangle_count());
    assert!(small.triangle_count() <= 6 && small.lamps.len() == 1 && small.nodes.len() == 1, "{small:#?}");
    assert_eq!(wrong(&mut sound, &small), None);
}

#[test]
fn brute_force_sees_what_the_reference_and_its_band_get_wrong() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let recipe = recipe_of(0, Family::Open, renderer.catalog());
    let scene = recipe.build(renderer.catalog()).unwrap();
    let snapshot = scene.snapshot().unwrap();
    let request = FrameRequest::new(snapshot.cameras[0].clone(), recipe.size_px);
    let mut evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
    let brute = Brute::new(&snapshot).unwrap();
    let query = evaluation.queries[0].clone();
    let sound = brute.compare(&snapshot, &request, &evaluation, (0, &query));
    assert_eq!((sound.reference, sound.excused), (0, 0));
    let compared = evaluation.errors[0].compared;
    // A reference that has light and shadow the other way round.
    let right = Arc::clone(&evaluation.reference);
    let light = &mut Arc::make_mut(&mut evaluation.reference).lights[0];
    light.factor.iter_mut().for_each(|factor| *factor = 1.0 - *factor);
    let turned = brute.compare(&snapshot, &request, &evaluation, (0, &query));
    assert!(turned.reference * 10 > compared * 8, "{turned:?} of {compared}");
    // A picture that has, and a band that excuses everything.
    evaluation.reference = right;
    Arc::make_mut(&mut evaluation.reference).lights[0].ambiguous.fill(true);
    evaluation.measured.lights[0].1.iter_mut().for_each(|factor| *factor = 1.0 - *factor);
    let excused = brute.compare(&snapshot, &request, &evaluation, (0, &query));
    assert!(excused.excused * 10 > compared * 8 && excused.reference == 0, "{excused:?} of {compared}");
}
