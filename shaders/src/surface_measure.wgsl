// What tests and reports compare: the visible triangle of every pixel, and the linear factor of one light there.
// Vertices are pulled by index so that the triangle's number is known without any optional feature.

#import common/frame
#import common/positions

@group(1) @binding(1) var<storage, read> indices: array<u32>;

struct Varyings {
    @builtin(position) @invariant clip: vec4f,
    @location(0) @interpolate(flat, first) instance: u32,
    @location(1) @interpolate(flat, first) triangle: u32,
}

@vertex
fn vertex(@builtin(vertex_index) corner: u32, @builtin(instance_index) instance: u32) -> Varyings {
    let clip = clip_from_local(instance, local_position(indices[corner]));
    return Varyings(clip, instance, corner / 3u);
}

@fragment
fn visible_triangle(in: Varyings) -> @location(0) vec2u {
    return vec2u(in.instance, in.triangle);
}
