//! What all qualities gather for a light: its casters' chains, lists over them, and the buffers the shaders read.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use glam::DVec3;
use shadowgraph_engine::math::{Aabb, Projection};
use shadowgraph_engine::plan::BufferDesc;
use shadowgraph_engine::scene::{ImageKey, Instance, Material};
use shadowgraph_engine::shadow::{Binding, LightContext, PassList, ShadowError, hash_of};

use super::chain::{CasterChain, LightBall};
use super::chains::{Chains, SoftCluster};
use super::lists::SoftGrid;
use super::masks::masks_key;
use super::packed::packed;
use super::slices::{LARGEST_DISC, MAX_SLICES, eye_distance};
use super::stretched::Stretched;
use super::{Quality, ShadowVolumeSoft};
use crate::GeometryMode;
use crate::common::culling::shows_its_inside;
use crate::common::ray_candidates::{GridPlane, Layout};
use crate::common::volume::{CastShape, Half};
use crate::shadow_volume_hard::note_left_out;

/// `struct SoftHead` of soft_light.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub(super) struct SoftHead {
    pub world_x: [f32; 3],
    pub plane_count: u32,
    pub world_y: [f32; 3],
    pub side: u32,
    pub world_z: [f32; 3],
    pub slice_count: u32,
    pub light: [f32; 4],
    pub origin: [f32; 3],
    pub radius: f32,
    pub near_clusters: u32,
    pub cluster_count: u32,
    pub triangle_side: u32,
    pub triangle_lists: u32,
    pub near_lists: u32,
    pub masked_lists: u32,
    pub masked_side: u32,
    pub first_masked: u32,
    pub end_masked: u32,
    pub pad_0: u32,
    pub pad_1: u32,
    pub pad_2: u32,
    pub slice_ends: [f32; MAX_SLICES],
    pub center: [f32; 4],
    pub plane: GridPlane,
}

/// Every structure of the shader as it is here: what the layout test compares.
pub fn layouts() -> [(&'static str, Layout); 2] {
    macro_rules! fields {
        ($type:ty: $($field:ident),*) => { vec![$((stringify!($field), std::mem::offset_of!($type, $field))),*] };
    }
    let cluster = fields!(SoftCluster: center, radius_m, first, end, caster, pad_0);
    let head = fields!(SoftHead:
        world_x, plane_count, world_y, side, world_z, slice_count, light, origin, radius,
        near_clusters, cluster_count, triangle_side, triangle_lists, near_lists,
        masked_lists, masked_side, first_masked, end_masked, pad_0, pad_1, pad_2, slice_ends, center, plane);
    [("SoftCluster", (cluster, size_of::<SoftCluster>())), ("SoftHead", (head, size_of::<SoftHead>()))]
}

/// Which parts of casters are gathered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Parts {
    /// All.
    All,
    /// Those without holes.
    Whole,
    /// Those with holes.
    Masked,
}

/// What the shaders read of a light and its casters.
#[derive(Default)]
pub(super) struct LightData {
    /// Bindings 0 of the light, 1 to 5 of casters if there are any (edges, triangles, lists, clusters if needed, centres if there are several), 6
    /// and 7 of receivers (depth, normals).
    pub(super) bindings: Vec<(u32, Binding)>,
    /// Whether some triangles are asked by themselves: clusters are bound then.
    pub(super) clusters: bool,
    /// Whether the light is beside some caster: triangles as it sees them are bound then, as 8.
    pub(super) beside: bool,
    /// Bindings 9 to 11 of masks, if there are any.
    pub(super) masks: Vec<(u32, Binding)>,
    /// Whether receivers are transparent surfaces: they have no horizon.
    pub(super) on_layer: bool,
    /// How many casters there are.
    pub(super) casters: usize,
    /// How many edges can be silhouettes.
    pub(super) edges: usize,
    /// How many edges, and how many triangles, one receiver may have to ask.
    pub(super) longest_lists: [usize; 2],
    /// How many triangles cast.
    pub(super) triangles: usize,
}

/// Drivers may bound how often a shader goes round, all its loops together: Mesa's software one to 65 535 times.
const MOST_TURNS: usize = 60_000;

impl LightData {
    /// Whether lists are so long that shaders which walk them one by one, those of edges `walks` times and those of triangles
    /// once, are to take several at a turn.
    pub(super) fn has_long_lists(&self, walks: usize) -> bool {
        let [edges, triangles] = self.longest_lists;
        walks * edges + triangles > MOST_TURNS
    }
}

