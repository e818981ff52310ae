//! Techniques broken on purpose: conformance turns red, on the cases where it must, and says what is wrong.
//!
//! Each wraps `ShadowVolumeHard`, takes its name and its rows, and spoils the draws it has planned as a slip in its code
//! would.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "what a sabotage turns red is what a reader of the log is after")]

mod common;

use std::sync::Arc;

use common::conformance::{Trial, try_all};
use common::tolerances::ROWS;
use shadowgraph::cases;
use shadowgraph::engine::plan::{CompareFunction, Draw, Geometry, Stencil, StencilOperation};
use shadowgraph::engine::scene::{Instance, Params};
use shadowgraph::engine::shadow::{
    Catalog, LightPlan, OptionError, Requirements, ShadowError, ShadowTechnique, TechniqueEntry,
};
use shadowgraph::prelude::*;

/// `ShadowVolumeHard`, with something done to every draw of its volumes.
#[derive(Debug)]
struct Broken {
    technique: ShadowVolumeHard,
    spoil: fn(&mut Draw),
}

impl ShadowTechnique for Broken {
    fn type_name(&self) -> &'static str {
        self.technique.type_name()
    }

    fn params(&self) -> Params {
        self.technique.params()
    }

    fn known_error(&self) -> &'static str {
        "whatever was done to it"
    }

    fn requirements(&self) -> Requirements {
        self.technique.requirements()
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        self.technique.casts(instance)
    }

    fn plan(&self, light: &mut LightPlan<'_>) -> Result<(), ShadowError> {
        self.technique.plan(light)?;
        light.passes_mut().iter_mut().flat_map(|pass| &mut pass.draws).for_each(self.spoil);
        Ok(())
    }
}

type FromParams = fn(&Params) -> Result<Arc<dyn ShadowTechnique>, OptionError>;

fn broken(
    technique: ShadowVolumeHard,
    spoil: fn(&mut Draw),
) -> Result<Arc<dyn ShadowTechnique>, OptionError> {
    Ok(Arc::new(Broken { technique, spoil }))
}

/// The default setting of a technique so made, on every variant of these cases.
fn trials(from_params: FromParams, ids: &[&str]) -> Option<Vec<Trial>> {
    let entry = TechniqueEntry { from_params, settings: &[], ..ShadowVolumeHard::ENTRY };
    let mut catalog = Catalog::new();
    catalog.register(entry);
    let mut renderer = Renderer::new(common::renderer()?.gpu().clone(), catalog);
    let cases: Vec<_> =
        cases::all().iter().filter(|entry| ids.contains(&entry.id)).flat_map(|entry| entry.build()).collect();
    assert!(
        ids.iter().all(|id| cases.iter().any(|case| case.id == *id)),
        "not every case of {ids:?} is there"
    );
    Some(cases.iter().flat_map(|case| try_all(&mut renderer, case, ROWS)).collect())
}

/// All of these cases turn red in at least one variant, and the complaint says `word`.
fn turns_red(from_params: FromParams, ids: &[&str], word: &str) {
    // Sound, they are green: what turns them red is the sabotage.
    let Some(sound) = trials(|_| broken(ShadowVolumeHard::default(), |_| ()), ids) else { return };
    for trial in sound {
        assert_eq!(trial.complaint, None, "{}", trial.name());
    }
    let trials = trials(from_params, ids).unwrap();
    for trial in &trials {
        let verdict =
            trial.complaint.as_deref().map_or("green", |complaint| complaint.lines().next().unwrap());
        println!("{}: {verdict}", trial.name());
    }
    for id in ids {
        let of_case = trials.iter().filter(|trial| trial.case.split('/').next() == Some(*id));
        let complaints: Vec<_> = of_case.filter_map(|trial| trial.complaint.as_deref()).collect();
        assert!(!complaints.is_empty(), "{id} stays green");
        assert!(complaints.iter().any(|complaint| complaint.contains(word)), "{id}: {complaints:?}");
    }
}

/// The stencil operations that count: those in front of the surface, or those behind it.
fn counting(stencil: &mut Stencil) -> [&mut StencilOperation; 2] {
    if stencil.front.depth_fail_op == StencilOperation::Keep {
        [&mut stencil.front.pass_op, &mut stencil.back.pass_op]
    } else {
        [&mut stencil.front.depth_fail_op, &mut stencil.back.depth_fail_op]
    }
}

