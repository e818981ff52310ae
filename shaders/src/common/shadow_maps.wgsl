// Maps of what a light sees, and whether a texel of one is before a receiver.
//
// *No bias.* A texel knows one point of a caster, and the plane of the triangle it is on. That triangle can hide the light
// from a receiver only if its point lies before the receiver's plane, and the receiver lies behind the triangle's. Both are
// asked. A surface never shadows itself: its points lie in its own plane. At a ridge the neighbour's points lie behind the
// receiver's plane, in a hollow the receiver lies before the neighbour's: neither is a shadow, however wide a texel is and
// however low the light. What is left is what a rasteriser and f32 round.

#import common/frame
#import common/receiver_depth

// One layer: what the light sees in one direction.
struct MapView {
    // Rows. From view space to texels (x right, y down), depth and w.
    texel_x: vec4f,
    texel_y: vec4f,
    depth: vec4f,
    w: vec4f,
    // Rows. What a plane (normal, −offset) of view space becomes there: its slope along x and y in texels, and along depth.
    plane_x: vec4f,
    plane_y: vec4f,
    plane_depth: vec4f,
    // Texels on a metre across the view, and what depth falls by on a metre along it; divided by w and its square.
    texels_per_m: f32,
    depth_per_m: f32,
    // What rounding loses of depth, relative to it and by itself.
    relative_loss: f32,
    absolute_loss: f32,
    // And of casters' positions, in metres.
    position_loss_m: f32,
    // A cascade is used up to this distance along the eye's view, and on the last metres of it the next as well.
    end_m: f32,
    blend_m: f32,
    // NO_LAYER where nothing casts.
    layer: u32,
}

const NO_LAYER: u32 = 0xffffffffu;

struct ShadowMaps {
    // (position, 1) or (direction towards it, 0), in view space.
    light: vec4f,
    // Rows. From view space to the axes of the world, from the light.
    world_x: vec4f,
    world_y: vec4f,
    world_z: vec4f,
    // Along a side.
    texels: u32,
    view_count: u32,
    // Biases: along the light, in metres; along the slope and along the normal, in texels.
    constant_m: f32,
    slope_texels: f32,
    normal_texels: f32,
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
    views: array<MapView>,
}

@group(1) @binding(0) var<storage, read> maps: ShadowMaps;
// Depth, reversed: 0 where nothing is.
@group(1) @binding(1) var depths: texture_depth_2d_array;
#if BIASED
#else
// What depth changes by from texel to texel on the triangle that is seen, over depth itself in a perspective view.
@group(1) @binding(2) var slopes: texture_2d_array<f32>;
#endif
@group(1) @binding(3) var receiver_depth: texture_depth_2d;
@group(1) @binding(4) var receiver_planes: texture_2d<u32>;

// A rasteriser moves corners by up to 1/256 texel; half floats of slopes lose 1/2048.
const SNAP_TEXELS: f32 = 0.0078125;
const SLOPE_LOSS: f32 = 0.0009765625;

// A visible point that receives.
struct Receiver {
    p: vec3f,
    // Unit, on the side of the light.
    normal: vec3f,
    // How far it is along the view.
    distance_m: f32,
    // Sine of how high the light stands over it.
    height: f32,
}

// The visible point of a pixel; whether it receives at all.
fn receiver_at(pixel: vec2f) -> Receiver {
    let depth = textureLoad(receiver_depth, vec2u(pixel), 0);
    let plane = unpacked_plane(textureLoad(receiver_planes, vec2u(pixel), 0));
    let seen = view_from_pixel(pixel, max(depth, 1e-30));
    let p = farther(seen, on_plane(plane, seen).farther);
    let towards = normalize(maps.light.xyz - p * maps.light.w);
    let height = dot(plane.normal, towards);
    let normal = select(plane.normal, -plane.normal, height < 0.0);
    // Towards the light by what rounding has lost of where it is.
    let lost_m = PLANE_ROUNDING * (plane.near_m + length(p));
    let receives = depth > 0.0 && plane.far_m > 0.0;
    return Receiver(p + normal * lost_m, normal, select(-1.0, -p.z, receives), abs(height));
}

