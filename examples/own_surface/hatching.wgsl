// A drawing in ink: where light comes is paper, where it does not are lines. They are where the surface cuts parallel
// planes of the world, so they follow its shape.

const PAPER = vec3f(0.80, 0.74, 0.62);
const INK = vec3f(0.045, 0.035, 0.06);
const LINES_PER_M = 26.0;

// How much ink is at `across` (whole numbers are the middles of lines) when lines cover this share of the paper.
fn line_ink(across: f32, share: f32) -> f32 {
    let width_px = fwidth(across);
    let off_middle = abs(fract(across + 0.5) - 0.5) * 2.0;
    let sharp = saturate((share - off_middle) / max(2.0 * width_px, 1e-4) + 0.5) * step(0.01, share);
    // Lines finer than pixels are their mean grey.
    return mix(sharp, share, smoothstep(0.35, 0.8, width_px));
}

// Which of the lines through world-space `p`, drawn by a hand that is not quite steady.
fn across_lines(p: vec3f, direction: vec3f) -> f32 {
    return dot(p, normalize(direction)) * LINES_PER_M + 0.12 * sin(p.x * 7.0 + p.z * 5.0) + 0.1 * sin(p.y * 11.0);
}

fn reflected(surface: Surface, light: LightArriving) -> vec3f {
    // The engine's factor picks the hatch: half-tones are the surface turning away, cross-hatching is cast shadow.
    let facing = saturate(dot(surface.normal_in_view, light.towards_in_view));
    let shadow = 1.0 - light.factor.g;
    let half_tone = 0.34 * (1.0 - smoothstep(0.05, 0.7, facing));
    let once = line_ink(across_lines(surface.p_in_world, vec3f(1.0, 1.5, 0.45)), max(half_tone, 0.46 * shadow));
    let crossed = line_ink(across_lines(surface.p_in_world, vec3f(-0.8, 1.1, 1.0)), 0.34 * shadow);
    let ink = 1.0 - (1.0 - once) * (1.0 - crossed);
    return mix(PAPER * surface.base_color.rgb, INK, ink);
}

fn outgoing(surface: Surface, lights: vec3f, ambient: vec3f, emitted: vec3f) -> vec3f {
    // The outline: where the surface turns out of sight.
    let turned = dot(surface.normal_in_view, surface.towards_eye_in_view);
    let outline = 1.0 - smoothstep(1.5, 3.0, turned / max(fwidth(turned), 1e-3));
    return mix(lights, INK, outline * (1.0 - smoothstep(0.3, 0.5, turned)));
}
