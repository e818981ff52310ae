// The shadow of alpha-masked triangles, texel by texel. Each triangle's volume is drawn as a closed prism, a little too
// large; at every pixel it covers, the visible point is rebuilt from its depth, and the segment from it to the light
// is tested exactly: does it pass through the triangle, and is the texture there where it does?

#import common/frame
#import common/alpha_mask

// A triangle and how the light sees it. Directions are those of the world.
struct MaskedTriangle {
    // Corners relative to the caster's centre, counter-clockwise as the light sees them.
    a: vec3f,
    // Alpha of the vertex colours.
    alpha_a: f32,
    b: vec3f,
    alpha_b: f32,
    c: vec3f,
    alpha_c: f32,
    // Planes through the light and an edge, as (normal, offset) relative to the caster's centre: the line from a point to
    // the light passes through the triangle where none of the three is negative. Neighbours hold the same numbers
    // with opposite signs, so no line slips between them.
    bc: vec4f,
    ca: vec4f,
    ab: vec4f,
    // The unit normal on the side turned away from the light.
    away: vec3f,
    caster: u32,
    // Texture coordinates, transformed.
    uv_a: vec2f,
    uv_b: vec2f,
    uv_c: vec2f,
    pad_0: vec2f,
}

// The triangles of one instance with one material, as the eye and the light see them.
struct MaskedCaster {
    // From the eye to the middle of its bounds.
    center: vec3f,
    // What the alpha of texture and vertex colour is multiplied by.
    alpha: f32,
    // The light from the centre: (position, 1), or (direction towards it, 0).
    light: vec4f,
    // Where volumes end, from the centre: {x : normal·x = offset}.
    end_normal: vec3f,
    end_offset: f32,
    // How they end: 0 at infinity, 1 on the end plane, 2 as a copy scaled about the light by `end_scale`.
    end_kind: u32,
    end_scale: f32,
    // Holes are where alpha is below.
    cutoff: f32,
    // How alpha is read: see common/alpha_mask.
    reading: u32,
}

struct MaskedCasters {
    // The columns of the rotation that takes directions from view space to the world.
    world_x: vec4f,
    world_y: vec4f,
    world_z: vec4f,
    casters: array<MaskedCaster>,
}

@group(1) @binding(0) var<storage, read> masked: MaskedCasters;
@group(1) @binding(1) var<storage, read> triangles: array<MaskedTriangle>;
@group(1) @binding(2) var receiver_depth: texture_depth_2d;
#if BASE_COLOR_TEXTURE
@group(1) @binding(3) var base_color_image: texture_2d<f32>;
#endif

// How many ulps the receiver's depth may be off: below the 64 that measures allow for.
const DEPTH_ULPS: u32 = 48u;
// What rounding leaves of a difference of positions around the eye, relative to their distance.
const ROUNDING: f32 = 4e-7;
// By how much prisms are enlarged, in pixels: rasterisers move their corners by less.
const MARGIN_PX: f32 = 0.5;
// Corners of slivers are moved no further than this many margins.
const LONGEST_MITRE: f32 = 64.0;
// How far before its triangle's plane a prism begins, relative to the distance from the eye. Measured off the plane: of
// a triangle that the light grazes, a step towards the light leads hardly off it, and the cap's depth would decide.
const BEFORE: f32 = 1e-3;

struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(flat, first) triangle: u32,
    // What decides most pixels, without a look into the buffers: they lie beside the line to the light.
    @location(1) @interpolate(flat, first) bc: vec4f,
    @location(2) @interpolate(flat, first) ca: vec4f,
    @location(3) @interpolate(flat, first) ab: vec4f,
    @location(4) @interpolate(flat, first) center: vec3f,
}

fn view_from_world(d: vec3f) -> vec3f {
    return vec3f(dot(masked.world_x.xyz, d), dot(masked.world_y.xyz, d), dot(masked.world_z.xyz, d));
}

fn world_from_view(d: vec3f) -> vec3f {
    return masked.world_x.xyz * d.x + masked.world_y.xyz * d.y + masked.world_z.xyz * d.z;
}

fn unit(d: vec3f) -> vec3f {
    return d * inverseSqrt(max(dot(d, d), 1e-37));
}

// A pixel's side at distance 1 (perspective) or anywhere (orthographic).
fn pixel_side() -> f32 {
    return 2.0 / (frame.clip_from_view[1][1] * frame.size_px.y);
}

// Where corner `v` moves so that the planes with unit normals `n` and `m`, pointing inwards, both move out by 1.
fn mitre(n: vec3f, m: vec3f) -> vec3f {
    let sum = n + m;
    let scale = 1.0 / max(1.0 + dot(n, m), 1e-7);
    let far = length(sum) * scale;
    return -sum * scale * min(1.0, LONGEST_MITRE / max(far, 1.0));
}

