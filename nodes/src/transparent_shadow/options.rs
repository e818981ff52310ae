//! The options of `TransparentShadow`: their values, their names in scenes, and how they are read and saved.

use std::sync::Arc;

use shadowgraph_engine::scene::{ParamValue, Params, ShadowNode};
use shadowgraph_engine::shadow::{OptionError, OptionReader, Setting, TechniqueEntry};

/// How what passes many surfaces is added up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Accumulate {
    /// Whole numbers of surfaces, for each class of material; then powers of what each lets pass. Exact.
    #[default]
    Counts,
    /// Logarithms, rounded to a grid on which sums of 32-bit floats are exact.
    GridLog,
    /// Logarithms in half floats: Kim, Kim & Turk, equation 3.
    Log16,
    /// Factors multiplied and divided in half floats: their equation 2.
    Product16,
    /// Equation 3 in 32-bit floats, as they foresaw it.
    Log32,
    /// Equation 2 in 32-bit floats.
    Product32,
}

/// On which transparent surfaces its shadows fall; on opaque ones they always do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SelfShadow {
    /// On all.
    #[default]
    Full,
    /// On the first one seen at each pixel: Kim, Kim & Turk, section 6.
    Partial,
    /// On none: they are drawn as if lit.
    None,
}

/// The node and its options.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TransparentShadow {
    /// How what passes many surfaces is added up.
    pub accumulate: Accumulate,
    /// On which transparent surfaces shadows fall.
    pub self_shadow: SelfShadow,
}

/// The type name scenes use.
pub(super) const TYPE_NAME: &str = "TransparentShadow";
const ACCUMULATIONS: &[(&str, Accumulate)] = &[
    ("counts", Accumulate::Counts),
    ("gridLog", Accumulate::GridLog),
    ("log16", Accumulate::Log16),
    ("product16", Accumulate::Product16),
    ("log32", Accumulate::Log32),
    ("product32", Accumulate::Product32),
];
const SELF_SHADOWS: &[(&str, SelfShadow)] =
    &[("full", SelfShadow::Full), ("partial", SelfShadow::Partial), ("none", SelfShadow::None)];

/// What reports and tests try beside the default.
const SETTINGS: &[Setting] = &[
    Setting {
        name: "grid-log",
        why: "logarithms on a grid: one target however many materials, and nothing left where all is taken back",
        params: || TransparentShadow::accumulating(Accumulate::GridLog).to_params(),
    },
    Setting {
        name: "log16",
        why: "Kim, Kim & Turk's equation 3 in half floats, as they drew it: ghosts where volumes overlap",
        params: || TransparentShadow::accumulating(Accumulate::Log16).to_params(),
    },
    Setting {
        name: "product16",
        why: "their equation 2 in half floats, which they found too coarse",
        params: || TransparentShadow::accumulating(Accumulate::Product16).to_params(),
    },
    Setting {
        name: "log32",
        why: "equation 3 in the 32-bit floats they waited for",
        params: || TransparentShadow::accumulating(Accumulate::Log32).to_params(),
    },
    Setting {
        name: "product32",
        why: "equation 2 in 32-bit floats",
        params: || TransparentShadow::accumulating(Accumulate::Product32).to_params(),
    },
];

impl TransparentShadow {
    /// How the catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry {
        type_name: TYPE_NAME,
        short_name: "transparent",
        summary: "exact coloured shadows of transparent casters; opaque ones cast black",
        from_params: |params| Ok(Arc::new(Self::from_params(params)?)),
        settings: SETTINGS,
    };

    /// Reads the options.
    ///
    /// # Errors
    /// [`OptionError`] names the option and what is accepted.
    pub fn from_params(params: &Params) -> Result<Self, OptionError> {
        let mut options = OptionReader::new(TYPE_NAME, params);
        let node = Self {
            accumulate: options.choice("accumulate", ACCUMULATIONS)?,
            self_shadow: options.choice("selfShadow", SELF_SHADOWS)?,
        };
        options.finish()?;
        Ok(node)
    }

    /// The node with this sum, and every other option at its default.
    const fn accumulating(accumulate: Accumulate) -> Self {
        Self { accumulate, self_shadow: SelfShadow::Full }
    }

    /// All options with their values.
    pub(super) fn to_params(self) -> Params {
        Params::from([
            ("accumulate".into(), name_of(ACCUMULATIONS, &self.accumulate)),
            ("selfShadow".into(), name_of(SELF_SHADOWS, &self.self_shadow)),
        ])
    }
}

fn name_of<T: PartialEq>(values: &[(&'static str, T)], value: &T) -> ParamValue {
    let name = values.iter().find(|(_, v)| v == value).map_or("", |(name, _)| name);
    ParamValue::Text(name.into())
}

impl From<TransparentShadow> for ShadowNode {
    fn from(node: TransparentShadow) -> Self {
        Self { technique: TYPE_NAME.into(), params: node.to_params(), ..Self::default() }
    }
}
