// How far the depth of a visible surface may be off, and the point that it says with it.

#import common/frame

// How many ulps the receiver's depth may be off: below the 64 that measures allow for.
const DEPTH_ULPS: u32 = 48u;
// And an orthographic depth, which is a difference of two numbers up to 1 whatever its own size: twelve roundings of 1, below the
// sixteen that measures allow for.
const ORTHOGRAPHIC_LOSS: f32 = 7.152557e-7;
// A rasteriser evaluates depth as a plane over the target: it loses some roundings of the largest depth that this plane has
// there. So many times one's own it may be before more ulps than DEPTH_ULPS are lost.
const STEEPEST_DEPTH: f32 = 16.0;

// The visible point as much nearer to the horizon as its depth may be off, from the eye, in view space.
fn deeper(pixel: vec2f, depth: f32) -> vec3f {
    let ulps = min(DEPTH_ULPS, bitcast<u32>(depth) - 1u);
    let ulps_deeper = bitcast<f32>(bitcast<u32>(depth) - ulps);
    return view_from_pixel(pixel, select(depth - ORTHOGRAPHIC_LOSS, ulps_deeper, frame.eye_w > 0.0));
}

// How many times as much the depth of a surface with this normal (in view space) may be off at the point `p`.
fn depth_loss(p: vec3f, normal: vec3f) -> f32 {
    // The plane's depth is proportional to normal·d in the direction d = (x, y, −1): largest at a corner of the target.
    let widest = abs(normal.x / frame.clip_from_view[0].x) + abs(normal.y / frame.clip_from_view[1].y) + abs(normal.z);
    let here = abs(dot(normal, p) / p.z);
    let steepness = widest / max(here, 1e-37);
    return select(1.0, max(1.0, steepness / STEEPEST_DEPTH), frame.eye_w > 0.0);
}
