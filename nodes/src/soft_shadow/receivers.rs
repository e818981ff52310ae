//! The planes that receive: which of the named meshes lie in one, and where.

use glam::{DVec2, DVec3, DVec4};
use shadowgraph_engine::math::{Aabb, Plane};
use shadowgraph_engine::scene::{Instance, SceneSnapshot};
use shadowgraph_engine::shadow::{LightContext, PassList, ShadowError};

/// A vertex in f32 that was computed to lie in a plane lies this share of its coordinates off it, or less: 8 roundings.
const FLATNESS: f64 = 4.8e-7;
/// What f64 leaves of a position's coordinates under a transform, and of a height computed from them.
const ROUNDING: f64 = 1e-13;

/// Why a mesh is not a plane.
#[derive(Clone, Debug, PartialEq)]
pub enum NotPlanar {
    /// It has no triangle with an area.
    NoArea,
    /// It reaches too far out of its largest triangle's plane.
    Deviates {
        /// How far.
        deviation_m: f64,
        /// How far rounding could have moved it.
        accepted_m: f64,
    },
}

impl std::fmt::Display for NotPlanar {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::NoArea => write!(f, "has no area, so it lies in no plane of its own"),
            Self::Deviates { deviation_m, accepted_m } => write!(
                f,
                "is not planar: it reaches {deviation_m:.3e} m out of its plane (accepted: {accepted_m:.1e} m); a node \
                 shades all that its 'receivers' name, everything where it names none"
            ),
        }
    }
}

/// The plane of a planar mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat {
    /// The plane.
    pub plane: Plane,
    /// How far from the plane a point may be that counts as in it, in metres: what rounding leaves.
    pub tolerance_m: f64,
}

impl Flat {
    /// The plane in which `instance` lies.
    ///
    /// # Errors
    /// Why it lies in none.
    pub fn of(instance: &Instance) -> Result<Self, NotPlanar> {
        let corners = (0..instance.mesh.triangle_count()).map(|triangle| instance.world_triangle(triangle));
        let normal = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a);
        let largest = corners
            .clone()
            .max_by(|p, q| normal(*p).length_squared().total_cmp(&normal(*q).length_squared()))
            .filter(|corners| normal(*corners).length_squared() > 0.0)
            .ok_or(NotPlanar::NoArea)?;
        let plane = Plane::through(largest[0], normal(largest));
        let deviation_m = corners.flatten().map(|p| plane.height(p).abs()).fold(0.0, f64::max);
        let coordinate = instance.mesh.positions().iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        let scale =
            instance.world_from_local.matrix3.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
        let world = instance.world_bounds.min.abs().max(instance.world_bounds.max.abs()).max_element();
        let accepted_m = FLATNESS * f64::from(coordinate) * scale + ROUNDING * world;
        if deviation_m > accepted_m {
            return Err(NotPlanar::Deviates { deviation_m, accepted_m });
        }
        Ok(Self { plane, tolerance_m: 2.0 * deviation_m + ROUNDING * world })
    }
}

/// Receivers in one plane, as the eye sees them.
#[derive(Clone, Debug)]
pub(super) struct Receiver {
    /// The plane; the eye is on its positive side.
    pub(super) flat: Flat,
    /// Indices into the scene's instances.
    pub(super) instances: Vec<usize>,
    /// Their names.
    pub(super) name: String,
    /// The box around them.
    pub(super) bounds: Aabb,
}

