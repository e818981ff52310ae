//! Alpha-masked casters, texel by texel.
//!
//! *The idea.* A volume knows triangles, not texels. So every pixel is asked: the visible point is rebuilt from its
//! depth, and the segment from it to the light is tested against the masked triangles it may pass. Which these are is
//! looked up in a grid the light looks through (see [`super::light_lists`]), that is, in lists made on the CPU and kept
//! until a caster or the light moves. Where the segment passes a triangle, the mask is looked up at the crossing, by the
//! function by which the visible surface gets its holes; the first crossing that is no hole makes the pixel dark.
//!
//! *Why nothing leaks.* The planes through the light and the edges are computed in f64, for both triangles of an edge
//! from the same corners in the same order, and rounded: on the GPU neighbours evaluate the same number with opposite
//! signs, and zero is inside for both. A point's cell is found with a bound on its rounding, and all cells within it
//! are asked. Nothing is rasterised but the whole target.
//!
//! *Self-shadows.* A point of the triangle itself is rebuilt some ulps of depth off its plane. It counts as behind the
//! triangle only if it would be so 48 ulps further away as well as nearer: within what measures call ambiguous.
//!
//! *Limits.* A target of visibility and a pass over the picture for each light with masked casters. The cost is that of
//! the lists: it grows with how many masked triangles lie one behind the other as the light sees them.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use glam::{DVec2, DVec3, DVec4};
use shadowgraph_engine::geometry::{LightGrid, LightPlane};
use shadowgraph_engine::math::{Aabb, facing_sign};
use shadowgraph_engine::plan::{
    Binding, BlendState, BufferUsage, CompareFunction, Draw, DrawState, Geometry, Pass, Shader,
};
use shadowgraph_engine::scene::{ImageKey, Instance, Material, TexCoord};
use shadowgraph_engine::shadow::{Channels, LightPlan, hash_of};

use super::light_lists::light_lists;

/// `struct MaskedCone` of masked_volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedCone {
    pub bc: [f32; 4],
    pub ca: [f32; 4],
    pub ab: [f32; 4],
    pub caster: u32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
}

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

/// `struct GridPlane` of masked_volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct GridPlane {
    pub x_axis: [f32; 3],
    pub x_length: f32,
    pub y_axis: [f32; 3],
    pub y_length: f32,
    pub z_axis: [f32; 3],
    pub z_offset: f32,
    pub away: [f32; 3],
    pub z_length: f32,
}

/// The head of `struct MaskedCasters` of masked_volume.wgsl, which its casters follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedView {
    pub world_x: [f32; 3],
    pub plane_count: u32,
    pub world_y: [f32; 3],
    pub reach_m: f32,
    pub world_z: [f32; 3],
    pub pad_0: f32,
    pub origin: [f32; 3],
    pub pad_1: f32,
    pub planes: [GridPlane; 6],
}

