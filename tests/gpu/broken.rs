//! Any technique, broken on purpose: what it has planned is spoilt as a slip in its code would.

use std::sync::Arc;

use shadowgraph::engine::plan::{Draw, Geometry};
use shadowgraph::engine::scene::{Instance, Params};
use shadowgraph::engine::shadow::{Layers, LightPlan, LightSize, Requirements, ShadowError, ShadowTechnique};

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
    Plan(fn(&dyn ShadowTechnique, &mut LightPlan<'_>) -> Result<(), ShadowError>),
}

impl ShadowTechnique for Broken {
    fn type_name(&self) -> &'static str {
        self.technique.type_name()
    }

    fn params(&self) -> Params {
        self.technique.params()
    }

    fn known_error(&self) -> &'static str {
        "whatever was done to it"
    }

    fn requirements(&self) -> Requirements {
        self.technique.requirements()
    }

    fn casts_transparent(&self) -> bool {
        self.technique.casts_transparent()
    }

    fn receiver_layers(&self) -> Layers {
        self.technique.receiver_layers()
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        self.technique.casts(instance)
    }

    fn light_size(&self) -> LightSize {
        self.technique.light_size()
    }

    fn light_sample_count(&self) -> Option<u32> {
        self.technique.light_sample_count()
    }

    fn plan(&self, light: &mut LightPlan<'_>) -> Result<(), ShadowError> {
        match self.spoil {
            Spoil::Draws(spoil) => {
                self.technique.plan(light)?;
                light.passes_mut().iter_mut().flat_map(|pass| &mut pass.draws).for_each(spoil);
                Ok(())
            }
            Spoil::Volumes(spoil) => {
                self.technique.plan(light)?;
                let draws = light.passes_mut().iter_mut().flat_map(|pass| &mut pass.draws);
                draws.filter(|draw| matches!(draw.geometry, Geometry::Indexed { .. })).for_each(spoil);
                Ok(())
            }
            Spoil::Plan(plan) => plan(self.technique.as_ref(), light),
        }
    }
}
