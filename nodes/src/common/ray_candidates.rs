//! Triangles that are asked at every pixel whether they are in the light's way, and what lets some of it pass.
//!
//! *The idea.* A volume knows triangles, not texels. So every pixel is asked: the visible point is rebuilt from its
//! depth, and the segment from it to the light is tested against the triangles it may pass. Which these are is looked up
//! in a grid the light looks through (see [`super::light_grid_lists`]), that is, in lists made on the CPU and kept until a
//! caster or the light moves. What a crossing means is for the technique's own shader to say.
//!
//! *Why nothing leaks.* The planes through the light and the edges are computed in f64, for both triangles of an edge
//! from the same corners in the same order, and rounded: on the GPU neighbours evaluate the same number with opposite
//! signs. A shader takes zero to be inside for both, or only for the one that *owns* the edge. A point's cell is found
//! with a bound on its rounding, and all cells within it are asked.
//!
//! *Self-shadows.* A point of the triangle itself is rebuilt some ulps of depth off its plane. It counts as behind the
//! triangle only if it would be so 48 ulps further away as well as nearer: within what measures call ambiguous.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use glam::{DVec3, DVec4};
use shadowgraph_engine::geometry::{LightGrid, LightPlane};
use shadowgraph_engine::math::{Aabb, facing_sign};
use shadowgraph_engine::plan::{BlendState, BufferDesc, CompareFunction, DrawState, Shader, ShaderError};
use shadowgraph_engine::scene::{ImageKey, Instance, TextureRef};
use shadowgraph_engine::shadow::{Binding, Draw, Geometry, LightContext, PassList, ShadowError, hash_of};

use super::light_grid_lists::light_grid_lists;
use super::mask_vertices::MaskVertices;

/// `struct ListedCone` of common/light_grid_lists.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct ListedCone {
    pub bc: [f32; 4],
    pub ca: [f32; 4],
    pub ab: [f32; 4],
    pub caster: u32,
    pub owned_edges: u32,
    pub pad_0: u32,
    pub pad_1: u32,
}

/// `struct GridPlane` of common/light_grid_lists.wgsl.
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

/// `struct ListView` of common/light_grid_lists.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub struct ListView {
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

/// The named fields of a structure with their byte offsets, and its whole size.
#[macro_export]
#[doc(hidden)]
macro_rules! layout {
    ($type:ty: $($field:ident),*) => {
        (vec![$((stringify!($field), std::mem::offset_of!($type, $field))),*], size_of::<$type>())
    };
}

