// Which triangles can block which light rays: lists of them for the cells of a grid the light looks through, made on
// the CPU, and the exact test of a receiver's segment to the light against one of them.

#import common/frame
#import common/receiver_depth

// What a triangle hides from the light: the planes through the light and an edge, as (normal, offset) relative to the
// caster's centre. The line from a point to the light passes through the triangle where none of the three is negative.
// Neighbours hold the same numbers with opposite signs, so no line slips between them. Directions are those of the
// world.
struct ListedCone {
    bc: vec4f,
    ca: vec4f,
    ab: vec4f,
    caster: u32,
    // Bits 0 to 2: of a line that meets the edge opposite a, b, c itself, this triangle has it; its neighbour does not.
    owned_edges: u32,
    pad_0: u32,
    pad_1: u32,
}

// A plane the light looks through: a point goes to (d·x_axis, d·y_axis) / (d·z_axis + z_offset), d = point − origin,
// and what is in view is within −1 … 1.
struct GridPlane {
    x_axis: vec3f,
    // Of x_axis and z_axis together.
    x_length: f32,
    y_axis: vec3f,
    // Of y_axis and z_axis together.
    y_length: f32,
    z_axis: vec3f,
    z_offset: f32,
    // The direction along which things lie further from the light.
    away: vec3f,
    z_length: f32,
}

// From where the eye and the light look.
struct ListView {
    // The columns of the rotation that takes directions from view space to the world.
    world_x: vec3f,
    // 1, or 6 of which each shows what lies within the pyramid |x|, |y| <= z.
    plane_count: u32,
    world_y: vec3f,
    // From the eye to the planes' origin, and to the end of the casters, together.
    reach_m: f32,
    world_z: vec3f,
    pad_0: f32,
    // From the eye to the planes' origin.
    origin: vec3f,
    pad_1: f32,
    planes: array<GridPlane, 6>,
}

@group(1) @binding(0) var<storage, read> lists_seen: ListView;
@group(1) @binding(1) var<storage, read> cones: array<ListedCone>;
// How many cells a side of a plane has; where each cell's list begins; where the last one ends; for each triangle of a
// list its number, and how far from the light it begins. The nearest comes first.
@group(1) @binding(3) var<storage, read> lists: array<u32>;
@group(1) @binding(4) var receiver_depth: texture_depth_2d;

// What rounding leaves of a difference of positions around the eye, relative to their distance.
const ROUNDING: f32 = 4e-7;
// How far a point may be from where its cell is looked up, relative to all distances that go into it. Projecting it and
// testing it against a cone's planes are two dozen roundings of 2^-24 each; this is 64.
const CELL_ROUNDING: f32 = 3.8e-6;
const TINY: f32 = 1e-30;

// A visible point.
struct Receiver {
    // In pixels, and its depth.
    pixel: vec2f,
    depth: f32,
    // From the eye, along the axes of the world.
    p: vec3f,
    // The direction in which its surface faces, as far as the pixels next to it tell.
    normal: vec3f,
}

fn world_from_view(d: vec3f) -> vec3f {
    return lists_seen.world_x * d.x + lists_seen.world_y * d.y + lists_seen.world_z * d.z;
}

// The visible point of a pixel that is not empty. Pixels ask it together, as derivatives are.
fn receiver_at(pixel: vec2f, depth: f32) -> Receiver {
    let p = world_from_view(view_from_pixel(pixel, depth));
    let normal = cross(dpdx(p), dpdy(p));
    return Receiver(pixel, depth, p, normal / max(length(normal), 1e-37));
}

// The cells of one plane in which a receiver may be seen: columns and rows, the last included.
struct Cells {
    none: bool,
    low: vec2u,
    high: vec2u,
    // What begins further from the light than this cannot block it.
    distance: f32,
}

fn cells_of(receiver: Receiver, plane_number: u32) -> Cells {
    let plane = lists_seen.planes[plane_number];
    let side = f32(lists[0]);
    let d = receiver.p - lists_seen.origin;
    let uncertain_m = CELL_ROUNDING * (length(receiver.p) + lists_seen.reach_m);
    let h = vec3f(dot(plane.x_axis, d), dot(plane.y_axis, d), dot(plane.z_axis, d) + plane.z_offset);
    let uncertain_z = uncertain_m * plane.z_length;
    let beside = select(0.0, max(abs(h.x), abs(h.y)) - 2.0 * uncertain_z, lists_seen.plane_count > 1u);
    let ndc = h.xy / max(h.z, TINY);
    let uncertain = vec2f(plane.x_length, plane.y_length) * (uncertain_m / max(h.z - uncertain_z, TINY));
    // No difference of infinities: what is that far out is clamped anyway.
    let middle = clamp(ndc, vec2f(-1e9), vec2f(1e9));
    let reach = min(uncertain, vec2f(2e9));
    // Every caster is within the planes' view.
    let outside = h.z + uncertain_z <= max(beside, 0.0) || any(abs(middle) - reach > vec2f(1.00001));
    let last = vec2f(side - 1.0);
    let low = clamp(floor(((middle - reach) * 0.5 + 0.5) * side), vec2f(0.0), last);
    let high = clamp(floor(((middle + reach) * 0.5 + 0.5) * side), vec2f(0.0), last);
    return Cells(outside, vec2u(low), vec2u(high), dot(plane.away, d) + uncertain_m);
}

// The number of a cell in the lists.
fn cell_number(plane: u32, column: u32, row: u32) -> u32 {
    return (plane * lists[0] + row) * lists[0] + column;
}

// How far the line from a receiver (relative to the caster's centre) to the light passes inside each edge of a triangle.
// These are proportional to the weights of corners a, b and c where it crosses.
fn inside_edges(cone: ListedCone, from_center: vec3f) -> vec3f {
    return vec3f(
        dot(cone.bc.xyz, from_center) + cone.bc.w,
        dot(cone.ca.xyz, from_center) + cone.ca.w,
        dot(cone.ab.xyz, from_center) + cone.ab.w,
    );
}

// A rasteriser's corners lie on a grid of 1/256 pixel, and where it cuts a triangle at the picture's edges the new ones do as well:
// the plane of its depths may be beside the surface by half of that.
const SNAP_PX: f32 = 0.001953125;
// What is turned against a triangle by more does not lie in its plane.
const SAME_DIRECTION: f32 = 0.015625;

// Whether a receiver lies strictly behind a triangle through `corner` (from the eye), wherever within the uncertainty of
// its depth it is: else it may lie on the triangle itself.
fn is_behind(receiver: Receiver, corner: vec3f, away: vec3f) -> bool {
    let height = dot(away, receiver.p - corner);
    let seen = view_from_pixel(receiver.pixel, receiver.depth);
    let step = world_from_view(deeper(receiver.pixel, receiver.depth) - seen);
    let away_in_view = vec3f(dot(away, lists_seen.world_x), dot(away, lists_seen.world_y), dot(away, lists_seen.world_z));
    let turned = cross(away, receiver.normal);
    let snap_px = select(0.0, SNAP_PX, dot(turned, turned) <= SAME_DIRECTION * SAME_DIRECTION);
    let beside = abs(view_from_pixel(receiver.pixel + vec2f(snap_px), receiver.depth) - seen);
    let uncertain = abs(dot(away, step)) * depth_loss(seen, away_in_view) + dot(abs(away_in_view.xy), beside.xy)
        + ROUNDING * (length(receiver.p) + length(corner));
    return height > uncertain;
}
