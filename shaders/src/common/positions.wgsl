// Vertex positions read by index, three floats each: for draws whose vertices are no vertices of a mesh.

@group(1) @binding(0) var<storage, read> positions: array<f32>;

fn local_position(vertex: u32) -> vec3f {
    let first = vertex * 3u;
    return vec3f(positions[first], positions[first + 1u], positions[first + 2u]);
}
