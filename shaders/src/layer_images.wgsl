// Images of transparent layers: the factor of one light on one layer, and the picture with all layers blended in.

#import common/frame
#import common/fullscreen

// Instance and triangle of the layer at every pixel.
@group(1) @binding(0) var triangles: texture_2d<u32>;
#if COUNTS
@group(1) @binding(1) var counts: texture_2d<u32>;
#endif
#if VISIBILITY
@group(1) @binding(1) var visibility: texture_2d_array<f32>;
#endif

// What all layers were blended into.
@group(1) @binding(2) var picture: texture_2d<f32>;

// The factor on this layer: 1 lit, 0 dark; 1 where there is none.
@fragment
fn factor(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2u(position.xy);
    let seen = textureLoad(triangles, pixel, 0).x;
    if seen == 0xffffffffu || (instances[seen].flags & 1u) == 0u {
        return vec4f(1.0);
    }
    var result = vec3f(1.0);
#if COUNTS
    if textureLoad(counts, pixel, 0).x > AT_REST {
        result = vec3f(0.0);
    }
#endif
#if VISIBILITY
    result = textureLoad(visibility, pixel, 0, 0).rgb;
#endif
    return vec4f(result, 1.0);
}

// The target rounds it.
@fragment
fn rounded(@builtin(position) position: vec4f) -> @location(0) vec4f {
    return textureLoad(picture, vec2u(position.xy), 0);
}
