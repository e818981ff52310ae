//! Different ways to the same picture: every option, draw order and grouping of passes gives the same factors.

use crate::known::{COMPARED_ONE_CASE_IN, KNOWN_ON_CASES};
use crate::tolerances::HARD;
use crate::trials::tries_everything;

use shadowgraph::cases::{self, Case};
use shadowgraph::measure::{Measured, Reference, ReferenceImage, queries};
use shadowgraph::prelude::*;

/// Of the cases that default options accept every third from `first` on: whether each is right, conformance asks of all. With
/// `CASE=` or `EVERY_CASE=1` all of them.
fn accepted(renderer: &mut Renderer, first: usize) -> Vec<Case> {
    let filter = std::env::var("CASE").unwrap_or_default();
    let (first, step) = if tries_everything() { (0, 1) } else { (first, COMPARED_ONE_CASE_IN) };
    let cases = cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST));
    let cases = cases.filter(|case| case.name().contains(&filter));
    let mut cases: Vec<Case> = cases.skip(first).step_by(step).collect();
    cases.retain(|case| match renderer.plan(&case.scene, &request(case)) {
        Ok(_) => true,
        Err(RenderError::Shadow(_) | RenderError::Frame(_)) => false,
        Err(error) => panic!("{}: {error}", case.name()),
    });
    assert!(!cases.is_empty(), "no case is called '{filter}'");
    cases
}

fn request(case: &Case) -> FrameRequest {
    FrameRequest::new(case.camera.clone(), case.size_px)
}

/// The case's reference picture, for its ambiguity band.
fn reference(renderer: &mut Renderer, case: &Case) -> ReferenceImage {
    let (snapshot, registry) = renderer.snapshot(&case.scene).unwrap();
    Reference::new(&snapshot).render(&case.camera, case.size_px, &queries(&registry), &|_, _| {})
}

/// The case's scene with its shadow node's options replaced.
fn with_options(case: &Case, node: ShadowVolumeHard) -> Scene {
    let mut scene = case.scene.clone();
    let key = scene.shadows().next().unwrap().0;
    let (ShadowNode { technique, params, .. }, shadow) = (node.into(), scene.shadow_mut(key).unwrap());
    (shadow.technique, shadow.params) = (technique, params);
    scene
}

/// Pixels at which two sets of factors differ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Differing {
    compared: usize,
    outside_band: usize,
    in_band: usize,
}

/// Counts where `other` differs from `first` among the pixels that `reference` compares, both seeing the same
/// triangle; `same` says which triangle of the other picture is which of the first.
fn differing(
    first: &Measured,
    other: &Measured,
    reference: &ReferenceImage,
    same: impl Fn([u32; 2]) -> [u32; 2],
) -> Differing {
    let mut count = Differing::default();
    for light in &reference.lights {
        let factor_of = |picture: &Measured| {
            let found = picture.lights.iter().find(|(name, _)| *name == light.name);
            found.unwrap_or_else(|| panic!("'{}' was not measured", light.name)).1.clone()
        };
        let (a, b) = (factor_of(first), factor_of(other));
        for pixel in 0..a.len() {
            let ids = first.ids[pixel];
            let hit = reference.hits[pixel].map(|hit| [hit.instance, hit.triangle]);
            if !light.compared[pixel] || hit != Some(ids) || ids != same(other.ids[pixel]) {
                continue;
            }
            count.compared += 1;
            let differs = usize::from(a[pixel].to_bits() != b[pixel].to_bits());
            if light.ambiguous[pixel] {
                count.in_band += differs;
            } else {
                count.outside_band += differs;
            }
        }
    }
    count
}

const OPTIONS: usize = 12;

