// The soft shadow of any triangles, by areas: what of the light's disc lies above the receiver's plane and is not covered by
// the casters, as this very receiver sees them. The layers over the centre are counted, and every silhouette edge adds
// what it covers beside the centre, or leaves: see common/disc_coverage.

#import common/soft_light
#import common/soft_seen
#import common/soft_near
#import common/soft_question
#import common/disc_coverage

// Radii are clamped to this: larger discs, seen from receivers at the light, fill nearly half of the directions anyway.
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
    var place = lists.edges.first;
    loop {
        // Pixels that are drawn together look for the next edge that matters each by itself, and reckon together.
        var edge = no_edge();
        while place < lists.edges.end && edge.weight == 0 {
            edge = seen_edge(list_word(place), r);
            place += 1u;
        }
        if edge.weight == 0 {
            break;
        }
        // What is more to its left than to its right.
        let crosses = edge.heights.x * edge.heights.x < dot(edge.heights.yz, edge.heights.yz);
        let weight = select(0.0, -f32(edge.weight), crosses);
        let line = vec3f(edge.heights.yz, edge.heights.x);
        let left = center_is_left(edge.a, edge.b);
        let a = of_disc(vec3f(edge.a, edge.depths.x), k);
        let b = of_disc(vec3f(edge.b, edge.depths.y), k);
        share += weight * cut_edge_share(disc, a, b, line, left);
        // A loop where a condition is meant: such pixels skip together what none of them enters, but only loops.
        for (var dips = disc.dips; dips; dips = false) {
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
fn share_of(t: SeenTriangle, r: Receiver, k: f32, disc: DiscView) -> f32 {
    let side = weight_of(t.side, t.bits);
    let share = triangle_share(disc, of_disc(t.a, k), of_disc(t.b, k), of_disc(t.c, k));
    // Within the light, only the centre counts.
    let of_center = f32(seen_hides_center(t));
    return select(f32(select(-side, side, (t.bits & 1u) != 0u)) * share, of_center, r.k == 0.0);
}

// The share that the triangles cover that are tested one by one.
fn nearby_share(lists: Lists, r: Receiver, k: f32, disc: DiscView) -> f32 {
    var share = 0.0;
    var walk = near_walk(lists);
    loop {
        let t = next_near(&walk, r);
        if t.side == 0 {
            break;
        }
        share += share_of(t, r, k, disc);
    }
    return share;
}
#endif

// The share that all casters cover.
fn covered(lists: Lists, r: Receiver, k: f32, disc: DiscView) -> f32 {
    var share = chain_share(lists, r, k, disc);
#if CLUSTERS
    share += nearby_share(lists, r, k, disc);
#endif
    return share;
}
#endif

// The share of the light's disc that is seen from the surface.
@fragment
fn per_receiver(in: SoftVaryings) -> @location(0) vec4f {
    take_light(in);
    let position = in.position;
    let q = question_at(position.xy);
    let height = q.height;
    // The light as a whole is below the surface's own plane.
    if height < -q.reach {
        return vec4f(0.0);
    }
    let n = q.n;
    let r = with_frame(q.r, position.xy, textureLoad(receiver_depth, vec2u(position.xy), 0), q.normal, q.at);
    let k = select(clamp(r.k, 1e-12, LARGEST_DISC), 1.0, r.k == 0.0);
    var disc: DiscView;
    disc.horizon = vec3f(dot(n, r.u) * k, dot(n, r.v) * k, height);
#if ON_LAYER
    disc.horizon = vec3f(0.0, 0.0, 1.0);
#endif
    disc.far = select(1e20, r.light_distance, soft.light.w > 0.0);
    let steep = length(disc.horizon.xy);
    disc.dips = r.k > 0.0 && disc.horizon.z < steep;
    var seen = select(0.0, 1.0, disc.horizon.z > 0.0);
    if r.k > 0.0 && steep > 0.0 {
        seen = share_above(disc.horizon.z / steep);
    }
#if CASTERS
    if seen > 0.0 {
        // What lies in the receiver's plane hides nothing, and rounding must not lift it out. A centre close to that plane is
        // taken to be below the horizon, since its side of what lies there is not certain.
        disc.margin = abs(dot(n, r.step)) / 8.0 + ROUNDING * r.distance;
        let unsure = clamp(disc.margin / (NEAREST * r.light_distance), 1e-6 * steep, 0.02 * steep);
        disc.lift = select(0.0, disc.horizon.z + unsure, disc.dips && abs(disc.horizon.z) < unsure);
        disc.horizon.z -= disc.lift;
        seen -= covered(q.lists, r, k, disc);
    }
#endif
    if seen >= 1.0 {
        discard;
    }
    return vec4f(max(seen, 0.0));
}
