// A light with a size and what casts before it, as one receiver's point sees them.
//
// Around the point p there is a frame (u, v, w): w points to the light's centre, u and v lie across. A sample (x, y) of the
// unit disc is seen in the direction (k·x, k·y, 1), k the disc's radius over its distance.

#import common/frame
#import common/receiver_depth

// Triangles that lie together, and the sphere around them.
struct SoftCluster {
    center: vec3f,
    radius_m: f32,
    first: u32,
    end: u32,
    caster: u32,
    pad_0: u32,
}

// A plane the light's centre looks through: a point goes to (d·x_axis, d·y_axis) / (d·z_axis + z_offset), d = point −
// origin, and what is in view is within −1 … 1.
struct GridPlane {
    x_axis: vec3f,
    x_length: f32,
    y_axis: vec3f,
    y_length: f32,
    z_axis: vec3f,
    z_offset: f32,
    // The direction along which things lie further from the light.
    away: vec3f,
    z_length: f32,
}

struct SoftHead {
    // The columns of the rotation that takes directions from view space to the world.
    world_x: vec3f,
    // 1, or 6: along +x, −x, +y, −y, +z, −z, each of which shows what lies within the pyramid |x|, |y| <= z.
    plane_count: u32,
    world_y: vec3f,
    // Cells along a side of a plane, for edges.
    side: u32,
    world_z: vec3f,
    slice_count: u32,
    // From the eye to the light's centre, 1; or the unit direction towards it, 0.
    light: vec4f,
    // From the eye to the planes' origin: the light where there are six, else the middle of the casters.
    origin: vec3f,
    // In metres, or the tangent of half the angle the light is seen under.
    radius: f32,
    // Of all clusters those at first that are not in the lists; and how many there are.
    near_clusters: u32,
    cluster_count: u32,
    // Cells along a side of a plane for triangles, and where their lists begin.
    triangle_side: u32,
    triangle_lists: u32,
    // Where the lists of near triangles begin, by directions from the light's centre; 0 where there are none.
    near_lists: u32,
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
    // Where slices end, as distances from the light, or along its direction from the planes' origin.
    slice_ends: array<vec4f, 2>,
    // From the eye to the middle of the only caster's bounds, and how far that is.
    center: vec4f,
    // The plane, where there is one.
    plane: GridPlane,
}

@group(1) @binding(0) var<storage, read> soft_head: SoftHead;
// Its copy, from the vertices: software adapters read storage word by word and pixel by pixel.
var<private> soft: SoftHead;

struct SoftVaryings {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, first) world_x: vec3f,
    @location(1) @interpolate(flat, first) world_y: vec3f,
    @location(2) @interpolate(flat, first) world_z: vec3f,
    @location(3) @interpolate(flat, first) light: vec4f,
    @location(4) @interpolate(flat, first) origin: vec4f,
    @location(5) @interpolate(flat, first) grid: vec4u,
    @location(6) @interpolate(flat, first) lists: vec4u,
    @location(7) @interpolate(flat, first) low_slices: vec4f,
    @location(8) @interpolate(flat, first) high_slices: vec4f,
    @location(9) @interpolate(flat, first) plane_x: vec3f,
    @location(10) @interpolate(flat, first) plane_y: vec3f,
    @location(11) @interpolate(flat, first) plane_z: vec4f,
    @location(12) @interpolate(flat, first) away: vec3f,
    @location(13) @interpolate(flat, first) center: vec4f,
}

// One triangle that covers the whole target, with what every pixel needs to know of the light.
@vertex
fn soft_vertex(@builtin(vertex_index) index: u32) -> SoftVaryings {
    let s = soft_head;
    var out: SoftVaryings;
    let corner = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    out.position = vec4f(corner * 2.0 - 1.0, 0.0, 1.0);
    out.world_x = s.world_x;
    out.world_y = s.world_y;
    out.world_z = s.world_z;
    out.light = s.light;
    out.origin = vec4f(s.origin, s.radius);
    out.grid = vec4u(s.plane_count, s.side, s.slice_count, s.triangle_side);
    out.lists = vec4u(s.near_clusters, s.cluster_count, s.triangle_lists, s.near_lists);
    out.low_slices = s.slice_ends[0];
    out.high_slices = s.slice_ends[1];
    out.plane_x = s.plane.x_axis;
    out.plane_y = s.plane.y_axis;
    out.plane_z = vec4f(s.plane.z_axis, s.plane.z_offset);
    out.away = s.plane.away;
    out.center = s.center;
    return out;
}