#[test]
fn a_wrong_sign() {
    // Every other caster counts down where the others count up: where two shadows overlap they cancel.
    turns_red(
        |_| {
            broken(ShadowVolumeHard::default(), |draw| {
                let (Geometry::Indexed { record, .. }, Some(stencil)) =
                    (&draw.geometry, &mut draw.state.stencil)
                else {
                    return;
                };
                if record % 2 == 1 {
                    let [front, back] = counting(stencil);
                    std::mem::swap(front, back);
                }
            })
        },
        &["nested-shells", "closed-open-mixed", "eye-in-shadow"],
        "leaks",
    );
}

#[test]
fn a_missing_cap() {
    // The last two triangles of each run of a volume that is counted from infinity: part of its caps.
    turns_red(
        |_| {
            let technique = ShadowVolumeHard { depth_test: DepthTest::ZFail, ..ShadowVolumeHard::default() };
            broken(technique, |draw| {
                if let Geometry::Indexed { count, .. } = &mut draw.geometry {
                    *count = (*count - 6).max(3);
                }
            })
        },
        &["single-quad", "eye-in-shadow", "light-in-closed"],
        "outside the band",
    );
}

#[test]
fn a_shifted_mask() {
    // Volumes land one pixel to the right.
    turns_red(
        |_| {
            broken(ShadowVolumeHard::default(), |draw| {
                let Some(shader) = &mut draw.shader else { return };
                let parameters = "(@builtin(vertex_index) index: u32, @builtin(instance_index) volume: u32)";
                let (entry, bare) =
                    (format!("@vertex\nfn vertex{parameters}"), "fn unshifted(index: u32, volume: u32)");
                if shader.vertex != "vertex" {
                    return;
                }
                let helper = shader.source.replace(&entry, bare);
                assert_ne!(*helper, *shader.source, "nothing is shifted");
                let pixel = "vec4f(v.clip.w * 2.0 / 256.0, 0.0, 0.0, 0.0)";
                let shifted = format!(
                    "{helper}\n{entry} -> Varyings {{\n  let v = unshifted(index, volume);\n  \
                     return Varyings(v.clip + {pixel});\n}}\n"
                );
                shader.source = shifted.into();
                shader.name = "shifted".into();
            })
        },
        &["single-quad", "touching-receiver", "uv-seam"],
        "outside the band",
    );
}

#[test]
fn a_clamped_counter() {
    // A count that is to fall below 0 on its way stays there.
    turns_red(
        |_| {
            broken(ShadowVolumeHard::default(), |draw| {
                let Some(stencil) = &mut draw.state.stencil else { return };
                for operation in counting(stencil) {
                    *operation = match *operation {
                        StencilOperation::IncrementWrap => StencilOperation::IncrementClamp,
                        StencilOperation::DecrementWrap => StencilOperation::DecrementClamp,
                        other => other,
                    };
                }
            })
        },
        &["overlap-seen-through", "near-clips-side", "fins"],
        "outside the band",
    );
}

#[test]
fn nothing_counted() {
    turns_red(
        |_| {
            broken(ShadowVolumeHard::default(), |draw| {
                if let Some(stencil) = &mut draw.state.stencil {
                    stencil.front.compare = CompareFunction::Never;
                    stencil.back.compare = CompareFunction::Never;
                }
            })
        },
        &["single-quad", "overlap-256", "lights-4"],
        "leaks and 0 false shadows",
    );
}

#[test]
fn a_technique_without_a_row() {
    let Some(renderer) = common::renderer() else { return };
    let mut renderer = Renderer::new(renderer.gpu().clone(), shadowgraph_nodes::catalog());
    let case = cases::all().iter().flat_map(|entry| entry.build()).next().unwrap();
    let without: Vec<_> = ROWS.iter().copied().filter(|row| row.setting != "z-fail").collect();
    let red = try_all(&mut renderer, &case, &without).into_iter().filter(|trial| trial.complaint.is_some());
    let red: Vec<_> = red.map(|trial| (trial.setting, trial.complaint.unwrap())).collect();
    assert_eq!(red, [("z-fail", "no row in the table of tolerances".to_owned())]);
}
