//! Alpha-masked casters, texel by texel: at every pixel the triangles in the light's way are asked for holes (see
//! [`super::ray_candidates`]), and the first crossing that is no hole makes the pixel dark. The mask is looked up by the function
//! by which the visible surface gets its holes.
//!
//! *Limits.* A target of visibility and a pass over the picture for each light with masked casters. The cost is that of
//! the lists: it grows with how many masked triangles lie one behind the other as the light sees them.

use bytemuck::{Pod, Zeroable};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::plan::{BlendState, Shader, ShaderError};
use shadowgraph_engine::scene::{Instance, Material};
use shadowgraph_engine::shadow::{
    Channels, ColorTarget, Contribution, LightContext, Pass, PassList, ShadowError, hash_of,
};

use super::ray_candidates::{Corners, Layout, RayCandidates, Run};
use crate::layout;

/// `struct MaskedTriangle` of masked_volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedTriangle {
    pub corner: [f32; 3],
    pub alpha_a: f32,
    pub away: [f32; 3],
    pub alpha_b: f32,
    pub uv_a: [f32; 2],
    pub uv_b: [f32; 2],
    pub uv_c: [f32; 2],
    pub alpha_c: f32,
    pub pad_0: u32,
}

/// `struct MaskedCaster` of masked_volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedCaster {
    pub center: [f32; 3],
    pub alpha: f32,
    pub cutoff: f32,
    pub reading: u32,
    pub pad_0: u32,
    pub pad_1: u32,
}

/// The structures of masked_volume.wgsl as they are here: what the layout test compares.
pub fn layouts() -> [(&'static str, Layout); 2] {
    [
        (
            "MaskedTriangle",
            layout!(MaskedTriangle: corner, alpha_a, away, alpha_b, uv_a, uv_b, uv_c, alpha_c, pad_0),
        ),
        ("MaskedCaster", layout!(MaskedCaster: center, alpha, cutoff, reading, pad_0, pad_1)),
    ]
}

/// Adds the pass that darkens what lies behind the masked triangles of `casters`, if they have any that face or turn
/// away from the light.
///
/// # Errors
/// What is wrong with a shader.
pub fn cast(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    casters: &[&Instance],
) -> Result<Contribution, ShadowError> {
    let mut candidates: RayCandidates<MaskedTriangle, MaskedCaster> = RayCandidates::default();
    let position = light.light().position;
    for instance in casters {
        for (part, material) in instance.materials.iter().enumerate() {
            if !material.casts_by_texel() {
                continue;
            }
            let texture = material.base_color_texture;
            let worn = format!("{texture:?}");
            let key = hash_of((instance.pose_key, part, worn, position.to_array().map(f64::to_bits)));
            let run = light.cache.get_or_compute("masked triangles", key, || {
                Run::new(instance, part, texture.as_ref(), position, |corners| triangle(instance, &corners))
            });
            candidates.push(
                run,
                key,
                texture.map(|texture| texture.image),
                record(light, instance, material),
            );
        }
    }
    if candidates.is_empty() {
        return Ok(Contribution::default());
    }
    let bounds = casters.iter().fold(Aabb::EMPTY, |bounds, caster| bounds.union(&caster.world_bounds));
    let draws = candidates.draws((light, out), "masked triangles", &bounds, shader, BlendState::REPLACE)?;
    let name = &light.light().name;
    let count = candidates.parts();
    out.pass(Pass {
        name: format!("masks of {name}"),
        reason: format!("{count} casters with holes between {name} and the view: asked at every pixel"),
        colors: vec![ColorTarget::VISIBILITY],
        depth: None,
        draws,
    });
    Ok(Contribution::visibility(Channels::One))
}

fn shader(textured: bool) -> Result<Shader, ShaderError> {
    let flags: &[&str] = if textured { &["BASE_COLOR_TEXTURE"] } else { &[] };
    Shader::composed("masked_volume", flags, "fullscreen_vertex", Some("darken"))
}

fn record(light: &LightContext<'_>, instance: &Instance, material: &Material) -> MaskedCaster {
    let center = instance.world_bounds.center();
    MaskedCaster {
        center: (center - light.view.camera.world_from_view.translation).as_vec3().to_array(),
        alpha: material.base_color.w,
        cutoff: material.cutoff().unwrap_or_default(),
        reading: material.base_color_texture.map_or(0, |texture| texture.reading_bits()),
        pad_0: 0,
        pad_1: 0,
    }
}

fn triangle(instance: &Instance, corners: &Corners) -> MaskedTriangle {
    let alpha = |vertex: u32| f32::from(instance.mesh.color8(vertex)[3]) / 255.0;
    let [alpha_a, alpha_b, alpha_c] = corners.vertices.map(alpha);
    let [uv_a, uv_b, uv_c] = corners.uvs;
    let (corner, away) = (corners.corner, corners.away);
    MaskedTriangle { corner, alpha_a, away, alpha_b, uv_a, uv_b, uv_c, alpha_c, pad_0: 0 }
}
