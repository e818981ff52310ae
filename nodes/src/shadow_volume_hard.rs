//! `ShadowVolumeHard`: exact hard shadows of any triangles, counted in the stencil.
//!
//! *The idea.* Every triangle that faces the light, or faces away from it, bounds a volume of darkness behind it. A
//! view ray that enters a volume counts +1, one that leaves it −1; where the count at the visible surface is not
//! zero, the light is blocked. What is drawn is the *chain* of the caster (see `shadowgraph_engine::geometry`): side
//! quads of silhouette edges with their signed weights of any size, and, where needed, caps. The chain is closed
//! whatever the mesh, so open, non-manifold and inconsistently wound casters cast exactly.
//!
//! *Sources.* Crow 1977; Heidmann 1991; Bilodeau & Songy, Carmack 2000 (z-fail); Bergeron 1986 as Lindrud & Löfgren
//! 2004 §3.2 apply it (open edges 1, closed edges 2); Kim, Kim & Turk for caps of soups.
//!
//! *What differs here.*
//! - Facing is decided once per triangle, in f64, on the CPU; silhouettes are kept until caster or light move.
//! - z-pass or z-fail is chosen per caster; both count in the same stencil.
//! - Front caps are rasterised as the visible surface is (same vertices, same order, same function), and lie behind it by what
//!   depth cannot tell apart: what lies in a receiver's own plane casts nothing on it, however it is tessellated. Nothing
//!   is biased by more than that.
//! - Vertices are extruded along vertex − light computed in two-float precision, so that a light may touch a caster. Edges and
//!   faces that a light all but touches are cut where they pass it: see [`crate::common::beside_light`].
//! - Sides end on one plane behind everything that can receive, where that is exact.
//! - Alpha-masked triangles cast texel by texel, into the light's visibility: see [`crate::common::masked`].
//! - Counts of any size stay exact in the 8-bit stencil: see [`crate::common::layer_groups`]; or in a float target.
//!
//! This file says what is chosen and why; `options` how it is asked for, `draws` how it is drawn.
//!
//! *Limits.* Blended casters cast through coloured techniques. Rasterisation snaps
//! vertices to 1/256 pixel, so pixels whose centre is that near a shadow edge may fall to either side; so may they at the edge of
//! a sheet in the receiver's own plane that is seen at a grazing angle. Triangles thinner than a pixel that pass the eye
//! are rasterised with fewer digits than z-fail needs of them.

mod draws;
mod float_counts;
pub(crate) mod options;

use std::sync::Arc;

use shadowgraph_engine::geometry::{capped, doubled};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{
    Apply, ColorTarget, Contribution, DepthTarget, Draw, Features, LightContext, Options, Pass, PassList,
    ShadowError, ShadowTechnique, Traits, hash_of,
};

use crate::common::culling::{near_plane_may_be_shadowed, shows_its_inside};
use crate::common::extrusion::{End, end_beyond, end_plane};
use crate::common::facing::CasterFacing;
use crate::common::layer_groups::{Caster, MAX_COUNT, group_by_layers};
use crate::common::masked;
use crate::common::volume::{Begin, CastShape, Half, Weights};
use crate::common::volume_draws::{Volume, begin_of, falls_on_itself, upload};
use draws::{Counter, Fold, counting_draws, fold_pass};
pub(crate) use float_counts::Layers;
use float_counts::count_in_float;
pub use options::{
    Closure, CounterKind, DepthTest, Extrusion, GeometryMode, Passes, ShadowVolumeHard, Terminator,
};

/// The errors that are left by design, in words that can be put together.
macro_rules! rounding {
    () => {
        "rasterisation: pixels whose centre is within 1/256 pixel of a shadow edge, or of a sheet's edge in the receiver's \
         own plane"
    };
}
macro_rules! caps {
    () => {
        "closure=cap: false shadows where light shines through an opening: on what lies inside it, and behind it for a \
         light inside"
    };
}
macro_rules! one_darkening {
    () => {
        "passes=single, in pictures: darkened once where shadows of several lights cross, and ambient light and \
         highlights are darkened alike (factors are exact)"
    };
}

