// The lights of the frame, in view space.

struct Light {
    // (position, 1), or (unit direction towards the light, 0).
    position: vec4f,
    // Linear colour times intensity.
    radiance: vec3f,
    // 1 / range in metres; 0 without a range.
    inverse_range: f32,
    // The unit direction in which a spot shines.
    direction: vec3f,
    // Spot falloff: saturate(cos(angle) * scale + offset), squared; (0, 1) for other lights.
    cone_scale: f32,
    cone_offset: f32,
    // Where its factor is: 0 always lit, 1 the stencil, 2 a bit of the mask, 3 a layer of the visibility array.
    factor_kind: u32,
    // The bit or the layer.
    factor_index: u32,
    // 1 where its factor holds the receiver's own shadow too: the terminator is where the factor says.
    own_shadow: u32,
}

// A uniform, not a storage buffer: software adapters read storage lane by lane. The larger array is as much as every
// adapter can bind.
#if MANY_LIGHTS
@group(0) @binding(2) var<uniform> lights: array<Light, 1024>;
#else
@group(0) @binding(2) var<uniform> lights: array<Light, 16>;
#endif

// Unit direction towards the light, and its irradiance on a surface facing it, at view-space point `p`.
struct Illumination {
    towards: vec3f,
    irradiance: vec3f,
}

fn illumination(light: Light, p: vec3f) -> Illumination {
    var to_light = light.position.xyz - p * light.position.w;
    let distance_squared = max(dot(to_light, to_light), 1e-12);
    to_light *= inverseSqrt(distance_squared);
    // The window KHR_lights_punctual recommends: smoothly zero at the range.
    let reach = distance_squared * light.inverse_range * light.inverse_range;
    let window = saturate(1.0 - reach * reach);
    let within_range = select(1.0, window * window, light.inverse_range > 0.0);
    let falloff = select(1.0, within_range / distance_squared, light.position.w > 0.0);
    let cone = saturate(dot(-to_light, light.direction) * light.cone_scale + light.cone_offset);
    return Illumination(to_light, light.radiance * falloff * cone * cone);
}
