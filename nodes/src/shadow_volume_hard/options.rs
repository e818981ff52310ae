//! The options of `ShadowVolumeHard`: their values, their names in scenes, and how they are read and saved.

use std::sync::Arc;

use shadowgraph_engine::scene::{ParamValue, Params, ShadowNode};
use shadowgraph_engine::shadow::{OptionError, OptionReader, Setting, TechniqueEntry};

/// From where crossings are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthTest {
    /// z-pass where the near plane is certainly unshadowed by the caster, z-fail elsewhere.
    #[default]
    Auto,
    /// From the near plane to the surface; refused where the near plane may be in shadow.
    ZPass,
    /// From the surface to infinity; always right, and needs caps.
    ZFail,
}

/// Which triangles cast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GeometryMode {
    /// Closed where the caster is a solid with light and eye outside, open elsewhere.
    #[default]
    Auto,
    /// Only triangles that face the light outwards; refused for casters that are no solids.
    Closed,
    /// All triangles.
    Open,
}

/// Where volumes end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extrusion {
    /// On a plane behind all receivers where that is exact, else at infinity.
    #[default]
    Auto,
    /// At infinity.
    Infinite,
    /// On a plane behind all receivers; refused where that is not exact.
    ToBounds,
}

/// How open casters are closed before they cast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
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

/// How the shadows of several lights are put into the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Passes {
    /// Each light is counted by itself and takes away its own light.
    #[default]
    Multi,
    /// All lights are counted at once, and the finished picture is darkened once.
    Single {
        /// How much of the picture's light a shadow takes away, from 0 to 1.
        weight: f64,
    },
}

impl Passes {
    /// `Single` with the weight it has when none is given.
    pub const SINGLE: Self = Self::Single { weight: 0.5 };
}

/// Where counts are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CounterKind {
    /// In the stencil: for no number of layers that was measured were frames with float counts faster beyond noise.
    #[default]
    Auto,
    /// In the stencil, in groups where it is too small.
    Stencil8,
    /// In a float target, added up by blending.
    Float,
}

/// Where the night begins on a caster that is shaded smooth.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Terminator {
    /// Where its triangles turn away from the light.
    #[default]
    Geometric,
    /// Where its normals do; a solid casts with its far side then. Pictures only: factors stay geometric.
    Smooth,
}

/// The node and its options.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShadowVolumeHard {
    /// From where crossings are counted.
    pub depth_test: DepthTest,
    /// Which triangles cast.
    pub geometry: GeometryMode,
    /// How open casters are closed.
    pub closure: Closure,
    /// How several lights are put together.
    pub passes: Passes,
    /// Where volumes end.
    pub extrusion: Extrusion,
    /// Where counts are kept.
    pub counter: CounterKind,
    /// Where the night begins on smooth casters.
    pub terminator: Terminator,
}

/// The type name scenes use.
pub(super) const TYPE_NAME: &str = "ShadowVolumeHard";
pub(crate) const DEPTH_TESTS: &[(&str, DepthTest)] =
    &[("auto", DepthTest::Auto), ("zpass", DepthTest::ZPass), ("zfail", DepthTest::ZFail)];
pub(crate) const GEOMETRIES: &[(&str, GeometryMode)] =
    &[("auto", GeometryMode::Auto), ("closed", GeometryMode::Closed), ("open", GeometryMode::Open)];
pub(crate) const CLOSURES: &[(&str, Closure)] =
    &[("none", Closure::None), ("cap", Closure::Cap), ("backfaces", Closure::Backfaces)];
const PASSES: &[(&str, Passes)] = &[("multi", Passes::Multi), ("single", Passes::SINGLE)];
const EXTRUSIONS: &[(&str, Extrusion)] =
    &[("auto", Extrusion::Auto), ("infinite", Extrusion::Infinite), ("toBounds", Extrusion::ToBounds)];
pub(crate) const COUNTERS: &[(&str, CounterKind)] =
    &[("auto", CounterKind::Auto), ("stencil8", CounterKind::Stencil8), ("float", CounterKind::Float)];
const TERMINATORS: &[(&str, Terminator)] =
    &[("geometric", Terminator::Geometric), ("smooth", Terminator::Smooth)];

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
        params: || ShadowVolumeHard { passes: Passes::SINGLE, ..ShadowVolumeHard::default() }.to_params(),
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
    /// How the catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry {
        type_name: TYPE_NAME,
        short_name: "hard",
        summary: "exact hard shadows of any triangles, counted in the stencil",
        from_params: |params| Ok(Arc::new(Self::from_params(params)?)),
        settings: SETTINGS,
    };

    /// Reads the options.
    ///
    /// # Errors
    /// [`OptionError`] names the option and what is accepted.
    pub fn from_params(params: &Params) -> Result<Self, OptionError> {
        let mut options = OptionReader::new(TYPE_NAME, params);
        let mut node = Self {
            depth_test: options.choice("depthTest", DEPTH_TESTS)?,
            geometry: options.choice("geometry", GEOMETRIES)?,
            closure: options.choice("closure", CLOSURES)?,
            passes: options.choice("passes", PASSES)?,
            extrusion: options.choice("extrusion", EXTRUSIONS)?,
            counter: options.choice("counter", COUNTERS)?,
            terminator: options.choice("terminator", TERMINATORS)?,
        };
        let given = params.contains_key("weight");
        let number = options.number("weight", 0.5, 0.0, 1.0)?;
        if let Passes::Single { weight } = &mut node.passes {
            *weight = number;
            // One stencil holds the counts of all lights, and there is one darkening to do.
            if node.counter == CounterKind::Float {
                return Err(options.conflict("counter", "auto, stencil8 with passes=single"));
            }
        } else if given {
            return Err(options.conflict("weight", "with passes=single only"));
        }
        options.finish()?;
        Ok(node)
    }

    /// All options with their values.
    pub(super) fn to_params(self) -> Params {
        let passes = if self.passes == Passes::Multi { "multi" } else { "single" };
        let mut params = Params::from([
            ("depthTest".into(), name_of(DEPTH_TESTS, &self.depth_test)),
            ("geometry".into(), name_of(GEOMETRIES, &self.geometry)),
            ("closure".into(), name_of(CLOSURES, &self.closure)),
            ("passes".into(), ParamValue::Text(passes.into())),
            ("extrusion".into(), name_of(EXTRUSIONS, &self.extrusion)),
            ("counter".into(), name_of(COUNTERS, &self.counter)),
            ("terminator".into(), name_of(TERMINATORS, &self.terminator)),
        ]);
        if let Passes::Single { weight } = self.passes {
            params.insert("weight".into(), ParamValue::Number(weight));
        }
        params
    }
}

/// The name of `value` among `values`, as scenes have it.
pub(crate) fn name_of<T: PartialEq>(values: &[(&'static str, T)], value: &T) -> ParamValue {
    let name = values.iter().find(|(_, v)| v == value).map_or("", |(name, _)| name);
    ParamValue::Text(name.into())
}

impl From<ShadowVolumeHard> for ShadowNode {
    fn from(node: ShadowVolumeHard) -> Self {
        Self { technique: TYPE_NAME.into(), params: node.to_params(), ..Self::default() }
    }
}
