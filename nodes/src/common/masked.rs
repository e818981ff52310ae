//! Alpha-masked casters, texel by texel.
//!
//! *The idea.* A volume knows triangles, not texels. So the prism behind each masked triangle is drawn once, back faces
//! only, over the receivers' depth: at every pixel whose surface lies before the prism's end, the visible point is
//! rebuilt from its depth, and the segment from it to the light is tested against the triangle itself. Where it passes,
//! the mask is looked up at the crossing, by the function by which the visible surface gets its holes, and what is
//! not a hole darkens the light's visibility. Darkening twice is darkening once: no order, no counts.
//!
//! *Why nothing leaks.* The planes through the light and the edges are computed in f64, for both triangles of an edge
//! from the same corners in the same order, and rounded: on the GPU neighbours evaluate the same number with opposite
//! signs, and zero is inside for both. The prisms are enlarged by half a pixel, so rasterisation decides nothing.
//!
//! *Self-shadows.* A point of the triangle itself is rebuilt some ulps of depth off its plane. It counts as behind the
//! triangle only if it would be so 48 ulps further away as well as nearer: within what measures call ambiguous.
//!
//! *Limits.* A target of visibility and a pass over depth for each light with masked casters; the cost is the area of
//! the prisms, each pixel with one look-up.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use glam::{DVec2, DVec3, DVec4};
use shadowgraph_engine::math::facing_sign;
use shadowgraph_engine::plan::{
    Binding, BlendState, BufferUsage, CompareFunction, Draw, DrawState, Face, Geometry, Pass, Shader,
};
use shadowgraph_engine::scene::{ImageKey, Instance, Material, TexCoord};
use shadowgraph_engine::shadow::{Channels, Features, LightPlan, ShadowError, hash_of};

use super::extrusion::End;

/// `struct MaskedTriangle` of masked_volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedTriangle {
    pub a: [f32; 3],
    pub alpha_a: f32,
    pub b: [f32; 3],
    pub alpha_b: f32,
    pub c: [f32; 3],
    pub alpha_c: f32,
    pub bc: [f32; 4],
    pub ca: [f32; 4],
    pub ab: [f32; 4],
    pub away: [f32; 3],
    pub caster: u32,
    pub uv_a: [f32; 2],
    pub uv_b: [f32; 2],
    pub uv_c: [f32; 2],
    pub pad_0: [f32; 2],
}

/// `struct MaskedCaster` of masked_volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedCaster {
    pub center: [f32; 3],
    pub alpha: f32,
    pub light: [f32; 4],
    pub end_normal: [f32; 3],
    pub end_offset: f32,
    pub end_kind: u32,
    pub end_scale: f32,
    pub cutoff: f32,
    pub reading: u32,
}

/// The head of `struct MaskedCasters` of masked_volume.wgsl, which its casters follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedView {
    pub world_x: [f32; 4],
    pub world_y: [f32; 4],
    pub world_z: [f32; 4],
}