/// Options that must give the factors of `auto`. Floors cast and are open, so that `geometry=closed` is always refused and not
/// among these.
fn options() -> [(&'static str, ShadowVolumeHard); OPTIONS] {
    let auto = ShadowVolumeHard::default();
    [
        ("depthTest=zpass", ShadowVolumeHard { depth_test: DepthTest::ZPass, ..auto }),
        ("depthTest=zfail", ShadowVolumeHard { depth_test: DepthTest::ZFail, ..auto }),
        ("geometry=open", ShadowVolumeHard { geometry: GeometryMode::Open, ..auto }),
        ("extrusion=infinite", ShadowVolumeHard { extrusion: Extrusion::Infinite, ..auto }),
        ("extrusion=toBounds", ShadowVolumeHard { extrusion: Extrusion::ToBounds, ..auto }),
        (
            "zfail, open, infinite",
            ShadowVolumeHard {
                depth_test: DepthTest::ZFail,
                geometry: GeometryMode::Open,
                extrusion: Extrusion::Infinite,
                ..auto
            },
        ),
        ("closure=backfaces", ShadowVolumeHard { closure: Closure::Backfaces, ..auto }),
        ("passes=single", ShadowVolumeHard { passes: Passes::Single, ..auto }),
        ("counter=float", ShadowVolumeHard { counter: CounterKind::Float, ..auto }),
        ("terminator=smooth", ShadowVolumeHard { terminator: Terminator::Smooth, ..auto }),
        (
            "float, smooth, zfail",
            ShadowVolumeHard {
                counter: CounterKind::Float,
                terminator: Terminator::Smooth,
                depth_test: DepthTest::ZFail,
                ..auto
            },
        ),
        (
            "backfaces, open, zfail",
            ShadowVolumeHard {
                closure: Closure::Backfaces,
                geometry: GeometryMode::Open,
                depth_test: DepthTest::ZFail,
                ..auto
            },
        ),
    ]
}

/// The case with other options; `None` where these are refused as they may be: zpass where the near plane may be in shadow,
/// toBounds where no plane serves, single for masks, which are no counts, and beside nodes that take away the light itself.
fn measured_with(
    renderer: &mut Renderer,
    case: &Case,
    name: &str,
    node: ShadowVolumeHard,
) -> Option<Measured> {
    match shadowgraph_testing::measure(renderer, &with_options(case, node), &request(case)) {
        Ok(measured) => Some(measured),
        Err(RenderError::Shadow(_) | RenderError::Frame(_))
            if name.ends_with("zpass")
                || name.ends_with("toBounds")
                || (name.ends_with("single")
                    && ["alpha-mask", "leaf-on-floor", "turned-from-centre"].contains(&case.id)) =>
        {
            None
        }
        Err(error) => panic!("{} {name}: {error}", case.name()),
    }
}

#[test]
fn every_option_gives_the_same_factors() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let options = options();
    let mut accepted_by = [0; OPTIONS];
    let mut totals = [Differing::default(); OPTIONS];
    let mut failures = Vec::new();
    let cases = accepted(&mut renderer, 0);
    for case in &cases {
        let reference = reference(&mut renderer, case);
        let first = shadowgraph_testing::measure(&mut renderer, &case.scene, &request(case)).unwrap();
        for (index, (name, node)) in options.iter().enumerate() {
            let Some(other) = measured_with(&mut renderer, case, name, *node) else { continue };
            assert!(first.ids == other.ids, "{} {name}: another surface is seen", case.name());
            let count = differing(&first, &other, &reference, |ids| ids);
            accepted_by[index] += 1;
            totals[index].compared += count.compared;
            totals[index].in_band += count.in_band;
            totals[index].outside_band += count.outside_band;
            let known_as = |word: &str, setting: &str| {
                let case = case.name();
                name.contains(word) && KNOWN_ON_CASES.iter().any(|known| known.is_about(HARD, setting, &case))
            };
            let is_known = known_as("zfail", "z-fail") || known_as("smooth", "smooth");
            if count.outside_band > 0 && !is_known {
                failures.push(format!("{} {name}: {count:?}", case.name()));
            }
        }
    }
    for ((name, _), (total, accepted)) in options.iter().zip(totals.iter().zip(accepted_by)) {
        println!("{name:<22} against auto: {accepted} of {} cases, {total:?}", cases.len());
    }
    assert!(failures.is_empty(), "{} differ:\n{}", failures.len(), failures.join("\n"));
    if std::env::var_os("CASE").is_none() {
        assert!(accepted_by.iter().all(|count| *count > cases.len() / 8), "{accepted_by:?}");
    }
}

