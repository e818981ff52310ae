//! What casts onto a plane: the part of every caster on the plane's lit side, as the shader reads it.
//!
//! Triangles in the plane or under it cast nothing on it, and of those that cross it only the part above does; both are
//! decided in f64 on the CPU, and kept until caster or plane move. What reaches beyond the light is left to the
//! clipping of the projected triangle: there its w is negative (see [`clip_from_caster`]).

use std::collections::HashMap;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable, cast_slice};
use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4};
use shadowgraph_engine::math::{Aabb, Plane, facing_sign};
use shadowgraph_engine::plan::{BufferDesc, Resource};
use shadowgraph_engine::scene::{ImageKey, Instance, Material, TexCoord};
use shadowgraph_engine::shadow::{LightContext, PassList, hash_of};

use super::points::LightPoints;
use super::receivers::{Flat, Receiver, height_of};

/// A corner of a triangle without holes: from its caster's middle, and the caster's number.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
struct Corner {
    position: [f32; 3],
    caster: u32,
}

/// `struct MaskedCorner` of soft_shadow.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct MaskedCorner {
    pub position: [f32; 3],
    pub caster: u32,
    pub uv: [f32; 2],
    pub alpha: f32,
    pub cutoff: f32,
    pub reading: u32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
}

/// A vertex, or a point on an edge where it was cut.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    p_in_world: DVec3,
    uv: DVec2,
    alpha: f64,
}

/// One material's triangles of one caster, above a plane.
#[derive(Debug, Default)]
struct AbovePlane {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
}

/// Triangles that one draw flattens.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    /// Whether they have holes.
    pub(super) masked: bool,
    /// What the holes are looked up in.
    pub(super) image: Option<Resource>,
    /// Their corners.
    pub(super) corners: Resource,
    /// Their corners' numbers.
    pub(super) indices: Resource,
    /// For each point of the light: where its indices begin, and how many there are.
    pub(super) runs: Vec<(u32, u32)>,
}

/// What casts onto one receiver.
#[derive(Clone, Debug, Default)]
pub(super) struct Casters {
    /// The middle of each, from which its corners are counted.
    pub(super) centers: Vec<DVec3>,
    /// The box around each.
    pub(super) bounds: Vec<Aabb>,
    /// Their triangles.
    pub(super) batches: Vec<Batch>,
    /// A hash of all of them: equal keys, equal shadows.
    pub(super) key: u64,
}

/// What a batch is made of.
struct BatchBytes {
    corners: Arc<Vec<u8>>,
    indices: Arc<Vec<u8>>,
    runs: Vec<(u32, u32)>,
}

