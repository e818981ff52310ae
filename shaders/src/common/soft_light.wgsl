// A light with a size and what casts before it, as one receiver's point sees them.
//
// Around the point p there is a frame (u, v, w): w points to the light's centre, u and v lie across. A sample (x, y) of the
// unit disc is seen in the direction (k·x, k·y, 1), k the disc's radius over its distance.

#import common/frame
#import common/receiver_depth

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
    // How many clusters, from the first, hold triangles that no list has; and how many clusters there are.
    near_clusters: u32,
    cluster_count: u32,
    // Cells along a side of a plane for triangles, and where their lists begin.
    triangle_side: u32,
    triangle_lists: u32,
    // Where the lists of near triangles begin, by directions from the light's centre; 0 where there are none.
    near_lists: u32,
    // Triangles with holes: where their lists begin, cells along a side of a plane for them, the first one's number, and after
    // the last one's.
    masked_lists: u32,
    masked_side: u32,
    first_masked: u32,
    end_masked: u32,
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
#if MASKS
    @location(14) @interpolate(flat, first) masked: vec4u,
#endif
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
#if MASKS
    out.masked = vec4u(s.masked_lists, s.masked_side, s.first_masked, s.end_masked);
#endif
    return out;
}

// Copies the light from the varyings: the first call of every fragment entry point.
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
#if MASKS
    soft.masked_lists = in.masked.x;
    soft.masked_side = in.masked.y;
    soft.first_masked = in.masked.z;
    soft.end_masked = in.masked.w;
#endif
}

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

// The point at `pixel`, whose depth is not 0, and the direction of its light, without the receiver's frame. `as_far` is the
// point's distance from the eye over the distance that depth gives.
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
