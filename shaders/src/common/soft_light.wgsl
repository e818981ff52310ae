// A light with a size and what casts before it, as one receiver's point sees them.
//
// Around the point p there is a frame (u, v, w): w points to the light's centre, u and v lie across. A sample (x, y) of the
// unit disc is seen in the direction (k·x, k·y, 1), k the disc's radius over its distance.

#import common/frame
#import common/fullscreen

// An edge that can be a silhouette. Positions and planes are relative to the caster's centre, directions those of the world.
struct SoftEdge {
    // Its ends, the lower first in the order of their coordinates: all that computes with it does so in one order.
    a: vec3f,
    caster: u32,
    b: vec3f,
    // Bit 0, bit 1: the first, the second triangle runs against it. Bit 2: they count for points behind them only.
    bits: u32,
    // Unit normals and offsets of its one or two triangles; 0 where there is no second.
    plane_1: vec4f,
    plane_2: vec4f,
}

struct SoftTriangle {
    // Its corners in the order of their coordinates.
    a: vec3f,
    caster: u32,
    b: vec3f,
    // Bit 0: its plane faces the other way than a, b, c run. Bit 2: it counts for points behind it only. Bits 3 and 4: the
    // light's centre is before it, or behind.
    bits: u32,
    c: vec3f,
    pad_0: u32,
    plane: vec4f,
}

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

struct SoftCasters {
    // The columns of the rotation that takes directions from view space to the world.
    world_x: vec3f,
    // 1, or 6: along +x, −x, +y, −y, +z, −z, each of which shows what lies within the pyramid |x|, |y| <= z.
    plane_count: u32,
    world_y: vec3f,
    // Cells along a side of a plane.
    side: u32,
    world_z: vec3f,
    slice_count: u32,
    // From the eye to the light's centre, 1; or the unit direction towards it, 0.
    light: vec4f,
    // From the eye to the planes' origin.
    origin: vec3f,
    // In metres, or the tangent of half the angle the light is seen under.
    radius: f32,
    // Of all clusters those at first that are not in the lists; and how many there are.
    near_clusters: u32,
    cluster_count: u32,
    sample_count: u32,
    pad_0: u32,
    // Where slices end, as distances from the light, or along its direction from the planes' origin.
    slice_ends: array<vec4f, 2>,
    planes: array<GridPlane, 6>,
    // From the eye to the middle of each caster's bounds, and how far that is.
    casters: array<vec4f>,
}

@group(1) @binding(0) var<storage, read> soft: SoftCasters;
#if CASTERS
@group(1) @binding(1) var<storage, read> soft_edges: array<SoftEdge>;
@group(1) @binding(2) var<storage, read> soft_triangles: array<SoftTriangle>;
// For each cell, plane by plane, slice by slice and row by row, where the numbers of its edges begin and where those of its
// triangles do; the end; then these.
@group(1) @binding(3) var<storage, read> soft_lists: array<u32>;
@group(1) @binding(4) var<storage, read> soft_clusters: array<SoftCluster>;
#endif
@group(1) @binding(6) var receiver_depth: texture_depth_2d;
@group(1) @binding(7) var receiver_normals: texture_2d<f32>;

// How many ulps the receiver's depth may be off: below the 64 that measures allow for.
const DEPTH_ULPS: u32 = 48u;
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
    // Unit normal on the eye's side, in the frame.
    normal: vec3f,
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

// The visible point `ulps` ulps of depth nearer to the horizon, from the eye, in view space.
fn deeper(pixel: vec2f, depth: f32) -> vec3f {
    if frame.eye_w > 0.0 {
        let ulps = min(DEPTH_ULPS, bitcast<u32>(depth) - 1u);
        return view_from_pixel(pixel, bitcast<f32>(bitcast<u32>(depth) - ulps));
    }
    // Orthographic depth is a difference of two numbers around 1: an ulp is one of 1.
    return view_from_pixel(pixel, depth - f32(DEPTH_ULPS) * 1.1920929e-7);
}

