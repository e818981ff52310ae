// The triangles and edges of the casters as one receiver sees them: in its frame, with the side of each plane that it is on.

#import common/soft_light
#import common/soft_lists

#if CASTERS
// An edge that can be a silhouette, in four texels. Positions and planes are relative to the caster's centre, directions
// those of the world.
// 0: its lower end a, in the order of coordinates, so that all that computes with it does so in one order; its caster.
// 1: its upper end b; bits: 0 and 1, the first and the second triangle run against it; 2, they count for points behind
//    them only; 5, before them only.
// 2, 3: unit normals and offsets of its one or two triangles; 0 where there is no second.
@group(1) @binding(1) var soft_edges: texture_2d<u32>;
// A triangle, in four texels.
// 0: corner a, its caster. 1: corner b; bits: 0, its plane faces the other way than a, b, c run; 2, it counts for points
// behind it only; 5, before it only; 3 and 4, the light's centre is before it, or behind. 2: corner c. 3: its plane. Corners
// are in the order of their coordinates.
@group(1) @binding(2) var soft_triangles: texture_2d<u32>;
#if ONE_CASTER
#else
// From the eye to the middle of each caster's bounds, and how far that is.
@group(1) @binding(5) var soft_centers: texture_2d<u32>;
#endif
#if BESIDE
// A triangle as the light's centre sees it, in six texels. 0, 1, 2: corners a, b and c relative to the centre; with a how high
// the centre is over its plane. 3, 4, 5: the moments a × b, b × c and a × c. All of them keep their digits however near the
// light is, which positions about the caster's middle do not.
@group(1) @binding(8) var soft_beside: texture_2d<u32>;
#endif

fn center_of(caster: u32) -> vec4f {
#if ONE_CASTER
    return soft.center;
#else
    return bitcast<vec4f>(packed(soft_centers, caster));
#endif
}

// On which side of a plane the receiver is, `from_center` from the centre of the plane's caster: 0 when rounding cannot
// tell, as on the plane itself.
fn side_of(plane: vec4f, r: Receiver, from_center: vec3f, center_distance: f32) -> i32 {
    let height = fma(plane.x, from_center.x, fma(plane.y, from_center.y, fma(plane.z, from_center.z, -plane.w)));
    let along = fma(plane.x, r.step.x, fma(plane.y, r.step.y, plane.z * r.step.z));
    let uncertain = abs(along) + ROUNDING * (r.distance + center_distance);
    return select(select(0, -1, height < -uncertain), 1, height > uncertain);
}

// The weight of a triangle in the count, the receiver being on this side of its plane.
fn weight_of(side: i32, bits: u32) -> i32 {
    return select(select(side, min(side, 0), (bits & 4u) != 0u), max(side, 0), (bits & 32u) != 0u);
}

// A direction of the world in the receiver's frame.
fn in_frame(r: Receiver, d: vec3f) -> vec3f {
    return vec3f(
        fma(r.u.x, d.x, fma(r.u.y, d.y, r.u.z * d.z)),
        fma(r.v.x, d.x, fma(r.v.y, d.y, r.v.z * d.z)),
        fma(r.w.x, d.x, fma(r.w.y, d.y, r.w.z * d.z)),
    );
}

// Of the plane through the receiver and an edge from a along d (in the frame), what a direction (x, y, 1) has for height:
// (at the centre, for x, for y). Positive to the left of the edge as the receiver sees it.
fn edge_heights(a: vec3f, d: vec3f) -> vec3f {
    return vec3f(
        fma(a.x, d.y, -(a.y * d.x)),
        fma(a.y, d.z, -(a.z * d.y)),
        fma(a.z, d.x, -(a.x * d.z)),
    );
}

// A point of the frame, across the light's centre. A point exactly in the centre or on an axis is moved a little beside it, so
// that all edges through such a point agree on which side of them the centre lies.
fn across(a: vec3f) -> vec2f {
    return select(a.xy, vec2f(1e-30, 1e-20), a.xy == vec2f(0.0));
}

// Whether the light's centre is on the left of an edge from a to b. Computed from the same numbers as the sides of the axes on
// which a and b lie, so that counts at the centre and from there on agree where the edge passes it within rounding.
fn center_is_left(a: vec2f, b: vec2f) -> bool {
    return fma(a.x, b.y, -(a.y * b.x)) >= 0.0;
}

// How often an edge from a to b (across the centre) crosses the half axis +u upwards, as the receiver sees it along w, with the
// centre on its `left` or not.
fn axis_crossing(a: vec2f, b: vec2f, left: bool) -> i32 {
    let upward = a.y < 0.0 && b.y >= 0.0;
    let downward = a.y >= 0.0 && b.y < 0.0;
    return select(0, 1, upward && left) - select(0, 1, downward && !left);
}

