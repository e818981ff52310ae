// What tests and reports compare: the visible triangle of every pixel, and the linear factor of one light there.
// Vertices are pulled by index so that the triangle's number is known without any optional feature.

#import common/frame
#import common/positions
#if MASKED
#import common/attributes
#endif

@group(1) @binding(1) var<storage, read> indices: array<u32>;

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) @interpolate(flat, first) instance: u32,
    @location(1) @interpolate(flat, first) triangle: u32,
#if MASKED
    @location(2) uvs: Uvs,
    @location(3) alpha: f32,
#endif
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let vertex = indices[corner];
    var out: Varyings;
    out.clip = clip_from_local(instance, local_position(vertex));
    out.instance = instance;
    out.triangle = corner / 3u;
#if MASKED
    out.uvs = vertex_uvs(vertex);
    out.alpha = vertex_alpha(vertex);
#endif
    return out;
}

@fragment
#if HALVES
// For targets whose channels have 16 bits: low then high.
fn visible_triangle(in: Varyings) -> @location(0) vec4u {
#else
fn visible_triangle(in: Varyings) -> @location(0) vec2u {
#endif
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
#if HALVES
    return vec4u(in.instance & 0xffffu, in.instance >> 16u, in.triangle & 0xffffu, in.triangle >> 16u);
#else
    return vec2u(in.instance, in.triangle);
#endif
}
