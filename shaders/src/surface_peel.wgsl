// The next layer of transparent surfaces: the nearest that lies behind the last layer and before the opaque surface.
// Of surfaces at one depth the first drawn is the nearer layer, so that every surface is a layer once.

#import common/frame
#import common/positions
#import common/attributes

@group(1) @binding(1) var<storage, read> indices: array<u32>;
@group(1) @binding(3) var opaque_depth: texture_depth_2d;
#if BEHIND
// Depth, instance and triangle of the last layer.
@group(1) @binding(4) var last_depth: texture_depth_2d;
@group(1) @binding(5) var last_triangles: texture_2d<u32>;
#endif

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) @interpolate(flat, first) triangle: vec2u,
    @location(1) uvs: Uvs,
    @location(2) alpha: f32,
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let vertex = indices[corner];
    var out: Varyings;
    out.clip = clip_from_local(instance, local_position(vertex));
    out.triangle = vec2u(instance, corner / 3u);
    out.uvs = vertex_uvs(vertex);
    out.alpha = vertex_alpha(vertex);
    return out;
}

@fragment
fn peel(in: Varyings) -> @location(0) vec2u {
    let pixel = vec2u(in.clip.xy);
    let depth = in.clip.z;
    var is_next = depth > textureLoad(opaque_depth, pixel, 0);
#if BEHIND
    let last = textureLoad(last_depth, pixel, 0);
    let last_triangle = textureLoad(last_triangles, pixel, 0).xy;
    let drawn_later = in.triangle.x > last_triangle.x
        || (in.triangle.x == last_triangle.x && in.triangle.y > last_triangle.y);
    is_next = is_next && (depth < last || (depth == last && drawn_later));
#endif
    if !is_next || !is_there(in.uvs, in.alpha) {
        discard;
    }
    return in.triangle;
}
