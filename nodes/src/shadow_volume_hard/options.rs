//! The options of `ShadowVolumeHard`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph_engine::shadow::{Clash, Options, Setting, TechniqueEntry};

pub use crate::common::volume_options::{Closure, CounterKind, DepthTest, GeometryMode};

/// Where volumes end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Extrusion {
    /// On a plane behind all receivers where that is exact, else at infinity.
    #[default]
    Auto,
    /// At infinity.
    Infinite,
    /// On a plane behind all receivers; refused where that is not exact.
    ToBounds,
}

/// Where the terminator of a smooth-shaded caster lies, the line beyond which it is turned away from the light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Terminator {
    /// Where its triangles turn away from the light.
    #[default]
    Geometric,
    /// Where its shading normals turn away; a solid then casts with its far side. In pictures only: factors stay
    /// geometric.
    Smooth,
}

/// How the shadows of several lights are applied to the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Passes {
    /// Each light is counted by itself, and its own light is taken away.
    #[default]
    Multi,
    /// All lights are counted at once, and the finished picture is darkened once.
    Single,
}

/// Hard shadow volumes, exact for any caster: the options of a node.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct ShadowVolumeHard {
    /// From where crossings are counted: `zpass` from the near plane, refused where that may be in shadow; `zfail` from
    /// infinity; `auto` per caster.
    pub depth_test: DepthTest,
    /// Which triangles cast: of a solid those that face the light, refused for what is no solid; or all.
    pub geometry: GeometryMode,
    /// How open casters are closed before they cast. `cap` is wrong where light comes through an opening or a lid passes
    /// through its mesh; `backfaces` doubles every face.
    pub closure: Closure,
    /// Each light by itself, or one darkening of the finished picture for all: too light where shadows cross.
    pub passes: Passes,
    /// How much of its light the picture loses in the one darkening; with `passes` `single` only.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub weight: f64,
    /// Where volumes end; `toBounds` is refused where it would not be exact.
    pub extrusion: Extrusion,
    /// Where counts are kept; not `float` with `passes` `single`.
    pub counter: CounterKind,
    /// Where the terminator of a smooth-shaded caster lies: at its triangles, or at its normals, in pictures only;
    /// not `smooth` with `geometry` `open`.
    pub terminator: Terminator,
}

impl Default for ShadowVolumeHard {
    fn default() -> Self {
        Self {
            depth_test: DepthTest::default(),
            geometry: GeometryMode::default(),
            closure: Closure::default(),
            passes: Passes::default(),
            weight: 0.5,
            extrusion: Extrusion::default(),
            counter: CounterKind::default(),
            terminator: Terminator::default(),
        }
    }
}

/// What reports and tests try beside the default: all of it exact but `cap`.
const SETTINGS: &[Setting] = &[
    Setting {
        name: "z-pass",
        why: "counting from the near plane, which needs no caps",
        params: || {
            ShadowVolumeHard { depth_test: DepthTest::ZPass, ..ShadowVolumeHard::default() }.to_params()
        },
    },
    Setting {
        name: "z-fail",
        why: "counting from infinity, which is right wherever the eye is",
        params: || {
            ShadowVolumeHard { depth_test: DepthTest::ZFail, ..ShadowVolumeHard::default() }.to_params()
        },
    },
    Setting {
        name: "open",
        why: "every triangle casts, closed casters too",
        params: || {
            ShadowVolumeHard { geometry: GeometryMode::Open, ..ShadowVolumeHard::default() }.to_params()
        },
    },
    Setting {
        name: "infinite",
        why: "sides to infinity, where the default ends them behind what receives",
        params: || {
            ShadowVolumeHard { extrusion: Extrusion::Infinite, ..ShadowVolumeHard::default() }.to_params()
        },
    },
    Setting {
        name: "backfaces",
        why: "open casters with a reverse for every face: the same picture, and twice the edges to look at",
        params: || {
            ShadowVolumeHard { closure: Closure::Backfaces, ..ShadowVolumeHard::default() }.to_params()
        },
    },
    Setting {
        name: "cap",
        why: "open casters closed by lids over their loops, which cast too: what a closed mode alone would need",
        params: || ShadowVolumeHard { closure: Closure::Cap, ..ShadowVolumeHard::default() }.to_params(),
    },
    Setting {
        name: "float",
        why: "counts in a float target, where the default counts in the stencil",
        params: || {
            ShadowVolumeHard { counter: CounterKind::Float, ..ShadowVolumeHard::default() }.to_params()
        },
    },
    Setting {
        name: "single",
        why: "one darkening of the picture for all lights; factors are each light's own",
        params: || ShadowVolumeHard { passes: Passes::Single, ..ShadowVolumeHard::default() }.to_params(),
    },
    Setting {
        name: "smooth",
        why: "solids cast from their far side, so that smooth casters have a smooth terminator; factors are geometric",
        params: || {
            ShadowVolumeHard { terminator: Terminator::Smooth, ..ShadowVolumeHard::default() }.to_params()
        },
    },
];

impl ShadowVolumeHard {
    /// Its entry in a catalog.
    pub const ENTRY: TechniqueEntry = TechniqueEntry::of::<Self>(
        "hard",
        "exact hard shadows of any triangles, counted in the stencil",
        SETTINGS,
    );
}

impl Options for ShadowVolumeHard {
    const TYPE_NAME: &'static str = "ShadowVolumeHard";

    fn check(&self) -> Vec<Clash> {
        let mut clashes = Vec::new();
        if self.passes == Passes::Multi {
            clashes.push(Clash::Idle { option: "weight", accepted: "with passes=single only" });
        }
        // One stencil holds the counts of all lights, and there is one darkening to do.
        if self.passes == Passes::Single && self.counter == CounterKind::Float {
            let accepted = "auto, stencil8 with passes=single";
            clashes.push(Clash::Contradiction { option: "counter", accepted });
        }
        // Only a solid has a far side that could cast in place of the near one.
        if self.geometry == GeometryMode::Open && self.terminator == Terminator::Smooth {
            clashes.push(Clash::Idle { option: "terminator", accepted: "geometric with geometry=open" });
        }
        clashes
    }
}
