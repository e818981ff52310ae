//! Technique × hard case: every factor is judged by the exact reference.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking and reports by printing"
)]

mod common;

use shadowgraph::cases::{self, Case, Expect};
use shadowgraph::measure::{ErrorTable, EvaluateError, Evaluation, evaluate, pictures};
use shadowgraph::prelude::*;

/// Renders and judges one case.
fn judge(renderer: &mut Renderer, case: &Case) -> Result<Evaluation, EvaluateError> {
    let request = FrameRequest::new(case.camera.clone(), case.size_px);
    evaluate(renderer, &case.scene, &request, &|_, _| {})
}

/// What is wrong with an evaluation, in a few lines; `None` when it is as the case expects.
fn complaint(case: &Case, result: &Result<Evaluation, EvaluateError>) -> Option<String> {
    let evaluation = match (result, &case.expect) {
        (
            Err(EvaluateError::Render(RenderError::Shadow(_) | RenderError::Frame(_))),
            Expect::Refused { .. },
        ) => {
            return None;
        }
        (Err(error), _) => return Some(format!("failed: {error}")),
        (Ok(_), Expect::Refused { why }) => return Some(format!("drew something, but should refuse: {why}")),
        (Ok(evaluation), _) => evaluation,
    };
    let mut wrong = Vec::new();
    // Where nothing is visible there is nothing to compare, and only then.
    let empty =
        case.expect == Expect::NoShadow && evaluation.errors.iter().all(|error| error.hit_pixels == 0);
    if !empty && !evaluation.errors.iter().all(|error| error.passes()) {
        wrong.push(ErrorTable(&evaluation.errors).to_string());
    }
    for error in &evaluation.errors {
        let (dark, lit) = (error.shadow_pixels > 0, error.shadow_pixels < error.compared);
        match case.expect {
            Expect::Shadow if !(dark && lit) => wrong.push(format!("{}: no shadow to get wrong", error.name)),
            Expect::NoShadow if dark => {
                wrong.push(format!("{}: a shadow where none is expected", error.name));
            }
            _ => {}
        }
    }
    (!wrong.is_empty()).then(|| wrong.join("\n"))
}

/// Writes the error maps of a case, for looking at.
fn dump(case: &Case, evaluation: &Evaluation, folder: &std::path::Path) {
    std::fs::create_dir_all(folder).unwrap();
    for (light, _) in &evaluation.measured.lights {
        let path = folder.join(format!("{}-{light}.png", case.name().replace('/', "_")));
        pictures::write_error_map(&path, &evaluation.measured, &evaluation.reference, light).unwrap();
    }
}

#[test]
fn hard_volumes_equal_the_reference_on_every_hard_case() {
    let Some(mut renderer) = common::renderer() else { return };
    let filter = std::env::var("CASE").unwrap_or_default();
    let mut failures = Vec::new();
    let mut judged = 0;
    for case in
        cases::all().iter().flat_map(|entry| entry.build()).filter(|case| case.name().contains(&filter))
    {
        let result = judge(&mut renderer, &case);
        judged += 1;
        if let (Ok(evaluation), Some(folder)) = (&result, std::env::var_os("DUMP")) {
            dump(&case, evaluation, std::path::Path::new(&folder));
        }
        if let Some(complaint) = complaint(&case, &result) {
            if filter.is_empty() {
                failures.push(format!("{}: {complaint}", case.name()));
            } else {
                println!("{}: {complaint}", case.name());
                if let Ok(evaluation) = &result {
                    println!("{}", evaluation.frame.plan);
                }
                failures.push(case.name());
            }
        }
    }
    assert!(judged > 0, "no case is called '{filter}'");
    assert!(failures.is_empty(), "{} of {judged} cases fail:\n{}", failures.len(), failures.join("\n"));
}
