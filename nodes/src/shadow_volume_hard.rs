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
//! This file is longer than most so that the technique reads top to bottom.
//!
//! *Limits.* Alpha-masked casters are refused; blended ones cast through coloured techniques. Rasterisation snaps
//! vertices to 1/256 pixel, so pixels whose centre is that near a shadow edge may fall to either side. A light nearer to
//! a caster than about 10⁻⁵ of its size, but not touching it, sees edges span half circles: single pixels go wrong.

use std::sync::Arc;

use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::plan::{
    Binding, BufferUsage, CompareFunction, DepthTarget, Draw, DrawState, Geometry, Pass, Shader, SlotId,
    Stencil, StencilFaceState, StencilOperation,
};
use shadowgraph_engine::scene::{Instance, ParamValue, Params, ShadowNode};
use shadowgraph_engine::shadow::{
    Features, LightPlan, OptionError, OptionReader, Requirements, Setting, ShadowError, ShadowTechnique,
    TechniqueEntry, hash_of,
};

use crate::common::culling::{may_shadow, near_plane_may_be_shadowed};
use crate::common::extrusion::{End, end_plane, scaled_end};
use crate::common::layer_groups::{Caster, MAX_COUNT, Member, group_by_layers};
use crate::common::volume::{CasterFacing, VolumeIndices, VolumeUniform};

/// From where crossings are counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DepthTest {
    /// z-pass where the near plane is certainly unshadowed by the caster, z-fail elsewhere.
    #[default]
    Auto,
    /// From the near plane to the surface; refused where the near plane may be in shadow.
    ZPass,
    /// From the surface to infinity; always right, and needs caps.
    ZFail,
}

/// Which triangles cast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GeometryMode {
    /// Closed where the caster is a solid with light and eye outside, open elsewhere.
    #[default]
    Auto,
    /// Only triangles that face the light outwards; refused for casters that are no solids.
    Closed,
    /// All triangles.
    Open,
}

/// Where volumes end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extrusion {
    /// On a plane behind all receivers where that is exact, else at infinity.
    #[default]
    Auto,
    /// At infinity.
    Infinite,
    /// On a plane behind all receivers; refused where that is not exact.
    ToBounds,
}

/// The node and its options.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowVolumeHard {
    /// From where crossings are counted.
    pub depth_test: DepthTest,
    /// Which triangles cast.
    pub geometry: GeometryMode,
    /// Where volumes end.
    pub extrusion: Extrusion,
}

const TYPE_NAME: &str = "ShadowVolumeHard";
const DEPTH_TESTS: &[(&str, DepthTest)] =
    &[("auto", DepthTest::Auto), ("zpass", DepthTest::ZPass), ("zfail", DepthTest::ZFail)];
const GEOMETRIES: &[(&str, GeometryMode)] =
    &[("auto", GeometryMode::Auto), ("closed", GeometryMode::Closed), ("open", GeometryMode::Open)];
const EXTRUSIONS: &[(&str, Extrusion)] =
    &[("auto", Extrusion::Auto), ("infinite", Extrusion::Infinite), ("toBounds", Extrusion::ToBounds)];

impl ShadowVolumeHard {
    /// How the catalog knows it.
    pub const ENTRY: TechniqueEntry = TechniqueEntry {
        type_name: TYPE_NAME,
        short_name: "hard",
        summary: "exact hard shadows of any triangles, counted in the stencil",
        from_params: |params| Ok(Arc::new(Self::from_params(params)?)),
        settings: &[
            Setting {
                name: "z-pass",
                why: "counting from the near plane, which needs no caps",
                params: || Self { depth_test: DepthTest::ZPass, ..Self::default() }.params(),
            },
            Setting {
                name: "z-fail",
                why: "counting from infinity, which is right wherever the eye is",
                params: || Self { depth_test: DepthTest::ZFail, ..Self::default() }.params(),
            },
            Setting {
                name: "open",
                why: "every triangle casts, closed casters too",
                params: || Self { geometry: GeometryMode::Open, ..Self::default() }.params(),
            },
            Setting {
                name: "infinite",
                why: "sides to infinity, where the default ends them behind what receives",
                params: || Self { extrusion: Extrusion::Infinite, ..Self::default() }.params(),
            },
        ],
    };

