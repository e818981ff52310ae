// What tests and reports compare when several samples a pixel are drawn: a texel for every sample. Texel
// (2x + s % 2, 2y + s / 2) is sample s of pixel (x, y).

#import common/frame
#import common/fullscreen

// Instance and triangle of each sample, as halves: low then high.
@group(1) @binding(0) var triangle_halves: texture_multisampled_2d<u32>;
// The same, a texel for every sample.
@group(1) @binding(1) var triangles: texture_2d<u32>;
// A bit for each triangle of the frame: the eye sees the side turned away from the light.
@group(1) @binding(3) var<storage, read> turned_away: array<u32>;
#if COUNTS
@group(1) @binding(4) var counts: texture_multisampled_2d<u32>;
#endif

@fragment
fn triangle(@builtin(position) position: vec4f) -> @location(0) vec2u {
    let texel = vec2u(position.xy);
    let halves = textureLoad(triangle_halves, texel / 2u, (texel.x & 1u) + (texel.y & 1u) * 2u);
    return vec2u(halves.x | (halves.y << 16u), halves.z | (halves.w << 16u));
}

// As surface_factor has it, but for the one sample.
@fragment
fn factor(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = vec2u(position.xy);
    let seen = textureLoad(triangles, texel, 0).xy;
    // The first bit of the instance's flags: it receives.
    if seen.x == 0xffffffffu || (instances[seen.x].flags & 1u) == 0u {
        return vec4f(1.0);
    }
    let triangle = instances[seen.x].first_triangle + seen.y;
    if ((turned_away[triangle / 32u] >> (triangle % 32u)) & 1u) == 1u {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
#if COUNTS
    if textureLoad(counts, texel / 2u, (texel.x & 1u) + (texel.y & 1u) * 2u).x > AT_REST {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
#endif
    return vec4f(1.0);
}
