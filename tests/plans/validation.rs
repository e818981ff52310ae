//! Broken plans: each kind of mistake is found, and the message names pass and slot.

use shadowgraph_engine::plan::{
    Access, Binding, BlendState, FactorAt, FramePlan, Geometry, Load, Pass, PlanError, SlotId, SlotKind,
};
use shadowgraph_testing::*;

/// A valid plan of two shadowed lights: prepass, volumes, resolve, volumes, resolve, shading.
fn valid() -> FramePlan {
    let mut scene = shadowed_yard(&[]);
    let second = add_lamp(&mut scene, "second");
    scene.node_mut(second).expect("it was just added").parent_from_local.translation.x += 1.0;
    let plan = plan(&scene, &request());
    assert_eq!(plan.validate(), Ok(()));
    plan
}

fn pass<'a>(plan: &'a mut FramePlan, name: &str) -> &'a mut Pass {
    plan.passes.iter_mut().find(|pass| pass.name == name).unwrap_or_else(|| panic!("no pass '{name}'"))
}

fn slot(plan: &FramePlan, name: &str) -> SlotId {
    SlotId(plan.slots.iter().position(|slot| slot.name == name).unwrap_or_else(|| panic!("no slot '{name}'")))
}

/// The error of the valid plan after `change`; its text must contain `names`.
fn broken(names: &[&str], change: impl FnOnce(&mut FramePlan)) -> PlanError {
    let mut plan = valid();
    change(&mut plan);
    let error = plan.validate().expect_err("the change breaks the plan");
    let text = error.to_string();
    for name in names {
        assert!(text.contains(name), "'{name}' is not named in: {text}");
    }
    error
}

#[test]
fn a_slot_that_is_not_there() {
    let count = valid().slots.len();
    let error = broken(&["'shading'", "slot 99"], |plan| {
        pass(plan, "shading").draws[0].bindings[0].1 = Binding::TextureArray(SlotId(99));
    });
    assert_eq!(error, PlanError::NoSuchSlot { pass: "shading".into(), slot: 99, count });
    for change in [
        |plan: &mut FramePlan| pass(plan, "shading").colors[0].slot = SlotId(99),
        |plan: &mut FramePlan| pass(plan, "shading").depth.as_mut().unwrap().slot = SlotId(99),
        |plan: &mut FramePlan| {
            let Geometry::Indexed { indices, .. } = &mut pass(plan, "volumes of lamp").draws[0].geometry
            else {
                panic!("volumes are indexed")
            };
            *indices = SlotId(99);
        },
    ] {
        assert!(matches!(broken(&["slot 99"], change), PlanError::NoSuchSlot { .. }));
    }
}

#[test]
fn reading_before_writing() {
    let error = broken(&["'shading'", "'light mask'"], |plan| {
        plan.passes.retain(|pass| !pass.name.starts_with("resolve"));
    });
    assert_eq!(error, PlanError::ReadBeforeWrite { pass: "shading".into(), slot: "light mask".into() });
    // In the wrong order.
    let error = broken(&[], |plan| {
        let shading = plan.passes.pop().unwrap();
        plan.passes.insert(1, shading);
    });
    assert!(matches!(error, PlanError::ReadBeforeWrite { .. }));
}

#[test]
fn keeping_what_was_never_cleared() {
    let error = broken(&["'resolve lamp'", "'light mask'"], |plan| {
        pass(plan, "resolve lamp").colors[0].load = Load::Keep;
    });
    assert_eq!(error, PlanError::MissingClear { pass: "resolve lamp".into(), slot: "light mask".into() });
    // Depth.
    let error = broken(&["'volumes of lamp'", "'depth'"], |plan| {
        plan.passes.remove(0);
    });
    assert_eq!(error, PlanError::MissingClear { pass: "volumes of lamp".into(), slot: "depth".into() });
    // The stencil alone.
    let error = broken(&["'depth prepass'", "'depth (stencil)'"], |plan| {
        pass(plan, "depth prepass").depth.as_mut().unwrap().stencil = Some(Access::Keep);
    });
    assert!(matches!(error, PlanError::MissingClear { .. }));
    // Another layer than the one that was cleared.
    let error = broken(&["'resolve second'", "'light mask'"], |plan| {
        let mask = slot(plan, "light mask");
        if let SlotKind::Texture { layers, .. } = &mut plan.slots[mask.0].kind {
            *layers = 2;
        }
        pass(plan, "resolve second").colors[0].layer = 1;
    });
    assert!(matches!(error, PlanError::MissingClear { .. }));
}

/// A change that breaks a plan, and what the error must name.
type Change = (&'static [&'static str], fn(&mut FramePlan));

#[test]
fn formats_and_kinds_that_do_not_match() {
    let changes: [Change; 8] = [
        (&["'shading'", "'depth'", "a colour attachment"], |plan| {
            let slot = slot(plan, "depth");
            pass(plan, "shading").colors[0].slot = slot;
        }),
        (&["'resolve lamp'", "'light mask'"], |plan| pass(plan, "resolve lamp").colors[0].layer = 1),
        (&["'shading'", "'volumes of lamp'"], |plan| {
            let slot = slot(plan, "volumes of lamp");
            pass(plan, "shading").colors[0].slot = slot;
        }),
        (&["'shading'", "'picture'", "a depth attachment"], |plan| {
            let slot = slot(plan, "picture");
            pass(plan, "shading").depth.as_mut().unwrap().slot = slot;
        }),
        (&["'shading'", "'depth'", "the stated stencil"], |plan| {
            pass(plan, "shading").depth.as_mut().unwrap().stencil = None;
        }),
        (&["'shading'", "'picture'"], |plan| {
            let slot = slot(plan, "picture");
            pass(plan, "shading").draws[0].bindings[0].1 = Binding::StencilOf(slot);
        }),
        (&["'shading'", "'light mask'"], |plan| {
            let slot = slot(plan, "light mask");
            pass(plan, "shading").draws[0].bindings[0].1 = Binding::Storage(slot);
        }),
        (&["'volumes of lamp'", "'picture'", "an index buffer"], |plan| {
            let picture = slot(plan, "picture");
            let Geometry::Indexed { indices, .. } = &mut pass(plan, "volumes of lamp").draws[0].geometry
            else {
                panic!("volumes are indexed")
            };
            *indices = picture;
        }),
    ];
    for (names, change) in changes {
        let error = broken(names, change);
        assert!(matches!(error, PlanError::WrongKind { .. }), "{error}");
    }
}

