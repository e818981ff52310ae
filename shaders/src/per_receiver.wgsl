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
fn chain_share(lists: Lists, r: Receiver, k: f32, disc: DiscView) -> f32 {
    let over_centre = f32(center_count(lists.triangles, r));
    var share = select(0.0, over_centre, !disc.dips || disc.horizon.z >= 0.0);
    var over_middle = over_centre;
    let chord = chord_of(disc.horizon);
    for (var place = lists.edges.first; place < lists.edges.end; place += 1u) {
        let edge = seen_edge(list_word(place), r);
        // What is more to its left than to its right.
        let weight = -f32(edge.weight);
        let crosses = edge.heights.x * edge.heights.x < dot(edge.heights.yz, edge.heights.yz);
        if weight == 0.0 || !crosses {
            continue;
        }
        let line = vec3f(edge.heights.yz, edge.heights.x);
        let left = center_is_left(edge.a, edge.b);
        let a = of_disc(vec3f(edge.a, edge.depths.x), k);
        let b = of_disc(vec3f(edge.b, edge.depths.y), k);
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

#if CLUSTERS
// The share that one triangle covers, whether before, in or beyond the light.
fn share_of(number: u32, r: Receiver, k: f32, disc: DiscView) -> f32 {
    let t = seen_triangle(number, r);
    let side = weight_of(t.side, t.bits);
    if side == 0 {
        return 0.0;
    }
    let share = triangle_share(disc, of_disc(t.a, k), of_disc(t.b, k), of_disc(t.c, k));
    return f32(select(-side, side, (t.bits & 1u) != 0u)) * share;
}

// The share that the first `count` clusters cover, triangle by triangle.
fn clusters_share(count: u32, r: Receiver, k: f32, disc: DiscView) -> f32 {
    var share = 0.0;
    for (var number = 0u; number < count; number += 1u) {
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
#endif

// The share that all casters cover.
fn covered(lists: Lists, r: Receiver, k: f32, disc: DiscView) -> f32 {
    var share = chain_share(lists, r, k, disc);
#if CLUSTERS
    share += clusters_share(lists.clusters, r, k, disc);
#endif
    return share;
}
#endif

// The share of the light's disc that is seen from the surface.
@fragment
fn per_receiver(in: SoftVaryings) -> @location(0) vec4f {
    take_light(in);
    let position = in.position;
    let pixel = vec2u(position.xy);
    let depth = textureLoad(receiver_depth, pixel, 0);
    let normal = textureLoad(receiver_normals, pixel, 0);
    // Depth is reversed: 0 is infinitely far, where nothing is.
    if depth == 0.0 || normal.w == 0.0 {
        discard;
    }
    var r = receiver_at(position.xy, depth);
    let n = world_from_view(normal.xyz);
    // The light over the surface's own plane: how high its centre is, and how far it reaches from there.
    let height = dot(n, r.w);
    let reach = r.k * sqrt(max(1.0 - height * height, 0.0));
    if height < -reach * 1.00001 {
        return vec4f(0.0);
    }
#if CASTERS
    let lists = lists_of(r);
    let alone = lists.clusters == 0u && lists.edges.first == lists.edges.end && lists.triangles.first == lists.triangles.end;
#else
    let alone = true;
#endif
    if alone && height > reach * 1.00001 {
        discard;
    }
    r = with_frame(r, position.xy, depth);
    let k = select(clamp(r.k, 1e-12, LARGEST_DISC), 1.0, r.k == 0.0);
    var disc: DiscView;
    disc.horizon = vec3f(dot(n, r.u) * k, dot(n, r.v) * k, height);
    disc.far = select(1e20, r.light_distance, soft.light.w > 0.0);
    let steep = length(disc.horizon.xy);
    disc.dips = r.k > 0.0 && disc.horizon.z < steep;
    var seen = select(0.0, 1.0, disc.horizon.z > 0.0);
    if r.k > 0.0 && steep > 0.0 {
        seen = share_above(disc.horizon.z / steep);
    }
#if CASTERS
    if seen > 0.0 && !alone {
        // What lies in the receiver's plane is in nobody's way, and rounding is not to lift it. Where the centre itself is
        // about in that plane, it is taken to be below the horizon: its side of what lies there is not sure.
        disc.margin = abs(dot(n, r.step)) / 8.0 + ROUNDING * r.distance;
        let unsure = clamp(disc.margin / (NEAREST * r.light_distance), 1e-6 * steep, 0.02 * steep);
        disc.lift = select(0.0, disc.horizon.z + unsure, disc.dips && abs(disc.horizon.z) < unsure);
        disc.horizon.z -= disc.lift;
        seen -= covered(lists, r, k, disc);
    }
#endif
    if seen >= 1.0 {
        discard;
    }
    return vec4f(max(seen, 0.0));
}
