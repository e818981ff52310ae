//! `ShadowMap`: hard shadows looked up in a map of what the light sees.
//!
//! *The idea.* The scene is drawn once as the light sees it, depth only. A point is in shadow if the light sees something nearer
//! than the point where the point would be. What is compared is texels: edges are as exact as texels are small. `pcf` texels
//! along a side are compared for each point, and their answers averaged, never their depths.
//!
//! *Sources.* Williams 1978; Reeves, Salesin & Cook 1987 (comparing first, averaging after); the textbook chapter (003 §8.2 to
//! 8.4); Dimitrov 2007 (cascades); Dou et al. 2014 and EEVEE (what a texel says is asked in its own plane).
//!
//! *What differs here.*
//! - No bias. A texel holds the plane of what is seen as well as its depth, and hides the light only from what lies behind that
//!   plane, and only if its own point lies before the receiver's: see common/shadow_maps.wgsl. Biases that are set are used as
//!   the textbook says.
//! - Windows show what casts and what receives, in fixed sizes at fixed places, so that nothing shimmers: see
//!   [`crate::common::light_views`].
//! - Maps are kept until light, caster or window change.
//! - The triangles that are drawn are chosen on the CPU, once each, in f64.
//!
//! *Limits.* What is thinner than a texel, or behind such, is missed or seen too wide: edges are off by up to a texel, and with
//! `pcf` blurred over as many. Relief finer than a texel may shadow itself. Of a light with a size this is the shadow from
//! its centre.

mod options;

use shadowgraph_engine::plan::{Shader, ShaderError};
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Channels, Contribution, LightContext, Options, PassList, ShadowError, ShadowTechnique, Traits,
};

use crate::common::culling::shows_its_inside;
use crate::common::light_maps::{LightMaps, MapsWanted};
use crate::common::light_views::MapSize;
use crate::common::map_casters::Drawn;
pub(crate) use options::biases;
pub use options::{Faces, MAX_BIAS, MAX_MAP_RESOLUTION, MIN_MAP_RESOLUTION, ShadowMap};

impl ShadowTechnique for ShadowMap {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        Traits {
            known_error: "texels: edges are off by up to one, and blurred over as many as pcf says; what is thinner is missed \
                          or too wide, and relief that is finer may shadow itself",
            approximates: true,
            asks_each_sample: true,
            ..Traits::default()
        }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.blocks_light())
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let size = MapSize { texels: self.resolution, margin: 0.5 * f64::from(self.pcf) + 1.5 };
        let wanted = MapsWanted { size, cascades: self.cascades, biases: self.biases() };
        let Some(maps) = LightMaps::new(light, out, wanted, |instance| self.drawn(light, instance))? else {
            return Ok(Contribution::default());
        };
        let (shader, pcf) = (self.shader(&maps.flags(light))?, self.pcf);
        maps.look_up(light, out, &shader, None, format!("{pcf} x {pcf} texels compared at every pixel"));
        Ok(Contribution::visibility(Channels::One))
    }
}

impl ShadowMap {
    /// The shader that compares so many texels.
    fn shader(&self, flags: &[&str]) -> Result<Shader, ShaderError> {
        let taps = || Ok(format!("const TAPS: i32 = {};\n", self.pcf));
        let name = ("shadow_map", &*format!("of {} texels", self.pcf));
        Shader::replacing(name, flags, ("common/map_taps", taps), "asking", Some("darken"))
    }

    /// Which triangles of an instance are drawn.
    fn drawn(&self, light: &LightContext<'_>, instance: &Instance) -> Drawn {
        match self.faces {
            Faces::Front => Drawn::Front,
            Faces::Back => Drawn::Back,
            Faces::Both => Drawn::Both,
            Faces::Auto if self.biases().is_none() => Drawn::Both,
            Faces::Auto => {
                let topology = instance.mesh.topology();
                let is_solid = topology.orientation(&instance.world_from_local).is_some();
                let position = light.light().position;
                let in_local = instance.world_from_local.inverse().transform_point3(position.truncate());
                let seen_from_within = shows_its_inside(instance, topology)
                    || (position.w > 0.0 && topology.may_enclose(in_local));
                if is_solid && !seen_from_within { Drawn::Back } else { Drawn::Both }
            }
        }
    }
}