impl Casters {
    /// The casters that may shadow something of `receiver`; where it is in view only, if `in_picture`.
    pub(super) fn of(
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        receiver: &Receiver,
        points: &LightPoints,
        in_picture: bool,
    ) -> Self {
        let mut casters = Self::default();
        let mut runs: Vec<(bool, Option<ImageKey>, Vec<Run>)> = Vec::new();
        let plane_bits = receiver.flat.plane.normal.extend(receiver.flat.plane.offset).to_array();
        let plane_bits = (plane_bits.map(f64::to_bits), receiver.flat.tolerance_m.to_bits());
        let mut left_out = Vec::new();
        for (_, instance) in light.casters() {
            if let Err(reason) = may_shadow(light, receiver, (points, in_picture), &instance.world_bounds) {
                left_out.push((instance, reason));
                continue;
            }
            let mut casts = false;
            for (part, material) in instance.materials.iter().enumerate() {
                if !material.casts_whole() && !material.casts_by_texel() {
                    continue;
                }
                let texture = material.base_color_texture.filter(|_| material.casts_by_texel());
                let reading = texture.map(|texture| {
                    let rows = texture.transform.rows().map(|row| row.to_array().map(f32::to_bits));
                    (texture.tex_coord == TexCoord::Second, rows)
                });
                let key = hash_of((instance.pose_key, part, plane_bits, reading));
                let flat = receiver.flat;
                let above =
                    light.cache.get_or_compute("above plane", key, || AbovePlane::new(instance, part, &flat));
                if above.indices.is_empty() {
                    continue;
                }
                casts = true;
                let masked = material.casts_by_texel();
                let image = material.base_color_texture.map(|texture| texture.image).filter(|_| masked);
                let run = Run {
                    caster: casters.centers.len() as u32,
                    above,
                    key,
                    material: Arc::clone(material),
                    center: instance.world_bounds.center(),
                    bounds: instance.world_bounds.expanded(1e-9 * instance.world_bounds.radius()),
                };
                match runs.iter_mut().find(|(m, i, _)| (*m, *i) == (masked, image)) {
                    Some((_, _, runs)) => runs.push(run),
                    None => runs.push((masked, image, vec![run])),
                }
            }
            if casts {
                casters.centers.push(instance.world_bounds.center());
                casters.bounds.push(instance.world_bounds);
            } else {
                left_out.push((instance, "lies in the plane or under it"));
            }
        }
        for (instance, reason) in left_out {
            out.note(format!(
                "'{}' on '{}' for '{}': {reason}",
                instance.name,
                receiver.name,
                light.light().name
            ));
        }
        let mut keys = Vec::new();
        for (masked, image, runs) in runs {
            let (batch, key) = upload(light, out, receiver, points, (masked, image), &runs);
            casters.batches.push(batch);
            // An image that was changed is another one.
            let image = image.and_then(|image| light.snapshot.images.get(&image));
            keys.push((key, image.map(|image| Arc::as_ptr(image) as usize)));
        }
        casters.key = hash_of(keys);
        casters
    }
}

/// One part of a caster in a batch.
struct Run {
    caster: u32,
    above: Arc<AbovePlane>,
    key: u64,
    material: Arc<Material>,
    center: DVec3,
    bounds: Aabb,
}

/// Puts the corners of several casters into one buffer, and their indices into another.
fn upload(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    receiver: &Receiver,
    points: &LightPoints,
    (masked, image): (bool, Option<ImageKey>),
    runs: &[Run],
) -> (Batch, u64) {
    let material_bits = |material: &Material| {
        let reading = material.base_color_texture.map_or(0, |texture| texture.reading_bits());
        (material.base_color.w.to_bits(), material.cutoff().unwrap_or_default().to_bits(), reading)
    };
    let keys: Vec<_> = runs.iter().map(|run| (run.caster, run.key, material_bits(&run.material))).collect();
    // Only a point within a caster's bounds may lie on one of its triangles.
    let near: Vec<usize> = (0..points.positions.len())
        .filter(|number| {
            let point = points.positions[*number];
            point.w > 0.0 && runs.iter().any(|run| run.bounds.contains(point.truncate()))
        })
        .collect();
    let near_bits: Vec<_> =
        near.iter().map(|number| (number, points.positions[*number].to_array().map(f64::to_bits))).collect();
    let key = hash_of(("flattened", masked, image, keys, points.positions.len(), near_bits));
    let bytes: Arc<BatchBytes> = light.cache.get_or_compute("flattened", key, || {
        let (mut corners, mut indices) = (Vec::new(), Vec::new());
        let mut first = 0;
        for run in runs {
            let Run { above, material, caster, center, .. } = run;
            let (_, _, reading) = material_bits(material);
            for vertex in &above.vertices {
                let position = (vertex.p_in_world - *center).as_vec3().to_array();
                if masked {
                    corners.extend_from_slice(bytemuck::bytes_of(&MaskedCorner {
                        position,
                        caster: *caster,
                        uv: vertex.uv.as_vec2().to_array(),
                        alpha: material.base_color.w * vertex.alpha as f32,
                        cutoff: material.cutoff().unwrap_or_default(),
                        reading,
                        ..MaskedCorner::default()
                    }));
                } else {
                    corners.extend_from_slice(bytemuck::bytes_of(&Corner { position, caster: *caster }));
                }
            }
            indices.extend(above.indices.iter().map(|index| first + index));
            first += above.vertices.len() as u32;
        }
        let mut of_points = vec![(0, indices.len() as u32); points.positions.len()];
        for number in &near {
            let first = indices.len() as u32;
            indices.extend(runs_seen(runs, points.positions[*number]));
            of_points[*number] = (first, indices.len() as u32 - first);
        }
        let indices = Arc::new(cast_slice(&indices).to_vec());
        BatchBytes { corners: Arc::new(corners), indices, runs: of_points }
    });
    let BatchBytes { corners, indices, runs } = &*bytes;
    let triangles = runs.iter().map(|(_, count)| count / 3).max().unwrap_or_default();
    let name = &receiver.name;
    let what = if masked { "masked casters" } else { "casters" };
    let reason = format!("{triangles} triangles above '{name}'");
    let image = image.map(|image| out.image(image, "holes are looked up where light would pass"));
    let batch = Batch {
        masked,
        image,
        corners: out.buffer(BufferDesc::storage(
            &format!("{what} over {name}"),
            hash_of((key, "corners")),
            Arc::clone(corners),
            &reason,
        )),
        indices: out.buffer(BufferDesc::index(
            &format!("triangles of {what} over {name}"),
            hash_of((key, "indices")),
            Arc::clone(indices),
            &reason,
        )),
        runs: runs.clone(),
    };
    (batch, key)
}

