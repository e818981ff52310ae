//! Slips: a technique broken in one place, and a case on which conformance must see it.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::broken::{Broken, Spoil};
use crate::trials::{no_references, try_setting};
use shadowgraph::cases::{self, Case};
use shadowgraph::engine::scene::Params;
use shadowgraph::engine::shadow::{Catalog, OptionError, ShadowTechnique, TechniqueEntry};
use shadowgraph::measure::KnownReferences;
use shadowgraph::prelude::*;

/// One thing wrong with a technique.
pub(crate) struct Slip {
    /// What is wrong.
    pub(crate) what: &'static str,
    /// The full name of a case that shows it.
    pub(crate) case: &'static str,
    /// Makes the broken technique.
    pub(crate) from_params: fn(&Params) -> Result<Arc<dyn ShadowTechnique>, OptionError>,
}

/// The technique of `entry` with its options, spoilt.
pub(crate) fn spoilt(
    entry: TechniqueEntry,
    params: &Params,
    spoil: Spoil,
) -> Result<Arc<dyn ShadowTechnique>, OptionError> {
    Ok(Arc::new(Broken { technique: (entry.from_params)(params)?, spoil }))
}

/// [`Slip`]s of one technique: what is wrong, the case that shows it, and how the plan is spoilt.
macro_rules! slips {
    ($entry:expr; $($what:literal, $case:literal: $spoil:expr;)+) => {
        [$($crate::slips::Slip {
            what: $what,
            case: $case,
            from_params: |params| $crate::slips::spoilt($entry, params, $spoil),
        }),+]
    };
}
pub(crate) use slips;

/// The case of this full name, or all variants of this id.
pub(crate) fn cases_named(name: &str) -> Vec<Case> {
    let id = name.split('/').next().unwrap_or(name);
    let entries = cases::all().into_iter().filter(|entry| entry.id == id);
    let cases = entries.flat_map(|entry| entry.build(&shadowgraph::CAST));
    let cases: Vec<Case> = cases.filter(|case| case.id == name || case.name() == name).collect();
    assert!(!cases.is_empty(), "no case is called '{name}'");
    cases
}

/// A setting of a technique is right on the cases of `slips`, and with each of them wrong: judged by its row of the table, as
/// conformance judges it. It still draws: an error would be no answer.
pub(crate) fn each_turns_red(entry: TechniqueEntry, setting: &str, slips: &[Slip]) {
    let Some(renderer) = shadowgraph_testing::renderer() else { return };
    let setting = entry.all_settings().find(|known| known.name == setting).expect("a setting");
    let mut sound = Renderer::new(renderer.gpu().clone(), shadowgraph::nodes::catalog());
    let mut known: BTreeMap<&str, (Case, KnownReferences)> = BTreeMap::new();
    let mut green = Vec::new();
    for slip in slips {
        let (case, references) = known.entry(slip.case).or_insert_with(|| {
            let (case, mut references) = (cases_named(slip.case).remove(0), no_references());
            let trial = try_setting(&mut sound, &case, (&entry, setting), &mut references);
            assert_eq!(trial.complaint, None, "{} without a slip", trial.name());
            (case, references)
        });
        let broken = TechniqueEntry { from_params: slip.from_params, ..entry };
        let mut catalog = Catalog::new();
        catalog.register(broken);
        let mut renderer = Renderer::new(renderer.gpu().clone(), catalog);
        let trial = try_setting(&mut renderer, case, (&broken, setting), references);
        let complaint = trial.complaint.as_deref().map_or("green", |text| text.lines().next().unwrap());
        println!("{:>5.1} s  {}, {}: {complaint}", trial.took.as_secs_f64(), trial.name(), slip.what);
        if trial.complaint.is_none() || !trial.accepted {
            green.push(format!("{}: {} ({complaint})", trial.name(), slip.what));
        }
    }
    assert!(green.is_empty(), "not seen to be wrong:\n{}", green.join("\n"));
}
