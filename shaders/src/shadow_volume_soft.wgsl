// The soft shadow of any triangles, sample by sample. At every pixel the visible point is rebuilt from its depth. For each
// sample of the light's disc it counts the triangles between: at the centre by the triangles listed there, and from
// there on by the edges between the centre and the sample. 64 samples are counted at a time, in bit planes: bit i of
// plane j is bit j of the count of sample i.

#import common/light_samples
#import common/soft_light
#import common/soft_seen
#import common/soft_near
#import common/soft_masks
#import common/soft_question

#if CASTERS
// Counts modulo 2^16, or with DEEP modulo 2^24: more than there are triangles. Signed sums come and go beneath. (No array:
// planes are to stay in registers.)
var<private> count_0: vec2u;
var<private> count_1: vec2u;
var<private> count_2: vec2u;
var<private> count_3: vec2u;
var<private> count_4: vec2u;
var<private> count_5: vec2u;
var<private> count_6: vec2u;
var<private> count_7: vec2u;
var<private> count_8: vec2u;
var<private> count_9: vec2u;
var<private> count_10: vec2u;
var<private> count_11: vec2u;
var<private> count_12: vec2u;
var<private> count_13: vec2u;
var<private> count_14: vec2u;
var<private> count_15: vec2u;
#if DEEP
var<private> count_16: vec2u;
var<private> count_17: vec2u;
var<private> count_18: vec2u;
var<private> count_19: vec2u;
var<private> count_20: vec2u;
var<private> count_21: vec2u;
var<private> count_22: vec2u;
var<private> count_23: vec2u;
#endif

// Adds 1 to the counts of the samples in `ones`, 2 to those in `twos`; subtracts where flip is not 0 but all ones. Of the two
// one is empty.
fn add(ones: vec2u, twos: vec2u, flip: vec2u) {
    var carry = ones & (count_0 ^ flip);
    count_0 ^= ones;
    carry |= twos;
    var next = carry & (count_1 ^ flip);
    count_1 ^= carry;
    carry = next & (count_2 ^ flip);
    count_2 ^= next;
    next = carry & (count_3 ^ flip);
    count_3 ^= carry;
    if (next.x | next.y) == 0u {
        return;
    }
    carry = next & (count_4 ^ flip);
    count_4 ^= next;
    next = carry & (count_5 ^ flip);
    count_5 ^= carry;
    carry = next & (count_6 ^ flip);
    count_6 ^= next;
    next = carry & (count_7 ^ flip);
    count_7 ^= carry;
    if (next.x | next.y) == 0u {
        return;
    }
    carry = next & (count_8 ^ flip);
    count_8 ^= next;
    next = carry & (count_9 ^ flip);
    count_9 ^= carry;
    carry = next & (count_10 ^ flip);
    count_10 ^= next;
    next = carry & (count_11 ^ flip);
    count_11 ^= carry;
    carry = next & (count_12 ^ flip);
    count_12 ^= next;
    next = carry & (count_13 ^ flip);
    count_13 ^= carry;
    carry = next & (count_14 ^ flip);
    count_14 ^= next;
    next = carry & (count_15 ^ flip);
    count_15 ^= carry;
#if DEEP
    carry = next & (count_16 ^ flip);
    count_16 ^= next;
    next = carry & (count_17 ^ flip);
    count_17 ^= carry;
    carry = next & (count_18 ^ flip);
    count_18 ^= next;
    next = carry & (count_19 ^ flip);
    count_19 ^= carry;
    carry = next & (count_20 ^ flip);
    count_20 ^= next;
    next = carry & (count_21 ^ flip);
    count_21 ^= carry;
    carry = next & (count_22 ^ flip);
    count_22 ^= next;
    next = carry & (count_23 ^ flip);
    count_23 ^= carry;
#endif
}

// Sets all counts to one number.
fn set_counts(count: i32) {
    count_0 = plane_of(count, 0u);
    count_1 = plane_of(count, 1u);
    count_2 = plane_of(count, 2u);
    count_3 = plane_of(count, 3u);
    count_4 = plane_of(count, 4u);
    count_5 = plane_of(count, 5u);
    count_6 = plane_of(count, 6u);
    count_7 = plane_of(count, 7u);
    count_8 = plane_of(count, 8u);
    count_9 = plane_of(count, 9u);
    count_10 = plane_of(count, 10u);
    count_11 = plane_of(count, 11u);
    count_12 = plane_of(count, 12u);
    count_13 = plane_of(count, 13u);
    count_14 = plane_of(count, 14u);
    count_15 = plane_of(count, 15u);
#if DEEP
    count_16 = plane_of(count, 16u);
    count_17 = plane_of(count, 17u);
    count_18 = plane_of(count, 18u);
    count_19 = plane_of(count, 19u);
    count_20 = plane_of(count, 20u);
    count_21 = plane_of(count, 21u);
    count_22 = plane_of(count, 22u);
    count_23 = plane_of(count, 23u);
#endif
}

