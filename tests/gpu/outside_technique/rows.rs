//! Its own rows of tolerances, and the hard cases that it takes.

use shadowgraph::cases::{self, About, Case, Expect};
use shadowgraph::engine::shadow::Catalog;
use shadowgraph::prelude::*;

use super::{Stage, lamp, request, stage};
use crate::known::OUTSIDE_ONE_CASE_IN;
use crate::own_technique::DiscShadow;
use crate::tolerances::{Bound, Row, Tolerance};
use crate::trials::try_all;

/// What this technique owes: its own declaration, kept beside it. The library's cases hold meshes that are no discs.
const ROWS: &[Row] = &[
    Row {
        technique: "DiscShadow",
        setting: "default",
        owes: Tolerance::Refused,
        except: &[&[(
            "discs",
            Tolerance::Within(Bound {
                leak_share: 1e-4,
                false_share: 1e-4,
                rmse: 0.01,
                penumbra_rmse: 1.0,
                max: 1.0,
                why: "depth buffers round the receiver",
            }),
        )]],
        accepts_at_least: 1,
    },
    Row {
        technique: "DiscShadow",
        setting: "soft rim",
        owes: Tolerance::Refused,
        except: &[&[(
            "discs",
            Tolerance::Within(Bound {
                leak_share: 1e-3,
                false_share: 1e-3,
                rmse: 0.08,
                penumbra_rmse: 1.0,
                max: 1.0,
                why: "no light fades at a rim like this",
            }),
        )]],
        accepts_at_least: 1,
    },
];

/// Its own hard case: discs over a floor and a wall that cast nothing.
fn own_case() -> Case {
    let Stage { mut scene, discs, .. } = stage();
    lamp(&mut scene);
    scene.add_shadow("discs", ShadowNode::from(DiscShadow::default()).with_casters(discs));
    Case {
        id: "discs",
        variant: String::new(),
        what_breaks: "whatever is not computed but drawn",
        scene,
        camera: request().camera,
        size_px: [256, 256],
        antialias: Default::default(),
        options: Default::default(),
        about: About::Anything,
        expect: Expect::Shadow,
        probes: vec![],
        is_heavy: false,
    }
}

#[test]
fn it_conforms_by_rows_of_its_own() {
    let Some(renderer) = shadowgraph_testing::renderer() else { return };
    let mut alone = Catalog::new();
    alone.register(DiscShadow::ENTRY);
    let mut renderer = Renderer::new(renderer.gpu().clone(), alone);
    let library = cases::all()
        .into_iter()
        .step_by(OUTSIDE_ONE_CASE_IN)
        .flat_map(|entry| entry.build(&shadowgraph::CAST));
    let trials: Vec<_> =
        library.chain([own_case()]).flat_map(|case| try_all(&mut renderer, &case, ROWS)).collect();
    let complaints: Vec<_> =
        trials.iter().filter_map(|t| Some(format!("{}: {}", t.name(), t.complaint.as_ref()?))).collect();
    assert!(complaints.is_empty(), "{complaints:#?}");
    let accepted =
        trials.iter().filter(|trial| trial.accepted).map(|trial| (trial.setting, trial.case.as_str()));
    assert_eq!(accepted.collect::<Vec<_>>(), [("default", "discs"), ("soft rim", "discs")]);

    // Without rows it fails, and so does a bound that its soft rim does not keep.
    let strict = [Row { setting: "soft rim", ..ROWS[0] }];
    let red = try_all(&mut renderer, &own_case(), &strict).into_iter().filter_map(|trial| trial.complaint);
    let red: Vec<_> = red.collect();
    assert_eq!(red[0], "no row in the table of tolerances");
    assert!(red.len() == 2 && red[1].contains("rmse"), "{red:?}");
}