impl Receiver {
    /// The planes that the node's receivers in view lie in.
    ///
    /// # Errors
    /// A receiver that is not planar, by name.
    pub(super) fn all(light: &LightContext<'_>, out: &mut PassList<'_>) -> Result<Vec<Self>, ShadowError> {
        let mut receivers: Vec<Self> = Vec::new();
        let mut left_out = Vec::new();
        for (index, instance) in light.receivers() {
            let flat = light.cache.get_or_compute("flat", instance.pose_key, || Flat::of(instance));
            let mut flat = flat
                .as_ref()
                .clone()
                .map_err(|reason| light.unsupported(format!("receiver '{}' {reason}", instance.name)))?;
            if !instance.materials.iter().any(|material| material.is_opaque()) {
                left_out.push((instance, "lets light through"));
                continue;
            }
            // A layer shows what is transparent, and nothing of this.
            if light.layer().is_some() && instance.materials.iter().all(|material| material.is_opaque()) {
                continue;
            }
            if !light.view.frustum.may_see(&instance.world_bounds) {
                left_out.push((instance, "outside the view"));
                continue;
            }
            let side = height_of(&flat.plane, light.view.frustum.eye);
            if side == 0.0 {
                left_out.push((instance, "seen edge-on"));
                continue;
            }
            if side < 0.0 {
                flat.plane = Plane { normal: -flat.plane.normal, offset: -flat.plane.offset };
            }
            let corners = instance.world_bounds.corners();
            let lies_in = |receiver: &&mut Self| {
                let Flat { plane, tolerance_m } = receiver.flat;
                plane.normal.dot(flat.plane.normal) > 0.0
                    && instance.mesh.positions().len() < 1 << 16
                    && (corners.iter().all(|p| plane.height(*p).abs() <= tolerance_m)
                        || (0..instance.mesh.positions().len() as u32)
                            .all(|v| plane.height(instance.world_position(v)).abs() <= tolerance_m))
            };
            match receivers.iter_mut().find(lies_in) {
                Some(receiver) => {
                    receiver.instances.push(index);
                    receiver.name = format!("{}, {}", receiver.name, instance.name);
                    receiver.bounds = receiver.bounds.union(&instance.world_bounds);
                }
                None => receivers.push(Self {
                    flat,
                    instances: vec![index],
                    name: instance.name.clone(),
                    bounds: instance.world_bounds,
                }),
            }
        }
        for (instance, reason) in left_out {
            out.note(format!("receiver '{}' for '{}': {reason}", instance.name, light.light().name));
        }
        Ok(receivers)
    }
}

impl Receiver {
    /// The plane's axes in which its rectangle is smallest, among those along an edge of its largest triangle.
    pub(super) fn axes(&self, snapshot: &SceneSnapshot) -> (DVec3, DVec3) {
        let normal = self.flat.plane.normal;
        let triangles = self.instances.iter().flat_map(|index| {
            let instance = &snapshot.instances[*index];
            (0..instance.mesh.triangle_count()).map(|triangle| instance.world_triangle(triangle))
        });
        let area = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).length_squared();
        let largest = triangles.max_by(|p, q| area(p).total_cmp(&area(q)));
        let edges = largest.into_iter().flat_map(|[a, b, c]| [b - a, c - b, a - c]);
        let axes = edges.chain([normal.any_orthonormal_vector()]).filter_map(|edge| {
            let u = (edge - normal * edge.dot(normal)).try_normalize()?;
            Some((u, normal.cross(u)))
        });
        let size = |(u, v): &(DVec3, DVec3)| {
            let (low, high) = self.extent(snapshot, *u, *v);
            (high - low).element_product()
        };
        axes.min_by(|p, q| size(p).total_cmp(&size(q))).unwrap_or((DVec3::X, DVec3::Z))
    }

    /// Its rectangle in the plane's axes.
    pub(super) fn extent(&self, snapshot: &SceneSnapshot, u: DVec3, v: DVec3) -> (DVec2, DVec2) {
        let instances = self.instances.iter().map(|index| &snapshot.instances[*index]);
        let vertices =
            instances.flat_map(|i| (0..i.mesh.positions().len() as u32).map(|v| i.world_position(v)));
        vertices.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), p| {
            let place = DVec2::new(u.dot(p), v.dot(p));
            (low.min(place), high.max(place))
        })
    }
}

/// The height of the homogeneous `position` over `plane`; for a direction, how much it rises along the normal.
pub(super) fn height_of(plane: &Plane, position: DVec4) -> f64 {
    plane.normal.dot(position.truncate()) - plane.offset * position.w
}
