// Planar shadows: casters flattened onto a receiver's plane from each point of a light, and what of the light they
// leave.
//
// For every point of the light the casters' triangles are drawn where their shadow falls, which marks one bit of each
// pixel of the receiver; the stencil lets a point mark a pixel once. Then the receiver's pixels weigh their bits.

#import common/frame

#if RECEIVER
#import common/fullscreen
#import common/positions
#if MASKED
#import common/attributes
#endif

@group(1) @binding(1) var<storage, read> indices: array<u32>;
@group(1) @binding(3) var receiver_depth: texture_depth_2d;
// One bit for each point of the light, 32 of them in a layer's four channels.
@group(1) @binding(4) var shadowed_bits: texture_2d_array<f32>;

// The points that stand for a light.
struct PlanarLight {
    // In view space; for a texture, from its middle along its sides and the plane's normal.
    center: vec3f,
    // Of a sphere; 0 where every point counts the same.
    radius_m: f32,
    count: u32,
    // The point that alone counts inside the sphere: its number, or `count` where no receiver reaches so far.
    center_point: u32,
    // Half the sides of a texture on the receiver.
    half_m: vec2f,
    // 1 where no point lies under the receiver, else 0.
    all_above: u32,
    // From the centre, along the axes of view space, in radii; w is 0 where the point lies under the receiver, else 1.
    points: array<vec4f>,
}

@group(1) @binding(5) var<storage, read> light: PlanarLight;
#if OVERLAPS
// The instance and the triangle that every pixel shows.
@group(1) @binding(8) var visible_triangles: texture_2d<u32>;
#endif

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) p_in_view: vec3f,
#if MASKED
    @location(1) uvs: Uvs,
    @location(2) alpha: f32,
#endif
#if OVERLAPS
    @location(3) @interpolate(flat, first) triangle: vec2u,
#endif
}

@vertex
fn receiver(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let vertex = indices[corner];
    let p = local_position(vertex);
    var out: Varyings;
    out.clip = clip_from_local(instance, p);
    out.p_in_view = view_from_local(instance, p);
#if MASKED
    out.uvs = vertex_uvs(vertex);
    out.alpha = vertex_alpha(vertex);
#endif
#if OVERLAPS
    out.triangle = vec2u(instance, corner / 3u);
#endif
    return out;
}

// Whether a fragment does not show the receiver: it is in a hole, or of a triangle with another, visible one over it.
fn is_left_out(in: Varyings) -> bool {
#if MASKED
    var left_out = has_hole(in.uvs, in.alpha);
#else
    var left_out = false;
#endif
#if OVERLAPS
    left_out = left_out || any(textureLoad(visible_triangles, vec2u(in.clip.xy), 0).xy != in.triangle);
#endif
    return left_out;
}

// Where the receiver is hidden, nothing need be drawn. Spared work only: what is taken to be seen here and is not is
// left out when the bits are weighed. So this much of the depth may be rounding.
const HIDDEN: f32 = 0.999;

@fragment
fn mark_receiver(in: Varyings) {
    if in.clip.z < textureLoad(receiver_depth, vec2u(in.clip.xy), 0) * HIDDEN {
        discard;
    }
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
}

// What a point of the ball at `a` counts, seen from a receiver a distance 1 away, `towards` it, with the ball's rim at
// this sine. Points whose density is 1/sqrt(1 - r²) in the ball cover the disc that the ball looks like evenly from far
// away; from nearby, the disc's area in a narrow cone over the points' number in it is
//     cos^-3 / (cos² + (rim² - sin²) / 2).
fn weight(a: vec3f, towards: vec3f, rim: f32) -> f32 {
    let along = dot(a, towards);
    let across = a - towards * along;
    let cos_squared = 1.0 / (1.0 + dot(across, across) / ((1.0 - along) * (1.0 - along)));
    let points = cos_squared + 0.5 * max(rim * rim - (1.0 - cos_squared), 0.0);
    return 1.0 / (cos_squared * sqrt(cos_squared) * points);
}

