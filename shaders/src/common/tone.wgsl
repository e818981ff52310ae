// From radiance to what a picture shows.

// Khronos PBR Neutral: true colours up to 0.8, then a soft shoulder that desaturates.
fn tone_mapped(radiance: vec3f) -> vec3f {
    var color = radiance;
    let low = min(color.r, min(color.g, color.b));
    let offset = select(0.04, low - 6.25 * low * low, low < 0.08);
    color -= offset;
    let peak = max(color.r, max(color.g, color.b));
    let start = 0.76;
    if peak < start {
        return color;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    color *= new_peak / peak;
    let g = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(color, vec3f(new_peak), g);
}
