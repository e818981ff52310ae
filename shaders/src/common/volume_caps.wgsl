// Caps before layers of transparent surfaces: whether what is seen lies in a cap's own plane is asked of the planes, pixel by pixel.
// Depths cannot tell it. Panes in one plane have depths that differ by tens of roundings of the largest depth on them, and next
// to the fold between two panes less than that is between the nearer one, which casts, and the one behind it.

#import common/volume
#import common/triangle_plane

// The planes of what is seen.
@group(1) @binding(5) var receiver_planes: texture_2d<u32>;
// The corners of all caps, three a triangle, as common/volume numbers them.
@group(1) @binding(6) var<storage, read> cap_corners: array<u32>;

// Planes that are turned against each other by less may be the same: what rounding leaves of small triangles' normals.
const SAME_DIRECTION: f32 = 0.00048828125;
// What rounding leaves of how high a point of one of two triangles in one plane is over the other, relative to the distance of
// their farthest corners: four roundings of each.
const SAME_HEIGHT: f32 = 2.4e-7;

// The plane of a cap, for its fragments.
struct CapPlane {
    // Unit normal and height over the eye, in view space.
    normal_offset: vec4f,
    // The distance of its farthest corner.
    far_m: f32,
}

// The plane of the cap that this corner is one of.
fn cap_plane(corner: u32, volume_index: u32) -> CapPlane {
    let volume = volumes[volume_index];
    let first = corner - corner % 3u;
    let a = volume_vertex(cap_corners[first] >> 2u, volume);
    let b = volume_vertex(cap_corners[first + 1u] >> 2u, volume);
    let c = volume_vertex(cap_corners[first + 2u] >> 2u, volume);
    let plane = triangle_plane(volume.instance, a, b, c);
    return CapPlane(vec4f(plane.normal, plane.offset_m), plane.far_m);
}

// Whether what is seen at this pixel lies in the cap's plane.
fn lies_in_cap(pixel: vec2f, cap: CapPlane) -> bool {
    let seen = unpacked_plane(textureLoad(receiver_planes, vec2u(pixel), 0));
    let normal = cap.normal_offset.xyz;
    // Where the view meets the plane that is seen.
    let ahead = view_from_pixel(pixel, 1.0);
    let along = select(vec3f(0.0, 0.0, -1.0), ahead, frame.eye_w > 0.0);
    let away = seen.offset_m - dot(seen.normal, ahead);
    let p = ahead + along * (away / dot(seen.normal, along));
    let height_m = abs(dot(normal, p) - cap.normal_offset.w);
    let turned = cross(normal, seen.normal);
    return height_m <= SAME_HEIGHT * (cap.far_m + seen.far_m) && dot(turned, turned) <= SAME_DIRECTION * SAME_DIRECTION;
}

// The depth at which a cap counts: behind all, or before, where what is seen lies in its plane; else where it is, a little
// behind or ahead, as the sides that hang from it.
fn cap_depth(position: vec4f, cap: CapPlane) -> f32 {
    let depth_unit = select(0.5, position.z, frame.eye_w > 0.0);
#if AHEAD
    return select(position.z + depth_unit * AHEAD_SHIFT, 1.0, lies_in_cap(position.xy, cap));
#else
    return select(position.z - depth_unit * SIDE_SHIFT, 0.0, lies_in_cap(position.xy, cap));
#endif
}
