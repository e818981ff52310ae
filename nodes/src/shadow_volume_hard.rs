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
//! - Front caps have the very depth of the visible surface (same vertices, same order, same function), and equal
//!   depth counts as "not in front": no bias anywhere.
//! - Vertices are extruded along vertex − light computed in two-float precision, so that a light may touch a caster.
//! - Sides end on one plane behind everything that can receive, where that is exact.
//! - Counts of any size stay exact in the 8-bit stencil: see [`crate::common::layer_groups`].
//!
//! This file says what is chosen and why; `options` how it is asked for, `draws` how it is drawn.
//!
//! *Limits.* Alpha-masked casters are refused; blended ones cast through coloured techniques. Rasterisation snaps
//! vertices to 1/256 pixel, so pixels whose centre is that near a shadow edge may fall to either side. A light nearer to
//! a caster than about 10⁻⁵ of its size, but not touching it, sees edges span half circles: single pixels go wrong.

mod draws;
mod options;

use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::plan::Pass;
use shadowgraph_engine::scene::{Instance, Params};
use shadowgraph_engine::shadow::{Features, LightPlan, Requirements, ShadowError, ShadowTechnique, hash_of};

use crate::common::culling::near_plane_may_be_shadowed;
use crate::common::extrusion::{End, end_plane, scaled_end};
use crate::common::layer_groups::{Caster, MAX_COUNT, group_by_layers};
use crate::common::volume::CasterFacing;
use draws::{Counter, fold_pass, upload, volume_draws};
use options::TYPE_NAME;
pub use options::{DepthTest, Extrusion, GeometryMode, ShadowVolumeHard};

impl ShadowTechnique for ShadowVolumeHard {
    fn type_name(&self) -> &'static str {
        TYPE_NAME
    }

    fn params(&self) -> Params {
        self.to_params()
    }

    fn known_error(&self) -> &'static str {
        "rasterisation: pixels whose centre is within 1/256 pixel of a shadow edge; and lights nearer to a caster than \
         1e-5 of its size without touching it"
    }

    fn requirements(&self) -> Requirements {
        Requirements { required: Features::DEPTH32FLOAT_STENCIL8, optional: Features::DEPTH_CLIP_CONTROL }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        if !instance.is_opaque() {
            return Ok(false);
        }
        if instance.is_masked() {
            return Err("alpha-masked surfaces would cast as if they had no holes".into());
        }
        Ok(true)
    }

    fn plan(&self, light: &mut LightPlan<'_>) -> Result<(), ShadowError> {
        let volumes = self.volumes(light)?;
        if volumes.is_empty() {
            return Ok(());
        }
        let casters: Vec<Caster<'_>> = volumes.iter().map(|volume| volume.caster.clone()).collect();
        let groups = group_by_layers(light, &casters);
        let bound = if groups.folds { MAX_COUNT } else { groups.bound };
        let (depth, before) = light.count_in_stencil(bound);
        let buffers = upload(light, &volumes, &groups.groups);
        let mut first_record = 0;
        for (index, group) in groups.groups.iter().enumerate() {
            if groups.folds && (index > 0 || before > 0) {
                light.pass(fold_pass(light, &depth));
            }
            let counter = if groups.folds { Counter::BesideStickyBit } else { Counter::AllBits };
            let draws = group
                .iter()
                .enumerate()
                .flat_map(|(place, member)| {
                    volume_draws(&volumes[member.caster], first_record + place as u32, &buffers, counter)
                })
                .collect();
            first_record += group.len() as u32;
            light.pass(Pass {
                name: format!("volumes of {}", light.light().name),
                reason: format!(
                    "what casts between {} and the view, casters: {}",
                    light.light().name,
                    group.len()
                ),
                colors: vec![],
                depth: Some(depth.clone()),
                draws,
            });
        }
        Ok(())
    }
}

/// One caster's volume, with everything the view decides about it.
struct Volume<'a> {
    caster: Caster<'a>,
    z_fail: bool,
    end: End,
    clamp_depth: bool,
    directional: bool,
    closed: bool,
}

