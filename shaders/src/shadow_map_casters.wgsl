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
#if CUT
// A corner of a piece of a triangle that is larger than the view.
struct CutCorner {
    clip: vec4f,
    // Of the plane that the triangle lies in: what depth changes by from texel to texel, and depth in the middle of the map.
    slope: vec2f,
    depth: f32,
    // From the middle of the map to its sides.
    half_texels: f32,
}

@group(1) @binding(4) var<storage, read> cut_corners: array<CutCorner>;
#else
#import common/positions
#endif
#endif

#if CUT
#else
// One for each caster and view.
@group(1) @binding(1) var<storage, read> clip_from_caster: array<mat4x4f>;
#endif

struct Varyings {
    @builtin(position) clip: vec4f,
#if MASKED
    @location(0) uv: vec2f,
    @location(1) alpha: f32,
    @location(2) @interpolate(flat, first) cutoff: f32,
    @location(3) @interpolate(flat, first) reading: u32,
#endif
#if CUT
    // Slope, depth in the middle, and half the texels along a side.
    @location(4) @interpolate(flat, first) plane: vec4f,
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
#if CUT
    let corner = cut_corners[index];
    out.clip = corner.clip;
    out.plane = vec4f(corner.slope, corner.depth, corner.half_texels);
#else
    out.clip = clip_from_caster[record] * vec4f(local_position(index), 1.0);
#endif
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

#if CUT
fn depth_on_plane(in: Varyings) -> f32 {
    return saturate(in.plane.z + dot(in.plane.xy, in.clip.xy - in.plane.w));
}

struct OfPiece {
    @location(0) slope: vec4f,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn slope_of_piece(in: Varyings) -> OfPiece {
    let depth = depth_on_plane(in);
#if PERSPECTIVE
    return OfPiece(vec4f(in.plane.xy / max(depth, 1e-30), 0.0, 0.0), depth);
#else
    return OfPiece(vec4f(in.plane.xy, 0.0, 0.0), depth);
#endif
}

@fragment
fn depth_of_piece(in: Varyings) -> @builtin(frag_depth) f32 {
    return depth_on_plane(in);
}
#endif
