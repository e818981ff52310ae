// The shadow of alpha-masked triangles, texel by texel. At every pixel the visible point is rebuilt from its depth, and
// the segment from it to the light is tested exactly against the triangles that the light sees about there: does it
// pass through one, and is the texture there where it does?

#import common/light_grid_lists
#import common/fullscreen
#import common/alpha_mask

// A listed triangle; corners a, b, c are counter-clockwise as the light sees them.
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

@group(1) @binding(2) var<storage, read> triangles: array<MaskedTriangle>;
#if BASE_COLOR_TEXTURE
@group(1) @binding(5) var base_color_image: texture_2d<f32>;
#endif
@group(1) @binding(6) var<storage, read> casters: array<MaskedCaster>;

@fragment
fn darken(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let depth = textureLoad(receiver_depth, vec2u(position.xy), 0);
    let receiver = receiver_at(position.xy, depth);
    // Depth is reversed: 0 is infinitely far, where nothing is.
    if depth == 0.0 {
        discard;
    }
    if !is_dark(receiver) {
        discard;
    }
    return vec4f(0.0);
}

// Whether a triangle blocks the light: in the cells that the receiver may be seen in.
fn is_dark(receiver: Receiver) -> bool {
    for (var plane = 0u; plane < lists_seen.plane_count; plane += 1u) {
        let cells = cells_of(receiver, plane);
        if cells.none {
            continue;
        }
        for (var y = cells.low.y; y <= cells.high.y; y += 1u) {
            for (var x = cells.low.x; x <= cells.high.x; x += 1u) {
                if is_blocked_in(cell_number(plane, x, y), cells.distance, receiver) {
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
        let e = inside_edges(cone, receiver.p - casters[cone.caster].center);
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
    let caster = casters[caster_number];
    if !is_behind(receiver, caster.center + t.corner, t.away) {
        return false;
    }
    var alpha = caster.alpha * dot(weights, vec3f(t.alpha_a, t.alpha_b, t.alpha_c));
#if BASE_COLOR_TEXTURE
    let uv = t.uv_a * weights.x + t.uv_b * weights.y + t.uv_c * weights.z;
    alpha *= mask_alpha(base_color_image, uv, caster.reading);
#endif
    return alpha >= caster.cutoff;
}
