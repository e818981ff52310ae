// What every draw can see: the frame, the instances and the lights. Everything is in view space, whose origin is
// the eye, so that f32 keeps its precision where the picture needs it.
//
// No shader branches on uniforms alone, at places in them that are known when it is compiled: `select`, a flag, or a
// condition that something else takes part in. A driver that bakes such values into the shader (Mesa's software one
// does) compiles it again for every draw and keeps what it compiled: 10 ms and 2 MB a frame.

struct Frame {
    clip_from_view: mat4x4f,
    view_from_clip: mat4x4f,
    // Inaccurate far from the world's origin: positions are better transformed on the CPU.
    view_from_world: mat4x4f,
    size_px: vec2f,
    exposure: f32,
    light_count: u32,
    ambient: vec3f,
    tone_map: u32,
    up_in_view: vec3f,
    eye_w: f32,
    // Outside these pixels (first x and y, x and y after the last) every visibility counts as 1, whatever it holds.
    shadowed_px: vec4u,
}

// What the stencil holds where nothing is counted; more is dark. `STENCIL_AT_REST` of the plan.
const AT_REST: u32 = 32u;

// One mesh at its place. The rows are those of the affine map view_from_local.
struct Instance {
    row_x: vec4f,
    row_y: vec4f,
    row_z: vec4f,
    // Rows of the matrix that takes normals from local to view space (not normalised).
    normal_x: vec4f,
    normal_y: vec4f,
    normal_z: vec4f,
    // Bit 0: receives shadows. Bit 1: casts.
    flags: u32,
    // The first triangle of this instance in buffers that hold a value for every triangle of the frame.
    first_triangle: u32,
    // One bit for each light: whether the instance's terminator follows its shading normals.
    smooth_terminators: u32,
    pad_0: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> instances: array<Instance>;

fn view_from_local(instance: u32, p: vec3f) -> vec3f {
    let p1 = vec4f(p, 1.0);
    let i = instances[instance];
    return vec3f(dot(i.row_x, p1), dot(i.row_y, p1), dot(i.row_z, p1));
}

// The one function by which positions reach clip space. Depth tests for equality rely on every pass using it.
fn clip_from_local(instance: u32, p: vec3f) -> vec4f {
    return frame.clip_from_view * vec4f(view_from_local(instance, p), 1.0);
}

// A direction (no translation) from local to view space.
fn view_direction_from_local(instance: u32, d: vec3f) -> vec3f {
    let i = instances[instance];
    return vec3f(dot(i.row_x.xyz, d), dot(i.row_y.xyz, d), dot(i.row_z.xyz, d));
}

// Where a texel of the images of what is seen lies, in pixels; both as @builtin(position). With EACH_SAMPLE texel
// (2x + s % 2, 2y + s / 2) is sample s of pixel (x, y), at the standard place of four samples.
fn place_px(texel: vec2f) -> vec2f {
#if EACH_SAMPLE
    let pixel = floor(texel * 0.5);
    let s = floor(texel) - 2.0 * pixel;
    return pixel + vec2f(0.375 + 0.5 * s.x - 0.25 * s.y, 0.125 + 0.25 * s.x + 0.5 * s.y);
#else
    return texel;
#endif
}

// The point in view space that pixel `position` (as @builtin(position)) shows at `depth`.
fn view_from_pixel(position: vec2f, depth: f32) -> vec3f {
    let ndc = vec2f(position.x / frame.size_px.x * 2.0 - 1.0, 1.0 - position.y / frame.size_px.y * 2.0);
    let p = frame.view_from_clip * vec4f(ndc, depth, 1.0);
    return p.xyz / p.w;
}
