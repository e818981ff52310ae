//! `SilhouetteMap`: hard shadows looked up in a map of what the light sees, with the outlines that pass its texels.
//!
//! *The idea.* A shadow map is right but for where outlines pass: there it knows only on which side of them the middles of its
//! texels are. So a second map holds, for each texel that an outline passes, one point of it. The map of depth lies half a
//! texel aside, so that each texel of points has four depths at its corners. Where the four say the same of a receiver, that is
//! it. Where they do not, lines from the texel's point to those of its four neighbours cut it into skewed quadrants, and each
//! is what its corner is: the shadow's edge is a line through points of the outline, not a stair of texels.
//!
//! *Source.* Sen, Cammarano & Hanrahan 2003 (004).
//!
//! *What differs here.*
//! - Outlines are the edges of nonzero weight of the caster's chain, as for shadow volumes: signs once per triangle, in f64,
//!   so open and non-manifold casters have theirs. They are cut and carried into texels in f64.
//! - Of several outlines in a texel the nearest to the light is kept, by a depth test, whatever the order of drawing.
//! - Corners are asked with both planes, without a bias: see common/shadow_maps.wgsl.
//! - Maps are kept until light, caster or window change.
//!
//! *Limits.* One point for each texel: where two outlines pass one, or one bends in it, the edge is off by up to a texel (004
//! Fig. 7). Where casters pass through one another no edge of either is the outline, and holes of masks have none: there points
//! are in the middle of texels, and edges those of a shadow map. Of a light with a size this is the shadow from its centre.

mod edges;
mod options;

use shadowgraph_engine::plan::{
    Access, BlendState, CompareFunction, DrawState, Lifetime, Load, Resource, Shader, TextureDesc,
    TextureFormat,
};
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Binding, Channels, ColorTarget, Contribution, DepthTarget, Draw, Geometry, LightContext, Options, Pass,
    PassList, ShadowError, ShadowTechnique, Traits, hash_of,
};

use crate::common::light_maps::{LightMaps, MapsWanted};
use crate::common::light_views::MapSize;
use crate::common::map_casters::{CasterBuffers, Drawn};
use crate::common::shadow_maps::ShadowMaps;
use edges::edges_in;
pub use edges::{SilhouetteEdge, layout as silhouette_layout};
pub use options::{PointFormat, Show, SilhouetteMap};

/// Where the look-up finds points.
const POINTS: u32 = 5;
/// Texels beside a point that are looked up for it: its corners, and the points of neighbours.
const MARGIN: f64 = 3.0;

impl ShadowTechnique for SilhouetteMap {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        if self.show == Show::Points {
            let known_error = "show=points: discs at the points of silhouettes in place of shadows";
            return Traits { known_error, approximates: true, asks_each_sample: true, ..Traits::default() };
        }
        Traits {
            known_error: "one point for each texel: where two outlines pass one, or one bends in it, where casters pass through \
                          one another, and at holes of masks, edges are off by up to a texel",
            approximates: true,
            asks_each_sample: true,
            ..Traits::default()
        }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.blocks_light())
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let size = MapSize { texels: self.resolution, margin: MARGIN };
        let wanted = MapsWanted { size, cascades: 1, biases: self.biases() };
        let Some(maps) = LightMaps::new(light, out, wanted, |_| Drawn::Both)? else {
            return Ok(Contribution::default());
        };
        let points = self.draw_points(light, out, &maps.casters, &maps.maps)?;
        let mut flags = maps.flags(light);
        flags.extend((self.point_format == PointFormat::OneByte).then_some("BYTE"));
        let (fragment, channels) = match self.show {
            Show::Shadows => ("darken", Channels::One),
            Show::Points => ("show_points", Channels::Rgb),
        };
        let shader = Shader::composed("silhouette_map", &flags, "asking", Some(fragment))?;
        let reason = "four corners compared at every pixel, and where they differ five points";
        maps.look_up(light, out, &shader, Some((POINTS, Binding::TextureArray(points))), reason.into());
        Ok(Contribution::visibility(channels))
    }
}

impl SilhouetteMap {
    /// Adds the passes that draw the points of silhouettes, one for each layer of the maps.
    fn draw_points(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        casters: &CasterBuffers<'_>,
        maps: &ShadowMaps,
    ) -> Result<Resource, ShadowError> {
        let name = &light.light().name;
        let key = hash_of(("silhouettes", maps.key, self.point_format));
        let mut texture = |what: &str, format, reason: &str| {
            let label = format!("{what} of {name}");
            out.texture(TextureDesc {
                layers: maps.layers.len() as u32,
                lifetime: Lifetime::Kept(key),
                ..TextureDesc::new(&label, format, [self.resolution; 2], reason)
            })
        };
        let points =
            texture("silhouette points", self.point_format.texture(), "where an outline passes each texel");
        let nearest = texture(
            "silhouette depth",
            TextureFormat::Depth32Float,
            "of several outlines the nearest is kept",
        );
        // On transparent layers too the points are those that were drawn for the opaque surfaces.
        if light.layer().is_some() {
            return Ok(points);
        }
        let flags: &[&str] = if self.point_format == PointFormat::OneByte { &["BYTE"] } else { &[] };
        let mut state = DrawState::new(CompareFunction::Greater, vec![Some(BlendState::REPLACE)]);
        state.depth_write = true;
        for (layer, view) in (0..).zip(&maps.layers) {
            let edges =
                edges_in(light, out, &casters.casters, (view, self.resolution), hash_of((maps.key, layer)));
            let mut draws = Vec::new();
            if let Some((edges, count)) = edges {
                let shader = Shader::composed("silhouette_points", flags, "vertex", Some("store"))?;
                let geometry = Geometry::Procedural { shader, vertices: 6 * count, instances: 1 };
                let draw = Draw::new(format!("{count} edges"), geometry, state.clone());
                let depths = Binding::TextureLayer(maps.depths, layer);
                draws.push(draw.reading(vec![(0, Binding::Storage(edges)), (1, depths)]));
            }
            out.pass(Pass {
                name: format!("silhouettes of {name}"),
                reason: "where what the light sees ends, within each texel".into(),
                colors: vec![ColorTarget {
                    layer,
                    ..ColorTarget::new(points, Load::Clear(self.point_format.middle()))
                }],
                depth: Some(DepthTarget { layer, ..DepthTarget::new(nearest, Access::Clear(0.0)) }),
                draws,
            });
        }
        Ok(points)
    }
}