/// Names and byte offsets of a structure's fields, and its whole size.
pub type Layout = (Vec<(&'static str, usize)>, usize);

/// Every structure of the shader as it is here: what the layout test compares.
pub fn layouts() -> [(&'static str, Layout); 3] {
    macro_rules! fields {
        ($type:ty: $($field:ident),*) => { vec![$((stringify!($field), std::mem::offset_of!($type, $field))),*] };
    }
    let triangle = fields!(MaskedTriangle: a, alpha_a, b, alpha_b, c, alpha_c, bc, ca, ab, away, caster, uv_a, uv_b, uv_c, pad_0);
    let caster = fields!(MaskedCaster: center, alpha, light, end_normal, end_offset, end_kind, end_scale, cutoff, reading);
    let mut casters = fields!(MaskedView: world_x, world_y, world_z);
    casters.push(("casters", size_of::<MaskedView>()));
    // A runtime-sized array counts as one element.
    let whole = size_of::<MaskedView>() + size_of::<MaskedCaster>();
    [
        ("MaskedTriangle", (triangle, size_of::<MaskedTriangle>())),
        ("MaskedCaster", (caster, size_of::<MaskedCaster>())),
        ("MaskedCasters", (casters, whole)),
    ]
}

/// The most triangles of one draw: their buffer stays below what every adapter can bind.
const MAX_TRIANGLES: usize = 1 << 19;
/// Vertices of one prism.
const PRISM_VERTICES: u32 = 24;

/// What is drawn together: masked triangles that wear one image.
#[derive(Default)]
struct Batch {
    image: Option<ImageKey>,
    /// The caster's number, its triangles, and what these were computed from.
    runs: Vec<(u32, Arc<Vec<MaskedTriangle>>, u64)>,
    triangles: usize,
}

/// Adds the pass that darkens what lies behind the masked triangles of `casters`, if they have any that face or turn
/// away from the light. Each caster comes with where its volumes end.
///
/// # Errors
/// Where an orthographic camera needs depth clamping that the adapter does not have.
pub fn cast(light: &mut LightPlan<'_>, casters: &[(&Instance, End)]) -> Result<(), ShadowError> {
    let mut records: Vec<MaskedCaster> = Vec::new();
    let mut batches: Vec<Batch> = Vec::new();
    for (instance, end) in casters {
        for (part, material) in instance.materials.iter().enumerate() {
            if !material.casts_by_texel() {
                continue;
            }
            let position = light.light().position;
            let worn = format!("{:?}", material.base_color_texture);
            let key = hash_of((instance.pose_key, part, worn, position.to_array().map(f64::to_bits)));
            let triangles = light
                .cache
                .get_or_compute("masked triangles", key, || triangles(instance, part, material, position));
            if triangles.is_empty() {
                continue;
            }
            let image = material.base_color_texture.map(|texture| texture.image);
            let fits = |batch: &&mut Batch| {
                batch.image == image && batch.triangles + triangles.len() <= MAX_TRIANGLES
            };
            let batch = match batches.iter_mut().find(fits) {
                Some(batch) => batch,
                None => {
                    batches.push(Batch { image, ..Batch::default() });
                    let last = batches.len() - 1;
                    &mut batches[last]
                }
            };
            batch.triangles += triangles.len();
            batch.runs.push((records.len() as u32, triangles, key));
            records.push(record(light, instance, material, *end));
        }
    }
    if !batches.is_empty() {
        let pass = pass(light, &records, &batches)?;
        light.pass(pass);
    }
    Ok(())
}

fn pass(light: &mut LightPlan<'_>, records: &[MaskedCaster], batches: &[Batch]) -> Result<Pass, ShadowError> {
    let name = light.light().name.clone();
    let orthographic = light.view.frustum.eye.w == 0.0;
    if orthographic {
        let purpose = "ends of volumes beyond what an orthographic camera sees";
        light.require(Features::DEPTH_CLIP_CONTROL, purpose)?;
    }
    let head = view(light);
    let bytes = [bytes_of(&head), cast_slice(records)].concat();
    let key = hash_of(("masked casters", &bytes));
    let (count, reason) = (records.len(), "where masked casters and the light are, as the eye sees them");
    let casters = light.buffer(
        &format!("masked casters of {name}"),
        BufferUsage::Storage,
        key,
        Arc::new(bytes),
        reason,
    );
    let depth = light.receiver_depth();
    let mut state = DrawState::new(CompareFunction::Less, vec![Some(BlendState::REPLACE)]);
    state.culled = Some(Face::Front);
    state.depth_clamp = orthographic;
    let mut draws = Vec::new();
    for batch in batches {
        let keys: Vec<(u32, u64)> = batch.runs.iter().map(|(caster, _, key)| (*caster, *key)).collect();
        let key = hash_of(("masked triangle bytes", &keys));
        let bytes = light.cache.get_or_compute("masked triangle bytes", key, || {
            let runs = batch.runs.iter();
            let numbered: Vec<MaskedTriangle> = runs
                .flat_map(|(caster, run, _)| run.iter().map(|t| MaskedTriangle { caster: *caster, ..*t }))
                .collect();
            cast_slice(&numbered).to_vec()
        });
        let reason = format!("{} triangles with holes, and how the light sees them", batch.triangles);
        let buffer_name = format!("masked triangles of {name}");
        let triangles = light.buffer(&buffer_name, BufferUsage::Storage, key, bytes, &reason);
        let mut bindings = vec![
            (0, Binding::Storage(casters)),
            (1, Binding::Storage(triangles)),
            (2, Binding::Texture(depth)),
        ];
        if let Some(image) = batch.image {
            let reason = "holes are looked up where light would pass";
            bindings.push((3, Binding::Texture(light.image(image, reason))));
        }
        draws.push(Draw {
            name: format!("{} masked triangles", batch.triangles),
            shader: Some(shader(batch.image.is_some())),
            state: state.clone(),
            geometry: Geometry::Procedural {
                vertices: batch.triangles as u32 * PRISM_VERTICES,
                instances: 1,
            },
            bindings,
            scissor_px: None,
        });
    }
    let target = light.multiply_visibility(Channels::One);
    Ok(Pass {
        name: format!("masks of {name}"),
        reason: format!(
            "{count} casters with holes between {name} and the view: asked at every pixel behind them"
        ),
        colors: vec![target],
        depth: Some(light.test_receiver_depth()),
        draws,
    })
}

fn shader(textured: bool) -> Shader {
    let flags: &[&str] = if textured { &["BASE_COLOR_TEXTURE"] } else { &[] };
    let source = shadowgraph_shaders::compose_named("masked_volume", flags).unwrap_or_default();
    let name = if textured { "masked_volume BASE_COLOR_TEXTURE" } else { "masked_volume" };
    Shader {
        name: name.into(),
        source: source.into(),
        vertex: "vertex".into(),
        fragment: Some("darken".into()),
    }
}

/// The rotation from view space to the world.
fn view(light: &LightPlan<'_>) -> MaskedView {
    let rotation = light.view.camera.world_from_view.matrix3;
    let column = |axis: DVec3| axis.extend(0.0).as_vec4().to_array();
    MaskedView {
        world_x: column(rotation.x_axis),
        world_y: column(rotation.y_axis),
        world_z: column(rotation.z_axis),
    }
}

fn record(light: &LightPlan<'_>, instance: &Instance, material: &Material, end: End) -> MaskedCaster {
    let center = instance.world_bounds.center();
    let position = light.light().position;
    let (end_kind, plane, end_scale) = match end {
        End::Infinite => (0, None, 0.0),
        End::Plane(plane) => (1, Some(plane), 0.0),
        End::Scaled(scale) => (2, None, scale as f32),
    };
    MaskedCaster {
        center: (center - light.view.camera.world_from_view.translation).as_vec3().to_array(),
        alpha: material.base_color.w,
        light: (position - (center * position.w).extend(0.0)).as_vec4().to_array(),
        end_normal: plane.map_or(DVec3::ZERO, |p| p.normal).as_vec3().to_array(),
        end_offset: plane.map_or(0.0, |p| -p.height(center) as f32),
        end_kind,
        end_scale,
        cutoff: material.cutoff().unwrap_or_default(),
        reading: material.base_color_texture.map_or(0, |texture| texture.reading_bits()),
    }
}

/// The triangles of a part that are not edge-on to the light.
fn triangles(instance: &Instance, part: usize, material: &Material, light: DVec4) -> Vec<MaskedTriangle> {
    let mesh = instance.mesh.data();
    let center = instance.world_bounds.center();
    let texture = material.base_color_texture;
    let uvs = match texture.map(|texture| texture.tex_coord) {
        Some(TexCoord::Second) => &mesh.second_uvs,
        _ => &mesh.uvs,
    };
    let rows = texture.map(|texture| texture.transform).unwrap_or_default().rows().map(|row| row.as_dvec3());
    let uv = |vertex: u32| {
        let uv = uvs.get(vertex as usize).copied().unwrap_or_default().as_dvec2().extend(1.0);
        DVec2::new(rows[0].dot(uv), rows[1].dot(uv)).as_vec2().to_array()
    };
    let alpha = |vertex: u32| f32::from(instance.mesh.color8(vertex)[3]) / 255.0;
    let of_triangle = |triangle: u32| {
        let mut vertices = instance.mesh.triangle(triangle as usize);
        let [a, b, c] = vertices.map(|vertex| instance.world_position(vertex));
        match facing_sign(a, b, c, light) {
            0 => return None,
            sign if sign < 0 => vertices.swap(1, 2),
            _ => {}
        }
        let [a, b, c] = vertices.map(|vertex| instance.world_position(vertex) - center);
        let towards = light - (center * light.w).extend(0.0);
        let away = -(b - a).cross(c - a).normalize_or_zero();
        let [uv_a, uv_b, uv_c] = vertices.map(uv);
        let [alpha_a, alpha_b, alpha_c] = vertices.map(alpha);
        let local = |p: DVec3| p.as_vec3().to_array();
        Some(MaskedTriangle {
            a: local(a),
            alpha_a,
            b: local(b),
            alpha_b,
            c: local(c),
            alpha_c,
            bc: edge_plane(b, c, towards),
            ca: edge_plane(c, a, towards),
            ab: edge_plane(a, b, towards),
            away: local(away),
            caster: 0,
            uv_a,
            uv_b,
            uv_c,
            pad_0: [0.0; 2],
        })
    };
    mesh.parts[part].triangles.clone().filter_map(of_triangle).collect()
}

/// The plane through `light` and the edge from `p` to `q`, not negative on the left of the edge as the light sees it.
/// Turning the edge round negates it exactly.
fn edge_plane(p: DVec3, q: DVec3, light: DVec4) -> [f32; 4] {
    if q.to_array() < p.to_array() {
        return edge_plane(q, p, light).map(|x| -x);
    }
    let normal = (light.truncate() - p * light.w).cross(q - p);
    normal.extend(-normal.dot(p)).as_vec4().to_array()
}