// The light as a receiver sees it. Read once: software adapters read storage word by word and pixel by pixel.
struct SeenLight {
    // Towards the receiver, from the light.
    towards: vec3f,
    // The sine of the ball's rim.
    rim: f32,
    weighs: bool,
    inside: bool,
    center_point: u32,
}

fn light_seen_from(p: vec3f) -> SeenLight {
    let radius_m = light.radius_m;
    let away = p - light.center;
    let distance_m = length(away);
    let weighs = radius_m > 0.0;
    let inside = weighs && distance_m <= radius_m;
    return SeenLight(away / distance_m, radius_m / distance_m, weighs, inside, light.center_point);
}

// What point `i` of the light, which is at `point`, counts for a receiver that sees the light so.
fn weight_of_point(i: u32, point: vec3f, seen: SeenLight) -> f32 {
    var w = 1.0;
    if (i == seen.center_point) != seen.inside {
        w = 0.0;
    } else if seen.weighs && !seen.inside {
        w = weight(point * seen.rim, seen.towards, seen.rim);
    }
    return w;
}

// The bits of 32 points.
fn bits_of(pixel: vec2u, layer: u32) -> vec4u {
    return vec4u(textureLoad(shadowed_bits, pixel, layer, 0) * 255.0 + 0.5);
}

// The share of the light that reaches a receiver at `p`, whose bits are those of `pixel`.
fn share_at(p: vec3f, pixel: vec2u) -> f32 {
    let count = light.count;
    // Most of a receiver sees all points or none, whatever they weigh.
    var shadowed = 0u;
    for (var layer = 0u; layer * 32u < count; layer += 1u) {
        // Channels that the format lacks read as 0 or 1.
        let points = clamp(vec4i(i32(count - layer * 32u)) - vec4i(0, 8, 16, 24), vec4i(0), vec4i(8));
        let ones = countOneBits(bits_of(pixel, layer) & ((vec4u(1u) << vec4u(points)) - 1u));
        shadowed += ones.x + ones.y + ones.z + ones.w;
    }
    if shadowed == count {
        return 0.0;
    }
    if shadowed == 0u && light.all_above == 1u {
        return 1.0;
    }
    let seen = light_seen_from(p);
    var lit = 0.0;
    var all = 0.0;
    var bits = vec4u(0u);
    for (var i = 0u; i < count; i += 1u) {
        if (i & 31u) == 0u {
            bits = bits_of(pixel, i >> 5u);
        }
        let point = light.points[i];
        let w = weight_of_point(i, point.xyz, seen);
        all += w;
        let is_shadowed = ((bits[(i >> 3u) & 3u] >> (i & 7u)) & 1u) == 1u;
        lit += select(w * point.w, 0.0, is_shadowed);
    }
    return lit / max(all, 1e-30);
}

@fragment
fn share(in: Varyings) -> @location(0) vec4f {
    if is_left_out(in) {
        discard;
    }
    return vec4f(share_at(in.p_in_view, vec2u(in.clip.xy)));
}

// The same for the middle of a texel.
@fragment
fn share_of_texel(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return vec4f(share_at(texel_middle(position), vec2u(position.xy)));
}

fn texel_middle(position: vec4f) -> vec3f {
    let size = vec2f(textureDimensions(shadowed_bits));
    let place = (position.xy / size * 2.0 - 1.0) * light.half_m;
    return vec3f(place.x, -place.y, 0.0);
}

// Where a texture lies: its texels are (dot(p, x_axis) + x_offset, dot(p, y_axis) + y_offset), p in view space.
struct PlanarTexture {
    x_axis: vec3f,
    x_offset: f32,
    y_axis: vec3f,
    y_offset: f32,
}

@group(1) @binding(6) var shares: texture_2d<f32>;
@group(1) @binding(7) var<storage, read> place: PlanarTexture;

// The four texels between whose middles a point is, and how they blend.
struct TexelsAt {
    low: vec2u,
    high: vec2u,
    blend: vec2f,
}

