//! The options of `ShadowVolumeHard`: their values, their names in scenes, and how they are read and saved.

use std::sync::Arc;

use shadowgraph_engine::scene::{ParamValue, Params, ShadowNode};
use shadowgraph_engine::shadow::{OptionError, OptionReader, Setting, ShadowTechnique, TechniqueEntry};

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

/// The node and its options.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowVolumeHard {
    /// From where crossings are counted.
    pub depth_test: DepthTest,
    /// Which triangles cast.
    pub geometry: GeometryMode,
    /// Where volumes end.
    pub extrusion: Extrusion,
}

/// The type name scenes use.
pub(super) const TYPE_NAME: &str = "ShadowVolumeHard";
const DEPTH_TESTS: &[(&str, DepthTest)] =
    &[("auto", DepthTest::Auto), ("zpass", DepthTest::ZPass), ("zfail", DepthTest::ZFail)];
const GEOMETRIES: &[(&str, GeometryMode)] =
    &[("auto", GeometryMode::Auto), ("closed", GeometryMode::Closed), ("open", GeometryMode::Open)];
const EXTRUSIONS: &[(&str, Extrusion)] =
    &[("auto", Extrusion::Auto), ("infinite", Extrusion::Infinite), ("toBounds", Extrusion::ToBounds)];

impl ShadowVolumeHard {
    /// How the catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry {
        type_name: TYPE_NAME,
        short_name: "hard",
        summary: "exact hard shadows of any triangles, counted in the stencil",
        from_params: |params| Ok(Arc::new(Self::from_params(params)?)),
        settings: &[
            Setting {
                name: "z-pass",
                why: "counting from the near plane, which needs no caps",
                params: || Self { depth_test: DepthTest::ZPass, ..Self::default() }.params(),
            },
            Setting {
                name: "z-fail",
                why: "counting from infinity, which is right wherever the eye is",
                params: || Self { depth_test: DepthTest::ZFail, ..Self::default() }.params(),
            },
            Setting {
                name: "open",
                why: "every triangle casts, closed casters too",
                params: || Self { geometry: GeometryMode::Open, ..Self::default() }.params(),
            },
            Setting {
                name: "infinite",
                why: "sides to infinity, where the default ends them behind what receives",
                params: || Self { extrusion: Extrusion::Infinite, ..Self::default() }.params(),
            },
        ],
    };

    /// Reads the options.
    ///
    /// # Errors
    /// [`OptionError`] names the option and what is accepted.
    pub fn from_params(params: &Params) -> Result<Self, OptionError> {
        let mut options = OptionReader::new(TYPE_NAME, params);
        let node = Self {
            depth_test: options.choice("depthTest", DEPTH_TESTS)?,
            geometry: options.choice("geometry", GEOMETRIES)?,
            extrusion: options.choice("extrusion", EXTRUSIONS)?,
        };
        // Options whose other values are not there yet accept their default, and say so.
        options.choice("closure", &[("none", ())])?;
        options.choice("passes", &[("multi", ())])?;
        options.choice("counter", &[("auto", ()), ("stencil8", ())])?;
        options.choice("terminator", &[("geometric", ())])?;
        options.finish()?;
        Ok(node)
    }

    /// All options with their values.
    pub(super) fn to_params(self) -> Params {
        Params::from([
            ("depthTest".into(), name_of(DEPTH_TESTS, &self.depth_test)),
            ("geometry".into(), name_of(GEOMETRIES, &self.geometry)),
            ("extrusion".into(), name_of(EXTRUSIONS, &self.extrusion)),
        ])
    }
}

fn name_of<T: PartialEq>(values: &[(&'static str, T)], value: &T) -> ParamValue {
    let name = values.iter().find(|(_, v)| v == value).map_or("", |(name, _)| name);
    ParamValue::Text(name.into())
}

impl From<ShadowVolumeHard> for ShadowNode {
    fn from(node: ShadowVolumeHard) -> Self {
        Self { technique: TYPE_NAME.into(), params: node.to_params(), ..Self::default() }
    }
}