/// The indices of triangles that `point` does not see edge-on. The shadow of the others is a line; but a corner in
/// which the point itself lies has none, and where it would be drawn is rounding.
fn runs_seen(runs: &[Run], point: DVec4) -> Vec<u32> {
    let mut seen = Vec::new();
    let mut first = 0;
    for Run { above, .. } in runs {
        for triangle in above.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| above.vertices[triangle[i] as usize].p_in_world);
            if facing_sign(a, b, c, point) != 0 {
                seen.extend(triangle.iter().map(|index| first + index));
            }
        }
        first += above.vertices.len() as u32;
    }
    seen
}

impl AbovePlane {
    /// The triangles of a part, cut where they cross the plane.
    fn new(instance: &Instance, part: usize, flat: &Flat) -> Self {
        let mesh = instance.mesh.data();
        let texture = instance.materials[part].base_color_texture;
        let uvs = match texture.map(|texture| texture.tex_coord) {
            Some(TexCoord::Second) => &mesh.second_uvs,
            _ => &mesh.uvs,
        };
        let rows =
            texture.map(|texture| texture.transform).unwrap_or_default().rows().map(|row| row.as_dvec3());
        let vertex = |vertex: u32| {
            let uv = uvs.get(vertex as usize).copied().unwrap_or_default().as_dvec2().extend(1.0);
            Vertex {
                p_in_world: instance.world_position(vertex),
                uv: DVec2::new(rows[0].dot(uv), rows[1].dot(uv)),
                alpha: f64::from(instance.mesh.color8(vertex)[3]) / 255.0,
            }
        };
        let mut above = Self::default();
        let mut known: HashMap<(u32, u32), u32> = HashMap::new();
        for triangle in mesh.parts[part].triangles.clone() {
            let corners = instance.mesh.triangle(triangle as usize);
            let heights = corners.map(|corner| flat.plane.height(instance.world_position(corner)));
            if heights.iter().all(|height| *height <= flat.tolerance_m) {
                continue;
            }
            let mut outline = Vec::with_capacity(4);
            for i in 0..3 {
                let (from, to) = (i, (i + 1) % 3);
                if heights[from] >= 0.0 {
                    let key = (corners[from], corners[from]);
                    outline.push(above.place(&mut known, key, || vertex(corners[from])));
                }
                if heights[from] * heights[to] < 0.0 {
                    // In one order for both triangles of an edge.
                    let (a, b) = if corners[from] < corners[to] { (from, to) } else { (to, from) };
                    let share = heights[a] / (heights[a] - heights[b]);
                    outline.push(above.place(&mut known, (corners[a], corners[b]), || {
                        let (a, b) = (vertex(corners[a]), vertex(corners[b]));
                        Vertex {
                            p_in_world: a.p_in_world.lerp(b.p_in_world, share),
                            uv: a.uv.lerp(b.uv, share),
                            alpha: a.alpha + (b.alpha - a.alpha) * share,
                        }
                    }));
                }
            }
            above.indices.extend((2..outline.len()).flat_map(|i| [outline[0], outline[i - 1], outline[i]]));
        }
        above
    }

