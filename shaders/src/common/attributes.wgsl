// What a mesh's vertices carry besides their positions, read by index.

#import common/material

// Eight words for each vertex: normal, first texture coordinates, colour (8 bits a channel), second coordinates.
@group(1) @binding(2) var<storage, read> attributes: array<u32>;

fn vertex_uvs(vertex: u32) -> Uvs {
    let at = vertex * 8u;
    let uv = bitcast<vec2f>(vec2u(attributes[at + 3u], attributes[at + 4u]));
#if SECOND_UV
    return vec4f(uv, bitcast<vec2f>(vec2u(attributes[at + 6u], attributes[at + 7u])));
#else
    return uv;
#endif
}

fn vertex_normal(vertex: u32) -> vec3f {
    let at = vertex * 8u;
    return bitcast<vec3f>(vec3u(attributes[at], attributes[at + 1u], attributes[at + 2u]));
}

fn vertex_color(vertex: u32) -> vec4f {
    return unpack4x8unorm(attributes[vertex * 8u + 5u]);
}

fn vertex_alpha(vertex: u32) -> f32 {
    return f32(attributes[vertex * 8u + 5u] >> 24u) / 255.0;
}
