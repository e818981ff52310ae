//! `DiscShadow`: hard shadows of flat round discs, computed and not rasterised.
//!
//! *The idea.* Whether a disc hides a light from a point is one intersection: that of the segment between them with the
//! disc's plane. So one draw over the whole picture rebuilds the visible point of every pixel from the depth buffer and
//! asks every disc. No silhouettes, no stencil; the cost is pixels × discs, whatever the tessellation.
//!
//! *What it shows.* Nothing here is known to the engine. The technique reads its options, says what casts, and writes
//! its passes into the plan; it multiplies a visibility target, so that it shares a light with techniques that count in
//! the stencil.
//!
//! *Limits.* Casters are discs and nothing else: other meshes are refused with the reason. Receivers closer to a disc
//! than depth can tell (8 millionths of their distance to the eye) count as part of it and are not shadowed by it. The
//! mesh is taken for the circle through its rim: straight edges of n segments lie up to π²/2n² of a radius inside it.

use std::mem::offset_of;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use shadowgraph::technique::*;

use super::disc::{Disc, NoDisc};

/// The shader as it is written; its imports are the engine's.
pub(crate) const SHADER: &str = include_str!("disc_shadow.wgsl");

/// The node and its options: what a scene may say of them, and what they are when it does not, is all declared here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub(crate) struct DiscShadow {
    /// How wide the rim fades from dark to lit, measured in the disc's plane, in metres; 0 for a hard rim.
    #[serde(rename = "edge")]
    #[schemars(range(min = 0.0, max = 1e6))]
    pub(crate) edge_m: f64,
}

impl Options for DiscShadow {
    const TYPE_NAME: &'static str = "DiscShadow";
}

impl DiscShadow {
    /// How the catalog knows it.
    pub(crate) const ENTRY: TechniqueEntry = TechniqueEntry::of::<Self>(
        "disc",
        "shadows of flat round discs, computed at every pixel",
        &[Setting {
            name: "soft rim",
            why: "a rim that fades over 5 cm, which no point light has",
            params: || Self { edge_m: 0.05 }.to_params(),
        }],
    );
}

/// The light of `struct Casters`, which its discs follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct LightRecord {
    light: [f32; 4],
}

/// `struct Disc` of disc_shadow.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct DiscRecord {
    center: [f32; 3],
    radius_m: f32,
    normal: [f32; 3],
    edge_m: f32,
}

/// The shader's structures as they are here: name, the byte offset of every field, and the whole size.
#[allow(dead_code, reason = "for the test that compares them with the shader's")]
pub(crate) fn layouts() -> [(&'static str, shadowgraph::engine::gpu::Layout); 2] {
    let disc = vec![
        ("center", offset_of!(DiscRecord, center)),
        ("radius_m", offset_of!(DiscRecord, radius_m)),
        ("normal", offset_of!(DiscRecord, normal)),
        ("edge_m", offset_of!(DiscRecord, edge_m)),
    ];
    let casters = vec![("light", offset_of!(LightRecord, light)), ("discs", size_of::<LightRecord>())];
    // A runtime-sized array counts as one element.
    let whole = size_of::<LightRecord>() + size_of::<DiscRecord>();
    [("Disc", (disc, size_of::<DiscRecord>())), ("Casters", (casters, whole))]
}

impl ShadowTechnique for DiscShadow {
    fn params(&self) -> Params {
        self.to_params()
    }

    fn traits(&self) -> Traits {
        let known_error = "the receiver is rebuilt from f32 depth and the rim is a circle: pixels within one pixel of the shadow's edge, \
         and receivers closer to a disc than 8 millionths of their distance to the eye, may be wrong";
        Traits { known_error, ..Traits::default() }
    }

    fn casts(&self, instance: &Instance) -> Result<bool, String> {
        if !instance.is_opaque() {
            return Ok(false);
        }
        if instance.is_masked() {
            return Err("alpha-masked surfaces would cast as if they had no holes".into());
        }
        Disc::of(instance).map(|_| true).map_err(|reason| reason.to_string())
    }

    fn plan(&self, light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Contribution, ShadowError> {
        let records = self.records(light, out)?;
        // A light that no disc can matter for keeps its factor, and the frame its bytes.
        if records.is_empty() {
            return Ok(Contribution::default());
        }
        let name = light.light().name.clone();
        let count = records.len();
        let contents = contents(light, &records);
        let casters = out.buffer(BufferDesc::storage(
            &format!("discs of {name}"),
            hash_of((Self::TYPE_NAME, &contents)),
            Arc::new(contents),
            "the light and its discs, as the eye sees them",
        ));
        let shader = Shader::written(Self::TYPE_NAME, SHADER, &[], "fullscreen_vertex", Some("visibility"))?;
        let state = DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)]);
        let discs = Draw::new("discs", Geometry::fullscreen(shader), state);
        let bindings = vec![(0, Binding::Storage(casters)), (1, Binding::Texture(out.receiver_depth()))];
        out.pass(Pass {
            name: format!("discs of {name}"),
            reason: format!("{count} discs between {name} and what is in view, asked at every pixel"),
            colors: vec![ColorTarget::VISIBILITY],
            depth: None,
            draws: vec![discs.reading(bindings)],
        });
        Ok(Contribution::visibility(Channels::One))
    }
}

impl DiscShadow {
    /// The discs that can matter, in view space. Computed in f64 and rounded once, since f32 world coordinates would
    /// cost precision far from the world's origin.
    fn records(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
    ) -> Result<Vec<DiscRecord>, ShadowError> {
        let view_from_world = light.view.camera.world_from_view.inverse();
        let mut records = Vec::new();
        for (_, instance) in light.casters() {
            let reach = instance.world_bounds.expanded(0.5 * self.edge_m);
            if let Err(reason) = light.may_shadow(&reach) {
                out.note(format!("disc '{}' for '{}': {reason}", instance.name, light.light().name));
                continue;
            }
            let disc: Arc<Result<Disc, NoDisc>> =
                light.cache.get_or_compute("disc", instance.pose_key, || Disc::of(instance));
            let Disc { center, normal, radius_m } = disc
                .as_ref()
                .clone()
                .map_err(|no| light.unsupported(format!("'{}': {no}", instance.name)))?;
            records.push(DiscRecord {
                center: view_from_world.transform_point3(center).as_vec3().into(),
                radius_m: radius_m as f32,
                normal: view_from_world.transform_vector3(normal).as_vec3().into(),
                edge_m: self.edge_m as f32,
            });
        }
        Ok(records)
    }
}

/// The bytes of `Casters` in disc_shadow.wgsl.
fn contents(light: &LightContext<'_>, records: &[DiscRecord]) -> Vec<u8> {
    let view_from_world = light.view.camera.world_from_view.inverse();
    let position = light.light().position;
    let in_view = view_from_world.matrix3 * position.truncate() + view_from_world.translation * position.w;
    let head = LightRecord { light: in_view.extend(position.w).as_vec4().into() };
    [bytemuck::bytes_of(&head), bytemuck::cast_slice(records)].concat()
}