    /// The number of a vertex, made if it is new.
    fn place(
        &mut self,
        known: &mut HashMap<(u32, u32), u32>,
        key: (u32, u32),
        vertex: impl FnOnce() -> Vertex,
    ) -> u32 {
        *known.entry(key).or_insert_with(|| {
            self.vertices.push(vertex());
            self.vertices.len() as u32 - 1
        })
    }
}

/// Whether a caster within `bounds` may shadow something of `receiver` in view from some point of the light.
///
/// # Errors
/// The reason why it cannot.
fn may_shadow(
    light: &LightContext<'_>,
    receiver: &Receiver,
    (points, in_picture): (&LightPoints, bool),
    bounds: &Aabb,
) -> Result<(), &'static str> {
    let Flat { plane, tolerance_m } = receiver.flat;
    let corners = bounds.corners();
    if corners.iter().all(|corner| plane.height(*corner) <= tolerance_m) {
        return Err("lies in the plane or under it");
    }
    let above = || points.positions.iter().filter(|point| height_of(&plane, **point) > 0.0);
    if above()
        .all(|point| point.w > 0.0 && corners.iter().all(|c| plane.height(*c) >= height_of(&plane, *point)))
    {
        return Err("lies beyond the light");
    }
    // What it shadows is within range and cone of the centre, and it lies between that and the light.
    if !light.light().may_reach(&bounds.expanded(points.radius_m)) {
        return Err("outside the light's range or cone");
    }
    // What it shadows and the light span a hull, which it must meet: see the engine's own test for lights without size.
    let separates = |plane: &Plane| {
        above().all(|point| height_of(plane, *point) >= 0.0) && corners.iter().all(|c| plane.height(*c) < 0.0)
    };
    if in_picture && light.view.frustum.planes.iter().any(separates) {
        return Err("its shadow misses the view");
    }
    let mut sides = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| {
        let low = Plane { normal: axis, offset: axis.dot(receiver.bounds.min) };
        [low, Plane { normal: -axis, offset: -axis.dot(receiver.bounds.max) }]
    });
    if sides.any(|side| separates(&side)) {
        return Err("its shadow misses the receiver");
    }
    Ok(())
}

/// From a place relative to `center`, along the axes of the world, onto the plane as `light` sees it there, and from
/// there to clip space.
///
/// M = (π·L)·I − L·πᵀ maps a point to where its shadow falls; divided by π·L, the light's height, w is 1 − h/h_L. It is
/// negative for what is farther from the plane than the light. Such shadows are no shadows, and never drawn: z in clip
/// space is a positive multiple of that w (of the eye's distance for orthographic cameras, where w is the same sign as
/// that distance's weight), so z ≥ 0 clips them.
pub(super) fn clip_from_caster(
    clip_from_view: &DMat4,
    view_from_world: &DAffine3,
    (plane, light): (&Plane, DVec4),
    center: DVec3,
) -> DMat4 {
    // In view space, where the eye is the origin: nothing is lost where the picture needs it.
    let normal = view_from_world.transform_vector3(plane.normal);
    let offset = plane.offset - plane.normal.dot(view_from_world.inverse().translation);
    let plane_in_view = normal.extend(-offset);
    let light_in_view = if light.w == 0.0 {
        view_from_world.transform_vector3(light.truncate()).extend(0.0)
    } else {
        view_from_world.transform_point3(light.truncate()).extend(1.0)
    };
    let light_in_view = light_in_view / plane_in_view.dot(light_in_view);
    let flatten = DMat4::from_cols(
        DVec4::X - light_in_view * plane_in_view.x,
        DVec4::Y - light_in_view * plane_in_view.y,
        DVec4::Z - light_in_view * plane_in_view.z,
        DVec4::W - light_in_view * plane_in_view.w,
    );
    *clip_from_view * flatten * DMat4::from(*view_from_world) * DMat4::from_translation(center)
}