impl ShadowVolumeSoft {
    /// Gathers what casts for this light, of it those parts that are wanted. Without casters, what is left is the light itself, which surfaces still see
    /// partly beyond their horizon.
    pub(super) fn light_data(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        wanted: Parts,
    ) -> Result<LightData, ShadowError> {
        let ball = self.ball(light);
        let mut left_out = Vec::new();
        let mut chains: Vec<(Arc<CasterChain>, u64)> = Vec::new();
        let mut bounds = Aabb::EMPTY;
        for (_, instance) in light.casters() {
            let has =
                |casts: fn(&Material) -> bool| instance.materials.iter().any(|material| casts(material));
            let has_whole = wanted != Parts::Masked && has(Material::casts_whole);
            let has_masked = wanted != Parts::Whole && has(Material::casts_by_texel);
            if !has_whole && !has_masked {
                continue;
            }
            if let Err(reason) = self.may_matter(light, &ball, instance) {
                left_out.push((instance, reason));
                continue;
            }
            let (chain, key) = self.caster_chain(light, &ball, instance, [has_whole, has_masked])?;
            if chain.triangles.is_empty() && chain.masked.is_empty() {
                left_out.push((instance, "has no triangle with an area"));
                continue;
            }
            bounds = bounds.union(&instance.world_bounds);
            chains.push((chain, key));
        }
        note_left_out(light, out, &left_out);
        if chains.is_empty() {
            return self.bind(light, out, None);
        }
        let receivers = light.snapshot.world_bounds;
        let keys: Vec<u64> = chains.iter().map(|(_, key)| *key).collect();
        let camera = &light.view.camera;
        // Orthographic depths are as coarse everywhere as at a distance of their whole range.
        let depths_m = match camera.projection {
            Projection::Orthographic { near_m, far_m, .. } => far_m - near_m,
            Projection::Perspective { .. } => 0.0,
        };
        let eye_m = eye_distance(camera.world_from_view.translation, &bounds, depths_m);
        let worn: Vec<usize> = chains
            .iter()
            .flat_map(|(chain, _)| chain.masked.iter().filter_map(|masked| masked.image))
            .filter_map(|image| light.snapshot.images.get(&image))
            .map(|image| Arc::as_ptr(image) as usize)
            .collect();
        let key = hash_of((
            &keys,
            worn,
            [receivers.min, receivers.max].map(|corner| corner.to_array().map(f64::to_bits)),
            eye_m.to_bits(),
        ));
        let data = light.cache.get_or_compute("soft chains", key, || {
            let grid = SoftGrid::new(ball, &bounds, &receivers, eye_m);
            let images = |image: ImageKey| light.snapshot.images.get(&image).cloned();
            Chains::new(grid, chains.iter().map(|(chain, _)| chain.as_ref()), &images)
        });
        self.bind(light, out, Some((&data, key)))
    }

    /// The chain of a caster, and its key, with its whole parts and those with holes where these are wanted.
    fn caster_chain(
        &self,
        light: &LightContext<'_>,
        ball: &LightBall,
        instance: &Instance,
        [whole, masked]: [bool; 2],
    ) -> Result<(Arc<CasterChain>, u64), ShadowError> {
        let ball_bits = [ball.position.x, ball.position.y, ball.position.z, ball.position.w, ball.radius];
        let mut key = hash_of((instance.pose_key, ball_bits.map(f64::to_bits)));
        let mut shape = None;
        if whole {
            let cast = self.hard().cast_shape(light, instance)?;
            let half = self.half(light, ball, instance, &cast)?;
            let stretched = Stretched::of(light, instance);
            let cut_about = stretched.map(|stretched| stretched.center.to_array().map(f64::to_bits));
            let parts: Vec<bool> = instance.materials.iter().map(|material| material.casts_whole()).collect();
            key = hash_of((key, half, self.closure, parts, cut_about));
            shape = Some((cast, half, stretched));
        }
        if masked {
            key = hash_of((key, masks_key(instance)));
        }
        let chain = light.cache.get_or_compute("soft chain", key, || {
            let whole = shape.as_ref().map(|(shape, half, stretched)| {
                CasterChain::new(instance, shape, ball, *half, stretched.as_ref())
            });
            if masked { CasterChain::with_masks(instance, ball, whole) } else { whole.unwrap_or_default() }
        });
        Ok((chain, key))
    }

    /// The light as a ball that holds every disc it is seen as from further away than two radii.
    fn ball(&self, light: &LightContext<'_>) -> LightBall {
        let (position, size) = (light.light().position, self.size());
        let radius = if position.w == 0.0 { size.half_angle_rad.tan() } else { size.radius_m * LARGEST_DISC };
        LightBall { position, radius }
    }

