//! Techniques broken on purpose: conformance turns red, on the cases where it must, and says what is wrong.
//!
//! Each wraps a technique, takes its name and its rows, and spoils what it has planned as a slip in its code would.

use std::sync::Arc;

use crate::broken::{Broken, PlanOf, Spoil};
use crate::tolerances::ROWS;
use crate::trials::{Trial, try_all};
use shadowgraph::cases;
use shadowgraph::engine::plan::{CompareFunction, Stencil, StencilOperation};
use shadowgraph::engine::scene::Params;
use shadowgraph::engine::shadow::{
    Catalog, Contribution, Draw, Geometry, OptionError, ShadowTechnique, TechniqueEntry,
};
use shadowgraph::prelude::*;

type FromParams = fn(&Params) -> Result<Arc<dyn ShadowTechnique>, OptionError>;

fn broken(
    technique: ShadowVolumeHard,
    spoil: fn(&mut Draw),
) -> Result<Arc<dyn ShadowTechnique>, OptionError> {
    Ok(Arc::new(Broken { technique: Arc::new(technique), spoil: Spoil::Draws(spoil) }))
}

/// The default setting of a technique so made, on every variant of these cases.
fn trials(entry: TechniqueEntry, ids: &[&str]) -> Option<Vec<Trial>> {
    let entry = TechniqueEntry { settings: &[], ..entry };
    let mut catalog = Catalog::new();
    catalog.register(entry);
    let mut renderer = Renderer::new(shadowgraph_testing::renderer()?.gpu().clone(), catalog);
    let cases: Vec<_> = cases::all()
        .iter()
        .filter(|entry| ids.contains(&entry.id))
        .flat_map(|entry| entry.build(&shadowgraph::CAST))
        .collect();
    assert!(
        ids.iter().all(|id| cases.iter().any(|case| case.id == *id)),
        "not every case of {ids:?} is there"
    );
    Some(cases.iter().flat_map(|case| try_all(&mut renderer, case, ROWS)).collect())
}

/// All of these cases turn red in at least one variant, and the complaint says `word`.
fn turns_red(from_params: FromParams, ids: &[&str], word: &str) {
    let sound: FromParams = |_| broken(ShadowVolumeHard::default(), |_| ());
    turns_red_of(ShadowVolumeHard::ENTRY, [sound, from_params], ids, word);
}

/// The same of the technique of this entry, sound and broken.
fn turns_red_of(entry: TechniqueEntry, [sound, broken]: [FromParams; 2], ids: &[&str], word: &str) {
    // Sound, they are green: what turns them red is the sabotage.
    let Some(sound) = trials(TechniqueEntry { from_params: sound, ..entry }, ids) else { return };
    for trial in sound {
        assert_eq!(trial.complaint, None, "{}", trial.name());
    }
    let trials = trials(TechniqueEntry { from_params: broken, ..entry }, ids).unwrap();
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
                let Geometry::Indexed { shader, .. } = &mut draw.geometry else { return };
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
                     return Varyings(v.clip + {pixel}, v.volume);\n}}\n"
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
fn a_narrow_counter() {
    // 128 layers come to nothing in six bits.
    turns_red(
        |_| {
            broken(ShadowVolumeHard::default(), |draw| {
                if let Some(stencil) = &mut draw.state.stencil {
                    stencil.write_mask &= 0x3f;
                }
            })
        },
        &["overlap-open-128"],
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
fn caps_at_their_very_depth() {
    // What lies in a cap's own plane is then in its shadow or not as rounding has it.
    turns_red(
        |_| broken(ShadowVolumeHard::default(), |draw| draw.state.depth_bias = 0),
        &["culled-underside", "back-to-back-panels"],
        "outside the band",
    );
}

#[test]
fn inner_walls_that_cast_nothing() {
    // Solids cast with half their triangles, as if all surfaces had two sides: the walls that are seen from inside are not
    // among them. A plan holds on to its scene for good, so the changed one is never dropped.
    let halved: FromParams = |_| {
        let plan: PlanOf = |technique, light, out| {
            let mut snapshot = light.snapshot.clone();
            for material in snapshot.instances.iter_mut().flat_map(|instance| &mut instance.materials) {
                *material = Arc::new(Material { double_sided: true, ..(**material).clone() });
            }
            let mut light = *light;
            light.snapshot = Box::leak(Box::new(snapshot));
            technique.plan(&light, out)
        };
        Ok(Arc::new(Broken { technique: Arc::new(ShadowVolumeHard::default()), spoil: Spoil::Plan(plan) }))
    };
    turns_red(halved, &["room-through-culled-walls", "inward-shell"], "leaks");
}

#[test]
fn a_horizon_that_only_casters_bring() {
    // Where nothing casts, the light's size is passed over.
    let sound: FromParams = |params| {
        let technique = (ShadowVolumeSoft::ENTRY.from_params)(params)?;
        Ok(Arc::new(Broken { technique, spoil: Spoil::Draws(|_| ()) }))
    };
    let broken: FromParams = |params| {
        let technique = (ShadowVolumeSoft::ENTRY.from_params)(params)?;
        let plan: PlanOf = |technique, light, out| {
            let casts = light.casters().any(|(_, instance)| technique.casts(instance) == Ok(true));
            if casts { technique.plan(light, out) } else { Ok(Contribution::default()) }
        };
        Ok(Arc::new(Broken { technique, spoil: Spoil::Plan(plan) }))
    };
    turns_red_of(ShadowVolumeSoft::ENTRY, [sound, broken], &["soft-no-caster"], "outside the band");
}

#[test]
fn a_technique_without_a_row() {
    let Some(renderer) = shadowgraph_testing::renderer() else { return };
    let mut renderer = Renderer::new(renderer.gpu().clone(), shadowgraph_nodes::catalog());
    let case = cases::all().iter().flat_map(|entry| entry.build(&shadowgraph::CAST)).next().unwrap();
    let without: Vec<_> = ROWS.iter().copied().filter(|row| row.setting != "z-fail").collect();
    let red = try_all(&mut renderer, &case, &without).into_iter().filter(|trial| trial.complaint.is_some());
    let red: Vec<_> = red.map(|trial| (trial.setting, trial.complaint.unwrap())).collect();
    assert_eq!(red, [("z-fail", "no row in the table of tolerances".to_owned())]);
}