#[test]
fn reading_what_is_being_written() {
    let error = broken(&["'resolve second'", "'light mask'"], |plan| {
        let mask = slot(plan, "light mask");
        pass(plan, "resolve second").draws[0].bindings.push((0, Binding::TextureArray(mask)));
    });
    assert!(matches!(error, PlanError::ReadWhileWritten { .. }));
    let error = broken(&["'volumes of lamp'", "'depth'"], |plan| {
        let depth = slot(plan, "depth");
        pass(plan, "volumes of lamp").draws[0].bindings.push((2, Binding::StencilOf(depth)));
    });
    assert!(matches!(error, PlanError::ReadWhileWritten { .. }));
}

#[test]
fn draws_that_do_not_fit_their_pass() {
    let error =
        broken(&["'volumes of lamp'", "'crate closed z-pass to a plane'", "1 colour targets"], |plan| {
            pass(plan, "volumes of lamp").draws[0].state.targets = vec![Some(BlendState::REPLACE)];
        });
    assert!(matches!(error, PlanError::TargetCount { given: 1, needed: 0, .. }));
    let error = broken(&["'shading'", "writes depth"], |plan| {
        pass(plan, "shading").draws[0].state.depth_write = true;
    });
    assert!(matches!(error, PlanError::NotWritable { aspect: "depth", .. }));
    let error = broken(&["'volumes of lamp'", "the stencil"], |plan| {
        pass(plan, "volumes of lamp").depth.as_mut().unwrap().stencil = Some(Access::ReadOnly);
    });
    assert!(matches!(error, PlanError::NotWritable { .. }));
    let error = broken(&["'volumes of lamp'", "the stencil"], |plan| {
        pass(plan, "volumes of lamp").depth = None;
    });
    assert!(matches!(error, PlanError::NotWritable { .. }));
}

#[test]
fn indices_beyond_the_buffer() {
    let held = buffer(&valid(), "volume indices of lamp").0.len() as u64 / 4;
    let error = broken(
        &["'volumes of lamp'", "'crate closed z-pass to a plane'", "'volume indices of lamp'"],
        |plan| {
            let Geometry::Indexed { first, count, .. } = &mut pass(plan, "volumes of lamp").draws[0].geometry
            else {
                panic!("volumes are indexed")
            };
            (*first, *count) = (u32::MAX, u32::MAX);
        },
    );
    let PlanError::IndexRange { end, count, .. } = error else { panic!("{error}") };
    assert_eq!((end, count), (2 * u64::from(u32::MAX), held));
}

#[test]
fn scissors_beyond_the_picture() {
    let [width, height] = SIZE_PX;
    for scissor in [[1, 0, width, height], [0, 1, width, height], [u32::MAX, 0, 1, 1]] {
        let error = broken(&["'resolve lamp'", "64x48"], |plan| {
            pass(plan, "resolve lamp").draws[0].scissor_px = Some(scissor);
        });
        assert!(matches!(error, PlanError::ScissorOutside { .. }));
    }
}

#[test]
fn factors_that_nothing_writes() {
    let error = broken(&["'lamp'", "layer 0 of the visibility array"], |plan| {
        plan.lights[0].factor = FactorAt::Visibility(0);
    });
    assert!(matches!(error, PlanError::FactorNeverWritten { .. }));
    broken(&["'second'", "bit 32 of the light mask"], |plan| plan.lights[1].factor = FactorAt::MaskBit(32));
    broken(&["'lamp'", "the stencil"], |plan| {
        plan.lights[0].factor = FactorAt::Counts;
        for pass in &mut plan.passes {
            pass.draws.iter_mut().for_each(|draw| draw.state.stencil = None);
        }
    });
}

#[test]
fn counts_that_leak_into_the_next_light() {
    let counted = [10, 10, 20, 20];
    let confine = |plan: &mut FramePlan, resolved| {
        for draw in &mut pass(plan, "volumes of lamp").draws {
            draw.scissor_px = Some(counted);
        }
        pass(plan, "resolve lamp").draws[0].scissor_px = Some(resolved);
    };
    for resolved in [[11, 10, 20, 20], [10, 10, 19, 20], [10, 11, 40, 30], [10, 10, 20, 19]] {
        let error = broken(&["'volumes of lamp'", "leak"], |plan| confine(plan, resolved));
        assert_eq!(error, PlanError::CountsLeak { pass: "volumes of lamp".into(), counted, resolved });
    }
    for resolved in [counted, [9, 9, 22, 22], [0, 0, 64, 48]] {
        let mut plan = valid();
        confine(&mut plan, resolved);
        assert_eq!(plan.validate(), Ok(()), "{resolved:?} contains {counted:?}");
    }
    // A volume without a scissor counts in the whole picture.
    let error = broken(&["'volumes of second'"], |plan| {
        pass(plan, "resolve second").draws[0].scissor_px = Some([0, 0, 63, 48]);
    });
    assert!(matches!(error, PlanError::CountsLeak { counted: [0, 0, 64, 48], .. }));
}