fn plane_of(count: i32, plane: u32) -> vec2u {
    return vec2u(0u - ((u32(count) >> plane) & 1u));
}

// Samples with a count other than 0.
fn counted() -> vec2u {
    var counted = count_0 | count_1 | count_2 | count_3 | count_4 | count_5 | count_6 | count_7;
    counted |= count_8 | count_9 | count_10 | count_11 | count_12 | count_13 | count_14 | count_15;
#if DEEP
    counted |= count_16 | count_17 | count_18 | count_19 | count_20 | count_21 | count_22 | count_23;
#endif
    return counted;
}

// Counts what an edge changes between the centre and each sample.
fn add_edge(edge: SeenEdge, round: u32) {
    let flip = select(0xffffffffu, 0u, center_is_left(edge.a, edge.b));
    let crossed = samples_crossed(edge.heights, edge.a, edge.b, flip, round);
    let size = abs(edge.weight);
    let subtracts = select(flip, ~flip, edge.weight < 0);
    let nothing = vec2u(0u);
    add(select(nothing, crossed, size == 1), select(nothing, crossed, size == 2), vec2u(subtracts));
}

// Whether an edge lies beyond the disc, to one side of it along itself: no way from the centre to a sample crosses it,
// though its line does. Where light may be is a cone about the way to the centre, |x, y| ≤ k·depth; what reaches beyond
// it along one direction at both ends does so all along.
fn is_beside(edge: SeenEdge, k: f32) -> bool {
    let along = edge.b - edge.a;
    // With room for what positions lose by rounding.
    let reach = (edge.depths * (k * 1.0001) + abs(edge.depths) * 4e-6) * length(along);
    let places = vec2f(dot(edge.a, along), dot(edge.b, along));
    return all(places > reach) || all(-places > reach);
}

// The edge at a place of a list that ends at `end`.
fn listed_edge(place: u32, end: u32, r: Receiver) -> SeenEdge {
    var edge = seen_edge(list_word(min(place, end - 1u)), r);
    edge.weight = select(0, edge.weight, place < end);
    return edge;
}

// Counts what the listed edges change.
fn add_edges(list: CellList, r: Receiver, round: u32) {
    var place = list.first;
#if LONG_LISTS
    // Drivers may bound how often a shader goes round, all its loops together: to 65 535 times, Mesa's software one.
    while place < list.end {
        add_edge(listed_edge(place, list.end, r), round);
        add_edge(listed_edge(place + 1u, list.end, r), round);
        add_edge(listed_edge(place + 2u, list.end, r), round);
        add_edge(listed_edge(place + 3u, list.end, r), round);
        add_edge(listed_edge(place + 4u, list.end, r), round);
        add_edge(listed_edge(place + 5u, list.end, r), round);
        add_edge(listed_edge(place + 6u, list.end, r), round);
        add_edge(listed_edge(place + 7u, list.end, r), round);
        place += 8u;
    }
#else
    // Pixels that are drawn together look for the next edge that matters each by itself, and count it together.
    loop {
        var edge = no_edge();
        while place < list.end && edge.weight == 0 {
            edge = seen_edge(list_word(place), r);
            edge.weight = select(edge.weight, 0, is_beside(edge, r.k));
            place += 1u;
        }
        if edge.weight == 0 {
            break;
        }
        add_edge(edge, round);
    }
#endif
}

// Samples that a triangle hides, whether it stands before the light or in it. Here nothing is counted, so that solids are
// no other than soups.
fn hidden_by(t: SeenTriangle, r: Receiver, round: u32) -> vec2u {
    let scale = vec3f(1.0, r.k, r.k);
    // Over the plane: where samples are.
    let n = in_frame(r, t.plane.xyz);
    let over = vec3f(t.center_height, n.xy * (r.k * r.light_distance));
    // On the side that the receiver is not on.
    let beyond = samples_not_below(select(-over, over, t.side < 0), round);
    let in_ab = samples_not_below(t.ab * scale, round);
    let in_bc = samples_not_below(t.bc * scale, round);
    let out_ca = samples_not_below(t.ac * scale, round);
    let through = (in_ab & in_bc & ~out_ca) | (~in_ab & ~in_bc & out_ca);
    // Within the light, only the centre counts, and on which side of the plane it is, if on one, was found with all digits.
    let of_center = vec2u(select(0u, 1u, seen_hides_center(t) != 0), 0u);
    return select(select(beyond & through, of_center, r.k == 0.0), vec2u(0u), t.side == 0);
}

#if CLUSTERS
// Samples that the triangles hide that are tested one by one.
fn hidden_nearby(lists: Lists, r: Receiver, round: u32) -> vec2u {
    var hidden = vec2u(0u);
    var walk = near_walk(lists);
    loop {
        let t = next_near(&walk, r);
        if t.side == 0 {
            break;
        }
        hidden |= hidden_by(t, r, round);
    }
    return hidden;
}
#endif