impl Volume<'_> {
    /// The caster's name and what was chosen for it.
    fn name(&self) -> String {
        let mode = if self.closed { "closed" } else { "open" };
        let depth_test = if self.z_fail { "z-fail" } else { "z-pass" };
        let end = match self.end {
            End::Infinite => "to infinity",
            End::Plane(_) => "to a plane",
            End::Scaled(_) => "beyond the view",
        };
        format!("{} {mode} {depth_test} {end}", self.caster.instance.name)
    }
}

impl ShadowVolumeHard {
    /// The volumes of all casters that can matter, with mode, depth test and end chosen.
    fn volumes<'a>(&self, light: &mut LightPlan<'a>) -> Result<Vec<Volume<'a>>, ShadowError> {
        let (position, view) = (light.light().position, light.view);
        let mut volumes = Vec::new();
        let mut left_out = Vec::new();
        for (index, instance) in light.casters() {
            if let Err(reason) = light.may_shadow(&instance.world_bounds) {
                left_out.push((instance, reason));
                continue;
            }
            let closed = self.casts_closed(light, instance)?;
            let key = hash_of((instance.pose_key, position.to_array().map(f64::to_bits), closed));
            let facing =
                light.cache.get_or_compute("facing", key, || CasterFacing::new(instance, position, closed));
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
            volumes.push(Volume {
                caster: Caster { index, instance, key, facing },
                z_fail,
                end: self.end(light, instance)?,
                clamp_depth: z_fail && !perspective,
                directional: position.w == 0.0,
                closed,
            });
        }
        note_left_out(light, &left_out);
        Ok(volumes)
    }

    /// Whether the caster casts with its light-facing half only.
    fn casts_closed(&self, light: &LightPlan<'_>, instance: &Instance) -> Result<bool, ShadowError> {
        if self.geometry == GeometryMode::Open {
            return Ok(false);
        }
        let topology = instance.mesh.topology();
        if topology.orientation(&instance.world_from_local).is_none() {
            if self.geometry == GeometryMode::Auto {
                return Ok(false);
            }
            let c = topology.closedness();
            return Err(light.unsupported(format!(
                "geometry=closed, but '{}' is no solid: {} unpaired edges, volume {:.3e} m3 (accepted for it: auto, open)",
                instance.name, c.unbalanced_edges, c.signed_volume
            )));
        }
        // Inside the solid, light or eye would see its walls from behind, which cast nothing in this mode.
        let local_from_world = instance.world_from_local.inverse();
        let position = light.light().position;
        if position.w > 0.0 && topology.may_enclose(local_from_world.transform_point3(position.truncate())) {
            return Ok(false);
        }
        let near = light.view.frustum.near_corners.map(|corner| local_from_world.transform_point3(corner));
        let eye = light.view.camera.world_from_view.translation;
        let near = Aabb::from_points(near.into_iter().chain([local_from_world.transform_point3(eye)]));
        Ok(!topology.components().iter().any(|component| component.bounds.overlaps(&near)))
    }

    /// Whether the caster is counted by z-fail.
    fn counts_from_infinity(&self, light: &LightPlan<'_>, instance: &Instance) -> Result<bool, ShadowError> {
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

    fn end(&self, light: &LightPlan<'_>, instance: &Instance) -> Result<End, ShadowError> {
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
            None if light.view.frustum.eye.w == 0.0 => {
                Ok(End::Scaled(scaled_end(light.view, position, &instance.world_bounds)))
            }
            None => Ok(End::Infinite),
        }
    }
}

/// One note for each reason, not for each caster.
fn note_left_out(light: &mut LightPlan<'_>, left_out: &[(&Instance, &'static str)]) {
    let mut reasons: Vec<&str> = left_out.iter().map(|(_, reason)| *reason).collect();
    reasons.sort_unstable();
    reasons.dedup();
    for reason in reasons {
        let names: Vec<&str> =
            left_out.iter().filter(|(_, r)| *r == reason).map(|(i, _)| i.name.as_str()).collect();
        let more = if names.len() > 3 { format!(" and {} more", names.len() - 3) } else { String::new() };
        let shown = names.iter().take(3).map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
        light.note(format!("casters of '{}' {shown}{more}: {reason}", light.light().name));
    }
}
