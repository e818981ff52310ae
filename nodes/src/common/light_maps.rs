//! The maps of one light and the pass that looks them up: what every technique of maps does alike.

use shadowgraph_engine::plan::{CompareFunction, DrawState, MULTIPLY, Shader};
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{Binding, ColorTarget, LightContext, Pass, PassList, ShadowError};

use super::light_views::MapSize;
use super::map_casters::{CasterBuffers, Drawn, casters_of};
use super::shadow_maps::{Biases, MapViews, ShadowMaps};

/// How a light's maps are to be.
#[derive(Clone, Copy, Debug)]
pub struct MapsWanted {
    /// How large each is.
    pub size: MapSize,
    /// How many a directional light has.
    pub cascades: u32,
    /// The biases that somebody has set.
    pub biases: Option<Biases>,
}

/// A light's maps, and what was drawn into them.
pub struct LightMaps<'a> {
    /// The casters.
    pub casters: CasterBuffers<'a>,
    /// The maps.
    pub maps: ShadowMaps,
    views: MapViews,
    is_biased: bool,
}

impl<'a> LightMaps<'a> {
    /// Adds the passes that draw the maps of a light, with those triangles of each caster that `drawn` says; `None` where nothing
    /// in view can be shadowed.
    ///
    /// # Errors
    /// What is wrong with a shader.
    pub fn new(
        light: &LightContext<'a>,
        out: &mut PassList<'_>,
        wanted: MapsWanted,
        drawn: impl Fn(&Instance) -> Drawn,
    ) -> Result<Option<Self>, ShadowError> {
        if light.view.receiver_bounds.is_empty() {
            return Ok(None);
        }
        let casters = casters_of(light, out, drawn);
        let views = MapViews::new(light, &casters, wanted.size, wanted.cascades);
        if views.is_empty() {
            return Ok(None);
        }
        let casters = CasterBuffers::new(light, out, casters);
        let maps = ShadowMaps::new(light, out, &casters, &views, wanted.biases)?;
        let is_biased = wanted.biases.is_some();
        Ok(maps.map(|maps| Self { casters, maps, views, is_biased }))
    }

    /// The flags under which common/shadow_maps asks them.
    pub fn flags(&self, light: &LightContext<'_>) -> Vec<&'static str> {
        let mut flags = self.views.flags();
        flags.extend(light.view.sample_flags());
        flags.extend(self.is_biased.then_some("BIASED"));
        flags
    }

    /// Adds the pass in which every pixel asks the maps, and what else is bound, by a shader whose vertices are `asking` of
    /// common/shadow_maps.
    pub fn look_up(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        shader: &Shader,
        more: Option<(u32, Binding)>,
        reason: String,
    ) {
        let state = DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)]);
        let bindings: Vec<_> = self.maps.bindings(out).into_iter().chain(more).collect();
        let draws = self.maps.look_up(out, (shader, &state), &bindings, self.views.has_cascades());
        let (name, colors) = (format!("look up {}", light.light().name), vec![ColorTarget::VISIBILITY]);
        out.pass(Pass { name, reason, colors, depth: None, draws });
    }
}
