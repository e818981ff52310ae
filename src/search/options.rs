//! The options that a technique has, asked of the technique itself, so that a new option or value is searched from the day it
//! is there.

use shadowgraph_engine::scene::{ParamValue, Params};
use shadowgraph_engine::shadow::{Accepts, OptionError, TechniqueEntry};

use super::Random;

/// Values that force what only some views and casters allow, refused elsewhere with a typed error: drawn rarely, since a
/// refusal finds nothing.
const FORCED: &[&str] = &["zpass", "closed", "toBounds"];

/// How large the lights of a scene are taken to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sizes {
    /// As most scenes have it: some centimetres and a few degrees, now and then none at all.
    Plain,
    /// None, tiny, and wider than what stands about.
    Extreme,
    /// None: every soft technique then owes hard shadows.
    None,
}

/// Options for a technique: some at other values than their defaults, all accepted together.
pub(super) fn draw(random: &mut Random, entry: &TechniqueEntry, sizes: Sizes) -> Params {
    let mut all = (entry.options)().options;
    // By name, so that a seed is the same scene in whatever order options are declared.
    all.sort_by(|a, b| a.name.cmp(&b.name));
    for _ in 0..20 {
        let drawn = all.iter().filter_map(|option| {
            Some((option.name.clone(), value(random, &option.name, &option.accepts, sizes)?))
        });
        if let Some(params) = without_idle(entry, drawn.collect()) {
            return params;
        }
    }
    Params::new()
}

/// The options without those that do nothing beside the others; none if the rest is refused.
fn without_idle(entry: &TechniqueEntry, mut params: Params) -> Option<Params> {
    loop {
        match (entry.from_params)(&params) {
            Ok(_) => return Some(params),
            Err(OptionError::Idle { option, .. }) => params.remove(&option)?,
            Err(_) => return None,
        };
    }
}

/// Another value than the default, or none to leave it at that.
fn value(random: &mut Random, name: &str, accepts: &Accepts, sizes: Sizes) -> Option<ParamValue> {
    match accepts {
        Accepts::Words(words) => {
            let word = random.pick(words).name;
            let allowed = if FORCED.contains(&word.as_str()) { 0.03 } else { 0.5 };
            random.chance(allowed).then_some(ParamValue::Text(word))
        }
        Accepts::Number { .. } => number(random, name, sizes).map(ParamValue::Number),
        Accepts::Numbers { .. } | Accepts::Flag => None,
    }
}

fn number(random: &mut Random, name: &str, sizes: Sizes) -> Option<f64> {
    match (name, sizes) {
        ("radius" | "angle", Sizes::None) => Some(0.0),
        ("radius", Sizes::Plain) => Some(if random.chance(0.1) { 0.0 } else { random.by_powers(0.02, 0.8) }),
        ("angle", Sizes::Plain) => Some(if random.chance(0.1) { 0.0 } else { random.by_powers(0.1, 10.0) }),
        ("radius", Sizes::Extreme) => {
            let drawn = random.by_powers(1e-7, 6.0);
            Some(random.pick(&[0.0, 1e-6, 1e-4, 1.0, 5.0, drawn, drawn]))
        }
        ("angle", Sizes::Extreme) => {
            let drawn = random.by_powers(1e-6, 40.0);
            Some(random.pick(&[0.0, 1e-5, 30.0, drawn, drawn]))
        }
        // 16 mostly: a reference ray for each.
        ("samples", _) => Some(random.pick(&[16.0, 16.0, 16.0, 64.0])),
        ("resolution", _) => random.chance(0.5).then_some(512.0),
        ("pcf", _) => Some(random.pick(&[1.0, 2.0, 3.0, 5.0, 7.0])),
        ("cascades", _) => random.chance(0.3).then_some(3.0),
        // It weighs what is seen, not the factors.
        ("weight", _) => None,
        _ => None,
    }
}
