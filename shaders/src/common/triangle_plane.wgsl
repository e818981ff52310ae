// The plane of a triangle from its corners: one function, so that triangles in one plane are told to be.

#import common/frame
#import common/receiver_depth

fn largest(v: vec3f) -> f32 {
    return max(abs(v.x), max(abs(v.y), abs(v.z)));
}

// Its direction, for a vector of any size; 1e-37 keeps zero from being divided by zero.
fn scaled(v: vec3f) -> vec3f {
    return v / max(largest(v), 1e-37);
}

// The plane of the triangle with these corners in an instance's local space.
fn triangle_plane(instance: u32, a: vec3f, b: vec3f, c: vec3f) -> ReceiverPlane {
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
