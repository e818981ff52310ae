// The shadow of alpha-masked triangles, texel by texel. At every pixel the visible point is rebuilt from its depth, and
// the segment from it to the light is tested exactly against the triangles that the light sees about there: does it
// pass through one, and is the texture there where it does?

#import common/frame
#import common/fullscreen
#import common/alpha_mask

// What a triangle hides from the light: the planes through the light and an edge, as (normal, offset) relative to the
// caster's centre. The line from a point to the light passes through the triangle where none of the three is negative.
// Neighbours hold the same numbers with opposite signs, so no line slips between them. Directions are those of the
// world.
struct MaskedCone {
    bc: vec4f,
    ca: vec4f,
    ab: vec4f,
    caster: u32,
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}

// The triangle itself; corners a, b, c are counter-clockwise as the light sees them.
struct MaskedTriangle {
    // Corner a relative to the caster's centre.
    corner: vec3f,
    // Alpha of the vertex colours.
    alpha_a: f32,
    // The unit normal on the side turned away from the light.
    away: vec3f,
    alpha_b: f32,
    // Texture coordinates, transformed.
    uv_a: vec2f,
    uv_b: vec2f,
    uv_c: vec2f,
    alpha_c: f32,
    pad_0: u32,
}

// The triangles of one instance with one material, as the eye sees them.
struct MaskedCaster {
    // From the eye to the middle of its bounds.
    center: vec3f,
    // What the alpha of texture and vertex colour is multiplied by.
    alpha: f32,
    // Holes are where alpha is below.
    cutoff: f32,
    // How alpha is read: see common/alpha_mask.
    reading: u32,
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

struct MaskedCasters {
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
    casters: array<MaskedCaster>,
}

@group(1) @binding(0) var<storage, read> masked: MaskedCasters;
@group(1) @binding(1) var<storage, read> cones: array<MaskedCone>;
@group(1) @binding(2) var<storage, read> triangles: array<MaskedTriangle>;
// How many cells a side of a plane has; where each cell's list begins; where the last one ends; for each triangle of a
// list its number, and how far from the light it begins. The nearest comes first.
@group(1) @binding(3) var<storage, read> lists: array<u32>;
@group(1) @binding(4) var receiver_depth: texture_depth_2d;
#if BASE_COLOR_TEXTURE
@group(1) @binding(5) var base_color_image: texture_2d<f32>;
#endif

// How many ulps the receiver's depth may be off: below the 64 that measures allow for.
const DEPTH_ULPS: u32 = 48u;
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
}

fn world_from_view(d: vec3f) -> vec3f {
    return masked.world_x * d.x + masked.world_y * d.y + masked.world_z * d.z;
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

@fragment
fn darken(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let depth = textureLoad(receiver_depth, vec2u(position.xy), 0);
    // Depth is reversed: 0 is infinitely far, where nothing is.
    if depth == 0.0 {
        discard;
    }
    let receiver = Receiver(position.xy, depth, world_from_view(view_from_pixel(position.xy, depth)));
    if !is_dark(receiver) {
        discard;
    }
    return vec4f(0.0);
}

// Whether a triangle blocks the light: in the cells that the receiver may be seen in.
fn is_dark(receiver: Receiver) -> bool {
    let d = receiver.p - masked.origin;
    let uncertain_m = CELL_ROUNDING * (length(receiver.p) + masked.reach_m);
    let side = lists[0];
    for (var i = 0u; i < masked.plane_count; i += 1u) {
        let plane = masked.planes[i];
        let h = vec3f(dot(plane.x_axis, d), dot(plane.y_axis, d), dot(plane.z_axis, d) + plane.z_offset);
        let uncertain_z = uncertain_m * plane.z_length;
        let beside = select(0.0, max(abs(h.x), abs(h.y)) - 2.0 * uncertain_z, masked.plane_count > 1u);
        if h.z + uncertain_z <= max(beside, 0.0) {
            continue;
        }
        let ndc = h.xy / max(h.z, TINY);
        let uncertain = vec2f(plane.x_length, plane.y_length) * (uncertain_m / max(h.z - uncertain_z, TINY));
        // No difference of infinities: what is that far out is clamped anyway.
        let middle = clamp(ndc, vec2f(-1e9), vec2f(1e9));
        let reach = min(uncertain, vec2f(2e9));
        // Every caster is within the planes' view.
        if any(abs(middle) - reach > vec2f(1.00001)) {
            continue;
        }
        let last = f32(side) - 1.0;
        let low = vec2u(clamp(floor(((middle - reach) * 0.5 + 0.5) * f32(side)), vec2f(0.0), vec2f(last)));
        let high = vec2u(clamp(floor(((middle + reach) * 0.5 + 0.5) * f32(side)), vec2f(0.0), vec2f(last)));
        let distance = dot(plane.away, d) + uncertain_m;
        for (var y = low.y; y <= high.y; y += 1u) {
            for (var x = low.x; x <= high.x; x += 1u) {
                if is_blocked_in((i * side + y) * side + x, distance, receiver) {
                    return true;
                }
            }
        }
    }
    return false;
}

// Whether a triangle of cell number `cell` blocks the light of a receiver no further from it than `distance`.
fn is_blocked_in(cell: u32, distance: f32, receiver: Receiver) -> bool {
    let end = lists[cell + 2u];
    for (var place = lists[cell + 1u]; place < end; place += 2u) {
        if bitcast<f32>(lists[place + 1u]) > distance {
            return false;
        }
        let number = lists[place];
        let cone = cones[number];
        let q = receiver.p - masked.casters[cone.caster].center;
        let e = vec3f(
            dot(cone.bc.xyz, q) + cone.bc.w,
            dot(cone.ca.xyz, q) + cone.ca.w,
            dot(cone.ab.xyz, q) + cone.ab.w,
        );
        let sum = e.x + e.y + e.z;
        let passes = min(e.x, min(e.y, e.z)) >= 0.0 && sum > 0.0;
        if passes && is_blocked(number, cone.caster, receiver, e / sum) {
            return true;
        }
    }
    return false;
}

// Whether a triangle, whose corners have these weights where the line to the light passes it, blocks the receiver.
fn is_blocked(number: u32, caster_number: u32, receiver: Receiver, weights: vec3f) -> bool {
    let t = triangles[number];
    let caster = masked.casters[caster_number];
    // The point must lie strictly behind the triangle, wherever within the uncertainty of its depth it is: else it may
    // lie on the triangle itself.
    let corner = caster.center + t.corner;
    let height = dot(t.away, receiver.p - corner);
    let step = world_from_view(deeper(receiver.pixel, receiver.depth)) - receiver.p;
    let uncertain = abs(dot(t.away, step)) + ROUNDING * (length(receiver.p) + length(corner));
    if height <= uncertain {
        return false;
    }
    var alpha = caster.alpha * dot(weights, vec3f(t.alpha_a, t.alpha_b, t.alpha_c));
#if BASE_COLOR_TEXTURE
    let uv = t.uv_a * weights.x + t.uv_b * weights.y + t.uv_c * weights.z;
    alpha *= mask_alpha(base_color_image, uv, caster.reading);
#endif
    return alpha >= caster.cutoff;
}