// What a fragment entry point begins with.
fn take_light(in: SoftVaryings) {
    soft.world_x = in.world_x;
    soft.world_y = in.world_y;
    soft.world_z = in.world_z;
    soft.light = in.light;
    soft.origin = in.origin.xyz;
    soft.radius = in.origin.w;
    soft.plane_count = in.grid.x;
    soft.side = in.grid.y;
    soft.slice_count = in.grid.z;
    soft.triangle_side = in.grid.w;
    soft.near_clusters = in.lists.x;
    soft.cluster_count = in.lists.y;
    soft.triangle_lists = in.lists.z;
    soft.near_lists = in.lists.w;
    soft.slice_ends[0] = in.low_slices;
    soft.slice_ends[1] = in.high_slices;
    soft.plane.x_axis = in.plane_x;
    soft.plane.y_axis = in.plane_y;
    soft.plane.z_axis = in.plane_z.xyz;
    soft.plane.z_offset = in.plane_z.w;
    soft.plane.away = in.away;
    soft.center = in.center;
}

#if CASTERS
// What follows is packed: texel i of it is at (i % 2048, i / 2048).
//
// An edge that can be a silhouette, in four texels. Positions and planes are relative to the caster's centre, directions
// those of the world.
// 0: its lower end a, in the order of coordinates, so that all that computes with it does so in one order; its caster.
// 1: its upper end b; bits: 0 and 1, the first and the second triangle run against it; 2, they count for points behind
//    them only; 5, before them only.
// 2, 3: unit normals and offsets of its one or two triangles; 0 where there is no second.
@group(1) @binding(1) var soft_edges: texture_2d<u32>;
// A triangle, in four texels.
// 0: corner a, its caster. 1: corner b; bits: 0, its plane faces the other way than a, b, c run; 2, it counts for points
// behind it only; 5, before it only; 3 and 4, the light's centre is before it, or behind. 2: corner c. 3: its plane. Corners are in the order
// of their coordinates.
@group(1) @binding(2) var soft_triangles: texture_2d<u32>;
// Words: for each cell, plane by plane, slice by slice and row by row, where the numbers of its edges begin, and where the
// last ones end; the same of triangles, without slices; then these numbers.
@group(1) @binding(3) var soft_lists: texture_2d<u32>;
#if ONE_CASTER
#else
// From the eye to the middle of each caster's bounds, and how far that is.
@group(1) @binding(5) var soft_centers: texture_2d<u32>;
#endif
#if CLUSTERS
@group(1) @binding(4) var<storage, read> soft_clusters: array<SoftCluster>;
#endif
#if BESIDE
// A triangle as the light's centre sees it, in six texels. 0, 1, 2: corners a, b and c relative to the centre; with a how high
// the centre is over its plane. 3, 4, 5: the moments a × b, b × c and a × c. All of them keep their digits however near the
// light is, which positions about the caster's middle do not.
@group(1) @binding(8) var soft_beside: texture_2d<u32>;
#endif
#endif
@group(1) @binding(6) var receiver_depth: texture_depth_2d;
@group(1) @binding(7) var receiver_planes: texture_2d<u32>;

// What rounding leaves of a height over a plane, relative to the distances of point and plane from the eye.
const ROUNDING: f32 = 6e-7;

// A visible point, and the light as it sees it.
struct Receiver {
    // From the eye, along the axes of the world.
    p: vec3f,
    // How far p may be off, along the view.
    step: vec3f,
    // Its distance from the eye.
    distance: f32,
    // The frame.
    u: vec3f,
    v: vec3f,
    w: vec3f,
    // The light's distance; 1 for a direction.
    light_distance: f32,
    // The disc's radius over its distance; 0 where only the centre counts.
    k: f32,
}

fn world_from_view(d: vec3f) -> vec3f {
    return soft.world_x * d.x + soft.world_y * d.y + soft.world_z * d.z;
}

