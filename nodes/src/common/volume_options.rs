//! Options that several techniques have: how volumes are made and counted.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// From where crossings are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum DepthTest {
    /// z-pass where the near plane is certainly unshadowed by the caster, z-fail elsewhere.
    #[default]
    Auto,
    /// From the near plane to the surface; refused where the near plane may be in shadow.
    #[serde(rename = "zpass")]
    ZPass,
    /// From the surface to infinity; always right, and needs caps.
    #[serde(rename = "zfail")]
    ZFail,
}

/// Which triangles cast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum GeometryMode {
    /// Closed where the caster is a solid with light and eye outside, open elsewhere.
    #[default]
    Auto,
    /// Only triangles that face the light outwards; refused for casters that are no solids.
    Closed,
    /// All triangles.
    Open,
}

/// How open casters are closed before they cast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Closure {
    /// Not at all: they cast as they are, exactly.
    #[default]
    None,
    /// By caps over their open loops, which cast too: wrong where light shines through an opening, and where a cap
    /// passes through its mesh.
    Cap,
    /// By the reverse of every face; exact.
    Backfaces,
}

/// Where counts are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum CounterKind {
    /// In the stencil: for no number of layers that was measured were frames with float counts faster beyond noise.
    #[default]
    Auto,
    /// In the stencil, in groups where it is too small.
    Stencil8,
    /// In a float target, added up by blending.
    Float,
}
