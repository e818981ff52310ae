// The soft shadow of any triangles, by areas: what of the light's disc lies above the receiver's plane and is not covered by
// the casters, as this very receiver sees them. The layers over the centre are counted, and every silhouette edge adds
// what it covers beside the centre, or leaves: see common/disc_coverage.

#import common/soft_light
#import common/disc_coverage

// Larger discs, of receivers at the light, are all but half of what is seen.
const LARGEST_DISC: f32 = 1e6;

// From this part of the way to the light on, rounding does not move edges in the receiver's plane across the centre.
const NEAREST: f32 = 0.02;

#if CASTERS
// Corners in units of the disc.
fn of_disc(a: vec3f, k: f32) -> vec3f {
    return off_centre(vec3f(a.xy / k, a.z));
}

// The share that the casters of the lists cover. Their triangles are before the light as a whole.
fn chain_share(cell: u32, r: Receiver, k: f32, disc: DiscView) -> f32 {
    let over_centre = f32(center_count(cell, r));
    var share = select(0.0, over_centre, !disc.dips || disc.horizon.z >= 0.0);
    var over_middle = over_centre;
    let chord = chord_of(disc.horizon);
    let end = soft_lists[2u * cell + 1u];
    for (var place = soft_lists[2u * cell]; place < end; place += 1u) {
        let edge = seen_edge(soft_lists[place], r);
        // What is more to its left than to its right.
        let weight = -f32(edge.weight);
        let crosses = edge.heights.x * edge.heights.x < dot(edge.heights.yz, edge.heights.yz);
        if weight == 0.0 || !crosses {
            continue;
        }
        let line = vec3f(edge.heights.yz, edge.heights.x);
        let left = edge.heights.x >= 0.0;
        let a = of_disc(edge.a, k);
        let b = of_disc(edge.b, k);
        share += weight * cut_edge_share(disc, a, b, line, left);
        if disc.dips {
            let terms = chord_terms(disc, chord, a, b, line, left);
            over_middle += weight * terms.x;
            share += weight * terms.y;
        }
    }
    if disc.dips {
        share += over_middle * 2.0 * chord_share(chord, chord.reach);
    }
    return share;
}

// The share that one triangle covers, whether before, in or beyond the light.
fn share_of(number: u32, r: Receiver, k: f32, disc: DiscView) -> f32 {
    let t = soft_triangles[number];
    let caster = soft.casters[t.caster];
    let from_center = r.p - caster.xyz;
    let side = weight_of(side_of(t.plane, r, from_center, caster.w), t.bits);
    if side == 0 {
        return 0.0;
    }
    let a = of_disc(in_frame(r, t.a - from_center), k);
    let b = of_disc(in_frame(r, t.b - from_center), k);
    let c = of_disc(in_frame(r, t.c - from_center), k);
    return f32(select(-side, side, (t.bits & 1u) != 0u)) * triangle_share(disc, a, b, c);
}

// The share that clusters `first` … `end` − 1 cover, triangle by triangle.
fn clusters_share(first: u32, end: u32, r: Receiver, k: f32, disc: DiscView) -> f32 {
    var share = 0.0;
    for (var number = first; number < end; number += 1u) {
        let cluster = soft_clusters[number];
        if !may_reach(cluster, r) {
            continue;
        }
        for (var triangle = cluster.first; triangle < cluster.end; triangle += 1u) {
            // Within the light, only the centre counts.
            if r.k == 0.0 {
                share += f32(hides_center(triangle, r));
            } else {
                share += share_of(triangle, r, k, disc);
            }
        }
    }
    return share;
}

// The share that all casters cover.
fn covered(r: Receiver, k: f32, disc: DiscView) -> f32 {
    if !has_lists(r) {
        return clusters_share(0u, soft.cluster_count, r, k, disc);
    }
    var share = clusters_share(0u, soft.near_clusters, r, k, disc);
    let cell = cell_of(r);
    if cell != NO_CELL {
        share += chain_share(cell, r, k, disc);
    }
    return share;
}
#endif

// The share of the light's disc that is seen from the surface.
@fragment
fn per_receiver(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let depth = textureLoad(receiver_depth, pixel, 0);
    let normal = textureLoad(receiver_normals, pixel, 0);
    // Depth is reversed: 0 is infinitely far, where nothing is.
    if depth == 0.0 || normal.w == 0.0 {
        discard;
    }
    let r = receiver_at(position.xy, depth, normal.xyz);
    let k = select(clamp(r.k, 1e-12, LARGEST_DISC), 1.0, r.k == 0.0);
    var disc: DiscView;
    disc.horizon = vec3f(r.normal.xy * k, r.normal.z);
    disc.far = select(1e20, r.light_distance, soft.light.w > 0.0);
    let steep = length(disc.horizon.xy);
    disc.dips = r.k > 0.0 && disc.horizon.z < steep;
    let n = r.u * r.normal.x + r.v * r.normal.y + r.w * r.normal.z;
    var seen = select(0.0, 1.0, disc.horizon.z > 0.0);
    if r.k > 0.0 && steep > 0.0 {
        seen = share_above(disc.horizon.z / steep);
    }
#if CASTERS
    if seen > 0.0 {
        // What lies in the receiver's plane is in nobody's way, and rounding is not to lift it. Where the centre itself is
        // about in that plane, it is taken to be below the horizon: its side of what lies there is not sure.
        disc.margin = abs(dot(n, r.step)) / 8.0 + ROUNDING * r.distance;
        let unsure = clamp(disc.margin / (NEAREST * r.light_distance), 1e-6 * steep, 0.02 * steep);
        disc.lift = select(0.0, disc.horizon.z + unsure, disc.dips && abs(disc.horizon.z) < unsure);
        disc.horizon.z -= disc.lift;
        seen -= covered(r, k, disc);
    }
#endif
    if seen >= 1.0 {
        discard;
    }
    return vec4f(max(seen, 0.0));
}