// Where a point (in view space) is on a texture of this size.
fn texels_at(p: vec3f, size: vec2u) -> TexelsAt {
    let texel = vec2f(dot(p, place.x_axis) + place.x_offset, dot(p, place.y_axis) + place.y_offset) - 0.5;
    let low = clamp(floor(texel), vec2f(0.0), vec2f(size) - 1.0);
    return TexelsAt(vec2u(low), min(vec2u(low) + 1u, size - 1u), saturate(texel - low));
}

// Which points of the light are added: from the first, up to the end.
struct Chunk {
    first: u32,
    end: u32,
}

@group(1) @binding(9) var<storage, read> chunk: Chunk;
// What glass lets pass of each of these points, a layer for each.
@group(1) @binding(10) var tints: texture_2d_array<f32>;

// The colour of what arrives of some points of the light at a receiver at `p`, whose bits are those of `pixel`, times their
// weights; and the weights: both over the number of all points.
fn tinted_at(p: vec3f, pixel: vec2u) -> vec4f {
    let seen = light_seen_from(p);
    var arrives = vec3f(0.0);
    var all = 0.0;
    let bits = bits_of(pixel, chunk.first >> 5u);
    for (var i = chunk.first; i < chunk.end; i += 1u) {
        let point = light.points[i];
        let w = weight_of_point(i, point.xyz, seen);
        all += w;
        let is_shadowed = ((bits[(i >> 3u) & 3u] >> (i & 7u)) & 1u) == 1u;
        arrives += select(w * point.w, 0.0, is_shadowed) * textureLoad(tints, pixel, i - chunk.first, 0).rgb;
    }
    return vec4f(arrives, all) / f32(light.count);
}

@fragment
fn tinted_points(in: Varyings) -> @location(0) vec4f {
    if is_left_out(in) {
        discard;
    }
    return tinted_at(in.p_in_view, vec2u(in.clip.xy));
}

@fragment
fn tinted_texel(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return tinted_at(texel_middle(position), vec2u(position.xy));
}

// The colour of what arrives of all points. `shares` is the sum of what `tinted_points` gives.
@fragment
fn tinted_share(in: Varyings) -> @location(0) vec4f {
    if is_left_out(in) {
        discard;
    }
    return tinted_texel_at(vec2u(in.clip.xy));
}

fn tinted_texel_at(texel: vec2u) -> vec4f {
    let sum = textureLoad(shares, texel, 0);
    return vec4f(sum.rgb / max(sum.a, 1e-30), 1.0);
}

// The same between four texels.
@fragment
fn tinted_share_from_texture(in: Varyings) -> @location(0) vec4f {
    if is_left_out(in) {
        discard;
    }
    let at = texels_at(in.p_in_view, textureDimensions(shares));
    let top = mix(tinted_texel_at(at.low), tinted_texel_at(vec2u(at.high.x, at.low.y)), at.blend.x);
    let bottom = mix(tinted_texel_at(vec2u(at.low.x, at.high.y)), tinted_texel_at(at.high), at.blend.x);
    return mix(top, bottom, at.blend.y);
}

// A texel with its neighbours to the right and below: what is blended where their middles are the corners.
@fragment
fn four_texels(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let low = vec2u(position.xy);
    let high = min(low + 1u, textureDimensions(shares) - 1u);
    let top = vec2f(textureLoad(shares, low, 0).r, textureLoad(shares, vec2u(high.x, low.y), 0).r);
    let bottom = vec2f(textureLoad(shares, vec2u(low.x, high.y), 0).r, textureLoad(shares, high, 0).r);
    return vec4f(top, bottom);
}

// `shares` are those of `four_texels` here.
@fragment
fn share_from_texture(in: Varyings) -> @location(0) vec4f {
    if is_left_out(in) {
        discard;
    }
    let at = texels_at(in.p_in_view, textureDimensions(shares));
    let four = textureLoad(shares, at.low, 0);
    return vec4f(mix(mix(four.x, four.y, at.blend.x), mix(four.z, four.w, at.blend.x), at.blend.y));
}

#else

#if GLASS
#import common/transmission

