// Maps of what a light sees, and whether a texel of one is before a receiver.
//
// *No bias.* A texel knows one point of a caster, and the plane of the triangle it is on. That triangle can hide the light
// from a receiver only if its point lies before the receiver's plane, and the receiver lies behind the triangle's. Both are
// asked. A surface never shadows itself: its points lie in its own plane. At a ridge the neighbour's points lie behind the
// receiver's plane, in a hollow the receiver lies before the neighbour's: neither is a shadow, however wide a texel is and
// however low the light. What is left is what a rasteriser and f32 round.

#import common/frame
#import common/fullscreen
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

// What a draw over the picture knows of the one view that it asks: it is the same at every pixel, so vertices carry it. (Software
// adapters read storage lane by lane.)
struct Asking {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat, first) texel_x: vec4f,
    @location(1) @interpolate(flat, first) texel_y: vec4f,
    @location(2) @interpolate(flat, first) depth: vec4f,
    @location(3) @interpolate(flat, first) w: vec4f,
    @location(4) @interpolate(flat, first) plane_x: vec4f,
    @location(5) @interpolate(flat, first) plane_y: vec4f,
    @location(6) @interpolate(flat, first) plane_depth: vec4f,
    @location(7) @interpolate(flat, first) scales: vec4f,
    @location(8) @interpolate(flat, first) light: vec4f,
    // Position loss, and as bits the layer, the texels along a side, and the number of the view.
    @location(9) @interpolate(flat, first) more: vec4u,
#if POINT
    @location(10) @interpolate(flat, first) world_x: vec4f,
    @location(11) @interpolate(flat, first) world_y: vec4f,
    @location(12) @interpolate(flat, first) world_z: vec4f,
#endif
#if BIASED
    @location(13) @interpolate(flat, first) biases: vec3f,
#endif
}

@vertex
fn asking(@builtin(vertex_index) index: u32, @builtin(instance_index) number: u32) -> Asking {
    var out: Asking;
    out.position = fullscreen_corner(index);
    out.light = maps.light;
#if POINT
    out.world_x = maps.world_x;
    out.world_y = maps.world_y;
    out.world_z = maps.world_z;
#endif
#if BIASED
    out.biases = vec3f(maps.constant_m, maps.slope_texels, maps.normal_texels);
#endif
    return about_view(out, number);
}

// The same question, put to this view.
fn about_view(asking: Asking, number: u32) -> Asking {
    let view = maps.views[number];
    var out = asking;
    out.texel_x = view.texel_x;
    out.texel_y = view.texel_y;
    out.depth = view.depth;
    out.w = view.w;
    out.plane_x = view.plane_x;
    out.plane_y = view.plane_y;
    out.plane_depth = view.plane_depth;
    out.scales = vec4f(view.texels_per_m, view.depth_per_m, view.relative_loss, view.absolute_loss);
    out.more = vec4u(bitcast<u32>(view.position_loss_m), view.layer, maps.texels, number);
    return out;
}

// A visible point.
struct Seen {
    // As depth has it.
    p: vec3f,
    // Whether there is something.
    is_there: bool,
}

fn seen_at(texel: vec2f) -> Seen {
    let depth = textureLoad(receiver_depth, vec2u(texel), 0);
    return Seen(view_from_pixel(place_px(texel), max(depth, 1e-30)), depth > 0.0);
}

// Whether this draw's view is the one that shows a point.
fn shows(in: Asking, p: vec3f) -> bool {
#if POINT
    let p1 = vec4f(p, 1.0);
    let d = vec3f(dot(in.world_x, p1), dot(in.world_y, p1), dot(in.world_z, p1));
    let size = abs(d);
    let axis = select(select(0u, 1u, size.y > size.x), 2u, size.z > max(size.x, size.y));
    let along = select(select(d.x, d.y, axis == 1u), d.z, axis == 2u);
    return axis * 2u + select(0u, 1u, along < 0.0) == in.more.w;
#else
    return true;
#endif
}

// Whether a point may lie within `margin` texels of the map.
fn is_near_map(in: Asking, p: vec3f, margin: f32) -> bool {
    let p1 = vec4f(p, 1.0);
    let w = dot(in.w, p1);
    let at = vec2f(dot(in.texel_x, p1), dot(in.texel_y, p1));
    let end = w * (f32(in.more.z) + margin);
    return w > 0.0 && all(at > vec2f(-margin * w)) && all(at < vec2f(end));
}

