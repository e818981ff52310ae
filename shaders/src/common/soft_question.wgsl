// The test whether a pixel sees the whole light, which most pixels pass. Every technique that uses `common/soft_light` draws it
// first, and so marks the pixels that need more.

#import common/soft_light
#import common/soft_lists

// What is known of a pixel before the receiver's frame is computed.
struct Question {
    r: Receiver,
    // Unit normal on the eye's side, and how high the light's centre is over the surface.
    n: vec3f,
    height: f32,
    // The same normal in view space, and the point found from plane and depth.
    normal: vec3f,
    at: OnPlane,
    // How much further up or down a sample may be.
    reach: f32,
#if CASTERS
    lists: Lists,
#endif
    // Whether all samples reach the surface, by what was asked so far.
    lit: bool,
}

fn question_at(position: vec2f) -> Question {
    var q: Question;
    let pixel = vec2u(position);
    let depth = textureLoad(receiver_depth, pixel, 0);
    let plane = unpacked_plane(textureLoad(receiver_planes, pixel, 0));
    // Depth is reversed: 0 is infinitely far, where nothing is.
    q.at = on_plane(plane, view_from_pixel(position, depth));
    q.r = receiver_at(position, depth, q.at.farther);
    q.normal = plane.normal;
    q.n = world_from_view(plane.normal);
    q.height = dot(q.n, q.r.w);
    q.reach = q.r.k * sqrt(max(1.0 - q.height * q.height, 0.0)) * 1.00001 + 1e-6;
    q.lit = q.height > q.reach && q.r.k > 0.0;
#if ON_LAYER
    // A transparent surface is lit from both sides: it has no horizon.
    q.height = 1.0;
    q.reach = 0.0;
    q.lit = true;
#endif
#if CASTERS
    q.lists = lists_of(q.r);
    let listed = q.lists.edges.first < q.lists.edges.end || q.lists.triangles.first < q.lists.triangles.end;
    let is_near = q.lists.near.first < q.lists.near.end || q.lists.clusters > 0u;
#if MASKS
    let is_masked = q.lists.masked.first < q.lists.masked.end;
#else
    let is_masked = false;
#endif
#if MASKS_ONLY
    // What lies beyond the horizon is another pass's business.
    q.lit = !is_masked;
#else
    q.lit = q.lit && !listed && !is_near && !is_masked;
#endif
#endif
    q.lit = q.lit || depth == 0.0 || plane.far_m == 0.0;
    return q;
}

// Marks the pixels whose samples are to be asked one by one, so that adapters skip the others as they skip what is hidden.
@fragment
fn mark(in: SoftVaryings) -> @builtin(frag_depth) f32 {
    take_light(in);
    if question_at(in.position.xy).lit {
        discard;
    }
    return 1.0;
}