    /// Whether a caster may hide part of the light from something in view.
    fn may_matter(
        &self,
        light: &LightContext<'_>,
        ball: &LightBall,
        instance: &Instance,
    ) -> Result<(), &'static str> {
        let bounds = instance.world_bounds;
        // Bounds grown by as far as the way to a sample may be from the way to the centre.
        let reach_m = if ball.position.w == 0.0 {
            2.0 * light.snapshot.world_bounds.union(&light.view.receiver_bounds).radius() * ball.radius
        } else if !self.may_be_close(light) {
            2.0 * ball.radius
        } else {
            // From close by, the disc is of any size.
            let nothing_receives = light.view.receiver_bounds.is_empty();
            return if nothing_receives { light.may_shadow(&bounds) } else { Ok(()) };
        };
        light.may_shadow(&bounds.expanded(reach_m))
    }

    /// Which of its triangles the caster casts with.
    fn half(
        &self,
        light: &LightContext<'_>,
        ball: &LightBall,
        instance: &Instance,
        shape: &CastShape<'_>,
    ) -> Result<Half, ShadowError> {
        if self.geometry == GeometryMode::Open {
            return Ok(Half::Both);
        }
        // A sheet of faces and their reverses has no inside in which the light could be.
        if matches!(shape, CastShape::Doubled(_)) {
            return Ok(Half::Lit);
        }
        let refused = |reason: String| match self.geometry {
            GeometryMode::Closed => {
                Err(light.unsupported(format!("geometry=closed, but {reason} (accepted for it: auto, open)")))
            }
            GeometryMode::Auto | GeometryMode::Open => Ok(Half::Both),
        };
        let name = &instance.name;
        if instance.materials.iter().any(|material| !material.casts_whole()) {
            return refused(format!("parts of '{name}' are blended or unlit"));
        }
        let topology = shape.topology();
        if topology.orientation(&instance.world_from_local).is_none() {
            let c = topology.closedness();
            return refused(format!(
                "'{name}' is no solid: {} unpaired edges, volume {:.3e} m3",
                c.unbalanced_edges, c.signed_volume
            ));
        }
        if shows_its_inside(instance, topology) {
            return Ok(Half::Both);
        }
        // From inside the solid, the light would see its walls from behind, which cast nothing in this mode.
        let outside = ball.position.w == 0.0
            || instance.world_bounds.distance(ball.position.truncate()) > ball.radius * (1.0 + 1e-6);
        if outside {
            return Ok(Half::Lit);
        }
        // Areas of all walls would count every way through the solid twice. Seen from outside, one side of it is enough.
        let local_from_world = instance.world_from_local.inverse();
        let near = light.view.frustum.near_corners.map(|corner| local_from_world.transform_point3(corner));
        let eye = light.view.camera.world_from_view.translation;
        let near = Aabb::from_points(near.into_iter().chain([local_from_world.transform_point3(eye)]));
        let eye_inside = topology.components().iter().any(|component| component.bounds.overlaps(&near));
        Ok(if self.quality == Quality::PerReceiver && !eye_inside { Half::Unlit } else { Half::Both })
    }

    /// Adds what the shaders read to the plan; without casters, what is left is the light itself.
    pub(super) fn bind(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
        chains: Option<(&Chains, u64)>,
    ) -> Result<LightData, ShadowError> {
        let name = light.light().name.clone();
        let head = Arc::new(bytes_of(&self.head(light, chains.map(|(chains, _)| chains))).to_vec());
        let storage = |out: &mut PassList<'_>, what: &str, key: u64, bytes: &Arc<Vec<u8>>, reason: &str| {
            let (name, key) = (format!("{what} of {name}"), hash_of((what, key)));
            out.buffer(BufferDesc::storage(&name, key, Arc::clone(bytes), reason))
        };
        let reason = "where the light is, as the eye sees it, and how it looks at casters";
        let slot = storage(out, "soft light", hash_of(&head), &head, reason);
        let mut bindings = vec![(0, Binding::Storage(slot))];
        let mut data = LightData::default();
        if let Some((chains, key)) = chains {
            for (binding, what, bytes, reason) in [
                (1, "soft edges", &chains.edges, "what can be a silhouette before the light"),
                (2, "soft triangles", &chains.triangles, "what hides the light's centre"),
                (3, "soft lists", &chains.lists, "which of these matter where"),
            ] {
                let slot = storage(out, what, key, bytes, reason);
                let (name, key) = (format!("{what} of {name}"), hash_of((what, key)));
                let packed = packed(light, out, &name, (slot, bytes.len()), Some(key))?;
                bindings.push((binding, Binding::Texture(packed)));
            }
            if chains.centers.len() > 1 {
                let centers: Vec<[f32; 4]> =
                    chains.centers.iter().map(|center| from_eye(light, *center)).collect();
                let centers = Arc::new(cast_slice(&centers).to_vec());
                let reason = "where casters are, as the eye sees them";
                let slot = storage(out, "soft centers", hash_of(&centers), &centers, reason);
                let packed =
                    packed(light, out, &format!("soft centers of {name}"), (slot, centers.len()), None)?;
                bindings.push((5, Binding::Texture(packed)));
            }
            // Where all casters are masked, there are none.
            let may_be_near = chains.near_clusters > 0 || self.may_be_close(light);
            data.clusters = chains.cluster_count > 0 && may_be_near;
            if data.clusters {
                let reason = "triangles that receivers ask at the light";
                bindings.push((
                    4,
                    Binding::Storage(storage(out, "soft clusters", key, &chains.clusters, reason)),
                ));
            }
            data.beside = !chains.beside.is_empty();
            if data.beside {
                let reason = "triangles as a light sees them that all but touches a caster";
                let slot = storage(out, "beside the soft light", key, &chains.beside, reason);
                let (name, key) = (format!("beside {name}"), hash_of(("beside the soft light", key)));
                let packed = packed(light, out, &name, (slot, chains.beside.len()), Some(key))?;
                bindings.push((8, Binding::Texture(packed)));
            }
            if let Some(masks) = &chains.masks {
                data.masks = masks.bind(light, out, key, self.samples)?;
            }
            data.casters = chains.centers.len();
            data.edges = chains.edge_count;
            data.longest_lists = chains.longest_lists;
            data.triangles = chains.triangle_count;
        }
        bindings.push((6, Binding::Texture(out.receiver_depth())));
        bindings.push((7, Binding::Texture(out.receiver_planes())));
        Ok(LightData { bindings, on_layer: light.layer().is_some(), ..data })
    }

    /// Whether something in view may receive so close to the light that lists do not hold there.
    fn may_be_close(&self, light: &LightContext<'_>) -> bool {
        let position = light.light().position;
        position.w > 0.0
            && light.view.receiver_bounds.distance(position.truncate()) < 2.0 * self.radius_m * (1.0 + 1e-6)
    }

    fn head(&self, light: &LightContext<'_>, chains: Option<&Chains>) -> SoftHead {
        let world_from_view = light.view.camera.world_from_view;
        let (rotation, eye) = (world_from_view.matrix3, world_from_view.translation);
        let short = |v: DVec3| v.as_vec3().to_array();
        let (size, position) = (self.size(), light.light().position);
        let to_light = position.truncate() - eye * position.w;
        let mut head = SoftHead {
            world_x: short(rotation.x_axis),
            world_y: short(rotation.y_axis),
            world_z: short(rotation.z_axis),
            light: to_light.extend(position.w).as_vec4().to_array(),
            radius: if position.w == 0.0 { size.half_angle_rad.tan() } else { size.radius_m } as f32,
            slice_ends: [f32::MAX; MAX_SLICES],
            ..SoftHead::zeroed()
        };
        let Some(chains) = chains else { return head };
        let SoftGrid { planes, side, triangle_side, slice_ends, .. } = &chains.grid;
        head.center = from_eye(light, chains.centers[0]);
        let plane = &planes[0];
        head.plane = GridPlane {
            x_axis: short(plane.x_axis),
            y_axis: short(plane.y_axis),
            z_axis: short(plane.z_axis),
            z_offset: plane.z_offset as f32,
            away: short(plane.away),
            ..GridPlane::default()
        };
        head.slice_ends.iter_mut().zip(slice_ends).for_each(|(place, end)| *place = *end as f32);
        if let Some(masks) = &chains.masks {
            head.masked_lists = masks.lists as u32;
            head.masked_side = masks.side as u32;
            head.first_masked = masks.first as u32;
            head.end_masked = (masks.first + masks.count) as u32;
        }
        SoftHead {
            plane_count: planes.len() as u32,
            side: *side as u32,
            slice_count: slice_ends.len() as u32,
            origin: short(planes[0].origin - eye),
            near_clusters: chains.near_clusters as u32,
            cluster_count: chains.cluster_count as u32,
            triangle_side: *triangle_side as u32,
            triangle_lists: chains.grid.edge_lists() as u32 + 1,
            near_lists: chains.near_lists as u32,
            ..head
        }
    }
}

/// From the eye to `center`, and how far that is.
fn from_eye(light: &LightContext<'_>, center: DVec3) -> [f32; 4] {
    let center = (center - light.view.camera.world_from_view.translation).as_vec3();
    center.extend(center.length()).to_array()
}