// The view that shows a point.
fn view_of(p: vec3f) -> u32 {
#if POINT
    let p1 = vec4f(p, 1.0);
    let d = vec3f(dot(maps.world_x, p1), dot(maps.world_y, p1), dot(maps.world_z, p1));
    let size = abs(d);
    let axis = select(select(0u, 1u, size.y > size.x), 2u, size.z > max(size.x, size.y));
    let along = select(select(d.x, d.y, axis == 1u), d.z, axis == 2u);
    return axis * 2u + select(0u, 1u, along < 0.0);
#else
    return 0u;
#endif
}

// What a receiver is in a map.
struct Question {
    // In texels, and depth.
    at: vec3f,
    // Its plane: how high over it a point is that lies so many texels and so much depth away.
    plane: vec3f,
    plane_loss: f32,
    snap_texels: f32,
    depth_loss: f32,
    // How much nearer it is taken to be.
    bias: f32,
    layer: u32,
    outside: bool,
}

fn question(number: u32, receiver: Receiver) -> Question {
    let view = maps.views[number];
    var p = receiver.p;
    var w = dot(view.w, vec4f(p, 1.0));
#if BIASED
    p += receiver.normal * (maps.normal_texels * max(w, 0.0) / view.texels_per_m);
    w = dot(view.w, vec4f(p, 1.0));
#endif
    let p1 = vec4f(p, 1.0);
    let outside = w <= 0.0 || view.layer == NO_LAYER || receiver.distance_m < 0.0;
    w = max(w, 1e-30);
    let at = vec3f(dot(view.texel_x, p1), dot(view.texel_y, p1), dot(view.depth, p1)) / w;
    let in_view = vec4f(receiver.normal, -dot(receiver.normal, p));
    let plane = vec3f(dot(view.plane_x, in_view), dot(view.plane_y, in_view), dot(view.plane_depth, in_view));
    let depth_per_m = view.depth_per_m / (w * w);
    let snap_texels = SNAP_TEXELS + view.position_loss_m * view.texels_per_m / w;
    let depth_loss = view.relative_loss * abs(at.z) + view.absolute_loss + view.position_loss_m * depth_per_m;
    let plane_loss = snap_texels * (abs(plane.x) + abs(plane.y)) + depth_loss * abs(plane.z);
    var bias = 0.0;
#if BIASED
    let tangent = sqrt(max(1.0 - receiver.height * receiver.height, 0.0)) / max(receiver.height, 1e-3);
    bias = (maps.constant_m + maps.slope_texels * tangent * w / view.texels_per_m) * depth_per_m;
#endif
    let layer = select(view.layer, 0u, view.layer == NO_LAYER);
    return Question(at, plane, plane_loss, snap_texels, depth_loss, bias, layer, outside);
}

// Whether what a texel shows hides the light from the receiver.
fn is_dark(texel: vec2i, asked: Question) -> bool {
    let beyond = any(texel < vec2i(0)) || any(texel >= vec2i(i32(maps.texels)));
    if beyond || asked.outside {
        return false;
    }
    let seen = textureLoad(depths, texel, asked.layer, 0);
#if BIASED
    return seen > asked.at.z + asked.bias;
#else
    let across = vec2f(texel) + 0.5 - asked.at.xy;
    let nearer = seen - asked.at.z;
    // Its point has to lie before the receiver's plane.
    if seen == 0.0 || dot(asked.plane, vec3f(across, nearer)) <= asked.plane_loss {
        return false;
    }
    // And the receiver behind its own.
#if PERSPECTIVE
    let slope = textureLoad(slopes, texel, asked.layer, 0).xy * seen;
#else
    let slope = textureLoad(slopes, texel, asked.layer, 0).xy;
#endif
    let loss = dot(abs(slope), asked.snap_texels + SLOPE_LOSS * abs(across)) + asked.depth_loss;
    return nearer - dot(slope, across) > loss;
#endif
}