// How far along `away` the end plane lies from `v`.
fn beyond_plane(caster: MaskedCaster, v: vec3f, away: vec3f) -> f32 {
    return (caster.end_offset - dot(caster.end_normal, v)) / dot(caster.end_normal, away);
}

fn varyings(number: u32, t: MaskedTriangle, caster: MaskedCaster, clip: vec4f) -> Varyings {
    return Varyings(clip, number, t.bc, t.ca, t.ab, caster.center);
}

// The prism: a near cap, a far cap and three sides of two triangles each, facing outwards.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Varyings {
    let t = triangles[index / 24u];
    let caster = masked.casters[t.caster];
    let place = index % 24u;
    var corner = place % 3u;
    var is_far = false;
    if place >= 6u {
        // q, p, p∞ and q, p∞, q∞ of the edge from p to q.
        let p = (place - 6u) / 6u;
        let within = (place - 6u) % 6u;
        let is_p = within == 1u || within == 2u || within == 4u;
        corner = select((p + 1u) % 3u, p, is_p);
        is_far = within == 2u || within >= 4u;
    } else if place >= 3u {
        corner = (3u - corner) % 3u;
        is_far = true;
    }
    let bc = unit(t.bc.xyz);
    let ca = unit(t.ca.xyz);
    let ab = unit(t.ab.xyz);
    var v = t.a;
    var outwards = mitre(ca, ab);
    if corner == 1u {
        v = t.b;
        outwards = mitre(ab, bc);
    } else if corner == 2u {
        v = t.c;
        outwards = mitre(bc, ca);
    }
    // Enlarged by a share of a pixel where the vertex is.
    let margin = MARGIN_PX * pixel_side();
    let away = v * caster.light.w - caster.light.xyz;
    if is_far && caster.end_kind == 0u {
        let end = away + outwards * margin * length(away);
        return varyings(index / 24u, t, caster, frame.clip_from_view * vec4f(view_from_world(end), 0.0));
    }
    var from_eye = caster.center + v;
    let before = BEFORE * select(frame.view_from_clip[1][1], length(from_eye), frame.eye_w > 0.0);
    // Halfway to the light at most.
    let furthest = select(length(from_eye), 0.5, caster.light.w > 0.0);
    var stretch = -min(before / max(abs(dot(t.away, away)), 1e-30), furthest);
    if is_far {
        stretch = select(caster.end_scale, beyond_plane(caster, v, away), caster.end_kind == 1u);
    }
    from_eye += away * stretch;
    from_eye += outwards * (margin * select(1.0, length(from_eye), frame.eye_w > 0.0));
    if is_far && caster.end_kind == 1u {
        // Moved outwards it may have left the plane, and risen over receivers.
        from_eye += away * beyond_plane(caster, from_eye - caster.center, away);
    }
    return varyings(index / 24u, t, caster, frame.clip_from_view * vec4f(view_from_world(from_eye), 1.0));
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
fn darken(in: Varyings) -> @location(0) vec4f {
    let depth = textureLoad(receiver_depth, vec2u(in.clip.xy), 0);
    // Depth is reversed: 0 is infinitely far, where nothing is.
    if depth == 0.0 {
        discard;
    }
    let p_in_view = view_from_pixel(in.clip.xy, depth);
    let p = world_from_view(p_in_view);
    let q = p - in.center;
    let e = vec3f(
        dot(in.bc.xyz, q) + in.bc.w,
        dot(in.ca.xyz, q) + in.ca.w,
        dot(in.ab.xyz, q) + in.ab.w,
    );
    let sum = e.x + e.y + e.z;
    let passes = min(e.x, min(e.y, e.z)) >= 0.0 && sum > 0.0;
    if !(passes && is_blocked(in, p, depth, e / sum)) {
        discard;
    }
    return vec4f(0.0);
}

// Whether the triangle, whose corners have these weights where the line to the light passes it, blocks `p`.
fn is_blocked(in: Varyings, p: vec3f, depth: f32, weights: vec3f) -> bool {
    let t = triangles[in.triangle];
    let caster = masked.casters[t.caster];
    // The point must lie strictly behind the triangle, wherever within the uncertainty of its depth it is: else it may
    // lie on the triangle itself.
    let corner = caster.center + t.a;
    let height = dot(t.away, p - corner);
    let step = world_from_view(deeper(in.clip.xy, depth)) - p;
    let uncertain = abs(dot(t.away, step)) + ROUNDING * (length(p) + length(corner));
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