/// The structures of common/light_grid_lists.wgsl as they are here: what the layout test compares.
pub fn layouts() -> [(&'static str, Layout); 3] {
    [
        ("ListedCone", layout!(ListedCone: bc, ca, ab, caster, owned_edges, pad_0, pad_1)),
        (
            "GridPlane",
            layout!(GridPlane: x_axis, x_length, y_axis, y_length, z_axis, z_offset, away, z_length),
        ),
        (
            "ListView",
            layout!(ListView: world_x, plane_count, world_y, reach_m, world_z, pad_0, origin, pad_1, planes),
        ),
    ]
}

/// The most triangles of one draw: their buffers stay below what every adapter can bind.
const MAX_TRIANGLES: usize = 1 << 19;

/// A triangle as the light sees it: counter-clockwise.
pub struct Corners {
    /// The first corner, relative to the middle of the caster's bounds.
    pub corner: [f32; 3],
    /// The unit normal on the side turned away from the light.
    pub away: [f32; 3],
    /// Transformed texture coordinates.
    pub uvs: [[f32; 2]; 3],
    /// The mesh's vertices.
    pub vertices: [u32; 3],
}

/// The triangles of one part of an instance, as the light sees them, number by number; `T` is what the technique's
/// shader knows of one.
#[derive(Debug)]
pub struct Run<T> {
    cones: Vec<ListedCone>,
    triangles: Vec<T>,
    corners_in_world: Vec<[DVec3; 3]>,
}

impl<T> Run<T> {
    /// The triangles of a part that are not edge-on to the light.
    pub fn new(
        instance: &Instance,
        part: usize,
        texture: Option<&TextureRef>,
        light: DVec4,
        make: impl Fn(Corners) -> T,
    ) -> Self {
        let center = instance.world_bounds.center();
        let worn = MaskVertices::new(instance, texture);
        let uv = |vertex: u32| worn.uv(vertex).as_vec2().to_array();
        let towards = light - (center * light.w).extend(0.0);
        let mut run = Self { cones: vec![], triangles: vec![], corners_in_world: vec![] };
        for triangle in instance.mesh.data().parts[part].triangles.clone() {
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
            let edges = [(b, c), (c, a), (a, b)];
            let owned = edges.into_iter().zip(0..).map(|((p, q), bit)| u32::from(!is_turned(p, q)) << bit);
            let [bc, ca, ab] = edges.map(|(p, q)| edge_plane(p, q, towards));
            run.cones.push(ListedCone { bc, ca, ab, owned_edges: owned.sum(), ..ListedCone::default() });
            run.triangles.push(make(Corners {
                corner: a.as_vec3().to_array(),
                away: away.as_vec3().to_array(),
                uvs: vertices.map(uv),
                vertices,
            }));
            run.corners_in_world.push(in_world);
        }
        run
    }
}

/// Whether the edge from p to q runs against the order in which its plane is computed.
fn is_turned(p: DVec3, q: DVec3) -> bool {
    q.to_array() < p.to_array()
}

/// The plane through `light` and the edge from `p` to `q`, not negative on the left of the edge as the light sees it.
/// Turning the edge round negates it exactly.
fn edge_plane(p: DVec3, q: DVec3, light: DVec4) -> [f32; 4] {
    if is_turned(p, q) {
        return edge_plane(q, p, light).map(|x| -x);
    }
    let normal = (light.truncate() - p * light.w).cross(q - p);
    normal.extend(-normal.dot(p)).as_vec4().to_array()
}

/// What is drawn together: triangles that wear one image.
struct Batch<T> {
    image: Option<ImageKey>,
    /// The caster's number, its triangles, and what these were computed from.
    runs: Vec<(u32, Arc<Run<T>>, u64)>,
    triangles: usize,
}

/// All triangles that may block the rays of one light; `T` is what the technique's shader knows of a triangle, `C` of
/// a caster.
pub struct RayCandidates<T, C> {
    batches: Vec<Batch<T>>,
    casters: Vec<C>,
}

impl<T, C> Default for RayCandidates<T, C> {
    fn default() -> Self {
        Self { batches: vec![], casters: vec![] }
    }
}

impl<T: Pod + Send + Sync, C: Pod> RayCandidates<T, C> {
    /// Adds a part; `key` is a hash of what its run was computed from. Parts without triangles are left out.
    pub fn push(&mut self, run: Arc<Run<T>>, key: u64, image: Option<ImageKey>, caster: C) {
        let count = run.cones.len();
        if count == 0 {
            return;
        }
        let fits = |batch: &Batch<T>| batch.image == image && batch.triangles + count <= MAX_TRIANGLES;
        let place = self.batches.iter().position(fits).unwrap_or(self.batches.len());
        if place == self.batches.len() {
            self.batches.push(Batch { image, runs: vec![], triangles: 0 });
        }
        self.batches[place].triangles += count;
        self.batches[place].runs.push((self.casters.len() as u32, run, key));
        self.casters.push(caster);
    }

    /// Whether there are no triangles to test.
    pub fn is_empty(&self) -> bool {
        self.batches.is_empty()
    }

    /// How many parts there are.
    pub fn parts(&self) -> usize {
        self.casters.len()
    }

    /// The draws that test the triangles at every pixel, one for each image; `bounds` is the box around all casters.
    /// `what` names the triangles in the plan's text, `shader` is the one for triangles with a texture, or without.
    ///
    /// # Errors
    /// What is wrong with a shader.
    pub fn draws(
        &self,
        (light, out): (&LightContext<'_>, &mut PassList<'_>),
        what: &'static str,
        bounds: &Aabb,
        shader: impl Fn(bool) -> Result<Shader, ShaderError>,
        blend: BlendState,
    ) -> Result<Vec<Draw>, ShadowError> {
        let (name, position) = (light.light().name.clone(), light.light().position);
        let grid = LightGrid::new(position, bounds);
        let view = view(light, grid.planes(), bounds);
        let mut storage = |name: &str, key: u64, bytes: Arc<Vec<u8>>, reason: &str| {
            Binding::Storage(out.buffer(BufferDesc::storage(name, key, bytes, reason)))
        };
        let buffer_of = |bytes: &[u8]| (hash_of((what, bytes)), Arc::new(bytes.to_vec()));
        let (key, bytes) = buffer_of(bytes_of(&view));
        let reason = "where the light's grid is, as the eye sees it";
        let view = storage(&format!("grid of {what} of {name}"), key, bytes, reason);
        let (key, bytes) = buffer_of(cast_slice(&self.casters));
        let reason = format!("where {what} are, as the eye sees them");
        let casters = storage(&format!("{what} casters of {name}"), key, bytes, &reason);
        let mut draws = Vec::new();
        for batch in &self.batches {
            let (bytes, key) = batch_bytes(light, batch, what, &grid, bounds);
            let mut part = |part: &str, bytes: &Arc<Vec<u8>>, reason: &str| {
                let name = format!("{part} of {what} of {name}");
                let (key, contents) = (hash_of((part, key)), Arc::clone(bytes));
                Binding::Storage(out.buffer(BufferDesc::storage(&name, key, contents, reason)))
            };
            let reason = format!("what {} {what} hide from the light", batch.triangles);
            let mut bindings = vec![
                (0, view),
                (1, part("cones", &bytes.cones, &reason)),
                (2, part("corners", &bytes.triangles, "where these are, and what they wear")),
                (3, part("lists", &bytes.lists, "which of these a ray to the light may meet")),
                (4, Binding::Texture(out.receiver_depth())),
                (6, casters),
            ];
            if let Some(image) = batch.image {
                let reason = "looked up where light would pass";
                bindings.push((5, Binding::Texture(out.image(image, reason))));
            }
            let geometry = Geometry::fullscreen(shader(batch.image.is_some())?);
            let state = DrawState::new(CompareFunction::Always, vec![Some(blend)]);
            draws.push(Draw::new(format!("{} {what}", batch.triangles), geometry, state).reading(bindings));
        }
        Ok(draws)
    }
}

/// What the shader reads of a batch.
struct BatchBytes {
    cones: Arc<Vec<u8>>,
    triangles: Arc<Vec<u8>>,
    lists: Arc<Vec<u8>>,
}

/// The bytes of a batch, and a hash of what they were computed from.
fn batch_bytes<T: Pod>(
    light: &LightContext<'_>,
    batch: &Batch<T>,
    what: &'static str,
    grid: &LightGrid,
    bounds: &Aabb,
) -> (Arc<BatchBytes>, u64) {
    let keys: Vec<(u32, u64)> = batch.runs.iter().map(|(caster, _, key)| (*caster, *key)).collect();
    // The light is part of each run's key.
    let bounds_bits = [bounds.min, bounds.max].map(|corner| corner.to_array().map(f64::to_bits));
    let key = hash_of((what, &keys, bounds_bits));
    let bytes = light.cache.get_or_compute("listed batch", key, || {
        let runs = || batch.runs.iter();
        let cones: Vec<ListedCone> = runs()
            .flat_map(|(caster, run, _)| run.cones.iter().map(|cone| ListedCone { caster: *caster, ..*cone }))
            .collect();
        let triangles: Vec<T> = runs().flat_map(|(_, run, _)| run.triangles.iter().copied()).collect();
        let corners: Vec<[DVec3; 3]> = runs().flat_map(|(_, run, _)| run.corners_in_world.clone()).collect();
        let bytes = |bytes: &[u8]| Arc::new(bytes.to_vec());
        BatchBytes {
            cones: bytes(cast_slice(&cones)),
            triangles: bytes(cast_slice(&triangles)),
            lists: bytes(cast_slice(&light_grid_lists(grid, &corners))),
        }
    });
    (bytes, key)
}

/// Where the eye is, and the planes the light looks through, to casters within `bounds`.
fn view(light: &LightContext<'_>, planes: &[LightPlane], bounds: &Aabb) -> ListView {
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
    ListView {
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
