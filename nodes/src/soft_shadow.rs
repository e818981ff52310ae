//! `SoftShadow`: soft shadows on planes, by flattening the casters from each point of the light.
//!
//! *The idea.* What a light's point leaves dark on a plane is the casters' triangles projected onto it. They are drawn
//! there, once for each of `samples` points of the light, and a pixel of the receiver gets the share of points that
//! none of them hides. Any plane receives; any triangles cast, glass in its colours (see [`tints`]).
//!
//! *Sources.* Blinn 1988; Lindrud & Löfgren 2004 §5.2, whose node had this name and its faults: here are their cures.
//!
//! - *Shadows past the receiver's edge.* Only pixels in which the receiver is the visible surface are shaded.
//! - *Double darkening.* A point of the light marks a pixel once: the stencil holds the number of the point that
//!   marked it last, and a point's own number does not mark again. What is marked is one bit, so each point's shadow
//!   is known by itself.
//! - *Shadows of what is behind the light.* Their w is negative, and clipped: see [`casters::clip_from_caster`].
//! - *Shadows of what is under the plane.* Cut off on the CPU, in f64, with all that lies in the plane itself.
//! - *Fixed points are not the light.* The light is a disc that each receiver sees at another angle. The points are
//!   spread in a ball so that they look like that disc from everywhere, weighed for nearness: see [`points`]. With
//!   their number the factor converges to the exact one.
//!
//! Which side of the plane is lit is decided by the eye: what is seen is the side it is on. Points of the light on the
//! other side are dark there.
//!
//! This file says what is drawn; `options` how it is asked for, `receivers` where, `casters` what (their part `above_plane`, in
//! `batches`), `points` from where, `canvas` onto what, `shadowed_area` over how much of a receiver and how finely, `tints` how
//! glass colours it, and `overlap` whether a receiver has places that more than one of its triangles covers.
//!
//! *Limits.* `samples` points give steps in penumbrae, and an error that falls about as samples^-0.8. Rasterisation
//! snaps vertices to 1/256 pixel. A caster within the light's own sphere is before some points of the ball that are
//! behind it on the disc, and behind others: up to 0.1 of the factor is wrong there whatever the samples (it would
//! take the distance along the ray, pixel by pixel). Receivers that are not planar are refused.

mod above_plane;
mod batches;
mod canvas;
mod casters;
mod draws;
mod options;
mod overlap;
mod points;
mod receivers;
mod shadowed_area;
mod tints;

use std::collections::BTreeMap;

use shadowgraph_engine::math::POSITION_EPSILON;
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Apply, Channels, Contribution, LightContext, LightSize, Options, PassList, ShadowError, ShadowTechnique,
    Traits, hash_of,
};

use crate::common::beside_light::distance_to_triangle;
pub use batches::MaskedCorner;
use canvas::{Canvas, Targets};
pub use canvas::{PlanarLight, PlanarTexture, planar_layouts};
use casters::Casters;
pub use options::{MAX_RESOLUTION, MAX_SAMPLES, PlanarMode, SoftShadow};
use points::LightPoints;
pub use receivers::{Flat, NotPlanar};
use receivers::{Receiver, height_of};

/// Points whose bits one layer of a target holds.
const POINTS_OF_A_LAYER: usize = 32;

impl ShadowTechnique for SoftShadow {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        Traits {
            known_error: "a light is as many points as there are samples: steps in penumbrae, by about 0.4 \
                          samples^-0.8; casters within a light's own sphere, which hide some points that they should not \
                          and the other way round; half floats where light passes glass; and rasterisation: pixels whose centre is within 1/256 pixel of a \
                          point's shadow edge",
            light_size: self.light_size(),
            approximates: self.mode == PlanarMode::Texture,
            casts_transparent: true,
            shades_receivers_only: true,
            ..Traits::default()
        }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.materials.iter().any(|material| !material.unlit))
    }

    fn receives(&self, instance: &Instance) -> Result<(), String> {
        Flat::of(instance).map(|_| ()).map_err(|reason| reason.to_string())
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        self.refuse_lamps_beside_casters(light)?;
        let receivers = Receiver::all(light, out)?;
        let lit: Vec<Lit> = receivers.iter().map(|receiver| Lit::new(self, light, receiver)).collect();
        // Turned to the light or away from it as a whole, a receiver's own shadow is the engine's to know, unless another
        // node's disc reaches over its horizon.
        let cut = lit.iter().any(|lit| lit.is_cut());
        let is_wide = self.light_size().is_wide(light.light().position);
        let may_be_left_to_nodes = cut || (is_wide && light.is_beside_size());
        let (mut in_picture, mut visibility) = (BTreeMap::new(), None);
        for (receiver, lit) in receivers.iter().zip(&lit) {
            if may_be_left_to_nodes || !lit.is_dark() {
                let channels = self.shade(light, out, (receiver, lit), &mut in_picture)?;
                visibility = visibility.max(channels);
            }
        }
        Ok(Contribution {
            visibility,
            own_shadow: cut,
            apply: Apply::Light { weight: self.weight, color: self.color },
            ..Contribution::default()
        })
    }
}