// A visible point that receives.
struct Receiver {
    p: vec3f,
    // Unit, on the side of the light.
    normal: vec3f,
    // How far it is along the view.
    distance_m: f32,
    // Sine of how high the light stands over it.
    height: f32,
    receives: bool,
}

fn receiver_of(in: Asking, texel: vec2f, seen: vec3f) -> Receiver {
    let plane = unpacked_plane(textureLoad(receiver_planes, vec2u(texel), 0));
    let p = farther(seen, on_plane(plane, seen).farther);
    let towards = normalize(in.light.xyz - p * in.light.w);
    let height = dot(plane.normal, towards);
    let normal = select(plane.normal, -plane.normal, height < 0.0);
    // Towards the light by what rounding has lost of where it is.
    let lost_m = PLANE_ROUNDING * (plane.near_m + length(p));
    return Receiver(p + normal * lost_m, normal, -p.z, abs(height), plane.far_m > 0.0);
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
    texels: i32,
    outside: bool,
}

fn question(in: Asking, receiver: Receiver) -> Question {
    var p = receiver.p;
    var w = dot(in.w, vec4f(p, 1.0));
    let texels_per_m = in.scales.x;
#if BIASED
    p += receiver.normal * (in.biases.z * max(w, 0.0) / texels_per_m);
    w = dot(in.w, vec4f(p, 1.0));
#endif
    let p1 = vec4f(p, 1.0);
    let outside = w <= 0.0 || in.more.y == NO_LAYER;
    w = max(w, 1e-30);
    let at = vec3f(dot(in.texel_x, p1), dot(in.texel_y, p1), dot(in.depth, p1)) / w;
    let in_view = vec4f(receiver.normal, -dot(receiver.normal, p));
    let plane = vec3f(dot(in.plane_x, in_view), dot(in.plane_y, in_view), dot(in.plane_depth, in_view));
    let depth_per_m = in.scales.y / (w * w);
    let position_loss_m = bitcast<f32>(in.more.x);
    let snap_texels = SNAP_TEXELS + position_loss_m * texels_per_m / w;
    let depth_loss = in.scales.z * abs(at.z) + in.scales.w + position_loss_m * depth_per_m;
    let plane_loss = snap_texels * (abs(plane.x) + abs(plane.y)) + depth_loss * abs(plane.z);
    var bias = 0.0;
#if BIASED
    let tangent = sqrt(max(1.0 - receiver.height * receiver.height, 0.0)) / max(receiver.height, 1e-3);
    bias = (in.biases.x + in.biases.y * tangent * w / texels_per_m) * depth_per_m;
#endif
    let layer = select(in.more.y, 0u, in.more.y == NO_LAYER);
    return Question(at, plane, plane_loss, snap_texels, depth_loss, bias, layer, i32(in.more.z), outside);
}

// The depth of a texel; 0, as where nothing is, beyond the map.
fn depth_of(texel: vec2i, asked: Question) -> f32 {
    let within = clamp(texel, vec2i(0), vec2i(asked.texels - 1));
    let seen = textureLoad(depths, within, asked.layer, 0);
    return select(0.0, seen, all(texel == within) && !asked.outside);
}

// Whether what a texel shows may hide the light from the receiver: by its point alone, which has to lie before the receiver's
// plane. No branches: most pixels are lit, and what they ask of many texels is then a straight line.
fn is_before(texel: vec2i, asked: Question) -> bool {
    let seen = depth_of(texel, asked);
#if BIASED
    return seen > asked.at.z + asked.bias;
#else
    let across = vec2f(texel) + 0.5 - asked.at.xy;
    return seen > 0.0 && dot(asked.plane, vec3f(across, seen - asked.at.z)) > asked.plane_loss;
#endif
}

// Whether it does: the receiver has to lie behind the plane of what is seen as well.
fn is_dark(texel: vec2i, asked: Question) -> bool {
#if BIASED
    return is_before(texel, asked);
#else
    let seen = depth_of(texel, asked);
    let across = vec2f(texel) + 0.5 - asked.at.xy;
    let nearer = seen - asked.at.z;
    let within = clamp(texel, vec2i(0), vec2i(asked.texels - 1));
#if PERSPECTIVE
    let slope = textureLoad(slopes, within, asked.layer, 0).xy * seen;
#else
    let slope = textureLoad(slopes, within, asked.layer, 0).xy;
#endif
    let loss = dot(abs(slope), asked.snap_texels + SLOPE_LOSS * abs(across)) + asked.depth_loss;
    let is_behind = nearer - dot(slope, across) > loss;
    return is_before(texel, asked) && is_behind;
#endif
}
