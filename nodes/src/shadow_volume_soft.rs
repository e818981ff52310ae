//! `ShadowVolumeSoft`: soft shadows of any triangles, from spheres and discs of light.
//!
//! *The idea.* From a receiver's point p the light is a disc ([`LightSize::disc`](shadowgraph_engine::shadow::LightSize::disc)), and its factor is the part of the disc
//! that no triangle hides. What hides it is bounded by silhouette edges: where a point of the disc moves across the image
//! of one, the number of triangles before it changes by the edge's weight. So the number at the light's centre and the
//! edges that cross the disc say all.
//!
//! *Sources.* Crow 1977 for the chain of edges; Assarsson & Akenine-Möller 2003, as Lindrud & Löfgren 2004 §4 have it, for
//! penumbrae from silhouette edges; Laine, Aila, Assarsson, Lehtinen & Akenine-Möller 2005 for sampling the light between
//! edges that each receiver finds for itself.
//!
//! *What differs here.*
//! - The silhouette is that of the receiver's point, not of the light's centre: which edges belong to it follows from two planes.
//! - Samples are counted as integers, signs are taken once for each triangle and point: any mesh, any overlap is exact.
//! - The lists of edges are looked up in a grid the light looks through, kept until a caster or the light moves.
//! - No bias anywhere: p's own plane is found by the rounding of p, and the part of the light beyond it is dark.
//!
//! This file says what is chosen and why; `options` how it is asked for, `chain` what a caster is for it, `lists` which of
//! it matters where, `masks` what of alpha-masked casters is hole, and each quality has a file.
//!
//! *Limits.* Blended casters cast through coloured techniques.

mod chain;
mod chains;
mod clusters;
mod light_data;
mod lists;
mod masks;
mod near_light_triangles;
mod options;
mod packed;
mod penumbra_mask;
mod per_receiver;
mod sampled;
mod silhouette_culling;
mod slices;
mod stretched;
mod wedge;

use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    self as shadow, Contribution, LightContext, Options, PassList, ShadowError, ShadowTechnique, Traits,
};

pub use light_data::layouts;
pub use options::{Apply, Quality, ShadowVolumeSoft};
pub use wedge::layouts as wedge_layouts;

impl ShadowTechnique for ShadowVolumeSoft {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        let known_error = match self.quality {
            Quality::Sampled => {
                "the light is its samples: at most 0.5/sqrt(samples) off its whole disc; and pixels in which a sample is \
                 blocked or not within 1/256 pixel"
            }
            Quality::PerReceiver => {
                "areas add up: where casters, or layers of one, overlap before the light, penumbrae are too dark; before \
                 one convex caster exact; what casters with holes leave, 64 samples of it, is multiplied"
            }
            Quality::Wedge => {
                "silhouettes are those of the light's centre, areas add up, and along hard shadow edges single pixels are a \
                 layer off, as published in 2003; what casters with holes leave, 64 samples of it, is multiplied"
            }
        };
        let light_samples = (self.quality == Quality::Sampled).then_some(self.samples);
        Traits { known_error, light_size: self.size(), light_samples, ..Traits::default() }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.blocks_light())
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let (weight, color) = (self.weight, [0.0; 3]);
        let apply = match self.apply {
            Apply::PerPixel => shadow::Apply::Light { weight, color },
            Apply::Darken => shadow::Apply::DarkenPicture { weight, color },
        };
        let left = match self.quality {
            _ if !self.size().is_wide(light.light().position) => self.hard().plan(light, out)?,
            Quality::Sampled => self.plan_sampled(light, out)?,
            Quality::PerReceiver => self.plan_per_receiver(light, out)?,
            Quality::Wedge => self.plan_wedges(light, out)?,
        };
        Ok(Contribution { apply, ..left })
    }
}
