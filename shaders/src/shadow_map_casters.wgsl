// Casters as a light sees them: their depth, and how it changes from texel to texel.

#if MASKED
#import common/alpha_mask

// A corner of a triangle that may have holes.
struct MapCorner {
    // From the middle of its caster, along the axes of the world.
    position: vec3f,
    // What the alpha of the texture is multiplied by.
    alpha: f32,
    uv: vec2f,
    // Holes are where alpha is below.
    cutoff: f32,
    // How alpha is read: see common/alpha_mask.
    reading: u32,
}

@group(1) @binding(2) var<storage, read> corners: array<MapCorner>;
#if BASE_COLOR_TEXTURE
@group(1) @binding(3) var image: texture_2d<f32>;
#endif
#else
#import common/positions
#endif

// One for each caster and view.
@group(1) @binding(1) var<storage, read> clip_from_caster: array<mat4x4f>;

struct Varyings {
    @builtin(position) clip: vec4f,
#if MASKED
    @location(0) uv: vec2f,
    @location(1) alpha: f32,
    @location(2) @interpolate(flat, first) cutoff: f32,
    @location(3) @interpolate(flat, first) reading: u32,
#endif
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, @builtin(instance_index) record: u32) -> Varyings {
    var out: Varyings;
#if MASKED
    let corner = corners[index];
    out.clip = clip_from_caster[record] * vec4f(corner.position, 1.0);
    out.uv = corner.uv;
    out.alpha = corner.alpha;
    out.cutoff = corner.cutoff;
    out.reading = corner.reading;
#else
    out.clip = clip_from_caster[record] * vec4f(local_position(index), 1.0);
#endif
    return out;
}

fn is_hole(in: Varyings) -> bool {
#if MASKED
    var alpha = in.alpha;
#if BASE_COLOR_TEXTURE
    alpha *= mask_alpha(image, in.uv, in.reading);
#endif
    return alpha < in.cutoff;
#else
    return false;
#endif
}

@fragment
fn slope(in: Varyings) -> @location(0) vec4f {
    let depth = in.clip.z;
    let change = vec2f(dpdx(depth), dpdy(depth));
    if is_hole(in) {
        discard;
    }
#if PERSPECTIVE
    return vec4f(change / max(depth, 1e-30), 0.0, 0.0);
#else
    return vec4f(change, 0.0, 0.0);
#endif
}

@fragment
fn holes(in: Varyings) {
    if is_hole(in) {
        discard;
    }
}
