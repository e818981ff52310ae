//! `counter=float`: exact for any number of layers and in any order of drawing.

use shadowgraph::cases;
use shadowgraph::engine::plan::TextureFormat;
use shadowgraph::measure::evaluate;
use shadowgraph::prelude::*;

const FLOAT: ShadowVolumeHard = ShadowVolumeHard {
    depth_test: DepthTest::Auto,
    geometry: GeometryMode::Auto,
    closure: Closure::None,
    passes: Passes::Multi,
    weight: 0.5,
    extrusion: Extrusion::Auto,
    counter: CounterKind::Float,
    terminator: Terminator::Geometric,
};

fn with_float(scene: &Scene, depth_test: DepthTest) -> Scene {
    let mut scene = scene.clone();
    let key = scene.shadows().next().unwrap().0;
    *scene.shadow_mut(key).unwrap() = ShadowVolumeHard { depth_test, ..FLOAT }.into();
    scene
}

#[test]
fn any_number_of_layers_is_counted_exactly() {
    let Some(mut renderer) = shadowgraph_testing::renderer() else { return };
    let stacks = cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST));
    let mut formats = Vec::new();
    let mut judged = 0;
    for case in stacks.filter(|case| case.id.starts_with("overlap") || case.id == "nested-shells") {
        for depth_test in [DepthTest::Auto, DepthTest::ZFail] {
            let request = case.request();
            let forwards = with_float(&case.scene, depth_test);
            // Last casters first: sums take another way to the same end.
            let mut backwards = forwards.clone();
            for root in forwards.roots().iter().rev() {
                backwards.reparent(*root, None).unwrap();
            }
            for (order, scene) in [("forwards", forwards), ("backwards", backwards)] {
                let evaluation = evaluate(&mut renderer, &scene, &request, &|_, _| {}).unwrap();
                let name = format!("{} {depth_test:?} {order}", case.name());
                assert!(
                    evaluation.errors.iter().all(|error| error.passes()),
                    "{name}: {:?}",
                    evaluation.errors
                );
                let slots = &evaluation.frame.plan.slots;
                let counts = slots.iter().find(|slot| slot.name == "counts of light0").unwrap();
                formats.extend(match counts.kind {
                    shadowgraph::engine::plan::SlotKind::Texture { format, .. } => Some(format),
                    _ => None,
                });
                judged += 1;
            }
        }
    }
    assert!(judged >= 4 * 9, "{judged}");
    // Both formats were tried.
    for format in [TextureFormat::R16Float, TextureFormat::R32Float] {
        assert!(formats.contains(&format), "{format:?} was not needed: {formats:?}");
    }
}