#if MASKS
// Which of these samples a triangle with holes hides that is crossed on the way to them.
fn hidden_by_mask(number: u32, t: SeenTriangle, crossed: vec2u, r: Receiver, round: u32) -> vec2u {
    let mask = mask_of(number);
    var asked = crossed;
    var hidden = vec2u(0u);
    while (asked.x | asked.y) != 0u {
        // Several at a turn: drivers may bound how often a shader goes round.
        hidden |= next_hidden(&asked, mask, t, r, round);
        hidden |= next_hidden(&asked, mask, t, r, round);
        hidden |= next_hidden(&asked, mask, t, r, round);
        hidden |= next_hidden(&asked, mask, t, r, round);
    }
    return hidden;
}

// Takes the first of the asked samples, and gives it back if the mask has no hole on the way to it.
fn next_hidden(asked: ptr<function, vec2u>, mask: Mask, t: SeenTriangle, r: Receiver, round: u32) -> vec2u {
    let in_low = (*asked).x != 0u;
    let word = select((*asked).y, (*asked).x, in_low);
    if word == 0u {
        return vec2u(0u);
    }
    let bit = word & (0u - word);
    let bits = select(vec2u(0u, bit), vec2u(bit, 0u), in_low);
    *asked &= ~bits;
    let place = sample_place(round * 64u + firstTrailingBit(word) + select(32u, 0u, in_low)) * r.k;
    return select(bits, vec2u(0u), has_hole_towards(mask, t, place));
}

// Which of these samples triangles with holes hide.
fn hidden_by_masks(lists: Lists, samples: vec2u, r: Receiver, round: u32) -> vec2u {
    var seen = samples;
    for (var place = lists.masked.first; place < lists.masked.end && (seen.x | seen.y) != 0u; place += 1u) {
        let number = select(list_word(place), place, lists.masked_by_number);
#if BESIDE
        let t = seen_from_light(number, r);
#else
        let t = seen_triangle(number, r);
#endif
        if may_hide(t, r) {
            seen &= ~hidden_by_mask(number, t, hidden_by(t, r, round) & seen, r, round);
        }
    }
    return samples & ~seen;
}
#endif

// Those of the samples that the casters hide, of which `over_center` hide the centre.
fn hidden(r: Receiver, lists: Lists, samples: vec2u, over_center: i32, round: u32) -> vec2u {
    var dark = vec2u(0u);
#if CLUSTERS
    dark = hidden_nearby(lists, r, round);
#endif
    set_counts(over_center);
    add_edges(lists.edges, r, round);
    dark |= counted();
#if MASKS
    dark |= hidden_by_masks(lists, samples & ~dark, r, round);
#endif
    return dark;
}
#endif

// The share of the light's samples that reach the surface.
@fragment
fn sampled(in: SoftVaryings) -> @location(0) vec4f {
    take_light(in);
    let position = in.position;
    let q = question_at(position.xy);
    let r = with_frame(q.r, position.xy, textureLoad(receiver_depth, vec2u(position.xy), 0), q.normal, q.at);
    // Within the light, only the centre counts: a disc without extent.
    let sample_count = select(SAMPLE_COUNT, 1u, r.k == 0.0);
    // A centre that rounding may place in the surface's plane counts as in it. A step is many more ulps than depth loses, which
    // leaves room for what positions lose.
    let rounding = ROUNDING * (2.0 * r.distance + r.light_distance);
    let uncertain = max(abs(dot(q.n, r.step)), rounding) / r.light_distance;
    let height = q.height - select(0.0, uncertain, r.k == 0.0);
    let over = vec3f(height, dot(q.n, r.u) * r.k, dot(q.n, r.v) * r.k);
    var lit = 0u;
#if MASKS_ONLY
    var over_horizon = 0u;
#endif
#if CASTERS
    let over_center = center_count(q.lists.triangles, r);
#endif
    for (var round = 0u; round < ROUNDS; round += 1u) {
        var bits = select(samples_of(round), vec2u(select(0u, 1u, round == 0u), 0u), r.k == 0.0);
#if ON_LAYER
        // A transparent surface is lit from both sides.
#else
        // What lies in the surface's own plane is dark.
        bits &= ~samples_not_below(-over, round);
#endif
#if MASKS_ONLY
        over_horizon += countOneBits(bits.x) + countOneBits(bits.y);
#endif
#if CASTERS
        bits &= ~hidden(r, q.lists, bits, over_center, round);
#endif
        lit += countOneBits(bits.x) + countOneBits(bits.y);
    }
#if MASKS_ONLY
    // Of what another pass leaves of the light.
    return vec4f(select(f32(lit) / f32(over_horizon), 1.0, over_horizon == 0u));
#else
    return vec4f(f32(lit) / f32(sample_count));
#endif
}
