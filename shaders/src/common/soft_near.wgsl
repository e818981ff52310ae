// Triangles that are tested one by one: those near the light or wide as it sees them, and all for receivers at the light. They
// are listed by directions from the light's centre, see near_light_triangles.rs of ShadowVolumeSoft, or lie in clusters.

#import common/soft_seen

#if CASTERS
#if CLUSTERS
// Triangles that lie together, and the sphere around them.
struct SoftCluster {
    center: vec3f,
    radius_m: f32,
    first: u32,
    end: u32,
    caster: u32,
    pad_0: u32,
}

@group(1) @binding(4) var<storage, read> soft_clusters: array<SoftCluster>;

// Whether a sphere may reach into the cone from the receiver to the disc.
fn may_reach(cluster: SoftCluster, r: Receiver) -> bool {
    let caster = center_of(cluster.caster);
    let radius_m = cluster.radius_m + ROUNDING * (r.distance + caster.w);
    let d = in_frame(r, cluster.center + caster.xyz - r.p);
    let across = length(d.xy);
    // Over the cone's flank by less than the radius, and not wholly behind the point or beyond the disc.
    let beyond = select(d.z - radius_m * 1.00001 > r.light_distance, false, soft.light.w == 0.0);
    return across - r.k * d.z <= radius_m * sqrt(1.0 + r.k * r.k) * 1.00001 && d.z >= -radius_m * 1.00001 && !beyond;
}

// Walks the triangles that are tested one by one: those of a list, and those of the clusters in reach.
struct NearWalk {
    next: u32,
    end: u32,
    cluster: u32,
    clusters: u32,
    in_list: bool,
}

fn near_walk(lists: Lists) -> NearWalk {
    return NearWalk(lists.near.first, lists.near.end, 0u, lists.clusters, true);
}

// The next of them that may hide a part of the light; with side 0 when there is none.
fn next_near(walk: ptr<function, NearWalk>, r: Receiver) -> SeenTriangle {
    var t: SeenTriangle;
    var found = false;
    // Pixels that are drawn together look for the next one each by itself.
    while !found && ((*walk).next < (*walk).end || (*walk).cluster < (*walk).clusters) {
        while (*walk).next == (*walk).end && (*walk).cluster < (*walk).clusters {
            let cluster = soft_clusters[(*walk).cluster];
            let is_reached = may_reach(cluster, r);
            (*walk).next = select(0u, cluster.first, is_reached);
            (*walk).end = select(0u, cluster.end, is_reached);
            (*walk).cluster += 1u;
            (*walk).in_list = false;
        }
        while !found && (*walk).next < (*walk).end {
            let next = (*walk).next;
#if BESIDE
            t = seen_from_light(select(next, list_word(next), (*walk).in_list), r);
#else
            t = seen_triangle(select(next, list_word(next), (*walk).in_list), r);
#endif
            found = may_hide(t, r);
            (*walk).next += 1u;
        }
    }
    t.side = select(0, t.side, found);
    return t;
}
#endif
#endif