// The point at `pixel`, whose depth is not 0, and its light. `normal` is in view space.
fn receiver_at(pixel: vec2f, depth: f32, normal: vec3f) -> Receiver {
    var r: Receiver;
    r.p = world_from_view(view_from_pixel(pixel, depth));
    r.step = world_from_view(deeper(pixel, depth)) - r.p;
    r.distance = length(r.p);
    let offset = soft.light.xyz - r.p * soft.light.w;
    r.light_distance = length(offset);
    r.w = offset / r.light_distance;
    // Unit axes across w: where it is +Y they are +X and −Z, from where the shortest turn takes them along.
    let across = r.w.x * r.w.x + r.w.z * r.w.z;
    var a = 1.0 / (1.0 + r.w.y);
    if r.w.y < 0.0 {
        a = (1.0 - r.w.y) / across;
    }
    r.u = vec3f(1.0 - r.w.x * r.w.x * a, -r.w.x, -r.w.x * r.w.z * a);
    r.v = vec3f(r.w.x * r.w.z * a, r.w.z, r.w.z * r.w.z * a - 1.0);
    if r.w.y < 0.0 && across == 0.0 {
        r.u = vec3f(1.0, 0.0, 0.0);
        r.v = vec3f(0.0, 0.0, 1.0);
    }
    let n = world_from_view(normal);
    r.normal = vec3f(dot(n, r.u), dot(n, r.v), dot(n, r.w));
    r.k = soft.radius;
    if soft.light.w > 0.0 {
        // The disc's radius R·d/sqrt(d² − R²) over d.
        let tangent = (r.light_distance - soft.radius) * (r.light_distance + soft.radius);
        r.k = select(0.0, soft.radius * inverseSqrt(max(tangent, 1e-37)), tangent > 0.0);
    }
    return r;
}

#if CASTERS
// Whether lists hold for this receiver: nearer than two radii to the light, all triangles are asked.
fn has_lists(r: Receiver) -> bool {
    return soft.light.w == 0.0 || r.light_distance >= 2.0 * soft.radius;
}

// The number of the receiver's cell; none where nothing is listed.
const NO_CELL: u32 = 0xffffffffu;

