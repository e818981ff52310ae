// What tests and reports compare when several samples a pixel are drawn: a texel for every sample. Texel
// (2x + s % 2, 2y + s / 2) is sample s of pixel (x, y).

#import common/frame
#import common/fullscreen

// Instance and triangle of each sample, as halves: low then high.
@group(1) @binding(0) var triangle_halves: texture_multisampled_2d<u32>;
// The same, a texel for every sample.
@group(1) @binding(1) var triangles: texture_2d<u32>;
// The planes of each sample, as halves: low then high of the first two words, and of the last two.
@group(1) @binding(5) var plane_halves: texture_multisampled_2d<u32>;
@group(1) @binding(6) var plane_halves_more: texture_multisampled_2d<u32>;
// The depth of each sample.
@group(1) @binding(7) var depths: texture_depth_multisampled_2d;
// A bit for each triangle of the frame: the eye sees the side turned away from the light.
#if OWN_SHADOW
#else
@group(1) @binding(3) var<storage, read> turned_away: array<u32>;
#endif
#if COUNTS
@group(1) @binding(4) var counts: texture_multisampled_2d<u32>;
#endif
#if VISIBILITY
@group(1) @binding(4) var visibility: texture_2d_array<f32>;
#endif

// The number of the sample that a texel is of.
fn sample_of(texel: vec2u) -> u32 {
    return (texel.x & 1u) + (texel.y & 1u) * 2u;
}

@fragment
fn triangle(@builtin(position) position: vec4f) -> @location(0) vec2u {
    let texel = vec2u(position.xy);
    let halves = textureLoad(triangle_halves, texel / 2u, sample_of(texel));
    return vec2u(halves.x | (halves.y << 16u), halves.z | (halves.w << 16u));
}

@fragment
fn plane(@builtin(position) position: vec4f) -> @location(0) vec4u {
    let texel = vec2u(position.xy);
    let first = textureLoad(plane_halves, texel / 2u, sample_of(texel));
    let last = textureLoad(plane_halves_more, texel / 2u, sample_of(texel));
    return vec4u(first.xz, last.xz) | (vec4u(first.yw, last.yw) << vec4u(16u));
}

@fragment
fn depth(@builtin(position) position: vec4f) -> @builtin(frag_depth) f32 {
    let texel = vec2u(position.xy);
    return textureLoad(depths, texel / 2u, sample_of(texel));
}

#if COUNTS
// Darkness where a light that also has a visibility was counted as shadowed.
@fragment
fn darken(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = vec2u(position.xy);
    if textureLoad(counts, texel / 2u, sample_of(texel)).x <= AT_REST {
        discard;
    }
    return vec4f(0.0);
}
#endif

// As surface_factor has it, but for the one sample.
@fragment
fn factor(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let texel = vec2u(position.xy);
    let seen = textureLoad(triangles, texel, 0).xy;
    // The first bit of the instance's flags: it receives.
    if seen.x == 0xffffffffu || (instances[seen.x].flags & 1u) == 0u {
        return vec4f(1.0);
    }
#if OWN_SHADOW
#else
    let triangle = instances[seen.x].first_triangle + seen.y;
    if ((turned_away[triangle / 32u] >> (triangle % 32u)) & 1u) == 1u {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
#endif
#if COUNTS
    if textureLoad(counts, texel / 2u, sample_of(texel)).x > AT_REST {
        return vec4f(0.0, 0.0, 0.0, 1.0);
    }
#endif
#if VISIBILITY
    return vec4f(textureLoad(visibility, texel, 0, 0).rgb, 1.0);
#else
    return vec4f(1.0);
#endif
}
