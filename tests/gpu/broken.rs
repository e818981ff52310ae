//! Any technique, broken on purpose: what it has planned is spoilt as a slip in its code would.

use std::sync::Arc;

use shadowgraph::engine::scene::{Instance, Params};
use shadowgraph::engine::shadow::{
    Contribution, Draw, Geometry, LightContext, Pass, PassList, ShadowError, ShadowTechnique, Traits,
};

/// A technique with something done to what it plans.
#[derive(Debug)]
pub(crate) struct Broken {
    pub(crate) technique: Arc<dyn ShadowTechnique>,
    pub(crate) spoil: Spoil,
}

/// What is done.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Spoil {
    /// To every draw.
    Draws(fn(&mut Draw)),
    /// To every draw of triangles that it lists: the sides and caps of volumes.
    Volumes(fn(&mut Draw)),
    /// To every pass.
    Passes(fn(&mut Pass)),
    /// To the text of every shader that holds the first of the two, as some must: it holds the second in its place.
    Text(&'static str, &'static str),
    /// In place of its plan.
    Plan(PlanOf),
}

/// What stands in for the plan of a technique.
pub(crate) type PlanOf =
    fn(&dyn ShadowTechnique, &LightContext<'_>, &mut PassList<'_>) -> Result<Contribution, ShadowError>;

impl ShadowTechnique for Broken {
    fn params(&self) -> Params {
        self.technique.params()
    }

    fn traits(&self) -> Traits {
        self.technique.traits()
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        self.technique.casts(instance)
    }

    fn receives(&self, instance: &Instance) -> Result<(), String> {
        self.technique.receives(instance)
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        if let Spoil::Plan(plan) = self.spoil {
            return plan(self.technique.as_ref(), light, out);
        }
        let left = self.technique.plan(light, out)?;
        let passes = out.take_passes();
        if let Spoil::Text(from, _) = self.spoil {
            let shaders =
                passes.iter().flat_map(|pass| &pass.draws).filter_map(|draw| draw.geometry.shader());
            assert!(
                shaders.into_iter().any(|shader| shader.source.contains(from)),
                "no shader says '{from}'"
            );
        }
        for mut pass in passes {
            self.spoil.spoil(&mut pass);
            out.pass(pass);
        }
        Ok(left)
    }
}

impl Spoil {
    fn spoil(&self, pass: &mut Pass) {
        let draws = pass.draws.iter_mut();
        match *self {
            Self::Draws(spoil) => draws.for_each(spoil),
            Self::Volumes(spoil) => {
                let of_volumes = |draw: &&mut Draw| {
                    matches!(draw.geometry, Geometry::Indexed { .. } | Geometry::Numbered { .. })
                };
                draws.filter(of_volumes).for_each(spoil);
            }
            Self::Passes(spoil) => spoil(pass),
            Self::Text(from, to) => draws.for_each(|draw| reword(draw, from, to)),
            // In place of what was planned.
            Self::Plan(_) => {}
        }
    }
}

/// Writes `to` for `from` in the text of a draw's shader, where it is there.
pub(crate) fn reword(draw: &mut Draw, from: &str, to: &str) {
    let shader = match &mut draw.geometry {
        Geometry::Surfaces { .. } => return,
        Geometry::PulledSurfaces { shader, .. }
        | Geometry::Indexed { shader, .. }
        | Geometry::Numbered { shader, .. }
        | Geometry::IndexedProcedural { shader, .. }
        | Geometry::Procedural { shader, .. } => shader,
    };
    if shader.source.contains(from) {
        shader.source = shader.source.replace(from, to).into();
        shader.name = format!("{} with {to}", shader.name).into();
    }
}