// The point at `pixel`, whose depth is not 0, and where its light is. What depends on the frame is left out. It is so
// many times `as_far` from the eye as depth says.
fn receiver_at(pixel: vec2f, depth: f32, as_far: f32) -> Receiver {
    var r: Receiver;
    r.p = world_from_view(farther(view_from_pixel(pixel, depth), as_far));
    let offset = soft.light.xyz - r.p * soft.light.w;
    r.light_distance = length(offset);
    r.w = offset / r.light_distance;
    // The disc's radius R·d/sqrt(d² − R²) over d; for a direction d is 1 and the disc as large as it is.
    let tangent = (r.light_distance - soft.radius) * (r.light_distance + soft.radius);
    let k = select(0.0, soft.radius * inverseSqrt(max(tangent, 1e-37)), tangent > 0.0);
    r.k = select(soft.radius, k, soft.light.w > 0.0);
    return r;
}

// The same with its frame, and with how far it may be off, on a plane with this normal in view space.
fn with_frame(receiver: Receiver, pixel: vec2f, depth: f32, normal: vec3f, at: OnPlane) -> Receiver {
    var r = receiver;
    let p = farther(view_from_pixel(pixel, depth), at.farther);
    let step = (world_from_view(farther(deeper(pixel, depth), at.farther)) - r.p) * depth_loss(p, normal);
    r.step = step * max(1.0, at.uncertain_m / max(length(step), 1e-37));
    r.distance = length(r.p);
    // Unit axes across w: where it is +Y they are +X and −Z, from where the shortest turn takes them along.
    let across = r.w.x * r.w.x + r.w.z * r.w.z;
    let a = select(1.0 / (1.0 + r.w.y), (1.0 - r.w.y) / across, r.w.y < 0.0);
    let pole = r.w.y < 0.0 && across == 0.0;
    r.u = select(vec3f(1.0 - r.w.x * r.w.x * a, -r.w.x, -r.w.x * r.w.z * a), vec3f(1.0, 0.0, 0.0), pole);
    r.v = select(vec3f(r.w.x * r.w.z * a, r.w.z, r.w.z * r.w.z * a - 1.0), vec3f(0.0, 0.0, 1.0), pole);
    return r;
}

#if CASTERS
fn packed(words: texture_2d<u32>, texel: u32) -> vec4u {
    return textureLoad(words, vec2u(texel & 2047u, texel >> 11u), 0);
}

fn list_word(place: u32) -> u32 {
    let four = packed(soft_lists, place >> 2u);
    let two = select(four.xy, four.zw, (place & 2u) != 0u);
    return select(two.x, two.y, (place & 1u) != 0u);
}

fn center_of(caster: u32) -> vec4f {
#if ONE_CASTER
    return soft.center;
#else
    return bitcast<vec4f>(packed(soft_centers, caster));
#endif
}

// Part of the lists.
struct CellList {
    first: u32,
    end: u32,
}

// What may hide the light of a receiver.
struct Lists {
    edges: CellList,
    triangles: CellList,
    // Triangles that are in no other list.
    near: CellList,
    // So many clusters from the first.
    clusters: u32,
}

// The receiver's cell on a plane, of `side` cells along a side; nothing is listed where `inside` is false.
struct Cell {
    inside: bool,
    plane: u32,
    // From 0 to 1 across the plane.
    place: vec2f,
}

// Where a direction meets the cube of faces +x, −x, +y, −y, +z, −z: away from the middle first, then across and up.
struct OnCube {
    face: u32,
    place: vec3f,
}

fn on_cube(d: vec3f) -> OnCube {
    let size = abs(d);
    let second = size.y > size.x;
    let third = size.z > max(size.x, size.y);
    let axis = select(select(0u, 1u, second), 2u, third);
    let place = select(select(d.xyz, d.yzx, second), d.zxy, third);
    return OnCube(axis * 2u + select(0u, 1u, place.x < 0.0), vec3f(abs(place.x), place.yz));
}

fn cell_of(r: Receiver) -> Cell {
    let d = r.p - soft.origin;
    let cube = on_cube(d);
    let in_plane = vec3f(dot(soft.plane.z_axis, d) + soft.plane.z_offset, dot(soft.plane.x_axis, d), dot(soft.plane.y_axis, d));
    let six = soft.plane_count > 1u;
    let seen = select(in_plane, cube.place, six);
    let inside = seen.x > 0.0 && all(abs(seen.yz) <= vec2f(seen.x * 1.00001));
    return Cell(inside, select(0u, cube.face, six), seen.yz / seen.x * 0.5 + 0.5);
}

fn cell_number(cell: Cell, layer: u32, side: u32) -> u32 {
    let place = vec2u(clamp(cell.place * f32(side), vec2f(0.0), vec2f(f32(side) - 1.0)));
    return (layer * side + place.y) * side + place.x;
}

