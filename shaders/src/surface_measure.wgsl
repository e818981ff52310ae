// What is seen at every pixel: which triangle, for techniques, tests and reports; and its plane, for techniques.
// Vertices are pulled by index so that the triangle's number is known without any optional feature.

#import common/frame
#import common/positions
#if PLANES
#import common/triangle_plane
#endif
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
#if PLANES
    @location(4) @interpolate(flat, first) plane: vec4u,
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
#if PLANES
    let first = corner - corner % 3u;
    let a = local_position(indices[first]);
    let b = local_position(indices[first + 1u]);
    let c = local_position(indices[first + 2u]);
    var plane = triangle_plane(instance, a, b, c);
    let receives = (instances[instance].flags & 1u) != 0u;
    plane.near_m = select(0.0, plane.near_m, receives);
    plane.far_m = select(0.0, plane.far_m, receives);
    out.plane = packed_plane(plane);
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

#if PLANES
// Of a plane, for targets whose channels have 16 bits: low then high of its first two words, and of its last two.
struct PlaneHalves {
    @location(0) first: vec4u,
    @location(1) last: vec4u,
}

@fragment
fn plane_halves(in: Varyings) -> PlaneHalves {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    let low = in.plane & vec4u(0xffffu);
    let high = in.plane >> vec4u(16u);
    return PlaneHalves(vec4u(low.x, high.x, low.y, high.y), vec4u(low.z, high.z, low.w, high.w));
}

// Its plane, packed; 0 in the last word where the surface does not receive shadows.
@fragment
fn receiver_plane(in: Varyings) -> @location(0) vec4u {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    return in.plane;
}

struct TriangleAndPlane {
    @location(0) triangle: vec2u,
    @location(1) plane: vec4u,
}

@fragment
fn triangle_and_plane(in: Varyings) -> TriangleAndPlane {
#if MASKED
    if has_hole(in.uvs, in.alpha) {
        discard;
    }
#endif
    return TriangleAndPlane(vec2u(in.instance, in.triangle), in.plane);
}
#endif
