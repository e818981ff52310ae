//! Any technique, broken on purpose: what it has planned is spoilt as a slip in its code would.

use std::sync::Arc;

use shadowgraph::engine::scene::{Instance, Params};
use shadowgraph::engine::shadow::{
    Contribution, Draw, Geometry, LightContext, PassList, ShadowError, ShadowTechnique, Traits,
};

/// A technique with something done to what it plans.
#[derive(Debug)]
pub(crate) struct Broken {
    pub(crate) technique: Arc<dyn ShadowTechnique>,
    pub(crate) spoil: Spoil,
}

/// What is done.
#[derive(Debug)]
pub(crate) enum Spoil {
    /// To every draw.
    Draws(fn(&mut Draw)),
    /// To every draw of triangles that it lists: the sides and caps of volumes.
    Volumes(fn(&mut Draw)),
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

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let (spoil, all): (fn(&mut Draw), bool) = match self.spoil {
            Spoil::Plan(plan) => return plan(self.technique.as_ref(), light, out),
            Spoil::Draws(spoil) => (spoil, true),
            Spoil::Volumes(spoil) => (spoil, false),
        };
        let left = self.technique.plan(light, out)?;
        for mut pass in out.take_passes() {
            let draws = pass.draws.iter_mut();
            draws.filter(|draw| all || matches!(draw.geometry, Geometry::Indexed { .. })).for_each(spoil);
            out.pass(pass);
        }
        Ok(left)
    }
}