fn list_at(place: u32) -> CellList {
    return CellList(list_word(place), list_word(place + 1u));
}

// See near.rs of the technique.
const NEAR_SIDE: u32 = 12u;
const NEAR_MARGIN: f32 = 1e-3;

fn lists_of(r: Receiver) -> Lists {
    let none = CellList(0u, 0u);
    // Nearer than two radii to the light, all triangles are asked.
    if soft.light.w > 0.0 && r.light_distance < 2.0 * soft.radius {
        return Lists(none, none, none, soft.cluster_count);
    }
    // Near triangles are listed by the direction from the light, where that is known well enough.
    let from_light = on_cube(-r.w);
    let near_cell = Cell(true, from_light.face, from_light.place.yz / from_light.place.x * 0.5 + 0.5);
    let lost = ROUNDING * (2.0 * length(r.p) + r.light_distance);
    let is_listed = soft.near_lists > 0u && lost < NEAR_MARGIN * r.light_distance;
    let near_list = list_at(soft.near_lists + cell_number(near_cell, near_cell.plane, NEAR_SIDE));
    let near = CellList(select(0u, near_list.first, is_listed), select(0u, near_list.end, is_listed));
    let clusters = select(soft.near_clusters, 0u, is_listed);
    let cell = cell_of(r);
    if !cell.inside {
        return Lists(none, none, near, clusters);
    }
    let along = select(dot(soft.plane.away, r.p - soft.origin), r.light_distance, soft.light.w > 0.0);
    let before = vec4u(vec4f(along) > soft.slice_ends[0]) + vec4u(vec4f(along) > soft.slice_ends[1]);
    let slice = min(before.x + before.y + before.z + before.w, soft.slice_count - 1u);
    let edges = cell_number(cell, cell.plane * soft.slice_count + slice, soft.side);
    let triangles = soft.triangle_lists + cell_number(cell, cell.plane, soft.triangle_side);
    return Lists(list_at(edges), list_at(triangles), near, clusters);
}

// On which side of a plane the receiver is, `from_center` from the centre of the plane's caster: 0 when rounding cannot
// tell, as on the plane itself.
fn side_of(plane: vec4f, r: Receiver, from_center: vec3f, center_distance: f32) -> i32 {
    let height = fma(plane.x, from_center.x, fma(plane.y, from_center.y, fma(plane.z, from_center.z, -plane.w)));
    let along = fma(plane.x, r.step.x, fma(plane.y, r.step.y, plane.z * r.step.z));
    let uncertain = abs(along) + ROUNDING * (r.distance + center_distance);
    return select(select(0, -1, height < -uncertain), 1, height > uncertain);
}

// What a triangle on whose plane's side `side` the receiver is weighs.
fn weight_of(side: i32, bits: u32) -> i32 {
    return select(select(side, min(side, 0), (bits & 4u) != 0u), max(side, 0), (bits & 32u) != 0u);
}

// In the receiver's frame.
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

// A point of the frame as seen across the light's centre. None is seen on the axes or in the centre, but next to them, as if the
// centre were a little to the side: so edges that pass through it exactly, or along an axis, all agree on which side it is.
fn across(a: vec3f) -> vec2f {
    return select(a.xy, vec2f(1e-30, 1e-20), a.xy == vec2f(0.0));
}

// Whether the light's centre is on the left of an edge from a to b. Decided by the very numbers that say on which side of the
// axes a and b lie: only so do counts at the centre and from there on agree where the edge passes it within rounding.
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
    // From a to b, and from b to c.
    along_ab: vec3f,
    along_bc: vec3f,
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
    seen.ab = edge_heights(seen.a, seen.along_ab);
    seen.bc = edge_heights(seen.b, seen.along_bc);
    seen.ac = edge_heights(seen.a, in_frame(r, c - a));
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

// The same of a triangle that the light is beside, by what it is as the light sees it. Only where triangles are asked one by one:
// beside listed edges, on which side the centre is has to follow from their own numbers.
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
    seen.ac = edge_heights_about_light(beside(number, 5u).xyz, seen.along_ab + seen.along_bc, r);
    seen.left_of_ab = seen.ab.x >= 0.0;
    seen.left_of_bc = seen.bc.x >= 0.0;
    seen.left_of_ac = seen.ac.x >= 0.0;
    return seen;
}
#endif

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
