//! Which casters have triangles in the very plane of what they may cast on. Few scenes have any, and only there must planes be asked.

use std::collections::HashSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use shadowgraph_engine::math::Aabb;
use shadowgraph_engine::scene::Instance;
use shadowgraph_engine::shadow::{LightContext, hash_of};

use super::parting::partings;

/// More triangles than this are not compared with each other: they count as if some lay in one plane.
const MAX_TRIANGLES: usize = 20_000;
/// What f32 loses of a mesh's corners, relative to its radius: some roundings.
const ROUNDING: f64 = 1e-6;
/// Planes that are turned against each other by more are told apart by depth.
const SAME_DIRECTION: f64 = 1.0 / 256.0;

/// The casters, by their numbers in the snapshot, of which a triangle lies in the plane of a transparent triangle of the scene and
/// touches it there. Kept until something moves; of two that did not it is not asked again.
pub(super) fn casters_on_glass(light: &LightContext<'_>) -> Arc<HashSet<usize>> {
    let instances = &light.snapshot.instances;
    let keys: Vec<_> = instances.iter().map(key_of).collect();
    light.cache.get_or_compute("casters on glass", hash_of(&keys), || {
        let glass: Vec<&Instance> = instances.iter().filter(|instance| has_glass(instance)).collect();
        let lies_on_some = |caster: &Instance| glass.iter().any(|receiver| lies_on(light, caster, receiver));
        (0..instances.len()).filter(|number| lies_on_some(&instances[*number])).collect()
    })
}

/// Whether a triangle of `caster` and a transparent one of `receiver` lie in one plane and touch.
fn lies_on(light: &LightContext<'_>, caster: &Instance, receiver: &Instance) -> bool {
    let margin_m = margin_m(caster, receiver);
    if !caster.world_bounds.expanded(margin_m).overlaps(&receiver.world_bounds) {
        return false;
    }
    let is_own = std::ptr::eq(caster, receiver);
    let key = hash_of((caster.pose_key, key_of(receiver), is_own));
    *light.cache.get_or_compute("coplanar", key, || share_a_plane(caster, receiver, is_own, margin_m))
}

/// Where an instance is, and which of its parts are transparent.
fn key_of(instance: &Instance) -> u64 {
    let glass: Vec<bool> = instance.materials.iter().map(|material| material.is_transparent()).collect();
    hash_of((instance.pose_key, glass))
}

fn has_glass(instance: &Instance) -> bool {
    instance.materials.iter().any(|material| material.is_transparent())
}

fn margin_m(a: &Instance, b: &Instance) -> f64 {
    ROUNDING * (a.world_bounds.radius() + b.world_bounds.radius())
}

/// A triangle in the world.
struct Flat {
    /// Its number in its mesh.
    number: usize,
    corners: [DVec3; 3],
    normal: DVec3,
    bounds: Aabb,
}

/// Whether some triangle of one and some transparent one of the other lie in one plane and touch.
fn share_a_plane(caster: &Instance, receiver: &Instance, is_own: bool, margin_m: f64) -> bool {
    let common = |instance: &Instance| instance.world_bounds.expanded(2.0 * margin_m);
    let (near_receiver, near_caster) = (common(receiver), common(caster));
    let casting = flats(caster, &near_receiver, |_| true);
    let seen = flats(receiver, &near_caster, |triangle| receiver.material_of(triangle).is_transparent());
    if casting.len().max(seen.len()) > MAX_TRIANGLES {
        return true;
    }
    let welded = is_own.then(|| caster.mesh.topology().triangles());
    // Both in the order in which they begin; those that have ended are of no more use.
    let (mut next, mut open): (usize, Vec<&Flat>) = (0, Vec::new());
    for flat in &casting {
        while let Some(begun) = seen.get(next).filter(|other| begins(other) <= ends(flat) + margin_m) {
            open.push(begun);
            next += 1;
        }
        open.retain(|other| ends(other) + margin_m >= begins(flat));
        let touches = |other: &&Flat| {
            let shared = welded.map_or(0, |welded| {
                welded[flat.number].iter().filter(|corner| welded[other.number].contains(corner)).count()
            });
            !(is_own && flat.number == other.number) && touch_in_plane(flat, other, shared, margin_m)
        };
        if open.iter().any(touches) {
            return true;
        }
    }
    false
}

fn begins(flat: &Flat) -> f64 {
    flat.bounds.min.x
}

fn ends(flat: &Flat) -> f64 {
    flat.bounds.max.x
}

/// The triangles of an instance that pass and come near `place`, those first that begin first.
fn flats(instance: &Instance, place: &Aabb, passes: impl Fn(usize) -> bool) -> Vec<Flat> {
    let flat = |number: usize| {
        let corners = instance.world_triangle(number);
        let [a, b, c] = corners;
        let bounds = Aabb::from_points(corners);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        (normal != DVec3::ZERO && bounds.overlaps(place)).then_some(Flat { number, corners, normal, bounds })
    };
    let mut flats: Vec<Flat> =
        (0..instance.mesh.triangle_count()).filter(|triangle| passes(*triangle)).filter_map(flat).collect();
    flats.sort_by(|a, b| begins(a).total_cmp(&begins(b)));
    flats
}

