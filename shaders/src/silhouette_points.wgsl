// The points of silhouettes in the texels that they pass, as the light sees them: one for each texel.
//
// A texel of these maps lies between four texels of depth, which are at its corners. Each edge is drawn as a rectangle around
// it, wide and long enough that every texel it touches gets a fragment, so that those of one outline hang together by their
// sides; which of the fragments the edge touches in fact is decided here.

struct Edge {
    // In texels of silhouettes.
    a: vec2f,
    b: vec2f,
    depth_a: f32,
    depth_b: f32,
    pad_0: u32,
    pad_1: u32,
}

@group(1) @binding(0) var<storage, read> edges: array<Edge>;
// The depth of the same view.
@group(1) @binding(1) var depths: texture_depth_2d_array;

// Texels beside an edge and beyond its ends: the middle of one that it touches is no farther than half a diagonal.
const REACH: f32 = 1.0;
// How far outside its texel a point may be found, to be moved onto its border: lines that pass a corner are in all four.
const CORNER: f32 = 0.015625;
// Points do not lie on the border itself, where no direction leads from them to a corner.
const BORDER: f32 = 0.001;
// What depth loses of itself, and of 1, before an edge is taken to be hidden.
const HIDDEN: f32 = 0.00001;

struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat, first) edge: u32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varyings {
    let number = index / 6u;
    let corner = index % 6u;
    let edge = edges[number];
    let size = vec2f(textureDimensions(depths));
    let along = edge.b - edge.a;
    let length_texels = length(along);
    let direction = select(vec2f(1.0, 0.0), along / max(length_texels, 1e-30), length_texels > 1e-6);
    let across = vec2f(-direction.y, direction.x);
    // 0 1 2, 2 1 3: two bits each.
    let place = (0xda4u >> (2u * corner)) & 3u;
    let at_end = (place & 1u) == 1u;
    let end = select(edge.a - direction * REACH, edge.b + direction * REACH, at_end);
    let side = select(-REACH, REACH, place > 1u);
    let texel = end + across * side;
    var out: Varyings;
    out.clip = vec4f(texel.x / size.x * 2.0 - 1.0, 1.0 - texel.y / size.y * 2.0, 0.5, 1.0);
    out.edge = number;
    return out;
}

// Where along the line from a to b its coordinate along `normal` is `offset`: beyond 0 … 1 where nowhere.
fn crossing(a: vec2f, b: vec2f, normal: vec2f, offset: f32) -> f32 {
    let change = dot(normal, b - a);
    let t = (offset - dot(normal, a)) / select(change, 1e-30, change == 0.0);
    return select(t, -1.0, change == 0.0);
}

fn is_within(p: vec2f) -> bool {
    return all(p >= vec2f(-CORNER)) && all(p <= vec2f(1.0 + CORNER));
}

struct Stored {
#if BYTE
    // Four bits for each offset.
    @location(0) point: f32,
#else
    @location(0) point: vec2f,
#endif
    // Of the point: the nearest to the light is kept.
    @builtin(frag_depth) depth: f32,
}

@fragment
fn store(in: Varyings) -> Stored {
    let texel = floor(in.clip.xy);
    let edge = edges[in.edge];
    let a = edge.a - texel;
    let b = edge.b - texel;
    // A corner of the outline; of two the nearer to the light.
    let has_a = all(a >= vec2f(0.0)) && all(a < vec2f(1.0));
    let has_b = all(b >= vec2f(0.0)) && all(b < vec2f(1.0));
    let takes_a = has_a && (!has_b || edge.depth_a >= edge.depth_b);
    // Else where it crosses one diagonal, or half way between both.
    let t = vec2f(crossing(a, b, vec2f(1.0, -1.0), 0.0), crossing(a, b, vec2f(1.0, 1.0), 1.0));
    let on_edge = (t >= vec2f(0.0)) & (t <= vec2f(1.0));
    let first = on_edge.x && is_within(a + (b - a) * t.x);
    let second = on_edge.y && is_within(a + (b - a) * t.y);
    var along = select(t.y, select(t.x, 0.5 * (t.x + t.y), second), first);
    along = select(along, 1.0, has_b);
    along = select(along, 0.0, takes_a);
    if !has_a && !has_b && !first && !second {
        discard;
    }
    let depth = edge.depth_a + (edge.depth_b - edge.depth_a) * along;
    // Only what the light sees: not what is farther than all that is seen at the corners.
    let corner = vec2i(texel);
    let last = vec2i(textureDimensions(depths)) - 1;
    let right = min(corner.x + 1, last.x);
    let down = min(corner.y + 1, last.y);
    let seen = vec4f(
        textureLoad(depths, corner, 0, 0),
        textureLoad(depths, vec2i(right, corner.y), 0, 0),
        textureLoad(depths, vec2i(corner.x, down), 0, 0),
        textureLoad(depths, vec2i(right, down), 0, 0),
    );
    if depth < min(min(seen.x, seen.y), min(seen.z, seen.w)) * (1.0 - HIDDEN) - HIDDEN * 0.1 {
        discard;
    }
    let p = clamp(a + (b - a) * along, vec2f(BORDER), vec2f(1.0 - BORDER));
    var out: Stored;
#if BYTE
    let offset = floor(p * 16.0);
    out.point = (offset.y * 16.0 + offset.x) / 255.0;
#else
    out.point = floor(p * 256.0) / 255.0;
#endif
    out.depth = clamp(depth, 0.0, 1.0);
    return out;
}
