//! Every technique × every hard case × every setting, on linear factors, judged by the exact reference.
//!
//! `CASE=part-of-a-name` tries the cases so called and prints the plan of what fails; `DUMP=folder` writes error maps.

use std::collections::BTreeMap;

use crate::known::KNOWN_ON_CASES;
use crate::tolerances::{ROWS, Row};
use crate::trials::{Trial, dump, is_thinned, print_times, try_all, with_several_renderers};
use shadowgraph::cases::{self, Case, sweeps};
use shadowgraph::measure::ReferenceShadow;
use shadowgraph::prelude::*;

/// The built-in techniques, the reference among them.
fn renderer() -> Option<Renderer> {
    let mut catalog = shadowgraph_nodes::catalog();
    catalog.register(ReferenceShadow::ENTRY);
    Some(Renderer::new(shadowgraph_testing::renderer()?.gpu().clone(), catalog))
}

#[test]
fn every_technique_does_on_every_case_what_it_declares() {
    let filter = std::env::var("CASE").unwrap_or_default();
    let cases = cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST));
    let cases: Vec<Case> = cases.filter(|case| case.name().contains(&filter)).collect();
    assert!(!cases.is_empty(), "no case is called '{filter}'");
    let mut failures = Vec::new();
    let mut accepted: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    let judged = with_several_renderers(renderer, &cases, |renderer, case| {
        let trials = try_all(renderer, case, ROWS);
        let outcome = |trial: &Trial| {
            dump(trial);
            let is_known = KNOWN_ON_CASES
                .iter()
                .any(|known| known.is_about(trial.technique, trial.setting, &trial.case));
            // What is listed and right would excuse the next fault.
            let right =
                (is_known && trial.accepted).then(|| "is right now: strike it out of what is known".into());
            if is_known && trial.complaint.is_some() {
                println!("known: {}", trial.name());
            }
            let complaint = match (&trial.complaint, is_known) {
                (Some(_), true) => None,
                (None, _) => right,
                (Some(complaint), false) => Some(complaint.clone()),
            };
            let complaint = complaint.map(|complaint| {
                if let (Some(evaluation), false) = (&trial.evaluation, filter.is_empty()) {
                    println!("{}", evaluation.frame.plan);
                }
                format!("{}: {complaint}", trial.name())
            });
            let time = (trial.technique, trial.setting, trial.case.clone(), trial.took);
            (time, [trial.accepted, trial.needs_exception], complaint)
        };
        trials.iter().map(outcome).collect::<Vec<_>>()
    });
    let Some(judged) = judged else { return };
    print_times(judged.iter().flatten().map(|(time, ..)| time));
    failures.extend(needless_exceptions(&cases, |technique, setting, case| {
        let mut trials = judged.iter().flatten();
        trials
            .any(|((t, s, c, _), [_, needs], _)| (*t, *s, c.as_str()) == (technique, setting, case) && *needs)
    }));
    for ((technique, setting, ..), [is_accepted, _], complaint) in judged.into_iter().flatten() {
        *accepted.entry((technique, setting)).or_default() += usize::from(is_accepted);
        failures.extend(complaint);
    }
    for ((technique, setting), count) in &accepted {
        println!("{technique} ({setting}): {count} of {} accepted", cases.len());
        let row = ROWS.iter().find(|row| row.technique == *technique && row.setting == *setting);
        let every = filter.is_empty() && !is_thinned(technique, setting);
        if every && row.is_some_and(|row| *count < row.accepts_at_least) {
            failures.push(format!("{technique} ({setting}) accepts only {count} cases"));
        }
    }
    assert!(failures.is_empty(), "{} fail:\n{}", failures.len(), failures.join("\n"));
}

/// What the table excepts from what settings owe, and no variant of these cases needs any more. Only of settings that are tried
/// on every case, and where all variants are there.
fn needless_exceptions(cases: &[Case], needs: impl Fn(&str, &str, &str) -> bool) -> Vec<String> {
    let mut needless = Vec::new();
    // Another driver may round otherwise; this is the one on which the table was made.
    let made_here =
        || shadowgraph_testing::renderer().is_some_and(|renderer| renderer.gpu().name().contains("llvmpipe"));
    if std::env::var_os("CASE").is_some() || !made_here() {
        return needless;
    }
    for row in ROWS.iter().filter(|row| !is_thinned(row.technique, row.setting) || row.setting == "default") {
        for (place, (name, owed)) in row.exceptions().enumerate() {
            let fits = |case: &&Case, name: &str| case.id == name || case.name() == name;
            let earlier = |case: &Case| row.exceptions().take(place).any(|(name, _)| fits(&case, name));
            let mut excepted = cases.iter().filter(|case| fits(case, name) && !earlier(case)).peekable();
            // What is on sweeps is not tried here.
            let is_tried = excepted.peek().is_some();
            if is_tried && !excepted.any(|case| needs(row.technique, row.setting, &case.name())) {
                let Row { technique, setting, .. } = row;
                needless.push(format!("{technique} ({setting}) needs no {owed:?} on '{name}' any more"));
            }
        }
    }
    needless
}

#[test]
fn every_row_belongs_to_a_technique() {
    let mut catalog = shadowgraph_nodes::catalog();
    catalog.register(ReferenceShadow::ENTRY);
    let known: Vec<_> = catalog
        .entries()
        .iter()
        .flat_map(|entry| entry.all_settings().map(|setting| (entry.type_name, setting.name)))
        .collect();
    let listed: Vec<_> = ROWS.iter().map(|row| (row.technique, row.setting)).collect();
    assert_eq!(
        listed.iter().filter(|row| !known.contains(row)).collect::<Vec<_>>(),
        Vec::<&(&str, &str)>::new()
    );
    let unique: std::collections::HashSet<_> = listed.iter().collect();
    assert_eq!(unique.len(), listed.len(), "a row is there twice");
    let names =
        cases::all().into_iter().flat_map(|entry| entry.build(&shadowgraph::CAST)).map(|case| case.name());
    let steps = sweeps::all()
        .into_iter()
        .flat_map(|sweep| sweep.steps(&shadowgraph::CAST))
        .map(|(_, case)| case.name());
    let names: Vec<_> = names.chain(steps).collect();
    for (case, _) in ROWS.iter().flat_map(|row| row.exceptions()) {
        let found = names.iter().any(|name| name == case || name.starts_with(&format!("{case}/")));
        assert!(found, "no case is called '{case}'");
    }
}