fn cell_of(r: Receiver) -> u32 {
    let d = r.p - soft.origin;
    var plane_number = 0u;
    if soft.plane_count > 1u {
        let size = abs(d);
        var axis = select(0u, 1u, size.y > size.x);
        axis = select(axis, 2u, size.z > max(size.x, size.y));
        plane_number = axis * 2u + select(0u, 1u, d[axis] < 0.0);
    }
    let z = dot(soft.planes[plane_number].z_axis, d) + soft.planes[plane_number].z_offset;
    let xy = vec2f(dot(soft.planes[plane_number].x_axis, d), dot(soft.planes[plane_number].y_axis, d));
    if z <= 0.0 || any(abs(xy) > vec2f(z * 1.00001)) {
        return NO_CELL;
    }
    let side = f32(soft.side);
    let place = vec2u(clamp((xy / z * 0.5 + 0.5) * side, vec2f(0.0), vec2f(side - 1.0)));
    let along = select(dot(soft.planes[0].away, d), r.light_distance, soft.light.w > 0.0);
    let before = vec4u(vec4f(along) > soft.slice_ends[0]) + vec4u(vec4f(along) > soft.slice_ends[1]);
    let slice = min(before.x + before.y + before.z + before.w, soft.slice_count - 1u);
    return ((plane_number * soft.slice_count + slice) * soft.side + place.y) * soft.side + place.x;
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
    return select(side, min(side, 0), (bits & 4u) != 0u);
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

// How often an edge from a to b (in the frame) crosses the half axis +u upwards, as the receiver sees it along w.
fn axis_crossing(a: vec3f, b: vec3f, at_center: f32) -> i32 {
    let upward = a.y < 0.0 && b.y >= 0.0;
    let downward = a.y >= 0.0 && b.y < 0.0;
    return select(0, 1, upward && at_center >= 0.0) - select(0, 1, downward && at_center < 0.0);
}

// How many times a triangle hides the light's centre: 0 or 1, but where rounding cannot tell neighbours apart; there,
// and only there, their sum is right.
fn hides_center(number: u32, r: Receiver) -> i32 {
    let t = soft_triangles[number];
    let caster = soft.casters[t.caster];
    let from_center = r.p - caster.xyz;
    let side = side_of(t.plane, r, from_center, caster.w);
    let opposite = (side < 0 && (t.bits & 8u) != 0u) || (side > 0 && (t.bits & 16u) != 0u);
    if !opposite || weight_of(side, t.bits) == 0 {
        return 0;
    }
    let a = in_frame(r, t.a - from_center);
    let b = in_frame(r, t.b - from_center);
    let c = in_frame(r, t.c - from_center);
    let turns = axis_crossing(a, b, edge_heights(a, in_frame(r, t.b - t.a)).x)
        + axis_crossing(b, c, edge_heights(b, in_frame(r, t.c - t.b)).x)
        - axis_crossing(a, c, edge_heights(a, in_frame(r, t.c - t.a)).x);
    return select(-side, side, (t.bits & 1u) != 0u) * turns;
}

// How many triangles in the lists of `cell` hide the light's centre.
fn center_count(cell: u32, r: Receiver) -> i32 {
    var count = 0;
    let end = soft_lists[2u * cell + 2u];
    for (var place = soft_lists[2u * cell + 1u]; place < end; place += 1u) {
        count += hides_center(soft_lists[place], r);
    }
    return count;
}

// An edge in the receiver's frame.
struct SeenEdge {
    a: vec3f,
    b: vec3f,
    // See edge_heights; already for samples of the unit disc.
    heights: vec3f,
    // By how much the number of triangles before the light changes from its left to its right; 0 where it is none.
    weight: i32,
}

fn seen_edge(number: u32, r: Receiver) -> SeenEdge {
    let e = soft_edges[number];
    let caster = soft.casters[e.caster];
    let from_center = r.p - caster.xyz;
    let weight_1 = weight_of(side_of(e.plane_1, r, from_center, caster.w), e.bits);
    let weight_2 = weight_of(side_of(e.plane_2, r, from_center, caster.w), e.bits);
    var seen: SeenEdge;
    seen.weight = select(weight_1, -weight_1, (e.bits & 1u) != 0u) + select(weight_2, -weight_2, (e.bits & 2u) != 0u);
    seen.a = in_frame(r, e.a - from_center);
    seen.b = in_frame(r, e.b - from_center);
    let heights = edge_heights(seen.a, in_frame(r, e.b - e.a));
    seen.heights = vec3f(heights.x, heights.yz * r.k);
    return seen;
}

// Whether the line of these heights crosses the unit disc, or may.
fn crosses_disc(heights: vec3f) -> bool {
    return heights.x * heights.x <= dot(heights.yz, heights.yz) * 1.00001;
}

// Whether a sphere may reach into the cone from the receiver to the disc.
fn may_reach(cluster: SoftCluster, r: Receiver) -> bool {
    let caster = soft.casters[cluster.caster];
    let radius_m = cluster.radius_m + ROUNDING * (r.distance + caster.w);
    let d = in_frame(r, cluster.center + caster.xyz - r.p);
    let across = length(d.xy);
    // Over the cone's flank by less than the radius, and not wholly behind the point or beyond the disc.
    let beyond = select(d.z - radius_m * 1.00001 > r.light_distance, false, soft.light.w == 0.0);
    return across - r.k * d.z <= radius_m * sqrt(1.0 + r.k * r.k) * 1.00001 && d.z >= -radius_m * 1.00001 && !beyond;
}
#endif