    /// Reads the options.
    ///
    /// # Errors
    /// [`OptionError`] names the option and what is accepted.
    pub fn from_params(params: &Params) -> Result<Self, OptionError> {
        let mut options = OptionReader::new(TYPE_NAME, params);
        let node = Self {
            depth_test: options.choice("depthTest", DEPTH_TESTS)?,
            geometry: options.choice("geometry", GEOMETRIES)?,
            extrusion: options.choice("extrusion", EXTRUSIONS)?,
        };
        // Options whose other values are not there yet accept their default, and say so.
        options.choice("closure", &[("none", ())])?;
        options.choice("passes", &[("multi", ())])?;
        options.choice("counter", &[("auto", ()), ("stencil8", ())])?;
        options.choice("terminator", &[("geometric", ())])?;
        options.finish()?;
        Ok(node)
    }
}

fn name_of<T: PartialEq>(values: &[(&'static str, T)], value: &T) -> ParamValue {
    let name = values.iter().find(|(_, v)| v == value).map_or("", |(name, _)| name);
    ParamValue::Text(name.into())
}

impl From<ShadowVolumeHard> for ShadowNode {
    fn from(node: ShadowVolumeHard) -> Self {
        Self { technique: TYPE_NAME.into(), params: node.params(), ..Self::default() }
    }
}

impl ShadowTechnique for ShadowVolumeHard {
    fn type_name(&self) -> &'static str {
        TYPE_NAME
    }

    fn params(&self) -> Params {
        Params::from([
            ("depthTest".into(), name_of(DEPTH_TESTS, &self.depth_test)),
            ("geometry".into(), name_of(GEOMETRIES, &self.geometry)),
            ("extrusion".into(), name_of(EXTRUSIONS, &self.extrusion)),
        ])
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
                    let volume = &volumes[member.caster];
                    let record = first_record + place as u32;
                    volume_draws(
                        volume,
                        &buffers.indices[first_record as usize + place],
                        record,
                        &buffers,
                        counter,
                    )
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
        let (posed_light, view) = (light.light(), light.view);
        let position = posed_light.position;
        let mut volumes = Vec::new();
        let mut left_out = Vec::new();
        for (index, instance) in light.casters() {
            if let Err(reason) = may_shadow(view, posed_light, &instance.world_bounds) {
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

/// The buffers of one light's volumes.
struct Buffers {
    index_slot: SlotId,
    records: SlotId,
    /// For each record: where its indices begin, and their runs.
    indices: Vec<(u32, Arc<VolumeIndices>)>,
    shader: Shader,
}

fn upload(light: &mut LightPlan<'_>, volumes: &[Volume<'_>], groups: &[Vec<Member>]) -> Buffers {
    let mut keys = Vec::new();
    let mut indices = Vec::new();
    let mut records: Vec<VolumeUniform> = Vec::new();
    let mut first = 0;
    for member in groups.iter().flatten() {
        let Volume { caster: Caster { index, instance, key, facing }, end, .. } = &volumes[member.caster];
        let key = hash_of((key, &member.triangles));
        let runs = light.cache.get_or_compute("volume indices", key, || {
            VolumeIndices::new(instance, facing, member.triangles.as_ref().unwrap_or(&facing.cast))
        });
        records.push(VolumeUniform::new(instance, *index, light.light().position, *end));
        keys.push(key);
        let count = runs.indices.len() as u32;
        indices.push((first, runs));
        first += count;
    }
    let name = light.light().name.clone();
    let key = hash_of(("volume indices", &keys));
    let bytes = light.cache.get_or_compute("volume index bytes", key, || {
        indices
            .iter()
            .flat_map(|(_, runs)| bytemuck::cast_slice::<u32, u8>(&runs.indices))
            .copied()
            .collect::<Vec<u8>>()
    });
    let edges: usize = indices.iter().map(|(_, runs)| runs.silhouette_edges).sum();
    let reason = format!("{edges} silhouette edges, and the caps for views that need them");
    let index_slot =
        light.buffer(&format!("volume indices of {name}"), BufferUsage::Index, key, bytes, &reason);
    let bytes: &[u8] = bytemuck::cast_slice(&records);
    let key = hash_of(("volumes", bytes));
    let records = light.buffer(
        &format!("volumes of {name}"),
        BufferUsage::Storage,
        key,
        Arc::new(bytes.to_vec()),
        "where the light is, as each caster sees it, and where its volume ends",
    );
    Buffers { index_slot, records, indices, shader: volume_shader("vertex") }
}

fn volume_shader(vertex: &'static str) -> Shader {
    let source = shadowgraph_shaders::compose_named("shadow_volume_hard", &[]).unwrap_or_default();
    Shader { name: "shadow_volume_hard".into(), source: source.into(), vertex: vertex.into(), fragment: None }
}

/// Which bits of the stencil count.
#[derive(Clone, Copy, PartialEq)]
enum Counter {
    AllBits,
    BesideStickyBit,
}

/// The draws of one volume: the runs its depth test and end demand, neighbours joined.
fn volume_draws(
    volume: &Volume<'_>,
    (first, runs): &(u32, Arc<VolumeIndices>),
    record: u32,
    buffers: &Buffers,
    counter: Counter,
) -> Vec<Draw> {
    let meets_at_infinity = volume.directional && volume.end == End::Infinite;
    let mut wanted = vec![(&runs.sides_near, false)];
    if !meets_at_infinity {
        wanted.push((&runs.sides_far, false));
    }
    if volume.z_fail {
        if !meets_at_infinity {
            wanted.push((&runs.far_caps, false));
        }
        wanted.push((&runs.front_caps, false));
        wanted.push((&runs.front_caps_turned, true));
    }
    let mut joined: Vec<(u32, u32, bool)> = Vec::new();
    for (run, turned) in wanted {
        match joined.last_mut() {
            Some((_, end, last_turned)) if *end == run.start && *last_turned == turned => *end = run.end,
            _ => joined.push((run.start, run.end, turned)),
        }
    }
    joined.retain(|(start, end, _)| start < end);
    joined
        .into_iter()
        .map(|(start, end, turned)| {
            let mut state = DrawState::new(CompareFunction::Greater, vec![]);
            state.depth_clamp = volume.clamp_depth;
            state.stencil = Some(count(volume.z_fail, turned, counter));
            Draw {
                name: volume.name(),
                shader: Some(buffers.shader.clone()),
                state,
                geometry: Geometry::Indexed {
                    instance: volume.caster.index as u32,
                    indices: buffers.index_slot,
                    first: first + start,
                    count: end - start,
                    record,
                },
                bindings: vec![(1, Binding::Storage(buffers.records))],
                scissor_px: None,
            }
        })
        .collect()
}

/// z-pass: a front face before the surface enters a volume, +1; a back face leaves it, −1. z-fail, counting behind
/// the surface: a back face still to be left, +1; a front face still to be entered, −1. `turned` triangles are wound
/// against the chain.
fn count(z_fail: bool, turned: bool, counter: Counter) -> Stencil {
    use StencilOperation::{DecrementWrap, IncrementWrap, Keep};
    let (front, back) =
        if z_fail == turned { (IncrementWrap, DecrementWrap) } else { (DecrementWrap, IncrementWrap) };
    let face = |op| StencilFaceState {
        compare: CompareFunction::Always,
        fail_op: Keep,
        depth_fail_op: if z_fail { op } else { Keep },
        pass_op: if z_fail { Keep } else { op },
    };
    let write_mask = if counter == Counter::AllBits { 0xff } else { 0x7f };
    Stencil { front: face(front), back: face(back), read_mask: 0xff, write_mask, reference: 0 }
}

/// Wherever bits 0 to 6 are not all zero: bit 7 alone.
fn fold_pass(light: &LightPlan<'_>, depth: &DepthTarget) -> Pass {
    let face = StencilFaceState {
        compare: CompareFunction::NotEqual,
        fail_op: StencilOperation::Keep,
        depth_fail_op: StencilOperation::Keep,
        pass_op: StencilOperation::Replace,
    };
    let mut state = DrawState::new(CompareFunction::Always, vec![]);
    state.stencil =
        Some(Stencil { front: face, back: face, read_mask: 0x7f, write_mask: 0xff, reference: 0x80 });
    Pass {
        name: format!("fold counts of {}", light.light().name),
        reason:
            "more layers than the stencil can count at once: dark stays dark while the counter starts again"
                .into(),
        colors: vec![],
        depth: Some(depth.clone()),
        draws: vec![Draw {
            name: "fold".into(),
            shader: Some(volume_shader("fullscreen_vertex")),
            state,
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings: vec![],
            scissor_px: None,
        }],
    }
}