/// Whether two triangles, which share so many corners of one mesh, lie in one plane and overlap or touch. Where two of a mesh share
/// an edge, or a corner only, rasterisers cover every pixel once.
fn touch_in_plane(a: &Flat, b: &Flat, shared: usize, margin_m: f64) -> bool {
    if !a.bounds.expanded(margin_m).overlaps(&b.bounds) || a.normal.cross(b.normal).length() > SAME_DIRECTION
    {
        return false;
    }
    let apart = |flat: &Flat, other: &Flat| {
        let heights = other.corners.map(|corner| flat.normal.dot(corner - flat.corners[0]));
        heights.iter().all(|height| *height > margin_m) || heights.iter().all(|height| *height < -margin_m)
    };
    if apart(a, b) || apart(b, a) {
        return false;
    }
    let x_axis = a.normal.any_orthonormal_vector();
    let y_axis = a.normal.cross(x_axis);
    let flat = |corner: DVec3| DVec2::new(x_axis.dot(corner), y_axis.dot(corner));
    let (p, q) = (a.corners.map(flat), b.corners.map(flat));
    // Convex shapes are apart if an edge of one parts them.
    let both = [(p, q), (q, p)].into_iter();
    for (other, edge) in both.flat_map(|(own, other)| partings(own, other).map(move |edge| (other, edge))) {
        let gap_m = edge.gap_m();
        if gap_m > margin_m {
            return false;
        }
        if gap_m < -margin_m || shared == 0 {
            continue;
        }
        // The corners on the edge's line, and how much of the edge they cover.
        let along = (edge.to - edge.from).normalize_or_zero();
        let on_line = other.iter().zip(edge.beyond_m).filter(|(_, beyond_m)| beyond_m.abs() <= margin_m);
        let places: Vec<f64> = on_line.map(|(corner, _)| along.dot(*corner - edge.from)).collect();
        let first = places.iter().copied().fold(f64::INFINITY, f64::min).max(0.0);
        let last = places.iter().copied().fold(f64::NEG_INFINITY, f64::max).min(edge.from.distance(edge.to));
        if places.len() <= shared || last - first <= margin_m {
            return false;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(number: usize, corners: [[f64; 3]; 3]) -> Flat {
        let corners = corners.map(DVec3::from);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).normalize();
        Flat { number, corners, normal, bounds: Aabb::from_points(corners) }
    }

    const LEVEL: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

    fn touches(corners: [[f64; 3]; 3], shared: usize) -> bool {
        let (a, b) = (flat(0, LEVEL), flat(1, corners));
        let both = [touch_in_plane(&a, &b, shared, 1e-6), touch_in_plane(&b, &a, shared, 1e-6)];
        assert_eq!(both[0], both[1]);
        both[0]
    }

    #[test]
    fn triangles_in_one_plane_touch_where_they_overlap() {
        // Within it, around it, the same, turned over, and across.
        assert!(touches([[0.1, 0.0, 0.1], [0.3, 0.0, 0.1], [0.1, 0.0, 0.3]], 0));
        assert!(touches([[-1.0, 0.0, -1.0], [4.0, 0.0, -1.0], [-1.0, 0.0, 4.0]], 0));
        assert!(touches(LEVEL, 0));
        assert!(touches([LEVEL[0], LEVEL[2], LEVEL[1]], 3));
        assert!(touches([[0.2, 0.0, -1.0], [0.3, 0.0, -1.0], [0.25, 0.0, 2.0]], 0));
        // Above, beside, at an angle.
        assert!(!touches(LEVEL.map(|[x, y, z]| [x, y + 1e-3, z]), 0));
        assert!(!touches(LEVEL.map(|[x, y, z]| [x + 1.1, y, z]), 0));
        assert!(!touches(LEVEL.map(|[x, _, z]| [x, 0.1 * x, z]), 2));
        // Folded over by next to nothing.
        assert!(touches(LEVEL.map(|[x, _, z]| [x, 1e-3 * x, z]), 2));
    }

    #[test]
    fn neighbours_of_one_mesh_do_not_touch() {
        // Across the edge from (1, 0, 0) to (0, 0, 1), and at the corner (1, 0, 0).
        let across = [[1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]];
        let at_corner = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.1], [2.0, 0.0, -0.1]];
        // So may an edge of each lie in one line.
        let in_line = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, -1.0]];
        assert!(!touches(across, 2) && !touches(at_corner, 1) && !touches(in_line, 1));
        // Of two meshes they do, and where a corner lies on an edge.
        assert!(touches(across, 0));
        assert!(touches([[1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.5, 0.0, 0.5]], 1));
    }
}
