// The soft shadow of any triangles, sample by sample. At every pixel the visible point is rebuilt from its depth. For each
// sample of the light's disc it counts the triangles between: at the centre by the triangles listed there, and from
// there on by the edges between the centre and the sample. 64 samples are counted at a time, in bit planes: bit i of
// plane j is bit j of the count of sample i.

#import common/soft_light

@group(1) @binding(5) var<storage, read> light_samples: array<vec2f>;

// Samples of this round, and how many there are.
struct Round {
    first: u32,
    count: u32,
}

// A bit for each sample of the round with heights.x + heights.y·x + heights.z·y >= 0.
fn not_below(heights: vec3f, round: Round) -> vec2u {
    var bits = vec2u(0u);
    for (var i = 0u; i < round.count; i += 1u) {
        let sample = light_samples[round.first + i];
        let above = u32(fma(sample.x, heights.y, fma(sample.y, heights.z, heights.x)) >= 0.0);
        bits |= select(vec2u(above << (i & 31u), 0u), vec2u(0u, above << (i & 31u)), i >= 32u);
    }
    return bits;
}

#if CASTERS
#if DEEP
const PLANES: u32 = 24u;
#else
const PLANES: u32 = 8u;
#endif

var<private> counts: array<vec2u, PLANES>;

// Adds `weight` to the counts of the samples in `bits`.
fn add(bits: vec2u, weight: i32) {
    let borrows = select(vec2u(0u), vec2u(0xffffffffu), weight < 0);
    var size = u32(abs(weight));
    // Weights are small: 1 or 2 for edges, once any number for the centre.
    for (var first = 0u; first < PLANES && size != 0u; first += 1u) {
        if (size & 1u) != 0u {
            var carry = bits;
            for (var plane = first; plane < PLANES && any(carry != vec2u(0u)); plane += 1u) {
                let old = counts[plane];
                counts[plane] = old ^ carry;
                carry &= old ^ borrows;
            }
        }
        size >>= 1u;
    }
}

// Counts what the edges of `cell` change between the centre and each sample.
fn add_edges(cell: u32, r: Receiver, round: Round) {
    let end = soft_lists[2u * cell + 1u];
    for (var place = soft_lists[2u * cell]; place < end; place += 1u) {
        let edge = seen_edge(soft_lists[place], r);
        if edge.weight == 0 || !crosses_disc(edge.heights) {
            continue;
        }
        // Beyond the edge's line, and between its ends as seen from the centre.
        let beyond = not_below(edge.heights, round);
        let a = not_below(vec3f(0.0, edge.a.y, -edge.a.x), round);
        let b = not_below(vec3f(0.0, edge.b.y, -edge.b.x), round);
        if edge.heights.x >= 0.0 {
            add(~beyond & ~a & b, edge.weight);
        } else {
            add(beyond & a & ~b, -edge.weight);
        }
    }
}

// Samples that a triangle hides, whether before, in or beyond the light.
fn hidden_by(number: u32, r: Receiver, round: Round) -> vec2u {
    let t = soft_triangles[number];
    let caster = soft.casters[t.caster];
    let from_center = r.p - caster.xyz;
    let side = side_of(t.plane, r, from_center, caster.w);
    if weight_of(side, t.bits) == 0 {
        return vec2u(0u);
    }
    let a = in_frame(r, t.a - from_center);
    let b = in_frame(r, t.b - from_center);
    let c = in_frame(r, t.c - from_center);
    let scale = vec3f(1.0, r.k, r.k);
    let ab = edge_heights(a, in_frame(r, t.b - t.a)) * scale;
    let bc = edge_heights(b, in_frame(r, t.c - t.b)) * scale;
    let ca = -edge_heights(a, in_frame(r, t.c - t.a)) * scale;
    // Where samples are over the plane: their distance, and what the receiver's height adds to it.
    let n = in_frame(r, t.plane.xyz);
    let own = dot(t.plane.xyz, from_center) - t.plane.w;
    let over = (n.zxy * scale) * r.light_distance + vec3f(own * soft.light.w, 0.0, 0.0);
    // On the side that the receiver is not on; on the plane is neither.
    let beyond = select(not_below(-over, round), not_below(over, round), side < 0);
    let in_ab = not_below(ab, round);
    let in_bc = not_below(bc, round);
    let out_ca = not_below(-ca, round);
    return beyond & ((in_ab & in_bc & ~out_ca) | (~in_ab & ~in_bc & out_ca));
}

// Samples that clusters `first` … `end` − 1 hide.
fn hidden_by_clusters(first: u32, end: u32, r: Receiver, round: Round) -> vec2u {
    var hidden = vec2u(0u);
    for (var number = first; number < end; number += 1u) {
        let cluster = soft_clusters[number];
        if !may_reach(cluster, r) {
            continue;
        }
        for (var triangle = cluster.first; triangle < cluster.end; triangle += 1u) {
            hidden |= hidden_by(triangle, r, round);
        }
    }
    return hidden;
}

// Samples that the casters hide.
fn hidden(r: Receiver, round: Round) -> vec2u {
    if !has_lists(r) {
        return hidden_by_clusters(0u, soft.cluster_count, r, round);
    }
    let dark = hidden_by_clusters(0u, soft.near_clusters, r, round);
    let cell = cell_of(r);
    if cell == NO_CELL {
        return dark;
    }
    for (var plane = 0u; plane < PLANES; plane += 1u) {
        counts[plane] = vec2u(0u);
    }
    add(vec2u(0xffffffffu), center_count(cell, r));
    add_edges(cell, r, round);
    var any_count = vec2u(0u);
    for (var plane = 0u; plane < PLANES; plane += 1u) {
        any_count |= counts[plane];
    }
    return dark | any_count;
}
#endif

// The share of the light's samples that reach the surface.
@fragment
fn sampled(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let depth = textureLoad(receiver_depth, pixel, 0);
    let normal = textureLoad(receiver_normals, pixel, 0);
    // Depth is reversed: 0 is infinitely far, where nothing is.
    if depth == 0.0 || normal.w == 0.0 {
        discard;
    }
    let r = receiver_at(position.xy, depth, normal.xyz);
    // Within the light, only the centre counts: a disc without extent.
    let sample_count = select(soft.sample_count, 1u, r.k == 0.0);
    var lit = 0u;
    for (var first = 0u; first < sample_count; first += 64u) {
        let round = Round(first, min(sample_count - first, 64u));
        // What lies in the surface's own plane is dark.
        var bits = ~not_below(-vec3f(r.normal.z, r.normal.xy * r.k), round);
        bits &= vec2u(
            select(0xffffffffu, (1u << round.count) - 1u, round.count < 32u),
            select(0xffffffffu, (1u << max(round.count, 32u) - 32u) - 1u, round.count < 64u),
        );
#if CASTERS
        if any(bits != vec2u(0u)) {
            bits &= ~hidden(r, round);
        }
#endif
        lit += countOneBits(bits.x) + countOneBits(bits.y);
    }
    if lit == sample_count {
        discard;
    }
    return vec4f(f32(lit) / f32(sample_count));
}
