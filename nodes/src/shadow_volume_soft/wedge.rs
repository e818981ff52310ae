//! `quality=wedge`: penumbra wedges as published in 2003, the baseline that the other qualities are measured against.
//!
//! *The idea.* The hard shadow from the light's centre is counted in a float target. Then every silhouette edge, as the
//! centre sees it, is drawn as the volume of all points from which it may cut the light's disc: its wedge. A fragment
//! adds the share of the disc between the edge and the centre, or takes it away: so that what was counted for the centre
//! becomes what is hidden of the disc. At last the sum is clamped and taken from the light.
//!
//! *Sources.* Assarsson & Akenine-Möller 2003; Lindrud & Löfgren 2004 §4, §5.4 and §6.4 for casters of any geometry: with
//! all triangles casting, what an edge adds counts twice where it is closed and once where it is open, as hard layers do.
//!
//! *What differs here.*
//! - The share of an edge is exact (`common/disc_coverage`) instead of looked up, for a disc and not for a square.
//! - One float target that takes negative numbers, instead of two of eight bits.
//! - A wedge is the convex volume between planes that touch the light's sphere: two through the edge, one through each
//!   end. Only the faces through which a view leaves it are drawn, behind what is seen: no near plane cuts them. Where
//!   the line of an edge meets the sphere, there are no such planes, and the whole view is asked.
//!
//! *Limits*, which are those of 2003 and stay:
//! - Silhouettes are those of the centre. What other points of the light see round a caster is missed.
//! - Areas add up. Where casters, or layers of one, overlap within a penumbra, it is too dark; open casters, of which
//!   every layer counts, have a shadow that is larger and a penumbra that is narrower (`closure=cap` is the cure).
//! - Where the rasterised count and the share disagree about which side of an edge the centre is on, a pixel is off by
//!   a whole layer: along the edge of the hard shadow, as many as hard shadows have within 1/256 pixel of theirs.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable, bytes_of, cast_slice};
use glam::{DVec3, DVec4};
use shadowgraph_engine::geometry::Chain;
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::plan::{
    ADD, BufferDesc, CompareFunction, DrawState, Load, MULTIPLY, Resource, Shader, ShaderError,
};
use shadowgraph_engine::shadow::{
    Binding, Channels, ColorTarget, Contribution, DepthTarget, Draw, Geometry, LightContext, LightSize, Pass,
    PassList, ShadowError, hash_of,
};

use super::ShadowVolumeSoft;
use crate::common::layer_groups::Caster;
use crate::shadow_volume_hard::Layers;

/// `struct WedgeEdge` of penumbra_wedge.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub(super) struct WedgeEdge {
    pub a: [f32; 3],
    pub weight: f32,
    pub b: [f32; 3],
    pub caster: u32,
    pub normals: [[f32; 4]; 4],
    pub rays: [[f32; 4]; 4],
}

/// The head of `struct WedgeCasters` of penumbra_wedge.wgsl, which the casters' centres follow.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented where the shader reads them")]
pub(super) struct WedgeCasters {
    pub world_x: [f32; 3],
    pub size: f32,
    pub world_y: [f32; 3],
    pub end_m: f32,
    pub world_z: [f32; 3],
    pub pad_0: f32,
    pub light: [f32; 4],
}

