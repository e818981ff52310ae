// What is seen at every pixel: which triangle, for techniques, tests and reports; and its plane, for techniques.
// Vertices are pulled by index so that the triangle's number is known without any optional feature.

#import common/frame
#import common/positions
#if PLANES
#import common/receiver_depth
#endif
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
#if PLANES
    @location(4) @interpolate(flat, first) plane: vec4u,
#endif
}

#if PLANES
fn largest(v: vec3f) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// Its direction, for a vector of any size; 1e-37 keeps zero from being divided by zero.
fn scaled(v: vec3f) -> vec3f {
    return v / max(largest(v), 1e-37);
}

// The plane of the triangle that begins with this corner.
fn plane_of(instance: u32, first: u32) -> ReceiverPlane {
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
    // The offset is taken from the nearest corner: farther ones carry larger roundings.
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
    // As it is unpacked.
    let axis = longest_axis(n);
    n = with_axis(beside_axis(n, axis), axis);
    let far_m = max(sqrt(max(squares.x, max(squares.y, squares.z))), 1e-30);
    let near_m = max(sqrt(min(squares.x, min(squares.y, squares.z))), 1e-30);
    return ReceiverPlane(n, dot(n, nearest), near_m, far_m);
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
#if PLANES
    var plane = plane_of(instance, corner - corner % 3u);
    let receives = (instances[instance].flags & 1u) != 0u;
    plane.near_m = select(0.0, plane.near_m, receives);
    plane.far_m = select(0.0, plane.far_m, receives);
    out.plane = packed_plane(plane);
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

#if PLANES
// Of a plane, for targets whose channels have 16 bits: low then high of its first two words, and of its last two.
struct PlaneHalves {
    @location(0) first: vec4u,
    @location(1) last: vec4u,
}

@fragment
fn plane_halves(in: Varyings) -> PlaneHalves {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    let low = in.plane & vec4u(0xffffu);
    let high = in.plane >> vec4u(16u);
    return PlaneHalves(vec4u(low.x, high.x, low.y, high.y), vec4u(low.z, high.z, low.w, high.w));
}

// Its plane, packed; 0 in the last word where the surface does not receive shadows.
@fragment
fn receiver_plane(in: Varyings) -> @location(0) vec4u {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    return in.plane;
}

struct TriangleAndPlane {
    @location(0) triangle: vec2u,
    @location(1) plane: vec4u,
}

@fragment
fn triangle_and_plane(in: Varyings) -> TriangleAndPlane {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    return TriangleAndPlane(vec2u(in.instance, in.triangle), in.plane);
}
#endif
