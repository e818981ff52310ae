// What is seen at every pixel: which triangle, for techniques, tests and reports; and its normal, for techniques.
// Vertices are pulled by index so that the triangle's number is known without any optional feature.

#import common/frame
#import common/positions
#if MASKED
#import common/attributes
#endif

@group(1) @binding(1) var<storage, read> indices: array<u32>;

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) @interpolate(flat, first) instance: u32,
    @location(1) @interpolate(flat, first) triangle: u32,
#if MASKED
    @location(2) uvs: Uvs,
    @location(3) alpha: f32,
#endif
#if NORMALS
    // The triangle's unit normal, and how far its farthest corner is; 0 where it does not receive shadows.
    @location(4) @interpolate(flat, first) normal: vec4f,
    // How high its plane is over the eye along the normal, and how far its nearest corner is: in metres.
    @location(5) @interpolate(flat, first) plane: vec2f,
#endif
}

#if NORMALS
fn largest(v: vec3f) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// Its direction, for a vector of any size; 1e-37 keeps zero from being divided by zero.
fn scaled(v: vec3f) -> vec3f {
    return v / max(largest(v), 1e-37);
}

// How far the visible point may be off along the view, relative to the distance of its triangle's farthest corner: what
// vertex shaders round of it, four roundings, and rasterisers lose when they cut the triangle at the picture's edges.
const CORNER_ROUNDING: f32 = 2.4e-7;
// What rounding leaves of how high a point is over a plane, relative to the distances of both.
const PLANE_ROUNDING: f32 = 6e-7;

// What fragments need to know of their triangle.
struct Plane {
    // Unit normal, in view space on the eye's side; and how far the farthest corner is.
    normal: vec4f,
    // How high the plane is over the eye along the normal, and how far the nearest corner is.
    offset: vec2f,
}

// The plane of the triangle that begins with this corner.
fn plane_of(instance: u32, first: u32) -> Plane {
    let a = local_position(indices[first]);
    let b = local_position(indices[first + 1u]);
    let c = local_position(indices[first + 2u]);
    // Edges are taken between positions as they are stored, and turned as directions: in view space the triangle's
    // distance would have cost their last digits. Scaled, so that no product leaves the range of f32.
    let ab_in_view = view_direction_from_local(instance, b - a);
    let bc_in_view = view_direction_from_local(instance, c - b);
    let ca_in_view = view_direction_from_local(instance, a - c);
    let size = max(max(largest(ab_in_view), largest(bc_in_view)), max(largest(ca_in_view), 1e-37));
    let ab = ab_in_view / size;
    let bc = bc_in_view / size;
    let ca = ca_in_view / size;
    // The product of the two shorter edges is the least rounded.
    let longest = max(dot(ab, ab), max(dot(bc, bc), dot(ca, ca)));
    var n = cross(scaled(ab), scaled(bc));
    if dot(ab, ab) == longest {
        n = cross(scaled(bc), scaled(ca));
    } else if dot(bc, bc) == longest {
        n = cross(scaled(ca), scaled(ab));
    }
    // Where it is, the nearest corner says: farther ones carry larger roundings.
    let a_in_view = view_from_local(instance, a);
    let b_in_view = view_from_local(instance, b);
    let c_in_view = view_from_local(instance, c);
    let squares = vec3f(dot(a_in_view, a_in_view), dot(b_in_view, b_in_view), dot(c_in_view, c_in_view));
    var nearest = select(a_in_view, b_in_view, squares.y < squares.x);
    nearest = select(nearest, c_in_view, squares.z < min(squares.x, squares.y));
    let towards_eye = select(vec3f(0.0, 0.0, 1.0), -nearest, frame.eye_w > 0.0);
    // Without an area it is seen nowhere; its normal is still one.
    n = normalize(select(scaled(n), vec3f(0.0, 0.0, 1.0), largest(n) < 1e-30));
    n = select(n, -n, dot(n, towards_eye) < 0.0);
    let far_m = max(sqrt(max(squares.x, max(squares.y, squares.z))), 1e-30);
    let near_m = sqrt(min(squares.x, min(squares.y, squares.z)));
    return Plane(vec4f(n, far_m), vec2f(dot(n, nearest), near_m));
}

// The normal of the visible point, as long as its distance is over the one that depth says; and how far it may be off along the
// view, 0 where it does not receive shadows. Of a triangle thinner than a pixel the depth is reckoned from edges that all but
// coincide, and the point it says is off the triangle's plane by more than rounding: there the plane says where it is.
fn surface_point(in: Varyings) -> vec4f {
    let p = view_from_pixel(in.clip.xy, in.clip.z);
    let distance_m = select(abs(p.z), length(p), frame.eye_w > 0.0);
    let view = select(vec3f(0.0, 0.0, -1.0), p / max(distance_m, 1e-30), frame.eye_w > 0.0);
    let slope = max(abs(dot(in.normal.xyz, view)), 1e-6);
    let off_plane_m = dot(in.normal.xyz, p) - in.plane.x;
    let lost_m = PLANE_ROUNDING * (in.plane.y + distance_m);
    let is_off = abs(off_plane_m) > 2.0 * lost_m;
    // Normals are on the eye's side: what is before the plane has to move on.
    let farther = select(1.0, 1.0 + off_plane_m / (slope * max(distance_m, 1e-30)), is_off);
    let uncertain_m = select(max(CORNER_ROUNDING * in.normal.w, 4.0 * abs(off_plane_m) / slope), lost_m / slope, is_off);
    return vec4f(in.normal.xyz * max(farther, 1e-3), select(0.0, uncertain_m, in.normal.w > 0.0));
}
#endif

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let vertex = indices[corner];
    var out: Varyings;
    out.clip = clip_from_local(instance, local_position(vertex));
    out.instance = instance;
    out.triangle = corner / 3u;
#if MASKED
    out.uvs = vertex_uvs(vertex);
    out.alpha = vertex_alpha(vertex);
#endif
#if NORMALS
    let first = corner - corner % 3u;
    let receives = (instances[instance].flags & 1u) != 0u;
    let plane = plane_of(instance, first);
    out.normal = vec4f(plane.normal.xyz, select(0.0, plane.normal.w, receives));
    out.plane = plane.offset;
#endif
    return out;
}

@fragment
#if HALVES
// For targets whose channels have 16 bits: low then high.
fn visible_triangle(in: Varyings) -> @location(0) vec4u {
#else
fn visible_triangle(in: Varyings) -> @location(0) vec2u {
#endif
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
#if HALVES
    return vec4u(in.instance & 0xffffu, in.instance >> 16u, in.triangle & 0xffffu, in.triangle >> 16u);
#else
    return vec2u(in.instance, in.triangle);
#endif
}

#if NORMALS
// Its normal, and how far the visible point may be off along the view; 0 where the surface does not receive shadows.
@fragment
fn receiver_normal(in: Varyings) -> @location(0) vec4f {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    return surface_point(in);
}

struct TriangleAndNormal {
    @location(0) triangle: vec2u,
    @location(1) normal: vec4f,
}

@fragment
fn triangle_and_normal(in: Varyings) -> TriangleAndNormal {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    return TriangleAndNormal(vec2u(in.instance, in.triangle), surface_point(in));
}
#endif