/// Names and byte offsets of a structure's fields, and its whole size.
type Layout = (Vec<(&'static str, usize)>, usize);

/// The structures of the shader as they are here: what the layout test compares.
pub fn layouts() -> [(&'static str, Layout); 2] {
    macro_rules! fields {
        ($type:ty: $($field:ident),*) => { vec![$((stringify!($field), std::mem::offset_of!($type, $field))),*] };
    }
    let edge = fields!(WedgeEdge: a, weight, b, caster, normals, rays);
    let mut casters = fields!(WedgeCasters: world_x, size, world_y, end_m, world_z, pad_0, light);
    casters.push(("centers", size_of::<WedgeCasters>()));
    // A runtime-sized array counts as one element.
    let whole = size_of::<WedgeCasters>() + size_of::<[f32; 4]>();
    [("WedgeEdge", (edge, size_of::<WedgeEdge>())), ("WedgeCasters", (casters, whole))]
}

/// The most edges of one draw: their buffer stays below what every adapter can bind.
const MAX_EDGES: usize = 1 << 19;
/// Triangles of a wedge's five faces, as corners.
const WEDGE_VERTICES: u32 = 24;

impl ShadowVolumeSoft {
    /// Adds the passes that darken the light's visibility: the layers over its centre, the wedges, and what is left.
    ///
    /// # Errors
    /// What the options do not accept.
    pub(super) fn plan_wedges(
        &self,
        light: &LightContext<'_>,
        out: &mut PassList<'_>,
    ) -> Result<Contribution, ShadowError> {
        let shares = match self.hard().count_layers(light, out)? {
            Some(layers) => add_shares(light, out, &layers, self.size())?,
            None => Contribution::default(),
        };
        Ok(shares.and(self.plan_horizon(light, out)?).and(self.plan_masks(light, out)?))
    }
}

/// Adds what silhouette edges hide beside the centre to `layers`, and darkens by the sum.
fn add_shares(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    layers: &Layers<'_>,
    size: LightSize,
) -> Result<Contribution, ShadowError> {
    let Layers { counts, casters } = layers;
    let counts = *counts;
    let name = light.light().name.clone();
    let (edges, key) = edges(light, casters, size);
    let shared = view(light, out, casters, size);
    let mut draws = Vec::new();
    for (batch, edges) in edges.chunks(MAX_EDGES).enumerate() {
        let bytes = Arc::new(cast_slice(edges).to_vec());
        let reason = format!("where {} silhouette edges may cut the light", edges.len());
        let key = hash_of(("wedge edges", key, batch));
        let edge_buffer = out.buffer(BufferDesc::storage(&format!("wedges of {name}"), key, bytes, &reason));
        let (shader, instances) = (shader("vertex", "add_share")?, edges.len() as u32);
        let geometry = Geometry::Procedural { shader, vertices: WEDGE_VERTICES, instances };
        let state = DrawState::new(CompareFunction::Less, vec![Some(ADD)]);
        draws.push(Draw::new(format!("{instances} wedges"), geometry, state).reading(vec![
            (0, Binding::Storage(shared)),
            (1, Binding::Storage(edge_buffer)),
            (2, Binding::Texture(out.receiver_depth())),
        ]));
    }
    out.pass(Pass {
        name: format!("wedges of {name}"),
        reason: "what each silhouette edge hides of the light beside its centre, or leaves of it".into(),
        colors: vec![ColorTarget::new(counts, Load::Keep)],
        depth: Some(DepthTarget::TEST),
        draws,
    });
    let state = DrawState::new(CompareFunction::Always, vec![Some(MULTIPLY)]);
    let darken = Draw::new("darken", Geometry::fullscreen(shader("fullscreen_vertex", "darken")?), state);
    out.pass(Pass {
        name: format!("darken {name}"),
        reason: "layers and shares become what is left of the light".into(),
        colors: vec![ColorTarget::VISIBILITY],
        depth: None,
        draws: vec![darken.reading(vec![(3, Binding::Texture(counts))])],
    });
    Ok(Contribution::visibility(Channels::One))
}

/// A shader of this technique's own.
fn shader(vertex: &'static str, fragment: &'static str) -> Result<Shader, ShaderError> {
    Shader::composed("penumbra_wedge", &[], vertex, Some(fragment))
}

/// The silhouette edges of all casters with their wedges, and a hash of what they were computed from.
fn edges(light: &LightContext<'_>, casters: &[Caster<'_>], size: LightSize) -> (Arc<Vec<WedgeEdge>>, u64) {
    let position = light.light().position;
    let size_bits = [size.radius_m, size.half_angle_rad].map(f64::to_bits);
    // The light is part of each caster's key.
    let keys: Vec<u64> = casters.iter().map(|caster| caster.key).collect();
    let key = hash_of(("wedges", &keys, size_bits));
    let edges = light.cache.get_or_compute("wedges", key, || {
        let of = |(number, caster): (usize, &Caster<'_>)| edges_of(caster, number as u32, position, size);
        casters.iter().enumerate().flat_map(of).collect()
    });
    (edges, key)
}

fn edges_of(caster: &Caster<'_>, number: u32, light: DVec4, size: LightSize) -> Vec<WedgeEdge> {
    let chain = Chain::extract(caster.shape.topology(), &caster.facing.signs);
    let center = caster.instance.world_bounds.center();
    // The chain lists an edge as often as it weighs. Its sides run along the caps as the light sees them.
    let weighted = chain.sides.chunk_by(|a, b| a == b);
    weighted
        .map(|equal| {
            let [q, p] = equal[0].map(|vertex| caster.facing.p_in_world[vertex as usize]);
            let short = |v: DVec3| v.as_vec3().to_array();
            let mut edge = WedgeEdge {
                a: short(p - center),
                weight: equal.len() as f32,
                b: short(q - center),
                caster: number,
                ..WedgeEdge::default()
            };
            if let Some(wedge) = Wedge::new(p, q, light, size) {
                edge.normals = wedge.normals.map(|n| n.as_vec3().extend(0.0).to_array());
                edge.rays = wedge.rays.map(|r| r.as_vec3().extend(0.0).to_array());
            }
            edge
        })
        .collect()
}

/// The volume of all points from which an edge may lie before the light.
#[derive(Clone, Debug)]
struct Wedge {
    /// Outward unit normals: two planes through the edge, one through each end.
    normals: [DVec3; 4],
    /// Unit directions: from both ends in the first plane, then in the second.
    rays: [DVec3; 4],
}

/// Planes touch a light that is larger by this, so that rounding cuts nothing off.
const LARGER: f64 = 1.0 + 1e-4;
/// The least cosine between any two rays: wider wedges are no volumes worth drawing.
const WIDEST: f64 = 0.05;

impl Wedge {
    /// `None` where the edge's line meets the light, or is seen so wide that the volume is about half of space.
    ///
    /// *Why it is enough.* Let n be a unit vector with n·(x − e) ≥ 0 for every point x of the light and n·(y − e) ≤ 0 for
    /// every point y of the edge. A point that sees y before x is y + t·(y − x), t ≥ 0, so it too has n·(… − e) ≤ 0.
    fn new(a: DVec3, b: DVec3, light: DVec4, size: LightSize) -> Option<Self> {
        let along = (b - a).try_normalize()?;
        let offset = |end: DVec3| light.truncate() - end * light.w;
        // How far the light reaches towards a plane: in metres, or as the sine of an angle.
        let reach = if light.w > 0.0 { size.radius_m } else { size.half_angle_rad.sin() } * LARGER;
        let from_line = offset(a) - along * offset(a).dot(along);
        let distance = from_line.length();
        let unit = if light.w > 0.0 { 1.0 } else { offset(a).length() };
        if distance <= reach * unit {
            return None;
        }
        let outwards = from_line / distance;
        let side = along.cross(outwards);
        let cosine = reach * unit / distance;
        let sine = (1.0 - cosine * cosine).sqrt();
        let end = |end: DVec3, along: DVec3| {
            // The normal in the plane of edge and centre, turned from the way to the centre as far as it goes.
            let way = offset(end);
            let turn = f64::atan2(way.dot(outwards), way.dot(along)) + (reach * unit / way.length()).acos();
            let normal = along * turn.cos() + outwards * turn.sin();
            (normal.dot(along) <= 0.0).then_some(normal)
        };
        let through = [outwards * cosine + side * sine, outwards * cosine - side * sine];
        let ends = [end(a, along)?, end(b, -along)?];
        // Away from the light, along the line in which two planes meet.
        let ray = |plane: DVec3, end: DVec3| {
            let ray = plane.cross(end).try_normalize()?;
            let away = -ray.dot(outwards).signum() * ray;
            Some(away)
        };
        let rays = [
            ray(through[0], ends[0])?,
            ray(through[0], ends[1])?,
            ray(through[1], ends[0])?,
            ray(through[1], ends[1])?,
        ];
        let normals = [through[0], through[1], ends[0], ends[1]];
        let inside = rays.iter().all(|ray| normals.iter().all(|normal| normal.dot(*ray) < 1e-9));
        let narrow = rays.iter().all(|r| rays.iter().all(|s| r.dot(*s) > WIDEST));
        (inside && narrow).then_some(Self { normals, rays })
    }
}

/// What all wedges of a light share: how the eye stands, the light, and where the casters are.
fn view(
    light: &LightContext<'_>,
    out: &mut PassList<'_>,
    casters: &[Caster<'_>],
    size: LightSize,
) -> Resource {
    let world_from_view = light.view.camera.world_from_view;
    let eye = world_from_view.translation;
    let position = light.light().position;
    let towards = position.truncate() - eye * position.w;
    let towards = if position.w > 0.0 { towards } else { towards.normalize_or_zero() };
    let short = |v: DVec3| v.as_vec3().to_array();
    let end_m = if light.view.frustum.eye.w > 0.0 {
        0.0
    } else {
        // The farthest way from an edge to anything in view, and rays may stand aslant.
        let near = Aabb::from_points(light.view.frustum.near_corners);
        let bounds = casters.iter().fold(near.union(&light.view.receiver_bounds), |bounds, caster| {
            bounds.union(&caster.instance.world_bounds)
        });
        2.0 * (bounds.radius() + light.view.camera.projection.far_m()) / WIDEST
    };
    let head = WedgeCasters {
        world_x: short(world_from_view.matrix3.x_axis),
        size: if position.w > 0.0 { size.radius_m } else { size.half_angle_rad.tan() } as f32,
        world_y: short(world_from_view.matrix3.y_axis),
        end_m: end_m as f32,
        world_z: short(world_from_view.matrix3.z_axis),
        pad_0: 0.0,
        light: towards.as_vec3().extend(position.w as f32).to_array(),
    };
    let centers: Vec<[f32; 4]> = casters
        .iter()
        .map(|caster| (caster.instance.world_bounds.center() - eye).as_vec3().extend(0.0).to_array())
        .collect();
    let bytes = [bytes_of(&head), cast_slice(&centers)].concat();
    let key = hash_of(("wedge casters", &bytes));
    let name = format!("wedge casters of {}", light.light().name);
    let reason = "where the light and casters are, from the eye";
    out.buffer(BufferDesc::storage(&name, key, Arc::new(bytes), reason))
}
