//! The options of `TransparentShadow`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph_engine::shadow::{Options, Setting, TechniqueEntry};

/// How the colours that many surfaces let pass are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
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
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum SelfShadow {
    /// On all.
    #[default]
    Full,
    /// On the first one seen at each pixel: Kim, Kim & Turk, section 6.
    Partial,
    /// On none: they are drawn as if lit.
    None,
}

/// Coloured shadows of transparent casters, hard ones of opaque casters: the options of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct TransparentShadow {
    /// How what passes many surfaces is added up: `counts` exactly; `gridLog` within 7e-4 of it; the others are the paper's
    /// sums, kept to be measured.
    pub accumulate: Accumulate,
    /// On which transparent surfaces its shadows fall: all, the nearest at each pixel, or none; on opaque ones they always do.
    pub self_shadow: SelfShadow,
}

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
    /// Its entry in a catalog.
    pub const ENTRY: TechniqueEntry = TechniqueEntry::of::<Self>(
        "transparent",
        "exact coloured shadows of transparent casters; opaque ones cast black",
        SETTINGS,
    );

    /// The node with this sum, and every other option at its default.
    const fn accumulating(accumulate: Accumulate) -> Self {
        Self { accumulate, self_shadow: SelfShadow::Full }
    }
}

impl Options for TransparentShadow {
    const TYPE_NAME: &'static str = "TransparentShadow";
}