// A triangle in the receiver's frame.
struct SeenTriangle {
    a: vec3f,
    b: vec3f,
    c: vec3f,
    // From a to b, from b to c, and from a to c: each a difference of corners, as any triangle at that edge has it.
    along_ab: vec3f,
    along_bc: vec3f,
    along_ac: vec3f,
    // Edges a → b, b → c and a → c: see edge_heights; and whether the light's centre is on the left of them.
    ab: vec3f,
    bc: vec3f,
    ac: vec3f,
    left_of_ab: bool,
    left_of_bc: bool,
    left_of_ac: bool,
    // The side of its plane that the receiver is on.
    side: i32,
    bits: u32,
    plane: vec4f,
    // From the middle of the caster's bounds to the receiver.
    from_center: vec3f,
    // How high the light's centre is over its plane, in metres.
    center_height: f32,
}

fn seen_triangle(number: u32, r: Receiver) -> SeenTriangle {
    let first = packed(soft_triangles, number * 4u);
    let second = packed(soft_triangles, number * 4u + 1u);
    let a = bitcast<vec3f>(first.xyz);
    let b = bitcast<vec3f>(second.xyz);
    let c = bitcast<vec3f>(packed(soft_triangles, number * 4u + 2u).xyz);
    let caster = center_of(first.w);
    var seen: SeenTriangle;
    seen.plane = bitcast<vec4f>(packed(soft_triangles, number * 4u + 3u));
    seen.from_center = r.p - caster.xyz;
    seen.side = side_of(seen.plane, r, seen.from_center, caster.w);
    seen.bits = second.w;
    let height = dot(seen.plane.xyz, seen.from_center) - seen.plane.w;
    seen.center_height = dot(seen.plane.xyz, r.w) * r.light_distance + height * soft.light.w;
    seen.a = in_frame(r, a - seen.from_center);
    seen.b = in_frame(r, b - seen.from_center);
    seen.c = in_frame(r, c - seen.from_center);
    seen.along_ab = in_frame(r, b - a);
    seen.along_bc = in_frame(r, c - b);
    seen.along_ac = in_frame(r, c - a);
    seen.ab = edge_heights(seen.a, seen.along_ab);
    seen.bc = edge_heights(seen.b, seen.along_bc);
    seen.ac = edge_heights(seen.a, seen.along_ac);
    seen.left_of_ab = center_is_left(across(seen.a), across(seen.b));
    seen.left_of_bc = center_is_left(across(seen.b), across(seen.c));
    seen.left_of_ac = center_is_left(across(seen.a), across(seen.c));
    return seen;
}

#if BESIDE
// As edge_heights, of an edge along d (in the frame) with this moment about the light's centre, which lies on the frame's axis.
fn edge_heights_about_light(moment: vec3f, d: vec3f, r: Receiver) -> vec3f {
    let m = in_frame(r, moment);
    return vec3f(m.z, fma(-r.light_distance, d.y, m.x), fma(r.light_distance, d.x, m.y));
}

fn beside(number: u32, part: u32) -> vec4f {
    return bitcast<vec4f>(packed(soft_beside, number * 6u + part));
}

// The same of a triangle that the light is beside, from its records relative to the light. Only for triangles that are tested
// one by one: where edges are listed, the centre's side must follow from the edges' own numbers.
fn seen_from_light(number: u32, r: Receiver) -> SeenTriangle {
    var seen = seen_triangle(number, r);
    let from_light = beside(number, 0u);
    let to_light = vec3f(0.0, 0.0, r.light_distance);
    seen.center_height = from_light.w;
    seen.a = in_frame(r, from_light.xyz) + to_light;
    seen.b = in_frame(r, beside(number, 1u).xyz) + to_light;
    seen.c = in_frame(r, beside(number, 2u).xyz) + to_light;
    seen.ab = edge_heights_about_light(beside(number, 3u).xyz, seen.along_ab, r);
    seen.bc = edge_heights_about_light(beside(number, 4u).xyz, seen.along_bc, r);
    seen.ac = edge_heights_about_light(beside(number, 5u).xyz, seen.along_ac, r);
    seen.left_of_ab = seen.ab.x >= 0.0;
    seen.left_of_bc = seen.bc.x >= 0.0;
    seen.left_of_ac = seen.ac.x >= 0.0;
    return seen;
}
#endif