impl ShadowTechnique for ShadowVolumeHard {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        let known_error = match (self.passes, self.closure) {
            (Passes::Multi, Closure::None | Closure::Backfaces) => rounding!(),
            (Passes::Multi, Closure::Cap) => concat!(caps!(), "; and ", rounding!()),
            (Passes::Single, Closure::None | Closure::Backfaces) => {
                concat!(one_darkening!(), "; and ", rounding!())
            }
            (Passes::Single, Closure::Cap) => {
                concat!(one_darkening!(), "; and ", caps!(), "; and ", rounding!())
            }
        };
        Traits { known_error, approximates: self.closure == Closure::Cap, ..Traits::default() }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        Ok(instance.blocks_light())
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let apply = match self.passes {
            Passes::Single => Apply::DarkenOnce { weight: self.weight },
            Passes::Multi => Apply::default(),
        };
        let masks = self.cast_masks(light, out)?;
        let Volumes { volumes, smooth_terminators } = self.volumes(light, out, Reach::Shadow)?;
        if volumes.is_empty() {
            return Ok(Contribution { smooth_terminators, ..masks });
        }
        let counts = match self.counter {
            CounterKind::Auto | CounterKind::Stencil8 => count_in_stencil(light, out, &volumes, apply)?,
            CounterKind::Float => count_in_float(light, out, &volumes)?,
        };
        Ok(Contribution { apply, smooth_terminators, ..masks.and(counts) })
    }
}

/// Counts in the stencil, in as many groups as it takes.
fn count_in_stencil(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    volumes: &[Volume<'_>],
    apply: Apply,
) -> Result<Contribution, ShadowError> {
    light.require(Features::DEPTH32FLOAT_STENCIL8, "counting in the stencil")?;
    let casters: Vec<Caster<'_>> = volumes.iter().map(|volume| volume.caster.clone()).collect();
    let groups = group_by_layers(light, out, &casters, apply);
    let bound = if groups.folds { MAX_COUNT } else { groups.bound };
    let buffers = upload(light, out, volumes, &groups.groups, Weights::Repeated);
    let mut first_record = 0;
    for (index, group) in groups.groups.iter().enumerate() {
        let folds: &[Fold] = match (groups.folds, index) {
            (true, 0) if light.counts_before(apply) > 0 => &[Fold::Large, Fold::Lit, Fold::Dark],
            (true, 1..) => &[Fold::Lit, Fold::Dark],
            _ => &[],
        };
        if !folds.is_empty() {
            out.pass(fold_pass(light, folds)?);
        }
        let counter = if groups.folds { Counter::InGroups } else { Counter::AllBits };
        let draws = group.iter().zip(first_record..);
        let draws = draws
            .map(|(member, record)| counting_draws(&volumes[member.caster], record, &buffers, counter))
            .collect::<Result<Vec<_>, _>>()?;
        first_record += group.len() as u32;
        out.pass(volumes_pass(light, group.len(), vec![], DepthTarget::COUNT, draws.concat()));
    }
    Ok(Contribution::counts(bound))
}

/// The pass that counts `casters` casters.
fn volumes_pass(
    light: &LightContext<'_>,
    casters: usize,
    colors: Vec<ColorTarget>,
    depth: DepthTarget,
    draws: Vec<Draw>,
) -> Pass {
    let name = &light.light().name;
    Pass {
        name: format!("volumes of {name}"),
        reason: format!("what casts between {name} and the view, casters: {casters}"),
        colors,
        depth: Some(depth),
        draws,
    }
}

/// Which casters matter.
#[derive(Clone, Copy, PartialEq)]
enum Reach {
    /// Those whose shadow may be in view.
    Shadow,
    /// All: of a light with a size, the penumbra reaches beyond the shadow from its centre.
    BeyondShadow,
}

impl Reach {
    /// Where volumes begin. Areas are added to layers where the sides are that bound them.
    fn begin(self, begin: Begin) -> Begin {
        match (self, begin) {
            (Self::BeyondShadow, Begin::AheadOfSlanted) => Begin::Behind,
            _ => begin,
        }
    }
}

/// The volumes of a light's casters.
struct Volumes<'a> {
    volumes: Vec<Volume<'a>>,
    /// The casters whose terminators are left to the shading.
    smooth_terminators: Vec<usize>,
}