// A corner of a triangle that light passes.
struct GlassCorner {
    // From its caster's middle.
    position: vec3f,
    caster: u32,
    // Of the vertex.
    color: vec4f,
    base_color: vec4f,
    // Transformed.
    uv: vec2f,
    // Holes are where alpha is below, of masks.
    cutoff: f32,
    transmission: f32,
    // 0: alpha is ignored, 1: a mask, 2: blended.
    alpha_mode: u32,
    // How the texture is read: see common/alpha_mask.
    reading: u32,
}

@group(1) @binding(0) var<storage, read> corners: array<GlassCorner>;
#if BASE_COLOR_TEXTURE
@group(1) @binding(2) var base_color_image: texture_2d<f32>;
#endif
#else
#if MASKED
#import common/alpha_mask

// A corner of a triangle with holes.
struct MaskedCorner {
    // From its caster's middle.
    position: vec3f,
    caster: u32,
    // Transformed.
    uv: vec2f,
    // What the texture's alpha is multiplied by.
    alpha: f32,
    // Holes are where alpha is below.
    cutoff: f32,
    // How alpha is read: see common/alpha_mask.
    reading: u32,
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
}

@group(1) @binding(0) var<storage, read> corners: array<MaskedCorner>;
#if BASE_COLOR_TEXTURE
@group(1) @binding(2) var base_color_image: texture_2d<f32>;
#endif
#else
// Corners from their caster's middle; w is the caster's number, as bits.
@group(1) @binding(0) var<storage, read> corners: array<vec4f>;
#endif
#endif
// For every point of the light, one for each caster: onto the receiver's plane as the light sees it there, and from
// there to clip space.
@group(1) @binding(1) var<storage, read> clip_from_caster: array<mat4x4f>;

struct Varyings {
    @builtin(position) clip: vec4f,
#if GLASS
    @location(0) uv: vec2f,
    @location(1) color: vec4f,
    @location(2) @interpolate(flat, first) base_color: vec4f,
    // Cutoff, transmission.
    @location(3) @interpolate(flat, first) factors: vec2f,
    // Alpha mode, reading.
    @location(4) @interpolate(flat, first) modes: vec2u,
#else
#if MASKED
    @location(0) uv: vec2f,
    @location(1) alpha: f32,
    @location(2) @interpolate(flat, first) cutoff: f32,
    @location(3) @interpolate(flat, first) reading: u32,
#endif
#endif
}

@vertex
fn flatten(@builtin(vertex_index) index: u32, @builtin(instance_index) first_caster: u32) -> Varyings {
    let corner = corners[index];
    var out: Varyings;
#if GLASS
    out.clip = clip_from_caster[first_caster + corner.caster] * vec4f(corner.position, 1.0);
    out.uv = corner.uv;
    out.color = corner.color;
    out.base_color = corner.base_color;
    out.factors = vec2f(corner.cutoff, corner.transmission);
    out.modes = vec2u(corner.alpha_mode, corner.reading);
#else
#if MASKED
    out.clip = clip_from_caster[first_caster + corner.caster] * vec4f(corner.position, 1.0);
    out.uv = corner.uv;
    out.alpha = corner.alpha;
    out.cutoff = corner.cutoff;
    out.reading = corner.reading;
#else
    out.clip = clip_from_caster[first_caster + bitcast<u32>(corner.w)] * vec4f(corner.xyz, 1.0);
#endif
#endif
    return out;
}

#if GLASS
// What one surface lets pass.
@fragment
fn tint(in: Varyings) -> @location(0) vec4f {
    var color = in.base_color * in.color;
#if BASE_COLOR_TEXTURE
    color *= color_at(base_color_image, in.uv, in.modes.y);
#endif
    return vec4f(passing_surface(color, in.modes.x, in.factors.x, in.factors.y), 1.0);
}
#else
// The blend constant says which bit.
@fragment
fn mark_shadow(in: Varyings) -> @location(0) vec4f {
#if MASKED
    var alpha = in.alpha;
#if BASE_COLOR_TEXTURE
    alpha *= mask_alpha(base_color_image, in.uv, in.reading);
#endif
    if alpha < in.cutoff {
        discard;
    }
#endif
    return vec4f(1.0);
}
#endif
#endif
