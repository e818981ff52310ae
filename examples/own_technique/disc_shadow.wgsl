// What flat round discs leave of a light, computed at every pixel: the visible point is rebuilt from its depth, and
// where the segment from it to the light passes through a disc, the light is blocked.

#import common/frame
#import common/fullscreen

// One caster, in view space.
struct Disc {
    center: vec3f,
    radius_m: f32,
    normal: vec3f,
    // How wide the rim fades from dark to lit, in the disc's plane; 0 for a hard rim.
    edge_m: f32,
}

struct Casters {
    // In view space: (position, 1), or (unit direction towards the light, 0).
    light: vec4f,
    discs: array<Disc>,
}

@group(1) @binding(0) var<storage, read> casters: Casters;
@group(1) @binding(1) var receiver_depth: texture_depth_2d;

// How far off the stored depth may be: 64 ulps of f32, the same allowance the measures make for rasterised depth.
const DEPTH_UNCERTAINTY: f32 = 7.62939453125e-6;

@fragment
fn visibility(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let depth = textureLoad(receiver_depth, vec2u(pixel.xy), 0);
    // Depth is reversed: 0 is infinitely far, where nothing is.
    if depth == 0.0 {
        return vec4f(1.0);
    }
    let p = view_from_pixel(pixel.xy, depth);
    // By how much p may be wrong, in metres. Perspective depth is wrong relative to itself, orthographic depth
    // relative to its range.
    let deeper = DEPTH_UNCERTAINTY * select(1.0, depth, frame.eye_w > 0.0);
    let uncertainty_m = distance(p, view_from_pixel(pixel.xy, depth + deeper));

    var visible = 1.0;
    for (var i = 0u; i < arrayLength(&casters.discs); i++) {
        visible *= past_disc(casters.discs[i], p, uncertainty_m);
    }
    return vec4f(visible);
}

// What `disc` lets through to `p`: 1, 0, or something between at a smooth rim.
fn past_disc(disc: Disc, p: vec3f, uncertainty_m: f32) -> f32 {
    // Everything relative to the disc's centre: there, where it matters, differences are small and precise.
    let from_center = p - disc.center;
    let height_m = dot(disc.normal, from_center);
    // A point of the disc itself lies in its plane only as precisely as it was rebuilt. On which side rounding put
    // it must not decide whether the disc shadows itself, so a point this near counts as on the plane, and a
    // surface does not block the light it faces. (From the light it turns away from, the engine darkens it.)
    if abs(height_m) <= uncertainty_m {
        return 1.0;
    }
    let towards_light = casters.light.xyz - p * casters.light.w;
    let climb = dot(disc.normal, towards_light);
    // The plane must be met strictly between p and the light; a light within the plane sees the disc edge-on.
    let t = -height_m / climb;
    if climb == 0.0 || t <= 0.0 || (t >= 1.0 && casters.light.w > 0.0) {
        return 1.0;
    }
    let beyond_rim_m = length(from_center + t * towards_light) - disc.radius_m;
    if disc.edge_m > 0.0 {
        return smoothstep(-0.5 * disc.edge_m, 0.5 * disc.edge_m, beyond_rim_m);
    }
    return select(1.0, 0.0, beyond_rim_m < 0.0);
}