impl ShadowVolumeHard {
    /// The volumes of all casters that can matter, with mode, depth test and end chosen.
    fn volumes<'a>(
        &self,
        light: &LightContext<'a>,
        out: &mut PassList<'_>,
        reach: Reach,
    ) -> Result<Volumes<'a>, ShadowError> {
        let (position, view) = (light.light().position, light.view);
        let (mut volumes, mut smooth_terminators) = (Vec::new(), Vec::new());
        let (mut left_out, mut keep_terminator) = (Vec::new(), Vec::new());
        for (index, instance) in light.casters() {
            let whole: Vec<bool> = instance.materials.iter().map(|material| material.casts_whole()).collect();
            if !whole.contains(&true) {
                continue;
            }
            if let (Reach::Shadow, Err(reason)) = (reach, light.may_shadow(&instance.world_bounds)) {
                left_out.push((instance, reason));
                continue;
            }
            let shape = self.cast_shape(light, instance)?;
            let mut half = self.half(light, instance, &shape)?;
            if self.terminator == Terminator::Smooth {
                if half != Half::Lit || !matches!(shape, CastShape::Own(_)) {
                    keep_terminator.push((instance, CASTS_OPEN));
                } else if light.has_size() {
                    // What is turned away from the light's centre is then not dark for that, and solids are to shadow it.
                    keep_terminator.push((instance, LIGHT_HAS_SIZE));
                } else if light.can_smooth_terminators() {
                    smooth_terminators.push(index);
                    half = Half::Unlit;
                } else {
                    keep_terminator.push((instance, TOO_MANY_LIGHTS));
                }
            }
            let position_bits = position.to_array().map(f64::to_bits);
            let key = hash_of((instance.pose_key, position_bits, half, self.closure, &whole));
            let facing = || CasterFacing::new(light, instance, &shape, half);
            let facing = light.cache.get_or_compute("facing", key, facing);
            if facing.cast.is_empty() {
                left_out.push((instance, "every triangle is edge-on to the light"));
                continue;
            }
            let z_fail = self.counts_from_infinity(light, instance)?;
            let perspective = view.frustum.eye.w > 0.0;
            if z_fail && !perspective {
                let clamp = Features::DEPTH_CLIP_CONTROL;
                light.require(clamp, "counting behind surfaces seen by an orthographic camera")?;
            }
            // From outside, the front of a solid hides the back that is not drawn.
            let hides_itself = half != Half::Both && matches!(shape, CastShape::Own(_));
            let single_sided = instance.materials.iter().any(|material| !material.double_sided);
            volumes.push(Volume {
                hidden_caps_count: single_sided && !hides_itself,
                falls_on_itself: falls_on_itself(light),
                begin: reach.begin(begin_of(light, half)),
                caster: Caster { index, instance, shape, key, facing },
                z_fail,
                end: self.end(light, instance)?,
                clamp_depth: z_fail && !perspective,
                directional: position.w == 0.0,
                half,
            });
        }
        note_left_out(light, out, &left_out);
        note_left_out(light, out, &keep_terminator);
        Ok(Volumes { volumes, smooth_terminators })
    }

    /// Casts the masked parts of all casters, if one of them can matter: what the light sees of them is then kept
    /// however the eye turns.
    fn cast_masks(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
    ) -> Result<Contribution, ShadowError> {
        let has_masks =
            |instance: &Instance| instance.materials.iter().any(|material| material.casts_by_texel());
        let masked: Vec<&Instance> =
            light.casters().map(|(_, instance)| instance).filter(|instance| has_masks(instance)).collect();
        let mut matter = masked.iter().filter(|instance| light.may_shadow(&instance.world_bounds).is_ok());
        let Some(first) = matter.next() else { return Ok(Contribution::default()) };
        let refusal = match (self.geometry, self.passes) {
            (GeometryMode::Closed, _) => {
                "geometry=closed, but '{}' has masked parts (accepted for it: auto, open)"
            }
            (_, Passes::Single) => {
                "passes=single, but '{}' has masked parts, which are no counts (accepted for it: multi)"
            }
            _ => return masked::cast(light, out, &masked),
        };
        Err(light.unsupported(refusal.replace("{}", &first.name)))
    }

    /// The triangles the caster casts with: its own, and those that close it where it is open.
    pub(crate) fn cast_shape<'a>(
        &self,
        light: &LightContext<'a>,
        instance: &'a Instance,
    ) -> Result<CastShape<'a>, ShadowError> {
        let mesh = &instance.mesh;
        let own = mesh.topology();
        if own.closedness().unbalanced_edges == 0 {
            return Ok(CastShape::Own(own));
        }
        match self.closure {
            Closure::None => Ok(CastShape::Own(own)),
            Closure::Backfaces => {
                Ok(CastShape::Doubled(light.cache.get_or_compute("doubled", mesh.id(), || doubled(mesh))))
            }
            Closure::Cap => {
                let result = light.cache.get_or_compute("capped", mesh.id(), || capped(mesh).map(Arc::new));
                let capped = Result::as_ref(&result).map_err(|reason| {
                    let name = &instance.name;
                    light.unsupported(format!(
                        "closure=cap on '{name}': {reason} (accepted for it: none, backfaces)"
                    ))
                })?;
                Ok(CastShape::Capped(Arc::clone(capped)))
            }
        }
    }

    /// Which of its triangles the caster casts with.
    fn half(
        &self,
        light: &LightContext<'_>,
        instance: &Instance,
        shape: &CastShape<'_>,
    ) -> Result<Half, ShadowError> {
        if self.geometry == GeometryMode::Open {
            return Ok(Half::Both);
        }
        // A sheet of faces and their reverses has no inside in which light or eye could be.
        if matches!(shape, CastShape::Doubled(_)) {
            return Ok(Half::Lit);
        }
        if instance.materials.iter().any(|material| !material.casts_whole()) {
            // What is left without the parts that have holes has a boundary.
            if self.geometry == GeometryMode::Auto {
                return Ok(Half::Both);
            }
            return Err(light.unsupported(format!(
                "geometry=closed, but parts of '{}' are masked, blended or unlit (accepted for it: auto, open)",
                instance.name
            )));
        }
        let topology = shape.topology();
        if topology.orientation(&instance.world_from_local).is_none() {
            if self.geometry == GeometryMode::Auto {
                return Ok(Half::Both);
            }
            let c = topology.closedness();
            return Err(light.unsupported(format!(
                "geometry=closed, but '{}' is no solid: {} unpaired edges, volume {:.3e} m3 (accepted for it: auto, open)",
                instance.name, c.unbalanced_edges, c.signed_volume
            )));
        }
        if shows_its_inside(instance, topology) {
            return Ok(Half::Both);
        }
        // Inside the solid, light or eye would see its walls from behind, which cast nothing in this mode.
        let local_from_world = instance.world_from_local.inverse();
        let position = light.light().position;
        if position.w > 0.0 && topology.may_enclose(local_from_world.transform_point3(position.truncate())) {
            return Ok(Half::Both);
        }
        let near = light.view.frustum.near_corners.map(|corner| local_from_world.transform_point3(corner));
        let eye = light.view.camera.world_from_view.translation;
        let near = Aabb::from_points(near.into_iter().chain([local_from_world.transform_point3(eye)]));
        let inside = topology.components().iter().any(|component| component.bounds.overlaps(&near));
        Ok(if inside { Half::Both } else { Half::Lit })
    }

    /// Whether the caster is counted by z-fail.
    fn counts_from_infinity(
        &self,
        light: &LightContext<'_>,
        instance: &Instance,
    ) -> Result<bool, ShadowError> {
        if self.depth_test == DepthTest::ZFail {
            return Ok(true);
        }
        let needed =
            near_plane_may_be_shadowed(&light.view.frustum, light.light().position, &instance.world_bounds);
        if needed && self.depth_test == DepthTest::ZPass {
            return Err(light.unsupported(format!(
                "depthTest=zpass, but the near plane may lie in the shadow of '{}' (accepted for it: auto, zfail)",
                instance.name
            )));
        }
        Ok(needed)
    }

    fn end(&self, light: &LightContext<'_>, instance: &Instance) -> Result<End, ShadowError> {
        let position = light.light().position;
        let plane = match self.extrusion {
            Extrusion::Infinite => None,
            Extrusion::Auto | Extrusion::ToBounds => end_plane(light.view, position, &instance.world_bounds),
        };
        match plane {
            Some(plane) => Ok(End::Plane(plane)),
            None if self.extrusion == Extrusion::ToBounds => Err(light.unsupported(format!(
                "extrusion=toBounds, but no plane has light and receivers before it and '{}' between \
                 (accepted for it: auto, infinite)",
                instance.name
            ))),
            None => Ok(end_beyond(light.view, position, &instance.world_bounds)),
        }
    }
}

/// Why a caster's terminator stays where its triangles turn away.
const CASTS_OPEN: &str = "terminator=smooth leaves it as it is: it does not cast as a solid (open, or light or eye within its bounds)";
const LIGHT_HAS_SIZE: &str =
    "terminator=smooth leaves it as it is: another node takes the light to have a size";
const TOO_MANY_LIGHTS: &str =
    "terminator=smooth leaves it as it is: only the first 32 lights of a scene can have smooth terminators";

/// One note for each reason, not for each caster.
pub(crate) fn note_left_out(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    left_out: &[(&Instance, &'static str)],
) {
    let mut reasons: Vec<&str> = left_out.iter().map(|(_, reason)| *reason).collect();
    reasons.sort_unstable();
    reasons.dedup();
    for reason in reasons {
        let names: Vec<&str> =
            left_out.iter().filter(|(_, r)| *r == reason).map(|(i, _)| i.name.as_str()).collect();
        let more = if names.len() > 3 { format!(" and {} more", names.len() - 3) } else { String::new() };
        let shown = names.iter().take(3).map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        out.note(format!("casters of '{}' {shown}{more}: {reason}", light.light().name));
    }
}
