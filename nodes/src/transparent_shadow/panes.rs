//! Transparent parts that are not evenly tinted, textured or with vertex colours, point by point: at every pixel the
//! triangles in the light's way are asked what they let pass where it crosses them (see [`crate::common::ray_candidates`]).
//!
//! A line through an edge of two triangles crosses one of them, and a triangle that several cells of the grid list counts
//! once. What passes is computed for each crossing in 32-bit floats; the visibility is multiplied by the product.

use bytemuck::{Pod, Zeroable};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::plan::{MULTIPLY, Shader, ShaderError};
use shadowgraph_engine::scene::{Instance, Material};
use shadowgraph_engine::shadow::{
    Channels, ColorTarget, Contribution, LightContext, Pass, PassList, ShadowError, hash_of,
};

use crate::common::mask_vertices::alpha_mode_of;
use crate::common::ray_candidates::{Corners, Layout, RayCandidates, Run};
use crate::layout;

/// `struct PaneTriangle` of transparent_panes.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
struct PaneTriangle {
    corner: [f32; 3],
    color_a: u32,
    away: [f32; 3],
    color_b: u32,
    uv_a: [f32; 2],
    uv_b: [f32; 2],
    uv_c: [f32; 2],
    color_c: u32,
    pad_0: u32,
}

/// `struct PaneCaster` of transparent_panes.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
struct PaneCaster {
    center: [f32; 3],
    alpha_mode: u32,
    base_color: [f32; 4],
    cutoff: f32,
    transmission: f32,
    reading: u32,
    pad_0: u32,
}

/// The structures of transparent_panes.wgsl as they are here: what the layout test compares.
pub(super) fn layouts() -> [(&'static str, Layout); 2] {
    [
        (
            "PaneTriangle",
            layout!(PaneTriangle: corner, color_a, away, color_b, uv_a, uv_b, uv_c, color_c, pad_0),
        ),
        (
            "PaneCaster",
            layout!(PaneCaster: center, alpha_mode, base_color, cutoff, transmission, reading, pad_0),
        ),
    ]
}

/// Adds the pass that tints what lies behind these (instance, part).
pub(super) fn cast(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    parts: &[(&Instance, usize)],
) -> Result<Contribution, ShadowError> {
    let mut candidates: RayCandidates<PaneTriangle, PaneCaster> = RayCandidates::default();
    let position = light.light().position;
    for &(instance, part) in parts {
        let material = &instance.materials[part];
        let texture = material.base_color_texture;
        let worn = format!("{texture:?}");
        let key = hash_of((instance.pose_key, part, worn, position.to_array().map(f64::to_bits)));
        let run = light.cache.get_or_compute("pane triangles", key, || {
            Run::new(instance, part, texture.as_ref(), position, |corners| triangle(instance, &corners))
        });
        candidates.push(run, key, texture.map(|texture| texture.image), record(light, instance, material));
    }
    if candidates.is_empty() {
        return Ok(Contribution::default());
    }
    let bounds = parts.iter().fold(Aabb::EMPTY, |bounds, (caster, _)| bounds.union(&caster.world_bounds));
    let draws = candidates.draws((light, out), "tinted triangles", &bounds, shader, MULTIPLY)?;
    let name = &light.light().name;
    let count = candidates.parts();
    out.pass(Pass {
        name: format!("panes of {name}"),
        reason: format!("{count} casters of many colours between {name} and the view: asked at every pixel"),
        colors: vec![ColorTarget::VISIBILITY],
        depth: None,
        draws,
    });
    Ok(Contribution::visibility(Channels::Rgb))
}

fn shader(textured: bool) -> Result<Shader, ShaderError> {
    let flags: &[&str] = if textured { &["BASE_COLOR_TEXTURE"] } else { &[] };
    Shader::composed("transparent_panes", flags, "fullscreen_vertex", Some("tint"))
}

fn record(light: &LightContext<'_>, instance: &Instance, material: &Material) -> PaneCaster {
    let center = instance.world_bounds.center();
    let (alpha_mode, cutoff) = alpha_mode_of(material);
    PaneCaster {
        center: (center - light.view.camera.world_from_view.translation).as_vec3().to_array(),
        alpha_mode,
        base_color: material.base_color.to_array(),
        cutoff,
        transmission: material.transmission,
        reading: material.base_color_texture.map_or(0, |texture| texture.reading_bits()),
        pad_0: 0,
    }
}

fn triangle(instance: &Instance, corners: &Corners) -> PaneTriangle {
    let color = |vertex: u32| u32::from_le_bytes(instance.mesh.color8(vertex));
    let [color_a, color_b, color_c] = corners.vertices.map(color);
    let [uv_a, uv_b, uv_c] = corners.uvs;
    let (corner, away) = (corners.corner, corners.away);
    PaneTriangle { corner, color_a, away, color_b, uv_a, uv_b, uv_c, color_c, pad_0: 0 }
}
