// The plane of a visible surface, how far its depth may be off, and the visible point found from both.

#import common/frame

// How many ulps the receiver's depth may be off: below the 64 that measures allow for.
const DEPTH_ULPS: u32 = 48u;
// And an orthographic depth, which is a difference of two numbers up to 1 whatever its own size: twenty-four roundings of 1, below the
// thirty-two that measures allow for.
const ORTHOGRAPHIC_LOSS: f32 = 1.4305115e-6;
// A rasteriser evaluates depth as a plane over the target: it loses some roundings of the largest depth that this plane has
// there. So many times one's own it may be before more ulps than DEPTH_ULPS are lost.
const STEEPEST_DEPTH: f32 = 16.0;

// The visible point as much nearer to the horizon as its depth may be off, from the eye, in view space.
fn deeper(pixel: vec2f, depth: f32) -> vec3f {
    let ulps = min(DEPTH_ULPS, bitcast<u32>(depth) - 1u);
    let ulps_deeper = bitcast<f32>(bitcast<u32>(depth) - ulps);
    return view_from_pixel(pixel, select(depth - ORTHOGRAPHIC_LOSS, ulps_deeper, frame.eye_w > 0.0));
}

// How many times as much the depth of a surface with this normal (in view space) may be off at the point `p`.
fn depth_loss(p: vec3f, normal: vec3f) -> f32 {
    // The plane's depth is proportional to normal·d in the direction d = (x, y, −1): largest at a corner of the target.
    let widest = abs(normal.x / frame.clip_from_view[0].x) + abs(normal.y / frame.clip_from_view[1].y) + abs(normal.z);
    let here = abs(dot(normal, p) / p.z);
    let steepness = widest / max(here, 1e-37);
    return select(1.0, max(1.0, steepness / STEEPEST_DEPTH), frame.eye_w > 0.0);
}

// The plane of the triangle that a pixel shows, in view space.
struct ReceiverPlane {
    // Unit, on the eye's side.
    normal: vec3f,
    // How high the plane is over the eye along the normal.
    offset_m: f32,
    // How far the triangle's nearest and farthest corner are; both 0 where it does not receive shadows.
    near_m: f32,
    far_m: f32,
}

// The axis along which a unit vector is longest: 0, 1 or 2; twice that, and 1 more where it points against it.
fn longest_axis(n: vec3f) -> u32 {
    let size = abs(n);
    let axis = select(select(0u, 1u, size.y > size.x), 2u, size.z > max(size.x, size.y));
    let along = select(select(n.x, n.y, axis == 1u), n.z, axis == 2u);
    return axis * 2u + select(0u, 1u, along < 0.0);
}

// The other two components of a unit vector, and the vector again: the longest, from a sum of squares, is as exact as they are.
fn beside_axis(n: vec3f, axis: u32) -> vec2f {
    return select(select(n.yz, n.zx, axis >> 1u == 1u), n.xy, axis >> 1u == 2u);
}

fn with_axis(others: vec2f, axis: u32) -> vec3f {
    let length = sqrt(max(1.0 - dot(others, others), 0.0));
    let along = select(length, -length, (axis & 1u) != 0u);
    let first = vec3f(along, others);
    return select(select(first, first.zxy, axis >> 1u == 1u), first.yzx, axis >> 1u == 2u);
}

// As a texel of the image of receivers' planes: four words, so that drawing it costs no more than a triangle's number. Of distances
// the first digits, rounded up.
fn packed_plane(plane: ReceiverPlane) -> vec4u {
    let axis = longest_axis(plane.normal);
    let near = (bitcast<u32>(plane.near_m) + 0x1ffffu) >> 17u;
    let far = (bitcast<u32>(plane.far_m) + 0xffffu) >> 16u;
    let others = bitcast<vec2u>(beside_axis(plane.normal, axis));
    return vec4u(others, bitcast<u32>(plane.offset_m), near | (far << 14u) | (axis << 29u));
}

fn unpacked_plane(texel: vec4u) -> ReceiverPlane {
    let normal = with_axis(bitcast<vec2f>(texel.xy), texel.w >> 29u);
    let near_m = bitcast<f32>((texel.w & 0x3fffu) << 17u);
    let far_m = bitcast<f32>(((texel.w >> 14u) & 0x7fffu) << 16u);
    return ReceiverPlane(normal, bitcast<f32>(texel.z), near_m, far_m);
}

// How far the visible point may be off along the view, relative to the distance of its triangle's farthest corner: what
// vertex shaders round of it, four roundings, and rasterisers lose when they cut the triangle at the picture's edges.
const CORNER_ROUNDING: f32 = 2.4e-7;
// What rounding leaves of how high a point is over a plane, relative to the distances of both.
const PLANE_ROUNDING: f32 = 6e-7;

// What depth and plane say of the visible point together.
struct OnPlane {
    // So many times as far from the eye it is as depth says.
    farther: f32,
    // How far it may then be off along the view.
    uncertain_m: f32,
}

// Of a triangle thinner than a pixel the depth is reckoned from edges that all but coincide, and the point it says, `p` in view
// space, is off the triangle's plane by more than rounding: there the plane says where it is.
fn on_plane(plane: ReceiverPlane, p: vec3f) -> OnPlane {
    let distance_m = select(abs(p.z), length(p), frame.eye_w > 0.0);
    let view = select(vec3f(0.0, 0.0, -1.0), p / max(distance_m, 1e-30), frame.eye_w > 0.0);
    let slope = max(abs(dot(plane.normal, view)), 1e-6);
    let off_plane_m = dot(plane.normal, p) - plane.offset_m;
    let lost_m = PLANE_ROUNDING * (plane.near_m + distance_m);
    let is_off = abs(off_plane_m) > 2.0 * lost_m;
    // Normals are on the eye's side: what is before the plane has to move on.
    let farther = select(1.0, 1.0 + off_plane_m / (slope * max(distance_m, 1e-30)), is_off);
    let uncertain_m = select(max(CORNER_ROUNDING * plane.far_m, 4.0 * abs(off_plane_m) / slope), lost_m / slope, is_off);
    return OnPlane(max(farther, 1e-3), uncertain_m);
}

// The point that depth says, so many times as far from the eye.
fn farther(p: vec3f, times: f32) -> vec3f {
    return select(vec3f(p.xy, p.z * times), p * times, frame.eye_w > 0.0);
}
