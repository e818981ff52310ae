//! A technique that plans what a test says, and the entry that makes it.

use std::fmt;

use shadowgraph_engine::plan::{BlendState, CompareFunction, DrawState, Shader};
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Binding, Catalog, ColorTarget, Contribution, Draw, Geometry, LightContext, Pass, PassList, ShadowError,
    ShadowTechnique, TechniqueEntry, Traits,
};

type Planned = Result<Contribution, ShadowError>;
type Casts = dyn Fn(&Instance) -> Result<bool, String> + Send + Sync;
type Plan = dyn Fn(&LightContext<'_>, &mut PassList<'_>) -> Planned + Send + Sync;

/// A technique that casts everything and plans what it is made with.
pub struct Plain {
    params: Params,
    traits: Traits,
    casts: Box<Casts>,
    plan: Box<Plan>,
}

impl Plain {
    pub fn new(
        plan: impl Fn(&LightContext<'_>, &mut PassList<'_>) -> Planned + Send + Sync + 'static,
    ) -> Self {
        let traits = Traits { known_error: "everything", ..Traits::default() };
        Self { params: Params::new(), traits, casts: Box::new(|_| Ok(true)), plan: Box::new(plan) }
    }

    pub fn with_params(self, params: &Params) -> Self {
        Self { params: params.clone(), ..self }
    }

    pub fn with_traits(self, traits: Traits) -> Self {
        Self { traits, ..self }
    }

    pub fn casting(self, casts: impl Fn(&Instance) -> Result<bool, String> + Send + Sync + 'static) -> Self {
        Self { casts: Box::new(casts), ..self }
    }
}

impl fmt::Debug for Plain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Plain").field("params", &self.params).finish_non_exhaustive()
    }
}

impl ShadowTechnique for Plain {
    fn params(&self) -> Params {
        self.params.clone()
    }

    fn traits(&self) -> Traits {
        self.traits
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        (self.casts)(instance)
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Planned {
        (self.plan)(light, out)
    }
}

/// The entry of a [`Plain`] technique: its type name, and what makes it from the options of a node.
#[macro_export]
macro_rules! technique {
    ($name:literal, $make:expr) => {
        shadowgraph_engine::shadow::TechniqueEntry {
            type_name: $name,
            short_name: $name,
            summary: "a test",
            settings: &[],
            from_params: |params| {
                let make: fn(&shadowgraph_engine::scene::Params) -> $crate::Plain = $make;
                Ok(std::sync::Arc::new(make(params)))
            },
            options: shadowgraph_engine::shadow::OptionTable::none,
        }
    };
}

/// The project's techniques and these.
pub fn catalog_with(entries: &[TechniqueEntry]) -> Catalog {
    let mut catalog = shadowgraph_nodes::catalog();
    entries.iter().for_each(|entry| catalog.register(*entry));
    catalog
}

/// A pass that a test adds.
pub fn pass(name: &str, draws: Vec<Draw>) -> Pass {
    Pass { name: name.into(), reason: "a test".into(), colors: vec![], depth: None, draws }
}

/// A pass of one triangle over the light's visibility; its shader has `fullscreen_vertex`.
pub fn over_visibility(
    name: &str,
    shader: Shader,
    blend: Option<BlendState>,
    bindings: Vec<(u32, Binding)>,
) -> Pass {
    let state = DrawState::new(CompareFunction::Always, vec![blend]);
    let draw = Draw::new(name, Geometry::fullscreen(shader), state).reading(bindings);
    Pass { colors: vec![ColorTarget::VISIBILITY], ..pass(name, vec![draw]) }
}

/// A technique that multiplies the light's visibility by nothing at all.
pub const VEIL: TechniqueEntry = technique!("Veil", |_| {
    Plain::new(|light, out| {
        let shader = Shader::composed("resolve_mask", &[], "fullscreen_vertex", Some("darken"))?;
        out.pass(over_visibility(&format!("veil of {}", light.light().name), shader, None, vec![]));
        Ok(Contribution::visibility(shadowgraph_engine::shadow::Channels::One))
    })
});