/// Names and byte offsets of a structure's fields, and its whole size.
pub type Layout = (Vec<(&'static str, usize)>, usize);

/// Every structure of the shader as it is here: what the layout test compares.
pub fn layouts() -> [(&'static str, Layout); 5] {
    macro_rules! fields {
        ($type:ty: $($field:ident),*) => { vec![$((stringify!($field), std::mem::offset_of!($type, $field))),*] };
    }
    let cone = fields!(MaskedCone: bc, ca, ab, caster, pad_0, pad_1, pad_2);
    let triangle = fields!(MaskedTriangle: corner, alpha_a, away, alpha_b, uv_a, uv_b, uv_c, alpha_c, pad_0);
    let caster = fields!(MaskedCaster: center, alpha, cutoff, reading, pad_0, pad_1);
    let plane = fields!(GridPlane: x_axis, x_length, y_axis, y_length, z_axis, z_offset, away, z_length);
    let mut casters =
        fields!(MaskedView: world_x, plane_count, world_y, reach_m, world_z, pad_0, origin, pad_1, planes);
    casters.push(("casters", size_of::<MaskedView>()));
    // A runtime-sized array counts as one element.
    let whole = size_of::<MaskedView>() + size_of::<MaskedCaster>();
    [
        ("MaskedCone", (cone, size_of::<MaskedCone>())),
        ("MaskedTriangle", (triangle, size_of::<MaskedTriangle>())),
        ("MaskedCaster", (caster, size_of::<MaskedCaster>())),
        ("GridPlane", (plane, size_of::<GridPlane>())),
        ("MaskedCasters", (casters, whole)),
    ]
}

/// The most triangles of one draw: their buffers stay below what every adapter can bind.
const MAX_TRIANGLES: usize = 1 << 19;

/// The masked triangles of one part of an instance, as the light sees them, number by number.
#[derive(Debug, Default)]
struct Run {
    cones: Vec<MaskedCone>,
    triangles: Vec<MaskedTriangle>,
    corners_in_world: Vec<[DVec3; 3]>,
}

/// What is drawn together: masked triangles that wear one image.
#[derive(Default)]
struct Batch {
    image: Option<ImageKey>,
    /// The caster's number, its triangles, and what these were computed from.
    runs: Vec<(u32, Arc<Run>, u64)>,
    triangles: usize,
}

/// What the shader reads of a batch.
struct BatchBytes {
    cones: Arc<Vec<u8>>,
    triangles: Arc<Vec<u8>>,
    lists: Arc<Vec<u8>>,
}

/// Adds the pass that darkens what lies behind the masked triangles of `casters`, if they have any that face or turn
/// away from the light.
pub fn cast(light: &mut LightPlan<'_>, casters: &[&Instance]) {
    let mut records: Vec<MaskedCaster> = Vec::new();
    let mut batches: Vec<Batch> = Vec::new();
    for instance in casters {
        for (part, material) in instance.materials.iter().enumerate() {
            if !material.casts_by_texel() {
                continue;
            }
            let position = light.light().position;
            let worn = format!("{:?}", material.base_color_texture);
            let key = hash_of((instance.pose_key, part, worn, position.to_array().map(f64::to_bits)));
            let run = light
                .cache
                .get_or_compute("masked triangles", key, || run(instance, part, material, position));
            if run.cones.is_empty() {
                continue;
            }
            let image = material.base_color_texture.map(|texture| texture.image);
            let count = run.cones.len();
            let fits = |batch: &&mut Batch| batch.image == image && batch.triangles + count <= MAX_TRIANGLES;
            let batch = match batches.iter_mut().find(fits) {
                Some(batch) => batch,
                None => {
                    batches.push(Batch { image, ..Batch::default() });
                    let last = batches.len() - 1;
                    &mut batches[last]
                }
            };
            batch.triangles += count;
            batch.runs.push((records.len() as u32, run, key));
            records.push(record(light, instance, material));
        }
    }
    if !batches.is_empty() {
        let bounds = casters.iter().fold(Aabb::EMPTY, |bounds, caster| bounds.union(&caster.world_bounds));
        let pass = pass(light, &records, &batches, &bounds);
        light.pass(pass);
    }
}

fn pass(light: &mut LightPlan<'_>, records: &[MaskedCaster], batches: &[Batch], bounds: &Aabb) -> Pass {
    let (name, position) = (light.light().name.clone(), light.light().position);
    let grid = LightGrid::new(position, bounds);
    let head = view(light, grid.planes(), bounds);
    let bytes = [bytes_of(&head), cast_slice(records)].concat();
    let key = hash_of(("masked casters", &bytes));
    let (count, reason) = (records.len(), "where masked casters and the light are, as the eye sees them");
    let buffer_name = format!("masked casters of {name}");
    let casters = light.buffer(&buffer_name, BufferUsage::Storage, key, Arc::new(bytes), reason);
    let depth = light.receiver_depth();
    let mut draws = Vec::new();
    for batch in batches {
        let (bytes, key) = batch_bytes(light, batch, &grid, bounds);
        let mut storage = |what: &str, bytes: &Arc<Vec<u8>>, reason: &str| {
            let key = hash_of((what, key));
            let name = format!("{what} of {name}");
            Binding::Storage(light.buffer(&name, BufferUsage::Storage, key, Arc::clone(bytes), reason))
        };
        let reason = format!("what {} triangles with holes hide from the light", batch.triangles);
        let mut bindings = vec![
            (0, Binding::Storage(casters)),
            (1, storage("masked cones", &bytes.cones, &reason)),
            (2, storage("masked triangles", &bytes.triangles, "where these have holes")),
            (3, storage("light lists", &bytes.lists, "which of these a ray to the light may meet")),
            (4, Binding::Texture(depth)),
        ];
        if let Some(image) = batch.image {
            let reason = "holes are looked up where light would pass";
            bindings.push((5, Binding::Texture(light.image(image, reason))));
        }
        draws.push(Draw {
            name: format!("{} masked triangles", batch.triangles),
            shader: Some(shader(batch.image.is_some())),
            state: DrawState::new(CompareFunction::Always, vec![Some(BlendState::REPLACE)]),
            geometry: Geometry::Procedural { vertices: 3, instances: 1 },
            bindings,
            scissor_px: None,
        });
    }
    let target = light.multiply_visibility(Channels::One);
    Pass {
        name: format!("masks of {name}"),
        reason: format!("{count} casters with holes between {name} and the view: asked at every pixel"),
        colors: vec![target],
        depth: None,
        draws,
    }
}

/// The bytes of a batch, and a hash of what they were computed from.
fn batch_bytes(
    light: &mut LightPlan<'_>,
    batch: &Batch,
    grid: &LightGrid,
    bounds: &Aabb,
) -> (Arc<BatchBytes>, u64) {
    let keys: Vec<(u32, u64)> = batch.runs.iter().map(|(caster, _, key)| (*caster, *key)).collect();
    // The light is part of each run's key.
    let bounds_bits = [bounds.min, bounds.max].map(|corner| corner.to_array().map(f64::to_bits));
    let key = hash_of((&keys, bounds_bits));
    let bytes = light.cache.get_or_compute("masked batch", key, || {
        let runs = || batch.runs.iter();
        let cones: Vec<MaskedCone> = runs()
            .flat_map(|(caster, run, _)| run.cones.iter().map(|cone| MaskedCone { caster: *caster, ..*cone }))
            .collect();
        let triangles: Vec<MaskedTriangle> = runs().flat_map(|(_, run, _)| run.triangles.clone()).collect();
        let corners: Vec<[DVec3; 3]> = runs().flat_map(|(_, run, _)| run.corners_in_world.clone()).collect();
        let bytes = |bytes: &[u8]| Arc::new(bytes.to_vec());
        BatchBytes {
            cones: bytes(cast_slice(&cones)),
            triangles: bytes(cast_slice(&triangles)),
            lists: bytes(cast_slice(&light_lists(grid, &corners))),
        }
    });
    (bytes, key)
}

fn shader(textured: bool) -> Shader {
    let flags: &[&str] = if textured { &["BASE_COLOR_TEXTURE"] } else { &[] };
    let source = shadowgraph_shaders::compose_named("masked_volume", flags).unwrap_or_default();
    let name = if textured { "masked_volume BASE_COLOR_TEXTURE" } else { "masked_volume" };
    Shader {
        name: name.into(),
        source: source.into(),
        vertex: "fullscreen_vertex".into(),
        fragment: Some("darken".into()),
    }
}

/// Where the eye is, and the planes the light looks through, to casters within `bounds`.
fn view(light: &LightPlan<'_>, planes: &[LightPlane], bounds: &Aabb) -> MaskedView {
    let world_from_view = light.view.camera.world_from_view;
    let rotation = world_from_view.matrix3;
    let short = |v: DVec3| v.as_vec3().to_array();
    let origin = planes[0].origin - world_from_view.translation;
    let to_casters_m = (bounds.center() - world_from_view.translation).length() + bounds.radius();
    let mut grid_planes = [GridPlane::default(); 6];
    for (place, plane) in grid_planes.iter_mut().zip(planes) {
        *place = GridPlane {
            x_axis: short(plane.x_axis),
            x_length: (plane.x_axis.length() + plane.z_axis.length()) as f32,
            y_axis: short(plane.y_axis),
            y_length: (plane.y_axis.length() + plane.z_axis.length()) as f32,
            z_axis: short(plane.z_axis),
            z_offset: plane.z_offset as f32,
            away: short(plane.away),
            z_length: plane.z_axis.length() as f32,
        };
    }
    MaskedView {
        world_x: short(rotation.x_axis),
        plane_count: planes.len() as u32,
        world_y: short(rotation.y_axis),
        reach_m: (origin.length() + to_casters_m) as f32,
        world_z: short(rotation.z_axis),
        pad_0: 0.0,
        origin: short(origin),
        pad_1: 0.0,
        planes: grid_planes,
    }
}

fn record(light: &LightPlan<'_>, instance: &Instance, material: &Material) -> MaskedCaster {
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

/// The triangles of a part that are not edge-on to the light.
fn run(instance: &Instance, part: usize, material: &Material, light: DVec4) -> Run {
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
    let towards = light - (center * light.w).extend(0.0);
    let mut run = Run::default();
    for triangle in mesh.parts[part].triangles.clone() {
        let mut vertices = instance.mesh.triangle(triangle as usize);
        let [a, b, c] = vertices.map(|vertex| instance.world_position(vertex));
        match facing_sign(a, b, c, light) {
            0 => continue,
            sign if sign < 0 => vertices.swap(1, 2),
            _ => {}
        }
        let in_world = vertices.map(|vertex| instance.world_position(vertex));
        let [a, b, c] = in_world.map(|corner| corner - center);
        let away = -(b - a).cross(c - a).normalize_or_zero();
        let [uv_a, uv_b, uv_c] = vertices.map(uv);
        let [alpha_a, alpha_b, alpha_c] = vertices.map(alpha);
        run.cones.push(MaskedCone {
            bc: edge_plane(b, c, towards),
            ca: edge_plane(c, a, towards),
            ab: edge_plane(a, b, towards),
            ..MaskedCone::default()
        });
        run.triangles.push(MaskedTriangle {
            corner: a.as_vec3().to_array(),
            alpha_a,
            away: away.as_vec3().to_array(),
            alpha_b,
            uv_a,
            uv_b,
            uv_c,
            alpha_c,
            pad_0: 0,
        });
        run.corners_in_world.push(in_world);
    }
    run
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
