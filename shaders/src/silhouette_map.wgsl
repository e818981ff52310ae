// What of a light reaches each pixel, as its map tells, with edges as its silhouettes have them: a texel whose four corners do
// not agree is cut by lines from its own point to those of its neighbours, and each piece is what its corner is.

#import common/shadow_maps

// A point in each texel between four of depth.
@group(1) @binding(5) var points: texture_2d_array<f32>;

// The point of a texel, from its corner; the middle where no silhouette passes, or beyond the map.
fn point_of(texel: vec2i, layer: u32, texels: i32) -> vec2f {
    let beyond = any(texel < vec2i(0)) || any(texel >= vec2i(texels));
    let stored = textureLoad(points, clamp(texel, vec2i(0), vec2i(texels - 1)), layer, 0);
#if BYTE
    let byte = u32(stored.x * 255.0 + 0.5);
    let offset = (vec2f(f32(byte & 15u), f32(byte >> 4u)) + 0.5) / 16.0;
#else
    let offset = (floor(stored.xy * 255.0 + 0.5) + 0.5) / 256.0;
#endif
    return select(offset, vec2f(0.5), beyond);
}

fn cross2(a: vec2f, b: vec2f) -> f32 {
    return a.x * b.y - a.y * b.x;
}

// Whether v lies between two directions that are less than half a turn apart, the second after the first.
fn is_between(from_direction: vec2f, v: vec2f, to_direction: vec2f) -> bool {
    return cross2(from_direction, v) >= 0.0 && cross2(v, to_direction) >= 0.0;
}

// Whether v lies in the quadrant of a corner, between the lines to two neighbours: in one of the two wedges that the corner cuts it
// into.
fn is_in_quadrant(first: vec2f, corner: vec2f, second: vec2f, v: vec2f) -> bool {
    return is_between(first, v, corner) || is_between(corner, v, second);
}

fn is_lit(asked: Question) -> bool {
    let place = clamp(asked.at.xy - 0.5, vec2f(-1e6), vec2f(1e6));
    let texel = vec2i(floor(place));
    let within = place - floor(place);
    let is_hidden = is_before(texel, asked)
        | is_before(texel + vec2i(1, 0), asked)
        | is_before(texel + vec2i(0, 1), asked)
        | is_before(texel + vec2i(1, 1), asked);
    if !is_hidden {
        return true;
    }
    // Corners: left and right above, left and right below.
    let dark_00 = is_dark(texel, asked);
    let dark_10 = is_dark(texel + vec2i(1, 0), asked);
    let dark_01 = is_dark(texel + vec2i(0, 1), asked);
    let dark_11 = is_dark(texel + vec2i(1, 1), asked);
    if dark_00 == dark_10 && dark_00 == dark_01 && dark_00 == dark_11 {
        return !dark_00;
    }
    let own = point_of(texel, asked.layer, asked.texels);
    let right = point_of(texel + vec2i(1, 0), asked.layer, asked.texels) + vec2f(1.0, 0.0) - own;
    let left = point_of(texel - vec2i(1, 0), asked.layer, asked.texels) - vec2f(1.0, 0.0) - own;
    let below = point_of(texel + vec2i(0, 1), asked.layer, asked.texels) + vec2f(0.0, 1.0) - own;
    let above = point_of(texel - vec2i(0, 1), asked.layer, asked.texels) - vec2f(0.0, 1.0) - own;
    let v = within - own;
    var dark = dark_00;
    dark = select(dark, dark_01, is_in_quadrant(below, vec2f(0.0, 1.0) - own, left, v));
    dark = select(dark, dark_10, is_in_quadrant(above, vec2f(1.0, 0.0) - own, right, v));
    dark = select(dark, dark_11, is_in_quadrant(right, vec2f(1.0) - own, below, v));
    dark = select(dark, dark_00, is_in_quadrant(left, -own, above, v));
    return !dark;
}

// Texels beside the map from which nothing of it is asked.
const BESIDE: f32 = 2.0;

@fragment
fn darken(in: Asking) -> @location(0) vec4f {
    let seen = seen_at(in.position.xy);
    if !seen.is_there || !shows(in, seen.p) || !is_near_map(in, seen.p, BESIDE) {
        discard;
    }
    let receiver = receiver_of(in, in.position.xy, seen.p);
    if !receiver.receives || is_lit(question(in, receiver)) {
        discard;
    }
    return vec4f(0.0);
}

// The radius of a disc, in texels.
const DISC: f32 = 0.35;

// Red discs where the light throws the points that the map holds; everything else is lit.
@fragment
fn show_points(in: Asking) -> @location(0) vec4f {
    let seen = seen_at(in.position.xy);
    let asked = question(in, receiver_of(in, in.position.xy, seen.p));
    let place = clamp(asked.at.xy - 0.5, vec2f(-1e6), vec2f(1e6));
    let own = point_of(vec2i(floor(place)), asked.layer, asked.texels);
    // The middle is where no silhouette passes.
#if BYTE
    let holds_none = all(abs(own - 8.5 / 16.0) < vec2f(0.001));
#else
    let holds_none = all(abs(own - 128.5 / 256.0) < vec2f(0.001)) || all(own == vec2f(0.5));
#endif
    if !seen.is_there || !shows(in, seen.p) || asked.outside || holds_none || distance(place - floor(place), own) > DISC {
        discard;
    }
    return vec4f(1.0, 0.0, 0.0, 1.0);
}