#[test]
fn draw_order_does_not_matter() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut failures = Vec::new();
    let mut total = Differing::default();
    for case in &accepted(&mut renderer, 1) {
        let reference = reference(&mut renderer, case);
        let first = shadowgraph_testing::measure(&mut renderer, &case.scene, &request(case)).unwrap();
        // Hanging every root up again at the end, last first, reverses meshes and lights alike.
        let mut reversed = case.scene.clone();
        for root in case.scene.roots().iter().rev() {
            reversed.reparent(*root, None).unwrap();
        }
        let last = renderer.snapshot(&reversed).unwrap().0.instances.len() as u32 - 1;
        let other = shadowgraph_testing::measure(&mut renderer, &reversed, &request(case)).unwrap();
        let count = differing(&first, &other, &reference, |[instance, triangle]| {
            [last.wrapping_sub(instance), triangle]
        });
        let drawn = reference.hits.iter().any(Option::is_some);
        if count.outside_band > 0 || (drawn && count.compared == 0) {
            failures.push(format!("{}: {count:?}", case.name()));
        }
        total.compared += count.compared;
        total.in_band += count.in_band;
    }
    println!("reversed draw order: {total:?}");
    assert!(failures.is_empty(), "{} differ:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn merged_and_separate_passes_give_the_same_bits() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let mut failures = Vec::new();
    for case in &accepted(&mut renderer, 2) {
        for (factors, picture) in [(false, PictureFormat::Srgb8), (true, PictureFormat::LinearF32)] {
            let request = FrameRequest { factors, picture, ..request(case) };
            let [merged, separate] = [Timing::Off, Timing::Passes].map(|timing| {
                let options = RenderOptions { timing, read_picture: true, ..RenderOptions::default() };
                renderer.render(&case.scene, &request, &options).unwrap()
            });
            assert_eq!(merged.factors.is_empty(), !factors, "{}", case.name());
            for (what, same) in [
                ("picture", merged.picture == separate.picture),
                ("factors", merged.factors == separate.factors),
                ("surfaces", merged.visible_triangles == separate.visible_triangles),
            ] {
                if !same {
                    failures.push(format!("{} {picture:?} factors {factors}: {what}", case.name()));
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} differ:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn asking_for_factors_does_not_change_the_picture() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    let mut failures = Vec::new();
    for case in &accepted(&mut renderer, 0) {
        let [plain, measured] = [false, true].map(|factors| {
            let request = FrameRequest { factors, ..request(case) };
            renderer.render(&case.scene, &request, &options).unwrap().picture.unwrap()
        });
        let differs = plain.bytes.chunks(4).zip(measured.bytes.chunks(4)).filter(|(a, b)| a != b).count();
        if differs > 0 {
            failures.push(format!("{}: {differs} of {} pixels", case.name(), plain.bytes.len() / 4));
        }
    }
    assert!(failures.is_empty(), "{} differ:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn an_unmoved_scene_is_drawn_again_without_work() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    for case in &accepted(&mut renderer, 1) {
        let request = FrameRequest { factors: true, ..request(case) };
        let before = renderer.work_done();
        let first = renderer.render(&case.scene, &request, &options).unwrap();
        let after = renderer.work_done();
        let second = renderer.render(&case.scene, &request, &options).unwrap();
        assert_eq!(after, renderer.work_done(), "{}: the second frame computed or uploaded", case.name());
        assert!(first.picture.is_some() && first.picture == second.picture, "{}: picture", case.name());
        assert!(first.factors == second.factors, "{}: factors", case.name());
        let shadowed = first.plan.lights.iter().any(|light| !light.techniques.is_empty());
        assert!(
            !shadowed || before != after || ["sky", "soft-no-caster", "planar-no-caster"].contains(&case.id),
            "{}: the first frame did nothing",
            case.name()
        );
    }
}

#[test]
fn moving_there_and_back_gives_the_first_frame_again() {
    // A second renderer never sees what the first may remember of before the move.
    let (Some(mut renderer), Some(mut fresh)) =
        (shadowgraph_testing::renderer(), shadowgraph_testing::renderer())
    else {
        return;
    };
    let options = RenderOptions { read_picture: true, ..RenderOptions::default() };
    let mut moved_pictures = 0;
    for case in &accepted(&mut renderer, 2) {
        let request = FrameRequest { factors: true, ..request(case) };
        let mut scene = case.scene.clone();
        let first = renderer.render(&scene, &request, &options).unwrap();
        let meshes = scene.depth_first().into_iter();
        let mut meshes = meshes.filter(|key| matches!(scene.node(*key).unwrap().content, Content::Mesh(_)));
        let Some(key) = meshes.next_back() else { continue };
        let home = scene.node(key).unwrap().parent_from_local;
        let aside = DAffine3::from_translation(DVec3::new(0.25, 0.0625, -0.125));
        scene.node_mut(key).unwrap().parent_from_local = aside * home;
        let moved_scene = scene.clone();
        let moved = renderer.render(&moved_scene, &request, &options).unwrap();
        scene.node_mut(key).unwrap().parent_from_local = home;
        let back = renderer.render(&scene, &request, &options).unwrap();
        assert!(first.picture.is_some() && first.picture == back.picture, "{}: picture", case.name());
        assert!(first.factors == back.factors, "{}: factors", case.name());
        assert!(first.visible_triangles == back.visible_triangles, "{}: surfaces", case.name());
        moved_pictures += usize::from(moved.factors != first.factors);
        let anew = fresh.render(&moved_scene, &request, &options).unwrap();
        assert!(moved.picture == anew.picture, "{}: the moved picture holds something stale", case.name());
        assert!(moved.factors == anew.factors, "{}: the moved factors hold something stale", case.name());
    }
    if std::env::var_os("CASE").is_none() {
        assert!(moved_pictures > 20, "moving changed the factors of {moved_pictures} cases only");
    }
}