// Whether a triangle may hide a part of the light.
fn may_hide(t: SeenTriangle, r: Receiver) -> bool {
    // Its three edges one way round. What lies left of one as a whole and right of another lies outside.
    let heights = vec3f(t.ab.x, t.bc.x, -t.ac.x);
    let reach = r.k * vec3f(length(t.ab.yz), length(t.bc.yz), length(t.ac.yz)) * 1.00001;
    let is_outside = any(heights > reach) && any(heights < -reach);
    let farthest = max(t.a.z, max(t.b.z, t.c.z));
    let nearest = min(t.a.z, min(t.b.z, t.c.z));
    let is_beyond = soft.light.w > 0.0 && nearest >= r.light_distance;
    return t.side != 0 && !is_outside && farthest > 0.0 && !is_beyond;
}

// How many times a triangle hides the light's centre: 0 or 1, but where rounding cannot tell neighbours apart; there,
// and only there, their sum is right.
fn hides_center(number: u32, r: Receiver) -> i32 {
    return seen_hides_center(seen_triangle(number, r));
}

fn seen_hides_center(t: SeenTriangle) -> i32 {
    let opposite = (t.side < 0 && (t.bits & 8u) != 0u) || (t.side > 0 && (t.bits & 16u) != 0u);
    let a = across(t.a);
    let b = across(t.b);
    let c = across(t.c);
    let turns = axis_crossing(a, b, t.left_of_ab) + axis_crossing(b, c, t.left_of_bc) - axis_crossing(a, c, t.left_of_ac);
    let weight = select(0, weight_of(t.side, t.bits), opposite);
    return select(-weight, weight, (t.bits & 1u) != 0u) * turns;
}

#if LONG_LISTS
// The same of the triangle at a place of a list that ends at `end`.
fn listed_over_center(place: u32, end: u32, r: Receiver) -> i32 {
    return select(0, hides_center(list_word(min(place, end - 1u)), r), place < end);
}
#endif

// How many of the listed triangles hide the light's centre.
fn center_count(list: CellList, r: Receiver) -> i32 {
    var count = 0;
#if LONG_LISTS
    for (var place = list.first; place < list.end; place += 8u) {
        count += hides_center(list_word(place), r) + listed_over_center(place + 1u, list.end, r)
            + listed_over_center(place + 2u, list.end, r) + listed_over_center(place + 3u, list.end, r)
            + listed_over_center(place + 4u, list.end, r) + listed_over_center(place + 5u, list.end, r)
            + listed_over_center(place + 6u, list.end, r) + listed_over_center(place + 7u, list.end, r);
    }
#else
    for (var place = list.first; place < list.end; place += 1u) {
        count += hides_center(list_word(place), r);
    }
#endif
    return count;
}

// An edge in the receiver's frame.
struct SeenEdge {
    // Its ends across the light's centre.
    a: vec2f,
    b: vec2f,
    // How far these are along the way to it.
    depths: vec2f,
    // See edge_heights; already for samples of the unit disc.
    heights: vec3f,
    // By how much the number of triangles before the light changes from the left of the edge to its right; 0 also where its
    // line does not cross the disc.
    weight: i32,
}

fn no_edge() -> SeenEdge {
    return SeenEdge(vec2f(0.0), vec2f(0.0), vec2f(0.0), vec3f(0.0), 0);
}

fn seen_edge(number: u32, r: Receiver) -> SeenEdge {
    let first = packed(soft_edges, number * 4u);
    let second = packed(soft_edges, number * 4u + 1u);
    let plane_1 = bitcast<vec4f>(packed(soft_edges, number * 4u + 2u));
    let plane_2 = bitcast<vec4f>(packed(soft_edges, number * 4u + 3u));
    let caster = center_of(first.w);
    let bits = second.w;
    let from_center = r.p - caster.xyz;
    let weight_1 = weight_of(side_of(plane_1, r, from_center, caster.w), bits);
    let weight_2 = weight_of(side_of(plane_2, r, from_center, caster.w), bits);
    let weight = select(weight_1, -weight_1, (bits & 1u) != 0u) + select(weight_2, -weight_2, (bits & 2u) != 0u);
    let a_in_world = bitcast<vec3f>(first.xyz);
    let b_in_world = bitcast<vec3f>(second.xyz);
    let a = in_frame(r, a_in_world - from_center);
    let b = in_frame(r, b_in_world - from_center);
    let along = edge_heights(a, in_frame(r, b_in_world - a_in_world));
    let heights = vec3f(along.x, along.yz * r.k);
    return SeenEdge(across(a), across(b), vec2f(a.z, b.z), heights, select(0, weight, crosses_disc(heights)));
}

// Whether the line of these heights crosses the unit disc, or may.
fn crosses_disc(heights: vec3f) -> bool {
    return heights.x * heights.x <= dot(heights.yz, heights.yz) * 1.00001;
}
#endif