/// A light's points, and how high they stand over a receiver.
struct Lit {
    points: LightPoints,
    heights: Vec<f64>,
}

impl Lit {
    fn new(options: &SoftShadow, light: &LightContext<'_>, receiver: &Receiver) -> Self {
        let snapshot = light.light();
        let plane = &receiver.flat.plane;
        let height_m = height_of(plane, snapshot.position).abs();
        let nearest_m = receiver.bounds.distance(snapshot.position.truncate()).max(height_m);
        let size = options.light_size();
        let points =
            LightPoints::new(light.cache, snapshot, size, options.samples, (plane.normal, nearest_m));
        let heights = points.positions.iter().map(|point| height_of(plane, *point)).collect();
        Self { points, heights }
    }

    /// Whether all of the light is under the plane.
    fn is_dark(&self) -> bool {
        self.heights.iter().all(|height| *height <= 0.0)
    }

    /// Whether the plane cuts the light.
    fn is_cut(&self) -> bool {
        let above = self.heights.iter().filter(|height| **height > 0.0).count();
        above > 0 && above < self.heights.len()
    }
}

/// A lamp without a size that is nearer to a caster than this share of the caster's radius, and does not touch it, projects its
/// edges to lines of which f32 cannot tell the direction.
const BESIDE: f64 = 1e-4;

impl SoftShadow {
    fn light_size(&self) -> LightSize {
        LightSize::new(self.radius_m, self.angle_deg)
    }

    /// Refuses what a projection cannot tell.
    fn refuse_lamps_beside_casters(&self, light: &LightContext<'_>) -> Result<(), ShadowError> {
        let position = light.light().position;
        if position.w == 0.0 || self.light_size().is_wide(position) {
            return Ok(());
        }
        let (lamp, bits) = (position.truncate(), position.to_array().map(f64::to_bits));
        for (_, instance) in light.casters() {
            let radius_m = instance.world_bounds.radius();
            if instance.world_bounds.distance(lamp) >= BESIDE * radius_m {
                continue;
            }
            let key = hash_of(("distance of a lamp", instance.pose_key, bits));
            let distance_m = *light.cache.get_or_compute("distance of a lamp", key, || {
                let triangles = 0..instance.mesh.triangle_count();
                let distances = triangles.map(|t| distance_to_triangle(lamp, instance.world_triangle(t)));
                // What it touches but for the rounding of positions, it touches.
                let touched_m = POSITION_EPSILON * (lamp.abs().max_element() + radius_m);
                distances.filter(|distance_m| *distance_m > touched_m).fold(f64::INFINITY, f64::min)
            });
            if distance_m < BESIDE * radius_m {
                return Err(light.unsupported(format!(
                    "'{}' is {distance_m:.1e} m from '{}', beside it but not on it, and has no size (accepted: a lamp \
                     on it, or {:.1e} m and more from it)",
                    light.light().name,
                    instance.name,
                    BESIDE * radius_m
                )));
            }
        }
        Ok(())
    }

    /// The shadow on one plane, and what channels it has; `None` where there is none. What is drawn in the picture with as many points shares its targets:
    /// planes that the light stands on have one point more.
    fn shade(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        (receiver, lit): (&Receiver, &Lit),
        shared: &mut BTreeMap<usize, Targets>,
    ) -> Result<Option<Channels>, ShadowError> {
        // Of what is dark as a whole there is nothing to keep.
        let in_picture = self.mode == PlanarMode::Direct || lit.is_dark();
        let casters = Casters::of(light, out, receiver, &lit.points, in_picture);
        if casters.batches.is_empty() && lit.heights.iter().all(|height| *height > 0.0) {
            return Ok(None);
        }
        let is_tinted = casters.glass().next().is_some();
        let what = (receiver, lit, &casters);
        let canvas = if in_picture {
            Some(Canvas::picture(light))
        } else {
            Canvas::texture(light, receiver, lit, &casters, self.resolution)
        };
        let Some(canvas) = canvas else { return Ok(None) };
        let count = lit.heights.len();
        let targets = if in_picture {
            *shared.entry(count).or_insert_with(|| canvas.targets(out, count))
        } else {
            canvas.targets(out, count)
        };
        draws::mark(light, out, (&canvas, targets), what)?;
        if is_tinted {
            tints::weigh(light, out, (&canvas, targets), what)?;
            return Ok(Some(Channels::Rgb));
        }
        if in_picture {
            draws::weigh(light, out, &canvas, (receiver, lit), targets.bits)?;
        } else {
            draws::weigh_texture(light, out, &canvas, (receiver, lit), targets.bits)?;
        }
        Ok(Some(Channels::One))
    }
}
